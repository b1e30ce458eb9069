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
"""Dimensions and unit of each sampled array of a Motion; ``WIRE`` holds those of a WireMotion.

The letters of the dimensions are n for instants, l for links, c for corners and 2 for the axes x
and y."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event: its name, for example ``strike`` or ``bar touch``, and its time, s."""

    name: str
    time: float


@dataclass(frozen=True, slots=True)
class Cost:
    """The computing time of a run, and its error estimate.

    Attributes:
        wall_s: wall time, s.
        cpu_s: CPU time, s.
        steps: number of engine steps, or of evaluations of the right-hand side of the equations of
            motion.
        error_estimate: the method's own estimate of the error of the last state, relative to the
            size of the motion; None if the method has no estimate.
        holds_until: time up to which the estimate is valid, s; None if it is valid to the end of
            the run. The estimate is not valid after an impact whose outcome depends on the error,
            as in chatter.
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
        time: the instants (s), shape (...).
        angles: absolute angle of each link (rad), shape (..., links).
        rates: absolute angular velocity of each link (rad/s), shape (..., links).
        centre_line: corners of the wire's centre line (root, knees, joints and tip, in order), as
            (x, y) from the hub's centre (m), shape (..., corners, 2). Pictures draw these points.
        centre_line_velocity: velocity of the same corners (m/s), shape (..., corners, 2).
    """

    time: Array
    angles: Array
    rates: Array
    centre_line: Array
    centre_line_velocity: Array


@dataclass(frozen=True, slots=True, eq=False)
class Motion(WireMotion):
    """The motion of a wire and of the hub, with energies and the normal force.

    Attributes:
        hub_angle: angle of the bristle's root from the direction of the workpart, rad; constant on
            a hub at rest.
        kinetic_energy: kinetic energy of the links, J.
        potential_energy: potential energy of belt, hinges and gravity, J.
        normal_force: sum of the normal forces of the sustained contacts, N; zero in flight and at
            the instant of an impact.
        hub_speed: angular velocity of the hub, rad/s.
    """

    hub_angle: Array
    kinetic_energy: Array
    potential_energy: Array
    normal_force: Array
    hub_speed: float

    @property
    def tip(self) -> Array:
        """Position of the end of the centre line (m), shape (..., 2)."""
        return self.centre_line[..., -1, :]

    @property
    def tip_velocity(self) -> Array:
        """Velocity of the tip (m/s), shape (..., 2)."""
        return self.centre_line_velocity[..., -1, :]

    @property
    def tip_speed(self) -> Array:
        """Magnitude of the tip's velocity, m/s."""
        return np.asarray(np.hypot(self.tip_velocity[..., 0], self.tip_velocity[..., 1]))

    @property
    def relative_angle(self) -> Array:
        """Angle alpha of the first link relative to the radial direction, rad; negative in
        retraction.
        """
        return np.asarray(self.angles[..., 0] - self.hub_angle)

    @property
    def retraction(self) -> Array:
        """Angle by which the first link lags behind the radial direction, rad.

        The retraction is ``relative_angle`` with the opposite sign.
        """
        return np.asarray(self.hub_angle - self.angles[..., 0])

    @property
    def relative_rate(self) -> Array:
        """Angular velocity of the first link relative to the hub, rad/s."""
        return np.asarray(self.rates[..., 0] - self.hub_speed)

    @property
    def total_energy(self) -> Array:
        """Kinetic plus potential energy, J.

        This energy is not constant, since the hub's drive does work on the bristle.
        """
        return np.asarray(self.kinetic_energy + self.potential_energy)

    def columns(self) -> dict[str, Array]:
        """Return the columns of a table of all quantities, by their titles "name (unit)".

        The motion must have a one-dimensional array of instants. Each column has one entry for each
        instant.
        """
        x_y = ("x", "y")
        links = range(self.angles.shape[1])
        return {
            "time (s)": self.time,
            "hub_angle (rad)": self.hub_angle,
            **{f"angle_{link + 1} (rad)": self.angles[:, link] for link in links},
            **{f"rate_{link + 1} (rad/s)": self.rates[:, link] for link in links},
            "relative_angle (rad)": self.relative_angle,
            "relative_rate (rad/s)": self.relative_rate,
            "retraction (rad)": self.retraction,
            **{f"tip_{name} (m)": each for name, each in zip(x_y, self.tip.T, strict=True)},
            **{
                f"tip_velocity_{name} (m/s)": each
                for name, each in zip(x_y, self.tip_velocity.T, strict=True)
            },
            "tip_speed (m/s)": self.tip_speed,
            "kinetic_energy (J)": self.kinetic_energy,
            "potential_energy (J)": self.potential_energy,
            "normal_force (N)": self.normal_force,
        }


