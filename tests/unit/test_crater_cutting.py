"""Force, energy and depth of cutting as one statement, and what a contact resolved in time says of the crater."""

import dataclasses
import math
import re

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from bristle_sim.theory.crater_cutting import (
    crater_depth_from_contact,
    cutting_stroke,
    depth_from_energy,
    depth_from_force,
    swept_volume,
)
from bristle_sim.theory.crater_kinematics import TipFace
from bristle_sim.theory.merchant import oblique_angles, specific_cutting_energy

GAMMA = math.radians(23.4)
FACE = TipFace()
MASS = 8.387e-5 / 3.0
SPEED = 30.03


def width(depth):
    """Chord of the tip ellipse at a depth (4.9, 4.14); the wire's diameter beyond its centre line."""
    a_1, a_2 = 7.1e-4 / math.cos(math.radians(39.5)), 7.1e-4
    y = max(a_1 / 2 - depth / math.sin(math.radians(28.0)), 0.0)
    return a_2 * math.sqrt(max(1 - (2 * y / a_1) ** 2, 0.0))


def swept(path, gamma):
    """The volume by quadrature, split where the width stops growing."""
    full = min(path, FACE.full_depth / math.sin(gamma))
    parts = [(0.0, full), (full, path)]
    total = sum(
        quad(lambda s: width(s * math.sin(gamma)) * s / path**2, *part, epsabs=0.0, epsrel=1e-11)[0] for part in parts
    )
    return math.tan(gamma) * total * path**2


@pytest.mark.parametrize("gamma_deg", [1.0, 23.4, 60.0])
@pytest.mark.parametrize("path", [1e-7, 2e-4, 5.4e-4, 2e-3])
def test_swept_volume_is_the_integral(path, gamma_deg):
    gamma = math.radians(gamma_deg)
    # quad is requested to reach 1e-11; its integrand starts like s^(3/2).
    assert swept_volume(path, gamma) == pytest.approx(swept(path, gamma), rel=1e-8)


def test_swept_volume_in_closed_form():
    # With y = 1 - depth/D the integral of sqrt(1 - y^2) (1 - y) dy is elementary.
    path = 3e-4
    reach = FACE.full_depth / math.sin(GAMMA)
    y = 1 - path / reach
    area = 0.5 * (math.pi / 2 - math.asin(y) - y * math.sqrt(1 - y * y)) - (1 - y * y) ** 1.5 / 3
    # Differences of numbers of order 0.1: 1e-15.
    assert swept_volume(path) == pytest.approx(math.tan(GAMMA) * 7.1e-4 * reach**2 * area, rel=1e-12)


def test_specific_energy_is_the_cutting_force_per_chip_area():
    angles = oblique_angles(0.5, GAMMA)
    force = 1.3e-4 * 6.5e-4 * 1.2e8 / angles.cutting_ratio
    assert specific_cutting_energy(0.5) == pytest.approx(force / (1.3e-4 * 6.5e-4), rel=1e-14)


@pytest.mark.parametrize("mu", [0.1, 0.31, 0.5, 4.0])
@pytest.mark.parametrize("gamma_deg", [0.0, 23.4, 50.0])
def test_inclined_surface_is_the_least_work_over_all_shear_planes(mu, gamma_deg):
    gamma, upright = math.radians(gamma_deg), math.atan(1 / mu)
    eta = gamma + np.linspace(1e-3, math.pi / 2 - upright - 1e-3, 200_001)
    # Shear force R cos(eta + arccot(mu) - gamma) on a plane depth/sin(eta - gamma) long; F_c along the path.
    per_depth = 1.2e8 / (np.sin(eta - gamma) * np.cos(eta + upright - gamma)) * math.cos(upright - gamma)
    expected = per_depth.min() * math.cos(gamma)
    # The grid is 1e-5 rad fine: second order in it.
    assert specific_cutting_energy(mu, gamma, surface="inclined") == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("mu", [1e-6, 1e-5, 1e-4])
