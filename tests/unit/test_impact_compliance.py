"""The tangential spring beside the normal one: an independent march in time, closed forms, limits, and hard cases."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.optimize import brentq

from benchmarks.law_march import (
    differences,
    impulse_and_velocity,
    marched,
    nearly_singular_impacts,
    random_impacts,
)
from bristle_sim.theory import impact_compliance
from bristle_sim.theory.impact import (
    OUTCOMES,
    Impact,
    energetic_impact,
    newton_impact,
    poisson_impact,
)
from bristle_sim.theory.impact_springs import Sums


@pytest.mark.parametrize(
    ("size", "most_steps"),
    [(40, 450), pytest.param(20_000, 4000, marks=pytest.mark.nightly)],
    ids=["few", "many"],
)
def test_the_same_as_a_march_in_time(size: int, most_steps: int) -> None:
    """DOP853 by steps of a seventh of the fastest time scale is good to rounding; it adds up to 1e-10 in a hundred steps of slow slip."""
    impacts = random_impacts(1, size)
    found, _ = marched(impacts, most_steps)
    apart = differences(impulse_and_velocity(energetic_impact(**impacts)), found)
    # The others press and release the point again and again, as mu_2 > mu_1 can, or take longer.
    assert np.isfinite(apart).sum() > 0.9 * size
    assert np.nanmax(apart) < 1e-9, np.argsort(np.nan_to_num(apart))[-5:]


@pytest.mark.nightly
def test_a_nearly_singular_K_goes_through_as_many_phases_as_a_march() -> None:
    """As above, through up to a thousand phases; the march's error grows with their number, to some 1e-10.

    The law is as close as rounding permits: closer than laws whose arguments differ by a rounding error, which are up to 1e-7 apart.
    Every seventh impact takes the march more than 20,000 steps.
    """
    impacts = nearly_singular_impacts(1, 300)
    law = impulse_and_velocity(energetic_impact(**impacts))
    found, _ = marched(impacts, 20_000, 4000)
    apart = differences(law, found)
    assert np.isfinite(apart).sum() > 0.8 * 300
    rng = np.random.default_rng(0)
    permitted = np.full(300, 1e-10)
    for _ in range(4):
        rounded = {
            key: each * (1.0 + np.spacing(1.0) * rng.choice([-1.0, 1.0], each.shape))
            for key, each in impacts.items()
        }
        rounded["inverse_mass"][:, 1, 0] = rounded["inverse_mass"][:, 0, 1]
        rounded["restitution_friction"] = rounded["friction"]
        other = impulse_and_velocity(energetic_impact(**rounded))
        permitted = np.maximum(permitted, differences(other, law))
    excess = np.nan_to_num(apart / permitted)
    assert excess.max() < 1.0, np.argsort(excess)[-5:]


@pytest.mark.parametrize("determinant", [1e-3, 1e-5, pytest.param(2e-6, marks=pytest.mark.nightly)])
def test_springs_that_lose_nothing_swing_as_one_motion(determinant: float) -> None:
    """With e* = 1 and no slip loading and unloading are one line: f'' = -D K f for the forces f, up to N = 0.

    The law goes through 53, 501 and 1,114 phases of stick, with roundings of some 1e-14 in each of them.
    """
    lever = np.array([1.0, 1.0])
    squared = 0.01
    across = np.array([1.0, -1.0])
    matrix = np.outer(lever, lever) + 0.25 * determinant * np.outer(across, across)
    start = np.array([-1.0, 0.9])
    root = np.array([1.0, 1.0 / math.sqrt(squared)])
    squares, modes = np.linalg.eigh(root[:, None] * matrix * root)
    squares[0] = np.linalg.det(matrix) / squared / squares[1]
    rates = np.sqrt(squares)
    speeds = modes.T @ (root * start)

    def push(time: float) -> float:
        return -float(modes[0] @ (speeds * np.sin(rates * time) / rates))

    times = np.linspace(0.0, 2.0 * math.pi / rates[0], 200_000)[1:]
    pushes = -(modes[0] * speeds / rates) @ np.sin(np.outer(rates, times))
    first = int(np.argmax(pushes < 0.0))
    end = brentq(push, times[first - 1], times[first], xtol=1e-16, rtol=1e-15)
    velocity = modes @ (speeds * np.cos(rates * end)) / root
    found = energetic_impact(matrix, start, 1e12, 1.0, tangential_compliance=squared)
    np.testing.assert_allclose(
        [found.velocity_normal, found.velocity_tangential], velocity, atol=1e-9
    )


def test_a_point_that_chatters_keeps_cone_and_energy() -> None:
    """With mu_2 > mu_1 slip can press a point on as soon as it begins to part: no accuracy is claimed, but both laws hold.

    The impulse stays within the wider cone, dv = K p up to roundings of the terms, and the energy does not grow.
    """
    impacts = random_impacts(4, 1000, reach=0.99)
    impacts |= {
        "friction": 0.2 * impacts["friction"],
        "restitution_friction": 1.0 + impacts["friction"],
    }
    found = energetic_impact(**impacts)
    matrix = impacts["inverse_mass"]
    start = impacts["velocity"]
    impulse, end = np.split(impulse_and_velocity(found), 2, axis=-1)
    terms = np.abs(start).sum(-1) + np.einsum("kij,kj->k", np.abs(matrix), np.abs(impulse))
    assert np.all(
        np.abs(end - start - np.einsum("kij,kj->ki", matrix, impulse)) < 1e-11 * terms[:, None]
    )
    assert np.all(
        np.abs(impulse[:, 1]) <= impacts["restitution_friction"] * impulse[:, 0] * (1.0 + 1e-12)
    )
    before = 0.5 * np.einsum("ki,kij,kj->k", start, np.linalg.inv(matrix), start)
    assert np.all(found.energy_change <= 1e-11 * before)
    assert np.all(found.velocity_normal >= 0.0)


class TestBounds:
    @pytest.mark.parametrize("squared", [1e-4, 0.01, 1.0, 100.0, 1e4])
    @pytest.mark.parametrize("same_friction", [True, False])
    def test_momentum_cone_and_energy(self, squared: float, same_friction: bool) -> None:
        """dv = K p, |p_t| <= mu p_n, W_r = e*^2 |W_c| and no energy gained, up to roundings of the terms; also ill-conditioned K."""
        impacts = random_impacts(2, 1000, reach=0.9999) | {"tangential_compliance": squared}
        if same_friction:
            impacts["restitution_friction"] = impacts["friction"]
        else:
            impacts["restitution_friction"] = np.minimum(
                impacts["restitution_friction"], impacts["friction"]
            )
        found = energetic_impact(**impacts)
        matrix = impacts["inverse_mass"]
        start = impacts["velocity"]
        impulse, end = np.split(impulse_and_velocity(found), 2, axis=-1)
        terms = np.abs(start).sum(-1) + np.einsum("kij,kj->k", np.abs(matrix), np.abs(impulse))
        moved = np.einsum("kij,kj->ki", matrix, impulse)
        assert np.all(np.abs(end - start - moved) < 1e-12 * terms[:, None])
        assert np.all(np.abs(impulse[:, 1]) <= impacts["friction"] * impulse[:, 0] * (1.0 + 1e-12))
        before = 0.5 * np.einsum("ki,kij,kj->k", start, np.linalg.inv(matrix), start)
        assert np.all(found.energy_change <= 1e-12 * before)
        assert np.all(found.velocity_normal >= 0.0)
        np.testing.assert_allclose(found.phase_impulse.sum(-1), found.impulse_normal, rtol=1e-13)
        compressive = found.compressive_work[0]
        restitutive = found.restitutive_work[0]
        np.testing.assert_allclose(
            restitutive, -(impacts["restitution"] ** 2) * compressive, rtol=1e-9
        )

    def test_mirror_symmetry(self) -> None:
        impacts = random_impacts(3, 500)
        plain = energetic_impact(**impacts)
        mirror = np.array([[1.0, -1.0], [-1.0, 1.0]])
        sides = {
            "inverse_mass": impacts["inverse_mass"] * mirror,
            "velocity": impacts["velocity"] * [1.0, -1.0],
        }
        flipped = energetic_impact(**impacts | sides)
        signs = np.array([1.0, -1.0, 1.0, -1.0])
        wanted = impulse_and_velocity(plain)
        found = impulse_and_velocity(flipped) * signs
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)

    @pytest.mark.parametrize("law", [poisson_impact, newton_impact])
    def test_the_other_laws_have_no_springs(self, law) -> None:
        arguments = (np.eye(2), [-1.0, 0.5], 0.3, 0.5)
        assert (
            law(*arguments, tangential_compliance=0.0).impulse_normal
            == law(*arguments).impulse_normal
        )
        with pytest.raises(
            ValueError, match=r"^tangential_compliance = 1\.21: must be 0 in this law"
        ):
            law(*arguments, tangential_compliance=1.21)

    @pytest.mark.parametrize("value", [-0.1, math.nan, math.inf, 1.1e4, "1", True, [1.0, -1.0]])
    def test_bad_values_are_named_in_one_line(self, value) -> None:
        with pytest.raises(ValueError, match=r"^tangential_compliance = ") as refusal:
            energetic_impact(np.eye(2), [-1.0, 0.5], 0.3, 0.5, tangential_compliance=value)
        assert "\n" not in str(refusal.value)


class TestLimits:
    def test_none_is_the_rigid_law_bit_for_bit(self) -> None:
        impacts = random_impacts(5, 2000) | {"tangential_compliance": 0.0}
        rigid = energetic_impact(
            **{key: value for key, value in impacts.items() if key != "tangential_compliance"}
        )
        for same in (
            energetic_impact(**impacts),
            energetic_impact(**impacts | {"tangential_compliance": np.zeros(2000)}),
        ):
            for each in dataclasses.fields(Impact):
                np.testing.assert_array_equal(getattr(same, each.name), getattr(rigid, each.name))

    @pytest.mark.parametrize(
        "size", [200, pytest.param(20_000, marks=pytest.mark.nightly)], ids=["few", "many"]
    )
    @pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
    def test_the_rigid_law_is_reached_without_a_jump(self, e: float, size: int) -> None:
        """The stated bounds hold, 30 eta at eta^2 = 1e-4, and the impulse has no jump there nor at 0."""
        impacts = random_impacts(11, size) | {"restitution": np.full(size, e)}
        impacts["restitution_friction"] = impacts["friction"]

        def impulse(squared: float) -> np.ndarray:
            return impulse_and_velocity(
                energetic_impact(**impacts | {"tangential_compliance": squared})
            )[:, :2]

        rigid = impulse(0.0)
        least = impulse(1e-4)
        largest = abs(rigid).max(axis=-1, keepdims=True)
        assert np.all(abs(least - rigid) < 30 * 1e-2 * largest)
        # The mean is linear in eta: a change of eta^2 by 1e-12 of it, or from 0 to 1e-24, leaves 30 times that.
        assert np.all(abs(least - impulse(1e-4 * (1.0 - 1e-12))) < 1e-12 * largest)
        assert np.all(abs(rigid - impulse(1e-24)) < 30 * 1e-12 * largest)

    @pytest.mark.parametrize("e", [0.0, 0.5])
    def test_a_mean_with_the_rigid_law_keeps_cone_and_energy(self, e: float) -> None:
        """Sums of works are the change of the kinetic energy, which does not grow, and W_r = -e*^2 W_c, up to roundings of the terms."""
        impacts = random_impacts(12, 1000) | {
            "restitution": np.full(1000, e),
            "tangential_compliance": 2.5e-5,
        }
        impacts["restitution_friction"] = impacts["friction"]
        found = energetic_impact(**impacts)
        matrix = impacts["inverse_mass"]
        start = impacts["velocity"]
        impulse, end = np.split(impulse_and_velocity(found), 2, axis=-1)
        before, after = (
            0.5 * np.einsum("ki,kij,kj->k", each, np.linalg.inv(matrix), each)
            for each in (start, end)
        )
        terms = np.abs(start).sum(-1) + np.einsum("kij,kj->k", np.abs(matrix), np.abs(impulse))
        assert np.all(
            np.abs(end - start - np.einsum("kij,kj->ki", matrix, impulse)) < 1e-12 * terms[:, None]
        )
        assert np.all(np.abs(impulse[:, 1]) <= impacts["friction"] * impulse[:, 0] * (1.0 + 1e-12))
        # A correlation of 0.95 makes the energies up to twenty times the terms of which they are sums.
        np.testing.assert_allclose(found.energy_change, after - before, atol=1e-12 * before.max())
        assert np.all(found.energy_change <= 0.0)
        np.testing.assert_allclose(
            found.restitutive_work[0], -(e**2) * found.compressive_work[0], rtol=1e-9, atol=1e-14
        )

    def test_a_single_impact_is_that_of_an_array(self) -> None:
        """Bit for bit but for the order of sums in arrays, with rigid, elastic and mean impacts side by side."""
        impacts = random_impacts(13, 30)
        impacts["tangential_compliance"] = np.tile([0.0, 1e-6, 0.3], 10)
        together = impulse_and_velocity(energetic_impact(**impacts))
        for index, row in enumerate(together):
            single = energetic_impact(**{key: value[index] for key, value in impacts.items()})
            np.testing.assert_allclose(impulse_and_velocity(single), row, rtol=1e-11, atol=1e-12)

    @pytest.mark.parametrize(
        ("mu", "e", "radial", "order"),
        [
            (0.5, 0.6, False, 100.0),
            (0.25, 0.6, False, 10.0),
            (0.31, 0.42, True, 10.0),
            (0.5, 0.0, False, 10.0),
        ],
    )
    def test_orders_in_which_it_tends_to_the_rigid_point(
        self, mu: float, e: float, radial: bool, order: float
    ) -> None:
        """A hundredth of eta^2 leaves a hundredth of the difference where the point sticks, and a tenth where T must pass from edge to edge.

        That takes a time of order eta: where slip reverses, and in a radial strike. At e* = 0 it is the slip left in the swing.
        """
        slips = np.linspace(0.1, 0.4, 101)
        lever = np.array([-math.sin(GAMMA), math.cos(GAMMA)])
        matrix = np.array([[1.0, -0.45], [-0.45, 1.4]])
        start = np.stack([np.full_like(slips, -1.0), slips], axis=-1)
        matrix, start = (np.outer(lever, lever), lever[np.newaxis]) if radial else (matrix, start)
        ends = [
            energetic_impact(matrix, start, mu, e, tangential_compliance=squared)
            for squared in (0.0, 1e-2, 1e-4)
        ]
        rigid, *values = [each.impulse_normal if e else each.velocity_tangential for each in ends]
        coarse, fine = (np.abs(value - rigid).max() for value in values)
        assert coarse / fine == pytest.approx(order, rel=0.3)

    def test_a_sphere_that_sticks(self) -> None:
        """K = diag(1, 7/2), mu without bound: two sines; the normal one takes pi/2 and e* pi/2, and the tangential one goes on.

        v_t = cos(omega t), omega^2 = 3.5/eta^2, up to where N = 0; what the spring then holds is lost.
        """
        squared = 1.21
        e = 0.98
        found = energetic_impact(
            np.diag([1.0, 3.5]), [-1.0, 0.3], 1e12, e, tangential_compliance=squared
        )
        phase = math.sqrt(3.5 / squared) * 0.5 * math.pi * (1.0 + e)
        assert found.velocity_tangential == pytest.approx(0.3 * math.cos(phase), rel=1e-9)
        assert found.velocity_normal == pytest.approx(e, rel=1e-12)


class TestBristle:
    """A radial bristle, K of one degree of freedom: v = (-sin gamma, cos gamma) u, slip and compression end together."""

    @staticmethod
    def strike(mu: float, squared: float, e: float = 0.42) -> Impact:
        lever = np.array([-math.sin(GAMMA), math.cos(GAMMA)])
        return energetic_impact(np.outer(lever, lever), lever, mu, e, tangential_compliance=squared)

    def test_the_foot_slides_on_and_the_bristle_rebounds_as_without_friction(self) -> None:
        """mu > e*^2/(eta^2 tan gamma): the cone closes faster than the spring unloads, T = -mu N throughout, and u = -e*."""
        for mu in (0.34, 0.5, 1.0):
            found = self.strike(mu, 1.21)
            assert found.velocity_normal == pytest.approx(0.42 * math.sin(GAMMA), rel=1e-12)
            assert found.outcome_name == "rebound"

    def test_a_foot_that_sticks_in_restitution(self) -> None:
        """Between the edges N and T are linear in the way x, u^2 is quadratic; beyond the second edge friction opposes."""
        mu = 0.31
        squared = 1.21
        e = 0.42
        sine, cosine = math.sin(GAMMA), math.cos(GAMMA)
        most = math.sqrt(sine / (sine + mu * cosine))
        way = 2.0 * mu * most / (cosine / squared + mu * sine / e**2)
        left = most - sine / e**2 * way
        bend = (sine / e) ** 2 + cosine**2 / squared
        square = (
            2.0 * (sine + mu * cosine) * most * way
            - bend * way**2
            + (sine - mu * cosine) * left**2 * e**2 / sine
        )
        assert self.strike(mu, squared).velocity_normal == pytest.approx(
            sine * math.sqrt(square), rel=1e-12
        )

    def test_a_foot_that_holds_the_bristle_for_good(self) -> None:
        """mu >= tan gamma and a stiff spring: it swings about a balance inside the cone, and nothing ends the contact."""
        assert self.strike(0.5, 0.01).outcome_name == "stiction"

    @pytest.mark.parametrize("mu", [0.5, 1.0, 2.0])
    def test_the_impulse_of_a_bristle_that_stays_is_that_of_a_rigid_point(self, mu: float) -> None:
        """Slip stops it: sin(gamma) p_n + mu cos(gamma) p_n is its momentum. What balances afterwards moves nothing."""
        held = self.strike(mu, 0.01)
        impulse = 1.0 / (math.sin(GAMMA) + mu * math.cos(GAMMA))
        assert held.impulse_normal == pytest.approx(impulse, rel=1e-12)
        assert held.impulse_tangential == pytest.approx(-mu * impulse, rel=1e-12)
        assert held.phase_impulse[2:].tolist() == [0.0, 0.0]
        assert float(
            held.phase_work_normal.sum() + held.phase_work_tangential.sum()
        ) == pytest.approx(-0.5)


GAMMA = math.radians(23.4)


@pytest.mark.parametrize("eta2", [1e-3, 0.05, 1.21])
@pytest.mark.parametrize("restitution", [0.0, 0.42, 1.0])
def test_a_jam_ends_where_its_forces_are_in_balance(restitution: float, eta2: float) -> None:
    """A rod at gamma whose root moves at w across it. The balance K_nt v_n + K_tt v_t/eta^2 = 0 at the kept w gives the velocity,
    and the velocity the impulse along the rod's freedom. A single impact gives the numbers of the array, and the works the energy.
    """
    gamma, mu, turning, across = (
        each.ravel()
        for each in np.meshgrid([0.2, 0.6, 1.0], [1.7, 2.5, 5.0], [-1.0, 0.3], [-0.7, -0.05])
    )
    s, c = np.sin(gamma), np.cos(gamma)
    matrix = np.array([[s * s, s * c], [s * c, c * c]]).transpose(2, 0, 1)
    velocity = np.array([s * turning + c * across, c * turning - s * across]).T
    many = energetic_impact(matrix, velocity, mu, restitution, tangential_compliance=eta2)
    jams = many.outcome == OUTCOMES.index("jam")
    assert np.count_nonzero(jams) >= 10
    along = s * many.velocity_normal + c * many.velocity_tangential
    balance = across * s * c * (1.0 - eta2) / (c * c + eta2 * s * s)
    np.testing.assert_allclose(along[jams], balance[jams], atol=1e-13)
    impulse = s * many.impulse_normal + c * many.impulse_tangential
    kept = c * many.impulse_normal - s * many.impulse_tangential
    np.testing.assert_allclose(impulse[jams], (along - turning)[jams], atol=1e-12)
    gained = 0.5 * (along**2 - turning**2) + across * kept
    np.testing.assert_allclose(many.energy_change[jams], gained[jams], atol=1e-11)
    for number in np.flatnonzero(jams):
        single = energetic_impact(
            matrix[number], velocity[number], mu[number], restitution, tangential_compliance=eta2
        )
        assert single.impulse_normal == pytest.approx(many.impulse_normal[number], rel=1e-12)


def test_a_force_that_fades_slowly_ends_after_a_bounded_number_of_phases(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The root moves away 1e-5 times as fast as the rod strikes: the point swings 1e5 times and slips a little in each swing."""
    monkeypatch.setattr(impact_compliance, "MOST_IN_STICK", 300)
    add = impact_compliance.Course.add
    phases = 0

    def counted(course: impact_compliance.Course, sums: Sums, slip: float) -> None:
        nonlocal phases
        phases += 1
        assert phases < 1000
        add(course, sums, slip)

    monkeypatch.setattr(impact_compliance.Course, "add", counted)
    for angle, friction, restitution in ((0.41, 0.481, 0.6), (0.42, 0.497, 0.5)):
        phases = 0
        s, c, away = math.sin(angle), math.cos(angle), 1e-5
        velocity = [c * away - s, -c - s * away]
        found = energetic_impact(
            np.outer([s, c], [s, c]), velocity, friction, restitution, tangential_compliance=0.01
        )
        assert found.outcome_name == "rebound"
        # What is left is the root's speed; the point returns with its rod or is held by friction.
        assert c * found.velocity_normal - s * found.velocity_tangential == pytest.approx(away)


