"""A parameter has one name: on the command line, in tool files, JSON, the headings of a sweep's table, messages and docstrings."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

import bristle_sim as bs
from bristle_sim.cli.scenario import load_scenario, script_paths
from bristle_sim.declared import Choice, Range, declarations
from bristle_sim.parameters import FIELDS, PARTS
from bristle_sim.settings import EVENTS

SCENARIOS = {name: load_scenario(path) for name, path in script_paths().items()}
DECLARED = {part: declarations(part) for each in SCENARIOS.values() for part in each.parts}


@pytest.mark.parametrize("part", DECLARED, ids=lambda part: part.__name__)
def test_a_declaration_documents_its_field_and_names_its_key_in_refusals(part: type) -> None:
    text = " ".join(("", *(part.__doc__ or "").rpartition("Attributes:")[2].split()))
    for field, declared in DECLARED[part].items():
        entry = text.partition(f" {field}: ")[2]
        key = "" if field == declared.key else f" Key {declared.key}."
        unit = "" if declared.unit in ("1", "word") else f", {declared.unit}"
        assert entry.startswith(
            f"{declared.meaning}{unit}.{key} Must be {declared.allowed}. Default "
        ), field
        assert f" ({declared.source})" in entry, field
        with pytest.raises(ValueError, match=rf"^{declared.key} = "):
            part(**{field: object()})
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(part(), field, getattr(part(), field))


def test_a_tool_file_and_replace_have_the_keys_of_the_command_line(tmp_path: Path) -> None:
    bs.write_tool(bs.Tool(), tmp_path / "tool.toml")
    lines = [
        line.removeprefix("# ")
        for line in (tmp_path / "tool.toml").read_text(encoding="utf-8").splitlines()
    ]
    for part, fields in FIELDS.items():
        for field, declared in fields.items():
            key = declared.key
            assert any(line.startswith(f"{key} = ") for line in lines), key
            owner = PARTS[part][0]() if part else bs.Tool()
            value = getattr(owner, field)
            if value is not None:
                changed = bs.Tool().replace(**{key: value})
                assert getattr(getattr(changed, part) if part else changed, field) == value
            assert isinstance(declared, Range | Choice)


def test_help_lists_events_and_laws() -> None:
    assert all(f"``{event}``" in " ".join((bs.simulate.__doc__ or "").split()) for event in EVENTS)
    assert all(law in (bs.Contact.__doc__ or "") for law in ("energetic", "compliant", "engine"))