@dataclass(frozen=True, slots=True, eq=False)
class ContactHistory(EqualByValue):
    """The history of a compliant contact, as arrays of equal length.

    Attributes:
        time: times from the first touch on, measured from the start of the run, s.
        normal_force: normal force on the tip, N.
        tangential_force: tangential force on the tip, N.
        penetration: penetration (m), positive inside the workpart.
        normal_velocity: normal velocity of the tip, m/s.
        tangential_velocity: tangential velocity of the tip, m/s.
    """

    time: Array
    normal_force: Array
    tangential_force: Array
    penetration: Array
    normal_velocity: Array
    tangential_velocity: Array

    def columns(self) -> dict[str, Array]:
        """Return the columns of a table of all quantities, by their titles "name (unit)"."""
        units = ("s", "N", "N", "m", "m/s", "m/s")
        named = zip(dataclasses.fields(self), units, strict=True)
        return {f"{each.name} ({unit})": getattr(self, each.name) for each, unit in named}


@dataclass(frozen=True, slots=True)
class ContactRecord:
    """The record of one contact.

    Vectors are (normal, tangential); the normal points out of the obstacle.

    Attributes:
        obstacle: ``bar``, ``workpart``, or ``wire`` for another bristle.
        law: ``energetic``, ``compliant`` or ``engine`` for an impact; ``sustained`` for a sustained
            contact.
        outcome: result of the impact law, for example ``rebound``. For a sustained contact it is
            the reason why the contact ended: a release, another contact, or the stop of the run.
        time: start of the contact, s.
        duration: duration, s; 0 for an instantaneous impact.
        impulse: impulse on the wire, N s.
        compressive_impulse: impulse on the wire up to the end of compression, N s; None if the law
            has no phases.
        compressive_work: work of the impulse on the wire in compression, J; None if the law has no
            phases. For a sustained contact the normal component is 0 and the tangential component
            is the work of friction.
        restitutive_work: work of the impulse on the wire in restitution, J; None for a sustained
            contact, or if the law has no phases.
        velocity_before: velocity of the contact point before the contact, m/s.
        velocity_after: velocity of the contact point after the contact, m/s.
        angles: absolute angle of every link when the contact began, rad.
        rates_before: absolute angular velocity of every link before the contact, rad/s.
        rates_after: absolute angular velocity of every link after the contact, rad/s.
        phases: names of the phases in order, for example ``("compression slip", "restitution
            slip")``.
        history: forces and motion of a compliant contact over time; None for any other contact.
        link: number of the link in contact, from 1 at the root; None for a rigid bristle.
        neighbour: number of the other bristle in its row, from 1 for the foremost bristle; None for
            any other obstacle.
        point: point of the wire in contact at the start: ``tip``, ``knee`` (or a joint between
            links), or ``flank`` (between corners). The text is empty for a contact of two wires,
            and for a single contact that is not part of a pass.
        place: position of this point on the wire's centre line at the start of the contact, (x, y)
            from the hub's centre, m; None where ``point`` is empty.
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
    def work(self) -> tuple[float, float] | None:
        """Work of the impulse on the wire, (normal, tangential), J.

        The result is None if the law has no phases.
        """
        if self.compressive_work is None or self.restitutive_work is None:
            return self.compressive_work
        normal, tangential = np.add(self.compressive_work, self.restitutive_work).tolist()
        return normal, tangential

    @property
    def outcome_in_words(self) -> str:
        """The outcome as words that complete a sentence, as in the results of ``ensemble``.

        The outcome of an impact is *rebounds*, *reverses its slip*, *sticks and rebounds*, *stays*
        or *jams*. Reverse slip and stick count only in phases with an impulse. For a sustained
        contact the text is ``outcome``.
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
        """Factor by which friction increases the normal impulse; it is large close to a jam.

        The normal impulse p_n is divided by the normal impulse that would cause the same change
        dv_n of the normal velocity without friction. An impulse p changes the velocity by dv = K p,
        with the contact-space inverse mass matrix K. Without friction the normal impulse is thus
        dv_n/K_nn. For a rod of one degree of freedom K has rank one, and the factor is p_n
        dv_n/(p_n dv_n + p_t dv_t). The factor is 1 without friction, and infinite if the impulse
        points along the wire and moves nothing.
        """
        normal, tangential = (
            after - before
            for after, before in zip(self.velocity_after, self.velocity_before, strict=True)
        )
        work = self.impulse[0] * normal + self.impulse[1] * tangential
        return self.impulse[0] * normal / work if work > 0.0 else math.inf

    def columns(self) -> dict[str, Array]:
        """Return the columns of a table of the contact's history, by their titles "name (unit)".

        Raises:
            ValueError: for a contact without a history.
        """
        if self.history is None:
            raise ValueError(
                f"contact = {self.law}: must be compliant; an impact at an instant has no time series"
            )
        return self.history.columns()
