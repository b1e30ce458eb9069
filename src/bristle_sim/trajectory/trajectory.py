"""The trajectory that a simulation returns: motion in samples, events, contacts, stop reason and
cost.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.trajectory.interpolation import Interpolation
from bristle_sim.trajectory.pictures import Html, drawn_by
from bristle_sim.trajectory.recorded_run import RecordedRun
from bristle_sim.trajectory.records import ContactRecord, Motion
from bristle_sim.trajectory.storage import read, write
from bristle_sim.trajectory.tables import summary, to_dataframe, to_xarray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Largest distance of a touch from a corner at which it is a touch of the corner, as a fraction of
# the piece's length.
CORNER_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Trajectory(RecordedRun):
    """The result of a run: the motion of one bristle at n samples, in SI units and radians.

    An impact has two samples at the same instant: before and after it.

    Attributes:
        time, hub_angle, angles, ..., normal_force, hub_speed: see Motion; arrays of n samples.
        events, contacts: in order of time.
        stop_reason: why the run stopped.
        cost: cost of the run.
        parameters: the simulation's parameters, as plain numbers and strings.
        stop_detail: why a contact law gave up, and the remedy; empty for any other stop.
    """

    def with_places(self, tool: Tool) -> Trajectory:
        """Return the trajectory with ``point`` and ``place`` set in its contacts with bar and
        workpart.
        """
        contacts = []
        for contact in self.contacts:
            line = self.centre_line[int(abs(self.time - contact.time).argmin())]
            contacts.append(
                located(contact, tool, line) if contact.obstacle in ("bar", "workpart") else contact
            )
        return dataclasses.replace(self, contacts=tuple(contacts))

    def at(self, time: ArrayLike, *, side: str = "after") -> Motion:
        """Return the motion at one or several instants, interpolated between samples.

        ``Interpolation`` states the accuracy.

        Args:
            time: instants, s, of any shape.
            side: ``before`` or ``after``: the state that is returned at the instant of an impact.

        Raises:
            ValueError: for an instant outside the run, another side, or a run of one instant.
        """
        return Interpolation(self)(time, side)

    def course(self, until: float = math.inf, points: int = 1500) -> Motion:
        """Return the motion for drawing, at every sample up to ``until`` (s) and at ``points``
        equally spaced instants.

        Two entries share the instant of an impact.

        Raises:
            ValueError: if ``until`` is not after the start of the run.
        """
        return Interpolation(self).course(until, points)

    def plot(self, *, until: float | None = None) -> Figure:
        """Draw tool, tip path, retraction, speed and energy up to the time ``until``, s."""
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
        """Write a film of the run, mp4 or gif, and return its path.

        ``size`` is in pixels. Options are those of ``bristle_sim.render.tool_films.pass_film``.
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
        """Read a trajectory from a file that :meth:`save` wrote, under exactly the same name.

        Raises:
            OSError: if the file cannot be read.
            ValueError: for a file of any other kind.
        """
        return cls(**read(Path(path)))


def located(contact: ContactRecord, tool: Tool, line: Array) -> ContactRecord:
    """Return the record of a contact with the point of the wire that is in contact.

    The point is the corner of the centre line at the workpart's surface, or the point of the centre
    line nearest to the bar's centre. ``line`` holds the corners of the centre line, shape (corners,
    2), m.
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
