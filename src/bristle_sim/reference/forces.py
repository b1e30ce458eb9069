"""Sustained contacts on wires of links, their forces, and the choice of those that stay closed.

A sustained contact c keeps its gap closed with a normal force N_c >= 0. It slips with the friction
force -mu sign(v_t) N_c, or sticks with a tangential force abs(T_c) <= mu N_c. With the mass matrix
M and the rows J_n, J_t and biases of ``contacts``, accelerations and forces solve

    M theta'' - sum_c (J_n + f_c J_t)^T N_c - sum_stick J_t^T T_c = forces,    J_n theta'' = -bias_n,    J_t theta'' = -bias_t,

with f_c = -mu sign(v_t) in slip and 0 in stick. Every contact either pushes or opens. This is a
complementarity problem. Since contacts are few, all combinations of stick, slip and opening are
tried.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface
from bristle_sim.reference.contacts import Point, Touch
from bristle_sim.theory.contact_spring import ContactSpring

STICK = 0

# Distance from the edge of the friction cone, as a fraction of the largest friction force, within
# which a contact slips. At this distance stick and slip differ by rounding error.
EDGE = 1e-10


class Acting(NamedTuple):
    """A closed contact: its kinematics, its friction and the forces of its springs.

    Attributes:
        touch: kinematics of the contact.
        friction: Coulomb's coefficient of friction.
        slip: sign of the slip velocity; 0 in stick.
        push: force of the normal spring, N; None for a contact that is rigid in this direction.
        rub: force of the tangential spring, N; None without a tangential spring.
    """

    touch: Touch
    friction: float
    slip: int
    push: Any = None
    rub: Any = None

    @property
    def sticks(self) -> bool:
        """Whether the contact sticks, so that its friction force is an unknown of the equations.

        A rigid contact on a single link has no such unknown: the normal force alone keeps the link
        at rest.
        """
        if self.slip != STICK or self.friction <= 0.0 or self.rub is not None:
            return False
        moved = self.touch.rows.reshape(-1, self.touch.rows.shape[-1]).any(axis=0)
        return self.push is not None or int(np.count_nonzero(moved)) > 1

    @property
    def ratio(self) -> float:
        """Ratio of the tangential to the normal force in slip: -friction times the slip's sign."""
        return -self.friction * self.slip


class Balance(NamedTuple):
    """Solution of the equations of motion at one instant, or at n instants along a first axis.

    Attributes:
        accelerations: angular accelerations of the links, rad/s^2.
        pushes: (normal, tangential) force of each contact (N), shape (..., contacts, 2).
    """

    accelerations: Array
    pushes: Array


class State(NamedTuple):
    """The state of all links: time (s), absolute angles (rad) and angular velocities (rad/s).

    In the state at n instants the arrays have a first axis of n instants.
    """

    time: Any
    angles: Array
    rates: Array


@dataclass(slots=True, eq=False)
class Sustained:
    """A sustained contact. It is rigid unless it belongs to the subclass ``Compliant``.

    Attributes:
        point: point of the wire at which the contact acts.
        surface: coefficients of friction and restitution.
        since: state at the start of the contact.
        velocity_before: (normal, tangential) contact velocity at the start, m/s.
        slip: sign of the slip velocity; 0 in stick.
        sums: normal and tangential impulse (N s), and normal and tangential work (J), so far.
        compression: value of ``sums`` at the end of compression. None during compression, and for a
            rigid contact.
    """

    point: Point
    surface: Surface
    since: State
    velocity_before: Array
    slip: int = 0
    sums: Array = field(default_factory=lambda: np.zeros(4))
    compression: Array | None = None

    @property
    def friction(self) -> float:
        """Coulomb's coefficient of friction in the present phase of the contact."""
        return self.surface.friction

    def acting(self, touch: Touch) -> Acting:
        """Return the contact with its kinematics and friction.

        ``touch`` is the kinematics at the present instant.
        """
        return Acting(touch, self.friction, self.slip)


