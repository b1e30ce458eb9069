"""Stick on two springs: the motion of two oscillators, and its first event.

In units in which the normal spring's loading stiffness is 1, a point in stick obeys

    N' = -kappa v_n,    T' = -v_t/eta^2,    (v_n, v_t)' = K (N, T),

with the velocity v, the normal and tangential force N and T, the inverse mass matrix K, and kappa =
1 in loading, 1/e*^2 in unloading. With D = diag(kappa, 1/eta^2), w = D^(1/2) v and G = D^(-1/2) (N,
T) this is w' = S G, G' = -w, with the symmetric S = D^(1/2) K D^(1/2). In the axes of the
eigenvectors of S the motion is that of two oscillators, the fast and the slow mode, with squared
angular frequencies lambda_1 >= lambda_2 >= 0. Their product is det S = kappa/eta^2 K_tt (K_nn -
K_nt^2/K_tt). The last factor, the compliance in stick, may be given to more digits than K holds.

Stick ends where the force reaches an edge of the friction cone, mu N -+ T = 0. Loading ends where
v_n = 0, and unloading ends where N returns to its largest value. Each of these event functions f is
a constant plus a harmonic term of each mode. The amplitudes give a bound M of |f''|. After a time
step h the value of f is at least f + f' h - M h^2/2. A step to the root of this parabola therefore
passes no root of f. Such steps converge quadratically to the first root of f, and step over a near
miss. If the frequencies of the modes differ much, a longer step follows from the parabola of the
slow mode, lowered by the amplitude of the fast mode.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import attrgetter

from bristle_sim.theory.impact_phases import KNIFE_EDGE
from bristle_sim.theory.impact_springs import NOISE, Contact, Event, Sums

STEEPEST_CONE = 1e150
"""Largest tangent of the friction cone's angle, in the units of the modes. A wider cone counts as a
half-plane."""

# Squared natural angular frequency that is used in place of zero, to avoid a division by zero.
LEAST_SQUARE = 1e-300

LEAST_STEP = 1e-6
"""Time step that leaves an instant at which an event function and its slope are zero, multiplied by
the natural angular frequency of the fast mode.

In this step the event function changes by a fraction 1e-18 of its amplitude."""

# Second derivative, as a fraction of its bound, below which a step of ``LEAST_STEP`` cannot take
# the event function past zero.
STRAIGHT = 1e-8

# Fraction of its amplitude that the fast oscillation is assumed to reach. An event function that
# would reach zero only with the full amplitude counts as a near miss.
GRAZE = 1.0 - 1e-13

# Third derivative, as a fraction of its bound, below which a function counts as zero throughout if
# its lower derivatives are rounding error.
FLAT = 1e-10

WIDE = 1e3  # rounding error of an event function that stays zero, over rounding error of its terms


class Oscillator:
    """One of a contact's two modes in stick: x(t) = start cos(omega t) + slope sin(omega t)/omega.

    Attributes:
        square: squared natural angular frequency omega^2.
        rate: natural angular frequency, replaced by a tiny value where it is zero.
        start, slope: initial value and initial time derivative of x.
        swing: bound of the time derivative of x.
        bend: bound of the second time derivative of x.
    """

    __slots__ = ("bend", "rate", "slope", "square", "start", "swing")

    def __init__(self, square: float, start: float, slope: float) -> None:
        self.square = square
        self.rate = math.sqrt(max(square, LEAST_SQUARE))
        self.start = start
        self.slope = slope
        self.swing = math.hypot(self.rate * start, slope)
        self.bend = square / self.rate * self.swing

    def at(self, time: float) -> tuple[float, float, float, float]:
        """Return x and x' at a time, and the sums of the magnitudes of the terms of x and of x'."""
        cosine = math.cos(self.rate * time)
        sine = math.sin(self.rate * time) / self.rate
        one = self.start * cosine
        other = self.slope * sine
        falling = self.slope * cosine
        bending = -self.square * self.start * sine
        sizes = abs(one) + abs(other), abs(falling) + abs(bending)
        return one + other, falling + bending, *sizes

    def integral(self, time: float) -> float:
        """Return the integral of x over the time from 0."""
        half = math.sin(0.5 * self.rate * time) / self.rate
        sine = math.sin(self.rate * time) / self.rate
        return self.start * sine + 2.0 * self.slope * half * half

    def derivative(self) -> Oscillator:
        """Return the oscillator whose displacement is the time derivative of this one's."""
        return Oscillator(self.square, self.slope, -self.square * self.start)


