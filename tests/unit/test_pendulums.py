"""Stronge's pendulums: the tables, the single pendulum's formula, and momentum, work and energy at random."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact, single_pendulum_impact, stick_friction

PAIR = {"angle_1": math.radians(20), "angle_2": math.radians(30), "rate_1": -0.1, "rate_2": -0.2}
RODS = {"rod_mass": 5.0, "rod_length": 1.0, "restitution": 0.5} | PAIR

# n, mu, phi'_1, phi'_2 after the impact, p_c, p_f: evaluated from Zhang 2020, eqs. 2.66-2.108, apart from this program.
TABLE = [
    (1, 0.0, -0.23050263, 0.29187510, 0.66465577, 0.99698365),
    (1, 0.3, -0.20819052, 0.24586736, 0.45772963, 0.70237711),
    (1, 0.5, -0.19893234, 0.22313679, 0.37905577, 0.59199844),
    (1, 0.7, -0.19260193, 0.20898534, 0.32345998, 0.51199185),
    (2, 0.5, -0.16850436, 0.19167816, 0.40948661, 0.65767170),
    (10, 0.5, -0.12013221, 0.14180543, 0.45902648, 0.79306389),
    (100, 0.5, -0.10226865, 0.12350185, 0.47717864, 0.85758897),
    (1e4, 0.5, -0.10002302, 0.12120826, 0.47943454, 0.86644492),
]


def random_pendulum(rng: np.random.Generator) -> dict[str, float]:
    """Any rods and rates, drawn until the tip approaches."""
    while True:
        drawn = {
            "rod_mass": 10.0 ** rng.uniform(-4, 2),
            "mass_ratio": 10.0 ** rng.uniform(-0.5, 4),
            "rod_length": 10.0 ** rng.uniform(-2, 1),
            "angle_1": rng.uniform(-1.5, 1.5),
            "angle_2": rng.uniform(-1.5, 1.5),
            "rate_1": rng.normal(),
            "rate_2": rng.normal(),
            "friction": rng.choice([0.0, rng.uniform(0, 0.5), rng.uniform(0, 3)]),
            "restitution": rng.uniform(0.05, 1),
        }
        if tip_velocity(drawn, drawn["rate_1"], drawn["rate_2"])[1] < -1e-3 * drawn["rod_length"]:
            return drawn


def tip_velocity(rods: dict[str, float], rate_1: float, rate_2: float) -> tuple[float, float]:
    """(2.68) from the geometry: the tip hangs at L (sin, -cos) of each angle below the hinge, mirrored in x."""
    length, first, second = rods["rod_length"], rods["angle_1"], rods["angle_2"]
    along = -length * (rate_1 * math.cos(first) + rate_2 * math.cos(second))
    return along, length * (rate_1 * math.sin(first) + rate_2 * math.sin(second))


def kinetic_energy(rods: dict[str, float], rate_1: float, rate_2: float) -> float:
    """Of the two rods by their centres' velocities and their inertias m L^2/12 (2.91)."""
    light, length = rods["rod_mass"], rods["rod_length"]
    heavy = rods["mass_ratio"] * light
    first, second = rods["angle_1"], rods["angle_2"]
    hinge = length * rate_1 * np.array([-math.cos(first), math.sin(first)])
    own = length * rate_2 * np.array([-math.cos(second), math.sin(second)])
    centres = heavy * np.sum((hinge / 2) ** 2) + light * np.sum((hinge + own / 2) ** 2)
    spins = (heavy * rate_1**2 + light * rate_2**2) * length**2 / 12
    return 0.5 * float(centres + spins)


def generalized_momenta(rods: dict[str, float], rate_1: float, rate_2: float) -> np.ndarray:
    """dT/d(phi') by differences of the quadratic T, which are exact up to rounding."""
    step = max(abs(rate_1), abs(rate_2), 1e-3)
    return np.array(
        [
            (kinetic_energy(rods, rate_1 + step, rate_2) - kinetic_energy(rods, rate_1 - step, rate_2)) / (2 * step),
            (kinetic_energy(rods, rate_1, rate_2 + step) - kinetic_energy(rods, rate_1, rate_2 - step)) / (2 * step),
        ]
    )


