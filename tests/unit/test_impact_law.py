"""Properties that the impact laws must have, and a march in small impulses as an independent referee."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
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
    rows = [np.stack(np.broadcast_arrays(*row), axis=-1) for row in ((normal, coupling), (coupling, tangential))]
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
        "inverse_mass": inverse_mass(10.0 ** rng.uniform(-1, 1, size), correlation, 10.0 ** rng.uniform(-1, 1, size)),
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
        np.testing.assert_allclose(getattr(one, each.name), getattr(other, each.name), rtol=rtol, atol=0)


# Every law


@every_law
@pytest.mark.parametrize("same_friction", [True, False])
def test_momentum_friction_cone_and_phases(law, same_friction):
    impacts = random_impacts(1, 20_000)
    impacts = impacts if same_friction else with_other_friction(impacts, 2)
    result = law(**impacts)
    start, end, impulse = impacts["velocity"], final_velocity(result), total_impulse(result)
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
    assert set(np.unique(result.outcome)) <= {OUTCOMES.index("rebound"), OUTCOMES.index("no rebound")}

    assert np.all(result.phase_impulse >= 0.0)
    np.testing.assert_allclose(result.phase_impulse.sum(-1), result.impulse_normal, rtol=1e-14)
    np.testing.assert_allclose(result.phase_impulse[:, :2].sum(-1), result.compressive_impulse_normal, rtol=1e-14)
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
    np.testing.assert_allclose(result.energy_change, after - before, rtol=1e-11, atol=1e-11 * before.max())


@every_law
def test_each_phase_moves_as_it_says(law):
    """Rebuild the velocities phase by phase from impulse, slip and friction; slip must not turn within a phase."""
    impacts = with_other_friction(random_impacts(5, 20_000), 6)
    result = law(**impacts)
    matrix, velocity = impacts["inverse_mass"], impacts["velocity"]
    slip_after = []
    for index in range(len(PHASES)):
        impulse, slip = result.phase_impulse[:, index], result.phase_slip[:, index]
        mu = impacts["friction" if index < 2 else "restitution_friction"]
        ratio = np.where(slip == 0.0, -matrix[:, 0, 1] / matrix[:, 1, 1], -mu * slip)
        # Slip at rest takes as much friction as holds v_n.
        resting = (index == 2) & (result.phase_work_normal[:, 2] == 0.0) & (slip != 0.0) & (impulse > 0.0)
        ratio = np.where(resting, -matrix[:, 0, 0] / np.where(resting, matrix[:, 0, 1], 1.0), ratio)
        step = np.stack([impulse, ratio * impulse], axis=-1)
        scale = np.abs(velocity).max() + np.einsum("kij,kj->k", np.abs(matrix), np.abs(step))
        velocity = velocity + np.einsum("kij,kj->ki", matrix, step)
        # Slip is along its direction at the end too, stick is none; a rounding of the terms.
        assert np.all(velocity[:, 1] * slip > -1e-12 * scale)
        assert np.all(np.abs(velocity[(slip == 0.0) & (impulse > 0.0), 1]) < 1e-12 * scale.max())
        slip_after.append(velocity[:, 1])
    np.testing.assert_allclose(velocity, final_velocity(result), atol=1e-12 * scale.max())
    check_slip_stop(result, impacts["velocity"][:, 1], np.stack(slip_after, axis=-1), 1e-12 * scale.max())


def check_slip_stop(result: Impact, initial: np.ndarray, slip_after: np.ndarray, small: float) -> None:
    """p_s is where the slip velocity first vanishes: at the start, after a phase in which it slips as it began, or never."""
    slips = (initial != 0.0)[:, None] & (result.phase_slip == np.sign(initial)[:, None]) & (result.phase_impulse > 0.0)
    as_begun = np.logical_and.accumulate(slips | (result.phase_impulse == 0.0), axis=-1)
    reached = np.cumsum(result.phase_impulse, axis=-1)
    lasts = np.isinf(result.slip_stop_impulse)
    assert np.all(as_begun[lasts, -1])
    assert np.all(slip_after[lasts, -1] * initial[lasts] > 0.0)
    assert np.all(result.slip_stop_impulse[initial == 0.0] == 0.0)
    stopped = ~lasts & (initial != 0.0)
    # The phase that ends at p_s leaves no slip.
    ends = np.isclose(reached, result.slip_stop_impulse[:, None], rtol=1e-13, atol=0) & (result.phase_impulse > 0.0)
    assert np.all((ends & as_begun & (np.abs(slip_after) < small)).any(axis=-1)[stopped])


@every_law
def test_mirror_symmetry(law):
    impacts = with_other_friction(random_impacts(7, 5000), 8)
    plain = law(**impacts)
    flipped = law(
        **impacts | {"inverse_mass": impacts["inverse_mass"] * MIRROR, "velocity": impacts["velocity"] * [1, -1]}
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
    speed, mass = 2.0**10, 2.0**-30
    changed = law(**impacts | {"inverse_mass": impacts["inverse_mass"] / mass, "velocity": impacts["velocity"] * speed})
    factors = {"velocity": speed, "phase_work": speed**2 * mass, "phase_slip": 1.0, "outcome": 1.0}
    for each in dataclasses.fields(Impact):
        factor = next((factors[key] for key in factors if each.name.startswith(key)), speed * mass)
        np.testing.assert_array_equal(getattr(changed, each.name), factor * getattr(plain, each.name))


@every_law
def test_single_impacts_equal_the_array(law):
    impacts = with_other_friction(random_impacts(11, 300, reach=1.0), 12)
    whole = law(**impacts)
    for index in range(300):
        single = law(**{key: value[index] for key, value in impacts.items()})
        assert isinstance(single.impulse_normal, float)
        for each in dataclasses.fields(Impact):
            # The same operations in the same order.
            np.testing.assert_array_equal(getattr(single, each.name), getattr(whole, each.name)[index])


@every_law
def test_floats_are_taken_as_they_are(law):
    """As a scene gives them, an array and floats, and as lists and integers, which are turned into arrays first."""
    matrix, velocity = np.array([[2.0, 0.5], [0.5, 1.0]]), (-3.0, 1.0)
    expected = law(matrix.tolist(), list(velocity), 1, 0.5, 0.25, 1.5)
    for each in (velocity, np.array(velocity)):
        assert_same(law(matrix, each, 1.0, 0.5, 0.25, 1.5), expected, 0.0)
    with pytest.raises(ValueError, match="restitution = 2"):
        law(matrix, velocity, 1.0, 2.0)


@every_law
def test_arguments_broadcast(law):
    impacts = random_impacts(13, 6)
    shaped = law(impacts["inverse_mass"][:, None], impacts["velocity"], np.array([[[0.1]], [[0.5]]]), 0.5)
    assert shaped.impulse_normal.shape == (2, 6, 6)
    assert shaped.phase_work_normal.shape == (2, 6, 6, len(PHASES))
    single = law(impacts["inverse_mass"][2], impacts["velocity"][4], 0.5, 0.5)
    assert shaped.impulse_normal[1, 2, 4] == single.impulse_normal
    assert law(np.zeros((0, 2, 2)), np.zeros((0, 2)), 0.3, 0.5).phase_slip.shape == (0, len(PHASES))


@every_law
def test_blocks_of_long_arrays_join(law):
    impacts = random_impacts(14, 20_000)
    whole = law(**impacts)
    tail = law(**{key: value[8000:8400] for key, value in impacts.items()})
    np.testing.assert_array_equal(whole.impulse_normal[8000:8400], tail.impulse_normal)
    np.testing.assert_array_equal(whole.phase_slip[8000:8400], tail.phase_slip)


@every_law
@pytest.mark.parametrize("normal_velocity", [0.0, 1.0])
def test_point_that_does_not_approach_is_left_alone(law, normal_velocity):
    result = law([[1.0, 0.3], [0.3, 2.0]], [normal_velocity, -0.7], 0.3, 0.5)
    assert result.outcome_name == "no contact"
    assert (result.velocity_normal, result.velocity_tangential) == (normal_velocity, -0.7)
    assert (result.impulse_normal, result.energy_change, result.phases) == (0.0, 0.0, ())


@every_law
def test_frictionless_impact_is_the_textbooks(law):
    """Without friction all coefficients agree: v_n = -e v_n, p = (1 + e) |v_n|/K_nn, energy lost (1 - e^2) v_n^2/(2 K_nn)."""
    impacts = random_impacts(15, 2000) | {"friction": np.zeros(2000)}
    result = law(**impacts)
    normal, e, k_nn = impacts["velocity"][:, 0], impacts["restitution"], impacts["inverse_mass"][:, 0, 0]
    # A dozen roundings, of the works in the last line.
    np.testing.assert_allclose(result.velocity_normal, -e * normal, rtol=1e-13)
    np.testing.assert_allclose(result.impulse_normal, -(1 + e) * normal / k_nn, rtol=1e-13)
    work = normal**2 / (2 * k_nn)
    assert np.all(np.abs(result.energy_change + (1 - e**2) * work) < 1e-14 * work)


@every_law
def test_uncoupled_contact_keeps_its_normal_motion(law):
    """K_nt = 0: slip stops at |v_t|/(mu K_tt) of normal impulse and stays stopped; the normal motion does not notice."""
    impacts = random_impacts(16, 2000)
    matrix = impacts["inverse_mass"] * np.eye(2)
    result = law(**impacts | {"inverse_mass": matrix})
    normal, tangential = impacts["velocity"].T
    e, mu, k_tt = impacts["restitution"], impacts["friction"], matrix[:, 1, 1]
    impulse = -(1 + e) * normal / matrix[:, 0, 0]
    np.testing.assert_allclose(result.impulse_normal, impulse, rtol=1e-13)
    left = np.maximum(np.abs(tangential) - mu * k_tt * impulse, 0.0) * np.sign(tangential)
    np.testing.assert_allclose(result.velocity_tangential, left, atol=1e-14 * np.abs(tangential).max())


# What each coefficient says


@pytest.mark.parametrize("same_friction", [True, False])
def test_energetic_work_rule_and_no_energy_gained(same_friction):
    impacts = random_impacts(17, 120_000)
    impacts = impacts if same_friction else with_other_friction(impacts, 18)
    result = energetic_impact(**impacts)
    compressive, restitutive = result.compressive_work[0], result.restitutive_work[0]
    # W_r = -e*^2 W_c by two phases of restitution: the second is what the first leaves.
    np.testing.assert_allclose(restitutive, -(impacts["restitution"] ** 2) * compressive, rtol=1e-13)
    before = kinetic_energy(impacts["inverse_mass"], impacts["velocity"])
    assert np.all(result.energy_change <= 1e-12 * before)
    assert np.all(result.energy_change >= -(1 + 1e-12) * before)


def test_poisson_impulse_rule_and_no_energy_gained():
    """p_r = e p_c; with one friction coefficient it gains no energy either (Wang and Mason 1992)."""
    impacts = random_impacts(19, 120_000)
    result = poisson_impact(**impacts)
    total = (1 + impacts["restitution"]) * result.compressive_impulse_normal
    np.testing.assert_allclose(result.impulse_normal, total, rtol=1e-14)
    before = kinetic_energy(impacts["inverse_mass"], impacts["velocity"])
    assert np.all(result.energy_change <= 1e-12 * before)


def test_poisson_gains_energy_now_and_then_where_restitution_has_its_own_friction():
    """As its docstring says; the energetic coefficient gains none on the same impacts."""
    impacts = with_other_friction(random_impacts(22, 120_000), 23)
    before = kinetic_energy(impacts["inverse_mass"], impacts["velocity"])
    assert 0.0 < np.mean(poisson_impact(**impacts).energy_change > 1e-6 * before) < 0.2
    assert np.all(energetic_impact(**impacts).energy_change <= 1e-12 * before)


def test_newton_velocity_rule_and_that_it_gains_energy_now_and_then():
    impacts = random_impacts(20, 120_000)
    result = newton_impact(**impacts)
    # Some roundings of the velocities on the way.
    np.testing.assert_allclose(result.velocity_normal, -impacts["restitution"] * impacts["velocity"][:, 0], rtol=1e-12)
    before = kinetic_energy(impacts["inverse_mass"], impacts["velocity"])
    gains = result.energy_change > 1e-6 * before
    assert 0.0 < gains.mean() < 0.2
    # Never while the initial slip lasts: v_n is then linear in p and e is e*.
    assert not np.any(gains & np.isinf(result.slip_stop_impulse))


def test_coefficients_agree_where_friction_is_none_or_slip_lasts():
    """One slope of v_n over the impulse from start to end: e, e* and Poisson's e are the same number."""
    impacts = random_impacts(21, 20_000)
    results = [law(**impacts) for law in LAWS]
    lasting = np.all([np.isinf(result.slip_stop_impulse) for result in results], axis=0)
    assert lasting.sum() > 5000
    for other in results[1:]:
        np.testing.assert_allclose(other.impulse_normal[lasting], results[0].impulse_normal[lasting], rtol=1e-12)
    # Without friction slip that reverses has no effect either, and one degree of freedom always reverses.
    impacts = random_impacts(24, 5_000, reach=1.0) | {"friction": 0.0}
    results = [law(**impacts) for law in LAWS]
    for other in results[1:]:
        np.testing.assert_allclose(other.impulse_normal, results[0].impulse_normal, rtol=1e-12)


