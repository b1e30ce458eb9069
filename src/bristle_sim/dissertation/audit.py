"""The audit: every printed number and decidable statement of the dissertation's chapters 2 to 4, recomputed.

Three rows are from chapters 1 and 5, which print the same quantities.

The rows are those of ``audit.toml``, with the expressions of their figures in the names of ``audit_values``. A number counts
as reproduced when the computed value lies within half a unit of the last printed digit. Where a printed number was itself
worked out from rounded ones, ``allowance`` adds what their rounding can do, and ``why`` says so. A statement in words has a
computed figure that decides whether it holds.
"""

from __future__ import annotations

import dataclasses
import math
import textwrap
import time as clock
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from importlib import resources
from typing import Any

from bristle_sim.comparison import WIDTH, Quantity, Report, side_by_side
from bristle_sim.units import Declared, choice

REPRODUCED, DIFFERS, NOT_COMPUTABLE = "reproduced", "differs", "not computable"

SLACK = 1e-9
"""Allowance for rounding where a value lies exactly half a unit away, as a fraction of the printed number."""

PRINTED, COMPUTED, UNIT = 22, 12, 9
"""Columns of the table's narrow cells; the status is the last and the place takes the rest."""


@dataclass(frozen=True, slots=True)
class AuditRow:
    """A printed number or statement and what the equations give.

    Attributes:
        where: place in the dissertation, unique.
        printed: the number, or the statement in words.
        unit: of printed and computed; ``1`` for none.
        computed: the figure, or None where nothing can be computed.
        formula: the expression that computes it, in the names of ``audit_values``; empty where nothing does.
        status: ``reproduced``, ``differs`` or ``not computable``.
        why: for ``differs`` the likeliest reason, with figures; else a remark, or empty.
        tolerance: largest difference that counts as reproduced; None for statements.
    """

    where: str
    printed: float | str
    unit: str
    computed: float | None
    formula: str
    status: str
    why: str = ""
    tolerance: float | None = None


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
    """Return all rows of the audit; numbers are finite, places unique."""
    from bristle_sim.dissertation import audit_values

    text = resources.files("bristle_sim.dissertation").joinpath("audit.toml").read_text(encoding="utf-8")
    return tuple(audit_row(each, vars(audit_values)) for each in tomllib.loads(text)["row"])


def audit_row(entry: Mapping[str, Any], names: Mapping[str, Any]) -> AuditRow:
    """Return the row of an entry of the table, its expressions evaluated with some names.

    Raises:
        ArithmeticError: if a figure is not finite.
    """

    def evaluated(key: str, x: float | None, default: str) -> Any:
        return eval(entry.get(key, default), {**names, "x": x})  # of the package's own table

    where, formula = entry["where"], entry.get("computed", "")
    figure = float(evaluated("computed", None, "")) if formula else None
    if figure is not None and not math.isfinite(figure):
        raise ArithmeticError(f"{where}: computed {figure:g}")
    told = evaluated("told", figure, "()")
    why = entry.get("why", "").format(*(told if isinstance(told, tuple) else (told,)))
    printed, tolerance, same = entry.get("statement", ""), None, False
    if "printed" in entry:
        printed = float(entry["printed"])
        tolerance = half_unit(entry["printed"]) + evaluated("allowance", figure, "0.0")
        same = figure is not None and abs(figure - printed) <= tolerance + SLACK * abs(printed)
    elif figure is not None:
        same = bool(evaluated("holds", figure, ""))
    status = NOT_COMPUTABLE if figure is None else REPRODUCED if same else DIFFERS
    return AuditRow(
        where, printed, entry.get("unit", "1"), figure, formula, status, why, None if figure is None else tolerance
    )


def half_unit(printed: str) -> float:
    """Return half a unit of the last digit of a number as printed, e.g. 0.5e-6 for ``1.619e-3``."""
    exponent = Decimal(printed).as_tuple().exponent
    assert isinstance(exponent, int)
    return 0.5 * 10.0**exponent


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
    return "-" if value is None else value if isinstance(value, str) else f"{value:.7g}"


def terminal_table(rows: Sequence[AuditRow], width: int = WIDTH) -> str:
    """Return rows under each other: place, printed, computed, unit and status, and below them the reason, indented."""
    status = max(map(len, (REPRODUCED, DIFFERS, NOT_COMPUTABLE)))
    widths = (width - PRINTED - COMPUTED - UNIT - status - 8, PRINTED, COMPUTED, UNIT, status)

    def line(*cells: str) -> list[str]:
        return side_by_side([textwrap.wrap(*each) for each in zip(cells, widths, strict=True)], widths, right=(1, 2))

    lines = [*line("where", "printed", "computed", "unit", "status"), "-" * width]
    for row in rows:
        lines += line(row.where, shown_number(row.printed), shown_number(row.computed), row.unit, row.status)
        lines += textwrap.wrap(row.why, width, initial_indent="    ", subsequent_indent="    ")
    return "\n".join(lines)
