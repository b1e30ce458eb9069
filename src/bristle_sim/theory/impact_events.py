"""The end of stick on two springs: the first event of two oscillators, for arrays of contacts.

Stick ends where the force reaches an edge of the friction cone, mu N -+ T = 0. Loading ends where
v_n = 0, and unloading ends where N returns to its largest value. These three event functions are
each a constant plus two harmonics,

    f(t) = c + sum_m [a_m cos(omega_m t) + b_m sin(omega_m t)/omega_m],

so |f''| <= M and |f'''| <= M_3, with bounds from the amplitudes of the modes. Two parabolas bound f from below after a step h: f + f' h - M h^2/2, and up to h = r
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

    Attributes:
        speeds: velocities w of the modes at the beginning of the phase, shape (2, n).
        forces: forces G of the modes at the beginning of the phase, shape (2, n).
        squares: squared natural rates of the modes, shape (2, n).
        rates: natural rates of the modes, never zero, shape (2, n).
        cosines: factors a of the event functions, shape (2, 3, n).
        sines: factors b of the event functions, shape (2, 3, n).
        bends: bounds of the second derivatives of the event functions' parts, shape (2, 3, n).
        terms: bounds of the terms whose sums are the coefficients of G in the two edges, (2, n).
        constant: constant c of the third event function, shape (n,).
        line_noise: rounding error of the third event function, shape (n,).
        loading: whether the contact loads, shape (n,).
        drifts: 0 where the slow mode is at rest, otherwise 1, shape (n,).
    """

    speeds: Number
    forces: Number
    squares: Number
    rates: Number
    cosines: Number
    sines: Number
    bends: Number
    terms: Number
    constant: Number
    line_noise: Number
    loading: Number
    drifts: Number

    def chosen(self, at: Number) -> Modes:
        """Return the constants of the contacts with indices ``at``."""
        return Modes(*(np.take(each, at, axis=-1) for each in self))


def both(pair: Number) -> Number:
    """Return the sum over the two modes.

    It is faster than NumPy's own sum along so short an axis.
    """
    return pair[0] + pair[1]


def harmonics(modes: Modes, time: Number) -> tuple[Number, Number, Number]:
    """Return cos(omega t), sin(omega t)/omega and tan(omega t/2)/omega of the two modes.

    A natural rate omega of zero is permitted.
    """
    # By the tangent of the half angle, at a tenth of the cost of sine and cosine.
    half = np.tan(0.5 * modes.rates * time)
    scale = 1.0 / (1.0 + half * half)
    tangent = half / modes.rates
    return (1.0 - half * half) * scale, 2.0 * tangent * scale, tangent


def oscillators(modes: Modes, cosine: Number, sine: Number) -> tuple[Number, Number]:
    """Return the velocities w and the forces G of the two modes.

    ``cosine`` and ``sine`` are the first two results of ``harmonics``.
    """
    speeds = modes.speeds * cosine + modes.squares * modes.forces * sine
    return speeds, modes.forces * cosine - modes.speeds * sine


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
    modes = modes.chosen(going)
    for _ in range(STEPS):
        if going.size <= few:
            break
        step, event = _step(modes, times[going])
        times[going] += step
        events[going] = event
        left = event == NONE
        going = going[left]
        modes = modes.chosen(np.flatnonzero(left))
    return times, events


