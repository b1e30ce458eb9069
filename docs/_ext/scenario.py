"""The directive ``{scenario}``: run a scenario while the site is built, and show its command, its answer, its picture and its table.

    ```{scenario} cue_and_impact
    :set: friction=0.4 hub_speed=3000rpm
    :show: command answer table picture
    ```

A scenario that takes longer than a build may is shown from the files in ``docs/kept``, which ``python docs/keep.py`` makes anew.
With ``-D nb_execution_mode=off`` no scenario and no example runs, and their results are left out.
"""

import contextlib
import io
import json
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from tables import table_node

from bristle_sim.cli import command
from bristle_sim.cli.scenario import load_scenario, script_paths
from bristle_sim.comparison import Quantity, cells

GIVEN = ("name", "unit", "simulated", "theory", "reference", "printed", "tolerance", "label")
"""The fields of a quantity in JSON that the others follow from."""

LEFT_OUT = ("tolerance", "formula")
"""Columns of judged rows that JSON keeps for programs."""


def run_scenario(name: str, assignments: list[str], folder: Path) -> dict[str, Any]:
    """Run a scenario in a folder and return its JSON, with its printed table and its picture's file, if it has one.

    It runs in this process, which has the libraries loaded already; loading them takes as long as most scenarios.

    Raises:
        RuntimeError: if the scenario refuses its input.
    """
    stem = "_".join([name, *assignments]).replace("=", "_").replace("/", "_")
    options = [part for each in assignments for part in ("--set", each)]
    drawn = load_scenario(script_paths()[name]).plot is not None
    options += ["--json", f"{stem}.json"] + (["--plot", f"{stem}.png"] if drawn else [])
    printed = io.StringIO()
    said = io.StringIO()
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(printed),
        contextlib.redirect_stderr(said),
    ):
        status = command.main([name, *options])
    if status not in (0, command.MISSED):
        raise RuntimeError(said.getvalue().strip())
    found: dict[str, Any] = json.loads((folder / f"{stem}.json").read_text(encoding="utf-8"))
    return found | {
        "printed": printed.getvalue(),
        "picture": f"{stem}.png" if drawn else None,
        "status": status,
    }


class ScenarioDirective(SphinxDirective):
    """Shows a scenario as it was run for this page."""

    required_arguments = 1
    option_spec = {  # noqa: RUF012 - docutils reads it from the class
        "set": directives.unchanged,
        "show": directives.unchanged,
        "alt": directives.unchanged,
        "kept": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        """Return the requested parts."""
        name = self.arguments[0]
        assignments = self.options.get("set", "").split()
        parts = self.options.get("show", "command answer picture table").split()
        target = Path(self.env.app.outdir).parent / "scenarios"
        target.mkdir(parents=True, exist_ok=True)
        if "kept" in self.options:
            kept = Path(self.env.srcdir) / "kept"
            found = json.loads((kept / f"{name}.json").read_text(encoding="utf-8"))
            found |= {
                "picture": f"{name}.png",
                "printed": (kept / f"{name}.txt").read_text(encoding="utf-8"),
            }
            target = kept
        elif self.config.nb_execution_mode == "off":
            return []
        else:
            key = (name, *assignments)
            known = self.env.app.scenarios  # type: ignore[attr-defined]
            if key not in known:
                known[key] = run_scenario(name, assignments, target)
            found = known[key]
        shown = {
            "command": self._command,
            "answer": self._answer,
            "picture": self._picture,
            "table": self._table,
        }
        made = [shown[part](name, assignments, found, target) for part in parts]
        return [node for each in made for node in (each if isinstance(each, list) else [each])]

    def _command(
        self, name: str, assignments: list[str], found: dict[str, Any], target: Path
    ) -> nodes.Node:
        del found, target
        text = " ".join(["bristle-sim", name, *(f"--set {each}" for each in assignments)])
        return nodes.literal_block(text, text, language="console")

    def _answer(
        self, name: str, assignments: list[str], found: dict[str, Any], target: Path
    ) -> nodes.Node:
        del name, assignments, target
        return nodes.paragraph(text=found.get("answer", "(no answer)"), classes=["answer"])

    def _picture(
        self, name: str, assignments: list[str], found: dict[str, Any], target: Path
    ) -> nodes.Node:
        del assignments
        path = target / found["picture"]
        # Sphinx takes a picture's place relative to the sources.
        place = (
            Path("/") / path.relative_to(self.env.srcdir)
            if path.is_relative_to(self.env.srcdir)
            else None
        )
        if place is None:
            copied = Path(self.env.srcdir) / "_made" / path.name
            copied.parent.mkdir(exist_ok=True)
            copied.write_bytes(path.read_bytes())
            place = Path("/_made") / path.name
        uri = self.env.relfn2path(str(place))[0]
        self.env.note_dependency(uri)
        return nodes.image(
            uri=f"/{uri}",
            alt=self.options.get("alt", f"Picture of {name}: {found.get('answer', '')}"),
        )

    def _table(
        self, name: str, assignments: list[str], found: dict[str, Any], target: Path
    ) -> list[nodes.Node]:
        """Return the quantities and the judged rows as tables, and the text that is printed below them."""
        del name, assignments, target
        head, *lines = cells(
            [Quantity(**{key: row[key] for key in GIVEN}) for row in found["quantities"]]
        )
        made: list[nodes.Node] = [table_node(head, lines, numbers=range(2, len(head)))]
        rows = found.get("rows") or [{}]
        if "status" in rows[0] or "ok" in rows[0]:
            kept = [
                key
                for key in rows[0]
                if key not in LEFT_OUT and any(row[key] not in ("", None) for row in rows)
            ]
            made.append(table_node(kept, [[_shown(row[key]) for key in kept] for row in rows]))
        else:
            below = found["printed"].rstrip().split("\n\n", 2)[2:]
            made += [nodes.literal_block(text, text, language="text") for text in below]
        return made


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.7g}" if isinstance(value, float) else "" if value is None else str(value)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive; each run is made once for all pages."""
    app.scenarios = {}  # type: ignore[attr-defined]
    app.add_directive("scenario", ScenarioDirective)
    return {"parallel_read_safe": False}
