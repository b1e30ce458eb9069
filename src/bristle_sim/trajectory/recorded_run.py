"""The record of a run, without the interpolation, files, tables and pictures of a trajectory."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bristle_sim.parameters import PARTS, Tool
from bristle_sim.settings import ABSENCES, EVENTS, OBSTACLES, StopReason, checked_name
from bristle_sim.trajectory.records import ContactRecord, Cost, Event, Motion

# error estimate over the requested accuracy above which the run states the excess
EXCESS_SAID = 100.0
NOTABLE = 0.01  # least extreme of the relative motion that is notable, as a fraction of the largest


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class RecordedRun(Motion):
    """The record of a run: the motion of one bristle at n samples, in SI units and radians, with
    its events and contacts.

    An impact has two samples at the same instant: before and after it.

    Attributes:
        time, hub_angle, angles, ..., normal_force, hub_speed: see Motion; arrays of n samples.
        events, contacts: in order of time.
        stop_reason: why the run stopped.
        cost: cost of the run.
        parameters: the simulation's parameters, as plain numbers and strings.
        stop_detail: why a contact law gave up, and the remedy; empty for any other stop.
    """

    events: tuple[Event, ...]
    contacts: tuple[ContactRecord, ...]
    stop_reason: StopReason
    cost: Cost
    parameters: dict[str, Any] = field(default_factory=dict)
    stop_detail: str = ""

    def event_time(
        self, name: str, *, last: bool = False, before: float = math.inf
    ) -> float | None:
        """Return the time of the first (or last) event of a name up to an instant, s; None if there
        is none.

        Raises:
            ValueError: for a name that no event can have.
        """
        recorded = [event.name for event in self.events]
        name = checked_name("name", name, dict.fromkeys((*EVENTS, *ABSENCES, *recorded)))
        times = [event.time for event in self.events if event.name == name and event.time <= before]
        return (times[-1] if last else times[0]) if times else None

    @property
    def notable_events(self) -> tuple[Event, ...]:
        """All events, except extremes of the relative motion below 1 % of the run's largest.

        For example, a bent wire carried by the hub swings by a tenth of a degree before it meets
        the bar.
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
        """The remedy for the stop of the run, in terms of the obstacle touched last."""
        at_bar = self.contacts and self.contacts[-1].obstacle == "bar"
        return self.stop_detail or self.stop_reason.remedy.format(
            friction="bar_friction" if at_bar else "friction"
        )

    @property
    def accuracy_not_reached(self) -> str:
        """Sentence that the error estimate exceeds the requested accuracy a hundredfold; otherwise
        empty.

        The sentence names the remedy. It begins with "accuracy not reached" unless chatter, or a
        touch slower than the error, has made the estimate a bound only.
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
        """Return the first contact with ``bar``, ``workpart`` or ``wire``, or None.

        Raises ValueError for any other name.
        """
        checked_name("obstacle", obstacle, OBSTACLES)
        for each in self.contacts:
            if each.obstacle == obstacle:
                return each
        return None

    @property
    def tool(self) -> Tool:
        """The tool that was simulated.

        Raises:
            ValueError: if the parameters do not describe a tool.
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
