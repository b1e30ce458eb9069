"""The audit: every printed number and decidable statement of chapters 2-4 of the dissertation, recomputed.

Rows come in the order of the chapters. Nothing is stored: each call computes all of them, the simulated pass once. As a
report they are rows for JSON, counts, and a table that reads on a terminal of 100 columns.
"""

from __future__ import annotations

import dataclasses
import textwrap
import time as clock
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

from bristle_sim.comparison import Quantity, Report, side_by_side
from bristle_sim.dissertation.audit_crater import crater_figures
from bristle_sim.dissertation.audit_force import force_figures
from bristle_sim.dissertation.audit_impact import impact_figures
from bristle_sim.dissertation.audit_row import DIFFERS, NOT_COMPUTABLE, REPRODUCED, AuditRow, Found, audit_row
from bristle_sim.dissertation.audit_tool import tool_figures
from bristle_sim.quantity import Declared, choice

WIDTH = 100
"""Columns of a terminal that the table fits in."""

PRINTED, COMPUTED, UNIT = 22, 12, 9
"""Columns of the table's narrow cells; the status is the last and the place takes the rest."""


@dataclass(frozen=True, slots=True)
class AuditView(Declared):
    """Which rows the table shows; the JSON always has them all."""

    show: str = choice(
        "all",
        "show",
        ("all", REPRODUCED, DIFFERS, NOT_COMPUTABLE),
        source="chosen: rows of the table on the terminal",
        meaning="which rows the table shows; the JSON has all",
    )


def audit_rows() -> tuple[AuditRow, ...]:
    """Return all rows of the audit (see AuditRow); numbers are finite, places unique."""
    text = resources.files("bristle_sim.dissertation").joinpath("audit.toml").read_text(encoding="utf-8")
    entries = tomllib.loads(text)["row"]
    figures = {**tool_figures(), **impact_figures(), **force_figures(), **crater_figures()}
    return tuple(audit_row(each, figures.get(each["where"], Found(None))) for each in entries)


def audit_report(view: AuditView) -> Report:
    """Recompute every printed number."""
    begin = clock.perf_counter()
    rows = audit_rows()
    counts = Counter(row.status for row in rows)
    names = {REPRODUCED: "rows_reproduced", DIFFERS: "rows_that_differ", NOT_COMPUTABLE: "rows_not_computable"}
    shown = [row for row in rows if view.show in ("all", row.status)]
    return Report(
        outcome=None,
        quantities=tuple(Quantity(name, "rows", float(counts[status])) for status, name in names.items()),
        wall_s=clock.perf_counter() - begin,
        remarks=("", terminal_table(shown)),
        extra={"rows": [dataclasses.asdict(row) for row in rows]},
        subject=rows,
    )


def shown_number(value: float | str | None) -> str:
    """Return the text of a cell: a statement as it is, a number with up to seven digits, a dash for nothing."""
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value:.7g}"


def terminal_table(rows: Sequence[AuditRow], width: int = WIDTH) -> str:
    """Return rows under each other: place, printed, computed, unit and status, and below them the reason, indented."""
    status = max(map(len, (REPRODUCED, DIFFERS, NOT_COMPUTABLE)))
    place = width - PRINTED - COMPUTED - UNIT - status - 8
    widths = (place, PRINTED, COMPUTED, UNIT, status)
    lines = [*_line(("where", "printed", "computed", "unit", "status"), widths), "-" * width]
    for row in rows:
        cells = (row.where, shown_number(row.printed), shown_number(row.computed), row.unit, row.status)
        lines += _line(cells, widths)
        lines += textwrap.wrap(row.why, width, initial_indent="    ", subsequent_indent="    ")
    return "\n".join(lines)


def _line(cells: Sequence[str], widths: Sequence[int]) -> list[str]:
    """Wrap each cell within its own column; numbers stand at the right."""
    return side_by_side([textwrap.wrap(*each) for each in zip(cells, widths, strict=True)], widths, right=(1, 2))