@pytest.mark.parametrize(("ratio", "mu", "rate_1", "rate_2", "p_c", "p_f"), TABLE)
def test_tabulated_impacts(ratio, mu, rate_1, rate_2, p_c, p_f):
    result = double_pendulum_impact(mass_ratio=ratio, friction=mu, **RODS)
    computed = (
        result.final_rate_1,
        result.final_rate_2,
        result.normal_compressive_impulse,
        result.normal_final_impulse,
    )
    # Eight decimals, some cut rather than rounded.
    assert computed == pytest.approx((rate_1, rate_2, p_c, p_f), rel=0, abs=1e-8)


def test_a_small_restitution_keeps_its_digits():
    """p_f = p_c + e* sqrt(2 W_c/(dv_n/dp)) in one slip, 50 digits: 0.379055774120665038... at e* = 1.93e-9.

    1 - (1 - e*^2) would leave none of the second term, 7e-10.
    """
    for restitution, expected in ((1.93e-9, 0.37905577412066503815), (0.0, 0.37905577338908739551)):
        result = double_pendulum_impact(mass_ratio=1, friction=0.5, **(RODS | {"restitution": restitution}))
        assert result.normal_final_impulse == pytest.approx(expected, rel=1e-13, abs=0.0)


def test_tabulated_phases():
    slips_back = ("compression slip", "restitution slip", "restitution reverse slip")
    sticks = ("compression slip", "restitution slip", "restitution stick")
    for mu, phases in ((0.3, slips_back), (0.5, slips_back), (0.7, sticks)):
        result = double_pendulum_impact(mass_ratio=1, friction=mu, **RODS)
        assert result.phases == phases
        assert result.normal_compressive_impulse < result.slip_stop_impulse < result.normal_final_impulse


def test_stick_friction_of_identical_rods():
    first, second = PAIR["angle_1"], PAIR["angle_2"]
    c = math.cos(first - second)
    above = math.sin(2 * first) + 4 * math.sin(2 * second) - 3 * math.sin(first + second) * c
    below = 2 * math.cos(first) ** 2 + 8 * math.cos(second) ** 2 - 6 * math.cos(first) * math.cos(second) * c
    # Six printed digits, then eq. 2.90 as printed.
    assert stick_friction(1, first, second) == pytest.approx(0.623401, abs=5e-7)
    assert stick_friction(1, first, second) == pytest.approx(above / below, rel=1e-14)


def test_stick_friction_parts_stick_from_reverse_slip():
    bar = stick_friction(1.0, PAIR["angle_1"], PAIR["angle_2"])
    for factor, ending in ((1 - 1e-9, "restitution reverse slip"), (1 + 1e-9, "restitution stick")):
        assert double_pendulum_impact(mass_ratio=1, friction=bar * factor, **RODS).phases[-1] == ending


def test_stick_friction_of_parallel_or_hub_like_rods_is_that_of_the_monofilament():
    """tan gamma (2.111): for parallel rods whatever n, for any first rod as n grows."""
    angle = math.radians(23.4)
    np.testing.assert_allclose(stick_friction(10.0 ** np.arange(-1, 6), angle, angle), math.tan(angle), rtol=1e-13)
    heavy = 10.0 ** np.arange(3, 8)
    gap = np.abs(stick_friction(heavy, 0.1, angle) - math.tan(angle))
    # Of order 1/n.
    np.testing.assert_allclose(gap * heavy, gap[-1] * heavy[-1], rtol=5e-3)


