"""Write the audit as a Markdown page: ``python -m bristle_sim.render.audit_table media/audit.md``."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence

import jinja2

from bristle_sim.dissertation.audit import AuditRow, audit_rows, shown_number
from bristle_sim.render.style import write_page

CHAPTERS = {2: "The tool, cueing and impact", 3: "Force history", 4: "Crater"}


def markdown_page(rows: Sequence[AuditRow]) -> str:
    """Return all rows: first those that differ, each with its reason, then everything by chapter."""
    environment = jinja2.Environment(loader=jinja2.PackageLoader("bristle_sim.render", "."), keep_trailing_newline=True)
    environment.filters["number"] = shown_number
    environment.filters["plain"] = lambda text: text.replace("|", "\\|").replace("*", "\\*")
    by_chapter = {number: [row for row in rows if chapter_of(row) == number] for number in CHAPTERS}
    count = Counter(row.status for row in rows)
    page = environment.get_template("audit.md.jinja")
    return page.render(rows=rows, count=count, chapters=CHAPTERS, by_chapter=by_chapter)


def chapter_of(row: AuditRow) -> int:
    """Return the chapter that a place is in, by the first number in it; those of chapters 1 and 5 belong to chapter 2."""
    digits = next(word for word in row.where.split() if word[0].isdigit())
    return int(digits[0]) if digits[0] in "234" else 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page to the file named; ends with status 2 where that cannot be done."""
    page = markdown_page(audit_rows())
    return write_page(arguments, "audit_table", ".md", lambda path: path.write_text(page, encoding="utf-8"))


if __name__ == "__main__":
    sys.exit(main())
