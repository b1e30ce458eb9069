"""What ``import bristle_sim`` offers: names imported when they are first used, and a docstring that runs."""

from __future__ import annotations

import ast
import doctest
import subprocess
import sys
from pathlib import Path

import pytest

import bristle_sim


def test_every_name_is_there_and_says_what_it_does():
    for name in bristle_sim.__all__:
        found = getattr(bristle_sim, name)
        assert name in dir(bristle_sim)
        assert name == "__version__" or found.__doc__


def test_a_type_checker_sees_the_names_that_a_program_sees():
    tree = ast.parse(Path(bristle_sim.__file__).read_text(encoding="utf-8"))
    typed = [each.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for each in node.names]
    assert {*typed} - {"TYPE_CHECKING", "Any", "import_module"} == {*bristle_sim.__all__} - {"__version__"}


def test_the_docstring_runs():
    found = doctest.testmod(bristle_sim)
    assert found.attempted >= 4
    assert found.failed == 0


def test_an_unknown_name_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'Tol'"):
        bristle_sim.Tol  # noqa: B018


def test_the_import_takes_no_library_and_30_ms():
    """Neither NumPy nor pymunk; the bound is the promise; the least CPU time of five imports keeps a busy machine out."""
    script = (
        "import sys, time; t = time.process_time(); import bristle_sim; t = time.process_time() - t;"
        "print(t, sorted({'numpy', 'pymunk', 'scipy', 'matplotlib', 'xarray'} & set(sys.modules)))"
    )
    runs = [
        subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True) for _ in range(5)
    ]
    seconds, libraries = zip(*(run.stdout.split(maxsplit=1) for run in runs), strict=True)
    assert min(map(float, seconds)) < 0.03
    assert {each.strip() for each in libraries} == {"[]"}


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delitem(bristle_sim.__dict__, "sweep", raising=False)
    monkeypatch.delitem(sys.modules, "bristle_sim.studies.sweep", raising=False)
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(ImportError, match=r"pip install 'bristle_sim\[sweep\]'"):
        bristle_sim.sweep  # noqa: B018
