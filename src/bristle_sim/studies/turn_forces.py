"""Forces on a bristle over a revolution of the hub: impulses of impacts, and time series of
sustained contacts.

Normal and tangential directions are those of a contact record. Moments are about the hub's centre,
positive in the hub's sense of rotation.

A load cell is modelled as a mass on a spring with the damping of a Butterworth filter. Its response
to a unit impulse is h(t) = sqrt(2) w exp(-w t/sqrt 2) sin(w t/sqrt 2) with w = 2 pi bandwidth. At
the bandwidth it passes half the power.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bar, Tool
from bristle_sim.studies.pass_invariants import (
    X_Y,
    impulse_moment,
    in_plane,
    surface_point,
)
from bristle_sim.trajectory import ContactRecord, Interpolation, Trajectory

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
"""Nodes and weights of a Gauss-Legendre rule on (-1, 1). It integrates a cubic in t times exp(p t)
to rounding error over an interval of length h with |p| h <= 1."""


@dataclass(frozen=True, slots=True)
class Force:
    """The force of an obstacle on the bristle in an impact or in a sustained contact.

    Attributes:
        obstacle: name of the obstacle.
        edges: ascending instants between which the force is smooth, s. An impact has a single
            instant.
        integral: time integrals of the normal force (N s), of the tangential force (N s), and of
            their moment about the hub's centre (N m s).
        course: function that returns the normal force (N) at given instants (s); None for an
            impact.
    """

    obstacle: str
    edges: tuple[float, ...]
    integral: Array
    course: Callable[[Array], Array] | None = None


def load_cell_response(
    forces: Iterable[Force], period: float, bandwidth: float, times: Array
) -> Array:
    """Return the normal force that a load cell shows at given times, N.

    The forces repeat periodically. h(t) is the load cell's response to a unit impulse, and p the
    pole of its filter. An impact of impulse J contributes J h(tau + k T) for k = 0, 1, ..., where T
    is the period and tau the time since the impact's latest repetition. The sum over k is a
    geometric series in exp(p T). A sustained force is divided into intervals that are shorter than
    T/2 and 1/|p|. In each interval the force is integrated with the weight exp(p t).

    Args:
        forces: forces within one period.
        period: time after which the forces repeat, s.
        bandwidth: bandwidth of the load cell, Hz.
        times: times at which the response is computed, s.
    """
    pole = 2.0 * math.pi * bandwidth * complex(-1.0, 1.0) / math.sqrt(2.0)
    state = np.zeros(len(times), dtype=complex)
    for force in forces:
        if force.course is None:
            since = np.mod(times - force.edges[0], period)
            state += force.integral[0] * np.exp(pole * since)
            continue
        for begin, end in pairwise(force.edges):
            parts = math.ceil((end - begin) * max(2.0 / period, abs(pole)) + 1.0)
            length = (end - begin) / parts
            for start in begin + length * np.arange(parts):
                since = np.mod(times - start, period)
                whole = complex(_weighed(force.course, start, np.array([length]), pole)[0])
                inside = since < length
                state += whole * np.exp(pole * (since - length + np.where(inside, period, 0.0)))
                # At times within this part, its force counts up to that time, and its earlier
                # repetitions count in full.
                acting = _weighed(force.course, start, since[inside], pole)
                state[inside] += -np.expm1(pole * period) * acting
    # Residue of w^2/((s - p)(s - p*)) at p, with the sum over k.
    return np.asarray(
        2.0 * (-1j * abs(pole) / math.sqrt(2.0) * state / -np.expm1(pole * period)).real
    )


def _weighed(
    course: Callable[[Array], Array], start: float, length: Array, pole: complex
) -> NDArray[np.complex128]:
    """Return the integral of exp(p (t_1 - t)) F(t) over each interval from t_0 to t_1, N s.

    Args:
        course: function that returns the normal force F (N) at given instants (s).
        start: common start t_0 of the intervals, s.
        length: lengths t_1 - t_0 of the intervals, s.
        pole: pole p of the load cell's filter, 1/s.
    """
    offset = 0.5 * length[:, np.newaxis] * (1.0 + NODES)
    values = course(start + offset)
    return np.asarray(
        0.5 * length * ((values * np.exp(pole * (length[:, np.newaxis] - offset))) @ WEIGHTS)
    )


def turn_forces(tool: Tool, run: Trajectory) -> tuple[Force, ...]:
    """Return all forces of bar and workpart on a rigid bristle in one revolution, in order of time."""
    motion = Interpolation(run, run.contacts)

    def normal_force(time: Array) -> Array:
        """Return the normal force of sustained contacts (N) at given instants (s)."""
        return motion.normal_force(time.ravel(), "before").reshape(time.shape)

    found = []
    for contact in run.contacts:
        edges: tuple[float, ...] = (contact.time,)
        course = None
        if contact.law == "sustained":
            edges, moment = _sustained(tool, motion, contact)
            course = normal_force
        else:
            moment = impulse_moment(tool, contact)
        integral = np.array([*contact.impulse, moment])
        found.append(Force(contact.obstacle, edges, integral, course))
    return tuple(found)


def dissipated(tool: Tool, run: Trajectory) -> float:
    """Return the energy that impacts, friction and belt damping dissipate in one revolution, J.

    The loss in an impact is the work of its impulse. The work of friction in sustained contacts is
    summed over the steps of the simulation. The work of damping is the time integral of c alpha'^2,
    where c is the belt's damping coefficient and alpha the bristle's angle relative to the hub.
    """
    lost = -sum(sum(each.work or ()) for each in run.contacts)
    if tool.belt_damping:
        instants, weights = quadrature(run.time)
        lost += tool.belt_damping * float((weights * run.at(instants).relative_rate ** 2).sum())
    return lost


def quadrature(time: Array) -> tuple[Array, Array]:
    """Return the nodes and weights of a time integral between samples.

    The rule is the two-point Gauss-Legendre rule, of fourth order. Its relative error is h^4/4320,
    where h is the phase of the oscillation between samples, rad: 1e-11 with 400 samples in a
    period.

    Returns:
        The nodes (s), shape (n - 1, 2) for n samples.
        The weights (s), of the same shape.
    """
    step = np.diff(time)[:, np.newaxis]
    places = 0.5 + np.array([-0.5, 0.5]) / math.sqrt(3.0)
    return time[:-1, np.newaxis] + step * places, np.repeat(0.5 * step, 2, axis=1)


def _sustained(
    tool: Tool, motion: Interpolation, contact: ContactRecord
) -> tuple[tuple[float, ...], float]:
    """Return the instants at which a sustained force may jump, and the integral of its moment.

    The force jumps when slip reverses, and when the wire's end slides onto the bar. At these
    instants the run has two samples, one before and one after the jump.

    Returns:
        The instants, s.
        The time integral of the moment about the hub's axis, N m s.
    """
    ends = (contact.time, contact.time + contact.duration)
    first, last = (int(abs(motion.run.time - each).argmin()) for each in ends)
    time = motion.run.time[first : last + 1]
    instants, weights = quadrature(time)
    at = motion(instants)
    lines = at.centre_line @ X_Y
    part = tool.bar if contact.obstacle == "bar" else tool.workpart
    assert part is not None
    place = lines[..., 1 if contact.point == "knee" else -1]
    if isinstance(part, Bar):
        points = part.closest(lines)
        piece = abs(points - complex(*part.centre)).argmin(axis=-1, keepdims=True)
        place = np.take_along_axis(points, piece, axis=-1)[..., 0]
    normal, point = surface_point(tool, contact.obstacle, place)
    root = lines[..., 0]
    velocity = 1j * (tool.hub.speed * root + at.rates[..., -1] * (point - root))
    slip = np.sign((np.conj(velocity) * normal).imag)
    pushed = weights * at.normal_force
    impulse = np.stack([pushed, -part.friction * slip * pushed])
    # A force that falls to 0 within the last interval is no polynomial there, and the quadrature
    # misses a part of its impulse. The lever hardly changes, so the missing part has the last lever.
    impulse[:, -1, -1] += np.subtract(contact.impulse, impulse.sum(axis=(1, 2)))
    moment = float((np.conj(point) * in_plane(normal, impulse)).imag.sum())
    return tuple(np.unique(time[[0, *np.flatnonzero(np.diff(time) <= 0.0), -1]]).tolist()), moment
