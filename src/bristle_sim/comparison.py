"""Comparison of simulated values with theory, an independent solution and printed values, in tables
and sentences.

A table has one row for each quantity. The same rule of agreement applies to every row.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from bristle_sim.readable import WIDTH, aligned, amount, finite, readable_unit, relative_text

Values = Mapping[str, float | None]
"""Values by the names of their quantities; None for an unknown value."""

UNKNOWN: Values = MappingProxyType({})

SIDES = ("simulated", "theory", "reference", "printed")
JUDGES = ("reference", "theory", "printed")  # sources of compared values, the best first


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity with its simulated value and the values with which it is compared.

    Attributes:
        name: name of the quantity.
        unit: unit of the quantity; "1" for a pure number.
        simulated: simulated value; None if absent.
        theory: value that a closed form gives; None if absent.
        reference: value that the independent solution gives; None if absent.
        printed: value printed in the dissertation; None if absent.
        tolerance: largest relative difference that counts as agreement, or largest absolute
            difference if the compared value is 0. None if a difference is a result of the study,
            not an error.
        label: name of the quantity in tables, with its symbol; by default the words of ``name``.
    """

    name: str
    unit: str
    simulated: float | None
    theory: float | None = None
    reference: float | None = None
    printed: float | None = None
    tolerance: float | None = None
    label: str = ""

    def __post_init__(self) -> None:
        if self.judge is None:
            object.__setattr__(self, "tolerance", None)
        if not self.label:
            object.__setattr__(self, "label", self.name.removesuffix("_deg").replace("_", " "))

    @property
    def judge(self) -> tuple[str, float] | None:
        """Source and value of the number with which the simulated value is compared.

        The source is the first of ``reference``, ``theory`` and ``printed`` that has a value. The
        result is None if none of the three has one.
        """
        known = ((name, getattr(self, name)) for name in JUDGES)
        return next((each for each in known if each[1] is not None), None)

    @property
    def relative_difference(self) -> float | None:
        """Simulated minus compared value, divided by the magnitude of the compared value.

        The compared value is the number in :attr:`judge`. The result is None if one of the two
        values is missing, or if the compared value is 0.
        """
        judge = self.judge
        if self.simulated is None or judge is None or not judge[1]:
            return None
        return (self.simulated - judge[1]) / abs(judge[1])

    @property
    def ok(self) -> bool | None:
        """Whether the difference from the compared value is within the tolerance.

        The result is None if there is no tolerance or no compared value. The result is False if the
        simulated value is missing or NaN.
        """
        if self.tolerance is None:
            return None
        relative = self.relative_difference
        difference = self.simulated if relative is None else relative
        return difference is not None and bool(abs(difference) <= self.tolerance)

    def as_dict(self) -> dict[str, Any]:
        """Return the quantity as a dictionary for JSON; a number that is not finite becomes None."""
        numbers = {
            name: finite(getattr(self, name))
            for name in (*SIDES, "relative_difference", "tolerance")
        }
        return {"name": self.name, "label": self.label, "unit": self.unit, **numbers, "ok": self.ok}


def rows(
    units: Mapping[str, tuple[str, str]],
    simulated: Values,
    theory: Values = UNKNOWN,
    reference: Values = UNKNOWN,
    printed: Values = UNKNOWN,
    tolerances: Values = UNKNOWN,
) -> tuple[Quantity, ...]:
    """Return one quantity for each name in ``units``, with its values from all sources.

    Args:
        units: label and unit by name; if the label is empty, the words of the name are the label.
        simulated: simulated values by name.
        theory: values of closed forms by name.
        reference: values of the independent solution by name.
        printed: printed values by name.
        tolerances: tolerances by name.
    """
    return tuple(
        [
            Quantity(
                name,
                unit,
                simulated.get(name),
                theory.get(name),
                reference.get(name),
                printed.get(name),
                tolerances.get(name),
                label,
            )
            for name, (label, unit) in units.items()
        ]
    )


