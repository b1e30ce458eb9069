"""The cost of accuracy: error against CPU time, compared with other packages on the same cases.

Every method computes a flight after a release, a strike with each contact law, the strike of a
double pendulum and a whole pass, with settings from coarse to fine. Errors are differences from
closed forms or from a converged reference. Times are CPU times; all methods are timed in turn. The
table compares the CPU time of this project (simulated) with that of the fastest other package
(reference).
"""

import sys

from bristle_sim.benchmarks.accuracy_cost import Effort
from bristle_sim.cli import Picture, Scenario, main
from bristle_sim.comparison import Report


def run(effort: Effort) -> Report:
    """Measure error and CPU time of every method at every setting."""
    from bristle_sim.benchmarks.accuracy_cost.study import accuracy_cost

    return accuracy_cost(effort)


def plot(report: Report) -> Picture:
    """Draw the error over the CPU time."""
    from bristle_sim.render.cost_figure import cost_figure

    return cost_figure(report.subject)


SCENARIO = Scenario(
    name="accuracy_cost",
    question="What does accuracy cost in time?",
    run=run,
    plot=plot,
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
