"""Forces of sustained contacts on a wire of links, and the choice of the contacts that act.

A sustained contact c keeps its gap closed with a force N_c >= 0. It slips with friction -mu
sign(v_t) N_c, or sticks with a force T_c inside the friction cone. Accelerations and forces solve

    M theta'' - sum_c (J_n + f_c J_t)^T N_c - sum_stick J_t^T T_c = forces,    J_n theta'' = -bias_n,    J_t theta'' = -bias_t,

with f_c = -mu sign(v_t) in slip and 0 in stick. Every contact either pushes or opens. This is a
complementarity problem; contacts are few, so all combinations of stick, slip and opening are tried.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.reference.contacts import Touch

STICK = 0

# Distance from the edge of the friction cone, as a fraction of the largest friction force, from
# which a contact slips: there stick and slip differ by rounding error.
EDGE = 1e-10


class Acting(NamedTuple):
    """A closed contact with its kinematics, its friction and the forces of its springs.

    Attributes:
        touch: kinematics of the contact.
        friction: Coulomb's coefficient of friction.
        slip: sign of the slip; 0 in stick.
        push: force of the normal spring, N; None for a rigid contact.
        rub: force of the tangential spring, N; None without a tangential spring.
    """

    touch: Touch
    friction: float
    slip: int
    push: float | None = None
    rub: float | None = None

    @property
    def sticks(self) -> bool:
        """Whether a static friction force must be found for the contact.

        If the normal force of a rigid contact alone keeps a single link at rest, no friction is
        needed for that.
        """
        if self.slip != STICK or self.friction <= 0.0 or self.rub is not None:
            return False
        rows = np.abs([self.touch.normal_row, self.touch.tangential_row])
        return self.push is not None or int(np.count_nonzero(rows.sum(axis=0))) > 1

    @property
    def ratio(self) -> float:
        """Ratio of the tangential to the normal force in slip, -friction times the slip's sign."""
        return -self.friction * self.slip


class Balance(NamedTuple):
    """Accelerations of the links, rad/s^2, and normal and tangential forces of the contacts, N."""

    accelerations: Array
    normal: Array
    tangential: Array


def balance(mass: Array, forces: Array, contacts: Sequence[Acting]) -> Balance:
    """Return the accelerations and the contact forces that solve the equations of motion."""
    size = len(forces)
    known = np.array(forces, dtype=float)
    rigid = [each for each in contacts if each.push is None]
    sticking = [each for each in contacts if each.sticks]
    for each in contacts:
        if each.push is not None:
            rub = each.ratio * each.push if each.rub is None else each.rub
            known += each.push * each.touch.normal_row + rub * each.touch.tangential_row
    across = [each.touch.normal_row for each in rigid]
    along = [each.touch.tangential_row for each in sticking]
    pushed = [each.touch.normal_row + each.ratio * each.touch.tangential_row for each in rigid]
    biases = [each.touch.bias[0] for each in rigid] + [each.touch.bias[1] for each in sticking]
    matrix = np.zeros((size + len(biases), size + len(biases)))
    matrix[:size, :size] = mass
    matrix[size:, :size] = np.reshape([*across, *along], (-1, size))
    matrix[:size, size:] = -np.reshape([*pushed, *along], (-1, size)).T
    found = np.linalg.solve(matrix, np.concatenate([known, np.negative(biases)]))
    pushes = iter(found[size : size + len(rigid)])
    pulls = iter(found[size + len(rigid) :])
    normal = [next(pushes) if each.push is None else each.push for each in contacts]
    tangential = [
        next(pulls) if each.sticks else each.ratio * push if each.rub is None else each.rub
        for each, push in zip(contacts, normal, strict=True)
    ]
    return Balance(found[:size], np.array(normal), np.array(tangential))


