"""The directive ``{keys}``: the keys of scenarios as a table, from the declarations that the command line reads."""

import re
import subprocess
import sys
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class KeysDirective(SphinxDirective):
    """Prints what ``--list-keys`` prints."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the list of a scenario's keys."""
        command = [sys.executable, "-m", "bristle_sim", self.arguments[0], "--list-keys"]
        text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        return [nodes.literal_block(text, re.sub(r"[ \t]+\n", "\n", text).rstrip(), language="text")]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("keys", KeysDirective)
    return {"parallel_read_safe": True}
