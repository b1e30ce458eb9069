"""The phases of a contact that is elastic along its normal and along the surface: stick, and slip of
the tangential spring's foot.

Slip in closed form follows from the equations of ``impact_compliance``. In units in which the normal spring's loading stiffness is 1, a point in stick obeys

    N' = -kappa v_n,    T' = -v_t/eta^2,    (v_n, v_t)' = K (N, T),

with the velocity v, the normal and tangential force N and T, the inverse mass matrix K, and kappa =
1 in loading, 1/e*^2 in unloading. With D = diag(kappa, 1/eta^2), w = D^(1/2) v and G = D^(-1/2) (N,
T) this is w' = S G, G' = -w, with the symmetric S = D^(1/2) K D^(1/2). In the axes of the
eigenvectors of S the motion is that of two oscillators with squared rates lambda_1 >= lambda_2 >=
0. Their product is det S = kappa/eta^2 K_tt (K_nn - K_nt^2/K_tt). The last factor, the compliance
in stick, may be given to more digits than K holds. ``impact_events`` finds the end of stick.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Number
from bristle_sim.theory.impact_events import (
    APART,
    BALANCED,
    LEAST_RATE,
    LINE,
    NEVER,
    NOISE,
    SETTLED,
    STOP,
    Modes,
    both,
    harmonics,
    oscillators,
    step_to_event,
)
from bristle_sim.theory.impact_phases import INFINITE, KNIFE_EDGE
from bristle_sim.theory.numbers import quotient

STEEPEST_CONE = 1e150
"""Largest tangent of the friction cone's angle, in the units of the modes. A wider cone counts as a
half-plane."""


class Contact(NamedTuple):
    """The constants and the present state of contacts on a normal and a tangential spring.

    Units are such that the normal stiffness in loading is 1. The attributes up to ``approach`` are
    constant during an impact.

    Attributes:
        k_nn, k_nt, k_tt: entries of the inverse mass matrix of the contact point.
        stick: change of the normal velocity per unit normal impulse in stick.
        tie: ratio k_nt/k_tt.
        mu_1, mu_2: coefficients of friction in loading and in unloading.
        restitution: energetic coefficient of restitution e*.
        eta: square root of the ratio of the normal to the tangential stiffness.
        approach: normal speed before the impact.
        normal, tangential: velocity of the contact point.
        push, rub: normal and tangential force.
        peak: largest normal force so far.
        loading: 1 in loading, 0 in unloading.
        steep: square root of the normal stiffness: 1 in loading, 1/e* in unloading.
        friction: coefficient of friction in the present phase.
        slip: sense in which the tangential spring's foot slides; 0 in stick.
    """

    k_nn: Number
    k_nt: Number
    k_tt: Number
    stick: Number
    tie: Number
    mu_1: Number
    mu_2: Number
    restitution: Number
    eta: Number
    approach: Number
    normal: Number
    tangential: Number
    push: Number
    rub: Number
    peak: Number
    loading: Number
    steep: Number
    friction: Number
    slip: Number


def stick(
    contact: Contact, jams: Number, settles: Number, balances: Number
) -> tuple[Contact, Number, tuple[Number, ...]]:
    """Advance contacts to the end of a phase of stick.

    In stick a contact is a pair of oscillators, the fast and the slow mode. A few contacts may be
    left without an event.

    Args:
        contact: contacts before the phase.
        jams: whether a point with one degree of freedom does not advance if it is driven into the
            surface without end. Its event is ``NEVER``.
        settles: whether the contact loses the energy of its fast mode instead of advancing. Its
            event is ``SETTLED``.
        balances: whether the phase of a point with one degree of freedom ends, at the latest, when
            the velocity of its fast mode is zero. Its event is ``BALANCED``.

    Returns:
        The contacts after the phase; the events that end it; and the normal impulse, tangential
        impulse, normal work and tangential work of the phase.
    """
    steep = contact.steep
    eta = contact.eta
    modes, (cosine, sine) = _modes(contact)
    # A single degree of freedom drifts across its line at a constant speed in stick.
    pressed = (contact.stick == 0.0) & (modes.drifts * sine * modes.speeds[1] > 0.0)
    time, event = step_to_event(modes, settles | (jams & pressed))
    rate = modes.rates[0]
    balance = np.arctan2(modes.speeds[0], -rate * modes.forces[0]) % np.pi / rate
    single = (contact.stick == 0.0) & (contact.loading > 0.0)
    balances = balances & single & ((balance <= time) | (event == NEVER))
    time = np.where(balances, balance, time)
    event = np.where(balances, BALANCED, event)
    swing, turn, tangent = harmonics(modes, time)
    (w_1, w_2), (g_1, g_2) = oscillators(modes, swing, turn)
    sum_1, sum_2 = turn * (modes.forces - modes.speeds * tangent)  # time integrals of G
    event = np.where((event == SETTLED) & pressed, NEVER, event)
    still = (event == NEVER) | (event == SETTLED)
    moved = still | (time > 0.0)  # no rounding where nothing happens

    def seen(w_1: Number, g_1: Number) -> Contact:
        """Return the contacts if their fast mode has the velocity w_1 and the force g_1."""
        ends = (
            np.where(moved, (cosine * w_1 - sine * w_2) / steep, contact.normal),
            np.where(moved, (sine * w_1 + cosine * w_2) * eta, contact.tangential),
            np.where(moved, steep * (cosine * g_1 - sine * g_2), contact.push),
            np.where(moved, (sine * g_1 + cosine * g_2) / eta, contact.rub),
        )
        return Contact(*contact[:10], *ends, *contact[14:])

    after = seen(w_1, g_1)
    done = (
        steep * (cosine * sum_1 - sine * sum_2),
        (sine * sum_1 + cosine * sum_2) / eta,
        0.5 * (contact.push - after.push) * (contact.push + after.push) / (steep * steep),
        0.5 * (contact.rub - after.rub) * (contact.rub + after.rub) * eta * eta,
    )
    if still.any():  # stopping the fast mode takes an impulse
        last = np.where(still, -w_1 / modes.squares[0], 0.0)
        before = after
        after = seen(np.where(still, 0.0, w_1), np.where(event == SETTLED, 0.0, g_1))
        impulse = steep * cosine * last, sine * last / eta
        works = (
            0.5 * impulse[0] * (before.normal + after.normal),
            0.5 * impulse[1] * (before.tangential + after.tangential),
        )
        done = tuple(part + more for part, more in zip(done, (*impulse, *works), strict=True))
    return after, event, done


def _modes(contact: Contact) -> tuple[Modes, tuple[Number, Number]]:
    """Return the two modes of contacts in stick.

    Returns:
        The constants of the modes; and the cosine and the sine of the rotation from (normal,
        tangential) to the modes' axes, in which the scaled inverse mass matrix is diagonal.
    """
    steep = contact.steep
    eta = contact.eta
    along = steep * steep * contact.k_nn
    across = contact.k_tt / (eta * eta)
    coupling = steep / eta * contact.k_nt
    half = 0.5 * (along - across)
    radius = np.sqrt(half * half + coupling * coupling)
    first = np.maximum(0.5 * (along + across) + radius, LEAST_RATE)
    squares = np.array([first, steep * steep * across * contact.stick / first])
    rates = np.sqrt(np.maximum(squares, LEAST_RATE))

    # The larger component of the eigenvector has no cancellation; for equal rates any vector
    # serves.
    large = abs(half) + radius
    scale = 1.0 / np.sqrt(large * large + coupling * coupling)
    one, other = (
        np.where(large > 0.0, large * scale, 1.0),
        np.where(large > 0.0, coupling * scale, 0.0),
    )
    upright = half >= 0.0
    cosine, sine = np.where(upright, one, other), np.where(upright, other, one)

    def turned(along: Number, across: Number) -> Number:
        return np.array([cosine * along + sine * across, cosine * across - sine * along])

    speeds = turned(steep * contact.normal, contact.tangential / eta)
    forces = turned(contact.push / steep, contact.rub * eta)

    # Coefficients of the cone's edges T = mu N and T = -mu N, over sqrt(1 + mu^2) in the modes'
    # units, and of the line; the line is one of w in loading, and one of G in unloading.
    angle = np.minimum(contact.friction * steep * eta, STEEPEST_CONE)
    aside = 1.0 / np.sqrt(1.0 + angle * angle)
    up = angle * aside
    parts = np.array(
        [
            [up * cosine - aside * sine, up * cosine + aside * sine, -cosine],
            [-up * sine - aside * cosine, aside * cosine - up * sine, sine],
        ]
    )
    loading = contact.loading > 0.0
    cosines = parts * forces[:, np.newaxis]
    sines = parts * -speeds[:, np.newaxis]
    cosines[:, 2] = parts[:, 2] * np.where(loading, speeds, forces)
    sines[:, 2] = parts[:, 2] * np.where(loading, squares * forces, -speeds)
    bends = (squares / rates)[:, np.newaxis] * np.hypot(rates[:, np.newaxis] * cosines, sines)
    sizes = abs(np.array([cosine, sine]))
    swings = np.sqrt(speeds * speeds + squares * forces * forces)
    peak = contact.peak / steep
    # One degree of freedom drifts across its line; a drift of the size of rounding is none.
    drifts = (squares[1] > 0.0) | (abs(speeds[1]) > KNIFE_EDGE * contact.approach)
    return Modes(
        speeds,
        forces,
        squares,
        rates,
        cosines,
        sines,
        bends,
        terms=up * sizes + aside * sizes[::-1],
        constant=np.where(loading, 0.0, peak),
        line_noise=NOISE * np.where(loading, both(sizes * swings), peak),
        loading=loading,
        drifts=drifts.astype(float),
    ), (cosine, sine)


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

    ``slip`` is the sense in which the foot slides. The last two results are divided by 1 + mu eta^2
    kappa, so that they do not overflow for a large friction mu. eta^2 is the ratio of the normal to
    the tangential stiffness; kappa is 1 in loading and 1/e*^2 in unloading.

    Returns:
        The changes of the normal and of the tangential velocity of the contact point per unit
        normal impulse; the velocity of the foot in the sense of slip; and the change of this
        velocity per unit normal impulse.
    """
    along = contact.k_nt - contact.friction * slip * contact.k_tt
    gain = contact.stick + contact.tie * along
    growth = contact.friction * (contact.eta * contact.steep) ** 2
    weight = 1.0 / (1.0 + growth)
    foot = weight * (slip * contact.tangential + growth * contact.normal)
    return gain, along, foot, weight * (slip * along + growth * gain)


def begun_slip(contact: Contact) -> Number:
    """Return the sense in which the tangential spring's foot begins to slide, or 0 for stick.

    The foot slides if the spring's force is at an edge of the friction cone and would leave the
    cone. Without friction the foot always slides.
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