@dataclass(slots=True, eq=False, kw_only=True)
class Compliant(Sustained):
    """A sustained contact with a normal spring and, if the law has one, a tangential spring.

    Attributes:
        law: force law of the springs in the present phase.
        level: gap at which the contact began, m. Penetration is measured from this gap. The gap is
            negative if the contact began in the dent that an earlier contact has left.
        anchor: coordinate of the tangential spring's foot along the surface while it sticks, m. The
            foot is the end of the spring at the workpart.
    """

    law: ContactSpring
    level: float
    anchor: float

    @property
    def friction(self) -> float:
        """Coulomb's coefficient of friction: that of restitution while the spring unloads."""
        return self.law.coefficient

    @property
    def steepest(self) -> float:
        """Largest stiffness of the contact's springs in any phase, N/m."""
        law = self.law
        return law.stiffness / min(1.0, law.restitution**2 or 1.0, law.compliance or 1.0)

    def acting(self, touch: Touch) -> Acting:
        """Return the contact with its kinematics and the forces of its springs."""
        return Acting(touch, self.friction, self.slip, self.force(touch.gap), self.rub(touch))

    def force(self, gap: Any) -> Any:
        """Return the normal force (N) at a gap (m) from the original surface."""
        return self.law.normal_force(self.level - gap)

    def rub(self, touch: Touch) -> Any:
        """Return the force of the tangential spring, N; None without a tangential spring."""
        if not self.law.compliance:
            return None
        if self.slip:
            return -self.friction * self.slip * self.force(touch.gap)
        return self.law.tangential_force(touch.along, self.anchor)

    def foot(self, touch: Touch, slip: int) -> Any:
        """Return the velocity of the tangential spring's foot in the sense of ``slip``, m/s.

        Without a tangential spring it is the velocity of the contact point.
        """
        velocity: Any = touch.velocity.T
        return slip * self.law.foot_velocity(velocity, slip)


def solve(matrix: Array, right: Array) -> Array:
    """Return the solution of a system of linear equations with the right-hand side ``right``.

    ``right`` is a vector, or has one column for each of several right-hand sides. With a first axis
    of n instants in ``matrix``, it has this axis and columns.
    """
    return np.asarray(np.linalg.solve(matrix, right), dtype=float)


def balance(mass: Array, forces: Array, contacts: Sequence[Acting]) -> Balance:
    """Return the accelerations and the contact forces that solve the equations of motion.

    Args:
        mass: mass matrix of the links (kg m^2), shape (..., links, links).
        forces: generalized forces on the links, without those of the contacts (N m), shape (...,
            links).
        contacts: the contacts, each in stick or in slip of a given sense.
    """
    links = forces.shape[-1]
    size = links + 2 * len(contacts)
    matrix = np.zeros((*forces.shape[:-1], size, size))
    right = np.zeros((*forces.shape[:-1], size))
    matrix[..., :links, :links] = mass
    right[..., :links] = forces
    for number, each in enumerate(contacts):
        normal = links + 2 * number
        tangential = normal + 1
        matrix[..., :links, normal : normal + 2] = -np.swapaxes(each.touch.rows, -1, -2)
        if each.push is None:  # the force that keeps the gap closed
            matrix[..., normal, :links] = each.touch.rows[..., 0, :]
            right[..., normal] = -each.touch.bias[..., 0]
        else:
            matrix[..., normal, normal] = 1.0
            right[..., normal] = each.push
        if each.sticks:
            matrix[..., tangential, :links] = each.touch.rows[..., 1, :]
            right[..., tangential] = -each.touch.bias[..., 1]
        else:
            matrix[..., tangential, tangential] = 1.0
            if each.rub is None:
                matrix[..., tangential, normal] = -each.ratio
            else:
                right[..., tangential] = each.rub
    found = solve(matrix, right[..., None])[..., 0]
    pushes = found[..., links:].reshape(*forces.shape[:-1], len(contacts), 2)
    return Balance(found[..., :links], pushes)


