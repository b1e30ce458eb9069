"""Hard cases: extreme masses, belts and hub speeds, jams, grazing, chatter, thin bars, long runs.

Each case has a promise: to stay accurate, to conserve a quantity, or to end with a named reason.
The table shows each result. ``--set theme=jam`` tries one theme.
"""

import sys

from bristle_sim.benchmarks.hard_cases import HardCaseChoice
from bristle_sim.cli import Scenario, main
from bristle_sim.comparison import Report


def run(chosen: HardCaseChoice) -> Report:
    """Try the cases, and compare each result with its promise."""
    from bristle_sim.benchmarks.hard_cases.report import hard_cases

    return hard_cases(chosen)


SCENARIO = Scenario(
    name="hard_cases",
    question="Does it stay stable where it is hard?",
    run=run,
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
