"""Cutting and craters: what other tests let pass. Expected values from the formulas' definition, similarity or by hand."""

import dataclasses
import math
import re
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Tool
from bristle_sim.theory import crater_cutting, merchant
from bristle_sim.theory.crater import friction_for_crater_depth, merchant_crater_depth
from bristle_sim.theory.crater_contact import crater_depth_from_contact
from bristle_sim.theory.crater_energy import (
    energy_coefficients,
    energy_crater_depth,
    energy_crater_depth_ratio,
    path_force,
)
from bristle_sim.theory.crater_kinematics import PRINTED_WIDTH, CraterKinematics, CuttingWidth, TipFace
from bristle_sim.theory.force_history import BRISTLE

GAMMA = 0.4
TWICE = dataclasses.replace(TipFace(), wire_diameter=2.0 * TipFace().wire_diameter)
"""The face of a wire twice as thick: all its lengths are doubled."""


class TestMerchant:
    def test_the_constant_of_the_shear_angle_reaches_every_circle(self) -> None:
        """eta = (C - (beta - alpha))/2 (4.45) with C = 0.9: beta - alpha is arctan mu - alpha or arccot mu - gamma."""
        assert merchant.shear_angle(0.1, 0.9) == pytest.approx(0.4, rel=1e-15)
        classical = merchant.orthogonal_angles(0.2, 0.5, 0.9)
        assert classical.shear == pytest.approx(0.5 * (0.9 - math.atan(0.5) + 0.2), rel=1e-14)
        oblique = merchant.oblique_angles(2.0, 0.2, constant=0.9)
        assert oblique.shear == pytest.approx(0.5 * (0.9 - math.atan(0.5) + 0.2), rel=1e-14)

    @pytest.mark.parametrize(("gamma", "least"), [(0.5, 1.0 / math.tan(0.4)), (0.9, math.inf), (1.0, math.inf)])
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([[0.01, value]])])
    def test_least_friction_of_an_oblique_cut(self, gamma: float, least: float, lengthen: Callable) -> None:
        """eta >= gamma with C = 0.9 is arccot mu <= C - gamma: mu >= cot(C - gamma), never for gamma >= C."""
        with pytest.raises(
            merchant.ShearAngleError, match=re.escape(f"friction = 2: friction >= cot(C - impact_angle) = {least:g} ")
        ):
            merchant.oblique_angles(2.0, lengthen(gamma), constant=0.9)


class TestCuttingByAnotherFace:
    """All lengths doubled: forces are 4 times, volumes and energies 8 times as large."""

    def test_volume_and_depths(self) -> None:
        volume = crater_cutting.swept_volume(3e-4, GAMMA)
        assert crater_cutting.swept_volume(6e-4, GAMMA, TWICE) == pytest.approx(8.0 * volume, rel=1e-13, abs=0.0)
        for depth_from, factor in ((crater_cutting.depth_from_energy, 8.0), (crater_cutting.depth_from_force, 4.0)):
            depth = depth_from(1e-2, 5e8, GAMMA)
            # Newton's method ends at 1e-14 of the root.
            assert depth_from(factor * 1e-2, 5e8, GAMMA, TWICE) == pytest.approx(2.0 * depth, rel=1e-12, abs=0.0)

    def test_stroke_of_eight_times_the_mass(self) -> None:
        small = crater_cutting.cutting_stroke(30.0, 3e-5, 5e8, GAMMA)
        large = crater_cutting.cutting_stroke(30.0, 24e-5, 5e8, GAMMA, TWICE)
        expected = (2.0 * small.depth, 2.0 * small.path, 2.0 * small.duration, 4.0 * small.peak_cutting_force)
        # The duration's integrand is a difference that keeps ten digits near the end of the path.
        assert dataclasses.astuple(large) == pytest.approx(expected, rel=1e-9, abs=0.0)


def contact(**changes: object) -> dict[str, object]:
    """A straight path at gamma in three samples, 1 us apart: the tip slows from 2 to 1 to 0 m/s under 10, 20, 30 N."""
    speed, normal = np.array([2.0, 1.0, 0.0]), np.array([10.0, 20.0, 30.0])
    rows = {
        "time": np.array([0.0, 1e-6, 2e-6]),
        "normal_force": normal,
        "tangential_force": -0.5 * normal,
        "penetration": np.array([0.0, 1e-6, 2e-6]),
        "normal_velocity": -math.sin(GAMMA) * speed,
        "tangential_velocity": math.cos(GAMMA) * speed,
    }
    return rows | {"impact_angle": GAMMA} | changes


