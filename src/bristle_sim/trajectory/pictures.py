"""Picture and film of a trajectory: the one place that calls the layer which draws, and only when a picture is requested."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure  # noqa: PLC0414 (trajectory.py annotates with it)

    from bristle_sim.trajectory.trajectory import Trajectory

__all__ = ["animate", "plot"]


def plot(run: Trajectory, until: float | None) -> Figure:
    """Draw a run as the scenarios' ``--plot`` does."""
    from bristle_sim.render.pass_figure import pass_figure

    return pass_figure(run, run.tool, until=until)


def animate(run: Trajectory, path: str | Path, **options: Any) -> Path:
    """Film a run as the scenarios' ``--video`` does."""
    from bristle_sim.render.pass_video import pass_video

    return pass_video(run, run.tool, path, **options)