def test_one_freedom_across_its_line_jams() -> None:
    """The drift across the lever presses stiff springs without end within the cone: no impulse stops it, as in the rigid law."""
    sine, cosine = 0.5, math.sqrt(0.75)
    matrix = np.outer([-sine, cosine], [-sine, cosine])
    for squared in (0.0, 1e-4, 1e-3):
        assert (
            energetic_impact(
                matrix, [-1.0, -0.5], 1.0, 0.5, tangential_compliance=squared
            ).outcome_name
            == "jam"
        )


@pytest.mark.parametrize("e", [0.0, 1e-200, 1e-3, 1.0])
@pytest.mark.parametrize("squared", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("coupling", [0.0, 0.5, -0.9, 1.0])
@pytest.mark.parametrize("friction", [0.0, 1e-12, 0.5, 1e3, 1e150])
def test_ends_of_the_ranges(e: float, squared: float, coupling: float, friction: float) -> None:
    """Equal frequencies, the border of stick at the start (v_t = mu eta^2 |v_n|), and extremes: finite, and no energy gained."""
    matrix = np.array([[1.0, coupling], [coupling, 1.0]])
    for slip in (0.0, friction * squared if friction < 1e4 else 1.0, -0.7, 1e-9):
        for unit in (1.0, 1e-120, 1e120):
            found = energetic_impact(
                matrix * unit, [-unit, slip * unit], friction, e, tangential_compliance=squared
            )
            values = impulse_and_velocity(found)
            assert np.all(np.isfinite(values))
            terms = np.array([1.0, abs(slip)]) * unit + np.abs(matrix * unit) @ np.abs(values[:2])
            assert np.all(
                np.abs(values[2:] - [-unit, slip * unit] - matrix * unit @ values[:2])
                <= 1e-9 * terms.max()
            )
            assert (
                found.energy_change <= 1e-12 * (1.0 + abs(slip)) * np.abs(values[:2]).sum() * unit
            )
