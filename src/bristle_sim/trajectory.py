"""What a simulation returns: samples in time, events, contacts, why it stopped and what it cost."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.files import complete_or_absent
from bristle_sim.stop_reason import ABSENCES, EVENTS, StopReason, checked_event

__all__ = ["ContactAtEnd", "ContactHistory", "ContactRecord", "Cost", "Event", "Trajectory"]

Array = NDArray[np.float64]
FORMAT = 2
"""Of saved files. Format 1 wrote the reason to stop as free text and had no centre lines."""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at an instant, e.g. ``strike`` or ``bar touch``; time in s."""

    name: str
    time: float


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run cost: wall and CPU time in s, engine steps or right-hand sides evaluated, and the error estimate.

    ``error_estimate`` is the method's own estimate of the accumulated error relative to the motion's size, or None where
    the method has none.
    """

    wall_s: float
    cpu_s: float
    steps: int
    error_estimate: float | None = None


@dataclass(frozen=True, slots=True)
class ContactHistory:
    """A contact resolved in time; arrays of one length.

    Attributes:
        time: s, from the first touch of the run's clock.
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
        """Return every sampled quantity by its name and unit, one entry a sample."""
        units = {"time": "s", "force": "N", "penetration": "m", "velocity": "m/s"}
        names = (each.name for each in dataclasses.fields(self))
        return {f"{name} ({units[name.split('_')[-1]]})": getattr(self, name) for name in names}