def test_coefficients_of_one_degree_of_freedom():
    """Slip and compression stop together: v_n gains s_1 per impulse before and s_2 after, so p_r/p_c is e sqrt(s_1/s_2)
    by work, e by impulse and e s_1/s_2 by velocity.
    """
    gamma, mu, e = 0.6, 0.3, 0.5
    line = np.array([math.sin(gamma), math.cos(gamma)])
    first, second = (math.sin(gamma) + sign * mu * math.cos(gamma) for sign in (1.0, -1.0))
    ratios = {"energetic": e * math.sqrt(first / second), "poisson": e, "newton": e * first / second}
    for name, law in BY_NAME.items():
        result = law(3.0 * np.outer(line, line), -line, mu, e)
        restitutive = result.impulse_normal / result.compressive_impulse_normal - 1.0
        assert restitutive == pytest.approx(ratios[name], rel=1e-12)


def test_elastic_sticking_impact_conserves_energy():
    """e* = 1 and no slip at all: nothing is lost."""
    impacts = random_impacts(22, 5000) | {"restitution": np.ones(5000), "friction": np.full(5000, 1e3)}
    impacts["velocity"] = impacts["velocity"] * [1.0, 0.0]
    result = energetic_impact(**impacts)
    before = kinetic_energy(impacts["inverse_mass"], impacts["velocity"])
    np.testing.assert_allclose(result.energy_change, 0.0, atol=1e-12 * before.max())
    np.testing.assert_allclose(result.velocity_normal, -impacts["velocity"][:, 0], rtol=1e-13)


