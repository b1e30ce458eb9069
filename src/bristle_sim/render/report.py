"""HTML pages that open without a network connection.

The pages are the report of a scenario, a comparison of two passes, the motion of a run, and the
interactive page of a tool.
"""

from __future__ import annotations

import base64
import math
import platform
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jinja2
from markupsafe import Markup

from bristle_sim.comparison import Report, cells
from bristle_sim.declared import Declaration
from bristle_sim.files import complete_or_absent
from bristle_sim.parameters import Tool
from bristle_sim.render.motion_data import motion_data
from bristle_sim.render.pass_figure import pair_figure, pass_figure
from bristle_sim.render.style import OUTCOMES, save_figure
from bristle_sim.trajectory import Trajectory
from bristle_sim.version import __version__, named_commit

LIBRARIES = (
    "numpy",
    "scipy",
    "pymunk",
    "matplotlib",
)  # libraries whose versions a page states, since they may change its numbers or figures
BEFORE_UNIT = re.compile(
    r"(?<=\d) (?=(?:[mµnk]?(?:s|m|N|J|W|Hz|g)|m/s|rad/s|rpm|mN|µN|%|°|deg)\b|%|°)|(?<=N) (?=[sm]\b)"
)
"""Pattern of the space between a number and its unit, or within a unit such as N m."""

ALIGNED = re.compile(
    r"\S {3,}\S|\n"
)  # pattern of a plain-text table, which the page replaces by an HTML table
MEDIA = {".png": "image/png", ".mp4": "video/mp4", ".gif": "image/gif"}


def write_report(
    path: Path,
    report: Report,
    *,
    name: str,
    question: str,
    command: str,
    keys: Mapping[str, Declaration],
    values: Mapping[str, Any],
    plot: Callable[[Report, Path], None] | None = None,
    plot_is_folder: bool = False,
    video: Path | None = None,
) -> None:
    """Write a report as one HTML page that needs no other files.

    The file appears only when it is complete. If the report's subject has a ``tool`` and a
    ``trajectory``, the page shows the motion with a slider.

    Args:
        path: file of the page.
        report: the report.
        name: name of the scenario.
        question: question that the scenario answers.
        command: command line that produces the page.
        keys: declarations of the scenario's parameters, by key.
        values: values of these parameters, by key.
        plot: function that draws the report's figure to a path. If it fails, the page has a remark
            with the reason.
        plot_is_folder: whether ``plot`` draws several figures, to a folder.
        video: path of a film to include.

    Raises:
        OSError: if a file cannot be written. The message names the file.
    """
    figures = list[Markup]()
    missing = ""
    if plot is not None:
        try:
            figures = _figures(partial(plot, report), plot_is_folder, name.replace("_", " "))
        except ValueError as error:
            missing = f"no figure: {error}"
    rows: Sequence[Mapping[str, Any]] = report.extra.get("rows") or [{}]
    if "status" not in rows[0]:
        rows = []
    run = getattr(report.subject, "trajectory", None)
    tool = getattr(report.subject, "tool", None)
    motion = None
    if isinstance(run, Trajectory) and isinstance(tool, Tool):
        motion = motion_data(run, tool)
    content = {
        "name": name,
        "question": question,
        "command": command,
        "parameters": [(declared, values[key]) for key, declared in keys.items()],
        "figures": figures,
        "report": report,
        "colour": OUTCOMES.get(report.outcome_in_words, ""),
        "verdict": verdict(report),
        "table": cells(report.quantities),
        "rows": rows,
        "head": [key for key in rows[0] if any(row[key] not in (None, "") for row in rows)]
        if rows
        else [],
        "counts": Counter(row["status"] for row in rows),
        "remarks": [
            each
            for each in (*report.remarks, missing)
            if each and not (rows and ALIGNED.search(each))
        ],
        "video": None if video is None else (_embedded(video), video.suffix.lower() == ".mp4"),
        "motion": motion,
        "versions": {
            "bristle_sim": __version__,
            **named_commit(),
            "Python": platform.python_version(),
            **{library: metadata.version(library) for library in LIBRARIES},
        },
    }
    _write(path, "report.html.jinja", alone=False, **content)


