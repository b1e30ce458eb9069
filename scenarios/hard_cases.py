"""Hard cases: extreme masses, belts, speeds and sizes, jams, grazing, chatter, thin bars, long runs, small budgets.

Each case has a promise: to stay accurate, to conserve what must be conserved, or to refuse in one clear line. The table
shows what was reached. ``--set theme=jam`` tries one theme, ``--set effort=quick`` leaves out what takes long.
"""

import sys

from bristle_sim.benchmarks.hard_cases.report import HardCaseChoice
from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import study

SCENARIO = Scenario(
    name="hard_cases",
    question="Does it stay stable where it is hard?",
    parts=(HardCaseChoice,),
    run=study("benchmarks.hard_cases.report.hard_cases"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
