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
"""Rounding error of an event function, as a fraction of its largest term. A function of a smaller
magnitude counts as zero."""

LEAST_STEP = 1e-6
"""Time step away from an instant at which an event function and its slope are zero, multiplied by
the natural angular frequency of the fast mode.

In this step the function changes by 1e-18 of its amplitude."""

# Second derivative, as a fraction of its bound, below which a step of ``LEAST_STEP`` cannot take
# the event function past zero.
STRAIGHT = 1e-8

FEW = 8  # a round stops when at most 1/FEW of its contacts are without an event

STEPS = 12  # largest number of steps in a round; contacts without an event go to the next round

# Time to a root, multiplied by the natural angular frequency of the fast mode, below which the
# third-order Taylor polynomial gives the root. Its error is NEAR^4/24 = 3e-15.
NEAR = 5e-4

REACH = 2.0
TANGENT = 1.2
"""Two limits of a step that follows from the bound of f'''. ``REACH``: the step multiplied by the
natural angular frequency of the fast mode. ``TANGENT``: the step divided by the time to the
tangent's root."""

# Step that is taken, as a fraction of the step in which a rising convex function stays convex by
# the bound of f'''.
CONVEX = 0.9

# Fraction of its amplitude that the fast oscillation is assumed to reach. A function that would
# reach zero only with the full amplitude counts as a near miss.
GRAZE = 1.0 - 1e-13

# Third derivative, as a fraction of its bound, below which a function counts as zero throughout if
# its lower derivatives are rounding error.
FLAT = 1e-10

WIDE = 1e3  # rounding error of a function that stays zero, divided by that of its terms

TINY = 1e-290  # added to a dividend so that 0/0 becomes infinite; other values do not change

# Squared natural angular frequency that is used in place of zero, to avoid a division by zero.
LEAST_RATE = 1e-300


class Modes(NamedTuple):
    """Constants of n contacts in stick: of their two modes and of their three event functions.

    In stick a contact is a pair of oscillators, the fast and the slow mode, in this order. Each has
    a velocity w and a force G. The first two event functions are zero at the two edges of the
    friction cone, the third one at the end of loading or unloading. They are c + sum_m [a_m
    cos(omega_m t) + b_m sin(omega_m t)/omega_m].

    Attributes:
        speeds: velocities w of the modes at the start of the phase, shape (2, n).
        forces: forces G of the modes at the start of the phase, shape (2, n).
        squares: squared natural angular frequencies of the modes, shape (2, n).
        rates: natural angular frequencies of the modes, replaced by a tiny value where zero, shape
            (2, n).
        cosines: coefficients a of the event functions, shape (2, 3, n).
        sines: coefficients b of the event functions, shape (2, 3, n).
        bends: bounds of the second derivatives of each mode's term, shape (2, 3, n).
        terms: factors of G from which the rounding error of the first two event functions follows,
            shape (2, n).
        constant: constant c of the third event function, shape (n,); those of the others are 0.
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
        """Return the constants of the contacts with the indices ``at`` alone."""
        return Modes(*(np.take(each, at, axis=-1) for each in self))


def both(pair: Number) -> Number:
    """Return the sum over the two modes, the first axis.

    For an axis of length two this is faster than NumPy's own sum.
    """
    return pair[0] + pair[1]


def harmonics(modes: Modes, time: Number) -> tuple[Number, Number, Number]:
    """Return cos(omega t), sin(omega t)/omega and tan(omega t/2)/omega of the two modes.

    omega is the natural angular frequency of a mode; it may be zero.
    """
    # By the tangent of the half angle, at a tenth of the cost of sine and cosine.
    half = np.tan(0.5 * modes.rates * time)
    scale = 1.0 / (1.0 + half * half)
    tangent = half / modes.rates
    return (1.0 - half * half) * scale, 2.0 * tangent * scale, tangent


def oscillators(modes: Modes, cosine: Number, sine: Number) -> tuple[Number, Number]:
    """Return the velocities w and the forces G of the two modes at a time.

    ``cosine`` and ``sine`` are the first two results of ``harmonics`` for this time.
    """
    speeds = modes.speeds * cosine + modes.squares * modes.forces * sine
    return speeds, modes.forces * cosine - modes.speeds * sine


def step_to_event(modes: Modes, settles: Number) -> tuple[Number, Number]:
    """Advance contacts in stick to their next events.

    The function stops when only a few contacts are left without an event. A contact for which
    ``settles`` is true does not advance, and its event is ``SETTLED``.

    Returns:
        The times since the start of the phase, and the events.
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
    """Return, for each contact, a time step in which no event occurs, and the event at its end.

    The step is 0 for a contact that is at an event already.
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
    """Return the rounding errors of the three event functions and of their slopes, shape (3, n)."""
    speeds, forces = oscillators(modes, cosine, sine)
    edge, slope = (NOISE * both(modes.terms * abs(each)) for each in (forces, speeds))
    return np.array([edge, edge, modes.line_noise]), np.array([slope, slope, 0.0 * slope])


def _taylor_root(
    value: Number, slope: Number, bend: Number, third: Number
) -> tuple[Number, Number]:
    """Return the root of the tangent, and the root near it of the third-order Taylor polynomial.

    The arguments are a function and its first three derivatives. Both roots are 0 where the slope
    is not negative.
    """
    tangent = np.where(slope < 0.0, -value / slope, 0.0)
    root = tangent
    for _ in range(2):
        rest = value + root * (slope + root * (0.5 * bend + root * third / 6.0))
        root = root - rest / (slope + root * (bend + 0.5 * root * third))
    return tangent, root


def _root(value: Number, slope: Number, most: Number) -> Number:
    """Return the first positive root h of value + slope h - most h^2/2, or infinity without one.

    ``value`` must be >= 0. The formula avoids cancellation.
    """
    square = slope * slope + 2.0 * most * value
    root = np.sqrt(np.maximum(square, 0.0))
    falls = slope < 0.0
    found = np.where(falls, 2.0 * value, root + slope + TINY) / np.where(
        falls, root - slope, np.maximum(most, 0.0)
    )
    return np.where(square < 0.0, INFINITE, found)
