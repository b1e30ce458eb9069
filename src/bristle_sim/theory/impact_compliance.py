"""Impact at a point with a tangential spring in addition to the normal spring (Stronge).

The normal spring has the stiffness kappa k, with kappa = 1 in loading and kappa = 1/e*^2 in
unloading, so that it returns e*^2 of the work of loading. The tangential spring has the stiffness
k/eta^2. The foot is the tangential spring's end on the surface. The foot slides where the spring's
force T would exceed the friction limit, |T| <= mu N. With the inverse mass matrix K, the velocity
v = (v_n, v_t) of the contact point obeys dv = K (N, T) dt. The outcome depends on K, v, mu, e* and
eta^2. The stiffness k affects only the duration, and is set to 1. An impact is a sequence of
phases (``impact_stick``, ``impact_springs``):

* stick: the point moves like two oscillators. The phase ends where the force reaches the friction
  limit, or where loading or unloading ends;
* slip in the sense s: T = -mu s N. The velocity v and the foot's velocity
  v_t + mu s eta^2 kappa v_n are then linear in the normal impulse p, and
  N^2 = N_0^2 - 2 kappa (v_n p + v_n'(p) p^2/2). The phase ends at a root of a polynomial: the foot
  stops, loading or unloading ends, or N = 0.

Loading ends where v_n = 0. With e* = 0 the contact ends there too, and the energy of both springs
is lost. In unloading the coefficient of friction is mu_2. A tangential force T beyond the friction
limit jumps to the limit. A point that is pressed deeper than before loads the spring again, with
mu_1. The works are those on the bodies; in stick they are -Delta N^2/(2 kappa) and -eta^2 Delta
T^2/2. Springs begin and end without force, or lose their force, so energy never grows.

A point of one degree of freedom may never leave the surface. In stiction, friction keeps both
springs compressed. In a jam, the point moves on into the surface at a constant speed, and both
forces grow. Balanced forces, K (N, T) = 0, do not change the motion, and their impulse grows
without bound. The impact is therefore taken to end where the tangential component of K (N, T) is
first stationary in loading, at K_nt v_n + K_tt v_t/eta^2 = 0. The velocity there is the mean
velocity about which the point would swing; it is 0 in stiction. As eta^2 falls, this end tends to
the end of slip, where the impact of a rigid point ends.

As eta^2 falls, the result tends to the result for a rigid point. If the rigid point sticks, the
impulse differs by a term of order eta^2. Three differences are of order eta: the impulse where slip
reverses, since T changes from one friction limit to the other in a time of that order; the impulse
where slip and approach stop together, as on a radial bristle; and the slip that remains if e* = 0.

Source: W. J. Stronge, *Impact Mechanics*, 2nd ed. (2018), chs. 5 and 6; N. Maw, J. R. Barber, J. N.
Fawcett, Wear 38 (1976) 101-114.
"""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_arguments import Arguments
from bristle_sim.theory.impact_phases import (
    JAM,
    KNIFE_EDGE,
    NO_REBOUND,
    PHASES,
    REBOUND,
    STICTION,
    Impact,
    inverse_mass_of,
)
from bristle_sim.theory.impact_springs import Contact, Event, Sums, slide
from bristle_sim.theory.impact_stick import stick

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
"""In two special cases ``SETTLING`` is the largest number of phases of stick, instead of
``MOST_IN_STICK``.

The first case is a jam of one degree of freedom, which further phases do not change. The second
case is a coefficient of restitution e* below ``LEAST_RESOLVED``. The steep unloading spring then
makes the point bounce some 1/e* times. In one of fifty such impacts the loss of the oscillation
changes the velocity, by up to an eighth."""

CHATTER = 500
FURTHER = 20
"""``CHATTER`` is the number of changes from unloading to loading before the slip velocity is first
halved, ``FURTHER`` the number of further changes before each further halving.

If friction is larger in unloading than in loading, slip can press the point back as soon as the
point begins to separate. In about one of a thousand impacts this occurs a million times, and each
change reduces the slip velocity by less than a millionth."""
# Coefficient of restitution e* below which phases of slip are counted like phases of stick: the
# steep unloading spring makes the point bounce some 1/e* times.
LEAST_EXACT = 0.01


