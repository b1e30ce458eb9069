"""Long work that is interrupted keeps its finished part; hard cases that break their promise are named."""

from __future__ import annotations

import pytest

from bristle_sim.benchmarks.accuracy_cost import Effort, study
from bristle_sim.benchmarks.hard_cases import report
from bristle_sim.benchmarks.hard_cases.measures import Finding, HardCase
from bristle_sim.comparison import Unfinished
from bristle_sim.dissertation import figures


def interrupted(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("module", "step", "run", "kept"),
    [
        (
            report,
            "TABLES",
            lambda: report.hard_cases(report.HardCaseChoice("grazing")),
            "rows",
        ),
        (study, "_measure", lambda: study.accuracy_cost(Effort("quick", "none")), "curves"),
        (figures, "redrawn", lambda: figures.figures_report(figures.Selection("4.6")), None),
    ],
)
def test_an_interruption_keeps_what_is_finished(
    module, step, run, kept, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = getattr(module, step)
    monkeypatch.setattr(
        module, step, dict.fromkeys(there, interrupted) if isinstance(there, dict) else interrupted
    )
    with pytest.raises(Unfinished) as ended:
        run()
    assert kept is None or ended.value.report.extra[kept] == []


def test_hard_cases_that_break_their_promise_are_named() -> None:
    case = HardCase("a ball", "rests", lambda: Finding("rests", True))
    kept = (case, Finding("rests", True))
    assert report.answer({"chatter": [kept]}) == "Yes: all 1 hard cases keep their promise."
    broken = report.answer({"chatter": [kept, (case, Finding("sinks", False))]})
    failing = HardCase("a ball", "rests", lambda: Finding(str(1 / 0), True))
    assert failing.run() == Finding("ZeroDivisionError: division by zero", False)
    assert broken == "No: promises are broken in 1 of 2 hard cases: chatter: a ball (sinks)."
