"""``bristle-sim limits KEY=FROM:TO`` finds the values of a key at which the outcome changes."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence

from bristle_sim.cli.options import add_options, deliver, targets_of
from bristle_sim.cli.output import json_of
from bristle_sim.cli.scenario import Scenario, assigned, build_parameters
from bristle_sim.parameters import KEYS, Tool
from bristle_sim.readable import aligned
from bristle_sim.studies.limits import limits_in_words
from bristle_sim.units import display_unit


def main(pass_of: Scenario, parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Find the values of a parameter at which the outcome of the pass changes, and print them.

    If requested, the values are also written as JSON.

    Args:
        pass_of: the scenario that simulates a pass.
        parser: parser to which the options of the command are added.
        arguments: arguments of the command.

    Returns:
        The exit status.

    Raises:
        ValueError: for bad input.
        OSError: if the JSON cannot be written; the message names the file.
    """
    parser.add_argument(
        "range", metavar="KEY=FROM:TO", help="a key of the tool and the range of its values"
    )
    add_options(parser, "set", "json")
    options = parser.parse_args(arguments)
    key, _, ends = options.range.partition("=")
    values = pass_of.values_of(assigned("--set", options.set))
    targets = targets_of(options, pass_of, values)
    answer, changes = limits_in_words(build_parameters(Tool, values), key, ends)
    text = json_of("limits", answer, values, changes=[dataclasses.asdict(each) for each in changes])
    unit, size = display_unit(key, KEYS[key].unit)
    rows = [[f"{key} ({unit})" if unit else key, "below", "above"]]
    rows += [[f"{each.at / size:.9g}", each.below, each.above] for each in changes]
    table = ["", *aligned(rows, ())] if changes else []
    deliver(options, targets, {"json": text}, "\n".join([answer, *table]))
    return 0
