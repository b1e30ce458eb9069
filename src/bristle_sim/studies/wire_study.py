"""The strike of a wire compared with that of a rigid bristle, for several contact stiffnesses and
numbers of links.
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
# Durations of the rigid bristle's contact, divided by the requested duration. They stand for the
# contact stiffnesses of the figure.
STIFFNESSES = tuple(np.geomspace(0.07, 14.0, 13).tolist())


@dataclass(frozen=True, slots=True)
class WireStudy:
    """Measures of the strike of a wire, divided by those of the rigid bristle's strike.

    They are functions of the contact stiffness and of the number of links.

    Attributes:
        durations: durations (s) of the rigid bristle's contact, each of which stands for a contact
            stiffness.
        by_duration: ratios at each of ``durations``, by name of the measure.
        links: numbers of links.
        by_links: ratios at each of ``links``, by name of the measure.
    """

    durations: Array
    by_duration: dict[str, Array]
    links: Array
    by_links: dict[str, Array]


def wire_study(strike: FlexibleStrike, stiffnesses: Sequence[float] = STIFFNESSES) -> WireStudy:
    """Simulate the strikes for the figure of the study.

    The tool's wire strikes on contacts of several stiffnesses. Wires with fewer links strike on the
    contact of the requested stiffness.

    Args:
        strike: the requested strike.
        stiffnesses: contact stiffnesses, each given as the duration that the rigid bristle's
            contact would have, divided by the requested duration.
    """
    most = strike.tool.bristle.links
    durations = strike.contact.duration * np.array(stiffnesses)
    numbers = range(1, max(2, most) + 1)
    coarse = dataclasses.replace(strike.settings, accuracy=STUDY_ACCURACY)

    def compared(strikes: Iterable[FlexibleStrike]) -> dict[str, Array]:
        """Return the measures of strikes, divided by those of the rigid bristle's strike.

        A ratio is NaN if one of the contacts does not end.
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
