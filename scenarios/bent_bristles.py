"""Bent bristles: which of a reverse bent, a straight and a forward bent wire slides, and which
retracts at once?

All three pass the same bar and workpart at 2600 rpm. The strike is resolved in time over 0.1 ms,
the dissertation's duration of a contact. In the dissertation's high-speed film the forward bent tip
retracts at once, while the other two slide first. The wire is a chain of links. The stiffness of
its contact would keep the rigid bristle in contact for contact_duration.
"""

import sys
from typing import Any

from bristle_sim.cli import Columns, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings


def run(tool: Tool, settings: Settings) -> Report:
    """Simulate the passes of the three shapes."""
    from bristle_sim.studies.bent_bristles import bent_bristles

    return bent_bristles(tool, settings)


def plot(report: Report) -> Picture:
    """Draw the three tips in contact."""
    from bristle_sim.render.bristle_figures import bent_figure

    return bent_figure(report.subject)


def series(report: Report) -> Columns:
    """Return the three motions, one after the other."""
    runs = report.subject.trajectories
    columns: dict[str, Any] = {"shape": [shape for shape, run in runs.items() for _ in run.time]}
    for motion in runs.values():
        for name, values in motion.columns().items():
            columns.setdefault(name, []).extend(values.tolist())
    return columns


SCENARIO = Scenario(
    name="bent_bristles",
    question="Reverse bent, straight, forward bent: which tip slides, which retracts at once?",
    run=run,
    plot=plot,
    series=series,
    without=("gravity",),
    highest={"wire_links": (4, "at most 4, of which three passes take 8 s")},
    defaults={
        "hub_speed": (272.27, "Zhang 2020, fig. 1.4: 2600 rpm"),
        "belt_damping_ratio": (0.05, "assumed: a wire that has swung out before the next strike"),
        "knee_angle_deg": (30.0, "assumed: as large as in Zhang 2020, fig. 1.3"),
        "contact": (
            "compliant",
            "chosen: sliding takes time, which only a contact resolved in time has",
        ),
        "contact_duration": (1e-4, "Zhang 2020, eq. 3.19: the assumed force lasts 0.1 ms"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