@dataclass(frozen=True, slots=True)
class ContactRecord:
    """Ledger entry of one contact. Vectors are (normal, tangential); the normal points out of the obstacle.

    Attributes:
        obstacle: ``bar`` or ``workpart``.
        law: ``energetic``, ``compliant``, ``engine`` (impacts) or ``hold`` (sustained touch).
        outcome: the impact law's word, or how a sustained touch ended.
        time, duration: start and length in s; an instantaneous impact lasts 0 s.
        impulse: on the moving body, N s.
        compressive_impulse: up to the end of compression, N s; None where the law knows no phases.
        compressive_work, restitutive_work: of the impulse on the body, J; (normal, tangential), or None.
        velocity_before, velocity_after: of the contact point, m/s.
        angles: absolute angle of every link when the contact began, rad.
        rates_before, rates_after: absolute rate of every link, rad/s.
        phases: in order, e.g. ``("compression slip", "restitution slip")``.
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

    def columns(self) -> dict[str, Array]:
        """Return the contact in time by names and units.

        Raises:
            ValueError: for a contact that was not resolved in time.
        """
        if self.history is None:
            raise ValueError(f"contact = {self.law}: must be compliant; an impact at an instant has no time series")
        return self.history.columns()


@dataclass(frozen=True, slots=True)
class ContactAtEnd:
    """The state of contact in which a run ended, from which it is resumed.

    Attributes:
        state: ``in flight``, ``separating`` or ``sustained contact``.
        obstacle: that the bristle separates from or is in contact with.
    """

    state: str = "in flight"
    obstacle: str | None = None


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A run of one mechanism: n samples, in SI units and radians.

    At an impact two samples share one instant: before and after it.

    Attributes:
        time: s.
        hub_angle: of the bristle's root, from the direction of the workpart, rad; zero throughout for a fixed root.
        angles, rates: absolute angle and rate of each link, shape (n, links), rad and rad/s.
        centre_line: corners of the wires' centre line from the root over knees and joints to the tip, (x, y) from the
            hub's centre, shape (n, corners, 2), m; pictures draw these points.
        centre_line_velocity: of the same corners, shape (n, corners, 2), m/s.
        kinetic_energy, potential_energy: of the links and of belt and gravity, J.
        normal_force: of the obstacle that is touched, N; zero in flight.
        events, contacts: in order of time.
        stop_reason: why the run stopped; its ``advice`` says what would let it go further.
        cost: see Cost.
        parameters: what was simulated, as plain numbers and words.
        contact_at_end: see ContactAtEnd; the reference leaves it out.
    """

    time: Array
    hub_angle: Array
    angles: Array
    rates: Array
    centre_line: Array
    centre_line_velocity: Array
    kinetic_energy: Array
    potential_energy: Array
    normal_force: Array
    hub_speed: float
    events: tuple[Event, ...]
    contacts: tuple[ContactRecord, ...]
    stop_reason: StopReason
    cost: Cost
    parameters: dict[str, Any] = field(default_factory=dict)
    contact_at_end: ContactAtEnd = field(default_factory=ContactAtEnd)

    @property
    def tip(self) -> Array:
        """Position of the last link's tip, where the centre line ends, shape (n, 2), m."""
        return self.centre_line[:, -1]

    @property
    def tip_velocity(self) -> Array:
        """Velocity of the tip, shape (n, 2), m/s."""
        return self.centre_line_velocity[:, -1]

    @property
    def retraction(self) -> Array:
        """Angle by which the first link lags the radial direction, positive when it lags, rad; minus relative_angle."""
        return np.asarray(self.hub_angle - self.angles[:, 0])

    @property
    def relative_angle(self) -> Array:
        """Angle of the first link relative to the radial direction, alpha; negative when it lags (retraction), rad."""
        return np.asarray(self.angles[:, 0] - self.hub_angle)

    @property
    def relative_rate(self) -> Array:
        """Rate of the first link relative to the hub, rad/s."""
        return np.asarray(self.rates[:, 0] - self.hub_speed)

    @property
    def total_energy(self) -> Array:
        """Kinetic plus potential energy, J; the hub's drive may change it."""
        return np.asarray(self.kinetic_energy + self.potential_energy)

    def event_time(self, name: str, *, last: bool = False, before: float = math.inf) -> float | None:
        """Return the time of the first (or last) event of that name at or before an instant, s; None if there is none.

        Raises:
            ValueError: if no run has an event of that name.
        """
        recorded = [event.name for event in self.events]
        name = checked_event("name", name, dict.fromkeys((*EVENTS, *ABSENCES, *recorded)))
        times = [event.time for event in self.events if event.name == name and event.time <= before]
        return (times[-1] if last else times[0]) if times else None

    @property
    def stop_advice(self) -> str:
        """What would let the run go further, in terms of the obstacle touched last."""
        return self.stop_reason.advice(self.contacts[-1].obstacle if self.contacts else None)

    def first_contact(self, obstacle: str) -> ContactRecord | None:
        """The first contact with ``bar`` or ``workpart``, or None."""
        return next((each for each in self.contacts if each.obstacle == obstacle), None)

    def columns(self) -> dict[str, Array]:
        """Return every sampled quantity by its name and unit, one entry a sample, for tables and files."""
        links = range(self.angles.shape[1])
        return {
            "time (s)": self.time,
            "hub_angle (rad)": self.hub_angle,
            **{f"angle_{link + 1} (rad)": self.angles[:, link] for link in links},
            **{f"rate_{link + 1} (rad/s)": self.rates[:, link] for link in links},
            "relative_angle (rad)": self.relative_angle,
            "relative_rate (rad/s)": self.relative_rate,
            "tip_x (m)": self.tip[:, 0],
            "tip_y (m)": self.tip[:, 1],
            "kinetic_energy (J)": self.kinetic_energy,
            "potential_energy (J)": self.potential_energy,
            "normal_force (N)": self.normal_force,
        }

    def save(self, path: str | Path) -> None:
        """Write everything to one npz file of exactly that name, with no suffix added; it appears only when complete.

        Raises:
            OSError: naming the file, if it cannot be written.
        """
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        contacts = []
        for number, contact in enumerate(self.contacts):
            row = dataclasses.asdict(dataclasses.replace(contact, history=None))
            if contact.history is not None:
                row["history"] = True
                for each in dataclasses.fields(ContactHistory):
                    arrays[f"contact{number}_{each.name}"] = getattr(contact.history, each.name)
            contacts.append(row)
        meta = {
            "format": FORMAT,
            "hub_speed": self.hub_speed,
            "events": [dataclasses.asdict(event) for event in self.events],
            "contacts": contacts,
            "stop_reason": self.stop_reason.name,
            "cost": dataclasses.asdict(self.cost),
            "parameters": self.parameters,
            "contact_at_end": dataclasses.asdict(self.contact_at_end),
        }
        with complete_or_absent(Path(path)) as partial, partial.open("wb") as stream:
            np.savez_compressed(stream, metadata=np.array(json.dumps(meta)), **arrays)

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a file written by :meth:`save`, by the same name.

        Raises:
            OSError: if there is no such file or it cannot be read.
            ValueError: for any other file.
        """
        try:
            with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
                meta = json.loads(str(stored["metadata"]))
                if meta["format"] != FORMAT:
                    raise ValueError(
                        f"written in format {meta['format']}, this version reads format {FORMAT}; simulate the run again"
                    )
                return cls._from(meta, stored)
        except OSError:
            raise
        except Exception as error:  # zip, JSON and NumPy each have their own for a file that is something else
            raise ValueError(f"{path}: not a trajectory file ({error})") from error

    @classmethod
    def _from(cls, meta: dict[str, Any], stored: Any) -> Trajectory:
        return cls(
            **{name: stored[name] for name in _ARRAYS},
            hub_speed=meta["hub_speed"],
            events=tuple(Event(**row) for row in meta["events"]),
            contacts=tuple(_contact(row, number, stored) for number, row in enumerate(meta["contacts"])),
            stop_reason=StopReason[meta["stop_reason"]],
            cost=Cost(**meta["cost"]),
            parameters=meta["parameters"],
            contact_at_end=ContactAtEnd(**meta["contact_at_end"]),
        )


_ARRAYS = (
    "time",
    "hub_angle",
    "angles",
    "rates",
    "centre_line",
    "centre_line_velocity",
    "kinetic_energy",
    "potential_energy",
    "normal_force",
)


def _contact(row: dict[str, Any], number: int, stored: Any) -> ContactRecord:
    has_history = row.pop("history") is not None
    history = None
    if has_history:
        names = (each.name for each in dataclasses.fields(ContactHistory))
        history = ContactHistory(**{name: stored[f"contact{number}_{name}"] for name in names})
    values: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
    return ContactRecord(**values, history=history)
