"""Write what a scenario found as one HTML page that opens offline: answer, table, figures, motion, parameters, versions."""

from __future__ import annotations

import base64
import math
import platform
import re
from collections.abc import Callable, Sequence
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup

import bristle_sim
from bristle_sim.comparison import Report, cells
from bristle_sim.files import complete_or_absent
from bristle_sim.parameters import Tool
from bristle_sim.render.story import phases, story_end
from bristle_sim.render.style import MILLIMETRES
from bristle_sim.trajectory import Trajectory
from bristle_sim.units import Choice, Range

Parameter = tuple[Range | Choice, Any, Any]
"""A key's declaration, its value in this run, and its default."""

LIBRARIES = ("numpy", "scipy", "pymunk", "matplotlib")
"""Those whose version may change a digit or a line."""

MEDIA = {".png": "image/png", ".mp4": "video/mp4", ".gif": "image/gif"}


def write_report(
    path: Path,
    report: Report,
    *,
    name: str,
    question: str,
    command: str,
    parameters: Sequence[Parameter],
    plot: Callable[[Report, Path], None] | None = None,
    plot_is_folder: bool = False,
    video: Path | None = None,
) -> None:
    """Write a report as a page without any reference to other files, which appears only when complete.

    Name, question and parameters are the scenario's; the command makes the page again. ``plot`` draws the figure to a path,
    or all figures to a folder, and a remark says why where it cannot; ``video`` is a film that has been made. An interactive view shows the motion if the report's
    subject has a ``tool`` and a ``trajectory``.

    Raises:
        OSError: naming the file, if it cannot be written.
    """
    run, tool = getattr(report.subject, "trajectory", None), getattr(report.subject, "tool", None)
    figures, missing = list[Markup](), ""
    if plot is not None:
        try:
            figures = embedded_figures(report, plot, plot_is_folder)
        except ValueError as error:
            missing = f"no figure: {error}"
    content = {
        "name": name,
        "question": question,
        "command": command,
        "answer": report.answer or answer(report),
        "table": cells(report.quantities),
        "phases": report.phases,
        "remarks": [each for each in (*report.remarks, missing) if each],
        "parameters": [(declared, _shown(value), value == default) for declared, value, default in parameters],
        "figures": figures,
        "video": None if video is None else (_embedded(video), video.suffix.lower() == ".mp4"),
        "motion": motion_data(run, tool) if isinstance(run, Trajectory) and isinstance(tool, Tool) else None,
        "versions": {"bristle_sim": bristle_sim.__version__, "Python": platform.python_version()}
        | {library: metadata.version(library) for library in LIBRARIES},
    }
    loader, strict = jinja2.PackageLoader("bristle_sim.render", "."), jinja2.StrictUndefined
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=strict)
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    with complete_or_absent(path) as partial:
        partial.write_text(environment.get_template("report.html.jinja").render(content), encoding="utf-8")


def answer(report: Report) -> str:
    """Say in a sentence or two what came out: the outcome, what agrees, what does not, and the largest difference."""
    said = [] if report.outcome is None else [f"Outcome: {report.outcome}."]
    judged = [row for row in report.quantities if row.ok is not None]
    missed = [row.name for row in judged if not row.ok]
    if missed:
        said.append(f"{len(missed)} of {len(judged)} comparisons exceed their tolerance: {', '.join(missed)}.")
    elif judged:
        said.append(f"All {len(judged)} comparisons that have a tolerance are within it.")
    rows = [row for row in report.quantities if row.tolerance is None and row.relative_difference is not None]
    found = max(rows, key=lambda row: abs(row.relative_difference or 0.0), default=None)
    if found is not None and found.relative_difference:
        size = f"{100.0 * found.relative_difference:+.3g} % from {found.judge_name}"
        said.append(f"Of the findings, {found.name} differs most: {size}.")
    return " ".join(said) or "See the table."


def motion_data(run: Trajectory, tool: Tool) -> dict[str, Any]:
    """Return a pass as plain numbers for the interactive view: times in ms, lengths in mm, up to the end of its story.

    Positions and velocities of the centre line at every sample let the page interpolate by the cubics of
    ``trajectory.sampled_motion``; samples that share an instant, before and after an impact, stay apart.
    """
    shown = run.time <= story_end(run)
    rows = {
        "line": run.centre_line * MILLIMETRES,
        "velocity": run.centre_line_velocity,  # m/s are mm/ms
        "hub": run.hub_angle,
        "retraction": np.degrees(run.retraction),
        "force": run.normal_force,
    }
    bar, end = tool.bar, float(run.time[shown][-1])
    return {
        # To nanometres and nanoseconds, which keeps a page small.
        "time": np.round(1e3 * run.time[shown], 6).tolist(),
        **{name: np.round(row[shown].reshape(shown.sum(), -1), 6).tolist() for name, row in rows.items()},
        "hubRadius": tool.hub.radius * MILLIMETRES,
        "wire": tool.bristle.wire_diameter * MILLIMETRES,
        "bar": None if bar is None else [each * MILLIMETRES for each in (*bar.centre, bar.radius)],
        "surface": None if tool.workpart is None else -tool.workpart_depth * MILLIMETRES,
        "contacts": [
            [each.obstacle, 1e3 * each.time, 1e3 * each.duration, *(1e3 * part for part in each.impulse)]
            for each in run.contacts
            if each.time <= end
        ],
        "phases": [[1e3 * each.start, each.caption] for each in phases(run) if each.start <= end],
    }


def embedded_figures(report: Report, plot: Callable[[Report, Path], None], plot_is_folder: bool) -> list[Markup]:
    """Draw the figures as elements of the page: an SVG without its XML head, another picture by its bytes."""
    found = []
    with TemporaryDirectory() as folder:
        target = Path(folder)
        plot(report, target if plot_is_folder else target / "figure.svg")
        for path in sorted(target.iterdir()):
            if path.suffix == ".svg":
                drawing = path.read_text(encoding="utf-8")
                drawing = re.sub(r"<metadata>.*?</metadata>", "", drawing[drawing.index("<svg") :], flags=re.DOTALL)
                found.append(Markup(drawing))
            else:
                name = path.stem.replace("_", " ")
                found.append(Markup('<img src="{}" alt="{}">').format(_embedded(path), name))
    return found


def _embedded(path: Path) -> str:
    return f"data:{MEDIA[path.suffix.lower()]};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"


def _shown(value: Any) -> str:
    if isinstance(value, float) and math.isfinite(value):
        return f"{value:.6g}"
    return "none" if value is None else str(value)


def view_page(run: Trajectory) -> str:
    """Return a page of the motion alone, with its slider."""
    raise NotImplementedError