@dataclass(slots=True)
class EventFunction:
    """A weighted sum of the two modes plus a constant. The event is the sum's first fall to zero.

    Attributes:
        modes: the fast and the slow mode.
        weights: two real weights as one complex number: that of the fast mode is the real part,
            that of the slow mode the imaginary part.
        sizes: magnitude from which the rounding error of either weight follows. A weight is a sum
            of terms; the magnitude is the sum of the terms' magnitudes.
        constant: constant part of the function.
        noise: least rounding error of the function.
        still: whether the slow mode is at rest except for rounding error.
        slip: sense in which the foot slips after an event that begins its slip; 0 for an event that
            ends loading or unloading.
        time: time up to which the function has not fallen to zero; infinite if it never will.
    """

    modes: tuple[Oscillator, Oscillator]
    weights: complex
    sizes: tuple[float, float]
    still: bool
    constant: float = 0.0
    noise: float = 0.0
    slip: float = 0.0
    time: float = 0.0

    def advance(self) -> bool:
        """Advance ``time`` by a step in which the event cannot occur.

        Returns:
            Whether ``time`` is the instant of the event, so that no step is possible.
        """
        fast, slow = self.modes
        part = self.weights.real
        other_part = self.weights.imag
        size, other_size = self.sizes
        quick, quick_slope, quick_size, quick_slope_size = fast.at(self.time)
        calm, calm_slope, calm_size, calm_slope_size = slow.at(self.time)
        calm = other_part * calm + self.constant
        calm_slope = other_part * calm_slope
        value = part * quick + calm
        slope = part * quick_slope + calm_slope
        noise = NOISE * (size * quick_size + other_size * calm_size) + self.noise
        slope_noise = NOISE * (size * quick_slope_size + other_size * calm_slope_size)
        bend = -fast.square * part * quick - slow.square * (calm - self.constant)
        swing = abs(part) * fast.bend
        most = swing + abs(other_part) * slow.bend
        rate = fast.rate
        if self.slip and value <= WIDE * noise and abs(slope) <= WIDE * slope_noise:
            third = -fast.square * part * quick_slope - slow.square * calm_slope
            # On the border of stick, with modes of equal rates, the force keeps to the edge.
            if abs(bend) <= WIDE * rate * slope_noise and abs(third) <= FLAT * rate * most:
                self.time = math.inf
                return False
        if abs(slope) <= slope_noise:
            slope = 0.0
        step = parabola_root(max(value, 0.0), slope, most)
        if value <= noise:
            dip = 2.0 * noise * bend
            if slope * slope > dip if slope < 0.0 else slope * slope < -dip:
                return True
            if bend >= -STRAIGHT * most:
                step = max(step, LEAST_STEP / rate, bend / (rate * most) if most else 0.0)
        clear = calm - GRAZE * swing / fast.square
        if clear > 0.0:
            drift = 0.0 if self.still else calm_slope
            step = max(step, parabola_root(clear, drift, abs(other_part) * slow.bend))
        before = self.time
        self.time += step
        return self.time == before


def parabola_root(value: float, slope: float, most: float) -> float:
    """Return the first positive root h of value + slope h - most h^2/2.

    The result is infinite if there is no such root. ``value`` and ``most`` must be >= 0. The
    formula avoids cancellation.
    """
    root = math.sqrt(slope * slope + 2.0 * most * value)
    if slope < 0.0:
        return 2.0 * value / (root - slope)
    return (slope + root) / most if most else math.inf


def modes_of(contact: Contact) -> tuple[float, float, complex]:
    """Return the squared natural angular frequencies of the two modes, and the axis of the fast one.

    The axis is a unit vector with a real part along the normal and an imaginary part along the
    surface. In the axes of the two modes the scaled inverse mass matrix is diagonal.
    """
    steep = contact.steep
    eta = contact.eta
    along = steep * steep * contact.k_nn
    across = contact.k_tt / (eta * eta)
    coupling = steep / eta * contact.k_nt
    half = 0.5 * (along - across)
    radius = math.hypot(half, coupling)
    first = max(0.5 * (along + across) + radius, LEAST_SQUARE)
    second = steep * steep * across * contact.stick / first
    # The larger component of the eigenvector has no cancellation; for equal rates any vector
    # serves.
    axis = complex(abs(half) + radius or 1.0, coupling)
    axis /= abs(axis)
    return first, second, axis if half >= 0.0 else complex(axis.imag, axis.real)


