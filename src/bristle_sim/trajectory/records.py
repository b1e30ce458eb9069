"""The parts of a run's result: motion, events, contacts and cost."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array, EqualByValue

WIRE = {
    "time": ("n", "s"), "angles": ("nl", "rad"), "rates": ("nl", "rad/s"), "centre_line": ("nc2", "m"),
    "centre_line_velocity": ("nc2", "m/s"),
}  # fmt: skip
SAMPLED = WIRE | {
    "hub_angle": ("n", "rad"), "kinetic_energy": ("n", "J"), "potential_energy": ("n", "J"), "normal_force": ("n", "N"),
}  # fmt: skip
"""Dimensions and unit of each sampled array of a WireMotion and of a Motion: n instants, l links, c corners, 2 axes."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at an instant, e.g. ``strike`` or ``bar touch``; time in s."""

    name: str
    time: float


@dataclass(frozen=True, slots=True)
class Cost:
    """The cost of a run: wall and CPU time in s, engine steps or right-hand sides evaluated, and the error estimate.

    ``error_estimate`` is the method's own estimate of the last state's error relative to the motion's size, or None where
    the method has none. It is not valid after ``holds_until``, s, because the outcome of an impact there depends on the
    error, as in a chatter.
    """

    wall_s: float
    cpu_s: float
    steps: int
    error_estimate: float | None = None
    holds_until: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class WireMotion(EqualByValue):
    """The motion of a wire at an array of instants of any shape (...), in SI units and radians.

    Attributes:
        angles, rates: absolute angle and rate of each link, shape (..., links), rad and rad/s.
        centre_line: corners of the wire's centre line from the root over knees and joints to the tip, (x, y) from the
            hub's centre, shape (..., corners, 2), m; pictures draw these points.
        centre_line_velocity: of the same corners, m/s.
    """

    time: Array
    angles: Array
    rates: Array
    centre_line: Array
    centre_line_velocity: Array


@dataclass(frozen=True, slots=True, eq=False)
class Motion(WireMotion):
    """The motion of a wire with the hub's, energies and forces.

    Attributes:
        hub_angle: of the bristle's root, from the direction of the workpart, rad; constant on a hub at rest.
        kinetic_energy, potential_energy: of the links; of belt, hinges and gravity, J.
        normal_force: sum over the contacts that last, N; zero in flight and at the instant of an impact.
        hub_speed: angular velocity of the hub, rad/s.
    """

    hub_angle: Array
    kinetic_energy: Array
    potential_energy: Array
    normal_force: Array
    hub_speed: float

    @property
    def tip(self) -> Array:
        """Position of the last link's tip, where the centre line ends, shape (..., 2), m."""
        return self.centre_line[..., -1, :]

    @property
    def tip_velocity(self) -> Array:
        """Velocity of the tip, shape (..., 2), m/s."""
        return self.centre_line_velocity[..., -1, :]

    @property
    def tip_speed(self) -> Array:
        """Speed of the tip over the workpart, m/s."""
        return np.asarray(np.hypot(self.tip_velocity[..., 0], self.tip_velocity[..., 1]))

    @property
    def relative_angle(self) -> Array:
        """Angle of the first link relative to the radial direction, alpha; negative when it lags (retraction), rad."""
        return np.asarray(self.angles[..., 0] - self.hub_angle)

    @property
    def retraction(self) -> Array:
        """Angle by which the first link lags the radial direction, rad: minus relative_angle."""
        return np.asarray(self.hub_angle - self.angles[..., 0])

    @property
    def relative_rate(self) -> Array:
        """Rate of the first link relative to the hub, rad/s."""
        return np.asarray(self.rates[..., 0] - self.hub_speed)

    @property
    def total_energy(self) -> Array:
        """Kinetic plus potential energy, J; not constant, as the hub's drive does work."""
        return np.asarray(self.kinetic_energy + self.potential_energy)


