"""The cost of accuracy: error against CPU time for the methods of this project and of other
packages.

All methods solve the same cases. An attempt is one method with one setting, applied to one case.
The module ``cases`` holds the cases with their exact answers. ``methods`` (this project, SciPy) and
``peers`` (MuJoCo, heyoka) list the attempts at each case. ``measure`` measures errors and CPU
times in separate runs. ``study`` makes the attempts and writes the report.
"""

from __future__ import annotations

from dataclasses import dataclass

from bristle_sim.declared import Declared
from bristle_sim.fields import choice


@dataclass(frozen=True, slots=True)
class Effort(Declared):
    """Options of the measurement: how much is measured, and which packages take part.

    At ``quick`` effort fewer settings of each method are measured than at ``full`` effort, and each
    setting is measured fewer times.
    """

    effort: str = choice(
        "effort: how many settings are timed and how often [chosen: quick measures too little to compare]",
        "full",
        "quick",
    )
    peers: str = choice(
        "peers: whether other packages are timed too [chosen: every installed peer takes part]",
        "all",
        "none",
    )
