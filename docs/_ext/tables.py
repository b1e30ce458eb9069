"""Tables of text cells as nodes of a page, which scrolls them where they are wide."""

from collections.abc import Sequence

from docutils import nodes


def table_node(
    head: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: Sequence[int] = ()
) -> nodes.table:
    """Return a table; the columns whose positions are in ``numbers`` stand at the right."""
    group = nodes.tgroup(cols=len(head))
    group += [nodes.colspec(colwidth=1) for _ in head]
    group += nodes.thead("", _row(head, numbers))
    group += nodes.tbody("", *(_row(row, numbers) for row in rows))
    return nodes.table("", group, classes=["made"])


def _row(cells: Sequence[str], numbers: Sequence[int]) -> nodes.row:
    row = nodes.row()
    for column, text in enumerate(cells):
        row += nodes.entry(
            "", nodes.paragraph(text=text), classes=["text-right"] if column in numbers else []
        )
    return row
