"""The two ways to start the bench, the interactive page of a tool.

They are the command ``bristle-sim explore``, and ``bristle_sim.explore`` in a notebook.
"""

from __future__ import annotations

import argparse
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bristle_sim.cli.options import value_of
from bristle_sim.cli.output import print_line
from bristle_sim.cli.scenario import Scenario, main_scenario
from bristle_sim.declared import Range
from bristle_sim.trajectory.pictures import Html

if TYPE_CHECKING:
    from bristle_sim.parameters import Tool

MOST_PORTS = 65535


def explore(tool: Tool | None = None, *, height: int = 900) -> Html:
    """Show an interactive page in a notebook: controls for a tool's parameters, and its motion.

    Args:
        tool: tool that is shown first; by default that of the dissertation.
        height: height of the frame, px.

    Returns:
        The frame, which a notebook shows. The page works until this Python process ends.
    """
    from bristle_sim.cli.explore.bench import typed_of
    from bristle_sim.cli.explore.server import Server

    server = Server({} if tool is None else typed_of(tool, main_scenario()))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return Html(
        f'<iframe src="{server.address}" width="100%" height="{height}" title="Explore a tool"></iframe>'
    )


def main(pass_of: Scenario, parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Serve the interactive page of a tool until Ctrl-C, and return the exit status 0.

    Args:
        pass_of: the scenario that simulates a pass.
        parser: parser to which the options of the command are added.
        arguments: arguments of the command.

    Raises:
        ValueError: for bad input.
        OSError: if the port is in use.
    """
    parser.add_argument("tool", nargs="?", metavar="FILE.toml", help="the tool to begin with")
    parser.add_argument(
        "--port",
        type=value_of(Range("port", "1", 0, MOST_PORTS, whole=True).parse),
        default=0,
        help="port to listen on; by default a free one",
    )
    options = parser.parse_args(arguments)
    start = {} if options.tool is None else pass_of.typed_in(options.tool, "FILE.toml")[0]
    pass_of.values_of(start)
    from bristle_sim.cli.explore.server import Server

    server = Server(start, options.port)
    print_line(f"{server.address} shows the bench; Ctrl-C ends it")
    server.serve_forever()
    return 0