@dataclass(frozen=True, slots=True, eq=False)
class ContactHistory(EqualByValue):
    """A contact resolved in time; arrays of one length.

    Attributes:
        time: on the run's clock, from the first touch on, s.
        normal_force, tangential_force: on the tip, N.
        penetration: m, positive inside the workpart.
        normal_velocity, tangential_velocity: of the tip, m/s.
    """

    time: Array
    normal_force: Array
    tangential_force: Array
    penetration: Array
    normal_velocity: Array
    tangential_velocity: Array

    def columns(self) -> dict[str, Array]:
        """Return every sampled quantity under a key of name and unit, one entry per sample."""
        units = ("s", "N", "N", "m", "m/s", "m/s")
        named = zip(dataclasses.fields(self), units, strict=True)
        return {f"{each.name} ({unit})": getattr(self, each.name) for each, unit in named}


@dataclass(frozen=True, slots=True)
class ContactRecord:
    """One contact; vectors are (normal, tangential), and the normal points out of the obstacle.

    Attributes:
        obstacle: ``bar``, ``workpart``, or ``wire`` for another bristle.
        law: ``energetic``, ``compliant``, ``engine`` (impacts) or ``sustained``.
        outcome: as named by the impact law, or how a sustained contact ended.
        time, duration: start and length in s; an instantaneous impact lasts 0 s.
        impulse: on the moving body, N s.
        compressive_impulse: up to the end of compression, N s; None where the law knows no phases.
        compressive_work, restitutive_work: of the impulse on the body, J; of a sustained contact (0, work of friction) and None.
        velocity_before, velocity_after: of the contact point, m/s.
        angles: absolute angle of every link when the contact began, rad.
        rates_before, rates_after: absolute rate of every link, rad/s.
        phases: in order, e.g. ``("compression slip", "restitution slip")``.
        history: of a contact resolved in time.
        link: number of the link in contact, from 1 at the root; None for a rigid bristle, and of the reference.
        neighbour: number of the other bristle in its row, from 1 for the foremost one; None for other obstacles.
        point: of the wire in contact when it began: ``tip``, ``knee`` (or a joint between links), or ``flank``; empty for a contact
            of two wires and for a single contact without a pass.
        place: of that point on the wire's centre line then, (x, y) from the hub's centre, m; None as for ``point``.
    """

    obstacle: str
    law: str
    outcome: str
    time: float
    duration: float
    impulse: tuple[float, float]
    compressive_impulse: tuple[float, float] | None
    compressive_work: tuple[float, float] | None
    restitutive_work: tuple[float, float] | None
    velocity_before: tuple[float, float]
    velocity_after: tuple[float, float]
    angles: tuple[float, ...]
    rates_before: tuple[float, ...]
    rates_after: tuple[float, ...]
    phases: tuple[str, ...] = ()
    history: ContactHistory | None = None
    link: int | None = None
    neighbour: int | None = None
    point: str = ""
    place: tuple[float, float] | None = None

    @property
    def outcome_in_words(self) -> str:
        """The outcome as sentences and ``ensemble`` write it: *rebounds*, *reverses its slip*, *sticks and rebounds*, *stays*, *jams*.

        A tip that reverses its slip, or sticks, does so in a phase with an impulse. A sustained contact keeps its own word.
        """
        if self.outcome != "rebound":
            ends = {"jam": "jams", "stiction": "stays", "no rebound": "stays"}
            return ends.get(self.outcome, self.outcome)
        slips = " ".join(self.phases)
        if "reverse" in slips:
            return "reverses its slip"
        return "sticks and rebounds" if "stick" in slips else "rebounds"

    @property
    def friction_magnification(self) -> float:
        """Normal impulse over that which would change the normal velocity as much without friction; large near the jam.

        With dv = K p the impulse without friction is dv_n/K_nn. For a rod of one degree of freedom, whose K has rank one, the
        ratio is p_n dv_n/(p . dv); 1 without friction, infinite where the impulse along the wire's own line moves nothing.
        """
        normal, tangential = (
            after - before
            for after, before in zip(self.velocity_after, self.velocity_before, strict=True)
        )
        work = self.impulse[0] * normal + self.impulse[1] * tangential
        return self.impulse[0] * normal / work if work > 0.0 else math.inf

    def columns(self) -> dict[str, Array]:
        """Return the history under keys of name and unit. Raises ValueError for a contact not resolved in time."""
        if self.history is None:
            raise ValueError(
                f"contact = {self.law}: must be compliant; an impact at an instant has no time series"
            )
        return self.history.columns()