def acting(
    mass: Array, forces: Array, contacts: Sequence[Acting], still: float
) -> tuple[tuple[int, int], ...] | None:
    """Return the closed contacts that stay closed, with stick or slip of each of them.

    All combinations of stick, slip and opening are tried. The result is None if no combination
    obeys the equations and Coulomb's law.

    Args:
        mass: mass matrix of the links, kg m^2.
        forces: generalized forces on the links, N m.
        contacts: closed contacts without an opening velocity. The function determines the sense of
            their slip.
        still: tangential velocity below which a contact may stick, m/s.

    Returns:
        For each contact that stays closed its index and the sign of its slip, 0 for stick.
    """
    options: list[tuple[int | None, ...]] = []
    for each in contacts:
        may_stick = each.friction > 0.0 and abs(each.touch.velocity[1]) <= still
        slips = (STICK, 1, -1) if may_stick else (int(np.sign(each.touch.velocity[1])) or 1,)
        slips = slips if each.rub is None else (each.slip,)
        options.append(slips if each.push is not None else (*slips, None))
    for modes in itertools.product(*options):
        chosen = {
            i: contacts[i]._replace(slip=mode) for i, mode in enumerate(modes) if mode is not None
        }
        if _consistent(mass, forces, contacts, chosen, still):
            return tuple((i, each.slip) for i, each in chosen.items())
    return None


def _consistent(
    mass: Array, forces: Array, contacts: Sequence[Acting], chosen: dict[int, Acting], still: float
) -> bool:
    """Return whether a combination of closed and opening contacts obeys the equations of motion.

    Every contact in ``chosen`` must push, with a force within its friction cone. All other contacts
    must open.
    """
    try:
        found = balance(mass, forces, tuple(chosen.values()))
    except np.linalg.LinAlgError:  # more contacts than the links can keep closed
        return False
    others = (each.touch for i, each in enumerate(contacts) if i not in chosen)
    if any(touch.normal_row @ found.accelerations + touch.bias[0] < 0.0 for touch in others):
        return False
    pushes = zip(chosen.values(), found.normal, found.tangential, strict=True)
    rigid = [(each, normal, tangential) for each, normal, tangential in pushes if each.rub is None]
    return all(
        _in_cone(mass, *each) and _slips_on(mass, forces, found.accelerations, each[0], still)
        for each in rigid
    )


def _in_cone(mass: Array, each: Acting, normal: float, tangential: float) -> bool:
    """Return whether the forces of a contact obey Coulomb's law.

    A rigid contact must push, and friction must not lock it. The force of a sticking contact must
    be within the friction cone.
    """
    if each.push is None and (
        normal < 0.0 or (each.slip and normal_response(mass, each.touch, each.ratio) <= 0.0)
    ):
        return False
    return not each.sticks or abs(tangential) <= (1.0 - EDGE) * each.friction * normal


def _slips_on(mass: Array, forces: Array, accelerations: Array, each: Acting, still: float) -> bool:
    """Return whether the tangential acceleration of a contact agrees with its assumed slip.

    A contact that begins to slip must accelerate in the sense of its slip. A contact that rests
    without a friction force must not accelerate. All other contacts agree.
    """
    if each.sticks or not each.friction or abs(each.touch.velocity[1]) > still:
        return True
    terms = (*each.touch.tangential_row * accelerations, each.touch.bias[1])
    cancelled = each.touch.tangential_row * np.linalg.solve(mass, forces)
    rounding = EDGE * float(np.abs([*terms, *cancelled]).max())
    begins = float(sum(terms))
    return each.slip * begins >= -rounding if each.slip else abs(begins) <= rounding


def normal_response(mass: Array, touch: Touch, ratio: float) -> float:
    """Return the normal acceleration of a contact per unit normal force, with friction, 1/kg.

    It is J_n M^-1 (J_n + f J_t)^T, with the rows J_n and J_t of ``touch``, the mass matrix M and
    the ratio f of the tangential to the normal force. If it is not positive, friction locks the
    contact.
    """
    return float(
        touch.normal_row @ np.linalg.solve(mass, touch.normal_row + ratio * touch.tangential_row)
    )


def closed(mass: Array, touches: Sequence[Touch]) -> tuple[Array, Array]:
    """Return the smallest changes of angles and rates that close gaps and stop their opening.

    The changes are smallest in the norm of the mass matrix.
    """
    rows = np.array([touch.normal_row for touch in touches])
    response = np.linalg.solve(mass, rows.T)
    amounts = np.array([[touch.gap, touch.velocity[0]] for touch in touches])
    changes = -response @ np.linalg.solve(rows @ response, amounts)
    return changes[:, 0], changes[:, 1]
