"""Film and crater: which contact stiffness and wire damping would explain the measurements?

Film and micrograph show one touch, about 50 us of compression and a crater 130 um deep. The damping
of the wire and the stiffness of the contact were never measured. The stiffness is specified by the
duration of a rigid bristle's contact. Each point of a map over both is a pass of a straight wire of
links, simulated until half a millisecond after its first touch. The pair nearest to the
measurements is then tried with bent wires, other numbers of links and other friction.
"""

import sys

from bristle_sim.cli import Columns, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import FilmGrid, Tool
from bristle_sim.settings import Settings


def run(tool: Tool, grid: FilmGrid, settings: Settings) -> Report:
    """Map the strike over contact stiffness and wire damping."""
    from bristle_sim.studies.film import film

    return film(tool, grid, settings)


def plot(report: Report) -> Picture:
    """Draw the map with the measured values as lines, and the nearest pass as filmed by a camera."""
    from bristle_sim.render.measurement_figures import film_map_figure

    return film_map_figure(report.subject)


def series(report: Report) -> Columns:
    """Return the motion of the whole pass of the nearest pair."""
    return dict(report.subject.run.columns())


SCENARIO = Scenario(
    name="film",
    question="Which contact stiffness and wire damping would explain film and crater?",
    run=run,
    plot=plot,
    series=series,
    without=("contact", "contact_duration", "wire_damping_ratio"),
    options=("workers", "store"),
    highest={
        "wire_links": (
            16,
            "at most 16; the strike of more is beyond the 500,000 engine steps of a run",
        )
    },
    defaults={
        "wire_links": (
            4,
            "chosen: at the nearest pair all three measures are within 1 % of those of 8 links",
        ),
        "knee_angle_deg": (
            30.0,
            "assumed: as large as in Zhang 2020, fig. 1.3; of the bent wires beside the straight one",
        ),
        "accuracy": (1e-3, "chosen: times and depths are those of 1e-6 to a per mille"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