def test_little_friction_keeps_its_digits(mu):
    """At gamma = 0, u = 2 tau_s cos(arccot mu)/(1 - sin(arccot mu)) = 4 tau_s/mu (1 + mu^2/4 - ...)."""
    expected = 4.0 * 1.2e8 / mu * (1.0 + 0.25 * mu**2)
    # The angle beta - alpha = arccot(mu), close to pi/2, has the rounding 1e-16/mu in its cosine.
    assert specific_cutting_energy(mu, 0.0, surface="inclined") == pytest.approx(expected, rel=3e-16 / mu)


def test_both_surfaces_agree_when_the_path_runs_along_the_surface():
    assert specific_cutting_energy(0.5, 0.0) == pytest.approx(specific_cutting_energy(0.5, 0.0, surface="inclined"))


@pytest.mark.parametrize("depth", [1e-8, 3e-5, 1.3e-4, 2.1e-4, 6e-4])
@pytest.mark.parametrize("gamma_deg", [2.0, 23.4, 70.0])
def test_depths_invert_force_and_energy(depth, gamma_deg):
    gamma = math.radians(gamma_deg)
    u = 5e8
    force = u * width(depth) * depth / math.cos(gamma)
    assert depth_from_force(force, u, gamma) == pytest.approx(depth, rel=1e-9)
    energy = u * swept_volume(depth / math.sin(gamma), gamma)
    assert depth_from_energy(energy, u, gamma) == pytest.approx(depth, rel=1e-9)


def test_depths_broadcast_and_start_at_nothing():
    energies = np.array([0.0, 1e-6, 1e-3, 12.6e-3, 1.0])[:, None]
    gammas = np.radians([5.0, 23.4])
    depths = depth_from_energy(energies, 5e8, gammas)
    assert depths.shape == (5, 2)
    assert np.all(depths[0] == 0.0)
    assert np.all(np.diff(depths, axis=0) > 0.0)
    forces = depth_from_force(np.array([0.0, 1.0, 44.0, 1e4]), 5e8)
    assert forces[0] == 0.0
    assert np.all(np.diff(forces) > 0.0)


def stroke_by_integration(u):
    """The tip's motion integrated in time until it stops."""

    def slopes(_, state):
        path, speed = state
        return [speed, -u * width(path * math.sin(GAMMA)) * path * math.tan(GAMMA) / MASS]

    def stopped(_, state):
        return state[1]

    stopped.terminal = True
    run = solve_ivp(slopes, (0.0, 1e-3), [0.0, SPEED], events=stopped, rtol=1e-10, atol=1e-14)
    return run.t_events[0][0], run.y_events[0][0][0]


@pytest.mark.parametrize("surface", ["parallel", "inclined"])
def test_cutting_stroke_is_the_motion_it_says(surface):
    u = float(specific_cutting_energy(0.5, surface=surface))
    stroke = cutting_stroke(SPEED, MASS, u)
    duration, path = stroke_by_integration(u)
    # The integrator is requested to reach 1e-10 a step.
    assert stroke.path == pytest.approx(path, rel=1e-7)
    assert stroke.duration == pytest.approx(duration, rel=1e-7)
    # The resistance grows along the whole path, so the last force is the largest, and it gives the same depth.
    assert depth_from_force(stroke.peak_cutting_force, u) == pytest.approx(stroke.depth, rel=1e-9)


def contact(duration=2e-5, samples=20_001, mu=0.31):
    """A tip of mass m/3 on a straight path, stopped by a half sine along it; angles and friction as in the impact."""
    t = np.linspace(0.0, 2.0 * duration, samples)
    w = 0.5 * math.pi / duration
    speed, place, along = SPEED * np.cos(w * t), SPEED / w * np.sin(w * t), MASS * SPEED * w * np.sin(w * t)
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
    crater = crater_depth_from_contact(**contact(), shear_yield_stress=1.2e8)
    energy = 0.5 * MASS * SPEED**2
    # Trapezoids over 10001 samples of a quarter period: (pi/2/1e4)^2/12 = 2e-9.
    assert crater.compression_time == pytest.approx(2e-5, rel=1e-12)
    assert crater.peak_cutting_force == pytest.approx(MASS * SPEED * 0.5 * math.pi / 2e-5, rel=1e-8)
    # With the contact's own friction at its peak, 0.31; the depth goes like a root of the energy.
    deep = depth_from_energy(energy, specific_cutting_energy(0.31))
    assert crater.depth_from_energy == pytest.approx(deep, rel=1e-8)
    assert crater.path == pytest.approx(SPEED * 2e-5 / (math.pi / 2), rel=1e-8)
    assert crater.penetration == pytest.approx(crater.path * math.sin(GAMMA), rel=1e-8)
    # 0.31 < tan(gamma): the shear plane of (4.36) would stay under the surface.
    assert not crater.shear_plane_emerges
    assert crater_depth_from_contact(**contact(), friction=0.5).shear_plane_emerges
    assert crater_depth_from_contact(**contact(), surface="inclined").shear_plane_emerges


