"""Properties that the impact laws must have, and their edges by hand."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bristle_sim.theory.impact import LAWS as BY_NAME
from bristle_sim.theory.impact import (
    OUTCOMES,
    PHASES,
    Impact,
    energetic_impact,
    newton_impact,
    poisson_impact,
)

LAWS = list(BY_NAME.values())
every_law = pytest.mark.parametrize("law", LAWS)
MIRROR = np.array([[1.0, -1.0], [-1.0, 1.0]])


def inverse_mass(normal, correlation, tangential):
    """K with K_nt = correlation sqrt(K_nn K_tt), |correlation| <= 1."""
    coupling = correlation * np.sqrt(np.multiply(normal, tangential))
    rows = [
        np.stack(np.broadcast_arrays(*row), axis=-1)
        for row in ((normal, coupling), (coupling, tangential))
    ]
    return np.stack(rows, axis=-2)


def random_impacts(seed: int, size: int, reach: float = 0.999) -> dict[str, np.ndarray]:
    """Approaching contacts of all kinds: one in ten each without slip, friction, coupling, or restitution, or elastic."""
    rng = np.random.default_rng(seed)

    def sometimes(value: float, otherwise: np.ndarray) -> np.ndarray:
        return np.where(rng.random(size) < 0.1, value, otherwise)

    velocity = rng.normal(size=(size, 2))
    velocity[:, 0] = -np.abs(velocity[:, 0])
    velocity[:, 1] = sometimes(0.0, velocity[:, 1])
    correlation = sometimes(0.0, rng.uniform(-reach, reach, size))
    return {
        "inverse_mass": inverse_mass(
            10.0 ** rng.uniform(-1, 1, size), correlation, 10.0 ** rng.uniform(-1, 1, size)
        ),
        "velocity": velocity,
        "friction": sometimes(0.0, rng.exponential(0.5, size)),
        "restitution": sometimes(0.0, sometimes(1.0, rng.uniform(0, 1, size))),
    }


def with_other_friction(impacts: dict[str, np.ndarray], seed: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return impacts | {"restitution_friction": rng.exponential(0.5, impacts["friction"].shape)}


def kinetic_energy(matrix: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Energy that the contact can exchange, v^T K^-1 v/2."""
    return 0.5 * np.einsum("...i,...ij,...j", velocity, np.linalg.inv(matrix), velocity)


def final_velocity(result: Impact) -> np.ndarray:
    return np.stack([result.velocity_normal, result.velocity_tangential], axis=-1)


def total_impulse(result: Impact) -> np.ndarray:
    return np.stack([result.impulse_normal, result.impulse_tangential], axis=-1)


def assert_same(one: Impact, other: Impact, rtol: float) -> None:
    for each in dataclasses.fields(Impact):
        np.testing.assert_allclose(
            getattr(one, each.name), getattr(other, each.name), rtol=rtol, atol=0
        )


# Every law


@every_law
@pytest.mark.parametrize("same_friction", [True, False])
def test_momentum_friction_cone_and_phases(law, same_friction):
    impacts = random_impacts(1, 20_000)
    impacts = impacts if same_friction else with_other_friction(impacts, 2)
    result = law(**impacts)
    start = impacts["velocity"]
    end = final_velocity(result)
    impulse = total_impulse(result)
    matrix = impacts["inverse_mass"]

    # dv = K p, up to roundings of the terms, which are some ten times the result.
    moved = np.einsum("kij,kj->ki", matrix, impulse)
    terms = np.abs(start).sum(-1) + np.einsum("kij,kj->k", np.abs(matrix), np.abs(impulse))
    assert np.all(np.abs(end - start - moved) < 1e-13 * terms[:, None])

    largest = np.maximum(impacts["friction"], impacts.get("restitution_friction", 0.0))
    assert np.all(np.abs(impulse[:, 1]) <= largest * impulse[:, 0] * (1 + 1e-12))
    assert np.all(result.impulse_normal > 0.0)
    assert np.all(result.velocity_normal >= 0.0)
    # No contact of two degrees of freedom jams.
    assert set(np.unique(result.outcome)) <= {
        OUTCOMES.index("rebound"),
        OUTCOMES.index("no rebound"),
    }

    assert np.all(result.phase_impulse >= 0.0)
    np.testing.assert_allclose(result.phase_impulse.sum(-1), result.impulse_normal, rtol=1e-14)
    np.testing.assert_allclose(
        result.phase_impulse[:, :2].sum(-1), result.compressive_impulse_normal, rtol=1e-14
    )
    # Friction never drives, compression takes from the normal motion and restitution gives.
    assert np.all(result.phase_work_tangential <= 1e-15 * terms[:, None] * impulse[:, :1])
    assert np.all(result.phase_work_normal[:, :2] <= 0.0)
    assert np.all(result.phase_work_normal[:, 2:] >= 0.0)


