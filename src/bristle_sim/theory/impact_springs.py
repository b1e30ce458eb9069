"""A contact that is elastic along its normal and along the surface, and its phases of slip.

In slip the tangential spring's foot slides on the surface. ``impact_compliance`` has the equations,
and ``impact_stick`` the phases of stick.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from enum import Enum, auto

from bristle_sim.theory.numbers import quotient

NOISE = 64.0 * sys.float_info.epsilon
"""Rounding error of a sum, as a fraction of its largest term. A sum of a smaller magnitude counts
as zero."""

Sums = tuple[float, float, float, float]  # impulses p_n and p_t, works W_n and W_t


class Event(Enum):
    """An event that ends a phase of a contact."""

    LINE = auto()  # loading ends, or begins again
    SLIP = auto()  # the force reaches an edge of the friction cone, and the foot begins to slide
    STOP = auto()  # the foot stops
    APART = auto()  # the force ends
    NEVER = auto()  # no event will come
    SETTLED = auto()  # the fast oscillation is removed from the motion
    BALANCED = auto()  # the velocity of the fast oscillation is 0


@dataclass(slots=True)
class Contact:
    """The constants and the present state of a contact on a normal and a tangential spring.

    Units are such that the normal stiffness in loading is 1. The attributes up to ``approach`` are
    constant during an impact.

    Attributes:
        k_nn, k_nt, k_tt: entries of the inverse mass matrix of the contact point.
        stick: change of the normal velocity per unit normal impulse in stick.
        mu_1, mu_2: coefficients of friction in loading and in unloading.
        restitution: energetic coefficient of restitution e*.
        eta: square root of the ratio of the normal to the tangential stiffness.
        approach: normal speed before the impact.
        normal, tangential: velocity of the contact point.
        push, rub: normal and tangential force.
        peak: largest normal force so far.
        loading: whether the normal spring is in loading.
        slip: sense in which the tangential spring's foot slides; 0 in stick.
    """

    k_nn: float
    k_nt: float
    k_tt: float
    stick: float
    mu_1: float
    mu_2: float
    restitution: float
    eta: float
    approach: float
    normal: float
    tangential: float
    push: float = 0.0
    rub: float = 0.0
    peak: float = 0.0
    loading: bool = True
    slip: float = 0.0

    @property
    def steep(self) -> float:
        """Square root of the ratio of the present normal stiffness to the loading stiffness.

        The value is 1 in loading and 1/e* in unloading, with the energetic coefficient of
        restitution e*.
        """
        return 1.0 if self.loading else 1.0 / self.restitution

    @property
    def friction(self) -> float:
        """Coefficient of friction in the present phase."""
        return self.mu_1 if self.loading else self.mu_2

    @property
    def growth(self) -> float:
        """Coefficient mu eta^2 kappa of the normal velocity in the velocity of the sliding foot.

        kappa is 1 in loading and 1/e*^2 in unloading.
        """
        return self.friction * (self.eta * self.steep) ** 2

    def foot(self, slip: float) -> tuple[float, float, float, float]:
        """Return the motion of the contact point and of the tangential spring's foot in slip.

        ``slip`` is the sense in which the foot slides. The last two results are divided by 1 +
        ``growth``, so that they do not overflow for a large friction.

        Returns:
            The change of the contact point's normal velocity per unit normal impulse.
            The change of the contact point's tangential velocity per unit normal impulse.
            The velocity of the foot in the sense of slip.
            The change of the foot's velocity per unit normal impulse.
        """
        along = self.k_nt - self.friction * slip * self.k_tt
        gain = self.stick + (self.k_nt / self.k_tt if self.k_tt else 0.0) * along
        growth = self.growth
        weight = 1.0 / (1.0 + growth)
        foot = weight * (slip * self.tangential + growth * self.normal)
        return gain, along, foot, weight * (slip * along + growth * gain)

    def begun_slip(self) -> float:
        """Return the sense in which the tangential spring's foot begins to slide, or 0 for stick.

        The foot slides if the spring's force is at the friction limit and would exceed this limit.
        Without friction the foot always slides.
        """
        smooth = self.friction == 0.0
        side = -math.copysign(1.0, self.rub)
        if smooth or self.rub == 0.0:
            begins = -1.0 if self.k_nt < 0.0 else 1.0
            side = math.copysign(1.0, self.tangential or begins)
        _, _, foot, gain = self.foot(side)
        growth = self.growth
        terms = (abs(self.tangential) + growth * abs(self.normal)) / (1.0 + growth)
        leaves = gain > 0.0 if abs(foot) <= NOISE * terms else foot > 0.0
        at_edge = abs(self.rub) >= self.friction * self.push * (1.0 - NOISE)
        return side if smooth or (at_edge and leaves) else 0.0


def slide(contact: Contact) -> tuple[Event, Sums]:
    """Advance a contact to the end of a phase of slip.

    Returns:
        The event that ends the phase, and the phase's impulses and works.
    """
    gain, gain_along, foot, foot_gain = contact.foot(contact.slip)
    kappa = contact.steep**2
    speed = contact.normal
    push = contact.push
    stop = math.inf
    if contact.friction > 0.0 and foot_gain < 0.0:
        stop = max(foot, 0.0) / -foot_gain
    apart = math.inf
    if contact.loading:
        line = quotient(-speed, gain)
    else:
        # N = 0 or N is back at its peak: roots of N^2(p) without cancellation.
        line = math.inf
        left = (contact.peak - push) * (contact.peak + push) / kappa
        stored = push * push / kappa
        inside = speed * speed - gain * left
        if inside >= 0.0 and speed < 0.0:
            line = left / (math.sqrt(inside) - speed)
        elif inside >= 0.0 and gain < 0.0:
            line = (speed + math.sqrt(inside)) / -gain
        beyond = speed * speed + gain * stored
        if beyond >= 0.0 and speed < 0.0:
            apart = quotient(math.sqrt(beyond) - speed, gain)
        elif beyond >= 0.0:
            apart = quotient(stored, speed + math.sqrt(beyond))
    impulse = min(stop, line, apart)
    if impulse == math.inf:
        return Event.NEVER, (0.0, 0.0, 0.0, 0.0)
    event = Event.STOP
    if impulse == apart:
        event = Event.APART
    elif impulse == line:
        event = Event.LINE
    normal = speed + gain * impulse
    if event is Event.LINE and contact.loading:
        normal = 0.0
    square = push * push - kappa * impulse * (speed + normal)
    ratio = -contact.friction * contact.slip
    before = contact.tangential
    contact.normal = normal
    contact.tangential = before + gain_along * impulse
    contact.push = 0.0 if event is Event.APART else math.sqrt(max(square, 0.0))
    contact.rub = ratio * contact.push
    work_along = 0.5 * ratio * impulse * (before + contact.tangential)
    return event, (impulse, ratio * impulse, 0.5 * impulse * (speed + normal), work_along)