def test_depth_from_energy_does_not_depend_on_the_duration_and_the_depth_from_force_does():
    short, long = (crater_depth_from_contact(**contact(duration), friction=0.5) for duration in (5e-6, 5e-5))
    assert short.depth_from_energy == pytest.approx(long.depth_from_energy, rel=1e-8)
    assert short.peak_cutting_force == pytest.approx(10.0 * long.peak_cutting_force, rel=1e-8)
    assert short.depth_from_force > 2.0 * long.depth_from_force


def test_contact_as_stiff_as_the_chip_gives_one_depth():
    u = float(specific_cutting_energy(0.5))
    path = np.linspace(0.0, cutting_stroke(SPEED, MASS, u).path, 4001)
    along = u * np.array([width(s * math.sin(GAMMA)) for s in path]) * path * math.tan(GAMMA)
    left = SPEED**2 - 2.0 * u * swept_volume(path) / MASS
    speed = np.sqrt(np.maximum(left, 0.0))
    # Time only orders the samples here; the works are sums of force times path.
    time = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(path) / (speed[1:] + speed[:-1]))])
    normal = along / (math.sin(GAMMA) + 0.5 * math.cos(GAMMA))
    crater = crater_depth_from_contact(
        time, normal, -0.5 * normal, path * math.sin(GAMMA), -speed * math.sin(GAMMA), speed * math.cos(GAMMA)
    )
    # Trapezoids in time over 4000 equal steps of path, the last of which ends at rest: 1e-4.
    assert crater.depth_from_force == pytest.approx(path[-1] * math.sin(GAMMA), rel=1e-9)
    assert crater.depth_from_energy == pytest.approx(path[-1] * math.sin(GAMMA), rel=1e-4)


def test_the_measured_crater_lies_between_the_two_surfaces():
    energy = 0.5 * MASS * SPEED**2
    parallel, inclined = (
        depth_from_energy(energy, specific_cutting_energy(0.5, surface=each)) for each in ("parallel", "inclined")
    )
    # 130 um measured (Zhang 2020, fig. 4.13); nothing here was fitted to it.
    assert inclined < 130e-6 < parallel


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": [0.0]}, "rows of equal lengths"),
        ({"normal_force": np.full(20_001, math.nan)}, "normal_force = nan"),
        ({"time": np.zeros(20_001) - np.arange(20_001)}, "times that do not decrease"),
        ({"normal_force": np.zeros(20_001), "tangential_force": np.zeros(20_001)}, "normal_force = 0"),
        ({"friction": 0.0}, "friction = 0"),
        ({"impact_angle": 0.0}, "impact_angle = 0"),
        ({"surface": "curved"}, r"parallel \| inclined"),
    ],
)
def test_what_is_no_contact_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        crater_depth_from_contact(**(contact() | change))


ANGLE = 0.4


def three_samples(**changes: object) -> dict[str, object]:
    """A straight path at gamma in three samples, 1 us apart: the tip slows from 2 to 1 to 0 m/s under 10, 20, 30 N."""
    speed, normal = np.array([2.0, 1.0, 0.0]), np.array([10.0, 20.0, 30.0])
    rows = {
        "time": np.array([0.0, 1e-6, 2e-6]),
        "normal_force": normal,
        "tangential_force": -0.5 * normal,
        "penetration": np.array([0.0, 1e-6, 2e-6]),
        "normal_velocity": -math.sin(ANGLE) * speed,
        "tangential_velocity": math.cos(ANGLE) * speed,
    }
    return rows | {"impact_angle": ANGLE} | changes