def test_heavy_first_rod_behaves_as_a_hub():
    """As n grows the rates tend to those of the monofilament with r_h = L, the error being of order 1/n (fig. 2.30)."""
    angle, mass, length, hub, rate = math.radians(23.4), 8.387e-5, 0.027, 261.8, 845.6
    limit = monofilament_impact(mass, length, length, hub, rate / hub, angle, 0.31, 0.42)
    # Printed 2.4932581e-3.
    assert limit.normal_final_impulse == pytest.approx(2.4932581e-3, rel=2e-8)
    ratios, gaps = 10.0 ** np.arange(2, 7), []
    for ratio in ratios:
        rods = double_pendulum_impact(mass, ratio, length, angle, angle, -hub, -rate, 0.31, 0.42)
        gaps.append((rods.normal_final_impulse / limit.normal_final_impulse - 1, rods.final_rate_1 / -hub - 1))
        assert rods.final_rate_2 == pytest.approx(-limit.final_bristle_rate, rel=10 / ratio)
    # First order in 1/n, with a relative second-order term of 1/n.
    scaled = np.array(gaps) * ratios[:, np.newaxis]
    np.testing.assert_allclose(scaled[1:], np.broadcast_to(scaled[-1], scaled[1:].shape), rtol=5e-3)


def test_figure_2_30_at_the_operating_friction():
    angle = math.radians(23.4)
    result = double_pendulum_impact(8.387e-5, 700, 0.027, angle, angle, -261.8, -845.6, 0.31, 0.42)
    # Eight printed digits.
    assert result.normal_final_impulse == pytest.approx(2.4923689e-3, rel=2e-8)


def test_momentum_work_and_energy_at_random():
    """Any solution must satisfy these, however found: see the comments."""
    rng = np.random.default_rng(3)
    for _ in range(300):
        rods = random_pendulum(rng)
        result = double_pendulum_impact(**rods)
        before, after = (rods["rate_1"], rods["rate_2"]), (result.final_rate_1, result.final_rate_2)
        # The impulse that the change of the generalized momenta needs, J^T p = dP (2.69), has the normal part p_f.
        lever = rods["rod_length"] * np.array(
            [
                [math.sin(rods["angle_1"]), -math.cos(rods["angle_1"])],
                [math.sin(rods["angle_2"]), -math.cos(rods["angle_2"])],
            ]
        )
        change = generalized_momenta(rods, *after) - generalized_momenta(rods, *before)
        impulse = np.linalg.solve(lever, change)
        # The two rods' momenta tell the components apart by sin(theta_1 - theta_2) and carry n times more than p.
        scale = np.max(np.abs(generalized_momenta(rods, *before))) / rods["rod_length"] + result.normal_final_impulse
        lost = 1e-13 * scale / abs(math.sin(rods["angle_1"] - rods["angle_2"]))
        assert abs(impulse[0] - result.normal_final_impulse) < lost
        assert abs(impulse[1]) <= rods["friction"] * result.normal_final_impulse + lost

        energies = kinetic_energy(rods, *before), kinetic_energy(rods, *after)
        assert result.kinetic_energy_ratio == pytest.approx(energies[1] / energies[0], rel=1e-12)
        assert result.kinetic_energy_ratio <= 1 + 1e-12
        assert tip_velocity(rods, *after)[1] > -1e-9 * rods["rod_length"]


def test_frictionless_impact_is_newtons():
    """Without friction the three coefficients are one: v_y after = -e* v_y before, p_f = (1 + e*) p_c, energy by v_y^2."""
    rng = np.random.default_rng(4)
    for _ in range(100):
        rods = random_pendulum(rng) | {"friction": 0.0}
        result = double_pendulum_impact(**rods)
        start = tip_velocity(rods, rods["rate_1"], rods["rate_2"])[1]
        end = tip_velocity(rods, result.final_rate_1, result.final_rate_2)[1]
        # The tip's speed is a sum of rates some hundred times larger where the first rod is heavy.
        assert end == pytest.approx(-rods["restitution"] * start, rel=1e-9)
        assert result.normal_final_impulse == pytest.approx(
            (1 + rods["restitution"]) * result.normal_compressive_impulse, rel=1e-12
        )
        lost = kinetic_energy(rods, rods["rate_1"], rods["rate_2"]) * (1 - result.kinetic_energy_ratio)
        taken = 0.5 * (1 - rods["restitution"] ** 2) * -start * result.normal_compressive_impulse
        # The loss is a difference of energies up to a thousand times larger.
        assert lost == pytest.approx(taken, rel=1e-6, abs=1e-13 * kinetic_energy(rods, rods["rate_1"], rods["rate_2"]))