class TestCraterFromContact:
    def test_the_clock_may_start_at_any_time(self) -> None:
        """Shifted by 2^-10 s times are still exact to 1e-19 s, 1e-13 of a microsecond."""
        now = crater_depth_from_contact(**contact())
        later = crater_depth_from_contact(**contact(time=np.array([0.0, 1e-6, 2e-6]) + 2.0**-10))
        assert dataclasses.astuple(later) == pytest.approx(dataclasses.astuple(now), rel=1e-12, abs=0.0)

    def test_a_face_twice_as_large(self) -> None:
        """Four times the force at twice the speed is eight times the energy: depths are doubled."""
        now = crater_depth_from_contact(**contact())
        larger = {name: 4.0 * contact()[name] for name in ("normal_force", "tangential_force")}
        larger |= {name: 2.0 * contact()[name] for name in ("normal_velocity", "tangential_velocity")}
        twice = crater_depth_from_contact(**contact(**larger), face=TWICE)
        assert twice.depth_from_force == pytest.approx(2.0 * now.depth_from_force, rel=1e-12, abs=0.0)
        assert twice.depth_from_energy == pytest.approx(2.0 * now.depth_from_energy, rel=1e-12, abs=0.0)

    def test_friction_of_tan_gamma_itself_lets_the_shear_plane_out(self) -> None:
        """mu >= tan gamma (4.42)."""
        assert crater_depth_from_contact(**contact(), friction=math.tan(GAMMA)).shear_plane_emerges
        assert not crater_depth_from_contact(**contact(), friction=0.999 * math.tan(GAMMA)).shear_plane_emerges

    @pytest.mark.parametrize("penetration", [[3e-6, 2e-6, 1e-6], [2e-6, 3e-6, 1e-6]])
    def test_the_deepest_sample_ends_compression_but_two_are_needed(self, penetration: list[float]) -> None:
        """The trapezium of the first microsecond: 10 and 20 N normal, half of that along the surface."""
        crater = crater_depth_from_contact(**contact(penetration=penetration))
        assert crater.compression_time == 1e-6
        assert crater.path_impulse == pytest.approx(
            15e-6 * (math.sin(GAMMA) + 0.5 * math.cos(GAMMA)), rel=1e-14, abs=0.0
        )

    def test_two_samples_are_enough(self) -> None:
        rows = {name: np.asarray(value)[:2] for name, value in contact().items() if name != "impact_angle"}
        assert crater_depth_from_contact(**rows, impact_angle=GAMMA).compression_time == 1e-6

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"tangential_velocity": [1.0, 2.0]}, r"^time \(3,\), normal_force \(3,\), .*tangential_velocity \(2,\): "),
            ({"penetration": [[0.0, 1e-6, 2e-6]]}, r"^time \(3,\), .*penetration \(1, 3\), "),
            ({"time": [0.0, 2e-6, 1e-6]}, r"^time = 1e-06: .*decrease.* \(in s\)$"),
            ({"normal_velocity": [0.0, math.nan, 0.0]}, r"^normal_velocity = nan: .* \(in SI units\)$"),
            ({"normal_force": [0.0, 0.0, -1.0]}, r"^normal_force = -1: .* \(in N\)$"),
        ],
    )
    def test_refusals_name_key_and_value(self, change: dict[str, object], said: str) -> None:
        with pytest.raises(ValueError, match=said):
            crater_depth_from_contact(**contact(**change))

    @pytest.mark.parametrize("shape", [(1,), (3, 1)])
    def test_one_row_of_two_samples_or_more(self, shape: tuple[int, ...]) -> None:
        rows = {name: np.ones(shape) for name in contact() if name != "impact_angle"}
        with pytest.raises(
            ValueError, match=re.escape(f"time {shape}, normal_force {shape}, tangential_force {shape}")
        ):
            crater_depth_from_contact(**rows)


