"""Stick on two springs: the modes of a contact that is elastic along its normal and along the surface.

In units in which the normal spring's loading stiffness is 1, a point in stick obeys

    N' = -kappa v_n,    T' = -v_t/eta^2,    (v_n, v_t)' = K (N, T),

kappa = 1 in loading and 1/e*^2 in unloading. With D = diag(kappa, 1/eta^2), w = D^(1/2) v and G = D^(-1/2) (N, T) this is
w' = S G, G' = -w with the symmetric S = D^(1/2) K D^(1/2). Turned by the angle of its eigenvectors it falls apart in two
oscillators of squared rates lambda_1 >= lambda_2 >= 0. lambda_1 lambda_2 = det S = kappa/eta^2 K_tt (K_nn - K_nt^2/K_tt), and the
last factor, the compliance in stick, may be given to more digits than K holds.

Stick ends where the force reaches an edge of the friction cone, mu N -+ T = 0; loading ends where v_n = 0, and unloading
where N returns to its largest value. Each of these functions f is a constant and two harmonics, so that |f''| <= M and
|f'''| <= M_3 with bounds known from the modes' amplitudes: f + f' h - M h^2/2, and up to h = r also f + f' h + (f'' - M_3 r/3) h^2/2,
bound f from below. The larger root of the two is a step that passes no root of f. Such steps converge on the first root faster
than Newton's method does, and pass a near miss. Where the rates differ much, the slow mode's parabola less the fast one's amplitude
allows longer ones. A step without end means that nothing ends the contact: a jam, or stiction.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import INFINITE, KNIFE_EDGE

NONE, LINE, FORWARD, BACKWARD, STOP, APART, NEVER, SETTLED = range(8)
"""How a step ends: in stick still; at the end of loading or back at it; at an edge of the cone, from where the spring's foot
slips forward or backward; where the foot stops; where the force ends; in no event at all; with the fast mode settled."""

NOISE = 64.0 * sys.float_info.epsilon
"""Roundings of a function of the state, over its largest term: below it the function is zero."""

LEAST_STEP = 1e-6
"""Step over the fast mode's time scale that leaves an edge at which a function and its slopes are zero; it then moves by 1e-18."""

STRAIGHT = 1e-8  # bend of a function over its bound below which such a step cannot take it past zero

FEW = 8  # a fraction 1/8 of the contacts is worth the cost of gathering, or of leaving it to the next round

STEPS = 12  # steps after which those of the contacts that have no event yet wait for the next round

REACH, TANGENT = 2.0, 1.2
"""Longest step by the bound of f''', over the fast mode's time scale, and over the distance of the tangent's root."""

CONVEX = 0.9  # part of the step for which a function that rises and bends upwards does so by the bound of f'''

GRAZE = 1.0 - 1e-13  # a fast oscillation that reaches a zero by less than the rest of its amplitude does not reach it

FLAT = 1e-10  # third derivative over its bound, beside slopes of rounding, of a function that stays zero to as much

WIDE = 1e3  # roundings of a function that keeps to zero, over those of its terms

TINY = 1e-290  # over zero it is infinite, and beside any other number nothing

LEAST_RATE = 1e-300  # squared rate of a mode that has none

STEEPEST_CONE = 1e150  # tangent of the cone's angle in the modes' units beyond which it is a half-plane


class Bodies(NamedTuple):
    """What does not change in an impact: K by its entries, its compliance in stick, K_nt/K_tt, coefficients, and eta."""

    normal: Number
    coupling: Number
    tangential: Number
    stick: Number
    tie: Number
    friction: Number
    restitution_friction: Number
    restitution: Number
    eta: Number
    approach: Number


class Motion(NamedTuple):
    """Velocity, normal and tangential force (push, rub), largest push; sqrt(kappa) and mu of the line; slip of the foot.

    ``loading`` is 1 in loading and 0 in unloading, ``steep`` 1 in loading and 1/e* in unloading, ``slip`` the sense in which the
    tangential spring's foot slides, 0 in stick.
    """

    normal: Number
    tangential: Number
    push: Number
    rub: Number
    peak: Number
    loading: Number
    steep: Number
    friction: Number
    slip: Number


