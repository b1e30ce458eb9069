"""The one place that knows which module draws runs: it stands above this layer, and is imported when a picture is requested."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle_sim.trajectory.trajectory import Trajectory

DRAWN_BY = "bristle_sim.render.of_run"


@dataclass(frozen=True, slots=True)
class Html:
    """What a notebook shows as HTML."""

    text: str

    def _repr_html_(self) -> str:
        return self.text


class Pictures(Protocol):
    """The functions of the module that draws runs."""

    def plot(self, run: Trajectory, until: float | None) -> Figure:
        """Draw a run up to an instant, s, or to the end of its story."""

    def film(
        self, run: Trajectory, path: str | Path, fps: float, size: tuple[int, int], options: Mapping[str, Any]
    ) -> Path:
        """Film a run, with frames a second and a size in px."""

    def view(self, run: Trajectory) -> Html:
        """Return the motion with a slider."""

    def summary_page(self, run: Trajectory) -> str:
        """Return the summary with a small drawing, as HTML."""


def drawn_by() -> Pictures:
    """Return the module that draws runs."""
    return cast(Pictures, import_module(DRAWN_BY))
