"""Force history: the curve that chapter 3 assumes compared with the contact force of a bristle in the scene.

Both have the same compressive impulse and compression time; the peak force is the finding. A measured force history takes
the curve's place with ``--set force_csv=FILE``, a file as an oscilloscope exports it: the contact is found on any clock and
above any zero, units are read from headings, ``time_column`` and ``force_column`` choose among several columns, and
``force_per_volt`` is the sensitivity of a force recorded as a voltage.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.crater_parameters import ForceHistory, Measurement
from bristle_sim.parameters import Bristle, Hub, Surface
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.force_comparison import force_comparison


def run(values: Mapping[str, Any]) -> Report:
    """Strike with the curve's impulse in the curve's time."""
    return force_comparison(
        build(Hub, values),
        build(Bristle, values),
        build(Surface, values),
        build(ForceHistory, values),
        build(Measurement, values),
        build(Settings, values),
    )


def plot(report: Report, path: Path) -> None:
    """Draw both forces over time, the ten segments of table 3.1 and the fit tried on points of the curve."""
    from bristle_sim.render.force_figure import force_figure
    from bristle_sim.render.style import save_figure

    save_figure(force_figure(report.subject), path)


def series(report: Report) -> dict[str, Any]:
    """The simulated contact in time."""
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.record.columns())


SCENARIO = Scenario(
    name="force_history",
    question="Does a simulated contact push as the force curve of chapter 3 assumes?",
    parts=(Hub, Bristle, Surface, ForceHistory, Measurement, Settings),
    run=run,
    plot=plot,
    series=series,
    without=("wire_diameter", "knee_position", "knee_angle_deg", "step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
