"""The result of an impact at one point, and its phases, for every coefficient of restitution.

Within a phase of constant slip direction (or stick) the velocities are linear in the normal impulse
and the works quadratic, so that each phase ends in closed form. Slip ends where v_t = 0,
compression where v_n = 0. Restitution ends at its target, which is a normal work, impulse or
velocity. The functions accept arrays, and also floats, for which they take less time.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import EqualByValue, Number
from bristle_sim.theory.numbers import quotient, select, sign, square_root

NO_CONTACT, REBOUND, NO_REBOUND, STICTION, JAM = range(5)
OUTCOMES = ("no contact", "rebound", "no rebound", "stiction", "jam")
"""Names of the outcomes of an impact, by their codes.

``no contact``: the point does not approach. ``rebound``: restitution ends with a normal velocity
v_n > 0. ``no rebound``: the coefficient of restitution is 0, or restitution ends with v_n = 0.
``stiction``: compression ends, but no impulse can separate the point from the surface again. This
occurs at a point with one degree of freedom, such as a radial bristle's tip, if friction is large.
``jam``: the point sticks, and no impulse ends compression; the rigid-body law has no solution.
"""

PHASES = ("compression", "compression after slip", "restitution", "restitution after slip")
"""Names of the four phases of an impact. A phase that does not occur has no normal impulse."""

KNIFE_EDGE = 1e-6
"""Normal speed, as a fraction of the speed of approach, up to which a sticking point with one
degree of freedom counts as being at rest.

An example is the tip of a radial bristle. Such a point neither jams nor rebounds: a rebound with
the normal work W would require an unbounded impulse W/v_n."""

SINGULAR = 64.0 * sys.float_info.epsilon
"""Change of the normal velocity per unit normal impulse in stick, as a fraction of K_nn, below
which this change is rounding error. The point then has one degree of freedom."""


@dataclass(frozen=True, slots=True, eq=False)
class Impact(EqualByValue):
    """The result of an impact, or of an array of impacts.

    Each attribute is a float for a single impact, or an array of the broadcast shape. Impulses and
    works are those on the moving body; normal impulses are positive.

    Attributes:
        impulse_normal, impulse_tangential: total impulse, N s.
        velocity_normal, velocity_tangential: velocity after the impact, m/s.
        compressive_impulse_normal, compressive_impulse_tangential: impulse of compression, N s.
        slip_stop_impulse: normal impulse at which the initial slip stops, N s; inf if the slip does
            not stop.
        phase_impulse: normal impulse of each of the four ``PHASES``, shape (..., 4), N s.
        phase_slip: direction of slip in each of the ``PHASES``, -1, 0 (stick) or 1, shape (..., 4).
        phase_work_normal, phase_work_tangential: works in each of the ``PHASES``, shape (..., 4),
            J.
        outcome: index of the outcome in ``OUTCOMES``.
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
    def compressive_work(self) -> tuple[Number, Number]:
        """Normal work (negative) and tangential work of compression, J."""
        normal = self.phase_work_normal[..., :2].sum(axis=-1)
        return normal, self.phase_work_tangential[..., :2].sum(axis=-1)

    @property
    def restitutive_work(self) -> tuple[Number, Number]:
        """Normal work (positive) and tangential work of restitution, J."""
        normal = self.phase_work_normal[..., 2:].sum(axis=-1)
        return normal, self.phase_work_tangential[..., 2:].sum(axis=-1)

    @property
    def energy_change(self) -> Number:
        """Change of the bodies' kinetic energy in the impact, J: the sum of all works."""
        return self.phase_work_normal.sum(axis=-1) + self.phase_work_tangential.sum(axis=-1)

    @property
    def outcome_name(self) -> str:
        """Name of the outcome of a single impact."""
        return OUTCOMES[int(self.outcome)]

    @property
    def phases(self) -> tuple[str, ...]:
        """Names of a single impact's phases in order, such as ``restitution stick``."""
        slips = self.phase_slip.tolist()
        names = []
        for name, impulse, slip in zip(PHASES, self.phase_impulse.tolist(), slips, strict=True):
            if impulse > 0.0:
                motion = "stick" if slip == 0.0 else "reverse slip" if slip == -slips[0] else "slip"
                names.append(f"{name.split()[0]} {motion}")
        return tuple(names)


@dataclass(slots=True)
class _State:
    """The present velocity of the contact point in an impact, and the impulse on it so far."""

    normal: Number
    tangential: Number
    impulse: Number
    impulse_tangential: Number


class InverseMass(NamedTuple):
    """The entries of the inverse mass matrix of the contact point, and its response in stick.

    Attributes:
        normal, coupling, tangential: entries K_nn, K_nt and K_tt of the matrix, 1/kg.
        stick: change of the normal velocity per unit normal impulse while the point does not slip,
            1/kg; exactly 0 for one degree of freedom.
        stick_ratio: ratio of the tangential to the normal impulse while the point does not slip.
    """

    normal: Number
    coupling: Number
    tangential: Number
    stick: Number
    stick_ratio: Number


