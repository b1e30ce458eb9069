"""The page of the bench: knobs, the motion under its slider, panels over time, and the table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jinja2
from markupsafe import Markup


def explore_page(knobs: Sequence[dict[str, Any]]) -> str:
    """Return the page for the knobs of :func:`bristle_sim.cli.explore.bench.knobs`; it asks its own server for runs."""
    loader = jinja2.PackageLoader("bristle_sim.render", ".")
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)

    def text(name: str) -> Markup:
        return Markup(loader.get_source(environment, name)[0])

    return environment.get_template("explore.html.jinja").render(
        keys=knobs, look=text("page.css"), viewer=text("viewer.html"), script=text("viewer.js") + text("explore.js")
    )