@every_law
def test_works_add_up_to_the_energy(law):
    impacts = with_other_friction(random_impacts(3, 20_000, reach=0.99), 4)
    result = law(**impacts)
    before = kinetic_energy(impacts["inverse_mass"], impacts["velocity"])
    after = kinetic_energy(impacts["inverse_mass"], final_velocity(result))
    # K^-1 has a condition of at most 1e4 here.
    np.testing.assert_allclose(
        result.energy_change, after - before, rtol=1e-11, atol=1e-11 * before.max()
    )


@every_law
def test_each_phase_moves_as_it_says(law):
    """Rebuild the velocities phase by phase from impulse, slip and friction; slip must not turn within a phase."""
    impacts = with_other_friction(random_impacts(5, 20_000), 6)
    result = law(**impacts)
    matrix = impacts["inverse_mass"]
    velocity = impacts["velocity"]
    slip_after = []
    for index in range(len(PHASES)):
        impulse = result.phase_impulse[:, index]
        slip = result.phase_slip[:, index]
        mu = impacts["friction" if index < 2 else "restitution_friction"]
        ratio = np.where(slip == 0.0, -matrix[:, 0, 1] / matrix[:, 1, 1], -mu * slip)
        # Slip at rest takes as much friction as holds v_n.
        resting = (
            (index == 2) & (result.phase_work_normal[:, 2] == 0.0) & (slip != 0.0) & (impulse > 0.0)
        )
        ratio = np.where(resting, -matrix[:, 0, 0] / np.where(resting, matrix[:, 0, 1], 1.0), ratio)
        step = np.stack([impulse, ratio * impulse], axis=-1)
        scale = np.abs(velocity).max() + np.einsum("kij,kj->k", np.abs(matrix), np.abs(step))
        velocity = velocity + np.einsum("kij,kj->ki", matrix, step)
        # Slip is along its direction at the end too, stick is none; a rounding of the terms.
        assert np.all(velocity[:, 1] * slip > -1e-12 * scale)
        assert np.all(np.abs(velocity[(slip == 0.0) & (impulse > 0.0), 1]) < 1e-12 * scale.max())
        slip_after.append(velocity[:, 1])
    np.testing.assert_allclose(velocity, final_velocity(result), atol=1e-12 * scale.max())
    check_slip_stop(
        result, impacts["velocity"][:, 1], np.stack(slip_after, axis=-1), 1e-12 * scale.max()
    )


