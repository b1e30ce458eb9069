"""Impact at a point that is elastic along the surface too: Stronge's tangential spring beside the
normal one.

The normal spring has stiffness k in loading and k/e*^2 in unloading, so that it returns e*^2 of the
work it took. The tangential spring has stiffness k/eta^2, and its foot slides where its force T
would leave the friction cone |T| <= mu N. With the inverse mass matrix K, dv = K (N, T) dt. The
outcome depends on K, v, mu, e* and eta^2. The stiffness k sets the time alone, and is 1 here. An
impact is a sequence of phases (``impact_springs``):

* stick: the motion of two oscillators. It ends where the force reaches the cone
  or where loading or unloading ends;
* slip in the sense s: T = -mu s N, so that v and the foot's velocity v_t + mu s
  eta^2 kappa v_n are linear in the normal impulse p, and N^2 = N_0^2 - 2 kappa (v_n p + v_n'(p)
  p^2/2). It ends at a root of a polynomial: the foot stops, loading or unloading ends, or N = 0.

Loading ends where v_n = 0. With e* = 0 the contact ends there too, and the energy of both springs
is lost. In unloading the coefficient of friction is mu_2. A tangential force T beyond the cone
jumps onto the cone. A point that is pressed deeper than before loads again, with mu_1. The works
are those on the bodies; in stick they are -Delta N^2/(2 kappa) and -eta^2 Delta T^2/2. Springs
begin and end without force, or lose their force, so energy never grows.

A point of one degree of freedom may never leave the surface. In stiction friction holds both
springs compressed; in a jam the root drives the point on into the surface at a constant speed, and
both forces grow. Balanced forces, K (N, T) = 0, do not change the motion, and their impulse has no
end. The impact therefore ends where K (N, T) is first stationary in loading, at K_nt v_n + K_tt
v_t/eta^2 = 0. This is the velocity of the balance about which the point would swing; it is 0 in
stiction. As eta^2 falls, this end tends to the end of slip, where the impact of a rigid point ends.

As eta^2 falls, the result tends to the result for a rigid point. If the rigid point sticks, the
impulse differs by a term of order eta^2. Three differences are of order eta: the impulse where slip
reverses, since T crosses the cone in a time of that order; the impulse where slip and approach stop
together, as on a radial bristle; and the slip that remains if e* = 0.

Source: W. J. Stronge, *Impact Mechanics*, 2nd ed. (2018), chs. 5 and 6; N. Maw, J. R. Barber, J. N.
Fawcett, Wear 38 (1976) 101-114.
"""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_arguments import Arguments
from bristle_sim.theory.impact_events import (
    APART,
    BACKWARD,
    BALANCED,
    FORWARD,
    LINE,
    NEVER,
    NONE,
    SETTLED,
    STOP,
)
from bristle_sim.theory.impact_phases import (
    INFINITE,
    JAM,
    KNIFE_EDGE,
    NO_REBOUND,
    REBOUND,
    STICTION,
    Impact,
    inverse_mass_of,
)
from bristle_sim.theory.impact_springs import Contact, begun_slip, slide, stick

# Energetic coefficient of restitution below which 0 is used. The work that the spring returns would
# be less than the rounding error of the work that loads it.
LEAST_RESTITUTION = 1e-8
# Largest coefficient of friction that is used. Its cone differs from a half-plane by 1e-12 rad.
WIDEST_CONE = 1e12

MOST_IN_STICK = 10_000
"""Largest number of consecutive phases of stick in which the fast oscillation is computed.

Later phases begin without this oscillation, as if its energy were lost. The cost is proportional to
the number. With a nearly singular inverse mass matrix K the two natural angular frequencies differ
by a factor of a thousand, and the contact alternates between loading and unloading: 2,690 times at
det K = 2e-5 K_nn K_tt."""

