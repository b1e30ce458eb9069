"""Forces on a bristle over a revolution of the hub: impulses of impacts, and time series of
sustained contacts.

Normal and tangential directions are those of a contact record. Moments are about the hub's centre,
positive in the hub's sense of rotation.

A load cell is modelled as a mass on a spring with the damping of a Butterworth filter. Its response
to a unit impulse is h(t) = sqrt(2) w exp(-w t/sqrt 2) sin(w t/sqrt 2) with w = 2 pi bandwidth. At
the bandwidth it passes half the power.
"""

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.studies.pass_invariants import (
    arms_at,
    complex_points,
    levers,
    nearest,
    touched,
    wire_lines,
)
from bristle_sim.trajectory import ContactRecord, Trajectory

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
"""Nodes and weights of a Gauss-Legendre rule on (-1, 1). Over an interval of length h with |p| h <= 1
its error for a cubic times exp(p t) is rounding error."""


CLOSEST_NODES = 0.05
"""Smallest distance of a spline's nodes, over their largest distance.

Near a release the samples of the simulation are so close to each other that a spline through all of
them would follow their rounding errors."""


@dataclass(frozen=True, slots=True)
class Force:
    """A force of an obstacle on the bristle: an impact, or a smooth interval of a sustained
    contact.

    Attributes:
        obstacle: name of the obstacle.
        begin, end: start and end, s; equal for an impact.
        integral: impulses of the normal and the tangential force, N s, and time integral of their
            moment, N m s.
        course: normal and tangential force, N, and moment, N m, as functions of time; None for an
            impact.
    """

    obstacle: str
    begin: float
    end: float
    integral: Array
    course: Any = None


