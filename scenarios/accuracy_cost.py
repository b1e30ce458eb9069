"""What accuracy costs in time: error against CPU time, compared with other tools on the same cases.

A release flight, a strike under each contact law, the strike of a double pendulum and the whole pass are computed by
every method at settings from coarse to fine. Errors are taken from closed forms or a converged reference; times are CPU
times, all methods in turn. The table compares our CPU time (simulated) with the cheapest peer's (reference).
"""

import sys
from collections.abc import Mapping
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.measure import Effort
from bristle_sim.comparison import Report
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.scenario_cli.scenario import figure


def run(values: Mapping[str, Any]) -> Report:
    """Measure with the requested effort."""
    from bristle_sim.benchmarks.accuracy_cost.study import accuracy_cost

    return accuracy_cost(build(Effort, values))


SCENARIO = Scenario(
    name="accuracy_cost",
    question="What does accuracy cost in time?",
    parts=(Effort,),
    run=run,
    plot=figure("cost_figure"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