SETTLING = 120
LEAST_RESOLVED = 2e-3
"""Largest number of phases of stick in two special cases, instead of ``MOST_IN_STICK``.

The first case is a jam of one degree of freedom, which further phases do not change. The second
case is a coefficient of restitution e* below ``LEAST_RESOLVED``. The steep unloading spring then
makes the point bounce some 1/e* times. In one of fifty such impacts the loss of the oscillation
changes the velocity, by up to an eighth."""

CHATTER = 500
FURTHER = 20
"""Number of changes from unloading to loading before the slip velocity is first halved, and number
of further changes before each further halving.

If friction is larger in unloading than in loading, slip can press the point back as soon as the
point begins to separate. In about one of a thousand impacts this occurs a million times, and each
change reduces the slip velocity by less than a millionth."""
# Coefficient of restitution e* below which phases of slip are counted like phases of stick: the
# steep unloading spring makes the point bounce some 1/e* times.
LEAST_EXACT = 0.01

MOTION = Contact._fields.index("normal")  # index of the first entry of ``Contact`` that changes


def _turned(contact: Contact, event: Number) -> Contact:
    """Return the contacts with the changes that an event makes, at the start of the next phase.

    An event can change the stiffness, the coefficient of friction, the tangential force and the
    sense of slip.
    """
    line = event == LINE
    loading = contact.loading > 0.0
    deepest = line & loading
    again = line & ~loading
    push = np.where(
        loading, contact.push, np.where(again, contact.peak, np.minimum(contact.push, contact.peak))
    )
    mu = np.where(deepest, contact.mu_2, np.where(again, contact.mu_1, contact.friction))
    limit = mu * push
    slides = (event == FORWARD) | (event == BACKWARD)
    side = np.where(event == FORWARD, 1.0, -1.0)
    contact = contact._replace(
        normal=np.where(deepest, 0.0, contact.normal),
        push=push,
        rub=np.where(slides, -side * limit, np.maximum(np.minimum(contact.rub, limit), -limit)),
        peak=np.where(deepest, push, contact.peak),
        loading=np.where(line, 1.0 - contact.loading, contact.loading),
        steep=np.where(deepest, 1.0 / contact.restitution, np.where(again, 1.0, contact.steep)),
        friction=mu,
    )
    stays = (event == STOP) | (event == NONE) | (event == BALANCED)
    return contact._replace(slip=np.where(slides, side, np.where(stays, 0.0, begun_slip(contact))))


