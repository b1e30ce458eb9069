"""The result of a simulation: sampled motion, events, contacts, stop reason and cost."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.declared import Choice
from bristle_sim.files import named_path
from bristle_sim.parameters import PARTS, Tool
from bristle_sim.settings import ABSENCES, EVENTS, OBSTACLE, StopReason
from bristle_sim.trajectory.interpolation import Interpolation
from bristle_sim.trajectory.pictures import Html, drawn_by
from bristle_sim.trajectory.records import ContactRecord, Cost, Event, Motion
from bristle_sim.trajectory.storage import read, write
from bristle_sim.trajectory.tables import to_dataframe, to_xarray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Largest ratio of error estimate to requested accuracy for which a run has no warning
EXCESS_SAID = 100.0
# Smallest extreme of the motion relative to the hub that is listed, as a fraction of the largest in
# the run
NOTABLE = 0.01

EVENTS_SHOWN = 6  # largest number of events in a summary

# Largest distance of a touch from a corner of the wire at which the corner counts as touched, divided
# by the wire's length
CORNER_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Trajectory(Motion):
    """The result of a run: the motion of one bristle at n samples, its events and its contacts, in
    SI units and radians.

    An impact has two samples at the same instant: one before it and one after it.

    Attributes:
        time, hub_angle, angles, ..., normal_force, hub_speed: see Motion; the arrays have n
            samples.
        events: events in order of time.
        contacts: contact records in order of time.
        stop_reason: reason why the run stopped.
        cost: cost of the run, and its error estimate.
        parameters: input of the simulation, as plain numbers and strings.
        stop_detail: explanation and remedy if a contact law could not resolve a contact; otherwise
            empty.
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
        """Return the time (s) of the first or the last event with a name; None without such an event.

        Args:
            name: name of the event.
            last: whether to return the last event instead of the first.
            before: latest time of the events considered, s.

        Raises:
            ValueError: if no event can have this name.
        """
        recorded = [event.name for event in self.events]
        known = dict.fromkeys((*EVENTS, *ABSENCES, *recorded))
        Choice("name", options=tuple(known)).check(name)
        times = [event.time for event in self.events if event.name == name and event.time <= before]
        return (times[-1] if last else times[0]) if times else None

    @property
    def notable_events(self) -> tuple[Event, ...]:
        """All events except small extremes of the motion relative to the hub.

        An extreme of retraction or relative speed is left out if it is smaller than 1 % of the
        largest value in the run. A bent wire, for example, swings by a tenth of a degree on the hub
        before it meets the bar.
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
        """Advice on a change of parameters after which the run would not stop early.

        Where friction is the cause, the advice names the friction parameter of the obstacle that
        was touched last.
        """
        at_bar = self.contacts and self.contacts[-1].obstacle == "bar"
        return self.stop_detail or self.stop_reason.remedy.format(
            friction="bar_friction" if at_bar else "friction"
        )

    @property
    def accuracy_not_reached(self) -> str:
        """A warning if the error estimate exceeds the requested accuracy more than a hundredfold.

        Otherwise the text is empty. If the estimate is valid for the whole run, the warning
        begins with "accuracy not reached". The estimate loses its validity at chatter, or at a
        touch whose speed is smaller than the error. The warning then begins with "error estimate".
        """
        estimate = self.cost.error_estimate
        requested = self.parameters.get("settings", {}).get("accuracy")
        if not estimate or not requested or estimate <= EXCESS_SAID * requested:
            return ""
        ratio = format(estimate / requested, ".0f" if estimate < 1e6 * requested else ".0e")
        start = "accuracy not reached: " if self.cost.holds_until is None else ""
        return (
            f"{start}error estimate {estimate:.1g}, {ratio} times the requested accuracy {requested:g};"
            " request a smaller accuracy"
        )

    def first_contact(self, obstacle: str) -> ContactRecord | None:
        """Return the first contact with an obstacle, or None if there is no such contact.

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

    def with_places(self, tool: Tool) -> Trajectory:
        """Return a copy in which the contacts with bar and workpart have ``point`` and ``place``.

        At the workpart the place is a corner of the centre line, at the bar it is the closest point
        of a straight segment. Of several such points, the point with the least g + T dv is taken.
        Here g is the gap of the point, T the duration of the run, and dv the difference of the
        point's normal velocity from the normal velocity in the contact record. ``tool`` is the tool
        that was simulated.
        """
        lines = self.centre_line @ (1.0, 1j)
        duration = float(self.time[-1] - self.time[0])
        contacts = []
        for contact in self.contacts:
            sample = int(abs(self.time - contact.time).argmin())
            corners = lines[sample]
            normals: Any = 1j
            if contact.obstacle == "workpart":
                places = corners[1:]
                gaps = abs(places.imag + tool.workpart_depth)
            elif tool.bar is not None and contact.obstacle == "bar":
                places = tool.bar.closest(corners)
                normals = places - complex(*tool.bar.centre)
                gaps = abs(normals)
                normals /= gaps
            else:
                contacts.append(contact)
                continue
            nearest = 0
            if places.size > 1:
                at_once = np.flatnonzero(self.time == self.time[sample])
                changes = abs(self.rates[at_once] - contact.rates_before).max(axis=1)
                velocity = self.centre_line_velocity[at_once[changes.argmin()]] @ (1.0, 1j)
                along = ((places - corners[:-1]) / np.diff(corners)).real
                moving = velocity[:-1] + along * np.diff(velocity)
                speeds = (np.conj(normals) * moving).real
                missed = gaps + duration * abs(speeds - contact.velocity_before[0])
                nearest = missed.argmin()
            place = complex(places[nearest])
            distances = abs(corners - place)
            corner = int(distances.argmin())
            name = "flank"
            if corner and distances[corner] <= CORNER_ROUNDING * tool.bristle.length:
                name = "tip" if corner == len(corners) - 1 else "knee"
            contacts.append(
                dataclasses.replace(contact, point=name, place=(place.real, place.imag))
            )
        return dataclasses.replace(self, contacts=tuple(contacts))

    def __repr__(self) -> str:
        """Return a text of five lines: samples, strike, events, stop reason and cost.

        If the requested accuracy was not reached, a sixth line says so.
        """
        first, last = (1e3 * float(instant) for instant in (self.time[0], self.time[-1]))
        contact = self.first_contact("workpart")
        strike = "none"
        if contact is not None:
            before, after = (
                math.hypot(*velocity)
                for velocity in (contact.velocity_before, contact.velocity_after)
            )
            speeds = (
                f"{contact.point or 'tip'} speed {before:.4g} m/s before and {after:.4g} m/s after"
            )
            strike = f"{contact.outcome} at {1e3 * contact.time:.4g} ms, {speeds}"
        lines = [
            f"Trajectory: {self.time.size} samples from {first:.4g} to {last:.4g} ms",
            f"strike: {strike}",
            *course_in_words(self),
            self.accuracy_not_reached,
        ]
        return "\n".join(filter(None, lines))

    def at(self, time: ArrayLike, *, side: str = "after") -> Motion:
        """Return the motion at one or several instants, interpolated between samples.

        :class:`Interpolation` states the accuracy.

        Args:
            time: instants (s), an array of any shape.
            side: at the instant of an impact, ``before`` for the state before the impact or
                ``after`` for the state after it.

        Raises:
            ValueError: for an instant outside the run, any other side, or a run whose samples all
                have the same instant.
        """
        return Interpolation(self, self.contacts)(time, side)

    def course(self, until: float = math.inf, points: int = 1500) -> Motion:
        """Return the motion for drawing, at every sample and at equally spaced instants.

        At the instant of an impact there are two entries: the state before the impact and the state
        after it.

        Args:
            until: last instant, s; by default the end of the run.
            points: number of equally spaced instants.

        Raises:
            ValueError: if ``until`` is not after the start of the run.
        """
        return Interpolation(self, self.contacts).course(until, points)

    def plot(self, *, until: float | None = None) -> Figure:
        """Return a figure of tool, tip path, retraction, speed and energy.

        ``until`` is the last time drawn, s; by default it is shortly after the tip has left the
        workpart.

        Raises:
            ValueError: if ``until`` is not after the start of the run, or all samples have the same
                instant.
        """
        figure: Figure = drawn_by().plot(self, until)
        return figure

    def animate(
        self,
        path: str | Path,
        *,
        fps: float = 30.0,
        size: tuple[int, int] = (640, 480),
        **options: Any,
    ) -> Path:
        """Write a film of the run as mp4 or gif, and return its path.

        Args:
            path: path of the film, with the suffix ``.mp4`` or ``.gif``.
            fps: frames per second.
            size: width and height, pixels.
            options: options of ``bristle_sim.render.tool_films.pass_film``.

        Raises:
            ValueError: for a file that cannot be written, an mp4 film without imageio-ffmpeg, or an
                option out of range.
            OSError: if the encoder fails.
        """
        written: Path = drawn_by().film(self, path, fps, size, options)
        return written

    def show(self) -> Html:
        """Return a view of the motion with a slider, for display in a notebook."""
        page: Html = drawn_by().view(self)
        return page

    def _repr_html_(self) -> str:
        return str(drawn_by().summary_page(self))

    # Functions from the modules of storage and tables, as methods of a run.
    to_dataframe = to_dataframe
    to_xarray = to_xarray
    save = write

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a trajectory from a file that :meth:`save` wrote.

        The name must be exactly that of the file; no suffix is added.

        Raises:
            OSError: if the file cannot be read.
            ValueError: for a file of any other kind.
        """
        return cls(**read(named_path(path)))


def course_in_words(run: Trajectory) -> list[str]:
    """Return three lines of text: the events, the stop reason and the cost of the run."""
    notable = run.notable_events
    events = ", ".join(
        f"{event.name} {1e3 * event.time:.4g} ms" for event in notable[:EVENTS_SHOWN]
    )
    more = f" and {len(notable) - EVENTS_SHOWN} more" if len(notable) > EVENTS_SHOWN else ""
    cost = run.cost
    error = "" if cost.error_estimate is None else f", error estimate {cost.error_estimate:.1e}"
    if cost.holds_until is not None:
        error += f" up to {1e3 * cost.holds_until:.4g} ms; later touches depend on the error itself"
    return [
        f"events: {events or 'none'}{more}",
        f"stopped: {run.stop_reason}",
        f"cost: {cost.steps} steps, {1e3 * cost.wall_s:.3g} ms{error}",
    ]
