"""The audit: every number printed in chapters 2 to 4, and every statement that can be checked.

Three rows are numbers of chapters 1 and 5, which print the same quantities again. ``printed.toml``
holds the printed numbers and statements. The modules ``audit_chapter_2`` and ``audit_chapters_3_4``
compute the values. Where a value differs from print, they also give the likeliest reason.

A number counts as reproduced if the computed value differs from it by at most half a unit of the
last printed digit. If the printed number was itself computed from rounded numbers, the effect of
their rounding is added to this tolerance, and the remark on the number says so. A statement in
words is checked by a computed value.
"""

from __future__ import annotations

import dataclasses
import math
import textwrap
import time as clock
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import zip_longest

from bristle_sim.comparison import Quantity, Report
from bristle_sim.declared import Declared
from bristle_sim.dissertation.printed import Figure, Printed, printed_rows
from bristle_sim.fields import choice
from bristle_sim.readable import WIDTH, aligned, amount

REPRODUCED = "reproduced"
DIFFERS = "differs"
NOT_COMPUTABLE = "not computable"

SLACK = 1e-9
"""Tolerance for rounding error, as a fraction of the printed number.

It admits a computed value that differs by exactly half a unit of the last printed digit."""

PRINTED = 22
COMPUTED = 12
UNIT = 9
"""Widths of the columns ``printed``, ``computed`` and ``unit`` of the table, in characters.

The column ``status`` is as wide as its longest word; the column ``where`` takes the rest."""


@dataclass(frozen=True, slots=True)
class AuditRow:
    """The result of the audit for one printed number or statement.

    Attributes:
        where: place of the number or statement in the dissertation.
        printed: the printed number, or the statement in words.
        unit: unit of the printed and of the computed number.
        computed: the value computed from the equations; None if it cannot be computed.
        status: ``reproduced``, ``differs`` or ``not computable``.
        why: the likeliest reason for a difference. Without a difference, it is a remark or empty.
        tolerance: largest difference that counts as reproduced. It is None for a statement, or if
            there is no computed value.
    """

    where: str
    printed: float | str
    unit: str
    computed: float | None
    status: str
    why: str = ""
    tolerance: float | None = None


@dataclass(frozen=True, slots=True)
class AuditView(Declared):
    """The choice, by status, of the rows that the table on the terminal shows.

    The JSON output always has all rows.
    """

    show: str = choice(
        "show: which rows the table shows; the JSON has all [chosen: rows of the table on the terminal]",
        *("all", REPRODUCED, DIFFERS, NOT_COMPUTABLE),
    )


def audit_rows() -> tuple[AuditRow, ...]:
    """Return the rows of the audit, one for each printed number or statement."""
    from bristle_sim.dissertation import audit_chapter_2 as impact
    from bristle_sim.dissertation import audit_chapters_3_4 as force

    figures = {
        **impact.tool_figures(),
        **impact.bar_figures(),
        **impact.pass_figures(),
        **impact.compression_figures(),
        **impact.restitution_figures(),
        **impact.pendulum_figures(),
        **force.ball_force_figures(),
        **force.segment_figures(),
        **force.bristle_force_figures(),
        **force.motion_figures(),
        **force.cutting_figures(),
        **force.plies_figures(),
        **force.energy_figures(),
    }
    return tuple(audit_row(row, figures[where]) for where, row in printed_rows().items())


def audit_row(row: Printed, figure: Figure | float) -> AuditRow:
    """Compare a printed number or statement with its computed value.

    Args:
        row: the printed number or statement.
        figure: the computed value.

    Raises:
        ArithmeticError: if the computed value is not finite.
    """
    if not isinstance(figure, Figure):
        figure = Figure(figure)
    printed = float(row.printed) if row.printed else row.statement
    if figure.value is None:
        return AuditRow(row.where, printed, row.unit, None, NOT_COMPUTABLE, figure.why)
    computed = float(figure.value)
    if not math.isfinite(computed):
        raise ArithmeticError(f"{row.where}: computed {computed:g}")
    tolerance = None
    same = figure.holds
    if isinstance(printed, float):
        tolerance = half_unit(row.printed) + figure.allowance
        same = abs(computed - printed) <= tolerance + SLACK * abs(printed)
    status = REPRODUCED if same else DIFFERS
    return AuditRow(row.where, printed, row.unit, computed, status, figure.why, tolerance)


def half_unit(printed: str) -> float:
    """Return half a unit of the last digit of a printed number, e.g. 0.5e-6 for ``1.619e-3``."""
    exponent = Decimal(printed).as_tuple().exponent
    assert isinstance(exponent, int)
    return 0.5 * 10.0**exponent


def audit_report(view: AuditView) -> Report:
    """Recompute all printed numbers and statements, and return the report of the audit.

    ``view`` selects the rows of the table on the terminal.
    """
    begin = clock.perf_counter()
    rows = audit_rows()
    counts = Counter(row.status for row in rows)
    shown = [row for row in rows if view.show in ("all", row.status)]
    return Report(
        outcome=None,
        quantities=(
            Quantity("rows_reproduced", "rows", float(counts[REPRODUCED])),
            Quantity("rows_that_differ", "rows", float(counts[DIFFERS])),
            Quantity("rows_not_computable", "rows", float(counts[NOT_COMPUTABLE])),
        ),
        wall_s=clock.perf_counter() - begin,
        remarks=("", terminal_table(shown)),
        extra={"rows": [dataclasses.asdict(row) for row in rows]},
        subject=rows,
        answer=_answer(rows, counts),
    )


def _answer(rows: Sequence[AuditRow], counts: Counter[str]) -> str:
    """Return a sentence with the number of rows of each status.

    The sentence also names the number whose computed value has the largest relative difference from
    the printed one.
    """
    _, where, numbers = max(
        (
            abs(row.computed / row.printed - 1.0),
            row.where,
            f"printed {amount(row.printed, row.unit)}, computed {amount(row.computed, row.unit)}",
        )
        for row in rows
        if row.status == DIFFERS and isinstance(row.printed, float) and row.computed
    )
    return (
        f"{counts[REPRODUCED]} of {len(rows)} printed numbers and statements are reproduced,"
        f" {counts[DIFFERS]} differ and {counts[NOT_COMPUTABLE]} cannot be computed; farthest off is"
        f" {where}, {numbers}."
    )


def shown_number(value: float | str | None) -> str:
    """Return the text of a table cell.

    A number has up to seven digits. A statement is unchanged. None becomes a dash.
    """
    return "-" if value is None else value if isinstance(value, str) else f"{value:.7g}"


def terminal_table(rows: Sequence[AuditRow]) -> str:
    """Return the rows as a text table; the remark ``why`` stands below its row, indented."""
    status = max(map(len, (REPRODUCED, DIFFERS, NOT_COMPUTABLE)))
    widths = (WIDTH - PRINTED - COMPUTED - UNIT - status - 8, PRINTED, COMPUTED, UNIT, status)

    def line(*cells: str) -> list[str]:
        """Return the lines of text of one table row, whose cells are wrapped to their columns."""
        wrapped = (textwrap.wrap(*each) for each in zip(cells, widths, strict=True))
        return aligned(list(zip_longest(*wrapped, fillvalue="")), (0, 3, 4), widths)

    lines = [*line("where", "printed", "computed", "unit", "status"), "-" * WIDTH]
    for row in rows:
        lines += line(
            row.where, shown_number(row.printed), shown_number(row.computed), row.unit, row.status
        )
        lines += textwrap.wrap(row.why, WIDTH, initial_indent="    ", subsequent_indent="    ")
    return "\n".join(lines)