class _Contacts:
    """The present state of an array of n contacts, and their impulses and works so far.

    If a contact in unloading is pressed beyond its deepest penetration, everything up to then
    counts as compression.

    Attributes:
        rows: entries of ``Contact``, one row each, with one column for each contact.
        totals: normal and tangential impulse, normal and tangential work, and slip, for each of the
            four phases of ``impact_phases.PHASES``, shape (5, 4, n). The phase "after slip"
            collects everything after the first stick or slip.
        row: index of the present phase in ``totals``.
        moves: whether neither a balance of forces nor the end of loading has occurred yet. It
            matters for points with one degree of freedom.
        balanced, velocity: ``totals`` and the velocity at the instant at which ``moves`` becomes
            false.
    """

    def __init__(self, contact: Contact) -> None:
        size = contact.slip.size
        self.rows = np.array(contact)
        self.initial = contact.slip
        self.totals = np.zeros((5, 4, size))
        self.row = np.zeros(size, dtype=int)
        self.phases = np.zeros(size, dtype=int)
        self.settled = np.zeros(size, dtype=bool)
        self.slip_stop = np.full(size, INFINITE)
        self.outcome = np.zeros(size, dtype=int)
        self.again = np.zeros(size, dtype=int)
        self.moves = np.ones(size, dtype=bool)
        self.balanced = np.zeros_like(self.totals)
        self.velocity = np.zeros((2, size))

    def advance(self, active: Number) -> Number:
        """Advance contacts by one phase, and return the indices of those that have not ended.

        ``active`` holds the indices of the contacts to advance.
        """
        slips = self.rows[-1, active] != 0.0
        going = [active[:0]]
        for at, slides in ((active[slips], True), (active[~slips], False)):
            before = Contact(*self.rows.take(at, axis=1))
            if slides:
                after, event, done = slide(before)
            else:
                fresh = ~self.settled[at]
                many = fresh & (self.phases[at] >= SETTLING)
                most = (self.phases[at] >= MOST_IN_STICK) | (before.restitution < LEAST_RESOLVED)
                after, event, done = stick(before, many, many & most, self.moves[at])
            over = self.note(at, before, after, event, done)
            self.turn(at, before, _turned(after, event), event, over)
            going.append(at[~over])
        return np.concatenate(going)

    def note(
        self, at: Number, before: Contact, after: Contact, event: Number, done: tuple[Number, ...]
    ) -> Number:
        """Add the impulses and works of a phase to the totals, and note which contacts have ended.

        Args:
            at: indices of the contacts.
            before: contacts before the phase.
            after: contacts after the phase.
            event: events that ended the phase.
            done: normal impulse, tangential impulse, normal work and tangential work of the phase.

        Returns:
            For each contact in ``at``, whether it has ended.
        """
        row = self.row[at]
        loading = before.loading > 0.0
        self.totals[:4, row, at] += done
        moved = done[0] > 0.0
        self.totals[4, row[moved], at[moved]] = before.slip[moved]
        deepest = (event == LINE) & loading
        kept = self.moves[at] & ((event == BALANCED) | deepest)
        chosen = at[kept]
        self.moves[chosen] = False
        self.velocity[:, chosen] = after.normal[kept], after.tangential[kept]
        self.balanced[..., chosen] = self.totals[..., chosen]
        counts = (before.slip == 0.0) | (before.restitution < LEAST_EXACT)
        # a force that fades slowly, with a little slip in each swing
        counts |= ~loading & (before.stick == 0.0)
        self.phases[at] = np.where(counts, self.phases[at] + 1, 0)
        self.settled[at] = event == SETTLED
        over = (event == APART) | (event == NEVER) | (deepest & (before.restitution == 0.0))
        pressed = loading | (after.normal < -KNIFE_EDGE * before.approach)
        parted = np.where((event == APART) & (after.normal > 0.0), REBOUND, NO_REBOUND)
        outcome = np.where(event == NEVER, np.where(pressed, JAM, STICTION), parted)
        self.outcome[at[over]] = outcome[over]
        return over

    def set_back(self) -> None:
        """Set contacts that end in a jam or stiction back to the instant of ``balanced``."""
        at = np.flatnonzero(np.isin(self.outcome, (JAM, STICTION)) & ~self.moves)
        self.rows[MOTION : MOTION + 2, at] = self.velocity[:, at]
        self.totals[..., at] = self.balanced[..., at]

    def turn(
        self, at: Number, before: Contact, after: Contact, event: Number, over: Number
    ) -> None:
        """Store the states of contacts after their events, and select their next phases.

        The next phase is the row of ``totals`` to which the impulses that follow are added.

        Args:
            at: indices of the contacts.
            before: contacts before the phase that has ended.
            after: contacts after their events, one for each index in ``at``.
            event: events that ended the phase.
            over: whether each contact has ended. A contact that has ended gets no new phase.
        """
        self.rows[MOTION:, at] = after[MOTION:]
        line = event == LINE
        again = line & (before.loading == 0.0)
        chosen = at[again]
        if chosen.size:
            self.totals[:4, 1, chosen] += self.totals[:4, 2:, chosen].sum(axis=1)
            self.totals[:, 2:, chosen] = 0.0
            self.again[chosen] += 1
            self.rest(chosen[self.again[chosen] >= CHATTER])
        turned = (after.slip != before.slip) & ~over
        row = self.row[at]
        self.row[at] = np.where(again, 1, np.where(line, 2, np.where(turned, row | 1, row)))
        stops = at[turned & (self.initial[at] != 0.0) & (self.slip_stop[at] == INFINITE)]
        self.slip_stop[stops] = self.totals[0][:, stops].sum(axis=0)

    def rest(self, at: Number) -> None:
        """Halve the tangential velocity of contacts that alternate too often between two phases.

        The two phases are loading and unloading. During these changes the mean friction force keeps
        the normal velocity constant. ``at`` holds the indices of the contacts.
        """
        contact = Contact(*self.rows.take(at, axis=1))
        speed = contact.tangential
        ratio = -contact.k_nn / contact.k_nt
        impulse = 0.5 * speed * contact.k_nt / (contact.stick * contact.k_tt)
        impulse = np.where(np.isfinite(impulse), np.maximum(impulse, 0.0), 0.0)
        done = (impulse, ratio * impulse, 0.0 * impulse, 0.75 * ratio * impulse * speed)
        self.totals[:4, 1, at] += done
        self.rows[MOTION + 1, at] = np.where(impulse > 0.0, 0.5 * speed, speed)
        self.again[at] -= FURTHER


