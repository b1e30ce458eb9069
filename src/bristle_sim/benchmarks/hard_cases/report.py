"""The report of hard cases: the promise and the result of every case, and the number of promises
kept.
"""

from __future__ import annotations

import logging
import textwrap
import time as clock
from collections.abc import Mapping, Sequence
from itertools import zip_longest

from bristle_sim.benchmarks.hard_cases import HardCaseChoice, contact, motion, strikes
from bristle_sim.benchmarks.hard_cases.measures import Finding, HardCase
from bristle_sim.comparison import Quantity, Report, Unfinished
from bristle_sim.readable import aligned

TABLES = {
    theme.__name__: theme
    for theme in (
        strikes.mass_ratio,
        motion.belt_stiffness,
        motion.damping,
        strikes.jam,
        strikes.grazing,
        motion.hub_speed,
        motion.tunnelling,
        motion.long_run,
        contact.chatter,
        contact.touching,
    )
}
"""Functions that yield the cases of a theme, by the name of the theme."""

Tried = Mapping[str, Sequence[tuple[HardCase, Finding]]]
"""Cases with their results, by theme."""


def hard_cases(requested: HardCaseChoice) -> Report:
    """Run the requested hard cases one after the other, and report their results.

    Raises:
        Unfinished: if the user interrupts the computation. The exception carries a report of the
            themes whose cases were run.
    """
    begin = clock.perf_counter()
    themes = tuple(TABLES) if requested.theme == "all" else (requested.theme,)
    tried: dict[str, list[tuple[HardCase, Finding]]] = {}
    try:
        for number, theme in enumerate(themes, start=1):
            logging.getLogger(__name__).info(
                "%s (theme %d of %d)", theme.replace("_", " "), number, len(themes)
            )
            tried[theme] = []
            for case in TABLES[theme]():
                tried[theme].append((case, case.run()))
    except KeyboardInterrupt:
        raise Unfinished(_report(tried, clock.perf_counter() - begin)) from None
    return _report(tried, clock.perf_counter() - begin)


def _report(tried: Tried, wall_s: float) -> Report:
    """Return the report of the hard cases that were run.

    Its quantities are the number of kept promises in each theme, compared with the number of cases.
    """
    quantities = []
    rows = []
    for theme, cases in tried.items():
        kept = float(sum(finding.ok for _, finding in cases))
        name = f"{theme}_promises_kept"
        quantities.append(Quantity(name, "1", kept, float(len(cases)), tolerance=0.0))
        rows += [
            {
                "theme": theme,
                "case": _named(theme, case),
                "promise": case.promise,
                "reached": finding.reached,
                "ok": finding.ok,
            }
            for case, finding in cases
        ]
    return Report(
        outcome=None,
        quantities=tuple(quantities),
        wall_s=wall_s,
        steps=sum(finding.steps for cases in tried.values() for _, finding in cases),
        remarks=("", *_table(tried)),
        extra={"rows": rows},
        subject=tried,
        answer=answer(tried),
    )


def answer(tried: Tried) -> str:
    """Return a sentence that says whether all cases keep their promises.

    If not, it lists the cases that break their promises.
    """
    number = sum(map(len, tried.values()))
    broken = [
        f"{_named(theme, case)} ({finding.reached})"
        for theme, cases in tried.items()
        for case, finding in cases
        if not finding.ok
    ]
    if broken:
        return (
            f"No: promises are broken in {len(broken)} of {number} hard cases: {'; '.join(broken)}."
        )
    return f"Yes: all {number} hard cases keep their promise."


def _named(theme: str, case: HardCase) -> str:
    return f"{theme.replace('_', ' ')}: {case.name}"


WIDTHS = (30, 30, 31, 3)
"""Widths of the table's columns, in characters; the table fits a terminal of 100 characters."""


def _table(tried: Tried) -> list[str]:
    left = range(len(WIDTHS))
    lines = [*aligned([("case", "promise", "reached", "ok")], left, WIDTHS), "-" * 100]
    for theme, cases in tried.items():
        lines.append(theme.replace("_", " "))
        for case, finding in cases:
            cells = [
                textwrap.wrap(case.name, 30, initial_indent="  ", subsequent_indent="  "),
                textwrap.wrap(case.promise, 30),
                textwrap.wrap(finding.reached, 31),
                ["yes" if finding.ok else "NO"],
            ]
            lines += aligned(list(zip_longest(*cells, fillvalue="")), left, WIDTHS)
    return lines