def check_slip_stop(
    result: Impact, initial: np.ndarray, slip_after: np.ndarray, small: float
) -> None:
    """p_s is where the slip velocity first vanishes: at the start, after a phase in which it slips as it began, or never."""
    slips = (
        (initial != 0.0)[:, None]
        & (result.phase_slip == np.sign(initial)[:, None])
        & (result.phase_impulse > 0.0)
    )
    as_begun = np.logical_and.accumulate(slips | (result.phase_impulse == 0.0), axis=-1)
    reached = np.cumsum(result.phase_impulse, axis=-1)
    lasts = np.isinf(result.slip_stop_impulse)
    assert np.all(as_begun[lasts, -1])
    assert np.all(slip_after[lasts, -1] * initial[lasts] > 0.0)
    assert np.all(result.slip_stop_impulse[initial == 0.0] == 0.0)
    stopped = ~lasts & (initial != 0.0)
    # The phase that ends at p_s leaves no slip.
    ends = np.isclose(reached, result.slip_stop_impulse[:, None], rtol=1e-13, atol=0) & (
        result.phase_impulse > 0.0
    )
    assert np.all((ends & as_begun & (np.abs(slip_after) < small)).any(axis=-1)[stopped])


@every_law
def test_mirror_symmetry(law):
    impacts = with_other_friction(random_impacts(7, 5000), 8)
    plain = law(**impacts)
    flipped = law(
        **impacts
        | {
            "inverse_mass": impacts["inverse_mass"] * MIRROR,
            "velocity": impacts["velocity"] * [1, -1],
        }
    )
    mirrored = dataclasses.replace(
        plain,
        impulse_tangential=-plain.impulse_tangential,
        velocity_tangential=-plain.velocity_tangential,
        compressive_impulse_tangential=-plain.compressive_impulse_tangential,
        phase_slip=-plain.phase_slip,
    )
    # Signs are exact.
    assert_same(flipped, mirrored, rtol=0)


@every_law
def test_scaling_of_speed_and_units(law):
    """v -> a v gives p -> a p, W -> a^2 W; K -> K/b gives p -> b p, W -> b W. Powers of two: exact."""
    impacts = with_other_friction(random_impacts(9, 5000), 10)
    plain = law(**impacts)
    speed = 2.0**10
    mass = 2.0**-30
    changed = law(
        **impacts
        | {"inverse_mass": impacts["inverse_mass"] / mass, "velocity": impacts["velocity"] * speed}
    )
    factors = {"velocity": speed, "phase_work": speed**2 * mass, "phase_slip": 1.0, "outcome": 1.0}
    for each in dataclasses.fields(Impact):
        factor = next((factors[key] for key in factors if each.name.startswith(key)), speed * mass)
        np.testing.assert_array_equal(
            getattr(changed, each.name), factor * getattr(plain, each.name)
        )


@every_law
def test_single_impacts_equal_the_array_whatever_they_are_given_as(law):
    """Lists, floats as a scene gives them, and any block of a long array: the same operations in the same order."""
    impacts = with_other_friction(random_impacts(11, 20_000, reach=1.0), 12)
    whole = law(**impacts)
    for index in range(0, 20_000, 67):
        given = {key: value[index] for key, value in impacts.items()}
        floats = {key: value.item() for key, value in given.items() if value.shape == ()}
        scene = floats | {
            "inverse_mass": given["inverse_mass"],
            "velocity": tuple(given["velocity"].tolist()),
        }
        lists = {key: value.tolist() for key, value in given.items()}
        for single in (law(**given), law(**scene), law(**lists)):
            assert isinstance(single.impulse_normal, float)
            for each in dataclasses.fields(Impact):
                np.testing.assert_array_equal(
                    getattr(single, each.name), getattr(whole, each.name)[index]
                )
    assert_same(
        law([[2, 1], [1, 2]], [-1, 1], 0, 1),
        law([[2.0, 1.0], [1.0, 2.0]], [-1.0, 1.0], 0.0, 1.0),
        0.0,
    )


@every_law
def test_arguments_broadcast(law):
    impacts = random_impacts(13, 6)
    shaped = law(
        impacts["inverse_mass"][:, None], impacts["velocity"], np.array([[[0.1]], [[0.5]]]), 0.5
    )
    assert shaped.impulse_normal.shape == (2, 6, 6)
    assert shaped.phase_work_normal.shape == (2, 6, 6, len(PHASES))
    single = law(impacts["inverse_mass"][2], impacts["velocity"][4], 0.5, 0.5)
    assert shaped.impulse_normal[1, 2, 4] == single.impulse_normal
    assert law(np.zeros((0, 2, 2)), np.zeros((0, 2)), 0.3, 0.5).phase_slip.shape == (0, len(PHASES))


