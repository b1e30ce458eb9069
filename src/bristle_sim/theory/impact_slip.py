"""Slip on two springs: a phase in closed form, and the sense in which the tangential spring's foot
begins to slide.

The equations are those of ``impact_compliance``, in units in which the loading stiffness of the
normal spring is 1.
"""

from __future__ import annotations

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_events import APART, LINE, NEVER, NOISE, STOP
from bristle_sim.theory.impact_phases import INFINITE
from bristle_sim.theory.impact_stick import Contact
from bristle_sim.theory.numbers import quotient


def slide(contact: Contact) -> tuple[Contact, Number, tuple[Number, ...]]:
    """Advance contacts to the end of a phase of slip.

    Returns:
        The contacts after the phase; the events that end it; and the normal impulse, tangential
        impulse, normal work and tangential work of the phase.
    """
    loading = contact.loading > 0.0
    mu = contact.friction
    kappa = contact.steep * contact.steep
    gain, gain_along, foot, foot_gain = foot_of(contact, contact.slip)
    stop = np.where((mu > 0.0) & (foot_gain < 0.0), np.maximum(foot, 0.0) / -foot_gain, INFINITE)
    speed = contact.normal
    push = contact.push

    # Unloading ends where N = 0 or where N is back at its peak: roots of N^2(p) without
    # cancellation.
    left = (contact.peak - push) * (contact.peak + push) / kappa
    stored = push * push / kappa
    inside = speed * speed - gain * left
    beyond = speed * speed + gain * stored
    root = np.sqrt(np.maximum(inside, 0.0))
    again = np.where(speed < 0.0, left / (root - speed), (speed + root) / -gain)
    again = np.where((inside >= 0.0) & ((speed < 0.0) | (gain < 0.0)), again, INFINITE)
    root = np.sqrt(np.maximum(beyond, 0.0))
    apart: Number = np.where(
        speed < 0.0, quotient(root - speed, gain), quotient(stored, speed + root)
    )
    apart = np.where(loading | (beyond < 0.0), INFINITE, apart)
    line = np.where(loading, quotient(-speed, gain), again)

    impulse = np.minimum(np.minimum(stop, line), apart)
    event = np.where(impulse == apart, APART, np.where(impulse == line, LINE, STOP))
    event = np.where(impulse == INFINITE, NEVER, event)
    impulse = np.where(impulse == INFINITE, 0.0, impulse)
    tangential = contact.tangential + gain_along * impulse
    normal = np.where(loading & (event == LINE), 0.0, speed + gain * impulse)
    square = push * push - kappa * impulse * (speed + normal)
    push = np.where(event == APART, 0.0, np.sqrt(np.maximum(square, 0.0)))
    ratio = -mu * contact.slip
    works = (
        0.5 * impulse * (speed + normal),
        0.5 * ratio * impulse * (contact.tangential + tangential),
    )
    after = contact._replace(normal=normal, tangential=tangential, push=push, rub=ratio * push)
    return after, event, (impulse, ratio * impulse, *works)


def foot_of(contact: Contact, slip: Number) -> tuple[Number, Number, Number, Number]:
    """Return the motion of the contact point and of the tangential spring's foot in slip.

    Returns:
        The changes of the normal and of the tangential velocity of the point per unit normal
        impulse; the velocity of the foot in the sense of slip; and its change per unit normal
        impulse. The last two are divided by 1 + mu eta^2 kappa, so that they do not overflow for
        any friction mu. eta^2 is the ratio of the normal to the tangential stiffness; kappa is 1 in
        loading and 1/e*^2 in unloading.
    """
    along = contact.k_nt - contact.friction * slip * contact.k_tt
    gain = contact.stick + contact.tie * along
    growth = contact.friction * (contact.eta * contact.steep) ** 2
    weight = 1.0 / (1.0 + growth)
    foot = weight * (slip * contact.tangential + growth * contact.normal)
    return gain, along, foot, weight * (slip * along + growth * gain)


def begun_slip(contact: Contact) -> Number:
    """Return the sense in which the tangential spring's foot begins to slip, or 0 for stick.

    The foot slips if the force is at an edge of the friction cone and would leave the cone. Without
    friction the foot always slips.
    """
    smooth = contact.friction == 0.0
    free = np.where(
        contact.tangential == 0.0,
        np.where(contact.k_nt < 0.0, -1.0, 1.0),
        np.sign(contact.tangential),
    )
    side = np.where(smooth | (contact.rub == 0.0), free, -np.sign(contact.rub))
    _, _, foot, gain = foot_of(contact, side)
    growth = contact.friction * (contact.eta * contact.steep) ** 2
    still = abs(foot) <= NOISE * (abs(contact.tangential) + growth * abs(contact.normal)) / (
        1.0 + growth
    )
    leaves = np.where(still, gain > 0.0, foot > 0.0)
    slips = (abs(contact.rub) >= contact.friction * contact.push * (1.0 - NOISE)) & leaves
    return np.where(smooth | slips, side, 0.0)
