"""The inertia-driven tool: how fast is the tip of a bristle that no bar holds back?

The wire arrives translating on a straight belt and enters the pulley with the rate 0; it lags, the belt whips it back, and it
passes the radial direction. How fast is its tip then, and how fast must the pulley turn for the tip speed of the bar-cued tool?
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.cli.scenario import figure, film, study
from bristle_sim.parameters import Bar, Belt, Bristle, Comparison, Hub, Workpart
from bristle_sim.settings import Settings

SCENARIO = Scenario(
    name="inertia_driven",
    question="How fast is the tip of a bristle that inertia drives, without a bar?",
    parts=(Hub, Belt, Bristle, Bar, Workpart, Settings, Comparison),
    run=study("studies.inertia_driven.inertia_driven"),
    plot=figure("inertia_figure"),
    video=film("tool_films.InertiaFilm"),
    without=(
        "knee_position",
        "knee_angle_deg",
        "friction",
        "restitution_friction",
        "restitution",
        "hub_turn",
        "step",
    ),
    highest={"wire_links": (4, "at most 4, of which the runs that find the equal hub speed take 17 s")},
    defaults={
        "reference": ("yes", "chosen: a flight takes the independent solution little time"),
        "accuracy": (1e-9, "chosen: the flight agrees with the reference to 1e-8"),
    },
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
