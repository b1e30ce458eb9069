"""Measured impacts: the laws' predictions for spheres on glass and an ellipse on a floor, compared
with the measurements.

For the spheres nothing is fitted to the published points. They are compared with the rigid law and
with a law that has a tangential spring, whose stiffness follows from elasticity. If ``data`` is
given, each law is fitted to every second impact of the ellipse and predicts the other impacts. No
law can have a smaller error than the best impulse at the contact point.
"""

import sys

from bristle_sim.cli import Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import Measured


def run(measured: Measured) -> Report:
    """Predict the measured impacts."""
    from bristle_sim.studies.measured_impacts import measured_impacts

    return measured_impacts(measured)


def plot(report: Report) -> Picture:
    """Draw the measured points with the curves of the rigid and the elastic contact."""
    from bristle_sim.render.measurement_figures import measured_figure

    return measured_figure(report.subject)


SCENARIO = Scenario(
    name="measured_impacts", question="Do the laws predict what was measured?", run=run, plot=plot
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
