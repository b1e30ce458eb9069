"""Write the comparison of two tools as one HTML page that opens offline: answers, keys, numbers and pictures one above the other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import jinja2

from bristle_sim.comparison import Report
from bristle_sim.files import complete_or_absent
from bristle_sim.render.pass_figure import pass_figure
from bristle_sim.render.report import embedded_figures
from bristle_sim.render.style import save_figure


def write_comparison(
    path: Path,
    names: Sequence[str],
    reports: Sequence[Report],
    changed: Sequence[Sequence[str]],
    rows: Sequence[Sequence[str]],
) -> None:
    """Write the page; it appears only when complete.

    Args:
        path: of the page.
        names, reports: of the two passes.
        changed: key and both values of each key that differs.
        rows: label, unit, both values and the difference of each number.

    Raises:
        OSError: naming the file, if it cannot be written.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("bristle_sim.render", "."), autoescape=True, undefined=jinja2.StrictUndefined
    )

    def plot(report: Report, target: Path) -> None:
        save_figure(pass_figure(report.subject.trajectory, report.subject.tool), target)

    passes = [
        (name, each.answer, *embedded_figures(each, plot, False)) for name, each in zip(names, reports, strict=True)
    ]
    page = environment.get_template("comparison.html.jinja").render(
        names=names, passes=passes, changed=changed, rows=rows
    )
    with complete_or_absent(path) as partial:
        partial.write_text(page, encoding="utf-8")
