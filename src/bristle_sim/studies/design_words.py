"""A design in sentences: the tool found, conflicting conditions, best compromises, and the
tolerances of the parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bristle_sim.arrays import Array
from bristle_sim.comparison import Report
from bristle_sim.parameters import KEYS
from bristle_sim.readable import amount, readable_unit
from bristle_sim.studies.design_search import Search
from bristle_sim.studies.whole_pass import QUANTITIES

# Decimals with which a quantity is printed in its customary unit; further ones are rounding error.
DECIMALS = 4


def tool_in_words(search: Search, varied: Mapping[str, float], report: Report, met: bool) -> str:
    """Return a clause with the designed tool's parameters, the quantities of its pass, and its
    outcome.

    Args:
        search: conditions of the design, and the quantity that it minimises or maximises.
        varied: values of the varied parameters, by name.
        report: report of the simulated pass.
        met: whether all conditions are met. Only then does the clause call the minimised or
            maximised quantity the lowest or highest.
    """
    reached = {each.name: each.simulated for each in report.quantities}
    extreme = "highest" if search.sense < 0.0 else "lowest"
    names = [*search.at_most, *search.want]
    parts = {name: f"a {_quantity(name, reached[name])}" for name in names}
    if search.goal and met:
        parts[search.goal] = f"the {extreme} {_quantity(search.goal, reached[search.goal])}"
    tool = listed([f"{key} {KEYS[key].displayed(value)}" for key, value in varied.items()])
    return f"with {tool} the pass has {listed([*parts.values()])}, and the tip {report.outcome_in_words}"


def conflict_in_words(search: Search, conflict: Sequence[str]) -> str:
    """Return a clause that states which conditions no tool in the ranges meets together."""
    parts = [
        f"a {_quantity(name, search.conditions[name], '' if name in search.want else 'at most ')}"
        for name in conflict
    ]
    return f"no tool in these ranges has {'both ' if len(conflict) == 2 else ''}{listed(parts)}"


def curve_in_words(curve: Mapping[str, Array], conflict: Sequence[str], free: Sequence[str]) -> str:
    """Return a sentence with the two quantities at both ends of the curve of best compromises.

    Args:
        curve: values of the two quantities along the curve.
        conflict: names of the two quantities.
        free: names of the quantities whose target values the curve disregards.
    """
    ends = [
        " with a ".join(_quantity(name, float(curve[name][end])) for name in conflict)
        for end in (0, -1)
    ]
    names = listed([QUANTITIES[name][0] for name in free])
    disregarded = f", without regard to the {names}," if free else ""
    return f"The best compromises{disregarded} run from a {ends[0]} to a {ends[1]}."


def kept_in_words(kept: Mapping[str, tuple[float, float]]) -> str:
    """Return a sentence with the interval of each parameter in which all targets stay met."""
    ranges = listed(
        [f"{key} from {' to '.join(map(KEYS[key].displayed, ends))}" for key, ends in kept.items()]
    )
    return f"The targets stay met, to 1 % or 1°, with {ranges}, one key at a time."


def listed(parts: Sequence[str]) -> str:
    """Return phrases joined by commas, with ``and`` before the last."""
    return f"{', '.join(parts[:-1])} and {parts[-1]}" if len(parts) > 1 else "".join(parts)


def _quantity(name: str, value: float | None, most: str = "") -> str:
    """Return a quantity with its value and unit, for example ``tip speed v_C of 36 m/s``.

    ``most`` is a phrase before the value, such as ``at most ``.
    """
    label, unit = QUANTITIES[name]
    if value is None:
        return f"{label} of none"
    size = readable_unit(unit, [value])[1]
    return f"{label} of {most}{amount((round(value / size, DECIMALS) + 0.0) * size, unit, 5)}"