finite = st.floats(-10, 10, allow_subnormal=False)
positive = st.floats(0.01, 100)


@settings(max_examples=300, deadline=None)
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
def test_any_contact_ends_without_energy_gain(normal, tangential, correlation, approach, slip, mu_1, mu_2, e):
    """Whatever the numbers, also on the borders between cases, results are finite and keep to the rules."""
    matrix = inverse_mass(normal, correlation, tangential)
    result = energetic_impact(matrix, [-approach, slip], mu_1, e, mu_2)
    values = [result.impulse_normal, *final_velocity(result), *total_impulse(result), result.energy_change]
    assert all(math.isfinite(value) for value in values)
    impulse = total_impulse(result)
    scale = (approach + abs(slip)) * np.abs(impulse).sum()
    assert result.energy_change <= 1e-12 * scale
    assert abs(impulse[1]) <= max(mu_1, mu_2) * impulse[0] * (1 + 1e-12)
    if result.outcome_name != "jam":
        assert result.velocity_normal >= 0.0
        wanted = -(e**2) * result.compressive_work[0] if result.outcome_name == "rebound" else 0.0
        assert result.restitutive_work[0] == pytest.approx(wanted, rel=1e-11, abs=1e-300)
    else:
        # Only a contact of one degree of freedom, or one like it to the last digits.
        assert abs(correlation) > 1 - 1e-13


# Borders between the cases


