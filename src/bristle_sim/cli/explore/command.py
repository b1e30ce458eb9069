"""``bristle-sim explore``: serve the bench until Ctrl-C."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from bristle_sim.cli.output import say
from bristle_sim.cli.scenario import Scenario

PROGRAM = "bristle-sim explore"
MOST_PORTS = 65535


def main(pass_of: Scenario, arguments: Sequence[str]) -> int:
    """Serve the bench; return the exit status.

    Raises:
        ValueError: for bad input, or without the extra ``explore``.
        OSError: if the port is taken.
    """
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description="Turn the knobs of a tool in the browser, and see its pass.",
        allow_abbrev=False,
        exit_on_error=False,
    )
    parser.add_argument("tool", nargs="?", metavar="FILE.toml", help="the tool to begin with")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on; by default this machine alone")
    parser.add_argument("--port", type=_port, default=0, help="port to listen on; by default a free one")
    options = parser.parse_args(arguments)
    start = [] if options.tool is None else pass_of.assignments_from(options.tool)[0]
    pass_of.values_of(start)
    try:
        from bristle_sim.cli.explore.server import server
    except ModuleNotFoundError as error:
        raise ValueError(f"{error.name}: must be installed; pip install 'bristle-sim[explore]' brings it") from error
    serving = server(start, host=options.host, port=options.port)
    say(f"http://{options.host}:{serving.server_port}/ shows the bench; Ctrl-C ends it")
    serving.serve_forever()
    return 0


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > MOST_PORTS:
        raise argparse.ArgumentTypeError(f"{text!r}: must be a whole number from 0 to {MOST_PORTS}")
    return int(text)