@every_law
@pytest.mark.parametrize("normal_velocity", [0.0, 1.0])
def test_point_that_does_not_approach_is_left_alone(law, normal_velocity):
    result = law([[1.0, 0.3], [0.3, 2.0]], [normal_velocity, -0.7], 0.3, 0.5)
    assert result.outcome_name == "no contact"
    assert (result.velocity_normal, result.velocity_tangential) == (normal_velocity, -0.7)
    assert (result.impulse_normal, result.energy_change, result.phases) == (0.0, 0.0, ())


# What each coefficient says


def test_the_rule_of_each_coefficient():
    """W_r = -e*^2 W_c, p_r = e p_c, v_n = -e v_n(0), each up to some roundings on the way."""
    impacts = with_other_friction(random_impacts(17, 120_000), 18)
    e = impacts["restitution"]
    works = energetic_impact(**impacts)
    np.testing.assert_allclose(
        works.restitutive_work[0], -(e**2) * works.compressive_work[0], rtol=1e-13
    )
    impulses = poisson_impact(**impacts)
    np.testing.assert_allclose(
        impulses.impulse_normal, (1 + e) * impulses.compressive_impulse_normal, rtol=1e-14
    )
    np.testing.assert_allclose(
        newton_impact(**impacts).velocity_normal, -e * impacts["velocity"][:, 0], rtol=1e-12
    )


def test_which_coefficients_gain_energy():
    """Newton's does, but not while the initial slip lasts; Poisson's only with a friction of its own in restitution."""
    one = random_impacts(19, 120_000)
    before = kinetic_energy(one["inverse_mass"], one["velocity"])
    two = with_other_friction(one, 23)
    for law, impacts in ((energetic_impact, one), (energetic_impact, two), (poisson_impact, one)):
        assert np.all(law(**impacts).energy_change <= 1e-12 * before)  # Wang and Mason 1992
    assert 0.0 < np.mean(poisson_impact(**two).energy_change > 1e-6 * before) < 0.2
    result = newton_impact(**one)
    gains = result.energy_change > 1e-6 * before
    assert 0.0 < gains.mean() < 0.2
    assert not np.any(gains & np.isinf(result.slip_stop_impulse))


finite = st.floats(-10, 10, allow_subnormal=False)
positive = st.floats(0.01, 100)


@settings(max_examples=300, deadline=None)
@example(
    normal=1.0,
    tangential=1.0,
    correlation=0.0,
    approach=0.6,
    slip=1.0,
    mu_1=5e-324,
    mu_2=5e-324,
    e=1.0,
)
@given(
    normal=positive,
    tangential=positive,
    correlation=st.floats(-1, 1) | st.sampled_from([-1.0, 0.0, 1.0]),
    approach=st.floats(1e-3, 10),
    slip=finite,
    mu_1=st.floats(0, 1e3),
    mu_2=st.floats(0, 1e3),
    e=st.floats(1e-9, 1) | st.just(0.0),
)
def test_any_contact_ends_without_energy_gain(
    normal, tangential, correlation, approach, slip, mu_1, mu_2, e
):
    """Whatever the numbers, also on the borders between cases, results are finite and keep to the rules."""
    matrix = inverse_mass(normal, correlation, tangential)
    result = energetic_impact(matrix, [-approach, slip], mu_1, e, mu_2)
    values = [
        result.impulse_normal,
        *final_velocity(result),
        *total_impulse(result),
        result.energy_change,
    ]
    assert all(math.isfinite(value) for value in values)
    impulse = total_impulse(result)
    scale = (approach + abs(slip)) * np.abs(impulse).sum()
    assert result.energy_change <= 1e-12 * scale
    # Rounding of a dozen operations, and where friction is denormal, its product with the impulse rounds by whole denormals.
    assert abs(impulse[1]) <= max(mu_1, mu_2) * impulse[0] * (1 + 1e-12) + 8 * math.ulp(0.0)
    if result.outcome_name != "jam":
        assert result.velocity_normal >= 0.0
        wanted = -(e**2) * result.compressive_work[0] if result.outcome_name == "rebound" else 0.0
        assert result.restitutive_work[0] == pytest.approx(wanted, rel=1e-11, abs=1e-300)
    else:
        # Only a contact of one degree of freedom, or one like it to the last digits.
        assert abs(correlation) > 1 - 1e-13


