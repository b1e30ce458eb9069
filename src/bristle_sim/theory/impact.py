"""Planar impact at one point with Coulomb friction: one law for a body, a chain of bodies or a whole machine.

All that an impact needs to know of the bodies is the contact-space inverse mass K, which turns an impulse
p = (p_n, p_t) on the contact point into the change of its velocity, dv = K dp, and the velocity v = (v_n, v_t) with which
the point arrives. The tangential impulse opposes slip, dp_t = -mu sign(v_t) dp_n, so within a phase of constant slip
direction (or stick) the velocities are linear and the works are quadratic in p_n, and every phase ends in closed form:

* slip continues until v_t = 0;
* then the point sticks if mu >= |K_nt| / K_tt, and otherwise slips in the direction of sign(K_nt);
* compression ends at v_n = 0;
* restitution ends where the coefficient of restitution says: the energetic one (Stronge 1990) when the normal work in
  restitution is W_r = -e*^2 W_c, Poisson's when the normal impulse in restitution is e times that of compression,
  Newton's when v_n is -e times its value before the impact.

So compression and restitution have two phases each: the slip that is there, and what follows after it stops.

Where restitution's friction is larger than compression's, slip can drive the point back into compression as soon as
v_n > 0; the only motion that obeys both coefficients then keeps v_n = 0 until slip stops ("slip at rest").

Sources: W. J. Stronge, *Rigid body collisions with friction*, Proc. R. Soc. Lond. A 431 (1990) 169-181;
J. Zhang (2020), eqs. 2.4-2.18, 2.46; Wang and Mason, J. Appl. Mech. 59 (1992) 635-642 for the three coefficients.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bristle_sim.theory.checks import numbers, require

__all__ = ["OUTCOMES", "PHASES", "Impact", "energetic_impact", "newton_impact", "poisson_impact", "stick_threshold"]

Number = Any
"""A float or an array of floats: the same lines serve both, floats for speed in a scene, arrays for sweeps."""

NO_CONTACT, REBOUND, NO_REBOUND, STICTION, JAM = range(5)
OUTCOMES = ("no contact", "rebound", "no rebound", "stiction", "jam")
"""What an outcome code means.

