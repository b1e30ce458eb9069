"""Writes table, JSON and CSV, and checks the files that options name before anything is computed."""

from __future__ import annotations

import csv
import json
import math
import os
import sys
import textwrap
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from bristle_sim import __version__
from bristle_sim.comparison import WIDTH, Report, finite, table
from bristle_sim.files import complete_or_absent, is_special
from bristle_sim.scenario_cli.scenario import Columns, Scenario, Values


def require_different(named: Iterable[tuple[str, Path | str | None]]) -> None:
    """Raise ValueError if two options or keys name one file; a device such as /dev/null may serve several."""
    seen: dict[str, str] = {}
    for option, path in named:
        if path is None or is_special(Path(path)):
            continue
        place = os.path.realpath(path)
        if place in seen:
            raise ValueError(f"{option} = {str(path)!r}: must be another file than that of {seen[place]}")
        seen[place] = option


def document(scenario: Scenario, values: Values, report: Report, *, finished: bool = True) -> str:
    """Return the results as JSON, in SI units at full precision; it says so if the work was interrupted."""
    found = {
        "scenario": scenario.name,
        "version": __version__,
        "parameters": dict(values),
        "outcome": report.outcome,
        "quantities": [row.as_dict() for row in report.quantities],
        "phases": list(report.phases),
        "events": [{"name": name, "time": time} for name, time in report.events if math.isfinite(time)],
        "cost": {"wall_s": report.wall_s, "steps": report.steps},
        **report.extra,
        **({} if finished else {"finished": False}),
    }
    return json.dumps(_plain(found), indent=1, allow_nan=False)


def _plain(value: Any) -> Any:
    """Turn values into JSON's own types; a number that is not finite becomes null."""
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "tolist"):  # NumPy's scalars and arrays
        return _plain(value.tolist())
    return finite(value) if isinstance(value, float) else value


def write_json(path: Path, text: str) -> None:
    """Write a JSON document to a file that appears only when complete."""
    with complete_or_absent(path) as partial:
        partial.write_text(text + "\n", encoding="utf-8")


def write_csv(path: Path, columns: Columns) -> None:
    """Write a time series at full precision: names and units in the first row, then one row a sample."""
    plain = [_plain(list(column)) for column in columns.values()]
    with complete_or_absent(path) as partial, partial.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*plain, strict=True))


def in_words(report: Report) -> str:
    """Return the table, the outcome where the question is about an impact, and the remarks."""
    lines = [table(report.quantities)]
    if report.outcome is not None:
        phases = f" ({', '.join(report.phases)})" if report.phases else ""
        lines += ["", *_wrapped(f"outcome: {report.outcome}{phases}")]
    elif report.remarks and report.remarks[0]:
        lines.append("")
    for remark in report.remarks:
        lines += _wrapped(remark)
    return "\n".join(lines)


def _wrapped(remark: str) -> list[str]:
    """Wrap a remark into lines that fit; one that is in columns or lines already stays as it is."""
    if len(remark) <= WIDTH or "\n" in remark or "  " in remark.strip():
        return [remark]
    return textwrap.wrap(remark, WIDTH, subsequent_indent="  ")


def say(text: str) -> None:
    """Print on standard output, where a reader that has seen enough, such as ``head``, is no error."""
    try:
        print(text, flush=True)
    except OSError as error:
        # Python flushes once more at exit: what is left must have somewhere to go.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise OSError(f"standard output: {error.strerror}") from None


def tell(text: str) -> None:
    """Print on standard error if there is one; print() would take standard output in its place."""
    if sys.stderr is not None:
        print(text, file=sys.stderr, flush=True)
