"""Stick on two springs: the modes of a contact that is elastic along its normal and along the surface.

In units in which the normal spring's loading stiffness is 1, a point in stick obeys

    N' = -kappa v_n,    T' = -v_t/eta^2,    (v_n, v_t)' = K (N, T),

kappa = 1 in loading and 1/e*^2 in unloading. With D = diag(kappa, 1/eta^2), w = D^(1/2) v and G = D^(-1/2) (N, T) this is
w' = S G, G' = -w with the symmetric S = D^(1/2) K D^(1/2). Turned by the angle of its eigenvectors it falls apart in two
oscillators of squared rates lambda_1 >= lambda_2 >= 0. lambda_1 lambda_2 = det S = kappa/eta^2 K_tt (K_nn - K_nt^2/K_tt), and the
last factor, the compliance in stick, may be given to more digits than K holds.

Stick ends where the force reaches an edge of the friction cone, mu N -+ T = 0; loading ends where v_n = 0, and unloading
where N returns to its largest value. Each of these functions f is a constant and two harmonics, so that |f''| <= M with M known
from the modes' amplitudes, and f + f' h - M h^2/2 bounds f from below. Its root is a step that passes no root of f. Such steps
converge on the first root as Newton's method does, and pass a near miss. Two further bounds lengthen them: f''' where f
rises from an edge that it has just left, and the slow mode's parabola less the fast one's amplitude where the rates
differ much. A step without end means that nothing ends the contact: a jam, or stiction.
"""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_phases import (
    INFINITE,
    KNIFE_EDGE,
    divided,
    inverse,
    larger,
    negated,
    select,
    smaller,
    square_root,
    tangent,
)

NONE, LINE, FORWARD, BACKWARD, STOP, APART, NEVER, SETTLED = range(8)
"""How a step ends: in stick still; at the end of loading or back at it; at an edge of the cone, from where the spring's foot
slips forward or backward; where the foot stops; where the force ends; in no event at all; with the fast mode settled."""

NOISE = 64.0 * sys.float_info.epsilon
"""Roundings of a function of the state, over its largest term: below it the function is zero."""

LEAST_STEP = 1e-6
"""Step over the fast mode's time scale that leaves an edge at which a function and its slopes are zero; it then moves by 1e-18."""

STRAIGHT = 1e-8  # bend of a function over its bound below which such a step cannot take it past zero

FEW = 8  # a fraction 1/8 of the contacts is worth the cost of gathering, or of leaving it to the next round

STEPS = 12  # steps after which those of an array's contacts that have no event yet wait for the next round

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

    ``steep`` is 1 in loading and 1/e* in unloading, ``slip`` the sense in which the tangential spring's foot slides, 0 in stick.
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


class Done(NamedTuple):
    """Impulses and works of a step, normal and tangential."""

    normal: Number
    tangential: Number
    normal_work: Number
    tangential_work: Number


class _Swings(NamedTuple):
    """The oscillators' w and G, the integrals of G since the phase began, and the time since then."""

    speed_1: Number
    speed_2: Number
    force_1: Number
    force_2: Number
    sum_1: Number
    sum_2: Number
    time: Number


class _Bound(NamedTuple):
    """An event function's bounds: M of its second derivative, of its fast part, of its slow part's second derivative; 1/(omega_1 M)."""

    bend: Number
    fast: Number
    slow_bend: Number
    lift: Number


class _Modes(NamedTuple):
    """What does not change in a phase: eigenvector of the fast mode, squared rates, rates, and the event functions.

    The edges of the cone are a_1 G_1 + a_2 G_2 and b_1 G_1 + b_2 G_2; ``terms`` bounds what their terms add up of.
    """

    cosine: Number
    sine: Number
    first: Number
    second: Number
    fast: Number
    slow: Number
    drifts: Number
    a_1: Number
    a_2: Number
    b_1: Number
    b_2: Number
    terms_1: Number
    terms_2: Number
    line_noise: Number
    loading: Number
    peak: Number
    a: _Bound
    b: _Bound
    line: _Bound


