"""The trajectory that a simulation returns: samples in time, events, contacts, stop reason and cost."""

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

CORNER_ROUNDING = 1e-9  # of a piece's length: a touch nearer to its end is one of the corner


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Trajectory(RecordedRun):
    """The result of a run: the motion of one bristle at n samples, in SI units and radians.

    An impact has two samples at the same instant: before and after it.

    Attributes:
        time, hub_angle, angles, ..., normal_force, hub_speed: see Motion; arrays of n samples.
        events, contacts: in order of time.
        stop_reason, cost: why the run stopped, and its cost.
        parameters: the simulation's parameters, as plain numbers and strings.
        stop_detail: why a contact law gave up, and the remedy; empty for any other stop.
        inner_samples: motion between the samples in sustained contact, used by ``at``; None without any.
    """

    def with_places(self, tool: Tool) -> Trajectory:
        """Return the trajectory with ``point`` and ``place`` of each contact of this tool's wire with the bar or the workpart."""
        contacts = []
        for contact in self.contacts:
            line = self.centre_line[int(abs(self.time - contact.time).argmin())]
            contacts.append(
                located(contact, tool, line) if contact.obstacle in ("bar", "workpart") else contact
            )
        return dataclasses.replace(self, contacts=tuple(contacts))

    def at(self, time: ArrayLike, *, side: str = "after") -> Motion:
        """Return the motion at one or several instants, interpolated between samples; see Interpolation for its accuracy.

        Args:
            time: s, of any shape.
            side: ``before`` or ``after``: which of the two states to return at the instant of an impact.

        Raises ValueError for an instant outside the run, another side, or a run of one instant.
        """
        return Interpolation(self)(time, side)

    def course(self, until: float = math.inf, points: int = 1500) -> Motion:
        """Return the motion for drawing: at every sample up to ``until`` and at ``points`` more instants, evenly spaced.

        Two entries share the instant of an impact. Raises ValueError if ``until`` (s) is not after the run's start.
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
        """Write a film of the run, mp4 or gif, ``size`` in px; for options see ``bristle_sim.render.tool_films.pass_film``."""
        written: Path = drawn_by().film(self, path, fps, size, options)
        return written

    def show(self) -> Html:
        """Return a view of the motion with a slider, for display in a notebook."""
        page: Html = drawn_by().view(self)
        return page

    def _repr_html_(self) -> str:
        return str(drawn_by().summary_page(self))

    # These functions of a run are its methods; each stands in the file of its concern.
    to_dataframe = to_dataframe
    to_xarray = to_xarray
    __repr__ = summary
    save = write

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a file written by :meth:`save`, under exactly the same name; raises OSError, or ValueError for any other file."""
        return cls(**read(Path(path)))


def located(contact: ContactRecord, tool: Tool, line: Array) -> ContactRecord:
    """Return a record with the point in contact of the wire's centre line, of shape (corners, 2), m.

    It is the corner at the workpart's surface, or the point nearest to the bar's centre.
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
