"""The motion of a run as numbers for an HTML page.

The page interpolates between the numbers and shows the same motion as :meth:`Trajectory.at`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.render.story import phases, story_end
from bristle_sim.render.style import MILLIMETRES, MILLISECONDS
from bristle_sim.trajectory import ContactRecord, Interpolation, Motion, Trajectory

ROUNDS = 12  # largest number of times that an interval between two samples is halved
TRIED = 0.4  # fraction of an interval where the page's interpolation is tried: errors do not cancel there

LINE_SHOWN = 0.001
RETRACTION_SHOWN = 0.001
FORCE_SHOWN = 0.0007
SPEED_SHOWN = 0.01
"""Largest errors of the page's interpolation: centre line, mm; retraction, degrees; force, N; tip
speed, m/s. Each is at most a tenth of the last digit that the page shows."""

FORCE_RATIO = 1e-4
"""Permitted error of the force, over the largest force in the contact, where it exceeds FORCE_SHOWN.

A contact that lasts 0.4 ns reaches 10 MN. To give its force to 0.7 mN would take a hundred thousand
nodes."""

# Largest number of numbers in a page's motion; at 12 bytes each it stays below 2 MB
MOST_NUMBERS = 100_000
LOOSENING = 4.0  # factor by which the errors grow until the motion has at most MOST_NUMBERS
MOST_LOOSENED = 4.0**6  # largest factor of the errors; the centre line's is then four millimetres

STRIKE_SHOWN = 0.01  # time for which an instantaneous impact is shown, as a fraction of the run
JUMP = 1e-9  # smallest difference before and after an instant that counts as a jump, in the page's units

Indices = NDArray[np.intp]


def motion_data(run: Trajectory, tool: Tool) -> dict[str, Any]:
    """Return the motion of a pass as JSON data for an HTML page, up to the last instant shown.

    Times are in ms, lengths in mm, velocities in m/s, angles in degrees; the hub's angle is in rad.

    The data hold the motion at chosen times, the nodes. Between nodes the page interpolates centre
    line and retraction by cubic Hermite polynomials, and the force linearly. The nodes are chosen
    such that the interpolation is exact to the digits shown. They are samples of the run and, where
    needed, times between samples. Two nodes at the same time are the motion before and after a
    jump. ``drawn`` states the number of samples that are nodes, and the errors.
    """
    end = story_end(run)
    nodes = _Nodes(run, end)
    jumps = nodes.jumps & (np.arange(nodes.time.size) > 0)
    kept = np.stack([jumps, np.ones(nodes.time.size, dtype=bool)], axis=1)
    # To attoseconds and picometres, so that speeds within a short contact are true, and no more, to keep a page small.
    places, slopes = np.round(np.stack([nodes.before, nodes.after], axis=2)[:, kept], 9)
    return {
        "time": np.round(
            MILLISECONDS * np.stack([nodes.time, nodes.time], axis=1)[kept], 12
        ).tolist(),
        "line": places[:, :-2].tolist(),
        "velocity": slopes[:, :-2].tolist(),
        "retraction": np.stack([places[:, -2], slopes[:, -2]], axis=1).tolist(),
        "force": places[:, -1:].tolist(),
        "drawn": nodes.drawn,
        "hub": [float(run.hub_angle[0]), run.hub_speed / MILLISECONDS],
        "hubRadius": tool.hub.radius * MILLIMETRES,
        "wire": tool.bristle.wire_diameter * MILLIMETRES,
        "bar": None
        if tool.bar is None
        else [each * MILLIMETRES for each in (*tool.bar.centre, tool.bar.radius)],
        "surface": None if tool.workpart is None else -tool.workpart_depth * MILLIMETRES,
        "contacts": [
            [
                each.obstacle,
                *(round(1e3 * part, 12) for part in (each.time, each.duration, *each.impulse)),
                _force_digit(run, each),
            ]
            for each in run.contacts
            if each.time <= end
        ],
        "phases": [
            [round(MILLISECONDS * each.start, 12), each.caption]
            for each in phases(run, STRIKE_SHOWN * (end - run.time[0]))
            if each.start <= end
        ],
    }


class _Nodes:
    """The nodes: the times of a run between which an HTML page interpolates the motion.

    Attributes:
        time: times of the nodes, s, ascending.
        before, after: values and time derivatives just before and after each node, shape (2, nodes,
            columns). The columns are the corners of the centre line, mm, the retraction, degrees,
            and the force, N. Derivatives are per ms; the derivative of the force is not used.
        drawn: a text with the number of samples that are nodes, and the errors.
    """

    def __init__(self, run: Trajectory, end: float) -> None:
        """Choose the nodes, up to the first sample at or after the time ``end``, s."""
        self._interpolation = Interpolation(run)
        last = run.time[np.searchsorted(run.time, end)]
        samples = int(np.searchsorted(run.time, last, side="right"))
        self.time, first = np.unique(run.time[:samples], return_index=True)
        states = _states(run)
        self.before = states[:, first]
        self.after = states[:, np.append(first[1:], samples) - 1]
        self.before[0, :, -1] = self._interpolation.normal_force(self.time, "before")
        self.after[0, :, -1] = self._interpolation.normal_force(self.time, "after")
        self._most = MOST_NUMBERS // (2 * self.before.shape[2])
        self._allowed = np.full((self.time.size, self.before.shape[2]), LINE_SHOWN)
        self._allowed[:, -2] = RETRACTION_SHOWN
        self._allowed[:, -1] = FORCE_SHOWN
        for contact in run.contacts:
            during = (self.time >= contact.time) & (self.time <= contact.time + contact.duration)
            self._allowed[during, -1] = _force_error(run, contact)
        self._loosened = 1.0
        kept = self._kept_samples()
        while kept.size > self._most and self._loosened < MOST_LOOSENED:
            self._loosened *= LOOSENING
            kept = self._kept_samples()
        self.time = self.time[kept]
        self.before = self.before[:, kept]
        self.after = self.after[:, kept]
        self._allowed = self._allowed[kept]
        self._add_between()
        between = self.time.size - kept.size
        more = f" and {between} instants between them" if between else ""
        errors = (self._loosened * each for each in (LINE_SHOWN, RETRACTION_SHOWN, SPEED_SHOWN))
        self.drawn = "{} of {} samples drawn{}; between these the motion is interpolated to {:g} mm, {:g}° and {:g} m/s".format(
            kept.size, first.size, more, *errors
        )

    @property
    def jumps(self) -> NDArray[np.bool_]:
        """Whether the motion jumps at each node."""
        found = np.abs(self.after - self.before).max(axis=(0, 2)) > JUMP
        return np.asarray(found)

    def _kept_samples(self) -> Indices:
        """Return the indices of the samples that are nodes.

        Interpolation between the nodes reproduces the other samples to the accuracy shown.
        """
        kept = self.jumps
        kept[[0, -1]] = True
        while kept.sum() <= self._most:
            nodes = np.flatnonzero(kept)
            others = np.flatnonzero(~kept)
            interval = np.searchsorted(nodes, others)
            starts = nodes[interval - 1]
            ends = nodes[interval]
            allowed = self._allowed[others]
            wrong = self._wrong(starts, ends, self.time[others], self.after[:, others], allowed)
            if not wrong.any():
                break
            kept[(starts[wrong] + ends[wrong]) // 2] = True
        return np.flatnonzero(kept)

    def _add_between(self) -> None:
        """Add nodes between the kept samples, where the accuracy requires them."""
        for _ in range(ROUNDS):
            starts = np.arange(self.time.size - 1)
            ends = starts + 1
            tried = self.time[starts] + TRIED * np.diff(self.time)
            allowed = np.maximum(self._allowed[starts], self._allowed[ends])
            wrong = self._wrong(starts, ends, tried, _states(self._interpolation(tried)), allowed)
            if not wrong.any() or self.time.size + wrong.sum() > self._most:
                break
            places = ends[wrong]
            middles = 0.5 * (self.time[starts] + self.time[ends])[wrong]
            states = _states(self._interpolation(middles))
            self.time = np.insert(self.time, places, middles)
            self.before = np.insert(self.before, places, states, axis=1)
            self.after = np.insert(self.after, places, states, axis=1)
            self._allowed = np.insert(self._allowed, places, allowed[wrong], axis=0)

    def _wrong(
        self, starts: Indices, ends: Indices, time: Array, motion: Array, allowed: Array
    ) -> NDArray[np.bool_]:
        """Return for each interval whether the page's interpolation is visibly wrong at one instant
        of it.

        Args:
            starts, ends: indices of the nodes at both ends of the intervals.
            time: an instant in each interval, s.
            motion: true values and derivatives at these instants.
            allowed: largest errors of the values.
        """
        length = self.time[ends] - self.time[starts]
        s = ((time - self.time[starts]) / length)[:, np.newaxis]
        h = MILLISECONDS * length[:, np.newaxis]
        p, v = self.after[:, starts]
        q, w = self.before[:, ends]
        true, velocity = motion
        # Hermite's cubic from values and slopes at both ends, and its slope; of the force a straight line.
        place = (
            q
            + (1.0 - s) ** 2 * (1.0 + 2.0 * s) * (p - q)
            + s * (1.0 - s) * h * ((1.0 - s) * v - s * w)
        )
        slope = (
            6.0 * s * (s - 1.0) * (p - q) / h
            + (1.0 - s) * (1.0 - 3.0 * s) * v
            + s * (3.0 * s - 2.0) * w
        )
        place[:, -1] = (p + s * (q - p))[:, -1]
        speed, true_speed = (np.hypot(*each[:, -4:-2].T) for each in (slope, velocity))
        error = np.maximum(
            (np.abs(place - true) / allowed).max(axis=1), np.abs(speed - true_speed) / SPEED_SHOWN
        )
        found: NDArray[np.bool_] = error > self._loosened
        return found


def _states(motion: Motion) -> Array:
    """Return values and time derivatives of the quantities that the page interpolates.

    Derivatives are per ms. Velocities therefore need no conversion, since 1 m/s is 1 mm/ms.
    """
    rows = motion.time.size
    retraction, falling = np.degrees([motion.retraction, -motion.relative_rate / MILLISECONDS])
    force = motion.normal_force
    places = (motion.centre_line * MILLIMETRES).reshape(rows, -1), retraction, force
    slopes = motion.centre_line_velocity.reshape(rows, -1), falling, np.zeros_like(force)
    return np.stack([np.column_stack(each) for each in (places, slopes)])


def _force_error(run: Trajectory, contact: ContactRecord) -> float:
    """Return the largest permitted error of the interpolated force in a contact, N."""
    during = (run.time >= contact.time) & (run.time <= contact.time + contact.duration)
    largest = float(run.normal_force[during].max(initial=0.0)) if contact.duration else 0.0
    return max(FORCE_SHOWN, FORCE_RATIO * largest)


def _force_digit(run: Trajectory, contact: ContactRecord) -> float:
    """Return the place value of the last digit of the force that the page shows in a contact, N.

    It is a power of ten, at least ten times the error of the force.
    """
    return float(10.0 ** math.ceil(math.log10(10.0 * _force_error(run, contact)) - 1e-9))