def write_comparison(
    path: Path,
    names: Sequence[str],
    reports: Sequence[Report],
    **tables: Any,
) -> None:
    """Write the comparison of two passes as an HTML page.

    The file appears only when it is complete.

    Args:
        path: file of the page.
        names: names of the two tools.
        reports: reports of the two passes.
        tables: the contents of the comparison, by name. ``changed`` has a row (key and both values)
            for each parameter that differs. ``rows`` has a row (label, unit, both values and their
            difference) for each quantity. ``verdict`` is the result in a sentence.

    Raises:
        OSError: if the file cannot be written. The message names the file.
    """
    passes = []
    for name, report in zip(names, reports, strict=True):
        figure = pass_figure(report.subject.trajectory, report.subject.tool)
        passes.append((name, report.answer, *_figures(partial(save_figure, figure))))
    pair = pair_figure(names, [each.subject.trajectory for each in reports])
    both = _figures(partial(save_figure, pair))
    _write(path, "comparison.html.jinja", names=names, passes=passes, both=both, **tables)


def filled(template: str, **content: Any) -> str:
    """Fill a template file with content, and return the resulting text.

    Filters of the template prevent a line break between a number and its unit, and permit one after
    an underscore.
    """
    loader = jinja2.PackageLoader("bristle_sim.render", ".")
    strict = jinja2.StrictUndefined
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=strict)
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    environment.filters["shown"] = _shown
    environment.filters["bound"] = lambda text: BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", str(text))
    environment.filters["breakable"] = lambda name: Markup("_<wbr>").join(str(name).split("_"))
    return environment.get_template(template).render(content)


def _write(path: Path, template: str, **content: Any) -> None:
    with complete_or_absent(path) as partial:
        partial.write_text(filled(template, **content), encoding="utf-8")


def verdict(report: Report) -> str:
    """Return a sentence that states how many compared quantities are within their tolerance.

    The sentence also names the quantities outside their tolerance. It is empty if no quantity has a
    tolerance.
    """
    judged = [row for row in report.quantities if row.ok is not None]
    missed = [row.label for row in judged if not row.ok]
    if not judged:
        return ""
    said = f"Within their tolerance: {len(judged) - len(missed)} of {len(judged)} comparisons"
    return f"{said}; not: {', '.join(missed)}." if missed else f"{said}."


def _figures(
    plot: Callable[[Path], object], plot_is_folder: bool = False, name: str = "the run"
) -> list[Markup]:
    """Draw the figures of a report, and return them as HTML without external files.

    An SVG file becomes part of the page; any other picture is encoded in base64.

    Args:
        plot: function that draws one figure to a path, or several to a folder.
        plot_is_folder: whether ``plot`` draws to a folder.
        name: description of the figure for screen readers.
    """
    found = []
    with TemporaryDirectory() as folder:
        plot(Path(folder) if plot_is_folder else Path(folder) / "figure.svg")
        for path in sorted(Path(folder).iterdir()):
            if path.suffix == ".svg":
                drawing = path.read_text(encoding="utf-8").partition("<svg")[2]
                named = Markup('<svg role="img" aria-label="figure of {}"').format(name)
                found.append(named + Markup(drawing))
            else:
                words = path.stem.replace("_", " ")
                found.append(Markup('<img src="{}" alt="{}">').format(_embedded(path), words))
    return found


def _embedded(path: Path) -> str:
    return f"data:{MEDIA[path.suffix.lower()]};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"


def _shown(value: Any, absent: str = "none") -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and math.isfinite(value):
        return f"{value:.6g}"
    return absent if value is None else str(value)