class _Modes(NamedTuple):
    """What does not change in a phase of stick; by mode (fast, slow), and by event function (edge, edge, line).

    At its beginning the oscillators are at w and G. A function is ``constant`` plus the modes' ``parts`` of G, or of w for the end
    of loading; ``terms`` bounds what the parts of the edges add up of. ``bend``, ``jerk`` bound its derivatives, ``swing`` its fast
    part and ``slow_bend`` the bend of its slow part.
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
    reach: Number
    swing: Number
    slow_bend: Number
    drifts: Number


def stick(bodies: Bodies, motion: Motion, settles: Number, patient: bool) -> tuple[Motion, Number, tuple[Number, ...]]:
    """Advance to the end of a phase of stick; return motion, event, and impulses and works along the normal and the surface.

    Where ``settles``, the fast mode's swing is taken from the motion instead, with the energy that it holds. Few may be left
    without an event; without patience those whose rates differ much are.
    """
    steep, eta = motion.steep, bodies.eta
    modes, turn = _modes(bodies, motion)
    time, event = _followed(modes, settles, patient)
    (w_1, w_2), (g_1, g_2), (sum_1, sum_2) = _state(modes, time, sums=True)
    # One degree of freedom that is pressed on across its line has no end.
    pressed = (bodies.stick == 0.0) & (modes.drifts * turn[1] * w_2 > 0.0)
    event = np.where((event == SETTLED) & pressed, NEVER, event)
    still = (event == NEVER) | (event == SETTLED)
    moved = still | (time > 0.0)  # no rounding where nothing happens
    cosine, sine = turn

    def seen(w_1: Number, g_1: Number) -> tuple[Number, Number, Number, Number]:
        """Return v_n, v_t, N and T for the fast mode's w and G."""
        return (
            np.where(moved, (cosine * w_1 - sine * w_2) / steep, motion.normal),
            np.where(moved, (sine * w_1 + cosine * w_2) * eta, motion.tangential),
            np.where(moved, steep * (cosine * g_1 - sine * g_2), motion.push),
            np.where(moved, (sine * g_1 + cosine * g_2) / eta, motion.rub),
        )

    normal, tangential, push, rub = ends = seen(w_1, g_1)
    done = (
        steep * (cosine * sum_1 - sine * sum_2),
        (sine * sum_1 + cosine * sum_2) / eta,
        0.5 * (motion.push - push) * (motion.push + push) / (steep * steep),
        0.5 * (motion.rub - rub) * (motion.rub + rub) * eta * eta,
    )
    if still.any():  # stopping the fast mode takes an impulse
        last = np.where(still, -w_1 / modes.squares[0], 0.0)
        ends = seen(np.where(still, 0.0, w_1), np.where(event == SETTLED, 0.0, g_1))
        impulse = steep * cosine * last, sine * last / eta
        works = 0.5 * impulse[0] * (normal + ends[0]), 0.5 * impulse[1] * (tangential + ends[1])
        done = tuple(part + more for part, more in zip(done, (*impulse, *works), strict=True))
    return motion._replace(normal=ends[0], tangential=ends[1], push=ends[2], rub=ends[3]), event, done


