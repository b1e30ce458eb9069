"""The result of a simulation: sampled motion, events, contacts, stop reason and cost."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from bristle_sim.files import named_path
from bristle_sim.trajectory.interpolation import Interpolation
from bristle_sim.trajectory.pictures import Html, drawn_by
from bristle_sim.trajectory.recorded_run import RecordedRun
from bristle_sim.trajectory.records import Motion
from bristle_sim.trajectory.storage import read, write
from bristle_sim.trajectory.tables import summary, to_dataframe, to_xarray

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Trajectory(RecordedRun):
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

    def at(self, time: ArrayLike, *, side: str = "after") -> Motion:
        """Return the motion at one instant or several, interpolated between samples.

        :class:`Interpolation` states the accuracy.

        Args:
            time: instants (s), an array of any shape.
            side: at the instant of an impact, ``before`` for the state before it or ``after`` for
                the state after it.

        Raises:
            ValueError: for an instant outside the run, any other side, or a run whose samples all
                have the same instant.
        """
        return Interpolation(self)(time, side)

    def course(self, until: float = math.inf, points: int = 1500) -> Motion:
        """Return the motion for drawing, at every sample and at equally spaced instants.

        An impact has two entries of the same instant: before it and after it.

        Args:
            until: last instant, s; by default the end of the run.
            points: number of equally spaced instants.

        Raises:
            ValueError: if ``until`` is not after the start of the run.
        """
        return Interpolation(self).course(until, points)

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
    __repr__ = summary
    save = write

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a trajectory from a file that :meth:`save` wrote; the name must be exactly the same.

        Raises:
            OSError: if the file cannot be read.
            ValueError: for a file of any other kind.
        """
        return cls(**read(named_path(path)))