def stick(bodies: Bodies, motion: Motion, settles: Number, patient: bool = True) -> tuple[Motion, Number, Done]:
    """Advance to the end of a phase of stick; return motion, event, impulses and works.

    Where ``settles``, the fast mode's swing is taken from the motion instead, with the energy that it holds. Of arrays few may be
    left without an event; without patience those whose rates differ much are, and those without end.
    """
    steep, eta = motion.steep, bodies.eta
    modes, swings = _modes(bodies, motion)
    swings, event = _followed(modes, swings, settles, patient)
    # One degree of freedom that is pressed on across its line has no end.
    pressed = (bodies.stick == 0.0) & (modes.drifts * modes.sine * swings.speed_2 > 0.0)
    event = select((event == SETTLED) & pressed, NEVER, event)
    still = (event == NEVER) | (event == SETTLED)
    moved = still | (swings.time > 0.0)  # no rounding where nothing happens

    def seen(speeds: tuple[Number, Number], forces: tuple[Number, Number]) -> tuple[Number, Number, Number, Number]:
        """Return v_n, v_t, N and T of the modes' w and G."""
        cosine, sine = modes.cosine, modes.sine
        return (
            select(moved, (cosine * speeds[0] - sine * speeds[1]) / steep, motion.normal),
            select(moved, (sine * speeds[0] + cosine * speeds[1]) * eta, motion.tangential),
            select(moved, steep * (cosine * forces[0] - sine * forces[1]), motion.push),
            select(moved, (sine * forces[0] + cosine * forces[1]) / eta, motion.rub),
        )

    w_1, w_2, g_1, g_2, sum_1, sum_2, _ = swings
    normal, tangential, push, rub = seen((w_1, w_2), (g_1, g_2))
    works = (
        0.5 * (motion.push - push) * (motion.push + push) / (steep * steep),
        0.5 * (motion.rub - rub) * (motion.rub + rub) * eta * eta,
    )
    # Stopping the fast mode takes an impulse.
    last = select(still, -w_1 / modes.first, 0.0)
    ends = seen((select(still, 0.0, w_1), w_2), (select(event == SETTLED, 0.0, g_1), g_2))
    last_normal, last_tangential = steep * modes.cosine * last, modes.sine * last / eta
    done = Done(
        steep * (modes.cosine * sum_1 - modes.sine * sum_2) + last_normal,
        (modes.sine * sum_1 + modes.cosine * sum_2) / eta + last_tangential,
        works[0] + 0.5 * last_normal * (normal + ends[0]),
        works[1] + 0.5 * last_tangential * (tangential + ends[1]),
    )
    return motion._replace(normal=ends[0], tangential=ends[1], push=ends[2], rub=ends[3]), event, done


def _modes(bodies: Bodies, motion: Motion) -> tuple[_Modes, _Swings]:
    """Return the two oscillators of a motion, by the rotation that makes S diagonal, and their state."""
    steep, eta, none = motion.steep, bodies.eta, 0.0 * motion.steep
    along, across = steep * steep * bodies.normal, bodies.tangential / (eta * eta)
    coupling, half = steep / eta * bodies.coupling, 0.5 * (along - across)
    radius = square_root(half * half + coupling * coupling)
    first = larger(0.5 * (along + across) + radius, LEAST_RATE)
    second = steep * steep * across * bodies.stick / first
    singular = second == 0.0
    fast, slow = square_root(first), square_root(larger(second, LEAST_RATE))

    # The larger component of the eigenvector is the one that does not cancel; equal rates have any.
    large = abs(half) + radius
    scale = inverse(square_root(large * large + coupling * coupling))
    one, other = select(large > 0.0, large * scale, 1.0), select(large > 0.0, coupling * scale, 0.0)
    upright = half >= 0.0
    cosine, sine = select(upright, one, other), select(upright, other, one)

    speeds, forces = (steep * motion.normal, motion.tangential / eta), (motion.push / steep, motion.rub * eta)
    w_1, w_2 = cosine * speeds[0] + sine * speeds[1], cosine * speeds[1] - sine * speeds[0]
    g_1, g_2 = cosine * forces[0] + sine * forces[1], cosine * forces[1] - sine * forces[0]
    swing_1, swing_2 = square_root(w_1 * w_1 + first * g_1 * g_1), square_root(w_2 * w_2 + second * g_2 * g_2)
    # One degree of freedom drifts across its line; as little as rounding makes is none.
    drifts = negated(singular & (abs(w_2) <= KNIFE_EDGE * bodies.approach))
    bend_1, bend_2 = fast * swing_1, select(singular, 0.0, slow * swing_2)

    # Edges of the cone T = mu N and T = -mu N, over sqrt(1 + mu^2) in the modes' units.
    angle = smaller(motion.friction * steep * eta, STEEPEST_CONE)
    aside = 1.0 / square_root(1.0 + angle * angle)
    up = angle * aside
    a_1, a_2, b_1, b_2 = (
        up * cosine - aside * sine,
        -up * sine - aside * cosine,
        up * cosine + aside * sine,
        aside * cosine - up * sine,
    )
    size_1, size_2, loading = abs(cosine), abs(sine), motion.loading
    fast_scale, slow_scale = select(loading, fast, 1.0), select(loading, slow, 1.0)
    line = _bound(
        fast,
        size_1 * bend_1 * fast_scale + size_2 * bend_2 * slow_scale,
        size_1 * swing_1 * fast_scale / fast,
        size_2 * bend_2 * slow_scale,
    )
    terms = up * size_1 + aside * size_2, up * size_2 + aside * size_1
    a = _bound(fast, abs(a_1) * bend_1 + abs(a_2) * bend_2, abs(a_1) * swing_1 / fast, abs(a_2) * bend_2)
    b = _bound(fast, abs(b_1) * bend_1 + abs(b_2) * bend_2, abs(b_1) * swing_1 / fast, abs(b_2) * bend_2)
    fixed = (cosine, sine, first, second, fast, slow, select(drifts, 1.0, 0.0), a_1, a_2, b_1, b_2, *terms)
    peak = motion.peak / steep
    line_noise = NOISE * select(loading, size_1 * swing_1 + size_2 * swing_2, peak)
    modes = _Modes(*fixed, line_noise, loading, peak, a, b, line)
    return modes, _Swings(w_1, w_2, g_1, g_2, none, none, none)


