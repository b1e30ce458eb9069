"""The trajectory that a simulation returns: samples in time, events, contacts, the reason to stop and the cost."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import PARTS, Tool
from bristle_sim.stop_reason import ABSENCES, EVENTS, OBSTACLES, StopReason, checked_name
from bristle_sim.trajectory.interpolation import Interpolation
from bristle_sim.trajectory.pictures import Html, drawn_by
from bristle_sim.trajectory.records import ContactRecord, Cost, Event, Motion, WireMotion
from bristle_sim.trajectory.storage import read, write
from bristle_sim.trajectory.tables import summary, to_dataframe, to_xarray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTABLE = 0.01  # extremes of the relative motion below this fraction of the largest are not worth a mention


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Trajectory(Motion):
    """A run of one mechanism: the motion at n samples, in SI units and radians.

    At an impact two samples share one instant: before and after it.

    Attributes:
        time, hub_angle, angles, ..., normal_force, hub_speed: see Motion; arrays of n samples.
        events, contacts: in order of time.
        stop_reason: why the run stopped; its ``advice`` says what would let it go further.
        cost: see Cost.
        parameters: of the simulation, as plain numbers and words.
        stop_detail: the reason and remedy of a contact law that gave up; empty for any other stop.
        inner_samples: motion between the samples of sustained contacts, for ``at``; None where there is none.
    """

    events: tuple[Event, ...]
    contacts: tuple[ContactRecord, ...]
    stop_reason: StopReason
    cost: Cost
    parameters: dict[str, Any] = field(default_factory=dict)
    stop_detail: str = ""
    inner_samples: WireMotion | None = None

    def event_time(self, name: str, *, last: bool = False, before: float = math.inf) -> float | None:
        """Return the time of the first (or last) event of that name at or before an instant, s; None if there is none.

        Raises ValueError if no run has an event of that name.
        """
        recorded = [event.name for event in self.events]
        name = checked_name("name", name, dict.fromkeys((*EVENTS, *ABSENCES, *recorded)))
        times = [event.time for event in self.events if event.name == name and event.time <= before]
        return (times[-1] if last else times[0]) if times else None

    @property
    def notable_events(self) -> tuple[Event, ...]:
        """Events but for extremes of the motion relative to the hub below a hundredth of the largest in the run.

        A bent wire that the hub carries along swings by a tenth of a degree before it meets the bar.
        """
        extremes = {"largest retraction": self.relative_angle, "highest relative speed": self.relative_rate}
        found = []
        for event in self.events:
            size = np.abs(extremes.get(event.name, np.ones_like(self.time)))
            if np.interp(event.time, self.time, size) >= NOTABLE * size.max():
                found.append(event)
        return tuple(found)

    @property
    def stop_advice(self) -> str:
        """The remedy that lets the run go further, in terms of the obstacle touched last."""
        return self.stop_detail or self.stop_reason.advice(self.contacts[-1].obstacle if self.contacts else None)

    def first_contact(self, obstacle: str) -> ContactRecord | None:
        """Return the first contact with ``bar``, ``workpart`` or ``wire``; None if there is none.

        Raises ValueError for any other name.
        """
        checked_name("obstacle", obstacle, OBSTACLES)
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
            "retraction (rad)": self.retraction,
            "tip_x (m)": self.tip[:, 0],
            "tip_y (m)": self.tip[:, 1],
            "tip_velocity_x (m/s)": self.tip_velocity[:, 0],
            "tip_velocity_y (m/s)": self.tip_velocity[:, 1],
            "tip_speed (m/s)": self.tip_speed,
            "kinetic_energy (J)": self.kinetic_energy,
            "potential_energy (J)": self.potential_energy,
            "normal_force (N)": self.normal_force,
        }

    @property
    def tool(self) -> Tool:
        """The tool that was simulated. Raises ValueError if the parameters do not describe one."""
        try:
            parts = self.parameters["tool"]
            built = {name: None if parts[name] is None else kinds[0](**parts[name]) for name, kinds in PARTS.items()}
            return Tool(**{**parts, **built})
        except (KeyError, TypeError) as error:
            raise ValueError(f"parameters: must describe the tool that was simulated ({error})") from error

    def at(self, time: ArrayLike, *, side: str = "after") -> Motion:
        """Return the motion at one instant or several, between samples too; see Interpolation for its accuracy.

        Args:
            time: s, of any shape.
            side: ``before`` or ``after``, which of the two states at the instant of an impact.

        Raises ValueError for an instant outside the run, another side, or a run of one instant.
        """
        return Interpolation(self)(time, side)

    def course(self, until: float = math.inf, points: int = 1500) -> Motion:
        """Return the motion up to an instant at every sample and at ``points`` further instants, evenly spaced, to draw it.

        Two entries share the instant of an impact. Raises ValueError if ``until`` (s) is not after the run's start.
        """
        return Interpolation(self).course(until, points)

    def plot(self, *, until: float | None = None) -> Figure:
        """Draw tool, tip path, retraction, speed and energy; ``until`` is the last instant shown, s."""
        figure: Figure = drawn_by().plot(self, until)
        return figure

    def animate(
        self, path: str | Path, *, fps: float = 30.0, size: tuple[int, int] = (640, 480), **options: Any
    ) -> Path:
        """Film the run to an mp4 or gif file of a size in px; options are those of ``bristle_sim.render.tool_films.pass_film``."""
        written: Path = drawn_by().film(self, path, fps, size, options)
        return written

    def show(self) -> Html:
        """Return the motion with a slider, which a notebook shows."""
        page: Html = drawn_by().view(self)
        return page

    def _repr_html_(self) -> str:
        return str(drawn_by().summary_page(self))

    # A function of the run, in the file of its concern, is its method.
    to_dataframe = to_dataframe
    to_xarray = to_xarray
    __repr__ = summary
    save = write

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a file written by :meth:`save`, by the same name.

        Raises:
            OSError: if there is no such file or it cannot be read.
            ValueError: for any other file.
        """
        return cls(**read(Path(path)))
