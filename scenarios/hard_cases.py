"""Hard cases: extreme masses, belts, speeds and angles, jams, grazing, chatter, long runs, bad input.

Each case has a promise: to stay accurate, to conserve what must be conserved, or to refuse in one clear line. The table
shows what was reached. ``--set theme=jam`` tries one theme, ``--set effort=quick`` leaves out what takes long.
"""

import sys
from collections.abc import Mapping
from typing import Any

from bristle_sim.benchmarks.hard_cases.report import HardCaseChoice, hard_cases
from bristle_sim.comparison import Report
from bristle_sim.scenario_cli import Scenario, build, main


def run(values: Mapping[str, Any]) -> Report:
    """Try the cases asked for."""
    return hard_cases(build(HardCaseChoice, values))


SCENARIO = Scenario(
    name="hard_cases",
    question="Does it stay stable where it is hard?",
    parts=(HardCaseChoice,),
    run=run,
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