def _bound(rate: Number, bend: Number, fast: Number, slow_bend: Number) -> _Bound:
    return _Bound(bend, fast, slow_bend, select(bend > 0.0, inverse(rate * bend), 0.0))


def _followed(modes: _Modes, swings: _Swings, settles: Number, patient: bool) -> tuple[_Swings, Number]:
    """Step until every contact has its event; of arrays until few have none, which are left without one."""
    if isinstance(settles, bool):
        event = SETTLED if settles else NONE
        while event == NONE:
            swings, event = _stepped(modes, swings, patient)
        return swings, event
    ends = _Swings(*(np.array(each) for each in swings))
    events = np.where(settles, SETTLED, NONE)
    going = np.flatnonzero(~settles)
    few = going.size // FEW
    modes, swings = _chosen(modes, going), _Swings(*(each[going] for each in swings))
    for _ in range(STEPS):
        if going.size <= few:
            break
        swings, event = _stepped(modes, swings, patient)
        over = np.count_nonzero(event)
        if FEW * over >= going.size or going.size - over <= few:
            for whole, part in zip(ends, swings, strict=True):
                whole[going] = part
            events[going] = event
            left = np.flatnonzero(event == NONE)
            going, modes, swings = going[left], _chosen(modes, left), _Swings(*(each[left] for each in swings))
    for whole, part in zip(ends, swings, strict=True):
        whole[going] = part
    return ends, events


def _chosen(modes: _Modes, at: Any) -> _Modes:
    """Return the modes of some of the contacts."""
    chosen: list[Any] = [each if isinstance(each, bool) else each[at] for each in modes[:-3]]
    return _Modes(*chosen, *(_Bound(*(each[at] for each in bound)) for bound in modes[-3:]))


def _stepped(modes: _Modes, swings: _Swings, patient: bool) -> tuple[_Swings, Number]:
    """Take a step that passes no event; a contact that is at one stays there."""
    w_1, w_2, g_1, g_2, sum_1, sum_2, time = swings
    first, second, fast, loading, drift = modes.first, modes.second, modes.fast, modes.loading, modes.drifts * w_2
    noise = NOISE * (modes.terms_1 * abs(g_1) + modes.terms_2 * abs(g_2))
    slope_noise = NOISE * (modes.terms_1 * abs(w_1) + modes.terms_2 * abs(w_2))
    found = []
    for one, two, bound in ((modes.a_1, modes.a_2, modes.a), (modes.b_1, modes.b_2, modes.b)):
        part_1, part_2 = one * g_1, two * g_2
        speed_1, speed_2 = one * w_1, two * w_2
        here = part_1 + part_2, -(speed_1 + speed_2), -(first * part_1 + second * part_2)
        jerk = first * speed_1 + second * speed_2
        found.append(_step(here, bound, (part_2, -two * drift) if patient else None, (noise, slope_noise), fast, jerk))

    cosine, sine, peak = modes.cosine, modes.sine, modes.peak
    force_2, gain_2 = sine * g_2, sine * second * g_2
    speed, force, gain = cosine * w_1 - sine * w_2, cosine * g_1 - force_2, cosine * first * g_1 - gain_2
    here = (
        select(loading, -speed, peak - force),
        select(loading, -gain, speed),
        select(loading, cosine * first * w_1 - sine * second * w_2, gain),
    )
    slow = None
    if patient:
        slow = select(loading, sine * drift, peak + force_2), select(loading, gain_2, -sine * drift)
    found.append(_step(here, modes.line, slow, (modes.line_noise, 0.0 * peak), fast, fast * modes.line.bend))

    (step_a, at_a), (step_b, at_b), (step_c, at_c) = found
    step = smaller(smaller(step_a, step_b), step_c)
    parts = negated(loading) & (force <= NOISE * peak) & (speed > 0.0)
    event = select(at_c, LINE, select(at_b, FORWARD, select(at_a, BACKWARD, NONE)))
    event = select(parts, APART, select((step == INFINITE) & (event == NONE), NEVER, event))
    step = select(event == NONE, step, 0.0)
    w_1, g_1, more_1 = _swing(w_1, g_1, first, fast, step)
    w_2, g_2, more_2 = _swing(w_2, g_2, second, modes.slow, step)
    return _Swings(w_1, w_2, g_1, g_2, sum_1 + more_1, sum_2 + more_2, time + step), event


