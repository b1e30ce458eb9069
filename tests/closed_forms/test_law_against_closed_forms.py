"""The impact law, given K and v of each mechanism, against the mechanism's own closed form; both at random parameters.

The closed forms know nothing of contact space: the monofilament and the single pendulum are formulas, the double pendulum
is followed in its generalized speeds. The law knows nothing of rods.
"""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.theory.impact import OUTCOMES, Impact, energetic_impact
from bristle_sim.theory.monofilament import monofilament_impact
from bristle_sim.theory.pendulums import double_pendulum_impact


def lever_contact(
    lever: np.ndarray, inertia: np.ndarray, speed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """K = lever lever^T/inertia and v = lever speed of one degree of freedom; lever = dv/dq in (normal, tangential)."""
    return lever[..., :, None] * lever[..., None, :] / inertia[..., None, None], lever * speed[
        ..., None
    ]


def random_rods(seed: int, size: int) -> list[dict[str, float]]:
    """Double pendulums of any angles and rates, mass ratios 0.3 to 1e6, friction and restitution at and off their limits."""
    rng = np.random.default_rng(seed)
    return [
        {
            "rod_mass": 10.0 ** rng.uniform(-4, 2),
            "mass_ratio": 10.0 ** rng.uniform(math.log10(0.3), 6),
            "rod_length": 10.0 ** rng.uniform(-2, 1),
            "angle_1": rng.uniform(-1.5, 1.5),
            "angle_2": rng.uniform(-1.5, 1.5),
            "rate_1": rng.normal() * 10.0 ** rng.uniform(-1, 3),
            "rate_2": rng.normal() * 10.0 ** rng.uniform(-1, 3),
            "friction": rng.choice([0.0, rng.uniform(0, 0.5), rng.uniform(0, 4)]),
            "restitution": rng.choice([0.0, rng.uniform(0, 1), 1.0]),
            "restitution_friction": rng.choice([0.0, rng.uniform(0, 0.5), rng.uniform(0, 4)]),
        }
        for _ in range(size)
    ]


def rod_contact(rods: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrix and contact Jacobian, rows (normal, tangential), in the rates of the rods (Zhang 2020, eqs. 2.91, 2.95)."""
    light = rods["rod_mass"]
    length = rods["rod_length"]
    first, second = rods["angle_1"], rods["angle_2"]
    coupled = math.cos(first - second) / 2
    mass = light * length**2 * np.array([[rods["mass_ratio"] / 3 + 1, coupled], [coupled, 1 / 3]])
    jacobian = length * np.array(
        [[math.sin(first), math.sin(second)], [-math.cos(first), -math.cos(second)]]
    )
    return mass, jacobian


def contact_space(rods: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """K, v and the change of the rates by a unit impulse."""
    mass, jacobian = rod_contact(rods)
    response = np.linalg.solve(mass, jacobian.T)
    matrix = jacobian @ response
    return (matrix + matrix.T) / 2, jacobian @ [rods["rate_1"], rods["rate_2"]], response


def solve_by_law(pendulums: list[dict[str, float]]) -> tuple[Impact, np.ndarray, np.ndarray]:
    """Impacts, rates after them, and how ill-conditioned each K is, K_nn K_tt/det K >= 1."""
    contacts = [contact_space(rods) for rods in pendulums]
    matrix, velocity, response = (np.array(each) for each in zip(*contacts, strict=True))
    column = {key: np.array([rods[key] for rods in pendulums]) for key in pendulums[0]}
    result = energetic_impact(
        matrix, velocity, column["friction"], column["restitution"], column["restitution_friction"]
    )
    impulse = np.stack([result.impulse_normal, result.impulse_tangential], axis=-1)
    rates = np.stack([column["rate_1"], column["rate_2"]], axis=-1) + np.einsum(
        "kij,kj->ki", response, impulse
    )
    return result, rates, matrix[:, 0, 0] * matrix[:, 1, 1] / np.linalg.det(matrix)


def test_double_pendulums_at_random():
    pendulums = random_rods(1, 2000)
    law, rates, condition = solve_by_law(pendulums)
    closed = [double_pendulum_impact(**rods) for rods in pendulums]

    # Some hundred roundings; where C sticks, as many of K's small compliance in stick, det K/K_tt.
    sticks = np.array([any("stick" in phase for phase in each.phases) for each in closed])
    allowed = np.where(sticks, np.maximum(1e-12, 2e-14 * condition), 1e-12)
    assert np.mean(allowed < 1e-9) > 0.97
    for name, other in (
        ("impulse_normal", "normal_final_impulse"),
        ("compressive_impulse_normal", "normal_compressive_impulse"),
        ("slip_stop_impulse", "slip_stop_impulse"),
    ):
        expected = np.array([getattr(each, other) for each in closed])
        stops = np.isfinite(expected)
        np.testing.assert_array_equal(np.isfinite(getattr(law, name)), stops)
        error = np.abs(getattr(law, name)[stops] - expected[stops])
        assert np.all(error <= allowed[stops] * expected[stops])

    expected = np.array([[each.final_rate_1, each.final_rate_2] for each in closed])
    start = np.array([[rods["rate_1"], rods["rate_2"]] for rods in pendulums])
    scale = np.maximum(np.abs(expected), np.abs(start)).max(axis=1)
    assert np.all(np.abs(rates - expected).max(axis=1) <= allowed * scale)

    masses = np.array([rod_contact(rods)[0] for rods in pendulums])
    before = 0.5 * np.einsum("ki,kij,kj->k", start, masses, start)
    lost = (1.0 - np.array([each.kinetic_energy_ratio for each in closed])) * before
    # The ratio is a difference from one; works carry the condition of K.
    assert np.all(
        np.abs(law.energy_change + lost) <= 1e-12 * before * np.maximum(1.0, 0.1 * condition)
    )

    assert [OUTCOMES[int(code)] for code in law.outcome] == [each.outcome for each in closed]
    # Every sequence of phases there is, each several times.
    assert len({each.phases for each in closed}) >= 10
    for rods, each in zip(pendulums[:1500], closed, strict=False):
        frictions = rods["friction"], rods["restitution"], rods["restitution_friction"]
        assert energetic_impact(*contact_space(rods)[:2], *frictions).phases == each.phases


def test_monofilaments_at_random():
    rng = np.random.default_rng(5)
    size = 50_000
    mass = 10.0 ** rng.uniform(-6, 2, size)
    length = 10.0 ** rng.uniform(-3, 1, size)
    hub_radius = 10.0 ** rng.uniform(-3, 1, size)
    hub_speed = 10.0 ** rng.uniform(-1, 4, size)
    ratio = rng.uniform(0.1, 10, size)
    angle = rng.uniform(0.02, math.pi / 2, size)
    mu_1 = rng.exponential(0.5, size)
    mu_2 = rng.exponential(0.5, size)
    e = rng.uniform(0, 1, size)
    e = np.where(rng.random(size) < 0.1, 0.0, e)
    closed = monofilament_impact(mass, length, hub_radius, hub_speed, ratio, angle, mu_1, e, mu_2)

    lever = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    law = energetic_impact(
        *lever_contact(lever, mass / 3, (ratio * length + hub_radius) * hub_speed), mu_1, e, mu_2
    )
    np.testing.assert_array_equal(law.outcome, closed.outcome)
    # s_2 = sin gamma - mu_2 cos gamma cancels towards stiction.
    near = np.sin(angle) / np.abs(np.sin(angle) - mu_2 * np.cos(angle))
    for computed, expected in (
        (law.compressive_impulse_normal, closed.normal_compressive_impulse),
        (law.compressive_impulse_tangential, closed.tangential_compressive_impulse),
        (law.compressive_work[0], closed.normal_compressive_work),
        (law.compressive_work[1], closed.tangential_compressive_work),
    ):
        np.testing.assert_allclose(computed, expected, rtol=1e-13)
    error = np.abs(law.impulse_normal - closed.normal_final_impulse)
    assert np.all(error <= 1e-13 * near * closed.normal_final_impulse)
    # The tip's velocity after the impact, along its lever.
    tip = length * closed.final_bristle_rate + hub_radius * hub_speed
    speed = (ratio * length + hub_radius) * hub_speed
    after = np.stack([law.velocity_normal, law.velocity_tangential], axis=-1)
    assert np.all(np.abs(after - lever * tip[:, None]) <= 1e-13 * (near * speed)[:, None])
    # Identity of eqs. 2.40 and 2.58: all of the approach's energy goes into compression, m v_C^2/6.
    spent = law.compressive_work[0] + law.compressive_work[1]
    np.testing.assert_allclose(spent, -mass * speed**2 / 6, rtol=1e-13)