def compliant_impact(values: Arguments, squared: Number) -> Impact:
    """Resolve impacts on a normal spring with energetic restitution and a tangential spring.

    ``values`` holds the arguments by name as arrays of shape (n,), with K_nn > 0 and v_n < 0.
    ``squared`` is the ratio eta^2 > 0 of the normal to the tangential stiffness, shape (n,).
    """
    k_nn = values["k_nn"]
    normal = values["normal"]
    tangential = values["tangential"]
    # Scaling by powers of two keeps squares in the range of floats, and loses no digit.
    mass, speed = (
        np.ldexp(1.0, np.frexp(each)[1]) for each in (k_nn, np.maximum(-normal, abs(tangential)))
    )
    k_nn = k_nn / mass
    k_nt = values["k_nt"] / mass
    k_tt = values["k_tt"] / mass
    stick_compliance = values.get("stick_compliance")
    known = None if stick_compliance is None else stick_compliance / mass
    normal = normal / speed
    tangential = tangential / speed
    mu_1 = np.minimum(values["friction"], WIDEST_CONE)
    mu_2 = np.minimum(values["restitution_friction"], WIDEST_CONE)
    e = np.where(values["restitution"] < LEAST_RESTITUTION, 0.0, values["restitution"])
    none = np.zeros_like(normal)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        inverse_mass = inverse_mass_of(k_nn, k_nt, k_tt, known)
        matrix = (k_nn, k_nt, k_tt, inverse_mass.stick, -inverse_mass.stick_ratio)
        surface = (mu_1, mu_2, e, np.sqrt(squared))
        begun = (normal, tangential, none, none, none, none + 1.0, none + 1.0, mu_1, none)
        contact = Contact(*matrix, *surface, -normal, *begun)
        contacts = _Contacts(contact._replace(slip=begun_slip(contact)))
        active = np.arange(none.size)
        while active.size:
            active = contacts.advance(active)
        contacts.set_back()
    momentum = speed / mass
    impulses, along = contacts.totals[:2] * momentum
    normal_works, tangential_works = contacts.totals[2:4] * (speed * momentum)
    slip_stop = np.where(contacts.initial == 0.0, 0.0, contacts.slip_stop * momentum)
    return Impact(
        impulse_normal=impulses.sum(axis=0),
        impulse_tangential=along.sum(axis=0),
        velocity_normal=contacts.rows[MOTION] * speed,
        velocity_tangential=contacts.rows[MOTION + 1] * speed,
        compressive_impulse_normal=impulses[:2].sum(axis=0),
        compressive_impulse_tangential=along[:2].sum(axis=0),
        slip_stop_impulse=slip_stop,
        phase_impulse=impulses.T,
        phase_slip=contacts.totals[4].T,
        phase_work_normal=normal_works.T,
        phase_work_tangential=tangential_works.T,
        outcome=contacts.outcome,
    )