``no contact``: the point does not approach. ``rebound``: restitution ends with v_n > 0. ``no rebound``: e = 0, or
what restitution has to give is spent with v_n = 0, in slip at rest (Poisson's impulse) or below the smallest float.
``stiction``: compression ends, but no impulse can part the point from the surface again (the jam of one degree of
freedom, mu >= tan gamma). ``jam``: the point sticks before compression ends and no impulse can end it; the rigid-body
law has no solution.
"""

PHASES = ("compression", "compression after slip", "restitution", "restitution after slip")
"""The four phases an impact can have; one that does not occur has a normal impulse of zero."""

INFINITE = math.inf

MOST_FRICTION = 1e150
"""More makes impulses that overflow."""

BLOCK = 1 << 13

KNIFE_EDGE = 1e-6
"""One degree of freedom that sticks with less than this share of its approach left, or already regained, is at rest: a
radial bristle, up to rounding and to where its strike was located. It is neither a jam, nor has it a rebound, for which the
work rule would ask an impulse of W/v_n, without bound."""

SINGULAR = 64.0 * sys.float_info.epsilon
"""A normal compliance in stick below this share of K_nn is rounding: the contact has one degree of freedom."""


@dataclass(frozen=True, slots=True)
class Impact:
    """Result of an impact; each entry is a float, or an array of the broadcast shape.

    Impulses act on the moving point; normal ones are positive, works are those of the impulse on the bodies.

    Attributes:
        impulse_normal, impulse_tangential: p_f, N s.
        velocity_normal, velocity_tangential: after the impact, m/s.
        compressive_impulse_normal, compressive_impulse_tangential: p_c, at the end of compression, N s.
        slip_stop_impulse: p_s, normal impulse at which the initial slip stops, N s; inf if it does not.
        phase_impulse: normal impulse of each of PHASES, shape (..., 4), N s.
        phase_slip: direction of slip in each of PHASES, -1, 0 (stick) or 1, shape (..., 4).
        phase_work_normal, phase_work_tangential: works in each of PHASES, shape (..., 4), J.
        outcome: index into OUTCOMES.
    """

    impulse_normal: Number
    impulse_tangential: Number
    velocity_normal: Number
    velocity_tangential: Number
    compressive_impulse_normal: Number
    compressive_impulse_tangential: Number
    slip_stop_impulse: Number
    phase_impulse: Number
    phase_slip: Number
    phase_work_normal: Number
    phase_work_tangential: Number
    outcome: Number

    @property
    def compressive_work_normal(self) -> Number:
        """W_c, normal work of compression, J (negative)."""
        return self.phase_work_normal[..., 0] + self.phase_work_normal[..., 1]

    @property
    def compressive_work_tangential(self) -> Number:
        """Work of friction during compression, J."""
        return self.phase_work_tangential[..., 0] + self.phase_work_tangential[..., 1]

    @property
    def restitutive_work_normal(self) -> Number:
        """W_r, normal work of restitution, J (positive)."""
        return self.phase_work_normal[..., 2] + self.phase_work_normal[..., 3]

    @property
    def restitutive_work_tangential(self) -> Number:
        """Work of friction during restitution, J."""
        return self.phase_work_tangential[..., 2] + self.phase_work_tangential[..., 3]

    @property
    def energy_change(self) -> Number:
        """Change of the bodies' kinetic energy, the sum of all works, J."""
        return self.phase_work_normal.sum(axis=-1) + self.phase_work_tangential.sum(axis=-1)

    @property
    def outcome_name(self) -> str:
        """The outcome of a single impact in words."""
        return OUTCOMES[int(self.outcome)]

    @property
    def phases(self) -> tuple[str, ...]:
        """Phases of a single impact in order, e.g. ``("compression slip", "restitution reverse slip")``."""
        initial = self.phase_slip[0]
        names = []
        for name, impulse, slip in zip(PHASES, self.phase_impulse, self.phase_slip, strict=True):
            if impulse > 0.0:
                motion = "stick" if slip == 0.0 else "reverse slip" if slip == -initial else "slip"
                names.append(f"{name.split()[0]} {motion}")
        return tuple(names)


def energetic_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
    stick_compliance: ArrayLike | None = None,
) -> Impact:
    """Impact with Stronge's energetic coefficient of restitution, W_r = -e*^2 W_c (Zhang 2020, eq. 2.46).

    Args:
        inverse_mass: K, symmetric and positive semidefinite, order (normal, tangential), shape (..., 2, 2), 1/kg.
        velocity: (v_n, v_t) of the contact point before the impact, shape (..., 2), m/s; v_n < 0 approaches.
        friction: Coulomb's mu, in compression if restitution_friction is given too, shape (...).
        restitution: e*, in [0, 1], shape (...).
        restitution_friction: mu in restitution; equal to ``friction`` by default.
        stick_compliance: gain of v_n per unit normal impulse while the point does not slip, K_nn - K_nt^2/K_tt, 1/kg,
            where it is known better than K's rounding tells: at a mass ratio of 1e12 the difference keeps four digits.

    Returns:
        The impact; floats for a single one, arrays of the broadcast shape otherwise.

    Raises:
        ValueError: for values that are not finite, a K that is not symmetric positive semidefinite, mu < 0, e*
            outside [0, 1], a stick_compliance < 0.
    """
    return _resolve(
        _energetic_end, inverse_mass, velocity, friction, restitution, restitution_friction, stick_compliance
    )


def poisson_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
) -> Impact:
    """Impact with Poisson's coefficient, p_r = e p_c in the normal impulses; first arguments as for energetic_impact."""
    return _resolve(_poisson_end, inverse_mass, velocity, friction, restitution, restitution_friction)


def newton_impact(
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None = None,
) -> Impact:
    """Impact with Newton's coefficient, v_n after = -e v_n before; first arguments as for energetic_impact.

    It can gain energy (Kane and Levinson 1985); it is here to be compared.
    """
    return _resolve(_newton_end, inverse_mass, velocity, friction, restitution, restitution_friction)