class Target(NamedTuple):
    """The values at which restitution ends.

    Attributes:
        work: normal work that restitution has still to do (Stronge), J.
        impulse: normal impulse that restitution has still to apply (Poisson), N s.
        velocity: final normal velocity (Newton), m/s.
        least: normal speed up to which a sticking point with one degree of freedom counts as being
            at rest, m/s.
    """

    work: Number
    impulse: Number
    velocity: Number
    least: Number


class _Phase(NamedTuple):
    """The result of one phase of an impact.

    Attributes:
        impulse: normal impulse of the phase, N s.
        slip: direction of slip, -1, 0 (stick) or 1.
        work_normal, work_tangential: works of the phase, J.
        stopped: whether slip stopped in the phase.
        unfinished: whether compression or restitution continues after the phase.
    """

    impulse: Number
    slip: Number
    work_normal: Number
    work_tangential: Number
    stopped: Number
    unfinished: Number


_NOTHING = _Phase(0.0, 0.0, 0.0, 0.0, False, False)  # phase that does not occur in a single impact

# (velocity, compliance, target) -> normal impulse of restitution
End = Callable[[Number, Number, Target], Number]


def energetic_end(velocity: Number, compliance: Number, target: Target) -> Number:
    """Return the normal impulse p (N s) of the phase in which restitution ends, by Stronge's rule.

    The normal work v p + a p^2/2 must equal ``target.work``, with the normal velocity v at the
    start of the phase (``velocity``) and its change a per unit normal impulse (``compliance``).
    """
    work = select(target.work > 0.0, target.work, 0.0)
    root = square_root(velocity * velocity + 2.0 * compliance * work)
    return select(work > 0.0, quotient(2.0 * work, velocity + root), 0.0)


def resolve_phases(
    k_nn: Number,
    k_nt: Number,
    k_tt: Number,
    normal: Number,
    tangential: Number,
    friction: Number,
    restitution: Number,
    restitution_friction: Number,
    stick_compliance: Number | None = None,
    end: End = energetic_end,
) -> Impact:
    """Resolve rigid impacts phase by phase, without a check of the arguments.

    Args:
        k_nn, k_nt, k_tt: entries of the inverse mass matrix, 1/kg.
        normal, tangential: velocity before the impact, m/s.
        friction: coefficient of friction in compression.
        restitution: coefficient of restitution e.
        restitution_friction: coefficient of friction in restitution.
        stick_compliance: normal compliance in stick, 1/kg; by default it follows from the matrix.
        end: function that returns the normal impulse at which restitution ends.
    """
    mass = inverse_mass_of(k_nn, k_nt, k_tt, stick_compliance)
    approaching = normal < 0.0
    none = abs(0.0 * normal)
    state = _State(select(approaching, normal, 0.0), tangential, none, none)
    initial = sign(tangential)

    first = _phase(state, mass, friction, initial, approaching & (initial != 0.0))
    second = _phase(state, mass, friction, _settled(mass, friction), state.normal < 0.0)
    jammed = approaching & (state.normal < KNIFE_EDGE * normal)
    compressive = (state.impulse, state.impulse_tangential)

    # Compression may have ended in slip, reversed slip or stick; slip continues.
    work = -(first.work_normal + second.work_normal) * restitution * restitution
    target = Target(work, restitution * compressive[0], -restitution * normal, -KNIFE_EDGE * normal)
    opens = (approaching ^ jammed) & (restitution > 0.0)
    slip = sign(state.tangential)
    third = _phase(state, mass, restitution_friction, slip, opens & (slip != 0.0), target, end)
    left = target._replace(work=work - third.work_normal, impulse=target.impulse - third.impulse)
    still_open = opens & ((slip == 0.0) | third.unfinished)
    settled = _settled(mass, restitution_friction)
    fourth = _phase(state, mass, restitution_friction, settled, still_open, left, end)

    # Poisson's restitution ends at an impulse even where no impulse can part the point.
    stuck = fourth.unfinished | ((state.normal <= 0.0) & (mass.stick == 0.0))
    parted = select(state.normal > 0.0, REBOUND, NO_REBOUND)
    ending = select(restitution == 0.0, NO_REBOUND, select(stuck, STICTION, parted))
    late = first.impulse + second.impulse + third.impulse
    stop = select(first.stopped, first.impulse, select(third.stopped, late, math.inf))
    *columns, _, _ = zip(first, second, third, fourth, strict=True)
    impulses, slips, normal_works, tangential_works = np.array(columns).swapaxes(1, -1)
    return Impact(
        impulse_normal=state.impulse,
        impulse_tangential=state.impulse_tangential,
        velocity_normal=select(approaching, state.normal, normal),
        velocity_tangential=state.tangential,
        compressive_impulse_normal=compressive[0],
        compressive_impulse_tangential=compressive[1],
        slip_stop_impulse=select(initial == 0.0, 0.0, stop),
        phase_impulse=impulses,
        phase_slip=slips,
        phase_work_normal=normal_works,
        phase_work_tangential=tangential_works,
        outcome=select(approaching, select(jammed, JAM, ending), NO_CONTACT),
    )