@dataclass(frozen=True, slots=True)
class Table:
    """A table of texts with a title and a row of headings."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __str__(self) -> str:
        """Return title and table as text for a terminal.

        The first column is aligned to the left, all others to the right.
        """
        return "\n".join([f"{self.title}:", *aligned([self.head, *self.rows], (0,))])


@dataclass(frozen=True, slots=True)
class Report:
    """The results of a scenario.

    Attributes:
        outcome: ``rebound``, ``no rebound``, ``stiction`` or ``no contact``; None if the scenario
            has no impact.
        quantities: the compared quantities.
        phases: phases of the impact, in order.
        events: names and times (s) of events, in order.
        wall_s: wall time of the computation, s.
        steps: number of engine steps.
        remarks: sentences that explain the table.
        tables: further tables, besides the table of the quantities.
        extra: further entries of the JSON output.
        subject: objects from which pictures are drawn.
        answer: answer to the scenario's question in one sentence, in customary units; empty if the
            computation was interrupted.
        outcome_in_words: the outcome in the words of ``ContactRecord.outcome_in_words``, for
            sentences, sweeps and web pages; empty without an outcome.
        not_reached: sentence on an accuracy that the simulation has not reached
            (``Trajectory.accuracy_not_reached``). The sentence becomes the last remark. If the
            sentence begins with "accuracy not reached", the answer begins with these words, too.
    """

    outcome: str | None = None
    quantities: tuple[Quantity, ...] = ()
    phases: tuple[str, ...] = ()
    events: tuple[tuple[str, float], ...] = ()
    wall_s: float = 0.0
    steps: int = 0
    remarks: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    extra: dict[str, Any] = field(default_factory=dict)
    subject: Any = None
    answer: str = ""
    not_reached: str = ""
    outcome_in_words: str = ""

    def __post_init__(self) -> None:
        """Add the sentence on an accuracy that was not reached to the answer and the remarks.

        If the outcome is ``no contact``, the tolerances of agreeing quantities are removed. Without
        a contact nothing has changed, so the agreement proves nothing.
        """
        if self.not_reached:
            if self.not_reached.startswith("accuracy not reached"):
                object.__setattr__(self, "answer", f"Accuracy not reached: {self.answer}")
            object.__setattr__(self, "remarks", (*self.remarks, self.not_reached))
            object.__setattr__(self, "not_reached", "")
        if self.outcome == "no contact":
            unjudged = tuple(
                replace(each, tolerance=None) if each.ok else each for each in self.quantities
            )
            object.__setattr__(self, "quantities", unjudged)


class Unfinished(KeyboardInterrupt):
    """Raised when the user interrupts a long computation.

    The exception carries a report of the part that was finished.
    """

    def __init__(self, report: Report) -> None:
        super().__init__("interrupted")
        self.report = report


LAYOUTS = (
    (6, ()),
    (5, ()),
    (6, ("reference",)),
    (5, ("reference",)),
    (4, ("reference",)),
    (4, ("reference", "within")),
)
"""Layouts of tables, the widest first: number of digits, and names of the omitted columns."""


def table(quantities: Sequence[Quantity], width: int = WIDTH) -> str:
    """Return the table of quantities as text for a terminal of a given width, in characters.

    Units have readable prefixes, and empty columns are omitted. If the table is still too wide, it
    shows fewer digits. If necessary, the column of the independent solution is omitted, and then
    the column of the tolerance. Each entry of the column of differences names the source with which
    the simulated value is compared.
    """
    for layout in LAYOUTS:
        head, *lines = aligned(cells(quantities, *layout), (0, 1))
        needed = max(map(len, [head, *lines]))
        if needed <= width:
            break
    return "\n".join([head, "-" * needed, *lines])


def cells(
    quantities: Sequence[Quantity], digits: int = 6, left_out: Sequence[str] = ()
) -> list[list[str]]:
    """Return the texts of a table of quantities, row by row, headings first.

    Args:
        quantities: quantities, one for each row.
        digits: number of significant digits.
        left_out: headings of columns to omit; empty columns are omitted anyway.
    """
    head = ["quantity", "unit", *SIDES, "difference from", "within", "ok"]
    lines = [head]
    for each in quantities:
        values = [getattr(each, side) for side in SIDES]
        unit, factor = readable_unit(each.unit, values)
        numbers = [
            "-" if finite(value) is None else f"{value / factor:.{digits}g}" for value in values
        ]
        difference = relative_text(each.relative_difference, "+")
        if each.judge and difference != "-":
            difference += f" {each.judge[0].removesuffix('ed')}"
        ok = {True: "yes", False: "NO", None: "-"}[each.ok]
        tail = (difference, relative_text(each.tolerance), ok)
        lines.append([each.label, "-" if unit == "1" else unit, *numbers, *tail])
    columns = list(zip(*lines, strict=True))
    kept = [
        each
        for each in columns
        if each[0] not in left_out and (each[0] in head[:3] or {*each[1:]} - {"-"})
    ]
    return list(map(list, zip(*kept, strict=True)))


LEAST_SIZE = 1e-12
"""Magnitude (in SI units) above which a value can be the base of a relative difference; a smaller
value counts as zero."""


def most_different(quantities: Iterable[Quantity], side: str, word: str) -> str:
    """Return a text on the quantity whose simulated value differs most from the value of a source.

    Differences are relative. The text gives both values, as in ``x 3 N, printed 4 N``; it is empty
    if no quantity has both values. A value of the source counts as missing if its magnitude is at
    most ``LEAST_SIZE``.

    Args:
        quantities: quantities to search.
        side: the source: ``theory``, ``reference`` or ``printed``.
        word: words that introduce the source's value in the text.
    """
    farthest = -1.0
    shown = ""
    for each in quantities:
        one, other = each.simulated, getattr(each, side) or 0.0
        if one is not None and abs(other) > LEAST_SIZE and abs(one / other - 1.0) > farthest:
            farthest = abs(one / other - 1.0)
            shown = f"{each.label} {amount(one, each.unit)}, {word} {amount(other, each.unit)}"
    return shown


def differences(quantities: Sequence[Quantity]) -> str:
    """Return a sentence on the largest differences from formulas and from printed values.

    The text is empty if there are no values to compare.
    """
    formula = most_different(quantities, "theory", "by formula")
    printed = most_different(quantities, "printed", "printed in the dissertation")
    found = "; ".join(filter(None, (formula, printed)))
    return f" Largest differences: {found}." if found else ""


def agreement(quantities: Sequence[Quantity]) -> str:
    """Return a clause on the agreement of closed forms with the simulated values.

    If all quantities agree, the clause states the largest relative difference, for example ``the
    closed form agrees to 2e-16``. Otherwise it names the quantity that differs most.
    """
    judged = [each for each in quantities if each.ok is not None]
    missed = [each for each in judged if not each.ok]
    if judged and not missed:
        worst = max(abs(each.relative_difference or 0.0) for each in judged)
        return (
            f"the closed form agrees to {worst:.0e}" if worst else "the closed form agrees exactly"
        )
    differing = most_different(missed or quantities, "theory", "by formula")
    return f"the closed form differs ({differing})" if differing else "there is no closed form"