class TestMotionAndWidth:
    def test_depths_of_a_tools_own_excursion(self) -> None:
        """delta = c_1 sin gamma (4.8); its trace on a face at the angle given is delta over that angle's sine (4.10)."""
        motion = CraterKinematics.of_tool(Tool(), 800.0, excursion=2e-4, impact_angle=GAMMA, face_angle=0.5)
        assert motion.excursion == 2e-4
        assert motion.depth == pytest.approx(2e-4 * math.sin(GAMMA), rel=1e-14, abs=0.0)
        assert motion.face_depth == pytest.approx(2e-4 * math.sin(GAMMA) / math.sin(0.5), rel=1e-14, abs=0.0)
        usual = CraterKinematics.of_tool(Tool(), 800.0)
        assert usual.face_depth == pytest.approx(usual.depth / math.sin(math.radians(28.0)), rel=1e-14, abs=0.0)

    def test_above_the_surface_nothing_is_cut(self) -> None:
        assert TipFace().width([-1e-3, -1e-9, 0.0]).tolist() == [0.0, 0.0, 0.0]

    def test_width_of_a_face_that_dives_to_its_centre_line_and_no_deeper(self) -> None:
        """With swing = h the width tends to 2 h; slow decays are allowed: b(t) = 2 sqrt(h^2 - h^2 e^2), e = e^(-t/2)."""
        width = CuttingWidth(1e-3, 1e-3, 0.5)
        assert width(2.0) == pytest.approx(2e-3 * math.sqrt(1.0 - math.exp(-2.0)), rel=1e-14, abs=0.0)
        for swing, decay in ((0.0, 1.0), (1.001e-3, 1.0), (5e-4, 0.0)):
            with pytest.raises(
                ValueError, match=r"^swing, half_width, decay = .*0 < swing <= half_width.*\(in m, m, 1/s\)$"
            ):
                CuttingWidth(1e-3, swing, decay)

    def test_width_of_a_face_in_its_own_motion(self) -> None:
        motion = dataclasses.replace(CraterKinematics(), decay=5e4)
        assert CuttingWidth.of_face(TipFace(), motion).decay == 5e4


class TestWorkAndEnergy:
    def test_another_bristle(self) -> None:
        """Twice the mass: twice the energy and twice the force (m/3) lambda v_C."""
        heavy = dataclasses.replace(Bristle(), mass=2.0 * Bristle().mass)
        assert energy_coefficients(bristle=heavy) == pytest.approx(
            [2.0 * each for each in energy_coefficients()], rel=1e-14
        )
        motion = CraterKinematics()
        force = heavy.mass / 3.0 * motion.decay * motion.tip_speed * math.exp(-1.0)
        assert path_force(1.0 / motion.decay, motion, heavy) == pytest.approx(force, rel=1e-14)

    def test_one_ply_by_hand(self) -> None:
        """cos gamma (E(0) - E(t_c))/R(t_c) with E = 3 e^-2x + 2 e^-x + 1, x = decay t_c = 1: both sums are one quotient."""
        lost = 3.0 * (1.0 - math.exp(-2.0)) + 2.0 * (1.0 - math.exp(-1.0))
        expected = math.cos(GAMMA) * lost / BRISTLE(5e-5)
        for depth in (energy_crater_depth, energy_crater_depth_ratio):
            found = depth(1, GAMMA, coefficients=(3.0, 2.0, 1.0), decay=2e4, compression_time=5e-5)
            assert found == pytest.approx(expected, rel=1e-14)

    def test_plies_are_those_of_print(self) -> None:
        """n = 300 (Zhang 2020, below eq. 4.56)."""
        assert energy_crater_depth_ratio() == energy_crater_depth_ratio(300)
        assert energy_crater_depth() == energy_crater_depth(300)


