"""The recorded data of a run, and properties derived from them; base class of a trajectory."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.declared import Choice
from bristle_sim.parameters import PARTS, Tool
from bristle_sim.settings import ABSENCES, EVENTS, OBSTACLE, StopReason
from bristle_sim.trajectory.records import ContactRecord, Cost, Event, Motion

# ratio of error estimate to requested accuracy above which the run reports the excess
EXCESS_SAID = 100.0
# least notable extreme of the motion relative to the hub, as a fraction of the run's largest value
NOTABLE = 0.01

# Largest distance of a touch from a corner of the wire up to which the corner counts as touched, as
# a fraction of the length of the straight segment.
CORNER_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class RecordedRun(Motion):
    """The recorded data of a run, as the class ``Trajectory`` describes them."""

    events: tuple[Event, ...]
    contacts: tuple[ContactRecord, ...]
    stop_reason: StopReason
    cost: Cost
    parameters: dict[str, Any] = field(default_factory=dict)
    stop_detail: str = ""

    def with_places(self, tool: Tool) -> Self:
        """Return the trajectory after setting ``point`` and ``place`` in the records of its
        contacts with bar and workpart.
        """
        contacts = []
        for contact in self.contacts:
            line = self.centre_line[int(abs(self.time - contact.time).argmin())]
            contacts.append(
                located(contact, tool, line) if contact.obstacle in ("bar", "workpart") else contact
            )
        return dataclasses.replace(self, contacts=tuple(contacts))

    def event_time(
        self, name: str, *, last: bool = False, before: float = math.inf
    ) -> float | None:
        """Return the time of the first or the last event of a name, s; None if there is no such
        event.

        Args:
            name: name of the event.
            last: whether to return the last event instead of the first.
            before: latest time of the events considered, s.

        Raises:
            ValueError: if no event can have this name.
        """
        recorded = [event.name for event in self.events]
        Choice("name", options=(*EVENTS, *ABSENCES, *recorded)).check(name)
        times = [event.time for event in self.events if event.name == name and event.time <= before]
        return (times[-1] if last else times[0]) if times else None

    @property
    def notable_events(self) -> tuple[Event, ...]:
        """All events, except extremes of the motion relative to the hub below 1 % of the run's
        largest.

        Small extremes are, for example, those of a bent wire carried by the hub, which swings by a
        tenth of a degree before it meets the bar.
        """
        sizes = {
            "largest retraction": abs(self.relative_angle),
            "highest relative speed": abs(self.relative_rate),
        }
        notable = []
        for event in self.events:
            size = sizes.get(event.name)
            if size is None or np.interp(event.time, self.time, size) >= NOTABLE * size.max():
                notable.append(event)
        return tuple(notable)

    @property
    def stop_advice(self) -> str:
        """Advice on how to avoid the stop of the run. It names the friction parameter of the
        obstacle touched last.
        """
        at_bar = self.contacts and self.contacts[-1].obstacle == "bar"
        return self.stop_detail or self.stop_reason.remedy.format(
            friction="bar_friction" if at_bar else "friction"
        )

    @property
    def accuracy_not_reached(self) -> str:
        """A warning if the error estimate exceeds the requested accuracy more than a hundredfold;
        otherwise empty.

        The warning states the remedy. It begins with "accuracy not reached", unless the estimate is
        valid only for the first part of the run: chatter, or a touch slower than the error, ends
        its validity.
        """
        estimate = self.cost.error_estimate
        requested = self.parameters.get("settings", {}).get("accuracy")
        if not estimate or not requested or estimate <= EXCESS_SAID * requested:
            return ""
        ratio = (
            f"{estimate / requested:.0f}"
            if estimate < 1e6 * requested
            else f"{estimate / requested:.0e}"
        )
        start = "accuracy not reached: " if self.cost.holds_until is None else ""
        return (
            f"{start}error estimate {estimate:.1g}, {ratio} times the requested accuracy {requested:g};"
            " request a smaller accuracy"
        )

    def first_contact(self, obstacle: str) -> ContactRecord | None:
        """Return the first contact with an obstacle, or None without one.

        ``obstacle`` is ``bar``, ``workpart`` or ``wire``.

        Raises:
            ValueError: for any other obstacle.
        """
        OBSTACLE.check(obstacle)
        for each in self.contacts:
            if each.obstacle == obstacle:
                return each
        return None

    @property
    def tool(self) -> Tool:
        """The tool that was simulated.

        Raises:
            ValueError: if the recorded parameters do not describe a tool.
        """
        try:
            parts = self.parameters["tool"]
            built = {
                name: None if parts[name] is None else kinds[0](**parts[name])
                for name, kinds in PARTS.items()
            }
            return Tool(**{**parts, **built})
        except (KeyError, TypeError) as error:
            raise ValueError(
                f"parameters: must describe the tool that was simulated ({error})"
            ) from error


def located(contact: ContactRecord, tool: Tool, line: Array) -> ContactRecord:
    """Return a contact's record after setting ``point`` and ``place``, the part of the wire in
    contact and its position.

    For the workpart it is the corner of the centre line nearest to the workpart's surface. For the
    bar it is the point of the centre line nearest to the bar's centre.

    Args:
        contact: the record.
        tool: the tool.
        line: corners of the centre line (m), shape (corners, 2).
    """
    if contact.obstacle == "workpart":
        corner = 1 + int(abs(line[1:, 1] + tool.workpart_depth).argmin())
        place = line[corner]
    else:
        assert tool.bar is not None
        pieces = np.diff(line, axis=0)
        along = ((np.array(tool.bar.centre) - line[:-1]) * pieces).sum(axis=1) / (pieces**2).sum(
            axis=1
        )
        along = np.clip(along, 0.0, 1.0)
        points = line[:-1] + along[:, np.newaxis] * pieces
        piece = int(np.linalg.norm(points - tool.bar.centre, axis=1).argmin())
        place = points[piece]
        near = np.array([along[piece], 1.0 - along[piece]]) <= CORNER_ROUNDING
        corner = piece + int(near[1]) if near.any() else 0
    name = "tip" if corner == len(line) - 1 else "knee" if corner else "flank"
    return dataclasses.replace(contact, point=name, place=(float(place[0]), float(place[1])))