def stick_threshold(inverse_mass: ArrayLike) -> Number:
    """Least friction at which a point that has stopped sticks, mu_bar = |K_nt| / K_tt (Zhang 2020, eq. 2.90)."""
    matrix = numbers("inverse_mass", inverse_mass, "real numbers are allowed (1/kg)")
    if matrix.shape[-2:] != (2, 2):
        raise ValueError(f"inverse_mass of shape {matrix.shape}: (..., 2, 2) is allowed")
    coupling, tangential = np.abs(matrix[..., 0, 1]), matrix[..., 1, 1]
    holds = np.isfinite(matrix).all(axis=(-2, -1)) & (tangential > sys.float_info.min * coupling) & (tangential > 0.0)
    require("inverse_mass", tangential, holds, "finite entries, the tangential one above 0, are allowed (1/kg)")
    return coupling / tangential


@dataclass(slots=True)
class _State:
    """Running state of an impact: velocities and accumulated impulses."""

    normal: Number
    tangential: Number
    impulse: Number
    impulse_tangential: Number


class _Mass(NamedTuple):
    """K by its entries, its normal compliance in stick rid of rounding, and the tangential share of stick."""

    normal: Number
    coupling: Number
    tangential: Number
    stick: Number
    stick_ratio: Number


class _Target(NamedTuple):
    """What restitution still has to reach: normal work, normal impulse, or (Newton) a normal velocity.

    A point that cannot be set in motion and moves no faster than ``least`` is at rest.
    """

    work: Number
    impulse: Number
    velocity: Number
    least: Number


class _Phase(NamedTuple):
    """What one phase did; ``stopped``: slip came to an end in it; ``unfinished``: its part of the impact goes on."""

    impulse: Number
    slip: Number
    work_normal: Number
    work_tangential: Number
    stopped: Number
    unfinished: Number


_End = Callable[[Number, Number, _Target], Number]
"""Normal impulse from (velocity, compliance) at which restitution ends."""


def _energetic_end(velocity: Number, compliance: Number, target: _Target) -> Number:
    # The root of v p + a p^2/2 = W in the form that does not cancel; a work below the smallest float is done at once.
    work = _select(target.work > 0.0, target.work, 0.0)
    root = _sqrt(velocity * velocity + 2.0 * compliance * work)
    return _select(work > 0.0, _quotient(2.0 * work, velocity + root), 0.0)


def _poisson_end(_velocity: Number, _compliance: Number, target: _Target) -> Number:
    return target.impulse


def _newton_end(velocity: Number, compliance: Number, target: _Target) -> Number:
    return _quotient(_select(target.velocity > velocity, target.velocity - velocity, 0.0), compliance)


def _resolve(
    end: _End,
    inverse_mass: ArrayLike,
    velocity: ArrayLike,
    friction: ArrayLike,
    restitution: ArrayLike,
    restitution_friction: ArrayLike | None,
    stick_compliance: ArrayLike | None = None,
) -> Impact:
    """Check and unpack the arguments, then walk the four phases; long arrays in blocks that fit the cache."""
    if restitution_friction is None:
        restitution_friction = friction
    extra = () if stick_compliance is None else (stick_compliance,)
    values, shape = _unpack(inverse_mass, velocity, friction, restitution, restitution_friction, *extra)
    if shape is None:
        return _walk(end, *values)
    size = values[0].size
    flat = [np.ravel(value) for value in values]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        blocks = [_walk(end, *(each[i : i + BLOCK] for each in flat)) for i in range(0, max(size, 1), BLOCK)]
    joined = {}
    for each in fields(Impact):
        parts = [getattr(block, each.name) for block in blocks]
        whole = parts[0] if len(parts) == 1 else np.concatenate(parts)
        joined[each.name] = whole.reshape(shape + whole.shape[1:])
    return Impact(**joined)