@every_law
def test_continuous_across_the_stick_threshold(law):
    """At mu = mu_bar reverse slip is without acceleration: both sides meet, with finite slopes."""
    matrix, velocity = np.array([[1.0, 0.7], [0.7, 1.5]]), np.array([-1.0, -0.6])
    bar = abs(matrix[0][1]) / matrix[1][1]  # mu_bar (Zhang 2020, eq. 2.90)
    gap = 10.0 ** -np.arange(2.0, 9.0)
    below, above = law(matrix, velocity, bar - gap, 0.6), law(matrix, velocity, bar + gap, 0.6)
    assert np.all(below.phase_slip[:, 1] == 1.0)
    assert np.all(above.phase_slip[:, 1] == 0.0)
    difference = np.abs(final_velocity(below) - final_velocity(above)).max(-1)
    # Linear in the gap: the ratio tends to a constant.
    np.testing.assert_allclose(difference[2:] / gap[2:], difference[4] / gap[4], rtol=2e-2)


@every_law
def test_continuous_where_slip_stops_at_the_end_of_compression(law):
    """The initial slip that stops exactly when compression ends, and its neighbours on both sides."""
    matrix, mu = np.array([[1.0, 0.2], [0.2, 1.5]]), 0.4
    normal_rate, tangential_rate = 1.0 - mu * 0.2, 0.2 - mu * 1.5
    exact = -tangential_rate / normal_rate
    gap = np.array([-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3])
    velocity = np.stack([np.full(7, -1.0), exact + gap], axis=-1)
    result = law(matrix, velocity, mu, 0.6)
    middle = result.impulse_normal[3]
    assert result.compressive_impulse_normal[3] == pytest.approx(1.0 / normal_rate, rel=1e-15)
    assert result.slip_stop_impulse[3] == pytest.approx(1.0 / normal_rate, rel=1e-14)
    # Slopes dp/dv_t are of order one.
    assert np.all(np.abs(result.impulse_normal - middle) <= 2 * np.abs(gap) + 1e-14)
    assert np.all(np.abs(final_velocity(result) - final_velocity(result)[3]) <= 3 * np.abs(gap)[:, None] + 1e-14)


def test_velocity_continuous_into_stiction():
    """One degree of freedom: the tip's speed after the impact falls to zero as sqrt(tan gamma - mu) and stays there."""
    angle = math.radians(23.4)
    lever = np.array([-math.sin(angle), math.cos(angle)])
    matrix, bar = np.outer(lever, lever), math.tan(angle)
    gap = 10.0 ** -np.arange(1.0, 9.0)
    result = energetic_impact(matrix, 2.0 * lever, bar - gap, 0.42)
    speed = np.hypot(result.velocity_normal, result.velocity_tangential)
    exact = 2.0 * 0.42 * np.sqrt(gap / (2 * bar - gap))
    # The gap keeps 16 - 8 digits at the last point.
    np.testing.assert_allclose(speed, exact, rtol=1e-7)
    stuck = energetic_impact(matrix, 2.0 * lever, bar + np.array([1e-12, 1e-3, 1.0, 1e3]), 0.42)
    assert {OUTCOMES[code] for code in stuck.outcome} == {"stiction"}
    assert np.all(stuck.velocity_normal == 0.0)
    assert np.all(stuck.velocity_tangential == 0.0)


def test_slip_that_jams_until_it_stops():
    """K_nn - mu s K_nt < 0: friction presses the point on faster than K_nn throws it back, until slip stops.

    K = ((1, 0.9), (0.9, 1)), mu = 2, slip 0.5: v_n' = -0.8, v_t' = -1.1 per impulse, so slip stops at 0.5/1.1 with
    v_n = -1 - 0.4/1.1; stick then has v_n' = 1 - 0.81, and elastic restitution mirrors the compression's work.
    """
    result = energetic_impact([[1.0, 0.9], [0.9, 1.0]], [-1.0, 0.5], 2.0, 1.0)
    assert result.phases == ("compression slip", "compression stick", "restitution stick")
    deepest = 1.0 + 0.4 / 1.1
    first, second = 0.5 / 1.1, deepest / 0.19
    works = -0.5 * first * (1.0 + deepest), -0.5 * second * deepest
    restitutive = math.sqrt(-2.0 * sum(works) / 0.19)
    np.testing.assert_allclose(result.phase_impulse, [first, second, 0.0, restitutive], rtol=1e-14)
    np.testing.assert_allclose(result.phase_work_normal[:2], works, rtol=1e-14)
    assert result.velocity_normal == pytest.approx(0.19 * restitutive, rel=1e-14)
    assert result.velocity_normal > 1.0


def test_slip_at_rest_where_restitution_has_more_friction():
    """K = ((1, 0.8), (0.8, 1)), mu_1 = 0, mu_2 = 5, slip 1, v_n = -1: by hand.

    Compression without friction: p_c = 1, v_t = 1.8. In restitution mu_2 would need v_n' = 1 - 4 < 0: v_n stays 0 with
    dp_t = -(1/0.8) dp_n and v_t' = 0.8 - 1.25, so slip stops after 4; stick then has v_n' = 0.36.
    """
    result = energetic_impact([[1.0, 0.8], [0.8, 1.0]], [-1.0, 1.0], 0.0, 0.5, 5.0)
    np.testing.assert_allclose(result.phase_impulse, [1.0, 0.0, 4.0, math.sqrt(2 * 0.125 / 0.36)], rtol=1e-14)
    np.testing.assert_allclose(result.phase_work_normal, [-0.5, 0.0, 0.0, 0.125], rtol=1e-14, atol=1e-15)
    assert result.phases == ("compression slip", "restitution slip", "restitution stick")


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
    assert (still.impulse_tangential, still.velocity_normal, still.impulse_normal) == (0.0, 0.5, 0.75)


