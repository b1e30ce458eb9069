"""Forces of sustained contacts on a wire of links, which of them act, and impacts.

A sustained contact c keeps its gap closed with a force N_c >= 0; it slips with friction -mu sign(v_t) N_c, or sticks with a
force T_c inside the friction cone. Accelerations and forces solve

    M theta'' - sum_c (J_n + f_c J_t)^T N_c - sum_stick J_t^T T_c = forces,    J_n theta'' = -bias_n,    J_t theta'' = -bias_t,

with f_c = -mu sign(v_t) in slip and 0 in stick. Which contacts act, and how, is the complementarity problem that every
contact either pushes or opens; there are few of them, so all combinations are tried.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.reference.chain_contact import Touch
from bristle_sim.theory.impact import Impact, energetic_impact

__all__ = ["Balance", "acting", "balance", "closed", "freedom", "resolve"]

Reals = NDArray[np.float64]

STICK = 0


class Balance(NamedTuple):
    """Accelerations, rad/s^2, and the normal and tangential forces of the contacts, N."""

    accelerations: Reals
    normal: Reals
    tangential: Reals


def balance(mass: Reals, forces: Reals, touches: Sequence[Touch], frictions: Sequence[float], slips: Sequence[int]) -> Balance:
    """Solve for accelerations and contact forces; ``slips`` are the signs of v_t, 0 for a contact that sticks."""
    size, count = len(forces), len(touches)
    if not count:
        return Balance(np.linalg.solve(mass, forces), np.zeros(0), np.zeros(0))
    sticking = [index for index, slip in enumerate(slips) if slip == STICK and frictions[index] > 0.0]
    ratios = [-friction * slip for friction, slip in zip(frictions, slips, strict=True)]
    pushed = [touch.normal_row + ratio * touch.tangential_row for touch, ratio in zip(touches, ratios, strict=True)]
    pushed += [touches[index].tangential_row for index in sticking]
    rows = [touch.normal_row for touch in touches] + [touches[index].tangential_row for index in sticking]
    biases = [touch.bias[0] for touch in touches] + [touches[index].bias[1] for index in sticking]
    matrix = np.zeros((size + len(rows), size + len(rows)))
    matrix[:size, :size], matrix[:size, size:], matrix[size:, :size] = mass, -np.transpose(pushed), rows
    found = np.linalg.solve(matrix, np.concatenate([forces, np.negative(biases)]))
    normal = found[size : size + count]
    tangential = np.asarray(ratios) * normal
    tangential[sticking] = found[size + count :]
    return Balance(found[:size], normal, tangential)


def acting(
    mass: Reals, forces: Reals, touches: Sequence[Touch], frictions: Sequence[float], still: float
) -> tuple[tuple[int, int], ...] | None:
    """Return which closed contacts stay closed, as (index, sign of slip), or None if no combination is consistent.

    Args:
        mass, forces: of the links.
        touches: the contacts that are closed and do not open with a velocity.
        frictions: Coulomb's mu of each.
        still: tangential velocity below which a contact may stick, m/s.
    """
    options: list[tuple[int | None, ...]] = []
    for touch, friction in zip(touches, frictions, strict=True):
        sense = int(np.sign(touch.velocity[1]))
        may_stick = friction > 0.0 and abs(touch.velocity[1]) <= still
        options.append(((STICK, 1, -1) if may_stick else (sense or 1,)) + (None,))
    for modes in itertools.product(*options):
        chosen = tuple((index, mode) for index, mode in enumerate(modes) if mode is not None)
        if _consistent(mass, forces, touches, frictions, chosen, still):
            return chosen
    return None


def _consistent(
    mass: Reals,
    forces: Reals,
    touches: Sequence[Touch],
    frictions: Sequence[float],
    chosen: Sequence[tuple[int, int]],
    still: float,
) -> bool:
    """Whether every chosen contact pushes within its friction cone and every other one opens."""
    held = [touches[index] for index, _ in chosen]
    rubs, slips = [frictions[index] for index, _ in chosen], [slip for _, slip in chosen]
    found = balance(mass, forces, held, rubs, slips)
    if (found.normal < 0.0).any():
        return False
    for number, (index, slip) in enumerate(chosen):
        touch = touches[index]
        sliding = touch.tangential_row @ found.accelerations + touch.bias[1]
        if slip == STICK and rubs[number] and abs(found.tangential[number]) > rubs[number] * found.normal[number]:
            return False
        if slip != STICK and rubs[number] and abs(touch.velocity[1]) <= still and slip * sliding < 0.0:
            return False
    indices = {index for index, _ in chosen}
    others = (touch for index, touch in enumerate(touches) if index not in indices)
    return all(touch.normal_row @ found.accelerations + touch.bias[0] >= 0.0 for touch in others)


def freedom(mass: Reals, touch: Touch, ratio: float) -> float:
    """Return J_n M^-1 (J_n + f J_t)^T, 1/kg; where it is not positive, friction locks the contact."""
    return float(touch.normal_row @ np.linalg.solve(mass, touch.normal_row + ratio * touch.tangential_row))


def resolve(mass: Reals, touch: Touch, friction: float, restitution: float, later: float) -> tuple[Reals, Impact]:
    """Return the change of the links' rates in an energetic impact, rad/s, and the impact."""
    rows = np.array([touch.normal_row, touch.tangential_row])
    response = np.linalg.solve(mass, rows.T)
    inverse_mass = rows @ response
    hit = energetic_impact(0.5 * (inverse_mass + inverse_mass.T), touch.velocity, friction, restitution, later)
    impulse = np.array([hit.impulse_normal, hit.impulse_tangential], dtype=float)
    return np.asarray(response @ impulse), hit


def closed(mass: Reals, touches: Sequence[Touch]) -> tuple[Reals, Reals]:
    """Return the smallest changes of angles and rates, in the metric of the mass, that close gaps and stop their opening."""
    rows = np.array([touch.normal_row for touch in touches])
    response = np.linalg.solve(mass, rows.T)
    amounts = np.array([[touch.gap, touch.velocity[0]] for touch in touches])
    changes = -response @ np.linalg.solve(rows @ response, amounts)
    return changes[:, 0], changes[:, 1]
