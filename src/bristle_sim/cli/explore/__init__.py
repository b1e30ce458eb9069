"""The bench: a page with a knob for every key of the tool, and the run that follows each move.

``bench`` computes a run for typed values, ``server`` answers the browser, ``command`` is ``bristle-sim explore``. The page
itself is ``render.explore_page``.
"""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from bristle_sim.trajectory.pictures import Html

if TYPE_CHECKING:
    from bristle_sim.parameters import Tool


def explore(tool: Tool | None = None, *, height: int = 900) -> Html:
    """Show the bench in a notebook: knobs for every key of a tool, and its pass.

    Args:
        tool: the one to begin with; by default that of the dissertation.
        height: of the frame, px.

    Returns:
        The frame, which a notebook shows. Its page comes from this process, and ends with it.

    Raises:
        ModuleNotFoundError: without the extra ``explore``.
    """
    from bristle_sim.cli.explore.bench import assignments_of, scenario
    from bristle_sim.cli.explore.server import serve

    address = serve(assignments_of(tool, scenario()))
    return Html(f'<iframe src="{html.escape(address)}" width="100%" height="{height}" title="Explore a tool"></iframe>')
