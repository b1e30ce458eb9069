"""The surface: which roughness does a tool make, and how many square metres an hour?

The first crater follows from the strike's energy. The places of the strikes follow from feed,
bristles and planes. A rule determines how a crater meets earlier craters. The roughness of the
simulated ground is evaluated as by a profilometer and compared with the measured roughness.
"""

import sys

from bristle_sim.cli import Columns, Film, Picture, Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.parameters import SHAPE_KEYS, Blasting, Bristle, Crater, Hub
from bristle_sim.settings import Settings


def run(
    hub: Hub, bristle: Bristle, crater: Crater, blasting: Blasting, settings: Settings
) -> Report:
    """Blast a piece of the track, and measure its roughness."""
    from bristle_sim.studies.surface import surface_study

    return surface_study(hub, bristle, crater, blasting, settings)


def plot(report: Report) -> Picture:
    """Draw the height map, a profile, and the growth of roughness and coverage."""
    from bristle_sim.render.surface_pictures import surface_figure

    return surface_figure(report.subject)


def film(report: Report, **size: int) -> Film:
    """Film the surface while it forms."""
    from bristle_sim.render.surface_pictures import SurfaceFilm

    return SurfaceFilm(report.subject, **size)


def series(report: Report) -> Columns:
    """Return the height of every cell."""
    from bristle_sim.studies.surface import height_columns

    return height_columns(report.subject)


def points(report: Report) -> str:
    """Return lines with x, y and height (m) of every cell, a format that Gwyddion imports."""
    from bristle_sim.studies.surface import height_lines

    return height_lines(report.subject)


SCENARIO = Scenario(
    name="surface",
    question="Which roughness does this tool make, and how many square metres an hour?",
    run=run,
    plot=plot,
    film=film,
    series=series,
    formats={".xyz": points},
    without=(*SHAPE_KEYS, "hub_turn", "plies"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