def test_rates_scale_and_mirror():
    plain = double_pendulum_impact(mass_ratio=3, friction=0.4, **RODS)
    faster = double_pendulum_impact(mass_ratio=3, friction=0.4, **(RODS | {"rate_1": -0.4, "rate_2": -0.8}))
    mirrored = RODS | {key: -PAIR[key] for key in PAIR}
    other = double_pendulum_impact(mass_ratio=3, friction=0.4, **mirrored)
    # Powers of two and signs are exact.
    assert faster.final_rate_2 == 4 * plain.final_rate_2
    assert faster.normal_final_impulse == 4 * plain.normal_final_impulse
    assert (other.final_rate_1, other.final_rate_2) == (-plain.final_rate_1, -plain.final_rate_2)
    assert other.phases == plain.phases


def test_tip_that_does_not_approach_is_left_alone():
    result = double_pendulum_impact(mass_ratio=1, friction=0.3, **(RODS | {"rate_1": 0.1, "rate_2": 0.2}))
    assert result.outcome == "no contact"
    assert (result.final_rate_1, result.final_rate_2, result.normal_final_impulse) == (0.1, 0.2, 0.0)
    resting = double_pendulum_impact(mass_ratio=1, friction=0.3, **(RODS | {"rate_1": 0.0, "rate_2": 0.0}))
    assert (resting.outcome, resting.kinetic_energy_ratio) == ("no contact", 1.0)


def test_parallel_rods_are_stuck_beyond_tan_theta():
    angle = math.radians(25)
    parallel = RODS | {"angle_1": angle, "angle_2": angle, "mass_ratio": 4}
    stuck = double_pendulum_impact(friction=math.tan(angle) * 1.001, **parallel)
    assert stuck.outcome == "stiction"
    assert stuck.normal_final_impulse == stuck.normal_compressive_impulse == stuck.slip_stop_impulse
    free = double_pendulum_impact(friction=math.tan(angle) * 0.999, **parallel)
    assert free.outcome == "rebound"


def test_edges_of_the_ranges_give_finite_numbers():
    """Right angles, parallel and nearly parallel rods, speeds and coefficients at the ends of what floats hold."""
    quarter = math.pi / 2
    outcomes = set()
    for first in (-quarter, 0.0, 0.4, quarter):
        for second in (first, first * (1 - 1e-9), 0.3, -quarter):
            for friction in (0.0, 0.5, 1e9):
                for restitution in (0.0, 1e-170, 1.0):
                    for rate in (-1.0, -1e-160):
                        angles = {"angle_1": first, "angle_2": second, "rate_1": rate, "rate_2": 2 * rate}
                        result = double_pendulum_impact(
                            2.0, 5.0, 0.3, **angles, friction=friction, restitution=restitution
                        )
                        outcomes.add(result.outcome)
                        impulses = (result.normal_compressive_impulse, result.normal_final_impulse)
                        numbers = (*impulses, result.final_rate_1, result.final_rate_2, result.kinetic_energy_ratio)
                        assert all(math.isfinite(number) for number in numbers)
    assert {"no contact", "rebound", "no rebound", "stiction"} <= outcomes


def test_no_rebound_without_restitution():
    result = double_pendulum_impact(mass_ratio=1, friction=0.3, **(RODS | {"restitution": 0.0}))
    assert result.outcome == "no rebound"
    assert result.normal_final_impulse == result.normal_compressive_impulse
    along, away = tip_velocity(RODS, result.final_rate_1, result.final_rate_2)
    assert away == pytest.approx(0.0, abs=1e-16)
    assert along > 0.0