# Borders between the cases


def test_contact_that_jams():
    """One degree of freedom whose point also moves across its lever, as no mechanism at rest around it can.

    K = 1 along l = (-sin, cos) of 30 deg, slip backwards: (1, mu) presses along l with mu cos - sin. For mu = 1 that is
    positive, so v_n falls further until slip stops after |v_t|/(cos (cos - sin)); then nothing can move the point. For
    mu = 0.1 it is negative and compression ends.
    """
    sine, cosine = 0.5, math.sqrt(0.75)
    matrix = np.outer([-sine, cosine], [-sine, cosine])
    jammed = energetic_impact(matrix, [-1.0, -0.5], 1.0, 0.5)
    assert jammed.outcome_name == "jam"
    assert jammed.impulse_normal == pytest.approx(0.5 / (cosine * (cosine - sine)), rel=1e-14)
    assert jammed.velocity_normal == pytest.approx(-1.0 - 0.5 * sine / cosine, rel=1e-14)
    ends = energetic_impact(matrix, [-1.0, -2.0], 0.1, 0.5)
    assert ends.outcome_name == "rebound"


def test_massive_tangent():
    """K_tt = 0: no impulse moves the point along the surface; friction acts while it slips, and nothing while it does not."""
    slipping = energetic_impact([[2.0, 0.0], [0.0, 0.0]], [-1.0, 0.7], 0.3, 0.5)
    assert slipping.velocity_tangential == 0.7
    assert slipping.impulse_tangential == pytest.approx(-0.3 * slipping.impulse_normal, rel=1e-15)
    still = energetic_impact([[2.0, 0.0], [0.0, 0.0]], [-1.0, 0.0], 0.3, 0.5)
    assert (still.impulse_tangential, still.velocity_normal, still.impulse_normal) == (
        0.0,
        0.5,
        0.75,
    )


def test_rounding_of_the_matrix_is_accepted():
    """K comes out of products: an asymmetry or an excess of K_nt of a rounding is none, in any units."""
    for unit in (1e-6, 1.0, 1e6):
        rounded = unit * np.array([[1.0, 1.0], [1.0 + 1e-13, 1.0 - 1e-13]])
        assert energetic_impact(rounded, [-1.0, 0.5], 0.3, 0.5).velocity_normal >= 0.0
        with pytest.raises(ValueError, match="symmetric"):
            energetic_impact(unit * np.array([[1.0, 0.5], [0.5001, 1.0]]), [-1.0, 0.5], 0.3, 0.5)
        with pytest.raises(ValueError, match="semidefinite"):
            energetic_impact(unit * np.array([[1.0, 1.001], [1.001, 1.0]]), [-1.0, 0.5], 0.3, 0.5)


@every_law
@pytest.mark.parametrize(("speed", "e"), [(1.0, 1e-170), (1e-170, 0.5)])
def test_works_too_small_for_floats(law, speed, e):
    """e*^2 or the works vanish in floats: the impact ends as without restitution, or a little later."""
    result = law([[1.0, -0.7], [-0.7, 2.0]], [-1.158 * speed, -speed], 0.3536, e, 0.8773)
    assert result.velocity_normal >= 0.0
    assert math.isfinite(result.impulse_normal)
    assert abs(result.impulse_tangential) <= 0.8773 * result.impulse_normal