class TestFrictionForDepth:
    @pytest.mark.parametrize("gamma", [0.1, 0.4, 0.7])
    def test_least_friction_is_tan_gamma(self, gamma: float) -> None:
        """Friction of tan gamma is given back (as the root of a difference: half of the digits), less is refused."""
        depth = merchant_crater_depth(math.tan(gamma), gamma)
        assert friction_for_crater_depth(depth, gamma) == pytest.approx(math.tan(gamma), rel=1e-7)
        with pytest.raises(ValueError, match=r"^depth = .*friction >= tan\(impact_angle\).*\(in m\)$"):
            friction_for_crater_depth(depth * (1.0 - 1e-6), gamma)

    def test_no_friction_gives_the_depth_of_infinite_friction(self) -> None:
        """At gamma = 0 one ply gives [1 - sin(arccot mu)]/2 of (R(t_c) - R(0))/(b(t_c) tau_s): half of it at infinity."""
        whole = 1.0 / 1.2e8 * float((BRISTLE(5e-5) - BRISTLE(0.0)) / PRINTED_WIDTH(5e-5))
        with pytest.raises(ValueError, match=r"^depth = "):
            friction_for_crater_depth(0.5 * whole, 0.0, plies=1)
        # 1 - 2 share = sin(arccot mu) = 1/sqrt(1 + mu^2): by hand 0.6 for mu = 4/3.
        assert friction_for_crater_depth(0.2 * whole, 0.0, plies=1) == pytest.approx(4.0 / 3.0, rel=1e-13)


REFUSALS = {
    "constant = 0": (lambda: merchant.shear_angle(-0.1, 0.0), "0 < C <= pi/2", "(in rad)"),
    "resultant_angle = 0.5": (lambda: merchant.shear_angle(0.5, 0.5), "beta - alpha < C", "(in rad)"),
    "slope = -1": (lambda: merchant.shear_constant(-1.0), "slope >= 0", "(dimensionless)"),
    "rake = 1.5708": (lambda: merchant.orthogonal_angles(0.5 * math.pi, 0.5), "-pi/2 < rake < pi/2", "(in rad)"),
    "friction = -1": (lambda: merchant.orthogonal_angles(0.1, -1.0), "friction >= 0", "(dimensionless)"),
    "friction = 0": (lambda: merchant.oblique_angles(0.0, 0.1), "friction > 0", "(dimensionless)"),
    "impact_angle = 1.5708": (
        lambda: merchant.oblique_angles(0.5, 0.5 * math.pi),
        "0 <= impact_angle < pi/2",
        "(in rad)",
    ),
    "impact_angle = 1.570796": (
        lambda: crater_cutting.swept_volume(1.0, 0.5 * math.pi),
        "0 < impact_angle < pi/2",
        "(in rad)",
    ),
    "path = -1": (lambda: crater_cutting.swept_volume(-1.0), "path >= 0", "(in m)"),
    "energy = -1": (lambda: crater_cutting.depth_from_energy(-1.0, 1.0), "energy >= 0", "(in J)"),
    "specific_energy = 0": (lambda: crater_cutting.depth_from_energy(1.0, 0.0), "specific_energy > 0", "(in J/m^3)"),
    "specific_energy = -1": (lambda: crater_cutting.depth_from_force(1.0, -1.0), "specific_energy > 0", "(in J/m^3)"),
    "cutting_force = -1": (lambda: crater_cutting.depth_from_force(-1.0, 1.0), "cutting_force >= 0", "(in N)"),
    "speed = 0": (lambda: crater_cutting.cutting_stroke(0.0, 1.0, 1.0), "speed > 0", "(in m/s)"),
    "effective_mass = 0": (lambda: crater_cutting.cutting_stroke(1.0, 0.0, 1.0), "effective_mass > 0", "(in kg)"),
    "shear_yield_stress = -1": (lambda: crater_cutting.specific_cutting_energy(0.5, GAMMA, -1.0), "> 0", "(in Pa)"),
    "shear_yield_stress = 0": (lambda: merchant_crater_depth(shear_yield_stress=0.0), "> 0", "(in Pa)"),
    "impact_angle = nan": (
        lambda: merchant_crater_depth(0.5, math.nan, angles=merchant.PRINTED_ANGLES),
        "",
        "(in rad)",
    ),
}


@pytest.mark.parametrize("start", REFUSALS)
def test_refusals_name_key_value_range_and_unit(start: str) -> None:
    """Values are compared as numbers: a message may write them with more or fewer digits."""
    call, allowed, unit = REFUSALS[start]
    name, _, value = start.partition(" = ")
    with pytest.raises(ValueError, match=rf"^{name} = \S+: ") as refusal:
        call()
    shown = re.match(rf"{name} = (\S+): ", str(refusal.value))[1]
    assert float(shown) == pytest.approx(float(value), rel=1e-5, nan_ok=True)
    assert allowed in str(refusal.value)
    assert str(refusal.value).endswith(unit)
