"""Force, energy and depth of cutting as one statement, and what a contact resolved in time says of the crater."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from bristle_sim.theory.crater_cutting import (
    crater_depth_from_contact,
    depth_from_energy,
    depth_from_force,
    swept_volume,
)
from bristle_sim.theory.crater_kinematics import TipFace
from bristle_sim.theory.merchant import specific_cutting_energy

GAMMA = math.radians(23.4)
FACE = TipFace()
MASS = 8.387e-5 / 3.0
SPEED = 30.03


def width(depth):
    """Chord of the tip ellipse at a depth (4.9, 4.14); the wire's diameter beyond its centre line."""
    a_1 = 7.1e-4 / math.cos(math.radians(39.5))
    a_2 = 7.1e-4
    y = max(a_1 / 2 - depth / math.sin(math.radians(28.0)), 0.0)
    return a_2 * math.sqrt(max(1 - (2 * y / a_1) ** 2, 0.0))


def swept(path, gamma):
    """The volume by quadrature, split where the width stops growing."""
    full = min(path, FACE.full_depth / math.sin(gamma))
    parts = [(0.0, full), (full, path)]
    total = sum(
        quad(lambda s: width(s * math.sin(gamma)) * s / path**2, *part, epsabs=0.0, epsrel=1e-11)[0]
        for part in parts
    )
    return math.tan(gamma) * total * path**2


@pytest.mark.parametrize("gamma_deg", [1.0, 23.4, 60.0])
@pytest.mark.parametrize("path", [1e-7, 2e-4, 5.4e-4, 2e-3])
def test_swept_volume_is_the_integral(path, gamma_deg):
    gamma = math.radians(gamma_deg)
    # quad is requested to reach 1e-11; its integrand starts like s^(3/2).
    assert swept_volume(path, gamma) == pytest.approx(swept(path, gamma), rel=1e-8)


@pytest.mark.parametrize("mu", [0.1, 0.31, 0.5, 4.0])
@pytest.mark.parametrize("gamma_deg", [0.0, 23.4, 50.0])
def test_inclined_surface_is_the_least_work_over_all_shear_planes(mu, gamma_deg):
    gamma = math.radians(gamma_deg)
    upright = math.atan(1 / mu)
    eta = gamma + np.linspace(1e-3, math.pi / 2 - upright - 1e-3, 200_001)
    # Shear force R cos(eta + arccot(mu) - gamma) on a plane depth/sin(eta - gamma) long; F_c along the path.
    per_depth = (
        1.2e8 / (np.sin(eta - gamma) * np.cos(eta + upright - gamma)) * math.cos(upright - gamma)
    )
    expected = per_depth.min() * math.cos(gamma)
    # The grid is 1e-5 rad fine: second order in it.
    assert specific_cutting_energy(mu, gamma, surface="inclined") == pytest.approx(
        expected, rel=1e-6
    )


@pytest.mark.parametrize("mu", [1e-6, 1e-5, 1e-4])
def test_little_friction_keeps_its_digits(mu):
    """At gamma = 0, u = 2 tau_s cos(arccot mu)/(1 - sin(arccot mu)) = 4 tau_s/mu (1 + mu^2/4 - ...)."""
    expected = 4.0 * 1.2e8 / mu * (1.0 + 0.25 * mu**2)
    # The angle beta - alpha = arccot(mu), close to pi/2, has the rounding 1e-16/mu in its cosine.
    assert specific_cutting_energy(mu, 0.0, surface="inclined") == pytest.approx(
        expected, rel=3e-16 / mu
    )


@pytest.mark.parametrize("depth", [1e-8, 3e-5, 1.3e-4, 2.1e-4, 6e-4])
@pytest.mark.parametrize("gamma_deg", [2.0, 23.4, 70.0])
def test_depths_invert_force_and_energy(depth, gamma_deg):
    gamma = math.radians(gamma_deg)
    u = 5e8
    force = u * width(depth) * depth / math.cos(gamma)
    assert depth_from_force(force, u, gamma) == pytest.approx(depth, rel=1e-9)
    energy = u * swept_volume(depth / math.sin(gamma), gamma)
    assert depth_from_energy(energy, u, gamma) == pytest.approx(depth, rel=1e-9)


def contact(duration=2e-5, samples=20_001, mu=0.31):
    """A tip of mass m/3 on a straight path, stopped by a half sine along it; angles and friction as in the impact."""
    t = np.linspace(0.0, 2.0 * duration, samples)
    w = 0.5 * math.pi / duration
    speed = SPEED * np.cos(w * t)
    place = SPEED / w * np.sin(w * t)
    along = MASS * SPEED * w * np.sin(w * t)
    normal = along / (math.sin(GAMMA) + mu * math.cos(GAMMA))
    return {
        "time": t,
        "normal_force": normal,
        "tangential_force": -mu * normal,
        "penetration": place * math.sin(GAMMA),
        "normal_velocity": -speed * math.sin(GAMMA),
        "tangential_velocity": speed * math.cos(GAMMA),
    }


def test_a_contact_adds_up():
    """With its own friction at the peak, 0.31 < tan(gamma), the shear plane of (4.36) would stay under the surface."""
    crater = crater_depth_from_contact(**contact(), shear_yield_stress=1.2e8)
    # Trapezoids over 10001 samples of a quarter period: (pi/2/1e4)^2/12 = 2e-9.
    assert crater.compression_time == pytest.approx(2e-5, rel=1e-12)
    assert crater.peak_cutting_force == pytest.approx(MASS * SPEED * 0.5 * math.pi / 2e-5, rel=1e-8)
    deep = depth_from_energy(0.5 * MASS * SPEED**2, specific_cutting_energy(0.31))
    assert crater.depth_from_energy == pytest.approx(deep, rel=1e-8)
    assert crater.penetration == pytest.approx(
        SPEED * 2e-5 / (math.pi / 2) * math.sin(GAMMA), rel=1e-8
    )
    assert not crater.shear_plane_emerges
    assert crater_depth_from_contact(**contact(), friction=0.5).shear_plane_emerges
    assert crater_depth_from_contact(**contact(), surface="inclined").shear_plane_emerges


def test_the_measured_crater_lies_between_the_two_surfaces():
    energy = 0.5 * MASS * SPEED**2
    parallel, inclined = (
        depth_from_energy(energy, specific_cutting_energy(0.5, surface=each))
        for each in ("parallel", "inclined")
    )
    # 130 um measured (Zhang 2020, fig. 4.13); nothing here was fitted to it.
    assert inclined < 130e-6 < parallel


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"normal_force": -1.0 - np.arange(20_001)}, r"^normal_force = -.* \(in N\)$"),
        (
            {"normal_force": np.zeros(20_001), "tangential_force": np.zeros(20_001)},
            "normal_force = 0",
        ),
    ],
)
def test_what_is_no_contact_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        crater_depth_from_contact(**(contact() | change))


@pytest.mark.parametrize("penetration", [[3e-6, 2e-6, 1e-6], [2e-6, 3e-6, 1e-6]])
def test_the_deepest_sample_ends_compression_but_two_are_needed(penetration: list[float]) -> None:
    rows = contact(samples=3) | {"penetration": penetration}
    assert crater_depth_from_contact(**rows).compression_time == rows["time"][1]
