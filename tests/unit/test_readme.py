"""What README shows must run."""

import re
from pathlib import Path
from typing import Any

import pytest

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


def test_the_python_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(code, "README.md", "exec"), names)
    first = names["impacts"][0]
    assert first.outcome_name == "rebound"
    assert first.energy_change < 0.0
    assert first.phases[0] == "compression slip"
    assert capsys.readouterr().out.startswith("rebound ")


def test_named_files_exist() -> None:
    root = Path(__file__).parents[2]
    named = set(re.findall(r"\]\(([\w./-]+)\)", README)) | set(re.findall(r"`?scenarios/(\w+\.py)", README))
    for name in named:
        assert (root / name).exists() or (root / "scenarios" / name).exists(), name
