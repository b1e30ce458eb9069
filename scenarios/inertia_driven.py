"""The inertia-driven tool: how fast is the tip of a bristle that no bar holds back?

The wire arrives in translation on a straight belt, so it does not rotate when it enters the pulley.
It lags, the belt drives it back, and it passes the radial direction. How fast is its tip then? How
fast must the pulley turn for the tip to be as fast as at the strike of the tool with a bar?
"""

import sys

from bristle_sim.cli import Columns, Film, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import CONTACT_KEYS, SHAPE_KEYS, SURFACE_KEYS, Comparison, Tool
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory


def run(tool: Tool, settings: Settings, compared: Comparison) -> Report:
    """Let the wire enter the pulley, and compare its tip speed with that of the tool with a bar."""
    from bristle_sim.studies.inertia_driven import inertia_driven

    return inertia_driven(tool, settings, with_reference=compared.reference == "yes")


def plot(report: Report) -> Picture:
    """Draw the retraction over the hub's turn, and the relative rate over the retraction."""
    from bristle_sim.render.release_figures import inertia_figure

    return inertia_figure(report.subject)


def thrown(report: Report) -> Trajectory:
    """Return the motion of the bristle from its entry into the pulley until it is radial again."""
    if report.subject.radial is None:
        raise ValueError(
            "motion: the bristle must become radial again; its inertia throws it beyond the limit of retraction"
        )
    motion: Trajectory = report.subject.radial
    return motion


def series(report: Report) -> Columns:
    """Return the simulated motion."""
    return dict(thrown(report).columns())


def film(report: Report, **size: int) -> Film:
    """Film the bristle thrown by its inertia, from its entry into the pulley until it is radial."""
    from bristle_sim.render.tool_films import pass_film

    run = thrown(report)
    return pass_film(run, run.tool, **size)


SCENARIO = Scenario(
    name="inertia_driven",
    question="How fast is the tip of a bristle that inertia drives, without a bar?",
    run=run,
    plot=plot,
    series=series,
    film=film,
    without=(*SHAPE_KEYS, *SURFACE_KEYS, *CONTACT_KEYS, "gravity", "hub_turn"),
    defaults={
        "reference": ("yes", "chosen: a flight takes the independent solution little time"),
        "accuracy": (1e-9, "chosen: the flight agrees with the reference to 1e-8"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