def _walk(
    end: _End,
    k_nn: Number,
    k_nt: Number,
    k_tt: Number,
    normal: Number,
    tangential: Number,
    mu_1: Number,
    e: Number,
    mu_2: Number,
    stick: Number | None = None,
) -> Impact:
    """The four phases in order."""
    mass = _mass(k_nn, k_nt, k_tt, stick)
    approaching = normal < 0.0
    state = _State(_select(approaching, normal, 0.0), tangential, 0.0 * normal, 0.0 * normal)
    initial = _sign(tangential)

    first = _compress(state, mass, mu_1, initial, approaching & (initial != 0.0))
    second = _compress(state, mass, mu_1, _settled(mass, mu_1), state.normal < 0.0)
    jammed = approaching & (state.normal < KNIFE_EDGE * normal)
    compressive, compressive_tangential = state.impulse, state.impulse_tangential

    # Compression may have ended in slip, reversed slip or stick; slip that is still there goes on.
    work = -(first.work_normal + second.work_normal) * e * e
    target = _Target(work, e * compressive, -e * normal, -KNIFE_EDGE * normal)
    opens = approaching & _not(jammed) & (e > 0.0)
    slip = _sign(state.tangential)
    third = _restitute(state, mass, mu_2, slip, opens & (slip != 0.0), target, end)
    left = _Target(work - third.work_normal, target.impulse - third.impulse, target.velocity, target.least)
    still_open = opens & ((slip == 0.0) | third.unfinished)
    fourth = _restitute(state, mass, mu_2, _settled(mass, mu_2), still_open, left, end)

    rows = (first, second, third, fourth)
    # Poisson's restitution ends at an impulse, even where one degree of freedom lets no impulse part the point.
    stuck = fourth.unfinished | ((state.normal <= 0.0) & (mass.stick == 0.0))
    parted = _select(state.normal > 0.0, REBOUND, NO_REBOUND)
    ending = _select(e == 0.0, NO_REBOUND, _select(stuck, STICTION, parted))
    return Impact(
        impulse_normal=state.impulse,
        impulse_tangential=state.impulse_tangential,
        velocity_normal=_select(approaching, state.normal, normal),
        velocity_tangential=state.tangential,
        compressive_impulse_normal=compressive,
        compressive_impulse_tangential=compressive_tangential,
        slip_stop_impulse=_slip_stop(initial, rows),
        phase_impulse=_stack([row.impulse for row in rows]),
        phase_slip=_stack([row.slip for row in rows]),
        phase_work_normal=_stack([row.work_normal for row in rows]),
        phase_work_tangential=_stack([row.work_tangential for row in rows]),
        outcome=_select(approaching, _select(jammed, JAM, ending), NO_CONTACT),
    )


def _mass(k_nn: Number, k_nt: Number, k_tt: Number, stick: Number | None) -> _Mass:
    ratio = _select(k_tt > 0.0, k_nt * _inverse(k_tt), 0.0)
    if stick is None:
        difference = k_nn - ratio * k_nt
        stick = _select(difference > SINGULAR * k_nn, difference, 0.0)
    return _Mass(k_nn, k_nt, k_tt, stick, -ratio)


def _settled(mass: _Mass, mu: Number) -> Number:
    """Direction of slip once it has stopped: none where friction holds the point, else the way K drives it."""
    holds = mu * mass.tangential >= _magnitude(mass.coupling)
    return _select(holds, 0.0, _sign(mass.coupling))


def _slip_rates(mass: _Mass, mu: Number, slip: Number) -> tuple[Number, Number]:
    """Gains of v_n and v_t per unit normal impulse in slip, K_nn - mu sign(v_t) K_nt and K_nt - mu sign(v_t) K_tt.

    The first by way of the second: where rounding decides both, they are still those of one mu, and no energy is gained.
    """
    tangential = mass.coupling - mu * slip * mass.tangential
    return mass.stick - mass.stick_ratio * tangential, tangential


def _compress(state: _State, mass: _Mass, mu: Number, slip: Number, active: Number) -> _Phase:
    """Advance to the end of compression or of slip, whichever comes first."""
    sticks = slip == 0.0
    slip_rate, slip_tangential_rate = _slip_rates(mass, mu, slip)
    ratio = _select(sticks, mass.stick_ratio, -mu * slip)
    normal_rate = _select(sticks, mass.stick, slip_rate)
    tangential_rate = _select(sticks, 0.0, slip_tangential_rate)
    end = _quotient(-state.normal, normal_rate)
    return _advance(state, active, slip, ratio, normal_rate, tangential_rate, end)


