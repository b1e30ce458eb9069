"""The strike of a wire relative to the rigid bristle's, over contact stiffness and over number of
links.
"""

import dataclasses
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import ContactStiffness
from bristle_sim.studies.flexible_wire import MEASURES, FlexibleStrike, measures, ratios

STUDY_ACCURACY = 1e-4  # accuracy of the strikes in the figure: errors far below the width of a line
# Contact stiffnesses of the figure, as durations of the rigid bristle's contact over the requested
# duration
STIFFNESSES = tuple(np.geomspace(0.07, 14.0, 13).tolist())


@dataclass(frozen=True, slots=True)
class WireStudy:
    """Measures of the strike of a wire relative to the rigid bristle, over contact stiffness and
    over number of links.

    Attributes:
        durations: contact stiffnesses, given as durations of the rigid bristle's contact, s.
        by_duration: ratios to the rigid bristle at each of ``durations``, by name of the measure.
        links: numbers of links.
        by_links: ratios to the rigid bristle at each of ``links``, by name of the measure.
    """

    durations: Array
    by_duration: dict[str, Array]
    links: Array
    by_links: dict[str, Array]


def wire_study(strike: FlexibleStrike, stiffnesses: Sequence[float] = STIFFNESSES) -> WireStudy:
    """Simulate the strikes for the figure of the study.

    ``stiffnesses`` are contact stiffnesses, given as durations of the rigid bristle's contact over
    the requested duration. On each of them the tool's wire strikes. On the requested stiffness
    wires of every number of links up to the tool's number strike.
    """
    most = strike.tool.bristle.links
    durations = strike.contact.duration * np.array(stiffnesses)
    numbers = range(1, max(2, most) + 1)
    coarse = dataclasses.replace(strike.settings, accuracy=STUDY_ACCURACY)

    def compared(strikes: Iterable[FlexibleStrike]) -> dict[str, Array]:
        """Return the measures of strikes, each divided by the measure of the rigid bristle's
        strike; NaN if a contact does not end.
        """
        found = []
        for each in strikes:
            try:
                found.append(
                    ratios(*(measures(one, one.run().contact) for one in (each, each.of(1))))
                )
            except ValueError:
                found.append(dict.fromkeys(MEASURES, math.nan))
        return {name: np.array([each[name] for each in found]) for name in MEASURES}

    contacts = [ContactStiffness(duration) for duration in durations.tolist()]
    by_duration = compared(strike.of(most, contact=each, settings=coarse) for each in contacts)
    by_links = compared(strike.of(links, settings=coarse) for links in numbers)
    return WireStudy(durations, by_duration, np.array(numbers, dtype=float), by_links)