def test_phases_of_a_slow_impact():
    """Phases are named by order and motion however small the impulses are."""
    matrix = [[1.0, 0.9], [0.9, 1.0]]
    for speed in (1.0, 1e-9):
        result = energetic_impact(matrix, [-speed, 0.5 * speed], 2.0, 1.0)
        assert result.phases == ("compression slip", "compression stick", "restitution stick")


def test_rounding_of_the_matrix_is_accepted():
    """K comes out of products: an asymmetry or an excess of K_nt of a rounding is none, in any units."""
    for unit in (1e-6, 1.0, 1e6):
        rounded = unit * np.array([[1.0, 1.0], [1.0 + 1e-13, 1.0 - 1e-13]])
        assert energetic_impact(rounded, [-1.0, 0.5], 0.3, 0.5).velocity_normal >= 0.0
        with pytest.raises(ValueError, match="symmetric"):
            energetic_impact(unit * np.array([[1.0, 0.5], [0.5001, 1.0]]), [-1.0, 0.5], 0.3, 0.5)
        with pytest.raises(ValueError, match="semidefinite"):
            energetic_impact(unit * np.array([[1.0, 1.001], [1.001, 1.0]]), [-1.0, 0.5], 0.3, 0.5)


def test_outcomes_in_words():
    matrix = [[1.0, 0.2], [0.2, 1.0]]
    assert energetic_impact(matrix, [-1.0, 0.5], 0.3, 0.5).outcome_name == "rebound"
    assert energetic_impact(matrix, [-1.0, 0.5], 0.3, 0.0).outcome_name == "no rebound"
    assert energetic_impact(matrix, [-1.0, 0.5], 0.3, 0.0).velocity_normal == 0.0
    assert energetic_impact(matrix, [0.1, 0.5], 0.3, 0.5).outcome_name == "no contact"


@every_law
@pytest.mark.parametrize(("speed", "e"), [(1.0, 1e-170), (1e-170, 0.5)])
def test_works_too_small_for_floats(law, speed, e):
    """e*^2 or the works vanish in floats: the impact ends as without restitution, or a little later."""
    result = law([[1.0, -0.7], [-0.7, 2.0]], [-1.158 * speed, -speed], 0.3536, e, 0.8773)
    assert result.velocity_normal >= 0.0
    assert math.isfinite(result.impulse_normal)
    assert abs(result.impulse_tangential) <= 0.8773 * result.impulse_normal


# The march: small normal impulses, friction as the projection on its cone