def stick(contact: Contact, *, jams: bool, settles: bool, balances: bool) -> tuple[Event, Sums]:
    """Advance a contact to the end of a phase of stick.

    Args:
        contact: the contact, whose state the function changes.
        jams: if True, a point with one degree of freedom that would move into the surface without
            end is not advanced in time. The event is then ``NEVER``.
        settles: if True, the contact is not advanced in time, but its fast mode loses its energy.
            The event is then ``SETTLED``, or ``NEVER`` for a point that would move into the surface
            without end.
        balances: if True, a phase in loading of a point with one degree of freedom ends at the
            latest when the velocity of the fast mode is zero. The event is then ``BALANCED``.

    Returns:
        The event that ends the phase, and the phase's impulses and works.
    """
    first, second, axis = modes_of(contact)
    steep = contact.steep
    eta = contact.eta
    normal, tangential = contact.normal, contact.tangential
    push, rub = contact.push, contact.rub
    # Vectors have the fast mode as real and the slow mode as imaginary part.
    speeds = axis.conjugate() * complex(steep * normal, tangential / eta)
    forces = axis.conjugate() * complex(push / steep, rub * eta)
    fast = Oscillator(first, forces.real, -speeds.real)
    slow = Oscillator(second, forces.imag, -speeds.imag)
    # A point with one degree of freedom has a slow mode of constant velocity. A velocity of the size
    # of rounding error counts as zero.
    still = second == 0.0 and abs(speeds.imag) <= KNIFE_EDGE * contact.approach
    pressed = contact.stick == 0.0 and not still and axis.imag * speeds.imag > 0.0
    if settles or (jams and pressed):
        time = 0.0
        event = Event.NEVER if pressed else Event.SETTLED
    else:
        balance = math.inf
        if balances and contact.stick == 0.0 and contact.loading:
            balance = math.atan2(speeds.real, -fast.rate * forces.real) % math.pi / fast.rate
        time, event = _first_event(contact, (fast, slow), axis, still, balance)
    stops = event in (Event.NEVER, Event.SETTLED)
    if stops:  # stopping the fast mode takes an impulse
        impulses = axis * (-speeds.real / first)
        speeds = complex(0.0, speeds.imag)
        forces = complex(0.0 if event is Event.SETTLED else forces.real, forces.imag)
    else:
        (one, rise, *_), (other, growth, *_) = fast.at(time), slow.at(time)
        impulses = axis * complex(fast.integral(time), slow.integral(time))
        speeds = complex(-rise, -growth)
        forces = complex(one, other)
    impulse = impulses.real * steep
    along = impulses.imag / eta
    if stops or time > 0.0:  # no rounding where nothing happens
        speeds *= axis
        forces *= axis
        contact.normal = speeds.real / steep
        contact.tangential = speeds.imag * eta
        contact.push = forces.real * steep
        contact.rub = forces.imag / eta
    if stops:
        work = 0.5 * impulse * (normal + contact.normal)
        work_along = 0.5 * along * (tangential + contact.tangential)
    else:
        work = 0.5 * (push - contact.push) * (push + contact.push) / steep**2
        work_along = 0.5 * (rub - contact.rub) * (rub + contact.rub) * eta * eta
        ends = contact.push <= NOISE * contact.peak and contact.normal > 0.0
        if ends and not contact.loading:
            event = Event.APART
    return event, (impulse, along, work, work_along)


def _first_event(
    contact: Contact,
    modes: tuple[Oscillator, Oscillator],
    axis: complex,
    still: bool,
    balance: float,
) -> tuple[float, Event]:
    """Return the time of the first event in stick, and the event.

    If the force reaches the friction limit, the sense of slip is set in the contact.

    Args:
        contact: the contact at the start of the phase.
        modes: the fast and the slow mode.
        axis: axis of the fast mode, from ``modes_of``.
        still: whether the slow mode moves by rounding error only.
        balance: time at which the phase ends at the latest, or infinite.
    """
    if balance == 0.0:
        return 0.0, Event.BALANCED
    axis = axis.conjugate()
    sizes = abs(axis.real), abs(axis.imag)
    if contact.loading:
        rates = modes[0].derivative(), modes[1].derivative()
        noise = NOISE * (sizes[0] * modes[0].swing + sizes[1] * modes[1].swing)
        functions = [EventFunction(rates, axis, sizes, still, noise=noise)]
    else:
        functions = [EventFunction(modes, -axis, sizes, still, contact.peak / contact.steep)]
    # The edges T = mu N and T = -mu N, over sqrt(1 + mu^2) in the modes' units.
    angle = min(contact.friction * contact.steep * contact.eta, STEEPEST_CONE)
    aside = 1.0 / math.sqrt(1.0 + angle * angle)
    up = angle * aside
    sizes = up * sizes[0] + aside * sizes[1], up * sizes[1] + aside * sizes[0]
    for side in (-1.0, 1.0):
        weights = axis * complex(up, side * aside)
        functions.append(EventFunction(modes, weights, sizes, still, slip=side))
    while True:
        first = min(functions, key=attrgetter("time"))
        if first.time >= balance:
            return balance, Event.NEVER if balance == math.inf else Event.BALANCED
        if first.advance():
            contact.slip = first.slip
            return first.time, Event.SLIP if first.slip else Event.LINE