def _restitute(
    state: _State, mass: _Mass, mu: Number, slip: Number, active: Number, target: _Target, end: _End
) -> _Phase:
    """Advance to the end of restitution or of slip; slip that would turn v_n back keeps it at rest."""
    sticks = slip == 0.0
    drive = slip * mass.coupling
    slip_rate, slip_tangential_rate = _slip_rates(mass, mu, slip)
    at_rest = (drive > 0.0) & (slip_rate <= 0.0)
    ratio = _select(at_rest, -mass.normal * _inverse(mass.coupling), -mu * slip)
    # At rest K_nt + r K_tt = -(K_nn K_tt - K_nt^2)/K_nt, which is rounding alone for one degree of freedom.
    slowing = -mass.stick * mass.tangential * _inverse(mass.coupling)
    ratio = _select(sticks, mass.stick_ratio, ratio)
    normal_rate = _select(sticks, mass.stick, _select(at_rest, 0.0, slip_rate))
    tangential_rate = _select(sticks, 0.0, _select(at_rest, slowing, slip_tangential_rate))
    rests = sticks & (normal_rate == 0.0) & (state.normal <= target.least)
    finish = _select(rests, INFINITE, end(state.normal, normal_rate, target))
    return _advance(state, active, slip, ratio, normal_rate, tangential_rate, finish)


def _advance(
    state: _State,
    active: Number,
    slip: Number,
    ratio: Number,
    normal_rate: Number,
    tangential_rate: Number,
    end: Number,
) -> _Phase:
    """Apply the normal impulse up to ``end`` or up to where slip stops; both may be infinite."""
    slows = state.tangential * tangential_rate < 0.0
    stop = _select(slows, _quotient(_magnitude(state.tangential), _magnitude(tangential_rate)), INFINITE)
    # Slip and compression of one degree of freedom stop at one impulse, up to rounding.
    stopped = active & (stop <= end * (1.0 + SINGULAR)) & (stop < INFINITE)
    finished = active & (end <= stop * (1.0 + SINGULAR)) & (end < INFINITE)
    step = _select(finished, end, _select(stopped, stop, 0.0))

    normal = state.normal + normal_rate * step
    tangential = _select(stopped, 0.0, state.tangential + tangential_rate * step)
    work_normal = 0.5 * step * (state.normal + normal)
    work_tangential = 0.5 * ratio * step * (state.tangential + tangential)
    # Compression ends at rest, exactly.
    state.normal = _select(finished & (state.normal < 0.0), 0.0, normal)
    state.tangential = tangential
    state.impulse = state.impulse + step
    state.impulse_tangential = state.impulse_tangential + ratio * step
    return _Phase(step, _select(active, slip, 0.0), work_normal, work_tangential, stopped, active & _not(finished))


def _slip_stop(initial: Number, rows: tuple[_Phase, ...]) -> Number:
    """p_s: where the initial slip stops; 0 if there is none, inf if it lasts."""
    first, second, third, _ = rows
    late = first.impulse + second.impulse + third.impulse
    stop = _select(first.stopped, first.impulse, _select(third.stopped, late, INFINITE))
    return _select(initial == 0.0, 0.0, stop)


def _unpack(
    inverse_mass: ArrayLike, velocity: ArrayLike, *others: ArrayLike
) -> tuple[list[Number], tuple[int, ...] | None]:
    """K's entries, the velocities and all other arguments: floats for one impact (shape None), else broadcast arrays."""
    matrix, velocity, *coefficients = _arrays(inverse_mass, velocity, *others)
    if matrix.shape[-2:] != (2, 2) or velocity.shape[-1:] != (2,):
        raise ValueError(
            f"inverse_mass, velocity of shapes {matrix.shape}, {velocity.shape}: (..., 2, 2) and (..., 2) are allowed"
        )
    shape: tuple[int, ...] | None = None
    if matrix.ndim == 2 and velocity.ndim == 1 and not any(each.ndim for each in coefficients):
        (k_nn, k_nt), (k_tn, k_tt) = matrix.tolist()
        values = [k_nn, k_nt, k_tt, *velocity.tolist(), *(each.item() for each in coefficients)]
    else:
        shape = np.broadcast_shapes(matrix.shape[:-2], velocity.shape[:-1], *(each.shape for each in coefficients))
        entries = (matrix[..., 0, 0], matrix[..., 0, 1], matrix[..., 1, 1], velocity[..., 0], velocity[..., 1])
        values = [np.broadcast_to(each, shape) for each in (*entries, *coefficients)]
        k_tn = matrix[..., 1, 0]
    _check(values, k_tn)
    return values, shape


