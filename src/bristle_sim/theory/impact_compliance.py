"""Impact at a point that is elastic along the surface too: Stronge's tangential spring beside the
normal one.

The normal spring has stiffness k in loading and k/e*^2 in unloading, so that it returns e*^2 of the
work it took; the tangential one has k/eta^2, and its foot slides where its force T would leave the
cone |T| <= mu N. With dv = K (N, T) dt the outcome depends on K, v, mu, e* and eta^2. The stiffness
k sets the time alone, and is 1 here. An impact is a sequence of phases:

* stick (``impact_stick``): two oscillators, ended by the cone or by the end of the line;
* slip in the sense s (``impact_slip``): T = -mu s N, so that v and the foot's velocity v_t + mu s eta^2 kappa v_n are linear in the normal impulse p,
  and N^2 = N_0^2 - 2 kappa (v_n p + v_n'(p) p^2/2): it ends where the foot stops, the line ends or N = 0, each a root of a polynomial.

Loading ends where v_n = 0, and the contact with it if e* = 0: the energy of both springs is then
lost. In unloading mu_2 holds. A tangential force T beyond the cone jumps onto the cone. A point
that is pressed beyond its deepest point loads further, with mu_1. The works are those on the
bodies, -Delta N^2/(2 kappa) and -eta^2 Delta T^2/2 in stick. Springs begin and end without force,
or lose their force, so energy never grows.

As eta^2 falls the result tends to that of the rigid point. If the rigid point sticks, the impulse
differs by a term of order eta^2. Three differences are of order eta: the impulse where slip
reverses, since T takes a time of that order from one edge of the cone to the other; the impulse
where slip and approach stop together, as on a radial bristle; and the slip that is left where e* =
0.

Source: W. J. Stronge, *Impact Mechanics*, 2nd ed. (2018), chs. 5 and 6; N. Maw, J. R. Barber, J. N.
Fawcett, Wear 38 (1976) 101-114.
"""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_events import (
    APART,
    BACKWARD,
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
from bristle_sim.theory.impact_slip import begun_slip, slide
from bristle_sim.theory.impact_stick import Contact, stick

# Smallest e* other than 0: below it the returned work is less than the rounding of the work taken.
LEAST_RESTITUTION = 1e-8

WIDEST_CONE = 1e12  # largest friction used: its cone is a half-plane to parts in 1e12


MOST_IN_STICK = 10_000
"""Largest number of consecutive phases of stick with the fast oscillation; later phases begin
without it, as if it were lost.

It bounds the cost, which is linear in the number. The modes of a nearly singular K, whose rates
differ a thousandfold, bounce between loading and unloading: 198 times at det K = 1e-4 K_nn K_tt,
2,690 times at 2e-5 K_nn K_tt."""

SETTLING = 120
LEAST_RESOLVED = 2e-3
"""Largest number of phases of stick, as ``MOST_IN_STICK``, in two cases, and the e* below which the
second one applies.

The first is a jam of one degree of freedom, which further phases do not change. The second is an e*
below ``LEAST_RESOLVED``: the point bounces on the steep unloading line some 1/e* times. The lost
oscillation then changes its velocity by up to an eighth in one impact of fifty."""

CHATTER = 500
FURTHER = 20
"""Number of times that a point is pressed on again before its slip is halved at rest, and before
each further halving.

With mu_2 > mu_1 slip can press the point on as soon as it begins to part. In one of some thousand
impacts this happens a million times, and each time changes the slip by less than a millionth."""

# The e* below which phases of slip are counted too: the point bounces on the steep line some 1/e*
# times.
LEAST_EXACT = 0.01

MOTION = Contact._fields.index("normal")  # index of the first row of a contact that changes


def _turned(contact: Contact, event: Number) -> Contact:
    """Return the contact after an event, with its new loading or unloading line and slip."""
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
    return contact._replace(
        slip=np.where(slides, side, np.where(event == STOP, 0.0, begun_slip(contact)))
    )


class _Contacts:
    """The present state of an array of contacts, in columns of ``rows``.

    ``totals`` holds impulses and works in the four rows of ``impact_phases.PHASES``, ``slips`` the
    slip in these rows. The second row of compression collects everything after its first stick or
    slip, and so does that of restitution. A point that is pressed beyond its deepest point was in
    compression until then.
    """

    def __init__(self, contact: Contact) -> None:
        self.rows = np.array(contact)
        self.initial = contact.slip
        size = contact.slip.size
        self.totals = np.zeros((4, 4 * size))
        self.slips = np.zeros((size, 4))
        self.row = np.zeros(size, dtype=int)
        self.phases = np.zeros(size, dtype=int)
        self.settled = np.zeros(size, dtype=bool)
        self.slip_stop = np.full(size, INFINITE)
        self.outcome = np.zeros(size, dtype=int)
        self.again = np.zeros(size, dtype=int)

    @property
    def by_row(self) -> Number:
        """Totals by quantity, contact and row."""
        return self.totals.reshape(4, -1, 4)

    def advance(self, active: Number) -> Number:
        """Advance the active contacts by one phase, and return the contacts that have not ended."""
        slips = self.rows[-1, active] != 0.0
        going = [active[:0]]
        for at, slides in ((active[slips], True), (active[~slips], False)):
            before = Contact(*self.rows.take(at, axis=1))
            if slides:
                after, event, done = slide(before)
            else:
                many = self.phases[at] >= SETTLING
                most = many & (
                    (self.phases[at] >= MOST_IN_STICK) | (before.restitution < LEAST_RESOLVED)
                )
                after, event, done = stick(
                    before, many & ~self.settled[at], most & ~self.settled[at]
                )
            over = self.note(at, before, after, event, done)
            turned = _turned(after, event)
            if (event == NONE).any():
                turned = Contact(
                    *(np.where(event == NONE, *pair) for pair in zip(after, turned, strict=True))
                )
            self.turn(at, before, turned, event, over)
            going.append(at[~over])
        return np.concatenate(going)

    def note(
        self, at: Number, before: Contact, after: Contact, event: Number, done: tuple[Number, ...]
    ) -> Number:
        """Add a phase, or a part of a phase, of the contacts with indices ``at``.

        Returns:
            Whether each of these contacts ends.
        """
        place = 4 * at + self.row[at]
        loading = before.loading > 0.0
        for total, part in zip(self.totals, done, strict=True):
            total[place] += part
        moved = done[0] > 0.0
        self.slips.ravel()[place[moved]] = before.slip[moved]
        counts = (before.slip == 0.0) | (before.restitution < LEAST_EXACT)
        self.phases[at] = np.where(counts, self.phases[at] + 1, 0)
        self.settled[at] = event == SETTLED
        over = (
            (event == APART)
            | (event == NEVER)
            | ((event == LINE) & loading & (before.restitution == 0.0))
        )
        ends = np.flatnonzero(over)
        event = event[ends]
        speed = after.normal[ends]
        approach = before.approach[ends]
        pressed = loading[ends] | (speed < -KNIFE_EDGE * approach)
        parted = np.where((event == APART) & (speed > 0.0), REBOUND, NO_REBOUND)
        self.outcome[at[ends]] = np.where(event == NEVER, np.where(pressed, JAM, STICTION), parted)
        return over

    def turn(
        self, at: Number, before: Contact, after: Contact, event: Number, over: Number
    ) -> None:
        """Set the contacts to the state after an event, and to the row of the next phase."""
        for row, value in zip(self.rows[MOTION:], after[MOTION:], strict=True):
            row[at] = value
        line = event == LINE
        again = line & (before.loading == 0.0)
        chosen = at[again]
        if chosen.size:
            rows = self.by_row
            rows[:, chosen, 1] += rows[:, chosen, 2:].sum(axis=-1)
            rows[:, chosen, 2:], self.slips[chosen, 2:] = 0.0, 0.0
            self.again[chosen] += 1
            self.rest(chosen[self.again[chosen] >= CHATTER])
        turned = (after.slip != before.slip) & ~over
        row = self.row[at]
        self.row[at] = np.where(again, 1, np.where(line, 2, np.where(turned, row | 1, row)))
        stops = at[turned & (self.initial[at] != 0.0) & (self.slip_stop[at] == INFINITE)]
        self.slip_stop[stops] = self.by_row[0, stops].sum(axis=-1)

    def rest(self, at: Number) -> None:
        """Halve the slip of points that chatter, under the mean friction that keeps v_n unchanged."""
        contact = Contact(*self.rows.take(at, axis=1))
        speed = contact.tangential
        ratio = -contact.k_nn / contact.k_nt
        impulse = 0.5 * speed * contact.k_nt / (contact.stick * contact.k_tt)
        impulse = np.where(np.isfinite(impulse), np.maximum(impulse, 0.0), 0.0)
        done = (impulse, ratio * impulse, 0.0 * impulse, 0.75 * ratio * impulse * speed)
        self.by_row[:, at, 1] += done
        self.rows[MOTION + 1, at] = np.where(impulse > 0.0, 0.5 * speed, speed)
        self.again[at] -= FURTHER


def compliant_impact(values: list[Number], squared: Number) -> Impact:
    """Resolve energetic impacts of approaching points with a tangential compliance eta^2.

    Args:
        values: arrays of shape (n,): K_nn > 0, K_nt, K_tt, v_n < 0, v_t, mu_1, e*, mu_2, and the
            compliance in stick if it is known more accurately than from K.
        squared: eta^2 > 0, shape (n,).
    """
    k_nn, k_nt, k_tt, normal, tangential, mu_1, e, mu_2, *given = values
    # Scaling by powers of two keeps squares in the range of floats, and loses no digit.
    mass, speed = (
        np.ldexp(1.0, np.frexp(each)[1]) for each in (k_nn, np.maximum(-normal, abs(tangential)))
    )
    k_nn = k_nn / mass
    k_nt = k_nt / mass
    k_tt = k_tt / mass
    normal, tangential = normal / speed, tangential / speed
    mu_1 = np.minimum(mu_1, WIDEST_CONE)
    mu_2 = np.minimum(mu_2, WIDEST_CONE)
    e = np.where(e < LEAST_RESTITUTION, 0.0, e)
    none = np.zeros_like(normal)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        inverse_mass = inverse_mass_of(k_nn, k_nt, k_tt, given[0] / mass if given else None)
        bodies = (
            k_nn,
            k_nt,
            k_tt,
            inverse_mass.stick,
            -inverse_mass.stick_ratio,
            mu_1,
            mu_2,
            e,
            np.sqrt(squared),
            -normal,
        )
        contact = Contact(
            *bodies, normal, tangential, none, none, none, none + 1.0, none + 1.0, mu_1, none
        )
        contacts = _Contacts(contact._replace(slip=begun_slip(contact)))
        active = np.arange(none.size)
        while active.size:
            active = contacts.advance(active)
    momentum = (speed / mass)[:, np.newaxis]
    energy = (speed * speed / mass)[:, np.newaxis]
    impulses, along = contacts.by_row[:2] * momentum
    normal_works, tangential_works = contacts.by_row[2:] * energy
    return Impact(
        impulse_normal=impulses.sum(axis=-1),
        impulse_tangential=along.sum(axis=-1),
        velocity_normal=contacts.rows[MOTION] * speed,
        velocity_tangential=contacts.rows[MOTION + 1] * speed,
        compressive_impulse_normal=impulses[:, :2].sum(axis=-1),
        compressive_impulse_tangential=along[:, :2].sum(axis=-1),
        slip_stop_impulse=np.where(
            contacts.initial == 0.0, 0.0, contacts.slip_stop * momentum[:, 0]
        ),
        phase_impulse=impulses,
        phase_slip=contacts.slips,
        phase_work_normal=normal_works,
        phase_work_tangential=tangential_works,
        outcome=contacts.outcome,
    )
