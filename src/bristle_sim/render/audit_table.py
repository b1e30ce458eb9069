"""Write the audit as a Markdown page: ``python -m bristle_sim.render.audit_table media/audit.md``."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from itertools import groupby

from bristle_sim.dissertation.audit import DIFFERS, NOT_COMPUTABLE, REPRODUCED, AuditRow, audit_rows, shown_number
from bristle_sim.files import complete_or_absent
from bristle_sim.render.style import checked_target

COMMAND = "python -m bristle_sim.render.audit_table media/audit.md"
CHAPTERS = {2: "The tool, cueing and impact", 3: "Force history", 4: "Crater"}


def markdown_page(rows: Sequence[AuditRow]) -> str:
    """Return all rows: first those that differ, each with its reason, then everything by chapter."""
    differing = [row for row in rows if row.status == DIFFERS]
    parts = [
        "# Every printed number, recomputed",
        _summary(rows),
        f"Remade by `{COMMAND}`; as a table or JSON: `python scenarios/dissertation_audit.py`.",
        "## What differs",
        _table(differing, with_status=False),
        "## Every row",
    ]
    for chapter, group in groupby(sorted(rows, key=chapter_of), key=chapter_of):
        parts += [f"### Chapter {chapter}: {CHAPTERS[chapter]}", _table(list(group), with_status=True)]
    return "\n\n".join(parts) + "\n"


def _summary(rows: Sequence[AuditRow]) -> str:
    counts = Counter(row.status for row in rows)
    return (
        f"{len(rows)} numbers and decidable statements of J. Zhang's dissertation (Marquette University, 2020), chapters 2"
        f" to 4: {counts[REPRODUCED]} are reproduced, {counts[DIFFERS]} differ, {counts[NOT_COMPUTABLE]} cannot be computed"
        " from the text. A number is reproduced when the computed one lies within half a unit of its last printed digit;"
        " where it was itself worked out from rounded ones, what their rounding can do is added."
    )


def chapter_of(row: AuditRow) -> int:
    """Return the chapter that a place is in, by the first number in it; those of chapters 1 and 5 belong to chapter 2."""
    digits = next(word for word in row.where.split() if word[0].isdigit())
    return int(digits[0]) if digits[0] in "234" else 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page to the file named; ends with status 2 where that cannot be done."""
    parser = argparse.ArgumentParser(prog="python -m bristle_sim.render.audit_table", description=__doc__)
    parser.add_argument("target", metavar="FILE.md")
    try:
        target = checked_target(parser.parse_args(arguments).target, (".md",))
    except ValueError as error:
        print(f"{parser.prog}: error: {error}", file=sys.stderr)
        return 2
    page = markdown_page(audit_rows())
    with complete_or_absent(target) as partial:
        partial.write_text(page, encoding="utf-8")
    return 0


def _table(rows: Sequence[AuditRow], *, with_status: bool) -> str:
    head = ["where", "printed", "computed", "unit", *(["status"] if with_status else []), "why or remark"]
    lines = [_row(head), _row(["---", "--:", "--:", "---", *(["---"] if with_status else []), "---"])]
    for row in rows:
        status = [row.status] if with_status else []
        unit = "" if row.unit == "1" else row.unit
        lines.append(_row([row.where, shown_number(row.printed), shown_number(row.computed), unit, *status, row.why]))
    return "\n".join(lines)


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|").replace("*", "\\*") for cell in cells) + " |"


if __name__ == "__main__":
    sys.exit(main())