def _step(modes: Modes, time: Number) -> tuple[Number, Number]:
    """Return, for each contact, a time step that passes no event, and the event at its end.

    A contact that is at an event has a step of 0.
    """
    cosine, sine, _ = harmonics(modes, time)
    squares = modes.squares[:, np.newaxis]
    values = modes.cosines * cosine[:, np.newaxis] + modes.sines * sine[:, np.newaxis]
    slopes = modes.sines * cosine[:, np.newaxis] - modes.cosines * (squares * sine[:, np.newaxis])
    value = both(values)
    value[2] += modes.constant
    slope = both(slopes)
    bend = -both(squares * values)
    third = -both(squares * slopes)
    bends = modes.bends
    most = both(bends)
    jerk = both(modes.rates[:, np.newaxis] * bends) / 3.0
    rate = modes.rates[0]

    above = np.maximum(value, 0.0)
    reach = REACH / rate
    tangents = np.minimum(np.where(slope < 0.0, TANGENT * above / -slope, INFINITE), reach)
    nearest = _root(above, slope, np.minimum(jerk * tangents - bend, most))
    steps = np.minimum(nearest, tangents)
    steps = np.fmax(steps, np.where(slope >= 0.0, CONVEX * bend / jerk, 0.0))
    clear = values[1] - GRAZE * bends[0] / modes.squares[0]
    clear[2] += modes.constant
    longer = _root(np.maximum(clear, 0.0), modes.drifts * slopes[1], bends[1])
    steps = np.where(clear > 0.0, np.maximum(steps, longer), steps)

    noise, slope_noise = _roundings(modes, cosine, sine)
    zero = value <= noise
    # On the border of stick, with modes of equal rates, the force keeps to the edge.
    flat = (abs(slope) <= WIDE * slope_noise) & (abs(bend) <= WIDE * rate * slope_noise)
    flat &= (abs(third) <= FLAT * rate * most) & (value <= WIDE * noise)
    flat[2] = False
    slope = np.where(abs(slope) <= slope_noise, 0.0, slope)
    dip = 2.0 * noise * bend
    falls = np.where(slope < 0.0, slope * slope > dip, slope * slope < -dip) & zero & ~flat
    lift = np.where(most > 0.0, bend / (rate * most), 0.0)
    rises = zero & (bend >= -STRAIGHT * most)
    steps = np.fmax(steps, np.where(rises, np.maximum(lift, LEAST_STEP / rate), 0.0))
    steps = np.where(flat, INFINITE, steps)

    first, second, _ = np.sort(steps, axis=0)
    event = np.where(first == INFINITE, NEVER, NONE)
    for name, at_zero in zip(NAMES, falls, strict=True):
        event[at_zero] = name
    apart = ~modes.loading & (value[2] >= modes.constant * (1.0 - NOISE)) & (slope[2] > 0.0)
    event[apart] = APART
    step = np.where(event == NONE, first, 0.0)
    near = np.flatnonzero((event == NONE) & (step * rate < NEAR))
    of = np.argmin(steps[:, near], axis=0)
    tangent, root = _taylor_root(*(each[of, near] for each in (value, slope, bend, third)))
    # Where all of the contact's force ends, both edges are zero up to the rounding of its amplitude.
    edge = NOISE * both(modes.terms * np.hypot(modes.speeds / modes.rates, modes.forces))
    good = value[of, near] > WIDE * np.array([edge, edge, modes.line_noise])[of, near]
    good &= (abs(root - tangent) < 0.1 * tangent) & (root <= second[near])
    step[near[good]] = root[good]
    event[near[good]] = NAMES[of[good]]
    return step, event


def _roundings(modes: Modes, cosine: Number, sine: Number) -> tuple[Number, Number]:
    """Return the rounding errors of the event functions and of their slopes, shape (3, n)."""
    speeds, forces = oscillators(modes, cosine, sine)
    edge, slope = (NOISE * both(modes.terms * abs(each)) for each in (forces, speeds))
    return np.array([edge, edge, modes.line_noise]), np.array([slope, slope, 0.0 * slope])


def _taylor_root(
    value: Number, slope: Number, bend: Number, third: Number
) -> tuple[Number, Number]:
    """Return the zero of the tangent, and that of the third-order Taylor polynomial near it.

    Both are 0 where the function does not fall.
    """
    tangent = np.where(slope < 0.0, -value / slope, 0.0)
    root = tangent
    for _ in range(2):
        rest = value + root * (slope + root * (0.5 * bend + root * third / 6.0))
        root = root - rest / (slope + root * (bend + 0.5 * root * third))
    return tangent, root


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
