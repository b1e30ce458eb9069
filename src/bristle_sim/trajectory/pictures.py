"""Picture and film of a trajectory: the one place that calls the layer which draws, and only when a picture is requested."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bristle_sim.trajectory.trajectory import Trajectory


def plot(run: Trajectory, *, until: float | None = None) -> Figure:
    """Draw tool, tip path, retraction, speed and energy; ``until`` is the last instant shown, s."""
    from bristle_sim.render.pass_figure import pass_figure

    return pass_figure(run, run.tool, until=until)


def animate(run: Trajectory, path: str | Path, **options: Any) -> Path:
    """Film the run to an mp4 or gif file; options are those of ``bristle_sim.render.pass_video.pass_video``."""
    from bristle_sim.render.pass_video import pass_video

    return pass_video(run, run.tool, path, **options)