def _modes(bodies: Bodies, motion: Motion) -> tuple[_Modes, tuple[Number, Number]]:
    """Return the two oscillators of a motion, and cosine and sine of the rotation that makes S diagonal."""
    steep, eta, loading = motion.steep, bodies.eta, motion.loading > 0.0
    along, across = steep * steep * bodies.normal, bodies.tangential / (eta * eta)
    coupling, half = steep / eta * bodies.coupling, 0.5 * (along - across)
    radius = np.sqrt(half * half + coupling * coupling)
    first = np.maximum(0.5 * (along + across) + radius, LEAST_RATE)
    second = steep * steep * across * bodies.stick / first
    squares = np.array([first, second])
    rates = np.sqrt(np.maximum(squares, LEAST_RATE))

    # The larger component of the eigenvector is the one that does not cancel; equal rates have any.
    large = abs(half) + radius
    scale = 1.0 / np.sqrt(large * large + coupling * coupling)
    one, other = np.where(large > 0.0, large * scale, 1.0), np.where(large > 0.0, coupling * scale, 0.0)
    upright = half >= 0.0
    cosine, sine = np.where(upright, one, other), np.where(upright, other, one)

    def turned(along: Number, across: Number) -> Number:
        return np.array([cosine * along + sine * across, cosine * across - sine * along])

    speeds, forces = (
        turned(steep * motion.normal, motion.tangential / eta),
        turned(motion.push / steep, motion.rub * eta),
    )
    swings = np.sqrt(speeds * speeds + squares * forces * forces)
    # One degree of freedom drifts across its line; as little as rounding makes is none.
    drifts = (second > 0.0) | (abs(speeds[1]) > KNIFE_EDGE * bodies.approach)

    # Edges of the cone T = mu N and T = -mu N, over sqrt(1 + mu^2) in the modes' units, and the line.
    angle = np.minimum(motion.friction * steep * eta, STEEPEST_CONE)
    aside = 1.0 / np.sqrt(1.0 + angle * angle)
    up = angle * aside
    parts = np.array(
        [
            [up * cosine - aside * sine, up * cosine + aside * sine, -cosine],
            [-up * sine - aside * cosine, aside * cosine - up * sine, sine],
        ]
    )
    sizes = abs(np.array([cosine, sine]))
    bends = abs(parts) * np.where(squares > 0.0, swings * rates, 0.0)[:, np.newaxis]
    bends[:, 2] *= np.where(loading, rates, 1.0)
    peak = motion.peak / steep
    terms, line_noise = up * sizes + aside * sizes[::-1], NOISE * np.where(loading, _both(sizes * swings), peak)
    close = np.empty_like(bends[0])
    close[:2], close[2] = WIDE * NOISE * _both(terms * (swings / rates)), WIDE * line_noise
    return _Modes(
        speeds,
        forces,
        squares,
        rates,
        parts,
        terms=terms,
        constant=np.where(loading, 0.0, peak),
        line_noise=line_noise,
        loading=loading,
        close=close,
        bend=_both(bends),
        jerk=_both(bends * rates[:, np.newaxis]) / 3.0,
        reach=REACH / rates[0],
        swing=bends[0] / first,
        slow_bend=bends[1],
        drifts=drifts.astype(float),
    ), (cosine, sine)


def _both(pair: Number) -> Number:
    """Return the sum over the two modes; numpy's own is slow along so short an axis."""
    return pair[0] + pair[1]


def _state(modes: _Modes, time: Number, *, sums: bool = False) -> tuple[Number, ...]:
    """Return the oscillators' w and G at times since the phase began, and the integral of G if ``sums``; rates of zero included."""
    # By the half angle's tangent, which costs a tenth of sine and cosine.
    half = np.tan(0.5 * modes.rates * time)
    scale = 1.0 / (1.0 + half * half)
    cosines, ways = (1.0 - half * half) * scale, half / modes.rates
    sines = 2.0 * ways * scale
    speeds = modes.speeds * cosines + modes.squares * modes.forces * sines
    forces = modes.forces * cosines - modes.speeds * sines
    if not sums:
        return speeds, forces
    return speeds, forces, sines * (modes.forces - modes.speeds * ways)


def _followed(modes: _Modes, settles: Number, patient: bool) -> tuple[Number, Number]:
    """Step until few contacts are left without an event; return the times since the phase began, and the events."""
    times, events = np.zeros(settles.size), np.where(settles, SETTLED, NONE)
    going = np.flatnonzero(~settles)
    few = going.size // FEW
    modes, time = _chosen(modes, going), np.zeros(going.size)
    for _ in range(STEPS):
        if going.size <= few:
            break
        step, event = _step(modes, time, patient)
        time = time + step
        over = np.count_nonzero(event)
        if FEW * over >= going.size or going.size - over <= few:
            times[going], events[going] = time, event
            left = np.flatnonzero(event == NONE)
            going, modes, time = going[left], _chosen(modes, left), time[left]
    times[going] = time
    return times, events


def _chosen(modes: _Modes, at: Number) -> _Modes:
    """Return the modes of some of the contacts."""
    return _Modes(*(np.take(each, at, axis=-1) for each in modes))


