"""Hard cases: extreme masses, belts, speeds and sizes, jams, grazing, chatter, thin bars, long
runs, small budgets.

Each case has a promise: to stay accurate, to conserve a quantity, or to refuse in one clear line.
The table shows each result. ``--set theme=jam`` tries one theme, ``--set effort=quick`` omits long
cases.
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
