"""The end of stick on two springs: the first event of two oscillators, for arrays of contacts.

Stick ends where the force reaches an edge of the friction cone, mu N -+ T = 0. Loading ends where
v_n = 0, and unloading where N returns to its largest value. Each of these functions f is a constant
plus two harmonics, so |f''| <= M and |f'''| <= M_3, with bounds from the amplitudes of the modes.
Two parabolas bound f from below: f + f' h - M h^2/2, and up to h = r also f + f' h + (f'' - M_3
r/3) h^2/2. The larger of their roots is a step that passes no root of f. Such steps converge on the
first root faster than Newton's method, and step past a near miss.

Where the rates differ much, longer steps are found from the parabola of the slow mode less the
amplitude of the fast one. The last step goes to the root of the cubic of f itself. An infinite step
means that nothing ends the contact: a jam, or stiction.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import INFINITE

NONE, LINE, FORWARD, BACKWARD, STOP, APART, NEVER, SETTLED = range(8)
"""Events at the end of a step.

``NONE``: still in stick. ``LINE``: the end of loading, or the return to it. ``FORWARD``,
``BACKWARD``: an edge of the cone, from which the spring's foot slips that way. ``STOP``: the foot
stops. ``APART``: the force ends. ``NEVER``: no event will come. ``SETTLED``: the fast mode is taken
from the motion."""

NAMES = np.array([BACKWARD, FORWARD, LINE])
"""Event at a zero of each event function."""

NOISE = 64.0 * sys.float_info.epsilon
"""Rounding of an event function as a fraction of its largest term; a smaller value counts as
zero."""

LEAST_STEP = 1e-6
"""Step away from an edge where a function and its slope are zero, over the fast mode's time scale.

The function then changes by 1e-18 of its amplitude."""

# Second derivative over its bound below which such a step cannot take the function past zero.
STRAIGHT = 1e-8

FEW = 8  # 1/FEW is the least fraction of contacts worth gathering or leaving to the next round

STEPS = 12  # largest number of steps in a round; contacts without an event wait for the next

# Distance of a root, over the fast mode's time scale, at which the cubic gives it: NEAR^4/24 =
# 3e-15.
NEAR = 5e-4

REACH = 2.0
TANGENT = 1.2
"""Longest step by the bound of f''': over the fast mode's time scale, and over the distance of the
tangent's root."""

# fraction of the step on which, by the bound of f''', a rising convex function stays convex
CONVEX = 0.9

# Fraction of the fast oscillation's amplitude that counts; a zero reached by the rest is not
# reached.
GRAZE = 1.0 - 1e-13

FLAT = 1e-10  # third derivative over its bound below which a function with slopes of rounding is 0

WIDE = 1e3  # rounding of a function that stays zero, over the rounding of its terms

TINY = 1e-290  # divided by zero it is infinite; added to any other number it changes nothing

LEAST_RATE = 1e-300  # squared rate that stands for zero, against division by zero


class Modes(NamedTuple):
    """Constants of a phase of stick, by mode (fast, slow) and by event function (edge, edge, line).

    An event function is ``constant`` plus ``parts`` times the modes' G, or times the modes' w at
    the end of loading.

    Attributes:
        speeds: w of the oscillators at the beginning of the phase.
        forces: G of the oscillators at the beginning of the phase.
        squares: squared rates of the modes.
        rates: rates of the modes, never zero.
        parts: coefficients of the modes in the event functions.
        terms: bounds of the terms of which the coefficients of the edges are sums.
        constant: constant of the line's function.
        line_noise: rounding of the line's function.
        loading: whether the contact loads.
        close: value of an event function below which its rounding matters.
        bend: bound of the second derivative.
        jerk: a third of the bound of the third derivative.
        swing: bound of the fast part.
        slow_bend: bound of the second derivative of the slow part.
        drifts: 0 where the slow mode is at rest, otherwise 1.
    """

    speeds: Number
    forces: Number
    squares: Number
    rates: Number
    parts: Number
    terms: Number
    constant: Number
    line_noise: Number
    loading: Number
    close: Number
    bend: Number
    jerk: Number
    swing: Number
    slow_bend: Number
    drifts: Number

    def chosen(self, at: Number) -> Modes:
        """Return the constants of the contacts with indices ``at``."""
        return Modes(*(np.take(each, at, axis=-1) for each in self))


def both(pair: Number) -> Number:
    """Return the sum over the two modes; NumPy's own sum is slow along so short an axis."""
    return pair[0] + pair[1]


