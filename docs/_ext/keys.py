"""The directive ``{keys}``: the keys of scenarios as a table, from the declarations that the command line reads."""

import contextlib
import io
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from tables import table_node

from bristle_sim.cli import command

HEAD = ("key", "default", "unit", "range")


class KeysDirective(SphinxDirective):
    """Shows the list of ``--list-keys`` as a table."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the table of a scenario's keys."""
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            command.main([self.arguments[0], "--list-keys"])
        head, _, _, *lines = printed.getvalue().splitlines()
        starts = [head.index(word) for word in HEAD]
        rows: list[list[str]] = []
        for line in lines:
            if not line.startswith(" "):
                parts = zip(starts, [*starts[1:], None], strict=True)
                rows.append([line[begin:end].strip() for begin, end in parts] + [""])
            elif line[: starts[-1]].strip():
                rows[-1][4] = f"{rows[-1][4]} {line.strip()}".strip()
            else:
                rows[-1][3] += f" {line.strip()}"
        return [table_node((*HEAD, "meaning (source of the default)"), rows, numbers=(1,))]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("keys", KeysDirective)
    return {"parallel_read_safe": True}