class TestCraterFromContact:
    def test_the_clock_may_start_at_any_time(self) -> None:
        """Shifted by 2^-10 s times are still exact to 1e-19 s, 1e-13 of a microsecond."""
        now = crater_depth_from_contact(**three_samples())
        later = crater_depth_from_contact(**three_samples(time=np.array([0.0, 1e-6, 2e-6]) + 2.0**-10))
        assert dataclasses.astuple(later) == pytest.approx(dataclasses.astuple(now), rel=1e-12, abs=0.0)

    def test_friction_of_tan_gamma_itself_lets_the_shear_plane_out(self) -> None:
        """mu >= tan gamma (4.42)."""
        assert crater_depth_from_contact(**three_samples(), friction=math.tan(ANGLE)).shear_plane_emerges
        assert not crater_depth_from_contact(**three_samples(), friction=0.999 * math.tan(ANGLE)).shear_plane_emerges

    @pytest.mark.parametrize("penetration", [[3e-6, 2e-6, 1e-6], [2e-6, 3e-6, 1e-6]])
    def test_the_deepest_sample_ends_compression_but_two_are_needed(self, penetration: list[float]) -> None:
        crater = crater_depth_from_contact(**three_samples(penetration=penetration))
        assert crater.compression_time == 1e-6

    def test_two_samples_are_enough(self) -> None:
        rows = {name: np.asarray(value)[:2] for name, value in three_samples().items() if name != "impact_angle"}
        assert crater_depth_from_contact(**rows, impact_angle=ANGLE).compression_time == 1e-6

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"tangential_velocity": [1.0, 2.0]}, r"^time \(3,\), normal_force \(3,\), .*tangential_velocity \(2,\): "),
            ({"penetration": [[0.0, 1e-6, 2e-6]]}, r"^time \(3,\), .*penetration \(1, 3\), "),
            ({"time": [0.0, 2e-6, 1e-6]}, r"^time = 1e-06: .*decrease.* \(in s\)$"),
            ({"normal_force": [0.0, 0.0, -1.0]}, r"^normal_force = -1: .* \(in N\)$"),
        ],
    )
    def test_refusals_name_key_and_value(self, change: dict[str, object], said: str) -> None:
        with pytest.raises(ValueError, match=said):
            crater_depth_from_contact(**three_samples(**change))

    @pytest.mark.parametrize("shape", [(1,), (3, 1)])
    def test_one_row_of_two_samples_or_more(self, shape: tuple[int, ...]) -> None:
        rows = {name: np.ones(shape) for name in three_samples() if name != "impact_angle"}
        with pytest.raises(
            ValueError, match=re.escape(f"time {shape}, normal_force {shape}, tangential_force {shape}")
        ):
            crater_depth_from_contact(**rows)


REFUSALS = {
    "impact_angle = 1.570796": (
        lambda: swept_volume(1.0, 0.5 * math.pi),
        "0 < impact_angle < pi/2",
        "(in rad)",
    ),
    "path = -1": (lambda: swept_volume(-1.0), "0 <= path", "(in m)"),
    "energy = -1": (lambda: depth_from_energy(-1.0, 1.0), "0 <= energy", "(in J)"),
    "specific_energy = 0": (lambda: depth_from_energy(1.0, 0.0), "1e-60 <= specific_energy", "(in J/m^3)"),
    "specific_energy = -1": (lambda: depth_from_force(1.0, -1.0), "1e-60 <= specific_energy", "(in J/m^3)"),
    "cutting_force = -1": (lambda: depth_from_force(-1.0, 1.0), "0 <= cutting_force", "(in N)"),
    "speed = 0": (lambda: cutting_stroke(0.0, 1.0, 1.0), "1e-60 <= speed", "(in m/s)"),
    "effective_mass = 0": (lambda: cutting_stroke(1.0, 0.0, 1.0), "1e-60 <= effective_mass", "(in kg)"),
}