def acting(
    mass: Array, forces: Array, contacts: Sequence[Acting], still: float
) -> dict[int, int] | None:
    """Return which of the closed contacts stay closed, and whether each of them sticks or slips.

    The function tries all combinations of stick, slip and opening, and takes the first one that
    obeys the equations of motion and Coulomb's law.

    Args:
        mass: mass matrix of the links, kg m^2.
        forces: generalized forces on the links, without those of the contacts, N m.
        contacts: contacts with a gap and a normal velocity of zero.
        still: tangential velocity below which a contact may stick, m/s.

    Returns:
        The sign of the slip (0 for stick) by the index of each contact that stays closed. None if
        no combination obeys the equations.
    """
    options: list[tuple[int | None, ...]] = []
    for each in contacts:
        along = float(each.touch.velocity[1])
        may_stick = each.friction > 0.0 and abs(along) <= still
        slips = (STICK, 1, -1) if may_stick else (int(np.sign(along)) or 1,)
        slips = slips if each.rub is None else (each.slip,)
        options.append(slips if each.push is not None else (*slips, None))
    free = solve(mass, forces)
    for modes in itertools.product(*options):
        chosen = {
            i: contacts[i]._replace(slip=mode) for i, mode in enumerate(modes) if mode is not None
        }
        try:
            accelerations, pushes = balance(mass, forces, list(chosen.values()))
        except np.linalg.LinAlgError:  # more contacts than the links can keep closed
            continue
        opening = [contacts[i].touch for i, mode in enumerate(modes) if mode is None]
        opens = all(touch.rows[0] @ accelerations + touch.bias[0] >= 0.0 for touch in opening)
        if opens and all(
            _obeys_coulomb(mass, each, push, accelerations, free, still)
            for each, push in zip(chosen.values(), pushes.tolist(), strict=True)
        ):
            return {i: each.slip for i, each in chosen.items()}
    return None


def _obeys_coulomb(
    mass: Array,
    each: Acting,
    push: tuple[float, float],
    accelerations: Array,
    free: Array,
    still: float,
) -> bool:
    """Return whether the force and the motion of a contact obey Coulomb's law.

    A rigid contact must push, and friction must not lock it. In stick the tangential force must not
    exceed the friction limit. A contact that begins to slip must accelerate in the sense of its
    slip. A contact at rest whose friction force is not an unknown (``Acting.sticks``) must not
    accelerate tangentially.

    Args:
        mass: mass matrix of the links, kg m^2.
        each: the contact.
        push: normal and tangential force of the contact, N.
        accelerations: angular accelerations of the links, rad/s^2.
        free: angular accelerations that the links would have without contacts, rad/s^2.
        still: tangential velocity below which a contact may stick, m/s.
    """
    normal, tangential = push
    if each.rub is not None:
        return True
    if each.push is None and (
        normal < 0.0 or (each.slip and normal_response(mass, each.touch, each.ratio) <= 0.0)
    ):
        return False
    if each.sticks:
        return abs(tangential) <= (1.0 - EDGE) * each.friction * normal
    if not each.friction or abs(each.touch.velocity[1]) > still:
        return True
    row = each.touch.rows[1]
    bias = each.touch.bias[1]
    begins = float(row @ accelerations + bias)
    rounding = EDGE * float(np.abs([*row * accelerations, *row * free, bias]).max())
    return each.slip * begins >= -rounding if each.slip else abs(begins) <= rounding


def normal_response(mass: Array, touch: Touch, ratio: float) -> Any:
    """Return the normal acceleration of a contact point per unit normal force in slip, 1/kg.

    The response is J_n M^-1 (J_n + f J_t)^T, with the rows J_n and J_t of ``touch``, the mass
    matrix M and the ratio f of the tangential to the normal force (``ratio``). If the response is
    not positive, friction locks the contact.
    """
    normal, tangential = np.moveaxis(touch.rows, -2, 0)
    response = solve(mass, (normal + ratio * tangential)[..., None])[..., 0]
    return (normal * response).sum(axis=-1)


def closed(mass: Array, touches: Sequence[Touch]) -> tuple[Array, Array]:
    """Return the smallest changes of angles and angular velocities that close contacts.

    After the changes the gaps and the normal velocities of all contacts in ``touches`` are zero, to
    first order. The size of a change is its norm in the mass matrix. The contacts are those of one
    instant, or of n instants along a first axis.

    Returns:
        The changes of the links' angles (rad), and of their angular velocities (rad/s).
    """
    rows = np.stack([touch.rows[..., 0, :] for touch in touches], axis=-2)
    response = solve(mass, np.swapaxes(rows, -1, -2))
    gaps = [touch.gap for touch in touches]
    speeds = [touch.velocity[..., 0] for touch in touches]
    amounts = np.array([gaps, speeds]).T
    changes = -response @ solve(rows @ response, amounts)
    return changes[..., 0], changes[..., 1]