NAMES = ("inverse_mass", "velocity", "friction", "restitution", "restitution_friction", "stick_compliance")


def _arrays(*arguments: ArrayLike) -> list[NDArray[np.float64]]:
    """All of them as floats; which of them is not is only looked for where one is not."""
    try:
        with np.errstate(over="ignore"):
            return [np.asarray(each, dtype=float) for each in arguments]
    except (TypeError, ValueError, OverflowError):
        return [numbers(name, each, "real numbers are allowed") for name, each in zip(NAMES, arguments, strict=False)]


def _check(values: list[Number], k_tn: Number) -> None:
    k_nn, k_nt, k_tt, normal, tangential, mu_1, e, mu_2, *given = values
    rules = [
        ("inverse_mass", "finite entries", _finite(k_nn) & _finite(k_nt) & _finite(k_tt) & _finite(k_tn)),
        ("inverse_mass", "a symmetric matrix", _magnitude(k_nt - k_tn) <= 1e-9 * _sqrt(_magnitude(k_nn * k_tt))),
        (
            "inverse_mass",
            "a positive semidefinite matrix (1/kg)",
            (k_nn >= 0.0) & (k_tt >= 0.0) & (k_nt * k_nt <= k_nn * k_tt * (1.0 + 1e-9)),
        ),
        ("velocity", "finite components (m/s)", _finite(normal) & _finite(tangential)),
        ("friction", "finite and >= 0 (dimensionless)", (mu_1 >= 0.0) & (mu_1 <= MOST_FRICTION)),
        ("restitution_friction", "finite and >= 0 (dimensionless)", (mu_2 >= 0.0) & (mu_2 <= MOST_FRICTION)),
        ("restitution", "0 <= restitution <= 1 (dimensionless)", (e >= 0.0) & (e <= 1.0)),
    ]
    rules += [("stick_compliance", "finite and >= 0 (1/kg)", _finite(each) & (each >= 0.0)) for each in given]
    for name, allowed, holds in rules:
        if not (holds if isinstance(holds, bool) else bool(holds.all())):
            raise ValueError(f"{name}: {allowed} is allowed")


def _select(condition: Number, chosen: Number, other: Number) -> Number:
    if isinstance(condition, bool):
        return chosen if condition else other
    return np.where(condition, chosen, other)


def _not(condition: Number) -> Number:
    return not condition if isinstance(condition, bool) else ~condition


def _magnitude(value: Number) -> Number:
    return abs(value)


def _sign(value: Number) -> Number:
    if isinstance(value, float):
        return math.copysign(1.0, value) if value else 0.0
    return np.sign(value)


def _sqrt(value: Number) -> Number:
    return math.sqrt(value) if isinstance(value, float) else np.sqrt(value)


def _finite(value: Number) -> Number:
    return math.isfinite(value) if isinstance(value, float) else np.isfinite(value)


def _inverse(value: Number) -> Number:
    """1/value, infinite at zero."""
    if isinstance(value, float):
        return 1.0 / value if value else INFINITE
    return 1.0 / value


def _quotient(value: Number, divisor: Number) -> Number:
    """value/divisor where the divisor is positive, else infinite."""
    if isinstance(divisor, float):
        return value / divisor if divisor > 0.0 else INFINITE
    quotient = np.full_like(divisor, INFINITE)
    np.divide(value, divisor, out=quotient, where=divisor > 0.0)
    return quotient


def _stack(columns: list[Number]) -> NDArray[np.float64]:
    if isinstance(columns[0], float):
        return np.array(columns)
    return np.stack(columns, axis=-1)