def _step(modes: _Modes, time: Number, patient: bool) -> tuple[Number, Number]:
    """Return a step that passes no event, and the event; a contact that is at one stays there."""
    speeds, forces = _state(modes, time)
    loading, parts, squares = modes.loading, modes.parts, modes.squares
    gains = squares * forces
    value, slope, bend = np.empty_like(modes.bend), np.empty_like(modes.bend), np.empty_like(modes.bend)
    value[:2] = parts[0, :2] * forces[0] + parts[1, :2] * forces[1]
    slope[:2] = -(parts[0, :2] * speeds[0] + parts[1, :2] * speeds[1])
    bend[:2] = -(parts[0, :2] * gains[0] + parts[1, :2] * gains[1])
    # The line's function is one of G, or at the end of loading of w, whose slope is lambda G.
    across, inclined, along = np.where(loading, speeds, forces), np.where(loading, gains, -speeds), parts[:, 2]
    value[2] = modes.constant + along[0] * across[0] + along[1] * across[1]
    slope[2] = along[0] * inclined[0] + along[1] * inclined[1]
    bend[2] = -(along[0] * squares[0] * across[0] + along[1] * squares[1] * across[1])

    above = np.maximum(value, 0.0)
    reach = np.minimum(np.where(slope < 0.0, TANGENT * above / -slope, INFINITE), modes.reach)
    steps = np.minimum(_root(above, slope, np.minimum(modes.jerk * reach - bend, modes.bend)), reach)
    steps = np.fmax(steps, np.where(slope >= 0.0, CONVEX * bend / modes.jerk, 0.0))
    if patient:
        slow, slow_slope = parts[1] * forces[1], -modes.drifts * parts[1] * speeds[1]
        slow[2] = modes.constant + along[1] * np.where(loading, modes.drifts * speeds[1], forces[1])
        slow_slope[2] = along[1] * np.where(loading, gains[1], -modes.drifts * speeds[1])
        clear = slow - GRAZE * modes.swing
        longer = _root(np.maximum(clear, 0.0), slow_slope, modes.slow_bend)
        steps = np.where(clear > 0.0, np.maximum(steps, longer), steps)
    event = np.zeros(time.size, dtype=int)
    close = np.nonzero(value <= modes.close)
    if close[0].size:
        of, at = close
        line, terms, rate = of == 2, modes.terms[:, at], modes.rates[0, at]
        noise, slope_noise = (NOISE * _both(terms * abs(each[:, at])) for each in (forces, speeds))
        noise, slope_noise = np.where(line, modes.line_noise[at], noise), np.where(line, 0.0, slope_noise)
        jerk = np.where(line, INFINITE, _both(squares[:, at] * parts[:, of, at] * speeds[:, at]))
        near = [*(each[close] for each in (steps, value, slope, bend, modes.bend)), noise, slope_noise, rate, jerk]
        steps[close], falls = _at_zero(*near)
        for function, name in ((0, BACKWARD), (1, FORWARD), (2, LINE)):
            event[at[falls & (of == function)]] = name
    step = np.minimum(np.minimum(steps[0], steps[1]), steps[2])
    event = np.where((step == INFINITE) & (event == NONE), NEVER, event)
    parted = ~loading & (value[2] >= modes.constant * (1.0 - NOISE)) & (slope[2] > 0.0)
    event = np.where(parted, APART, event)
    return np.where(event == NONE, step, 0.0), event


def _at_zero(
    step: Number,
    value: Number,
    slope: Number,
    bend: Number,
    most: Number,
    noise: Number,
    slope_noise: Number,
    rate: Number,
    jerk: Number,
) -> tuple[Number, Number]:
    """Return the step from a zero of a function that leaves it, and whether it falls instead, by more than rounding."""
    # On the border of stick, with modes of equal rates, the force keeps to the edge.
    flat = (abs(slope) <= WIDE * slope_noise) & (abs(bend) <= WIDE * rate * slope_noise)
    flat &= (abs(jerk) <= FLAT * rate * most) & (value <= WIDE * noise)
    zero, slope = value <= noise, np.where(abs(slope) <= slope_noise, 0.0, slope)
    square, dip = slope * slope, 2.0 * noise * bend
    lift = np.where(most > 0.0, bend / (rate * most), 0.0)
    leaves = np.where(zero & (bend >= -STRAIGHT * most), np.maximum(lift, LEAST_STEP / rate), 0.0)
    falls = np.where(slope < 0.0, square > dip, square < -dip)
    return np.where(flat, INFINITE, np.maximum(step, leaves)), falls & zero & ~flat


def _root(value: Number, slope: Number, most: Number) -> Number:
    """Return the first positive root of value + slope h - most h^2/2, value >= 0, in the form that does not cancel; inf without one."""
    square = slope * slope + 2.0 * most * value
    root, falls = np.sqrt(np.maximum(square, 0.0)), slope < 0.0
    found = np.where(falls, 2.0 * value, root + slope + TINY) / np.where(falls, root - slope, np.maximum(most, 0.0))
    return np.where(square < 0.0, INFINITE, found)
