"""A parameter has one name: on the command line, in tool files, JSON, the headings of a sweep's table, messages and docstrings."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from pathlib import Path

import pytest

import bristle_sim as bs
from bristle_sim.cli import command, output
from bristle_sim.comparison import Report
from bristle_sim.parameters import PARTS, tool_keys
from bristle_sim.stop_reason import EVENTS
from bristle_sim.units import Choice, Range, declarations

SCENARIOS = {name: command.load(path) for name, path in command.scripts().items()}
DECLARED = {part: declarations(part) for each in SCENARIOS.values() for part in each.parts}


@pytest.mark.parametrize("part", DECLARED, ids=lambda part: part.__name__)
def test_a_declaration_documents_its_field_and_names_its_key_in_refusals(part: type) -> None:
    text = " ".join(("", *(part.__doc__ or "").rpartition("Attributes:")[2].split()))
    for field, declared in DECLARED[part].items():
        entry = text.partition(f" {field} ({declared.key}): " if field != declared.key else f" {field}: ")[2]
        unit = "" if declared.unit in ("1", "word") else f", {declared.unit}"
        assert entry.startswith(f"{declared.meaning}{unit}. Must be {declared.allowed}. Default "), field
        assert f" ({declared.source})" in entry, field
        with pytest.raises(ValueError, match=rf"^{declared.key} = "):
            part(**{field: object()})
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(part(), field, getattr(part(), field))


@pytest.mark.parametrize("name", SCENARIOS)
def test_keys_are_those_of_the_declarations_in_files_and_documents(name: str, tmp_path: Path) -> None:
    scenario = SCENARIOS[name]
    of_parts = {each.key for part in scenario.parts for each in DECLARED[part].values()}
    assert {*scenario.keys()} == of_parts - {*scenario.without}
    values = scenario.values_of([])
    assert [*json.loads(output.document(name, values, Report(None, ())))["parameters"]] == [*scenario.keys()]
    given = {key: value for key, value in values.items() if value is not None}
    path = tmp_path / "tool.toml"
    path.write_text("".join(f"{key} = {json.dumps(value)}\n" for key, value in given.items()), encoding="utf-8")
    assignments, _ = scenario.assignments_from(str(path))
    assert [each.partition("=")[0] for each in assignments] == [*given]


def test_a_tool_file_and_replace_have_the_keys_of_the_command_line(tmp_path: Path) -> None:
    bs.write_tool(bs.Tool(), tmp_path / "tool.toml")
    lines = [line.removeprefix("# ") for line in (tmp_path / "tool.toml").read_text(encoding="utf-8").splitlines()]
    for part, keys in tool_keys().items():
        for key, (field, declared) in keys.items():
            assert any(line.startswith(f"{key} = ") for line in lines), key
            owner = PARTS[part][0]() if part else bs.Tool()
            value = getattr(owner, field)
            if value is not None:
                changed = bs.Tool().replace(**{key: value})
                assert getattr(getattr(changed, part) if part else changed, field) == value
            assert isinstance(declared, Range | Choice)


def test_a_sweep_heads_its_columns_with_key_and_unit(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("zarr", reason="needs the extra sweep")
    for key, (declared, default) in SCENARIOS["oblique_impact"].keys().items():
        if isinstance(declared, Range) and default is not None:
            assert command.main(["oblique_impact", "--sweep", f"{key}={default!r}:{default!r}:1", "--csv", "-"]) == 0
            heading = next(csv.reader(io.StringIO(capsys.readouterr().out)))[0]
            assert heading == (key if declared.unit == "1" else f"{key} ({declared.unit})")


def test_help_lists_events_and_laws() -> None:
    assert all(f"``{event}``" in " ".join((bs.simulate.__doc__ or "").split()) for event in EVENTS)
    assert all(law in (bs.Contact.__doc__ or "") for law in ("energetic", "compliant", "engine"))
