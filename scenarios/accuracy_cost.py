"""What accuracy costs in time: error against CPU time, compared with other tools on the same cases.

A release flight, a strike under each contact law, the strike of a double pendulum and the whole pass are computed by
every method at settings from coarse to fine. Errors are taken from closed forms or a converged reference; times are CPU
times, all methods in turn. The table compares our CPU time (simulated) with the cheapest peer's (reference).
"""

import sys

from bristle_sim.benchmarks.accuracy_cost.measure import Effort
from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure, study

SCENARIO = Scenario(
    name="accuracy_cost",
    question="What does accuracy cost in time?",
    parts=(Effort,),
    run=study("benchmarks.accuracy_cost.study.accuracy_cost"),
    plot=figure("cost_figure"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
