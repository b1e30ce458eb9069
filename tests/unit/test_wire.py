"""Frequencies of a bending wire: limits of the beam equation, the printed wire, and the chain's convergence to the beam."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.parameters import Tool
from bristle_sim.theory.wire import (
    beam_frequencies,
    chain_frequencies,
    hinge_damping,
    hinge_stiffness,
)

TOOL = Tool()
WIRE = (TOOL.bristle.mass, TOOL.bristle.length, TOOL.bristle.wire_diameter, TOOL.bristle.modulus)
BELT = TOOL.belt.stiffness


def wave_numbers(root_stiffness: float, modes: int) -> np.ndarray:
    """lambda of each mode, from omega = lambda^2 sqrt(E I_a/(m L^3))."""
    mass, length, diameter, modulus = WIRE
    scale = math.sqrt(modulus * math.pi * diameter**4 / 64.0 / (mass * length**3))
    return np.sqrt(math.tau * beam_frequencies(*WIRE, root_stiffness, modes) / scale)


def test_a_hinged_root_without_spring() -> None:
    """tan = tanh has the roots 0, 3.926602, 7.068583 (Blevins, table 8-1: hinged-free)."""
    assert wave_numbers(0.0, 3) == pytest.approx([0.0, 3.926602, 7.068583], abs=1e-6)


def test_a_rigid_root() -> None:
    """A cantilever, 1.875104, 4.694091, 7.854757; a spring of 1e9 N m/rad is 1e7 times as stiff as the wire."""
    assert wave_numbers(1e9, 3) == pytest.approx([1.875104, 4.694091, 7.854757], abs=1e-6)


def test_the_bristle_on_its_belt() -> None:
    """165.962, 3062.10 and 9824.7 Hz, worked out apart from the program."""
    assert beam_frequencies(*WIRE, BELT, 3) == pytest.approx([165.962, 3062.10, 9824.7], rel=5e-6)


@pytest.mark.parametrize("stiffness", [1e-10, 1e-13, 1e-25, 1e-60])
def test_a_soft_root_swings_a_rigid_rod(stiffness: float) -> None:
    """sqrt(k/I)/(2 pi) up to parts of order k L/(E I_a), here at most 1.1e-9, and rounding of the beam equation, 1e-9."""
    rigid = math.sqrt(stiffness / (WIRE[0] * WIRE[1] ** 2 / 3.0)) / math.tau
    assert beam_frequencies(*WIRE, stiffness, 1)[0] == pytest.approx(rigid, rel=3e-9, abs=0.0)


@pytest.mark.parametrize("function", [beam_frequencies, chain_frequencies])
def test_the_ends_of_all_ranges_give_finite_numbers(function: Callable) -> None:
    """Mass, kg, length, m, diameter, m, modulus, Pa, and root stiffness, N m/rad."""
    ends = ((1e-30, 1e6), (1e-9, 1e3), (1e-30, 1e2), (1e-30, 1e15), (0.0, 1e9))
    for values in itertools.product(*ends):
        assert np.all(np.isfinite(function(*values, 3)))


def test_two_links_by_hand() -> None:
    """det(K - omega^2 M) = 0 of two rods of m/2 and L/2: M = (m l^2/2) ((4/3, 1/2), (1/2, 1/3)), spring k between them."""
    mass, length = WIRE[:2]
    spring = hinge_stiffness(WIRE[2], length, WIRE[3], 2)
    half = mass / 2.0 * (length / 2.0) ** 2
    a, b, c = (
        half**2 * (4.0 / 9.0 - 0.25),
        half * (4.0 / 3.0 + 1.0 + 1.0 / 3.0) * spring + half / 3.0 * BELT,
        spring * BELT,
    )
    root = math.sqrt(b**2 - 4.0 * a * c)
    expected = [
        math.sqrt(2.0 * c / (b + root)) / math.tau,
        math.sqrt((b + root) / (2.0 * a)) / math.tau,
    ]
    assert chain_frequencies(*WIRE, BELT, 2) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(
    ("links", "expected"), [(8, (167.14, 3060.6, 9813.0)), (16, (166.57, 3061.9, 9823.0))]
)
def test_the_chain_at_rest(links: int, expected: tuple[float, ...]) -> None:
    """To the digits that are known of it from another program."""
    found = chain_frequencies(*WIRE, BELT, links)[:3]
    assert np.all(np.abs(found - expected) <= (5e-3, 5e-2, 0.5))


def test_damping_of_a_hinge() -> None:
    """2 zeta k/omega_1, omega_1 of the first bending mode on the belt (Rayleigh)."""
    omega = math.tau * beam_frequencies(*WIRE, BELT, 2)[1]
    stiffness = hinge_stiffness(WIRE[2], WIRE[1], WIRE[3], 8)
    assert hinge_damping(*WIRE, BELT, 0.02, 8) == pytest.approx(0.04 * stiffness / omega, rel=1e-14)


def test_a_thread_without_bending_stiffness_has_no_damping() -> None:
    assert hinge_damping(1e-4, 0.03, 0.0, 2e11, BELT, 0.02, 8) == 0.0
