"""The report of hard cases: every promise with its result, and the number of promises kept."""

from __future__ import annotations

import logging
import textwrap
import time as clock
from collections.abc import Sequence

from bristle_sim.benchmarks.hard_cases import HardCaseChoice, contact, motion, strikes
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase
from bristle_sim.comparison import Quantity, Report, Unfinished, side_by_side

THEMES = (
    *(
        strikes.mass_ratio,
        motion.belt_stiffness,
        motion.damping,
        strikes.jam,
        strikes.grazing,
        motion.hub_speed,
    ),
    *(
        motion.tunnelling,
        motion.long_run,
        contact.chatter,
        contact.touching,
        motion.wires,
        motion.size,
        motion.budget,
    ),
)
"""Functions that yield the cases of the themes; a theme has the name of its function."""

TABLES = {theme.__name__: theme for theme in THEMES}

Tried = Sequence[tuple[HardCase, Finding]]


def cases_of(theme: str, *, full: bool) -> tuple[HardCase, ...]:
    """Return the cases of one theme; without ``full``, only those at quick effort."""
    return tuple(case for case in TABLES[theme]() if full or case.quick)


def hard_cases(requested: HardCaseChoice) -> Report:
    """Try the requested cases, one after the other.

    Raises:
        Unfinished: if the user interrupts; it has a report of the cases tried so far.
    """
    begin = clock.perf_counter()
    themes = tuple(TABLES) if requested.theme == "all" else (requested.theme,)
    tried: list[tuple[HardCase, Finding]] = []
    try:
        for number, theme in enumerate(themes, start=1):
            logging.getLogger(__name__).info(
                "%s (theme %d of %d)", theme.replace("_", " "), number, len(themes)
            )
            for case in cases_of(theme, full=requested.effort == "full"):
                tried.append((case, case.run()))
    except KeyboardInterrupt:
        raise Unfinished(_report(tried, clock.perf_counter() - begin)) from None
    return _report(tried, clock.perf_counter() - begin)


def _report(tried: Tried, wall_s: float) -> Report:
    """Return the report, which compares the kept promises of each theme with the number of its
    cases.
    """
    kept = []
    for theme in dict.fromkeys(case.theme for case, _ in tried):
        verdicts = [finding.ok for case, finding in tried if case.theme == theme]
        kept.append(
            Quantity(
                f"{theme}_promises_kept",
                "1",
                float(sum(verdicts)),
                float(len(verdicts)),
                tolerance=0.0,
            )
        )
    rows = [
        {
            "theme": case.theme,
            "case": _named(case),
            "promise": case.promise,
            "reached": each.reached,
            "ok": each.ok,
        }
        for case, each in tried
    ]
    return Report(
        outcome=None,
        quantities=tuple(kept),
        wall_s=wall_s,
        steps=sum(finding.steps for _, finding in tried),
        remarks=("", *_table(tried)),
        extra={"rows": rows},
        subject=tried,
        answer=answer(tried),
    )


def answer(tried: Tried) -> str:
    """Return the sentence that all cases keep their promise, or that lists the broken ones."""
    broken = [f"{_named(case)} ({finding.reached})" for case, finding in tried if not finding.ok]
    if broken:
        return f"No: {len(broken)} of {len(tried)} hard cases break their promise: {'; '.join(broken)}."
    return f"Yes: all {len(tried)} hard cases keep their promise."


def _named(case: HardCase) -> str:
    return f"{case.theme.replace('_', ' ')}: {case.name}"


WIDTHS = (30, 30, 31, 3)
"""Widths of the columns of the table, in characters; the table fits a terminal of 100."""


def _table(tried: Tried) -> list[str]:
    lines = [*side_by_side([["case"], ["promise"], ["reached"], ["ok"]], WIDTHS), "-" * 100]
    theme = ""
    for case, finding in tried:
        lines += [case.theme.replace("_", " ")] if case.theme != theme else []
        theme = case.theme
        name, promise, reached = map(
            textwrap.wrap, (case.name, case.promise, finding.reached), (28, 30, 31)
        )
        cells = ([f"  {each}" for each in name], promise, reached, ["yes" if finding.ok else "NO"])
        lines += side_by_side(cells, WIDTHS)
    return lines