class Course:
    """The course of one impact: its phases, with their impulses and works.

    If a contact in unloading is pressed beyond its deepest penetration, everything up to then
    counts as compression.

    Attributes:
        contact: the contact in its present state.
        initial: sense of slip at the start.
        totals: normal and tangential impulse, normal and tangential work, and sense of slip, for
            each of the four phases of ``impact_phases.PHASES``, shape (4, 5). The phases "after
            slip" collect everything after the first stick or slip.
        row: index of the present phase in ``totals``.
        slip_stop: normal impulse at which the initial slip stops.
        phases: number of consecutive phases that count towards ``MOST_IN_STICK`` and ``SETTLING``.
        returns: number of changes from unloading to loading.
        kept: ``totals`` and the velocity at the first balance of forces or end of loading. The
            impact of a point with one degree of freedom may never end; it is then taken to end at
            this balance or end of loading.
    """

    def __init__(self, contact: Contact) -> None:
        contact.slip = contact.begun_slip()
        self.contact = contact
        self.initial = contact.slip
        self.totals = [[0.0] * 5 for _ in PHASES]
        self.row = 0
        self.slip_stop = 0.0 if self.initial == 0.0 else math.inf
        self.phases = 0
        self.returns = 0
        self.kept: tuple[list[list[float]], float, float] | None = None

    def resolve(self) -> int:
        """Advance the contact to its end, and return the outcome of the impact."""
        contact = self.contact
        settled = False
        while True:
            loading = contact.loading
            slip = contact.slip
            if slip:
                event, sums = slide(contact)
            else:
                many = self.phases >= SETTLING and not settled
                most = self.phases >= MOST_IN_STICK or contact.restitution < LEAST_RESOLVED
                event, sums = stick(
                    contact, jams=many, settles=many and most, balances=self.kept is None
                )
                settled = event is Event.SETTLED
            self.add(sums, slip)
            deepest = loading and event is Event.LINE
            if self.kept is None and (deepest or event is Event.BALANCED):
                totals = [row.copy() for row in self.totals]
                self.kept = totals, contact.normal, contact.tangential
            if event is Event.NEVER:
                return self.end_without_release()
            if event is Event.APART:
                return REBOUND if contact.normal > 0.0 else NO_REBOUND
            if deepest and contact.restitution == 0.0:
                contact.normal = 0.0
                return NO_REBOUND
            # The force of one degree of freedom may fade slowly, with a little slip in each swing.
            fades = not loading and contact.stick == 0.0
            limited = slip == 0.0 or contact.restitution < LEAST_EXACT or fades
            self.phases = self.phases + 1 if limited else 0
            self.apply(event, slip)

    def add(self, sums: Sums, slip: float) -> None:
        """Add the impulses and works of a phase (``sums``) and its sense of slip to the totals."""
        totals = self.totals[self.row]
        for index, each in enumerate(sums):
            totals[index] += each
        if sums[0] > 0.0:
            totals[4] = slip

    def end_without_release(self) -> int:
        """Return the outcome of an impact that would never end.

        The contact is set back to the state ``kept``. The outcome is a jam if the point moves into
        the surface, otherwise stiction.
        """
        contact = self.contact
        pressed = contact.loading or contact.normal < -KNIFE_EDGE * contact.approach
        if self.kept is not None:
            self.totals, contact.normal, contact.tangential = self.kept
        return JAM if pressed else STICTION

    def apply(self, event: Event, slip: float) -> None:
        """Apply an event to the contact, and select the next phase.

        An event can change the stiffness, the coefficient of friction, the tangential force and the
        sense of slip. ``slip`` is the sense of slip before the event.
        """
        contact = self.contact
        again = event is Event.LINE and not contact.loading
        if event is Event.LINE and contact.loading:
            contact.normal = 0.0
            contact.peak = contact.push
        elif not contact.loading:
            contact.push = contact.peak if again else min(contact.push, contact.peak)
        contact.loading ^= event is Event.LINE
        limit = contact.friction * contact.push
        if event is Event.SLIP:
            contact.rub = -contact.slip * limit
        else:
            contact.rub = max(min(contact.rub, limit), -limit)
            stays = event in (Event.STOP, Event.BALANCED)
            contact.slip = 0.0 if stays else contact.begun_slip()
        if again:
            self.load_again()
        elif event is Event.LINE:
            self.row = 2
        elif contact.slip != slip:
            self.row |= 1
        if contact.slip != slip and self.slip_stop == math.inf:
            self.slip_stop = sum(row[0] for row in self.totals)

    def load_again(self) -> None:
        """Return from unloading to loading, and count all phases so far as compression.

        After ``CHATTER`` such changes the slip velocity is halved as well. In the motion that is
        thus skipped, the mean friction force keeps the normal velocity constant.
        """
        first, second, *later = self.totals
        for index in range(4):
            second[index] += sum(row[index] for row in later)
        self.totals = [first, second, [0.0] * 5, [0.0] * 5]
        self.row = 1
        self.returns += 1
        contact = self.contact
        if self.returns < CHATTER or contact.stick == 0.0 or contact.k_nt == 0.0:
            return
        self.returns -= FURTHER
        speed = contact.tangential
        ratio = -contact.k_nn / contact.k_nt
        impulse = 0.5 * speed * contact.k_nt / (contact.stick * contact.k_tt)
        if impulse > 0.0:
            self.add((impulse, ratio * impulse, 0.0, 0.75 * ratio * impulse * speed), second[4])
            contact.tangential = 0.5 * speed