def march(impacts: dict[str, np.ndarray], steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Impulses, velocities and whether the impact has ended, by steps of 1/steps of the frictionless p_c.

    Friction takes what would stop the slip within the step, but no more than mu dp: slip, stick and reversal come by
    themselves. Restitution ends when its normal work reaches e*^2 times that of compression.
    """
    matrix, velocity = impacts["inverse_mass"], impacts["velocity"].copy()
    k_nn, k_nt, k_tt = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 1]
    mu_1, e = impacts["friction"], impacts["restitution"]
    mu_2 = impacts.get("restitution_friction", mu_1)
    step = -velocity[:, 0] / k_nn / steps
    impulse, compressed = np.zeros_like(velocity), np.zeros(len(step), dtype=bool)
    work, taken = np.zeros_like(step), np.zeros_like(step)
    active = np.ones(len(step), dtype=bool)
    for _ in range(40 * steps):
        push = np.where(active, step, 0.0)
        bound = np.where(velocity[:, 0] < 0.0, mu_1, mu_2) * push
        rub = np.clip(-(velocity[:, 1] + k_nt * push) / k_tt, -bound, bound)
        change = np.stack([k_nn * push + k_nt * rub, k_nt * push + k_tt * rub], axis=-1)
        work += push * (velocity[:, 0] + 0.5 * change[:, 0])
        velocity += change
        impulse += np.stack([push, rub], axis=-1)
        newly = active & ~compressed & (velocity[:, 0] >= 0.0)
        taken = np.where(newly, work, taken)
        compressed |= newly
        active &= ~(compressed & (work >= (1.0 - e**2) * taken))
        if not active.any():
            break
    return impulse, velocity, ~active


def special_impacts(kind: str) -> dict[str, np.ndarray]:
    """Contacts of one kind each."""
    size = 200
    impacts = random_impacts(sum(map(ord, kind)), size, reach=0.9)
    matrix, velocity, mu = impacts["inverse_mass"], impacts["velocity"], impacts["friction"]
    along = np.where(velocity[:, 1] == 0.0, 1.0, np.sign(velocity[:, 1]))
    if kind == "other friction":
        return with_other_friction(impacts, 31)
    if kind == "initial stick":
        velocity[:, 1] = 0.0
    elif kind == "slip stops as compression ends":
        slowing = mu * matrix[:, 1, 1] - along * matrix[:, 0, 1]
        closing = matrix[:, 0, 0] - mu * along * matrix[:, 0, 1]
        regular = (slowing > 0.0) & (closing > 0.1 * matrix[:, 0, 0])
        exact = -velocity[:, 0] * slowing / np.where(closing > 0.0, closing, 1.0)
        velocity[:, 1] = np.where(regular, along * exact, velocity[:, 1])
    elif kind == "pressed on":
        # mu beyond K_nn/|K_nt|, with slip in the direction that digs in.
        coupling = 0.9 * np.sqrt(matrix[:, 0, 0] * matrix[:, 1, 1])
        matrix[:, 0, 1] = matrix[:, 1, 0] = along * coupling
        impacts["friction"] = 1.2 * matrix[:, 0, 0] / coupling
    elif kind == "more friction in restitution":
        coupling = 0.9 * np.sqrt(matrix[:, 0, 0] * matrix[:, 1, 1])
        matrix[:, 0, 1] = matrix[:, 1, 0] = along * coupling
        impacts["friction"] = np.full(size, 0.05)
        impacts["restitution_friction"] = 1.5 * matrix[:, 0, 0] / coupling
        # While it slips at rest the march chatters about v_n = 0, and its stray work counts against e*^2.
        impacts["restitution"] = np.linspace(0.5, 1.0, size)
    elif kind == "one degree of freedom":
        # The velocity lies along the lever, and mu is below the stiction that ends a march.
        angle = np.linspace(0.3, 1.4, size)
        lever = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
        impacts["inverse_mass"] = lever[:, :, None] * lever[:, None, :]
        impacts["velocity"], impacts["friction"] = lever.copy(), 0.8 * np.tan(angle) * np.linspace(1.0, 0.0, size)
    return impacts


KINDS = [
    "any", "other friction", "initial stick", "slip stops as compression ends", "pressed on",
    "more friction in restitution", "one degree of freedom",
]  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_march_in_small_impulses(kind):
    impacts = special_impacts(kind)
    result = energetic_impact(**impacts)
    # Contacts that need more than thirty times the impulse of a frictionless compression would march for long.
    short = result.impulse_normal < -30 * impacts["velocity"][:, 0] / impacts["inverse_mass"][:, 0, 0]
    assert short.mean() > 0.7
    impacts = {key: value[short] for key, value in impacts.items()}
    wanted, reached = total_impulse(result)[short], final_velocity(result)[short]
    speed = np.abs(impacts["velocity"]).max(-1) + np.abs(reached).max(-1)
    errors = []
    for steps in (60, 240):
        impulse, velocity, ended = march(impacts, steps)
        assert ended.all()
        apart = np.abs(impulse - wanted).max(-1) / wanted[:, 0] + np.abs(velocity - reached).max(-1) / speed
        errors.append(apart)
    # First order in the step: an error of a few steps, and four times smaller on the average at a quarter of the step.
    assert np.all(errors[0] < 20 / 60)
    assert np.all(errors[1] < 20 / 240)
    assert errors[1].mean() < 0.4 * errors[0].mean()


# Bad input


@every_law
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"inverse_mass": [[1.0, 0.5], [0.4, 1.0]]}, r"^inverse_mass = \(1, 0.5, 0.4, 1\): must be symmetric"),
        (
            {"inverse_mass": [[1.0, 2.0], [2.0, 1.0]]},
            r"^inverse_mass = \(1, 2, 2, 1\): must be positive semidefinite \(1/kg\)",
        ),
        (
            {"inverse_mass": [[-1.0, 0.0], [0.0, 1.0]]},
            r"^inverse_mass = \(-1, 0, 0, 1\): must be positive semidefinite \(1/kg\)",
        ),
        (
            {"inverse_mass": [[math.nan, 0.0], [0.0, 1.0]]},
            r"^inverse_mass = \(nan, 0, 0, 1\): must be finite",
        ),
        ({"inverse_mass": [1.0, 2.0]}, r"^inverse_mass, velocity of shapes \(2,\), \(2,\)"),
        ({"velocity": [-1.0, 0.0, 0.0]}, r"^inverse_mass, velocity of shapes \(2, 2\), \(3,\)"),
        ({"velocity": [-math.inf, 0.0]}, r"^velocity = \(-inf, 0\): must be finite \(m/s\)"),
        ({"friction": -0.1}, r"^friction = -0.1: must be from 0 to 1e\+150"),
        ({"friction": math.inf}, r"^friction = inf: must be from 0 to 1e\+150"),
        ({"friction": [0.1, math.nan]}, r"^friction = nan: must be from 0 to 1e\+150"),
        ({"restitution_friction": -0.1}, r"^restitution_friction = -0.1: must be from 0 to 1e\+150"),
        ({"restitution": 1.1}, r"^restitution = 1.1: must be 0 <= restitution <= 1"),
        ({"restitution": [0.5, -0.1]}, r"^restitution = -0.1: must be 0 <= restitution <= 1"),
        ({"friction": True}, r"^friction = True: must be real numbers"),
        ({"friction": [0.3, False]}, r"^friction = \[0.3, False\]: must be real numbers"),
        ({"restitution": "0.5"}, r"^restitution = '0.5': must be real numbers"),
        ({"velocity": ("-1", "0")}, r"^velocity = \('-1', '0'\): must be real numbers"),
        ({"inverse_mass": np.eye(2, dtype=bool)}, r"^inverse_mass = .*: must be real numbers"),
        ({"inverse_mass": [[1e200, 3e200], [3e200, 1e200]]}, r"^inverse_mass = .*: must be positive semidefinite"),
        ({"inverse_mass": [[1e-200, 3e-200], [3e-200, 1e-200]]}, r"^inverse_mass = .*: must be positive semidefinite"),
        ({"velocity": (-1e200, 1e200)}, r"^velocity = \(-1e\+200, 1e\+200\) with inverse_mass .* v\^2/K are finite"),
        ({"velocity": [(-1.0, 1.0), (-1e160, 0.0)]}, r"^velocity = \(-1e\+160, 0\) with inverse_mass"),
        ({"inverse_mass": [[1e-320, 0.0], [0.0, 1e-320]]}, r"^velocity = .* with inverse_mass of diagonal"),
    ],
)
def test_bad_input_is_named_in_one_line(law, change, message):
    arguments = {"inverse_mass": [[1.0, 0.2], [0.2, 1.0]], "velocity": [-1.0, 0.5], "friction": 0.3, "restitution": 0.5}
    with pytest.raises(ValueError, match=message) as refusal:
        law(**arguments | change)
    assert "\n" not in str(refusal.value)


def one_freedom(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Direction (n, t) of the tip of a bristle at an angle to the normal, and K of unit mass along it alone."""
    along = np.array([-math.sin(angle), math.cos(angle)])
    return along, np.outer(along, along)


class TestEdges:
    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [np.asarray, lambda value: np.stack([value, value])])
    def test_whole_numbers_are_numbers(self, law: Callable, lengthen: Callable) -> None:
        """K = ((2, 1), (1, 2)), v = (-1, 1), mu = 0, e = 1 typed as integers: v_n is reversed by 2 |v_n|/K_nn."""
        matrix, velocity = lengthen(np.array([[2, 1], [1, 2]])), lengthen(np.array([-1, 1]))
        for arguments in ((matrix, velocity, 0, 1), (matrix.astype(float), velocity, 0.0, 1)):
            result = law(*arguments)
            np.testing.assert_allclose(result.impulse_normal, 1.0, rtol=1e-15)
            np.testing.assert_allclose(result.velocity_tangential, 2.0, rtol=1e-15)

    def test_a_touch_whose_work_is_below_the_smallest_float(self) -> None:
        """K = 1, v_n = -1e-170: W_c = 5e-341 is no float, but p_f lies between p_c = 1e-170 and 2 p_c, and the outcome is named by v_n."""
        result = energetic_impact(np.eye(2), [-1e-170, 0.0], 0.3, 0.5)
        assert 1e-170 <= result.impulse_normal <= 2e-170
        assert result.outcome_name == ("rebound" if result.velocity_normal > 0.0 else "no rebound")

    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([value])])
    def test_one_freedom_a_rounding_off_its_line(self, law: Callable, lengthen: Callable) -> None:
        """mu = 0.7 > tan 0.5: once slip has stopped nothing moves the point, whose v_n is then 1e-9 tan 0.5 or so.

        That is rest, and the impulse is that of compression, 2/(sin 0.5 + 0.7 cos 0.5), up to parts in 1e9.
        """
        along, matrix = one_freedom(0.5)
        result = law(matrix, 2.0 * along + np.array([0.0, 1e-9]), lengthen(0.7), 0.5)
        assert OUTCOMES[int(np.asarray(result.outcome).item())] == "stiction"
        expected = 2.0 / (math.sin(0.5) + 0.7 * math.cos(0.5))
        assert np.asarray(result.impulse_normal).item() == pytest.approx(expected, rel=1e-8)

    def test_one_freedom_well_off_its_line_can_still_part(self) -> None:
        """Where v_n = w > 0 is left and stick adds nothing, the work rule asks for p = e*^2 (-W_c)/w more (Stronge).

        v_n at the stop is the slip offered, 1e-3 2, times tan 0.5, since v_t/v_n moves along one line.
        """
        along, matrix = one_freedom(0.5)
        result = energetic_impact(matrix, 2.0 * along + np.array([0.0, 2e-3]), 0.7, 0.5)
        assert result.velocity_normal == pytest.approx(2e-3 * math.tan(0.5), rel=1e-9)
        assert result.outcome_name == "rebound"
        needed = -0.25 * result.compressive_work[0] - result.phase_work_normal[2]
        assert result.phase_impulse[3] == pytest.approx(needed / result.velocity_normal, rel=1e-9)

    def test_poissons_impulse_spent_in_slip_at_rest_parts_nothing(self) -> None:
        """One degree of freedom that slips on at rest (mu 0, then 5): v_n stays 0, which is no rebound."""
        along, matrix = one_freedom(0.5)
        result = poisson_impact(matrix, 2.0 * along + np.array([0.0, -5.0]), 0.0, 0.5, 5.0)
        assert result.velocity_normal == 0.0
        assert result.outcome_name == "stiction"

    @pytest.mark.parametrize("law", LAWS)
    def test_phases_that_do_not_occur_have_no_slip(self, law: Callable) -> None:
        """A point that departs has none of the four; without restitution (e = 0) the last two are missing."""
        departing = law(np.eye(2), [1.0, 1.0], 0.3, 0.5)
        assert departing.outcome_name == "no contact"
        assert not departing.phase_slip.any()
        assert not law(np.eye(2), [-1.0, 9.0], 0.3, 0.0).phase_slip[2:].any()

    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([value, 0.5 * value])])
    def test_a_point_that_nothing_moves_along_the_normal_jams(self, law: Callable, lengthen: Callable) -> None:
        """K_nn = 0 is positive semidefinite: no impulse stops the approach."""
        outcome = law(np.diag([0.0, 1.0]), [-1.0, 0.5], lengthen(0.3), 0.5).outcome
        assert np.all(np.asarray(outcome) == OUTCOMES.index("jam"))

    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("lengthen", [float, lambda value: np.array([value])])
    @pytest.mark.parametrize("coupling", [1e-310, -1e-310])
    def test_a_coupling_too_small_to_be_divided_by_is_none(
        self, law: Callable, lengthen: Callable, coupling: float
    ) -> None:
        """1/1e-310 is no float. Uncoupled, v = (-1, 5), mu = 0.3, e = 0.5: p_f = 1.5, and v_t falls by 0.45."""
        result = law([[1.0, coupling], [coupling, 1.0]], [-1.0, 5.0], lengthen(0.3), 0.5)
        assert np.asarray(result.impulse_normal).item() == pytest.approx(1.5, rel=1e-15)
        assert np.asarray(result.velocity_tangential).item() == pytest.approx(4.55, rel=1e-15)


