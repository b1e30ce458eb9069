"""Impact at a point that is elastic along the surface too: Stronge's tangential spring beside the normal one.

The normal spring has stiffness k in loading and k/e*^2 in unloading, so that it returns e*^2 of the work it took; the
tangential one has k/eta^2, and its foot slides where its force T would leave the cone |T| <= mu N. With dv = K (N, T) dt the
outcome depends on K, v, mu, e* and eta^2; k sets the time alone, and is 1 here. An impact is a sequence of phases:

* stick (``impact_stick``): two oscillators, ended by the cone or by the end of the line;
* slip in the sense s: T = -mu s N, so that v and the foot's velocity v_t + mu s eta^2 kappa v_n are linear in the normal impulse p,
  and N^2 = N_0^2 - 2 kappa (v_n p + v_n'(p) p^2/2): it ends where the foot stops, the line ends or N = 0, each a root of a polynomial.

Loading ends where v_n = 0, and the contact with it if e* = 0: what both springs hold is lost. In unloading mu_2 holds. A T beyond
its cone jumps onto it. A point that is pressed on beyond its deepest point loads further, with mu_1. The works are those on the
bodies, -Delta N^2/(2 kappa) and -eta^2 Delta T^2/2 in stick; as springs begin and end without force, or lose it, energy never grows.

As eta^2 falls the result tends to that of the rigid point. Impulse and velocity differ from it by terms of order eta^2. Of order
eta are the impulse where slip and approach stop together, as a radial bristle's do, and the slip that is left where e* = 0.

Source: W. J. Stronge, *Impact Mechanics*, 2nd ed. (2018), chs. 5 and 6; N. Maw, J. R. Barber, J. N. Fawcett, Wear 38 (1976) 101-114.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from bristle_sim.arrays import Array, Number
from bristle_sim.theory.impact_phases import (
    INFINITE,
    KNIFE_EDGE,
    inverse_mass_of,
    larger,
    negated,
    quotient,
    select,
    sign,
    smaller,
    square_root,
)
from bristle_sim.theory.impact_result import JAM, NO_REBOUND, REBOUND, STICTION, Impact
from bristle_sim.theory.impact_stick import (
    APART,
    BACKWARD,
    FORWARD,
    LINE,
    NEVER,
    NOISE,
    NONE,
    SETTLED,
    STOP,
    Bodies,
    Done,
    Motion,
    stick,
)

LEAST_RESTITUTION = 1e-8  # below it the work that is returned is less than the rounding of the work that was taken

WIDEST_CONE = 1e12  # more friction acts as this: the cone is a half-plane but for parts in 1e12

BLOCK = 1 << 16

ROUNDS = 6
"""Phases that all contacts of a block take together. The few that have more are carried on with those of all blocks."""

SETTLING = 120
"""Phases of stick in a row after which each further one begins without the fast oscillation that is left: it counts as lost.
One contact in a thousand of random K has more: those of modes whose rates differ a thousandfold, which bounce from line to line."""

LEAST_EXACT = 0.01  # below this e* phases of slip count too, since the point bounces on the steep line some 1/e* times

SINGLES = 12  # so few contacts are carried on one by one, by floats


def _slip(bodies: Bodies, motion: Motion, settles: Number, patient: bool = True) -> tuple[Motion, Number, Done]:
    """Advance by a phase of slip; return motion, event, impulses and works."""
    del settles, patient
    loading, slip, mu, kappa = motion.loading, motion.slip, motion.friction, motion.steep * motion.steep
    gain, gain_along, foot, foot_gain = _foot(bodies, motion, slip)
    stop = select(mu > 0.0, quotient(larger(foot, 0.0), -foot_gain), INFINITE)
    speed, push = motion.normal, motion.push

    # Unloading: N = 0, or N as large as it was, by the quadratic N^2(p) in the forms that do not cancel.
    left, stored = (motion.peak - push) * (motion.peak + push) / kappa, push * push / kappa
    inside, beyond = speed * speed - gain * left, speed * speed + gain * stored
    root = square_root(larger(inside, 0.0))
    again = select(speed < 0.0, quotient(left, root - speed), quotient(speed + root, -gain))
    again = select((inside >= 0.0) & ((speed < 0.0) | (gain < 0.0)), again, INFINITE)
    root = square_root(larger(beyond, 0.0))
    apart = select(speed < 0.0, quotient(root - speed, gain), quotient(stored, speed + root))
    apart = select(negated(loading) & (beyond >= 0.0), apart, INFINITE)
    line = select(loading, quotient(-speed, gain), again)

    impulse = smaller(smaller(stop, line), apart)
    event = select(impulse == apart, APART, select(impulse == line, LINE, STOP))
    event = select(impulse == INFINITE, NEVER, event)
    impulse = select(impulse == INFINITE, 0.0, impulse)
    normal, tangential = speed + gain * impulse, motion.tangential + gain_along * impulse
    normal = select(loading & (event == LINE), 0.0, normal)
    square = push * push - kappa * impulse * (speed + normal)
    push = select(event == APART, 0.0, square_root(larger(square, 0.0)))
    ratio = -mu * slip
    works = 0.5 * impulse * (speed + normal), 0.5 * ratio * impulse * (motion.tangential + tangential)
    after = motion._replace(normal=normal, tangential=tangential, push=push, rub=ratio * push)
    return after, event, Done(impulse, ratio * impulse, *works)


def _foot(bodies: Bodies, motion: Motion, slip: Number) -> tuple[Number, Number, Number, Number]:
    """Return the gains of v_n and v_t per impulse in slip, the foot's velocity in its sense, and that one's gain.

    The latter two over 1 + mu eta^2 kappa, so that no friction makes them overflow.
    """
    along = bodies.coupling - motion.friction * slip * bodies.tangential
    gain = bodies.stick + bodies.tie * along
    growth = motion.friction * (bodies.eta * motion.steep) * (bodies.eta * motion.steep)
    weight = 1.0 / (1.0 + growth)
    foot = weight * (slip * motion.tangential + growth * motion.normal)
    return gain, along, foot, weight * (slip * along + growth * gain)


def _begun(bodies: Bodies, motion: Motion) -> Motion:
    """Let the foot slip where it must: at an edge of the cone that the force would leave. Without friction it always slips."""
    smooth = motion.friction == 0.0
    free = select(motion.tangential == 0.0, select(bodies.coupling < 0.0, -1.0, 1.0), sign(motion.tangential))
    side = select(smooth | (motion.rub == 0.0), free, -sign(motion.rub))
    _, _, foot, gain = _foot(bodies, motion, side)
    growth = motion.friction * (bodies.eta * motion.steep) * (bodies.eta * motion.steep)
    still = abs(foot) <= NOISE * (abs(motion.tangential) + growth * abs(motion.normal)) / (1.0 + growth)
    leaves = (negated(still) & (foot > 0.0)) | (still & (gain > 0.0))
    slips = (abs(motion.rub) >= motion.friction * motion.push * (1.0 - NOISE)) & leaves
    return motion._replace(slip=select(smooth | slips, side, 0.0))


def _turned(bodies: Bodies, motion: Motion, event: Number) -> Motion:
    """Return the motion after an event, on the line and with the slip that follow it."""
    line = event == LINE
    deepest, again = line & motion.loading, line & negated(motion.loading)
    loading = (motion.loading & negated(deepest)) | again
    push = select(
        loading & negated(again), motion.push, select(deepest, motion.push, smaller(motion.push, motion.peak))
    )
    push = select(again, motion.peak, push)
    mu = select(deepest, bodies.restitution_friction, select(again, bodies.friction, motion.friction))
    limit, slides = mu * push, (event == FORWARD) | (event == BACKWARD)
    side = select(event == FORWARD, 1.0, -1.0)
    motion = motion._replace(
        normal=select(deepest, 0.0, motion.normal),
        push=push,
        rub=select(slides, -side * limit, larger(smaller(motion.rub, limit), -limit)),
        peak=select(deepest, push, motion.peak),
        loading=loading,
        steep=select(deepest, quotient(1.0 + 0.0 * push, bodies.restitution), select(again, 1.0, motion.steep)),
        friction=mu,
    )
    return motion._replace(slip=select(slides, side, select(event == STOP, 0.0, _begun(bodies, motion).slip)))


class _Record:
    """Impulses, works and slip of the contacts by the four rows of ``impact_result.PHASES``, and how each ended.

    The second row of compression, and of restitution, collects all that follows its first stick or slip. A point that is
    pressed on beyond its deepest point was in compression until then.
    """

    def __init__(self, slip: Number) -> None:
        """Begin with the slip, or stick, that each contact begins with."""
        self.initial = np.atleast_1d(slip)
        size = self.initial.size
        self.rows, self.slips = np.zeros((4, 4, size)), np.zeros((4, size))
        self.row, self.phases = np.zeros(size, dtype=int), np.zeros(size, dtype=int)
        self.settled = np.zeros(size, dtype=bool)
        self.slip_stop, self.outcome = np.full(size, INFINITE), np.zeros(size, dtype=int)

    def part(self, at: Any) -> _Record:
        """Return a record of some of the contacts."""
        found = _Record.__new__(_Record)
        for name, each in vars(self).items():
            setattr(found, name, np.array(each[..., at]))
        return found

    def put(self, at: Any, part: _Record) -> None:
        """Take over the record of some of the contacts."""
        for name, each in vars(self).items():
            each[..., at] = getattr(part, name)

    def settles(self, at: Any) -> Number:
        """Return which contacts lose their fast oscillation now."""
        return (self.phases[at] >= SETTLING) & ~self.settled[at]

    def note(self, at: Any, bodies: Bodies, before: Motion, after: Motion, event: Number, done: Done) -> Number:
        """Add a step of the contacts ``at`` an index; return which of them it ends."""
        row = self.row[at]
        for total, part in zip(self.rows, done, strict=True):
            total[row, at] += part
        self.slips[row, at] = select(done.normal > 0.0, before.slip, self.slips[row, at])
        counts = (before.slip == 0.0) | (bodies.restitution < LEAST_EXACT)
        self.phases[at] = select(counts, self.phases[at] + 1, 0)
        self.settled[at] = event == SETTLED
        deepest = (event == LINE) & before.loading
        parts, never = event == APART, event == NEVER
        over = parts | never | (deepest & (bodies.restitution == 0.0))
        parted = select(parts & (after.normal > 0.0), REBOUND, NO_REBOUND)
        pressed = before.loading | (after.normal < -KNIFE_EDGE * bodies.approach)
        self.outcome[at] = select(never, select(pressed, JAM, STICTION), parted)
        return over

    def turn(self, at: Any, before: Motion, after: Motion, event: Number) -> None:
        """Go on to the row of the motion after an event."""
        line = event == LINE
        again = line & after.loading
        if np.any(again):
            chosen = np.atleast_1d(at)[np.atleast_1d(again)]
            self.rows[:, 1, chosen] += self.rows[:, 2:, chosen].sum(axis=1)
            self.rows[:, 2:, chosen], self.slips[2:, chosen] = 0.0, 0.0
        turned = after.slip != before.slip
        row = self.row[at]
        self.row[at] = select(again, 1, select(line, 2, select(turned, row | 1, row)))
        stops = turned & (self.initial[at] != 0.0) & (self.slip_stop[at] == INFINITE)
        self.slip_stop[at] = select(stops, self.rows[0, :, at].sum(axis=-1), self.slip_stop[at])


def _array_impacts(bodies: Bodies, motion: Motion) -> tuple[Motion, _Record]:
    """Carry arrays of contacts to their ends: blocks that fit the cache for some rounds, then what is left of all of them."""
    record, motion = _Record(motion.slip), Motion(*(np.array(each) for each in motion))
    rest = []
    for begin in range(0, motion.normal.size, BLOCK):
        part = slice(begin, begin + BLOCK)
        rest.append(begin + _carried(bodies, motion, record, part, ROUNDS))
    _carried(bodies, motion, record, np.concatenate(rest), None)
    return motion, record


def _carried(bodies: Bodies, motion: Motion, record: _Record, part: Any, rounds: int | None) -> Array:
    """Carry some contacts on for some rounds, or to their ends; return the indices within the part of those that go on."""
    own = Bodies(*(each[part] for each in bodies))
    moves = Motion(*(np.array(each[part]) for each in motion))
    notes = record.part(part)
    active = np.arange(moves.normal.size)
    patient = rounds is None
    while active.size > (SINGLES if patient else 0) and rounds != 0:
        active = _act(own, moves, notes, active, patient)
        rounds = None if rounds is None else rounds - 1
    if patient:
        for at in active.tolist():
            ends = _single_impact(Bodies(*_floats(own, at)), Motion(*_floats(moves, at)), notes, at)
            for whole, end in zip(moves[:4], ends[:4], strict=True):
                whole[at] = end
    for whole, each in zip(motion, moves, strict=True):
        whole[part] = each
    record.put(part, notes)
    return active


def _act(bodies: Bodies, motion: Motion, record: _Record, active: Array, patient: bool) -> Array:
    """Take a phase of the active contacts; return those that go on."""
    slips, loads = motion.slip[active] != 0.0, motion.loading[active]
    groups: list[tuple[Array, Callable[..., Any], bool]] = [
        (active[slips & loads], _slip, True),
        (active[slips & ~loads], _slip, False),
        (active[~slips & loads], stick, True),
        (active[~slips & ~loads], stick, False),
    ]
    going = []
    for at, way, loading in groups:
        if not at.size:
            continue
        own, before = Bodies(*(each[at] for each in bodies)), Motion(*(each[at] for each in motion))
        after, event, done = way(own, before._replace(loading=loading), record.settles(at), patient)
        over = record.note(at, own, before, after, event, done)
        for whole, part in zip(motion[:4], after[:4], strict=True):
            whole[at] = part
        turns = np.flatnonzero((event != NONE) & ~over)
        if turns.size:
            after = after._replace(loading=before.loading)
            chosen, earlier = at[turns], Motion(*(each[turns] for each in before))
            own, after = Bodies(*(each[turns] for each in own)), Motion(*(each[turns] for each in after))
            new = _turned(own, after, event[turns])
            record.turn(chosen, earlier, new, event[turns])
            for whole, part in zip(motion, new, strict=True):
                whole[chosen] = part
        going.append(at[~over])
    return np.concatenate(going)


def _floats(values: tuple[Number, ...], at: int) -> list[Number]:
    return [each[at].item() for each in values]


def _single_impact(bodies: Bodies, motion: Motion, record: _Record, at: int) -> Motion:
    """Carry one contact, of floats, to its end."""
    while True:
        way = _slip if motion.slip else stick
        after, event, done = way(bodies, motion, bool(record.settles(at)))
        if record.note(at, bodies, motion, after, event, done):
            return after
        motion = after
        if event != NONE:
            motion = _turned(bodies, after, event)
            record.turn(at, after, motion, event)


def compliant_impact(values: list[Number], squared: Number) -> Impact:
    """Resolve energetic impacts of approaching points whose tangential compliance eta^2 is ``squared``; floats or arrays.

    Args:
        values: K_nn > 0, K_nt, K_tt, v_n < 0, v_t, mu_1, e*, mu_2, and the compliance in stick where it is known better.
        squared: eta^2 > 0.
    """
    k_nn, k_nt, k_tt, normal, tangential, mu_1, e, mu_2, *given = values
    # Powers of two keep squares of any unit within floats, and every digit.
    mass, speed = _power(k_nn), _power(larger(abs(normal), abs(tangential)))
    k_nn, k_nt, k_tt = k_nn / mass, k_nt / mass, k_tt / mass
    normal, tangential = normal / speed, tangential / speed
    inverse_mass = inverse_mass_of(k_nn, k_nt, k_tt, given[0] / mass if given else None)
    mu_1, mu_2 = smaller(mu_1, WIDEST_CONE), smaller(mu_2, WIDEST_CONE)
    e = select(e < LEAST_RESTITUTION, 0.0, e)
    none, loads = 0.0 * normal, normal < 0.0
    bodies = Bodies(
        k_nn, k_nt, k_tt, inverse_mass.stick, -inverse_mass.stick_ratio, mu_1, mu_2, e, square_root(squared), -normal
    )
    motion = _begun(bodies, Motion(normal, tangential, none, none, none, loads, 1.0 + none, mu_1, none))
    single = isinstance(normal, float)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        if single:
            record = _Record(motion.slip)
            motion = _single_impact(bodies, motion, record, 0)
        else:
            motion, record = _array_impacts(bodies, motion)
    impulses, along, normal_works, tangential_works = (
        (each * factor).T
        for each, factor in zip(record.rows, (speed / mass,) * 2 + (speed * speed / mass,) * 2, strict=True)
    )
    found = Impact(
        impulse_normal=impulses.sum(axis=-1),
        impulse_tangential=along.sum(axis=-1),
        velocity_normal=np.atleast_1d(motion.normal * speed),
        velocity_tangential=np.atleast_1d(motion.tangential * speed),
        compressive_impulse_normal=impulses[:, :2].sum(axis=-1),
        compressive_impulse_tangential=along[:, :2].sum(axis=-1),
        slip_stop_impulse=np.where(record.initial == 0.0, 0.0, record.slip_stop * (speed / mass)),
        phase_impulse=impulses,
        phase_slip=record.slips.T,
        phase_work_normal=normal_works,
        phase_work_tangential=tangential_works,
        outcome=record.outcome,
    )
    return Impact(*(_only(getattr(found, each.name)) for each in fields(Impact))) if single else found


def _power(value: Number) -> Number:
    """Return the power of two next above a value."""
    if isinstance(value, float):
        return math.ldexp(1.0, math.frexp(value)[1])
    return np.ldexp(1.0, np.frexp(value)[1])


def _only(values: Array) -> Number:
    """Return the entry of the only impact, a float where it is one number."""
    return values[0] if values.ndim > 1 else values[0].item()
