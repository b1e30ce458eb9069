"""``bristle-sim limits KEY=FROM:TO``: finds the values of a parameter at which the outcome changes."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from typing import Any

from bristle_sim.cli.options import add_options, deliver, targets_of
from bristle_sim.cli.output import json_of
from bristle_sim.cli.scenario import Scenario, build_parameters
from bristle_sim.declared import Range
from bristle_sim.parameters import Tool
from bristle_sim.readable import aligned
from bristle_sim.studies.limits import Change, limits
from bristle_sim.studies.many_passes import checked_range


def main(pass_of: Scenario, parser: argparse.ArgumentParser, arguments: Sequence[str]) -> int:
    """Find the values of a parameter at which the outcome of the pass changes, and print them.

    The values are also written as JSON if requested.

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
    targets = targets_of(options)
    values = pass_of.values_of(options.set)
    tool = build_parameters(Tool, values)
    low, high = checked_range(tool, key, ends)
    between: dict[str, Any] = {key: (low, high)}
    changes = limits(tool, **between)
    declared: Any = pass_of.keys()[key]
    answer = limits_in_words(declared, low, high, changes)
    text = json_of("limits", answer, values, changes=[dataclasses.asdict(each) for each in changes])
    unit, size = declared.display
    rows = [[f"{key} ({unit})" if unit else key, "below", "above"]]
    rows += [[f"{each.at / size:.9g}", each.below, each.above] for each in changes]
    table = ["", *aligned(rows, ())] if changes else []
    deliver(options, targets, {"json": text}, "\n".join([answer, *table]))
    return 0


def limits_in_words(declared: Range, low: float, high: float, changes: Sequence[Change]) -> str:
    """Return a sentence that lists the changes of the outcome between two values of a parameter.

    Args:
        declared: declaration of the parameter.
        low: smaller value, in the declared unit.
        high: larger value, in the declared unit.
        changes: values at which the outcome changes, with the outcomes on both sides.
    """
    between = f"For {declared.key} from {declared.displayed(low)} to {declared.displayed(high)} the outcome"
    places = [
        f"at {declared.displayed(each.at)} (below: {each.below}, above: {each.above})"
        for each in changes
    ]
    if not places:
        return f"{between} does not change."
    doubtful = [declared.displayed(each.at) for each in changes if not each.confirmed]
    scene = f"does not confirm {', '.join(doubtful)}" if doubtful else "agrees on both sides"
    return f"{between} changes {', '.join(places)}; the time-domain simulation {scene}."