class TestByHand:
    @pytest.mark.parametrize("slip", [10.0, 0.35])
    def test_work_of_friction_in_restitution(self, slip: float) -> None:
        """K = 1 (uncoupled), v_n = -1, mu = 0.3, e* = 0.5: p_c = 1, p_r = 0.5, and v_t falls by 0.3 per unit impulse.

        Friction takes the energy of the tangential motion, v_t^2/2 before restitution less v_t^2/2 after it. Slip of 0.35
        has 0.05 left after compression, less than the 0.15 that restitution could take: all of it goes.
        """
        result = energetic_impact(np.eye(2), [-1.0, slip], 0.3, 0.5)
        before, after = slip - 0.3, max(slip - 0.45, 0.0)
        # A few roundings of numbers of order slip^2.
        small = 1e-15 * slip**2
        assert result.compressive_work[1] == pytest.approx(0.5 * (before**2 - slip**2), rel=1e-14, abs=small)
        assert result.restitutive_work[1] == pytest.approx(0.5 * (after**2 - before**2), rel=1e-13, abs=small)

    def test_work_of_friction_after_slip_that_reverses_in_restitution(self) -> None:
        """K = ((1, 0.8), (0.8, 1)), v = (-1, -1.2), mu = 0.1, e* = 1: by hand.

        Backward slip: v_n' = 0.8 (1.25 + 0.1), v_t' = 0.9, so compression ends at p = 1/1.08 with v_t = -1.2 + 0.9/1.08,
        W_c = -0.5/1.08. Slip stops after (1.2 - 0.9/1.08)/0.9 more, where v_n = 1.08 times that; forward slip then has
        v_n' = 0.92, v_t' = 0.7, and takes v_n^2 - w^2 = 2 0.92 (W_c left). Friction's work is -0.1 times the slip path.
        """
        result = energetic_impact([[1.0, 0.8], [0.8, 1.0]], [-1.0, -1.2], 0.1, 1.0)
        left_slip = 1.2 - 0.9 / 1.08
        backwards = left_slip / 0.9
        at_stop = 1.08 * backwards
        work_left = 0.5 / 1.08 - 0.5 * at_stop * backwards
        forwards = (math.sqrt(at_stop**2 + 2.0 * 0.92 * work_left) - at_stop) / 0.92
        friction = -0.1 * 0.5 * (left_slip * backwards + 0.7 * forwards**2)
        assert result.phases == ("compression slip", "restitution slip", "restitution reverse slip")
        # A few roundings, of differences that keep one digit less.
        assert result.restitutive_work[1] == pytest.approx(friction, rel=1e-13)

    @pytest.mark.parametrize("matrix", [((-1.0, 0.0), (0.0, 0.0)), ((0.0, 0.0), (0.0, -1.0))])
    def test_negative_mass_beside_none_is_refused(self, matrix: tuple[tuple[float, float], ...]) -> None:
        """K = diag(-1, 0) has a determinant of 0 as a hinged rod's K has, but no body gains speed against its impulse."""
        with pytest.raises(ValueError, match="positive semidefinite"):
            energetic_impact(matrix, [-1.0, 0.0], 0.3, 0.5)

    @pytest.mark.parametrize("scale", [1.0, 3.0])
    def test_poisson_in_stiction(self, scale: float) -> None:
        """One degree of freedom, mu > tan gamma: stick leaves no compliance, so p_r = e p_c parts the point from nothing.

        Its speed is 0 after the impact, and the outcome is the energetic law's: stiction.
        """
        angle = math.radians(30.0)
        lever = np.array([-math.sin(angle), math.cos(angle)])
        matrix = scale * np.outer(lever, lever)
        for law in (poisson_impact, energetic_impact):
            result = law(matrix, 2.0 * lever, 0.7, 0.5)
            assert result.outcome_name == "stiction"
            assert result.velocity_normal == 0.0

    def test_a_rebound_at_unit_compliance_is_one(self) -> None:
        """K = 1, e = 1, v_n = -1: the point leaves at exactly 1, which is no stiction."""
        for law in (poisson_impact, energetic_impact):
            result = law(np.eye(2), [-1.0, 0.0], 0.3, 1.0)
            assert (result.velocity_normal, result.outcome_name) == (1.0, "rebound")

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_friction_that_just_suffices_sticks(self, side: float) -> None:
        """mu = |K_nt|/K_tt exactly, no slip before: Zhang 2020, eq. 2.90, counts equality as stick."""
        result = energetic_impact([[1.0, 0.5 * side], [0.5 * side, 1.0]], [-1.0, 0.0], 0.5, 0.5)
        assert result.phases == ("compression stick", "restitution stick")
        assert result.impulse_tangential == pytest.approx(-0.5 * side * result.impulse_normal, rel=1e-15)