# Bad input and edges

BAD = [
    ("inverse_mass", [[1.0, 0.5], [0.4, 1.0]], r" = \(1, 0.5, 0.4, 1\): must be symmetric"),
    (
        "inverse_mass",
        [[1.0, 2.0], [2.0, 1.0]],
        r" = \(1, 2, 2, 1\): must be positive semidefinite \(1/kg\)",
    ),
    (
        "inverse_mass",
        [[-1.0, 0.0], [0.0, 1.0]],
        r" = \(-1, 0, 0, 1\): must be positive semidefinite",
    ),
    (
        "inverse_mass",
        [[-1.0, 0.0], [0.0, 0.0]],
        r" = \(-1, 0, 0, 0\): must be positive semidefinite",
    ),
    ("inverse_mass", [[math.nan, 0.0], [0.0, 1.0]], r" = \(nan, 0, 0, 1\): must be finite"),
    ("inverse_mass", [1.0, 2.0], r", velocity of shapes \(2,\), \(2,\)"),
    ("inverse_mass", np.eye(2, dtype=bool), " = .*: must be real numbers"),
    ("inverse_mass", [[1e200, 3e200], [3e200, 1e200]], " = .*: must be positive semidefinite"),
    ("inverse_mass", [[1e-200, 3e-200], [3e-200, 1e-200]], " = .*: must be positive semidefinite"),
    ("velocity", [-math.inf, 0.0], r" = \(-inf, 0\): must be finite \(m/s\)"),
    ("velocity", ("-1", "0"), r" = \('-1', '0'\): must be real numbers"),
    (
        "velocity",
        (-1e200, 1e200),
        r" = \(-1e\+200, 1e\+200\) with inverse_mass .* v\^2/K are finite",
    ),
    ("velocity", (-1e160, 0.0), r" = \(-1e\+160, 0\) with inverse_mass .* v\^2/K are finite"),
    ("velocity", [(-1.0, 1.0), (-1e160, 0.0)], r" = \(-1e\+160, 0\) with inverse_mass"),
    ("friction", -0.1, r" = -0.1: must be from 0 to 1e\+150"),
    ("friction", [0.1, math.nan], r" = nan: must be from 0 to 1e\+150"),
    ("friction", True, " = True: must be real numbers"),
    ("restitution_friction", -0.1, r" = -0.1: must be from 0 to 1e\+150"),
    ("restitution", [0.5, 1.1], " = 1.1: must be 0 <= restitution <= 1"),
    ("restitution", -0.1, " = -0.1: must be 0 <= restitution <= 1"),
]


@every_law
@pytest.mark.parametrize(("name", "value", "message"), BAD)
def test_bad_input_is_named_in_one_line(law, name, value, message):
    arguments = {
        "inverse_mass": [[1.0, 0.2], [0.2, 1.0]],
        "velocity": [-1.0, 0.5],
        "friction": 0.3,
        "restitution": 0.5,
    }
    with pytest.raises(ValueError, match=f"^{name}{message}") as refusal:
        law(**arguments | {name: value})
    assert "\n" not in str(refusal.value)


def test_arrays_that_do_not_broadcast_are_named():
    shapes = r"inverse_mass \(\), velocity \(3,\), friction \(2,\), restitution \(\), [^\n]*"
    with pytest.raises(ValueError, match=f"{shapes}: must be shapes that broadcast"):
        energetic_impact(np.eye(2), [[-1.0, 0.0]] * 3, [0.1, 0.2], 0.5)


def test_arrays_of_impacts_compare_by_value():
    first, same, other = (
        energetic_impact(np.eye(2), [-1.0, 0.5], friction, 0.5)
        for friction in ([0.1, 0.2], [0.1, 0.2], [0.1, 0.3])
    )
    assert first == same
    assert first != other


