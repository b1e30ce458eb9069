"""Stronge's double pendulum: two hinged rods, the lower end strikes; slip stops, sticks or reverses on the way.

Final rates, impulses and the kinetic-energy ratio are laid beside the closed form, for any ratio of the rods' masses. The
engine's own contact gains energy here; the energetic law never does.
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.parameters import Contact, DoublePendulum, Surface
from bristle_sim.scenario_cli import Scenario, build, main
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import double_pendulum


def run(values: Mapping[str, Any]) -> Report:
    """Strike once, by the law asked for."""
    return double_pendulum(
        build(DoublePendulum, values), build(Surface, values), build(Contact, values), build(Settings, values)
    )


def plot(report: Report, path: Path) -> None:
    """Velocities over the normal impulse, final rates over the mass ratio, energy over the engine's iterations."""
    from bristle_sim.render.impact_figures import double_pendulum_figure
    from bristle_sim.render.style import save_figure
    from bristle_sim.studies.impact_families import double_pendulum_panels
    from bristle_sim.studies.law_convergence import engine_energy

    impacts = report.subject
    energy = engine_energy(impacts.chain, impacts.surface) if any(impacts.chain.rates) else None
    save_figure(double_pendulum_figure(impacts, double_pendulum_panels(impacts), energy), path)


def video(report: Report, path: Path) -> None:
    """The strike in ultra slow motion, compressed in the printed 50 us unless contact_duration says otherwise."""
    from bristle_sim.render.impact_video import impact_video
    from bristle_sim.studies.timed_contact import with_visible_contact

    impact_video(with_visible_contact(report.subject), path)


def series(report: Report) -> dict[str, Any]:
    """The contact in time, where the law resolves it."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


SCENARIO = Scenario(
    name="double_pendulum",
    question="Stronge's double pendulum: does the simulated impact follow the closed form, whatever the masses?",
    parts=(DoublePendulum, Surface, Contact, Settings),
    run=run,
    plot=plot,
    video=video,
    series=series,
    defaults={
        "friction": (0.5, "Zhang 2020, fig. 2.28: the second of its three curves"),
        "restitution": (0.5, "Zhang 2020, fig. 2.28: e*"),
    },
    without=("step", "hub_turn"),
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