def compliant_impact(values: Arguments, squared: Number) -> Impact:
    """Resolve impacts on a normal spring with energetic restitution and a tangential spring.

    ``values`` holds the arguments by name as arrays of shape (n,), with K_nn > 0 and v_n < 0.
    ``squared`` is the ratio eta^2 > 0 of the normal to the tangential stiffness, shape (n,).
    """
    normal = values["normal"]
    tangential = values["tangential"]
    # Scaling by powers of two keeps squares in the range of floats, and loses no digit.
    mass, speed = (
        np.ldexp(1.0, np.frexp(each)[1])
        for each in (values["k_nn"], np.maximum(-normal, abs(tangential)))
    )
    known = values.get("stick_compliance")
    k_nn, k_nt, k_tt = (values[name] / mass for name in ("k_nn", "k_nt", "k_tt"))
    inverse_mass = inverse_mass_of(k_nn, k_nt, k_tt, None if known is None else known / mass)
    e = values["restitution"]
    columns = (
        k_nn,
        k_nt,
        k_tt,
        inverse_mass.stick,
        np.minimum(values["friction"], WIDEST_CONE),
        np.minimum(values["restitution_friction"], WIDEST_CONE),
        np.where(e < LEAST_RESTITUTION, 0.0, e),
        np.sqrt(squared),
        -normal / speed,
        normal / speed,
        tangential / speed,
    )
    courses = [Course(Contact(*row)) for row in np.transpose(columns).tolist()]
    outcome = np.array([each.resolve() for each in courses])
    momentum = speed / mass
    totals = np.array([each.totals for each in courses]).T
    impulses, along = totals[:2] * momentum
    normal_works, tangential_works = totals[2:4] * (speed * momentum)
    return Impact(
        impulse_normal=impulses.sum(axis=0),
        impulse_tangential=along.sum(axis=0),
        velocity_normal=np.array([each.contact.normal for each in courses]) * speed,
        velocity_tangential=np.array([each.contact.tangential for each in courses]) * speed,
        compressive_impulse_normal=impulses[:2].sum(axis=0),
        compressive_impulse_tangential=along[:2].sum(axis=0),
        slip_stop_impulse=np.array([each.slip_stop for each in courses]) * momentum,
        phase_impulse=impulses.T,
        phase_slip=totals[4].T,
        phase_work_normal=normal_works.T,
        phase_work_tangential=tangential_works.T,
        outcome=outcome,
    )