def test_single_pendulum_is_the_monofilament_on_a_point():
    """r_h = 0 (2.4.1), for any friction on either side of tan gamma."""
    angles = np.radians([5.0, 23.4, 60.0, 90.0])
    for angle in angles:
        for mu in (0.0, 0.05, 0.31, 0.8, 3.0):
            single = single_pendulum_impact(0.2, 0.5, angle, -3.0, mu, 0.42)
            mono = monofilament_impact(0.2, 0.5, 0.0, 3.0, 1.0, angle, mu, 0.42)
            assert single.outcome == mono.outcome_name
            assert single.rebound_ratio == pytest.approx(mono.rebound_ratio, rel=1e-13, abs=1e-300)
            assert single.normal_compressive_impulse == pytest.approx(mono.normal_compressive_impulse, rel=1e-14)
            assert single.normal_final_impulse == pytest.approx(mono.normal_final_impulse, rel=1e-13)


def test_single_pendulum_formula():
    """-e* sqrt((1 - mu cot gamma)/(1 + mu cot gamma)) with numbers that make it rational: mu cot gamma = 3/5 gives 1/2."""
    angle = math.atan(0.5)
    result = single_pendulum_impact(1.0, 1.0, angle, -2.0, 0.3, 0.5)
    assert result.rebound_ratio == pytest.approx(-0.25, rel=1e-15)
    assert result.final_rate == pytest.approx(0.5, rel=1e-15)
    # p_c = m L |phi'|/(3 (sin gamma + mu cos gamma)) with sin gamma = 1/sqrt 5.
    assert result.normal_compressive_impulse == pytest.approx(2 * math.sqrt(5) / (3 * 1.6), rel=1e-15)
    # p_f = p_c (1 + e* sqrt(s_1/s_2)) = p_c (1 + e* 2).
    assert result.normal_final_impulse == pytest.approx(2 * result.normal_compressive_impulse, rel=1e-15)


def test_single_pendulum_that_does_not_approach():
    for rate in (0.0, 0.5):
        result = single_pendulum_impact(1.0, 1.0, 0.4, rate, 0.3, 0.5)
        assert (result.outcome, result.final_rate) == ("no contact", rate)
        assert (result.normal_compressive_impulse, result.normal_final_impulse) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("rod_mass", 0.0),
        ("mass_ratio", -1.0),
        ("rod_length", math.nan),
        ("angle_1", 2.0),
        ("angle_2", -2.0),
        ("rate_1", math.inf),
        ("rate_2", math.nan),
        ("friction", -0.1),
        ("restitution", 1.5),
        ("restitution_friction", -1.0),
    ],
)
def test_bad_input_is_named_in_one_line(name, value):
    arguments = {"mass_ratio": 1.0, "friction": 0.3, "restitution_friction": 0.2} | RODS | {name: value}
    with pytest.raises(ValueError, match=f"^{name} = ") as refusal:
        double_pendulum_impact(**arguments)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("angle", [0.0, -0.1, 1.6])
def test_single_pendulum_needs_an_inclination(angle):
    with pytest.raises(ValueError, match=r"^impact_angle = .*rad"):
        single_pendulum_impact(1.0, 1.0, angle, -1.0, 0.3, 0.5)


def holds_exactly(gamma: float) -> bool:
    """Whether tan gamma cos gamma is sin gamma in floats too."""
    return math.sin(gamma) - math.sin(gamma) / math.cos(gamma) * math.cos(gamma) == 0.0