def oscillators(modes: Modes, time: Number, *, sums: bool = False) -> tuple[Number, ...]:
    """Return w and G of the oscillators at times since the phase began, and the integral of G if
    ``sums``.

    Rates of zero are permitted.
    """
    # Sine and cosine by the tangent of the half angle, at a tenth of their cost.
    half = np.tan(0.5 * modes.rates * time)
    scale = 1.0 / (1.0 + half * half)
    cosines = (1.0 - half * half) * scale
    ways = half / modes.rates
    sines = 2.0 * ways * scale
    speeds = modes.speeds * cosines + modes.squares * modes.forces * sines
    forces = modes.forces * cosines - modes.speeds * sines
    if not sums:
        return speeds, forces
    return speeds, forces, sines * (modes.forces - modes.speeds * ways)


def step_to_event(modes: Modes, settles: Number) -> tuple[Number, Number]:
    """Step until few contacts are left without an event.

    Returns:
        The times since the phase began, and the events.
    """
    times = np.zeros(settles.size)
    events = np.where(settles, SETTLED, NONE)
    going = np.flatnonzero(~settles)
    few = going.size // FEW
    modes = modes if going.size == settles.size else modes.chosen(going)
    time = np.zeros(going.size)
    for _ in range(STEPS):
        if going.size <= few:
            break
        step, event = _step(modes, time)
        time = time + step
        over = np.count_nonzero(event)
        if FEW * over >= going.size or going.size - over <= few:
            times[going], events[going] = time, event
            left = np.flatnonzero(event == NONE)
            going = going[left]
            modes = modes.chosen(left)
            time = time[left]
    times[going] = time
    return times, events


def _step(modes: Modes, time: Number) -> tuple[Number, Number]:
    """Return a step that passes no event, and the event at its end; a contact at an event stays
    there.
    """
    speeds, forces = oscillators(modes, time)
    loading = modes.loading
    parts = modes.parts
    squares = modes.squares
    gains = squares * forces
    value = np.empty_like(modes.bend)
    slope = np.empty_like(modes.bend)
    bend = np.empty_like(modes.bend)
    value[:2] = parts[0, :2] * forces[0] + parts[1, :2] * forces[1]
    slope[:2] = -(parts[0, :2] * speeds[0] + parts[1, :2] * speeds[1])
    bend[:2] = -(parts[0, :2] * gains[0] + parts[1, :2] * gains[1])
    # The line's function is one of G in unloading; in loading it is one of w, whose slope is lambda
    # G.
    across = np.where(loading, speeds, forces)
    inclined = np.where(loading, gains, -speeds)
    along = parts[:, 2]
    value[2] = modes.constant + along[0] * across[0] + along[1] * across[1]
    slope[2] = along[0] * inclined[0] + along[1] * inclined[1]
    bend[2] = -(along[0] * squares[0] * across[0] + along[1] * squares[1] * across[1])

    above = np.maximum(value, 0.0)
    reach = REACH / modes.rates[0]
    tangents = np.minimum(np.where(slope < 0.0, TANGENT * above / -slope, INFINITE), reach)
    steps = np.minimum(
        _root(above, slope, np.minimum(modes.jerk * tangents - bend, modes.bend)), tangents
    )
    steps = np.fmax(steps, np.where(slope >= 0.0, CONVEX * bend / modes.jerk, 0.0))
    slow = parts[1] * forces[1]
    drift = modes.drifts * speeds[1]
    slow_slope = -drift * parts[1]
    slow[2] = modes.constant + along[1] * np.where(loading, drift, forces[1])
    slow_slope[2] = along[1] * np.where(loading, gains[1], -drift)
    clear = slow - GRAZE * modes.swing
    longer = _root(np.maximum(clear, 0.0), slow_slope, modes.slow_bend)
    steps = np.where(clear > 0.0, np.maximum(steps, longer), steps)
    event = np.zeros(time.size, dtype=int)
    found = _Functions(modes, speeds, forces, value, slope, bend, steps)
    found.leave(event)
    step = np.minimum(np.minimum(steps[0], steps[1]), steps[2])
    event[(step == INFINITE) & (event == NONE)] = NEVER
    event[~loading & (value[2] >= modes.constant * (1.0 - NOISE)) & (slope[2] > 0.0)] = APART
    step = np.where(event == NONE, step, 0.0)
    found.arrive(step, event)
    return step, event


