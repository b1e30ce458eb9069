"""The cost of accuracy: error against CPU time of this project's methods and of other packages on the same cases.

``cases`` has the cases with their exact answers. ``own_methods``, ``scipy_methods`` and ``peers`` (MuJoCo, heyoka) list the
attempts at each case. ``measure`` takes errors and times in separate passes. ``study`` runs them and writes the report.
"""

from __future__ import annotations

from dataclasses import dataclass

from bristle_sim.units import Declared, choice


@dataclass(frozen=True, slots=True)
class Effort(Declared):
    """The extent of the measurement."""

    effort: str = choice(
        *("full", "effort", ("full", "quick"), "how many settings are timed and how often"),
        source="chosen: quick measures too little to compare",
    )
    peers: str = choice(
        *("all", "peers", ("all", "none"), "whether other packages are timed too"),
        source="chosen: every installed peer takes part",
    )