class TestEdges:
    def test_an_elastic_rod_without_friction_is_thrown_back(self) -> None:
        """e* = 1, mu = 0: the rate is reversed, and the impulse twice that of compression, m L w/(3 sin gamma)."""
        result = single_pendulum_impact(3.0, 0.5, 0.6, -2.0, 0.0, 1.0)
        assert (result.outcome, result.rebound_ratio, result.final_rate) == ("rebound", -1.0, 2.0)
        assert result.normal_compressive_impulse == pytest.approx(1.0 / math.sin(0.6), rel=1e-14)
        assert result.normal_final_impulse == pytest.approx(2.0 / math.sin(0.6), rel=1e-14)

    @pytest.mark.parametrize(
        ("friction", "restitution", "outcome"),
        [(0.1, 0.0, "no rebound"), (9.0, 0.0, "no rebound"), (9.0, 0.5, "stiction")],
    )
    def test_why_a_rod_stays(self, friction: float, restitution: float, outcome: str) -> None:
        """Without restitution nothing drives the rod back; with it, friction above tan gamma holds it."""
        result = single_pendulum_impact(3.0, 0.5, 0.6, -2.0, friction, restitution)
        assert (result.outcome, result.final_rate, result.rebound_ratio) == (outcome, 0.0, 0.0)

    def test_friction_of_tan_gamma_itself_holds_the_rod(self) -> None:
        """No rebound for mu >= tan gamma: cos gamma = 0.8 and sin gamma = 0.6 = 0.75 cos gamma, where floats agree."""
        exact = [gamma for gamma in np.linspace(0.2, 1.2, 41).tolist() if holds_exactly(gamma)]
        assert exact, "some angle whose sine is the float product of tangent and cosine"
        for gamma in exact:
            result = single_pendulum_impact(1.0, 1.0, gamma, -1.0, math.sin(gamma) / math.cos(gamma), 0.5)
            assert result.outcome == "stiction"

    def test_a_rod_that_swings_away_keeps_its_rate(self) -> None:
        result = single_pendulum_impact(3.0, 0.5, 0.6, 2.0, 0.3, 0.5)
        assert (result.outcome, result.final_rate, result.rebound_ratio) == ("no contact", 2.0, 1.0)

    @pytest.mark.parametrize("apart", [0.0, 1e-10, -1e-10, 5e-9])
    def test_rods_parallel_up_to_rounding_are_held_by_friction(self, apart: float) -> None:
        """Their tip moves along one line, so above tan theta no impulse parts it: energy lost is all but a drift."""
        result = double_pendulum_impact(1.0, 2.0, 1.0, 0.4, 0.4 + apart, -1.0, -2.0, 1.5 * math.tan(0.4), 0.5)
        assert result.outcome == "stiction"
        # All the tip's approach is stopped by m_eff v/(sin + mu cos); restitution adds nothing to that.
        assert result.normal_final_impulse == pytest.approx(result.normal_compressive_impulse, rel=1e-6)

    def test_friction_of_the_threshold_itself_sticks(self) -> None:
        """Zhang 2020, eq. 2.90: mu >= mu_bar sticks."""
        threshold = float(stick_friction(1.0, 0.35, 0.52))
        result = double_pendulum_impact(5.0, 1.0, 1.0, 0.35, 0.52, -0.1, -0.2, threshold, 0.5)
        assert result.phases[-1] == "restitution stick"

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_slip_of_a_billionth_is_slip(self, side: float) -> None:
        """Two rods at 0.35 and 0.52 whose tip slips by 1e-9 of their speed: p_s = |v_t|/|v_t'|, v_t' by the mass matrix."""
        angles, friction = side * np.array([0.35, 0.52]), 0.1
        rates = side * np.array([1.0, -(math.cos(0.35) + 1e-9) / math.cos(0.52)])
        result = double_pendulum_impact(1.0, 1.0, 1.0, *angles.tolist(), *rates.tolist(), friction, 0.5)
        along, away, c = -np.cos(angles), np.sin(angles), 0.5 * math.cos(0.17)
        change = along @ np.linalg.inv([[4.0 / 3.0, c], [c, 1.0 / 3.0]]) @ (away - side * friction * along)
        assert float(along @ rates) * change < 0.0, "the slip does stop"
        assert result.phases[0] == "compression slip"
        # A difference of numbers of order 1 is 1e-9: seven digits are left.
        assert result.slip_stop_impulse == pytest.approx(1e-9 / abs(change), rel=1e-6, abs=0.0)

    def test_no_slip_has_stopped_at_once(self) -> None:
        """Rods at 0.5 and -0.5 with opposite rates come straight down: p_s = 0."""
        result = double_pendulum_impact(1.0, 1.0, 1.0, 0.5, -0.5, -1.0, 1.0, 0.9, 0.5)
        assert result.slip_stop_impulse == 0.0
        assert result.phases == ("compression stick", "restitution stick")
