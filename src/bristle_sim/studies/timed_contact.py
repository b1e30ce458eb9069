"""Force and motion of a bristle during a contact with a requested compression time and a requested
impulse or speed.

During a contact of about 50 us, the hub turns by 0.75 deg and the bristle by more, so the impulse
and the duration differ from the rigid-body limit by a few per cent. Speed and stiffness are
therefore adjusted until the simulated contact has the requested values.
"""

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PPoly

from bristle_sim.arrays import Array
from bristle_sim.parameters import Bristle, Contact, Hub, Surface
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_laws import Impacts
from bristle_sim.studies.impacts import radial_chain
from bristle_sim.studies.whole_pass import record_fields
from bristle_sim.theory.monofilament import normal_compressive_impulse
from bristle_sim.trajectory import ContactHistory
from bristle_sim.trajectory.interpolation import cubics, integral, smooth_pieces

Result = TypeVar("Result")

# Relative difference from the requested values at which the adjustment ends. If the requested
# accuracy is larger, the adjustment ends at the accuracy.
REQUEST_TOLERANCE = 1e-6
MOST_ROUNDS = 30  # largest number of iterations of the adjustment, which usually takes five to ten
LARGEST_STEP = 0.5  # largest change of the logarithm of speed or duration in an iteration
PRINTED_COMPRESSION = 5e-5  # compression time of a bristle's strike, s (Zhang 2020, sec. 3.3)


def compression_end(history: ContactHistory) -> float:
    """Return the time (s) from the first touch to the sample with the deepest penetration."""
    return float(history.time[int(np.argmax(history.penetration))] - history.time[0])


@dataclass(frozen=True)
class TimedContact:
    """A radial bristle's contact, resolved in time.

    Its time series have one entry for each sample.

    Attributes:
        chain: the bristle before the contact.
        strike: the contact, and the cost of its simulation.
    """

    chain: Chain
    strike: ChainStrike

    @property
    def history(self) -> ContactHistory:
        """Recorded time history of the contact."""
        assert self.strike.contact.history is not None
        return self.strike.contact.history

    @cached_property
    def time(self) -> Array:
        """Time since the first touch, s."""
        return np.asarray(self.history.time - self.history.time[0])

    @property
    def compression_time(self) -> float:
        """Time from the first touch to the deepest penetration, s."""
        return compression_end(self.history)

    @property
    def tip_speed(self) -> float:
        """Speed v_C of the tip before the contact (Zhang 2020, eq. 2.24), m/s."""
        return math.hypot(*self.strike.contact.velocity_before)

    @cached_property
    def force(self) -> Array:
        """Magnitude of the resultant force at each sample, N."""
        return np.asarray(np.hypot(self.history.normal_force, self.history.tangential_force))

    @cached_property
    def resultant(self) -> PPoly:
        """Magnitude of the resultant force (N), piecewise cubic in the time since the touch (s).

        The slope of the force at a sample is a stiffness times the speed of penetration. The
        stiffness is constant in each smooth part of the time history.
        """
        depth = self.history.penetration
        slopes = np.zeros_like(self.time)
        for first, last in smooth_pieces(self.time):
            deeper = depth[last] - depth[first]
            stiffness = (self.force[last] - self.force[first]) / deeper if deeper else 0.0
            section = slice(first, last + 1)
            slopes[section] = -stiffness * self.history.normal_velocity[section]
        return cubics(self.time, self.force, slopes)

    @property
    def peak_force(self) -> float:
        """Largest magnitude of the resultant force, N.

        It occurs at the instant of deepest penetration, which is one of the samples.
        """
        return float(self.force.max())

    @property
    def compressive_impulse(self) -> float:
        """Compressive impulse p_c, N s.

        It is the integral of the resultant force over the compression time (Zhang 2020, eq. 3.1).
        """
        return float(self.resultant.integrate(0.0, self.compression_time))

    @property
    def path(self) -> Array:
        """Length of the tip's path since the first touch at each sample, m."""
        return integral(self.time, np.abs(self._tip_velocity))

    @property
    def rate(self) -> Array:
        """Absolute angular velocity of the bristle at each sample, rad/s."""
        swing = self._tip_velocity - self._root_velocity
        forward = (swing * np.exp(-1j * self.chain.angles[0])).real
        return np.asarray(np.copysign(abs(swing), forward) / self.chain.lengths[0])

    @property
    def centre_speed(self) -> Array:
        """Speed v_G of the bristle's centre at each sample, m/s."""
        return np.asarray(0.5 * abs(self._root_velocity + self._tip_velocity))

    @property
    def _tip_velocity(self) -> NDArray[np.complex128]:
        """Velocity of the tip at each sample, m/s.

        The real part is along the workpart, the imaginary part normal to it.
        """
        return self.history.tangential_velocity + 1j * self.history.normal_velocity

    @property
    def _root_velocity(self) -> NDArray[np.complex128]:
        """Velocity of the bristle's root on the hub at each sample, m/s.

        The real part is along the workpart, the imaginary part normal to it.
        """
        chain = self.chain
        angle = chain.hub_angle + chain.hub_speed * self.time
        return np.asarray(chain.hub_radius * chain.hub_speed * np.exp(1j * angle))