def _step(
    here: tuple[Number, Number, Number],
    bound: _Bound,
    slow: tuple[Number, Number] | None,
    noise: tuple[Number, Number],
    rate: Number,
    jerk: Number,
) -> tuple[Number, Number]:
    """Return a step that passes no root, and whether a root is here.

    Args:
        here: the function's value, slope and second derivative.
        bound: its bounds.
        slow: value and slope of its slow part; None where that is not worth its cost.
        noise: the rounding of its value and slope.
        rate: of the fast mode.
        jerk: the function's third derivative.
    """
    value, slope, bend = here
    step = _root(larger(value, 0.0), slope, bound.bend)
    if slow is not None:
        clear = slow[0] - GRAZE * bound.fast
        step = larger(step, select(clear > 0.0, _root(larger(clear, 0.0), slow[1], bound.slow_bend), 0.0))
    zero = value <= WIDE * noise[0]
    if isinstance(zero, bool):
        return _at_zero(step, value, slope, bend, *noise, bound.bend, bound.lift, rate, jerk) if zero else (step, zero)
    at = np.flatnonzero(zero)
    if at.size:
        few = (each[at] for each in (step, value, slope, bend, *noise, bound.bend, bound.lift, rate, jerk))
        step[at], zero[at] = _at_zero(*few)
    return step, zero


def _at_zero(
    step: Number,
    value: Number,
    slope: Number,
    bend: Number,
    noise: Number,
    slope_noise: Number,
    most: Number,
    lift: Number,
    rate: Number,
    jerk: Number,
) -> tuple[Number, Number]:
    """Return the step from a zero of a function that leaves it, and whether it falls instead, by more than rounding."""
    # On the border of stick, with modes of equal rates, the force keeps to the edge.
    flat = (abs(slope) <= WIDE * slope_noise) & (abs(bend) <= WIDE * rate * slope_noise)
    flat = flat & (abs(jerk) <= FLAT * rate * most)
    zero, slope = value <= noise, select(abs(slope) <= slope_noise, 0.0, slope)
    square, dip = slope * slope, 2.0 * noise * bend
    leaves = select(zero & (bend >= -STRAIGHT * most), larger(bend * lift, LEAST_STEP / rate), 0.0)
    falls = select(slope < 0.0, square > dip, square < -dip)
    return select(flat, INFINITE, larger(step, leaves)), falls & zero & negated(flat)


def _root(value: Number, slope: Number, most: Number) -> Number:
    """Return the positive root of value + slope h - most h^2/2, value >= 0, in the form that does not cancel; inf without one."""
    root, falls = square_root(slope * slope + 2.0 * most * value), slope < 0.0
    return divided(select(falls, 2.0 * value, root + slope + TINY), select(falls, root - slope, most))


def _swing(speed: Number, force: Number, square: Number, rate: Number, step: Number) -> tuple[Number, Number, Number]:
    """Return w and G of an oscillator after a step and the integral of G; by the half angle's tangent, rate zero included."""
    half = tangent(0.5 * rate * step) / rate
    turned = square * half * half
    scale = 1.0 / (1.0 + turned)
    sine, cosine = 2.0 * half * scale, (1.0 - turned) * scale
    return speed * cosine + square * force * sine, force * cosine - speed * sine, sine * (force - speed * half)