def inverse_mass_of(k_nn: Number, k_nt: Number, k_tt: Number, stick: Number | None) -> InverseMass:
    """Return the inverse mass matrix with the normal compliance in stick, k_nn - k_nt^2/k_tt.

    If ``stick`` (1/kg) is given, it replaces this compliance.
    """
    ratio = select(k_tt > 0.0, quotient(k_nt, k_tt), 0.0)
    if stick is None:
        difference = k_nn - ratio * k_nt
        stick = select(difference > SINGULAR * k_nn, difference, 0.0)
    return InverseMass(k_nn, k_nt, k_tt, stick, -ratio)


def _settled(mass: InverseMass, mu: Number) -> Number:
    """Return the sense of slip after the initial slip: 0 in stick, otherwise the sign of K_nt."""
    holds = mu * mass.tangential >= abs(mass.coupling)
    return select(holds, 0.0, sign(mass.coupling))


def _phase(
    state: _State,
    mass: InverseMass,
    mu: Number,
    slip: Number,
    active: Number,
    target: Target | None = None,
    end: End | None = None,
) -> _Phase:
    """Advance the state to the end of slip, or to an earlier end of compression or restitution.

    With a ``target`` the phase belongs to restitution, otherwise to compression. If no finite
    impulse ends the phase, the state does not change. Where slip would drive the point back into
    the surface in restitution, the normal velocity stays constant.

    Args:
        state: velocities and impulses, which the function updates.
        mass: inverse mass matrix of the contact point.
        mu: coefficient of friction.
        slip: direction of slip, 0 for stick.
        active: whether the phase occurs.
        target: values at which restitution ends, or None in compression.
        end: function that returns the normal impulse at which restitution ends.
    """
    if active is False:
        return _NOTHING
    sticks = slip == 0.0
    ratio = -mu * slip
    # The normal rate is computed from the tangential rate. Rounding error then changes both rates as
    # a small change of mu would.
    tangential_rate = mass.coupling - mu * slip * mass.tangential
    normal_rate = mass.stick - mass.stick_ratio * tangential_rate
    if target is not None:
        at_rest = (slip * mass.coupling > 0.0) & (normal_rate <= 0.0)
        # In slip at rest the tangential rate K_nt + r K_tt is -(K_nn K_tt - K_nt^2)/K_nt. The response
        # in stick gives this difference without cancellation.
        coupling = abs(mass.coupling)
        slowing = -slip * quotient(mass.stick * mass.tangential, coupling)
        ratio = select(at_rest, -slip * quotient(mass.normal, coupling), ratio)
        normal_rate = select(at_rest, 0.0, normal_rate)
        tangential_rate = select(at_rest, slowing, tangential_rate)
    ratio = select(sticks, mass.stick_ratio, ratio)
    normal_rate = select(sticks, mass.stick, normal_rate)
    tangential_rate = select(sticks, 0.0, tangential_rate)
    if target is None or end is None:
        finish = quotient(-state.normal, normal_rate)
    else:
        rests = sticks & (normal_rate == 0.0) & (state.normal <= target.least)
        finish = select(rests, math.inf, end(state.normal, normal_rate, target))

    slows = state.tangential * tangential_rate < 0.0
    stop = select(slows, quotient(abs(state.tangential), abs(tangential_rate)), math.inf)
    # With one degree of freedom, slip and compression stop at the same impulse, up to rounding error.
    stopped = active & (stop <= finish * (1.0 + SINGULAR)) & (stop < math.inf)
    finished = active & (finish <= stop * (1.0 + SINGULAR)) & (finish < math.inf)
    step = select(finished, finish, select(stopped, stop, 0.0))

    normal = state.normal + normal_rate * step
    tangential = select(stopped, 0.0, state.tangential + tangential_rate * step)
    work_normal = 0.5 * step * (state.normal + normal)
    work_tangential = 0.5 * ratio * step * (state.tangential + tangential)
    # The normal velocity at the end of compression is exactly 0.
    state.normal = select(finished & (state.normal < 0.0), 0.0, normal)
    state.tangential = tangential
    state.impulse = state.impulse + step
    state.impulse_tangential = state.impulse_tangential + ratio * step
    return _Phase(
        step, select(active, slip, 0.0), work_normal, work_tangential, stopped, active ^ finished
    )
