"""Contacts resolved in time against a march of the same equations in many small steps, which knows no events.

The march shares no code with the scene: absolute angles, mass matrix from Lagrange's equations, leapfrog steps, and in
each step the tangential force that would stop the tip, cut to friction's limit. Whether the tip slips, sticks or reverses
follows from that; nothing is located.
"""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactHistory, ContactRecord

Array = NDArray[np.float64]

BREAKING = Chain((1.0, 1.0), (1.0, 1.0), (0.35, 0.52), (-4.0, -8.0))
"""Its tip sticks in restitution, until close to separation the rods' own turning asks for more than friction gives."""

JAMMED = Chain((0.5,), (0.7,), (0.65,), (2.9,), 0.9, 5.9, -0.5)
"""A rod whose hub brings its root down on it: a jam for a contact without duration, not for one of 20 ms."""


class Marched:
    """The march: many chains of equally many rods at once, each array with one row a chain."""

    def __init__(self, chains: list[Chain], surfaces: list[Surface], stiffness: Array) -> None:
        self.masses, self.lengths, self.angles, self.rates = (
            np.array([getattr(chain, name) for chain in chains]) for name in ("masses", "lengths", "angles", "rates")
        )
        self.radius, self.turning, self.start = (
            np.array([getattr(chain, name) for chain in chains]) for name in ("hub_radius", "hub_speed", "hub_angle")
        )
        self.friction, self.later, self.restitution = (
            np.array([getattr(surface, name) for surface in surfaces])
            for name in ("friction", "friction_in_restitution", "restitution")
        )
        self.stiffness = stiffness
        beyond = np.cumsum(self.masses[:, ::-1], axis=1)[:, ::-1] - self.masses
        rods = np.arange(self.masses.shape[1])
        outer = np.maximum(rods[:, None], rods[None, :])
        self.coupling = self.lengths[:, :, None] * self.lengths[:, None, :] * (0.5 * self.masses + beyond)[:, outer]
        self.coupling[:, rods, rods] = self.lengths**2 * (self.masses / 3.0 + beyond)
        self.carried = self.lengths * (0.5 * self.masses + beyond)
        self.time = np.zeros(len(chains))
        self.height = self._tip_height(self.angles, self.time)
        self.impulse = np.zeros((len(chains), 2))
        self.loading, self.left = np.ones(len(chains), dtype=bool), np.zeros(len(chains), dtype=bool)
        self.peak = np.zeros(len(chains))

    def go(self, durations: Array, steps: int) -> None:
        """March until all tips have left, in so many steps of each given duration and a few more."""
        for _ in range(steps + steps // 50):
            step = np.where(self.left, 0.0, durations / steps)
            self._step(step, durations / steps)
            if self.left.all():
                return

    def _tip_height(self, angles: Array, time: Array) -> Array:
        hub = self.start + self.turning * time
        return np.asarray(-(self.lengths * np.cos(angles)).sum(axis=1) - self.radius * np.cos(hub))

    def _step(self, step: Array, length: Array) -> None:
        middle, time = self.angles + 0.5 * step[:, None] * self.rates, self.time + 0.5 * step
        residual = np.where(self.loading, 0.0, (1.0 - self.restitution**2) * self.peak)
        stiffness = np.where(self.loading, self.stiffness, self.stiffness / self.restitution**2)
        normal = np.maximum(stiffness * (self.height - self._tip_height(middle, time) - residual), 0.0)
        limit = np.where(self.loading, self.friction, self.later) * normal
        across, up = self.lengths * np.cos(middle), self.lengths * np.sin(middle)
        hub = self.start + self.turning * time
        root = self.turning**2 * self.radius * np.array([-np.sin(hub), np.cos(hub)])
        slip = (across * self.rates).sum(axis=1) + self.turning * self.radius * np.cos(hub)
        turned = middle[:, :, None] - middle[:, None, :]
        mean = self.rates
        for _ in range(2):  # the second time with the rates in the middle of the step
            load = -np.einsum("cij,cj->ci", self.coupling * np.sin(turned), mean**2)
            load -= self.carried * (np.cos(middle) * root[0][:, None] + np.sin(middle) * root[1][:, None])
            columns = np.stack([load + up * normal[:, None], across], axis=-1)
            solved = np.linalg.solve(self.coupling * np.cos(turned), columns)
            gain = slip / length + (across * solved[..., 0] - up * mean**2).sum(axis=1) + root[0]
            tangential = np.clip(-gain / (across * solved[..., 1]).sum(axis=1), -limit, limit)
            change = step[:, None] * (solved[..., 0] + solved[..., 1] * tangential[:, None])
            mean = self.rates + 0.5 * change
        self.rates = self.rates + change
        self.angles, self.time = middle + 0.5 * step[:, None] * self.rates, self.time + step
        self.impulse += step[:, None] * np.stack([normal, tangential], axis=1)
        self._turn()

    def _turn(self) -> None:
        depth = self.height - self._tip_height(self.angles, self.time)
        hub = self.start + self.turning * self.time
        away = (self.lengths * np.sin(self.angles) * self.rates).sum(axis=1) + self.turning * self.radius * np.sin(hub)
        ends = self.loading & (away >= 0.0) & ~self.left
        self.left |= ~self.loading & (depth <= (1.0 - self.restitution**2) * self.peak)
        reloads = ~self.loading & (depth > self.peak)
        self.peak = np.where(ends, depth, self.peak)
        self.loading = (self.loading & ~ends) | reloads


def found(chain: Chain, surface: Surface, duration: float | None, accuracy: float = 1e-7) -> ContactRecord:
    return strike(chain, surface, Contact("compliant", duration), Settings(accuracy=accuracy)).contact


def history(record: ContactRecord) -> ContactHistory:
    assert record.history is not None
    return record.history


def random_cases(links: int, count: int) -> list[tuple[Chain, Surface, float]]:
    """Chains that approach at 0.5 or more, every other one on a turning hub; contacts of 1 to 60 ms at some 10 rad/s."""
    random, cases = np.random.default_rng(links), []
    while len(cases) < count:
        masses, lengths = np.exp(random.uniform(-1.0, 1.0, (2, links)))
        angles, rates = random.uniform(-1.2, 1.2, links), random.uniform(-10.0, 10.0, links)
        hub = (random.uniform(0.1, 1.5), random.uniform(-8.0, 8.0), random.uniform(-1.0, 1.0))
        chain = Chain(*(tuple(map(float, each)) for each in (masses, lengths, angles, rates)), *hub[: 3 * (links % 2)])
        friction, restitution = math.exp(random.uniform(-2.0, 1.0)), random.uniform(0.2, 1.0)
        duration = 10.0 ** random.uniform(-3.0, -1.2)
        approach = (lengths * np.sin(angles) * rates).sum()
        approach += chain.hub_radius * chain.hub_speed * math.sin(chain.hub_angle)
        if approach < -0.5:
            cases.append((chain, Surface(friction, None, restitution), duration))
    return cases


STEPS = 4000


class TestAgainstTheMarch:
    @pytest.mark.parametrize("links", [1, 2, 3])
    def test_random_chains(self, links: int) -> None:
        """The march switches friction at the end of a step: up to pi/2 steps of the peak force late, two or three times.

        One impulse changes rates by twice the fastest or so: 1.5e-3 of it are four to five steps of 4000.
        """
        cases = random_cases(links, 20)
        records = [found(*case) for case in cases]
        kept = [i for i, record in enumerate(records) if record.outcome == "rebound"]
        assert len(kept) > 10
        stiffness = [history(records[i]).normal_force[1] / history(records[i]).penetration[1] for i in kept]
        march = Marched([cases[i][0] for i in kept], [cases[i][1] for i in kept], np.array(stiffness))
        march.go(np.array([records[i].duration for i in kept]), STEPS)
        assert march.left.all()
        for i, rates, impulse in zip(kept, march.rates, march.impulse, strict=True):
            scale = np.abs([*records[i].rates_before, *records[i].rates_after]).max()
            np.testing.assert_allclose(records[i].rates_after, rates, rtol=0.0, atol=1.5e-3 * scale)
            np.testing.assert_allclose(records[i].impulse, impulse, rtol=0.0, atol=1.5e-3 * np.abs(impulse).max())

    def test_a_jam_of_the_rigid_law_that_the_spring_gets_out_of(self) -> None:
        surface = Surface(3.0, None, 0.9)
        assert strike(JAMMED, surface, Contact(), Settings()).contact.outcome == "jam"
        record = found(JAMMED, surface, 0.02)
        assert record.outcome == "rebound"
        assert "compression stick" in record.phases
        march = Marched([JAMMED], [surface], history(record).normal_force[1:2] / history(record).penetration[1:2])
        march.go(np.array([record.duration]), STEPS)
        assert march.left.all()
        assert record.rates_after[0] == pytest.approx(march.rates[0, 0], rel=1e-3)
        assert record.impulse == pytest.approx(tuple(march.impulse[0]), rel=1e-3)

    def test_a_jam_that_lasts_stays_one(self) -> None:
        """Ten times 0.1 ms later the hub's root has hardly moved on: the record ends where the tip stuck."""
        record = found(JAMMED, Surface(3.0, None, 0.9), 1e-4)
        limit = strike(JAMMED, Surface(3.0, None, 0.9), Contact(), Settings()).contact
        assert record.outcome == limit.outcome == "jam"
        assert record.phases == (*limit.phases[:1], "compression stick")
        # The hub turns by 6e-4 in a duration, and a rod at its rates by as much.
        assert record.impulse == record.compressive_impulse == pytest.approx(limit.impulse, rel=1e-3)


class TestStickThatBreaks:
    @pytest.mark.parametrize("accuracy", [1e-4, 1e-5, 1e-6, 1e-8, 1e-10])
    def test_at_every_accuracy(self, accuracy: float) -> None:
        """7.88645 rad/s by an event-driven integration and by brute force, neither of this project."""
        record = found(BREAKING, Surface(1.5, None, 0.5), 3e-2, accuracy)
        assert record.rates_after[1] == pytest.approx(7.88645, abs=5e-6 + 8.0 * accuracy)
        assert record.phases == ("compression slip", "restitution slip", "restitution stick", "restitution slip")

    @pytest.mark.parametrize("links", [1, 2, 3])
    def test_the_force_stays_within_the_friction_cone(self, links: int) -> None:
        """But for the accuracy, 1e-7, to which the instant is located where stick ends: ten times that of the peak."""
        for chain, surface, duration in random_cases(links, 15):
            course = history(found(chain, surface, duration))
            excess = np.abs(course.tangential_force) - surface.friction * course.normal_force
            assert excess.max() <= 1e-6 * course.normal_force.max()
