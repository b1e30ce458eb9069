"""Write the audit as a Markdown page: ``python -m bristle_sim.render.audit_table media/audit.md``."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from itertools import groupby

from bristle_sim.dissertation.audit import DIFFERS, NOT_COMPUTABLE, REPRODUCED, AuditRow, audit_rows, shown_number
from bristle_sim.render.style import write_page

COMMAND = "python -m bristle_sim.render.audit_table media/audit.md"
CHAPTERS = {2: "The tool, cueing and impact", 3: "Force history", 4: "Crater"}


def markdown_page(rows: Sequence[AuditRow]) -> str:
    """Return all rows: first those that differ, each with its reason, then everything by chapter."""
    counts = Counter(row.status for row in rows)
    parts = [
        "# Every printed number, recomputed",
        f"{len(rows)} numbers and decidable statements of J. Zhang's dissertation (Marquette University, 2020), chapters 2"
        f" to 4: {counts[REPRODUCED]} are reproduced, {counts[DIFFERS]} differ, {counts[NOT_COMPUTABLE]} cannot be computed"
        " from the text. A number is reproduced when the computed one lies within half a unit of its last printed digit;"
        " where it was itself worked out from rounded ones, what their rounding can do is added.",
        f"Remade by `{COMMAND}`; as a table or JSON: `python scenarios/dissertation_audit.py`.",
        "## What differs",
        _table([row for row in rows if row.status == DIFFERS], with_status=False),
        "## Every row",
    ]
    for chapter, group in groupby(sorted(rows, key=chapter_of), key=chapter_of):
        parts += [f"### Chapter {chapter}: {CHAPTERS[chapter]}", _table(list(group), with_status=True)]
    return "\n\n".join(parts) + "\n"


def chapter_of(row: AuditRow) -> int:
    """Return the chapter that a place is in, by the first number in it; those of chapters 1 and 5 belong to chapter 2."""
    digits = next(word for word in row.where.split() if word[0].isdigit())
    return int(digits[0]) if digits[0] in "234" else 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page to the file named; ends with status 2 where that cannot be done."""
    page = markdown_page(audit_rows())
    return write_page(arguments, "audit_table", ".md", lambda path: path.write_text(page, encoding="utf-8"))


def _table(rows: Sequence[AuditRow], *, with_status: bool) -> str:
    heads = {
        "where": "---",
        "printed": "--:",
        "computed": "--:",
        "unit": "---",
        "status": "---",
        "why or remark": "---",
    }
    cells = [tuple(heads), tuple(heads.values())]
    for row in rows:
        numbers = (shown_number(row.printed), shown_number(row.computed), "" if row.unit == "1" else row.unit)
        cells.append((row.where, *numbers, row.status, row.why))
    lines = [line if with_status else (*line[:4], line[5]) for line in cells]
    plain = [[cell.replace("|", "\\|").replace("*", "\\*") for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in plain)


if __name__ == "__main__":
    sys.exit(main())