class _Functions(NamedTuple):
    """The event functions at the beginning of a step.

    ``value``, ``slope`` and ``bend`` are the functions and their two derivatives. A step of
    ``steps`` passes no zero of its function.
    """

    modes: Modes
    speeds: Number
    forces: Number
    value: Number
    slope: Number
    bend: Number
    steps: Number

    def third(self, of: Number, at: Number) -> Number:
        """Return the third derivatives of the functions with indices ``of`` for the contacts
        ``at``.
        """
        fast, slow = (each.ravel()[of * self.value.shape[1] + at] for each in self.modes.parts)
        ends = self.modes.loading[at] & (of == 2)
        first, second = (
            np.where(ends, -square[at] * force[at], speed[at]) * square[at]
            for square, force, speed in zip(
                self.modes.squares, self.forces, self.speeds, strict=True
            )
        )
        return fast * first + slow * second

    def leave(self, event: Number) -> None:
        """Step away from zeros of rising functions, and note the events of falling ones.

        A function falls if it does so by more than rounding.
        """
        flat = np.flatnonzero(self.value <= self.modes.close)
        if not flat.size:
            return
        modes = self.modes
        of, at = np.divmod(flat, event.size)
        step, value, slope, bend, most = (
            each.ravel()[flat]
            for each in (self.steps, self.value, self.slope, self.bend, modes.bend)
        )
        line = of == 2
        terms = modes.terms.take(at, axis=1)
        rate = modes.rates[0][at]
        noise, slope_noise = (
            NOISE * both(terms * abs(each.take(at, axis=1))) for each in (self.forces, self.speeds)
        )
        noise = np.where(line, modes.line_noise[at], noise)
        slope_noise = np.where(line, 0.0, slope_noise)
        # On the border of stick, with modes of equal rates, the force keeps to the edge.
        flats = (
            (abs(slope) <= WIDE * slope_noise) & (abs(bend) <= WIDE * rate * slope_noise) & ~line
        )
        if flats.any():
            flats &= (abs(self.third(of, at)) <= FLAT * rate * most) & (value <= WIDE * noise)
        zero = value <= noise
        slope = np.where(abs(slope) <= slope_noise, 0.0, slope)
        square = slope * slope
        dip = 2.0 * noise * bend
        lift = np.where(most > 0.0, bend / (rate * most), 0.0)
        leaves = np.where(
            zero & (bend >= -STRAIGHT * most), np.maximum(lift, LEAST_STEP / rate), 0.0
        )
        self.steps.ravel()[flat] = np.where(flats, INFINITE, np.maximum(step, leaves))
        falls = np.where(slope < 0.0, square > dip, square < -dip) & zero & ~flats
        event[at[falls]] = NAMES[of[falls]]

    def arrive(self, step: Number, event: Number) -> None:
        """Step to the first zero if it is near and no other function can have an earlier one."""
        at = np.flatnonzero((event == NONE) & (step * self.modes.rates[0] < NEAR))
        if not at.size:
            return
        of = np.where(
            self.steps[2][at] == step[at], 2, np.where(self.steps[1][at] == step[at], 1, 0)
        )
        flat = of * event.size + at
        value, slope, bend = (each.ravel()[flat] for each in (self.value, self.slope, self.bend))
        third = self.third(of, at)
        close = self.modes.close.ravel()[flat]
        falls = (slope < 0.0) & (value > close)
        tangent = np.where(falls, -value / slope, 0.0)
        root = tangent
        for _ in range(2):
            rest = value + root * (slope + root * (0.5 * bend + root * third / 6.0))
            root = root - rest / (slope + root * (bend + 0.5 * root * third))
        steps = self.steps.take(at, axis=1)
        steps[of, np.arange(at.size)] = INFINITE
        good = (
            falls & (abs(root - tangent) < 0.1 * tangent) & (root * self.modes.rates[0][at] < NEAR)
        )
        good &= root <= np.minimum(np.minimum(steps[0], steps[1]), steps[2])
        step[at[good]], event[at[good]] = root[good], NAMES[of[good]]


def _root(value: Number, slope: Number, most: Number) -> Number:
    """Return the first positive root of value + slope h - most h^2/2 with value >= 0; infinite if
    there is none.

    The form of the root avoids cancellation.
    """
    square = slope * slope + 2.0 * most * value
    root = np.sqrt(np.maximum(square, 0.0))
    falls = slope < 0.0
    found = np.where(falls, 2.0 * value, root + slope + TINY) / np.where(
        falls, root - slope, np.maximum(most, 0.0)
    )
    return np.where(square < 0.0, INFINITE, found)
