"""Where stick on two springs ends: the first event of two oscillators, for arrays of contacts.

Stick ends where the force reaches an edge of the friction cone, mu N -+ T = 0; loading ends where v_n = 0, and unloading
where N returns to its largest value. Each of these functions f is a constant and two harmonics, so that |f''| <= M and
|f'''| <= M_3 with bounds known from the modes' amplitudes: f + f' h - M h^2/2, and up to h = r also f + f' h + (f'' - M_3 r/3) h^2/2,
bound f from below. The larger root of the two is a step that passes no root of f. Such steps converge on the first root faster
than Newton's method does, and pass a near miss. Where the rates differ much, the slow mode's parabola less the fast one's amplitude
allows longer ones. The last step goes to the root of the cubic of f itself. A step without end means that nothing ends the
contact: a jam, or stiction.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import INFINITE

NONE, LINE, FORWARD, BACKWARD, STOP, APART, NEVER, SETTLED = range(8)
"""How a step ends: in stick still; at the end of loading or back at it; at an edge of the cone, from where the spring's foot
slips forward or backward; where the foot stops; where the force ends; in no event at all; with the fast mode settled."""

NAMES = np.array([BACKWARD, FORWARD, LINE])
"""The event at a zero of each function."""

NOISE = 64.0 * sys.float_info.epsilon
"""Roundings of a function of the state, over its largest term: below it the function is zero."""

LEAST_STEP = 1e-6
"""Step over the fast mode's time scale that leaves an edge at which a function and its slopes are zero; it then moves by 1e-18."""

STRAIGHT = (
    1e-8  # bend of a function over its bound below which such a step cannot take it past zero
)

FEW = 8  # a fraction 1/8 of the contacts is worth the cost of gathering, or of leaving it to the next round

STEPS = 12  # steps after which those of the contacts that have no event yet wait for the next round

NEAR = 5e-4  # a root this near, over the fast mode's time scale, is that of the cubic: the fourth order is (NEAR)^4/24 = 3e-15

REACH = 2.0
TANGENT = 1.2
"""Longest step by the bound of f''', over the fast mode's time scale, and over the distance of the tangent's root."""

CONVEX = 0.9  # part of the step for which a function that rises and bends upwards does so by the bound of f'''

GRAZE = (
    1.0 - 1e-13
)  # a fast oscillation that reaches a zero by less than the rest of its amplitude does not reach it

FLAT = 1e-10  # third derivative over its bound, beside slopes of rounding, of a function that stays zero to as much

WIDE = 1e3  # roundings of a function that keeps to zero, over those of its terms

TINY = 1e-290  # over zero it is infinite, and beside any other number nothing

LEAST_RATE = 1e-300  # squared rate of a mode that has none


class Modes(NamedTuple):
    """Constants of a phase of stick, by mode (fast, slow) and by event function (edge, edge, line).

    At its beginning the oscillators are at w and G. A function is ``constant`` plus the modes' ``parts`` of G, or of w for the end
    of loading; ``terms`` bounds the terms of which the parts of the edges are sums. ``bend``, ``jerk`` bound its
    derivatives, ``swing`` its fast part and ``slow_bend`` the bend of its slow part.
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
        """Return the modes of some of the contacts."""
        return Modes(*(np.take(each, at, axis=-1) for each in self))


def both(pair: Number) -> Number:
    """Return the sum over the two modes; numpy's own is slow along so short an axis."""
    return pair[0] + pair[1]


def oscillators(modes: Modes, time: Number, *, sums: bool = False) -> tuple[Number, ...]:
    """Return the oscillators' w and G at times since the phase began, and the integral of G if ``sums``; rates of zero included."""
    # By the half angle's tangent, which costs a tenth of sine and cosine.
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


def step_to_event(modes: Modes, settles: Number, patient: bool) -> tuple[Number, Number]:
    """Step until few contacts are left without an event; return the times since the phase began, and the events."""
    times = np.zeros(settles.size)
    events = np.where(settles, SETTLED, NONE)
    going = np.flatnonzero(~settles)
    few = going.size // FEW
    modes = modes if going.size == settles.size else modes.chosen(going)
    time = np.zeros(going.size)
    for _ in range(STEPS):
        if going.size <= few:
            break
        step, event = _step(modes, time, patient)
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


def _step(modes: Modes, time: Number, patient: bool) -> tuple[Number, Number]:
    """Return a step that passes no event, and the event at its end; a contact that is at one stays there."""
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
    # The line's function is one of G, or at the end of loading of w, whose slope is lambda G.
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
    if patient:
        slow = parts[1] * forces[1]
        slow_slope = -modes.drifts * parts[1] * speeds[1]
        slow[2] = modes.constant + along[1] * np.where(loading, modes.drifts * speeds[1], forces[1])
        slow_slope[2] = along[1] * np.where(loading, gains[1], -modes.drifts * speeds[1])
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
    """The event functions of a step: the modes' w and G, values, slopes, bends, and steps that pass no zero of each."""

    modes: Modes
    speeds: Number
    forces: Number
    value: Number
    slope: Number
    bend: Number
    steps: Number

    def third(self, of: Number, at: Number) -> Number:
        """Return the third derivatives of functions ``of`` contacts ``at``."""
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
        """Step away from zeros of functions that rise, and note the events of functions that fall by more than rounding."""
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
        """Go to the first zero where it is near and no other function can have one before."""
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
    """Return the first positive root of value + slope h - most h^2/2, value >= 0, in the form that does not cancel; inf without one."""
    square = slope * slope + 2.0 * most * value
    root = np.sqrt(np.maximum(square, 0.0))
    falls = slope < 0.0
    found = np.where(falls, 2.0 * value, root + slope + TINY) / np.where(
        falls, root - slope, np.maximum(most, 0.0)
    )
    return np.where(square < 0.0, INFINITE, found)
