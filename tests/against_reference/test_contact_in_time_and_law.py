"""Random strikes of chains and wires: a contact in time ends, and tends to the impact law as it gets shorter."""

from __future__ import annotations

import math

import numpy as np
import pytest

import bristle_sim as bs
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.spring import SHORTEST_SWING
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings

# durations over the time in which the fastest rod turns by a radian
LONG = 1e-4
SHORT = 1e-5

ACCURACY = 1e-8

FLOOR = 2e-7  # twenty times the accuracy: two to a dozen phases, each located and integrated to it

LARGEST = 1e-3  # hundred times the angle that the rods turn by in the short contact; K varies by as much times their number

SWINGING = 0.5 * math.pi * SHORTEST_SWING
"""Bound of the relative error of the impulse where the tangential force swings to and fro between two frictions at the deepest
point. The mean replaces faster swings, and the outcome jumps by up to a swing's impulse: a thousandth of the contact's duration at
the largest force, which is pi/2 times the mean one."""


def random_strike(number: int) -> tuple[Chain, Surface, float]:
    """Two to six rods of unlike mass and length, and every kind of surface."""
    random = np.random.default_rng([7, number])
    size = int(random.integers(2, 7))
    masses, lengths, angles, rates = (
        random.uniform(*bounds, size)
        for bounds in ((0.5, 3.0), (0.5, 1.5), (-0.9, 0.9), (-1.5, 1.5))
    )
    if (lengths * np.sin(angles)) @ rates > 0.0:
        rates = -rates
    first = float(random.choice([0.0, random.uniform()], p=[0.1, 0.9]))
    later = first if random.random() < 0.3 else float(random.uniform())
    restitution = float(random.choice([0.0, 1.0, random.uniform(0.05, 1.0)], p=[0.1, 0.2, 0.7]))
    squared = float(
        random.choice([0.0, 1.5, 10.0 ** random.uniform(-3.0, 0.17)], p=[0.35, 0.05, 0.6])
    )
    columns = (tuple(each.tolist()) for each in (masses, lengths, angles, rates))
    return Chain(*columns), Surface(first, later, restitution), squared


def inverse_mass(chain: Chain) -> np.ndarray:
    """K of the tip, (normal, tangential), from the mass matrix of slender rods."""
    masses, lengths, angles = (
        np.array(each) for each in (chain.masses, chain.lengths, chain.angles)
    )
    beyond = np.cumsum(masses[::-1])[::-1] - masses
    last = np.maximum.outer(np.arange(masses.size), np.arange(masses.size))
    matrix = (
        np.outer(lengths, lengths)
        * np.cos(np.subtract.outer(angles, angles))
        * (0.5 * masses + beyond)[last]
    )
    np.fill_diagonal(matrix, lengths**2 * (masses / 3.0 + beyond))
    rows = np.array([lengths * np.sin(angles), lengths * np.cos(angles)])
    return np.asarray(rows @ np.linalg.solve(matrix, rows.T))


def may_swing(chain: Chain, surface: Surface) -> bool:
    """Whether slip in either sense parts the point with the friction of compression, and presses it on with that of restitution."""
    (normal, coupling), _ = inverse_mass(chain).tolist()
    return (
        surface.friction_in_restitution * abs(coupling) > normal > surface.friction * abs(coupling)
    )


@pytest.mark.parametrize(
    "numbers",
    [range(8), pytest.param(range(8, 500), marks=pytest.mark.nightly)],
    ids=["few", "many"],
)
def test_chains_tend_to_the_law_in_proportion_to_the_duration(numbers: range) -> None:
    """A tenth of the duration leaves a tenth of the difference, with a third of it for the square of the duration."""
    for number in numbers:
        chain, surface, squared = random_strike(number)
        unit = 1.0 / max(map(abs, chain.rates))
        law = strike(chain, surface, Contact(tangential_compliance=squared), Settings()).contact
        timed = [
            strike(
                chain,
                surface,
                Contact("compliant", duration * unit, squared),
                Settings(accuracy=ACCURACY),
            ).contact
            for duration in (LONG, SHORT)
        ]
        longer, shorter = (
            np.abs(np.subtract(found.rates_after, law.rates_after)).max() * unit for found in timed
        )
        if squared and may_swing(chain, surface):
            missed = np.hypot(*np.subtract(timed[1].impulse, law.impulse))
            assert missed < SWINGING * np.hypot(*law.impulse), number
        else:
            assert shorter < min(0.13 * longer + FLOOR, LARGEST), number


def random_wire(number: int) -> bs.Tool:
    """A wire of two to twelve links that bends, on a workpart of any friction and restitution."""
    random = np.random.default_rng([11, number])
    first = float(random.uniform(0.0, 0.8))
    later = first if random.random() < 0.5 else float(random.uniform(0.0, 0.8))
    restitution = float(random.choice([0.0, 1.0, random.uniform(0.1, 1.0)], p=[0.1, 0.2, 0.7]))
    return bs.Tool(
        bristle=bs.Bristle(links=int(random.integers(2, 13))),
        bar=None,
        workpart=bs.Workpart(friction=first, restitution_friction=later, restitution=restitution),
        contact=bs.Contact(
            "compliant", float(10.0 ** random.uniform(-4.5, -3.5)), float(random.uniform(0.0, 1.5))
        ),
    )


@pytest.mark.parametrize(
    "numbers",
    [range(2), pytest.param(range(2, 300), marks=pytest.mark.nightly)],
    ids=["few", "many"],
)
def test_strikes_of_wires_that_bend_end_and_gain_no_energy(numbers: range) -> None:
    """Thrown from 0.7 rad behind: the first contact is over, and the surface has done no work on the wire but took some."""
    for number in numbers:
        tool = random_wire(number)
        found = bs.simulate(
            tool,
            Settings(accuracy=1e-5, hub_turn=1.6),
            start_hub_angle=-math.radians(23.447) - 0.21,
            start_relative_angle=-0.7,
            start_relative_rate=877.0,
            stop_after="workpart release",
        )
        assert found.stop_reason == "requested event", (number, found.stop_reason)
        contact = found.first_contact("workpart")
        assert contact.restitutive_work is not None
        taken = contact.compressive_work[0] + contact.compressive_work[1]
        assert taken + sum(contact.restitutive_work) < 1e-5 * abs(taken), number
