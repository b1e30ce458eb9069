"""The end of stick on two springs: the first event of two oscillators, for arrays of contacts.

Stick ends where the force reaches an edge of the friction cone, mu N -+ T = 0. Loading ends where
v_n = 0, and unloading ends where N returns to its largest value. These three event functions f are
each a constant plus two harmonics, so |f''| <= M and |f'''| <= M_3, with bounds from the amplitudes
of the modes. Two parabolas bound f from below after a step h: f + f' h - M h^2/2, and up to h = r
also f + f' h + (f'' - M_3 r/3) h^2/2. The larger of their roots is a step that passes no root of f.
Such steps converge on the first root faster than Newton's method, and pass a near miss.

Where the rates of the modes differ much, longer steps are found from the parabola of the slow mode
less the amplitude of the fast mode. The last step goes to the root of the third-order Taylor
polynomial of f. An infinite step means that nothing ends the contact: a jam, or stiction.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import INFINITE

NONE, LINE, FORWARD, BACKWARD, STOP, APART, NEVER, SETTLED, BALANCED = range(9)
"""Events at the end of a step.

``NONE``: the contact is still in stick. ``LINE``: loading ends, or begins again. ``FORWARD``,
``BACKWARD``: the force reaches an edge of the friction cone, and the spring's foot slips in this
sense. ``STOP``: the foot stops. ``APART``: the force ends. ``NEVER``: no event will come.
``SETTLED``: the fast mode is removed from the motion. ``BALANCED``: the fast mode's velocity is 0."""

NAMES = np.array([BACKWARD, FORWARD, LINE])
"""Event at a zero of each event function."""

NOISE = 64.0 * sys.float_info.epsilon
"""Rounding error of an event function as a fraction of its largest term; a smaller value counts as
zero."""

LEAST_STEP = 1e-6
"""Step away from a point where an event function and its slope are zero, over the time scale of the
fast mode.

In this step the function changes by 1e-18 of its amplitude."""

# Second derivative, as a fraction of its bound, below which a step of ``LEAST_STEP`` cannot take
# the event function past zero.
STRAIGHT = 1e-8

FEW = 8  # 1/FEW is the smallest fraction of contacts worth gathering or leaving to the next round

STEPS = 12  # largest number of steps in a round; contacts without an event wait for the next round

# Distance, over the time scale of the fast mode, from which the third-order Taylor polynomial gives
# a root: its error is NEAR^4/24 = 3e-15.
NEAR = 5e-4

REACH = 2.0
TANGENT = 1.2
"""Longest steps that the bound of f''' may give: over the time scale of the fast mode, and over the
distance of the tangent's root."""

# Fraction used of the step over which, by the bound of f''', a rising convex function stays convex.
CONVEX = 0.9

# Fraction of the fast oscillation's amplitude that is assumed reached; a function that comes to
# zero only by the remainder counts as a near miss.
GRAZE = 1.0 - 1e-13

# Third derivative, as a fraction of its bound, below which a function counts as zero throughout if
# its lower derivatives are rounding error.
FLAT = 1e-10

WIDE = 1e3  # rounding error of a function that stays zero, over the rounding error of its terms

TINY = 1e-290  # added to a dividend so that 0/0 becomes infinite; other values do not change

LEAST_RATE = 1e-300  # squared rate used in place of zero, against division by zero


class Modes(NamedTuple):
    """Constants of a phase of stick for its two modes and its three event functions.

    The modes are the fast and the slow oscillator; each has a velocity w and a force G. The event
    functions are zero at the two edges of the friction cone and at the end of loading or unloading.
    Each is a constant plus ``parts`` times the G of the modes; at the end of loading it is
    ``parts`` times their w.

    Attributes:
        speeds: velocities w of the modes at the beginning of the phase.
        forces: forces G of the modes at the beginning of the phase.
        squares: squared natural rates of the modes.
        rates: natural rates of the modes, never zero.
        parts: coefficients of the modes in the event functions.
        terms: bounds of the terms whose sums are the coefficients of the two edges.
        constant: constant of the third event function.
        line_noise: rounding error of the third event function.
        loading: whether the contact loads.
        close: value of an event function below which its rounding error matters.
        bend: bound of the second derivative of each event function.
        jerk: a third of the bound of the third derivative of each event function.
        swing: bound of the fast mode's part of each event function.
        slow_bend: bound of the second derivative of the slow mode's part of each event function.
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
    """Return the sum over the two modes.

    It is faster than NumPy's own sum along so short an axis.
    """
    return pair[0] + pair[1]


def oscillators(modes: Modes, time: Number, *, sums: bool = False) -> tuple[Number, ...]:
    """Return velocities and forces of the two modes at times since the phase of stick began.

    Natural rates of zero are permitted.

    Returns:
        The velocities w, the forces G, and with ``sums`` the time integrals of G.
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
    """Advance contacts in stick to their next events, until few are left without an event.

    Where ``settles`` is set, the contact does not advance, and its event is ``SETTLED``.

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
    """Return, for each contact, a time step that passes no event, and the event at its end.

    A contact that is at an event has a step of 0.
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
    """Values of the event functions at the beginning of a time step.

    ``value``, ``slope`` and ``bend`` are the functions and their first and second derivatives.
    ``steps`` holds, for each function, a time step that passes none of its zeros.
    """

    modes: Modes
    speeds: Number
    forces: Number
    value: Number
    slope: Number
    bend: Number
    steps: Number

    def third(self, of: Number, at: Number) -> Number:
        """Return third derivatives of event functions.

        ``of`` holds the indices of the functions, ``at`` the indices of the contacts.
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
        """Treat event functions that are zero at the beginning of the step.

        If a function rises, its step is lengthened away from the zero. If a function falls by more
        than rounding error, its event is entered in ``event``.
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
        """Set the step to the first zero of the event functions if this zero is near.

        No other function may have an earlier zero. The event is entered in ``event``.
        """
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
    """Return the first positive root h of value + slope h - most h^2/2, or infinity without a root.

    The value must be >= 0. The root is computed without cancellation.
    """
    square = slope * slope + 2.0 * most * value
    root = np.sqrt(np.maximum(square, 0.0))
    falls = slope < 0.0
    found = np.where(falls, 2.0 * value, root + slope + TINY) / np.where(
        falls, root - slope, np.maximum(most, 0.0)
    )
    return np.where(square < 0.0, INFINITE, found)