def load_cell_response(
    forces: Iterable[Force], period: float, bandwidth: float, times: Array
) -> Array:
    """Return the normal force that a load cell shows at given times, N, if the forces repeat
    periodically.

    An impact of impulse J contributes J h(tau + k T) for k = 0, 1, ..., where tau is the time since
    its last repetition and T the period. The sum is a geometric series in exp(p T), where p is the
    filter's pole. A sustained force is divided into parts shorter than half a period and 1/|p|;
    each part is integrated with exp(p t).

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
            state += force.integral[0] * np.exp(pole * np.mod(times - force.begin, period))
            continue
        parts = math.ceil((force.end - force.begin) * max(2.0 / period, abs(pole)) + 1.0)
        length = (force.end - force.begin) / parts
        for start in force.begin + length * np.arange(parts):
            since = np.mod(times - start, period)
            whole = complex(_weighed(force.course, start, np.array([length]), pole)[0])
            inside = since < length
            state += whole * np.exp(pole * (since - length + np.where(inside, period, 0.0)))
            # Of the part that still acts only the impulse so far counts; its earlier repetitions
            # are complete.
            state[inside] += -np.expm1(pole * period) * _weighed(
                force.course, start, since[inside], pole
            )
    # Residue of w^2/((s - p)(s - p*)) at p, with the sum over k.
    return np.asarray(
        2.0 * (-1j * abs(pole) / math.sqrt(2.0) * state / -np.expm1(pole * period)).real
    )


def _weighed(
    course: Callable[[Array], Array], start: float, length: Array, pole: complex
) -> NDArray[np.complex128]:
    """Return the integral of exp(p (end - t)) F(t), the normal force weighted with the decay until
    the end.

    The intervals begin at ``start`` and have the given lengths; p is the filter's pole.
    """
    offset = 0.5 * length[:, np.newaxis] * (1.0 + NODES)
    values = course(start + offset)[..., 0]
    return np.asarray(
        0.5 * length * ((values * np.exp(pole * (length[:, np.newaxis] - offset))) @ WEIGHTS)
    )


def turn_forces(tool: Tool, run: Trajectory) -> tuple[Force, ...]:
    """Return all forces of bar and workpart on a rigid bristle in one revolution, in order of time."""
    found = list[Force]()
    for contact in run.contacts:
        if contact.law == "sustained":
            found += _sustained(tool, run, contact)
            continue
        moment = arms_at(tool, run, contact)[0] @ contact.impulse
        integral = np.array([*contact.impulse, moment])
        found.append(Force(contact.obstacle, contact.time, contact.time, integral))
    return tuple(found)


def dissipated(tool: Tool, run: Trajectory) -> float:
    """Return the energy that impacts, friction and the belt's damping dissipate in one revolution,
    J.

    The losses in impacts are those of the impact law. The work of friction in sustained contacts is
    summed over the steps of the simulation. The work of damping is the integral of c alpha'^2, with
    the belt's damping c and the relative angle alpha. Splines are fitted separately between the
    instants at which the acceleration jumps, and integrated.
    """
    lost = -sum(sum(each.work or ()) for each in run.contacts)
    if not tool.belt_damping:
        return lost
    breaks = [edge for each in turn_forces(tool, run) for edge in (each.begin, each.end)]
    power = tool.belt_damping * run.relative_rate**2
    for begin, end in itertools.pairwise(np.unique([run.time[0], *breaks, run.time[-1]])):
        # At an impact the later of two samples begins an interval, and the earlier one ends the
        # interval before.
        first, last = (
            np.searchsorted(run.time, begin, "right") - 1,
            np.searchsorted(run.time, end, "left"),
        )
        lost += float(
            CubicSpline(run.time[first : last + 1], power[first : last + 1]).integrate(begin, end)
        )
    return lost


def _sustained(tool: Tool, run: Trajectory, contact: ContactRecord) -> list[Force]:
    """Return the forces of a sustained contact, divided at the instants at which its force jumps.

    It jumps where the bar reaches the wire's end, and where slip reverses. The sample at a jump has
    the force before the jump. Each spline therefore begins one sample later and is extrapolated
    back to the jump.
    """
    # The factor makes up for the rounding of the sum, by which the sample at the end could be
    # missed.
    end = (contact.time + contact.duration) * (1.0 - 1e-15)
    rows = np.arange(
        np.searchsorted(run.time, contact.time, "right") - 1,
        np.searchsorted(run.time, end, "left") + 1,
    )
    rows = rows[rows < len(run.time)]
    time = run.time[rows]
    force = run.normal_force[rows]
    lines = complex_points(run.centre_line[rows])
    states = _slip_and_place(tool, run, contact.obstacle, rows)
    # The earlier of two samples at a jump has the force before the jump.
    jumps = np.searchsorted(
        time, time[np.flatnonzero((states[:, 1:] != states[:, :-1]).any(axis=0)) + 1]
    )
    part = tool.workpart if contact.obstacle == "workpart" else tool.bar
    assert part is not None
    arms = levers(*touched(tool, contact.obstacle, lines))
    if contact.outcome == "release":
        force[-1] = 0.0
    found = []
    for first, last in itertools.pairwise([0, *jumps, len(rows) - 1]):
        own = _spaced(time, first, last)
        forces = np.stack([force[own], -part.friction * states[0, first] * force[own]], axis=-1)
        values = np.column_stack([forces, (arms[own] * forces).sum(axis=-1)])
        nodes = time[own]
        if len(own) == 1:
            nodes = np.array([nodes[0] - 1.0, nodes[0]])
            values = np.repeat(values, 2, axis=0)
        course = CubicSpline(nodes, values)
        begin = float(time[first])
        end = float(time[last])
        found.append(
            Force(contact.obstacle, begin, end, np.asarray(course.integrate(begin, end)), course)
        )
    # No spline follows a force that falls to 0 within the last interval; the lever hardly changes
    # there.
    short = np.subtract(contact.impulse, np.sum([each.integral[:2] for each in found], axis=0))
    found[-1].integral[2] += arms[-1] @ short
    return found


def _spaced(time: Array, first: int, last: int) -> list[int]:
    """Return the indices of samples that are far enough apart for a spline, from ``first``
    (excluded) to ``last``.
    """
    kept = [last]
    closest = CLOSEST_NODES * np.diff(time[first : last + 1]).max()
    for row in range(last - 1, first, -1):
        if time[kept[-1]] - time[row] >= closest:
            kept.append(row)
    return kept[::-1]


def _slip_and_place(tool: Tool, run: Trajectory, obstacle: str, rows: Any) -> Array:
    """Return two numbers for each interval between samples, which change where the contact force
    jumps.

    The first is the sense of slip, -1, 0 or 1. The second is the index of the wire's straight
    segment at the bar; at a corner it is halfway between the indices of the two segments.
    """
    hub, angle, rate = (
        0.5 * (each[rows][1:] + each[rows][:-1])
        for each in (run.hub_angle, run.angles[:, -1], run.rates[:, -1])
    )
    lines = wire_lines(tool, hub, angle)
    root = lines[:, 0]
    normal, point = touched(tool, obstacle, lines)
    velocity = 1j * (tool.hub.speed * root + rate * (point - root))
    slips = np.sign((np.conj(velocity) * normal).imag)
    if obstacle == "workpart":
        return np.stack([slips, 0.0 * slips])
    piece, fraction, _ = nearest(tool, lines)
    return np.stack(
        [slips, piece + 0.5 * (fraction >= 1.0) - 0.5 * (fraction <= 0.0) * (piece > 0)]
    )