def one_freedom(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Direction (n, t) of the tip of a bristle at an angle to the normal, and K of unit mass along it alone."""
    along = np.array([-math.sin(angle), math.cos(angle)])
    return along, np.outer(along, along)


def alone(value: float) -> float:
    return value


def in_array(value: float) -> np.ndarray:
    return np.array([value])


@every_law
@pytest.mark.parametrize("lengthen", [alone, in_array])
class TestEdges:
    def test_one_freedom_a_rounding_off_its_line(self, law: Callable, lengthen: Callable) -> None:
        """mu = 0.7 > tan 0.5: once slip has stopped nothing moves the point, whose v_n is then 1e-9 tan 0.5 or so.

        That is rest, and the impulse is that of compression, 2/(sin 0.5 + 0.7 cos 0.5), up to parts in 1e9.
        """
        along, matrix = one_freedom(0.5)
        result = law(matrix, 2.0 * along + np.array([0.0, 1e-9]), lengthen(0.7), 0.5)
        assert OUTCOMES[int(np.asarray(result.outcome).item())] == "stiction"
        expected = 2.0 / (math.sin(0.5) + 0.7 * math.cos(0.5))
        assert np.asarray(result.impulse_normal).item() == pytest.approx(expected, rel=1e-8)

    @pytest.mark.parametrize("coupling", [1e-310, -1e-310])
    def test_a_coupling_too_small_to_be_divided_by_is_none(
        self, law: Callable, lengthen: Callable, coupling
    ) -> None:
        """1/1e-310 is no float. Uncoupled, v = (-1, 5), mu = 0.3, e = 0.5: p_f = 1.5, and v_t falls by 0.45."""
        result = law([[1.0, coupling], [coupling, 1.0]], [-1.0, 5.0], lengthen(0.3), 0.5)
        assert np.asarray(result.impulse_normal).item() == pytest.approx(1.5, rel=1e-15)
        assert np.asarray(result.velocity_tangential).item() == pytest.approx(4.55, rel=1e-15)


def test_one_freedom_well_off_its_line_can_still_part() -> None:
    """Where v_n = w > 0 is left and stick adds nothing, the work rule asks for p = e*^2 (-W_c)/w more (Stronge).

    v_n at the stop is the slip offered, 1e-3 2, times tan 0.5, since v_t/v_n moves along one line.
    """
    along, matrix = one_freedom(0.5)
    result = energetic_impact(matrix, 2.0 * along + np.array([0.0, 2e-3]), 0.7, 0.5)
    assert result.velocity_normal == pytest.approx(2e-3 * math.tan(0.5), rel=1e-9)
    assert result.outcome_name == "rebound"
    needed = -0.25 * result.compressive_work[0] - result.phase_work_normal[2]
    assert result.phase_impulse[3] == pytest.approx(needed / result.velocity_normal, rel=1e-9)


@pytest.mark.parametrize(("slip", "mu_1", "mu_2"), [(0.0, 0.7, 0.7), (-5.0, 0.0, 5.0)])
def test_poissons_impulse_parts_nothing_where_stick_leaves_no_compliance(slip, mu_1, mu_2) -> None:
    """One degree of freedom, mu_2 > tan gamma: its speed is 0 after the impact, and the outcome is stiction."""
    along, matrix = one_freedom(0.5)
    result = poisson_impact(matrix, 2.0 * along + np.array([0.0, slip]), mu_1, 0.5, mu_2)
    assert (result.velocity_normal, result.outcome_name) == (0.0, "stiction")


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_friction_that_just_suffices_sticks(side: float) -> None:
    """mu = |K_nt|/K_tt exactly, no slip before: Zhang 2020, eq. 2.90, counts equality as stick."""
    result = energetic_impact([[1.0, 0.5 * side], [0.5 * side, 1.0]], [-1.0, 0.0], 0.5, 0.5)
    assert result.phases == ("compression stick", "restitution stick")
    assert result.impulse_tangential == pytest.approx(
        -0.5 * side * result.impulse_normal, rel=1e-15
    )