def timed_contact(
    hub: Hub,
    bristle: Bristle,
    surface: Surface,
    impact_angle: float,
    settings: Settings,
    *,
    compression_time: float,
    rate: float | None = None,
    impulse: float | None = None,
) -> TimedContact:
    """Simulate a strike with a requested compression time, and a requested angular velocity or
    impulse.

    Args:
        hub, bristle, surface, settings: parameters of the strike.
        impact_angle: angle gamma between the radial bristle and the workpart's normal, rad.
        compression_time: time from the first touch to the deepest penetration, s.
        rate: angular velocity of the bristle before the strike, rad/s; give either ``rate`` or
            ``impulse``.
        impulse: impulse of the resultant force in compression, N s.

    Raises:
        ValueError: if no contact has the requested values.
    """
    requested = [compression_time]
    speed = bristle.length * (rate or 0.0) + hub.radius * hub.speed
    if impulse is not None:
        requested = [compression_time, impulse]
        # A first guess by the impulse p_c of the rigid-body impact (Zhang 2020, eqs. 2.37, 2.56 and
        # 3.8).
        own = normal_compressive_impulse(bristle.mass, 1.0, impact_angle, surface.friction)
        speed = impulse / (math.hypot(1.0, surface.friction) * float(own))

    def struck(duration: float, speed: float) -> tuple[TimedContact, tuple[float, float]]:
        """Simulate a contact of given duration (s) and tip speed (m/s).

        Returns:
            The contact.
            Its compression time (s) and compressive impulse (N s).
        """
        if (
            not duration * max(speed, hub.speed * hub.radius, hub.speed * bristle.length)
            <= bristle.length
        ):
            raise ValueError(
                f"compression_time: must be shorter; in {duration:g} s of contact tip or hub move by more than"
                " the bristle's length"
            )
        chain = radial_chain(
            hub, bristle, impact_angle, (speed - hub.radius * hub.speed) / bristle.length
        )
        found = strike(chain, surface, Contact("compliant", duration), settings)
        contact = TimedContact(chain, found)
        if found.contact.history is None or not contact.compressive_impulse > 0.0:
            raise ValueError(
                f"speed_ratio: must let the tip strike; this one approaches at {speed:g} m/s"
            )
        return contact, (contact.compression_time, contact.compressive_impulse)

    # In restitution the spring is stiffer by 1/e*^2, and the tip's response is proportional to s_2
    # = sin gamma - mu_2 cos gamma instead of s_1 = sin gamma + mu_1 cos gamma.
    cosine, sine = math.cos(impact_angle), math.sin(impact_angle)
    leaving = sine - surface.friction_in_restitution * cosine
    whole = 1.0
    if leaving > 0.0:
        whole += surface.restitution * math.sqrt((sine + surface.friction * cosine) / leaving)
    given = np.array([compression_time * whole, speed])
    return _adjusted(struck, given, np.array(requested), max(REQUEST_TOLERANCE, settings.accuracy))


def contact_fields(contact: TimedContact, **later: float) -> dict[str, Any]:
    """Return the fields with which a report describes a contact.

    ``later`` holds times of further events (s), by name.
    """
    events = {"strike": 0.0, "deepest": contact.compression_time} | later
    return record_fields(contact.strike, **events)


def with_visible_contact(impacts: Impacts) -> Impacts:
    """Return the impacts with a compliant contact that is long enough to be seen in a film.

    If no duration was requested, the compliant contact is so short that the rods hardly move. It is
    then replaced by a contact whose compression lasts 50 us, the value printed in the dissertation.
    The impacts are returned unchanged if a duration was requested, or if no contact of these rods
    has this compression time.
    """
    found = impacts.strikes.get("compliant")
    if found is None or impacts.contact.duration is not None:
        return impacts
    duration = 2.0 * PRINTED_COMPRESSION
    if math.hypot(*found.contact.velocity_before) * duration > min(impacts.chain.lengths):
        return impacts

    def struck(duration: float) -> tuple[ChainStrike, tuple[float]]:
        """Simulate the impact with a contact of a given duration (s); return it with its
        compression time.
        """
        law = Contact("compliant", duration)
        found = strike(impacts.chain, impacts.surface, law, Settings())
        assert found.contact.history is not None  # the contact is resolved in time
        return found, (compression_end(found.contact.history),)

    wanted = np.array([PRINTED_COMPRESSION])
    try:
        visible = _adjusted(struck, np.array([duration]), wanted, REQUEST_TOLERANCE)
    except ValueError:
        return impacts
    strikes = impacts.strikes | {"compliant": visible}
    return dataclasses.replace(impacts, strikes=strikes, timing="as printed, for the film")


def _adjusted(
    struck: Callable[..., tuple[Result, tuple[float, ...]]],
    given: Array,
    wanted: Array,
    tolerance: float,
) -> Result:
    """Adjust arguments of a simulation until it attains target values, and return its result.

    The method is Broyden's, applied to the logarithms of arguments and values.

    Args:
        struck: simulation; it returns its result, and the values to compare with the target values.
        given: arguments with which the adjustment starts. If there are n target values, the first n
            arguments are adjusted.
        wanted: target values.
        tolerance: largest accepted relative deviation from the target values.

    Raises:
        ValueError: if the target values are not attained in MOST_ROUNDS iterations.
    """
    free = len(wanted)
    slopes = np.eye(len(wanted))
    step = before = np.zeros(free)
    for _ in range(MOST_ROUNDS):
        found, values = struck(*given.tolist())
        missing = np.log(wanted / np.array(values[:free]))
        if np.all(np.abs(missing) <= tolerance):
            return found
        if step.any():
            slopes += np.outer(before - missing - slopes @ step, step) / float(step @ step)
        step = np.clip(np.linalg.solve(slopes, missing), -LARGEST_STEP, LARGEST_STEP)
        before = missing
        given[:free] *= np.exp(step)
    raise ValueError(
        f"compression_time = {wanted[0]:g}: must be shorter, as the hub turns too far during the contact (in s)"
    )
