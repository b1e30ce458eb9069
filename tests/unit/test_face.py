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
        assert name == "__version__" or found.__doc__


def test_a_type_checker_sees_the_names_that_a_program_sees():
    tree = ast.parse(Path(bristle_sim.__file__).read_text(encoding="utf-8"))
    typed = [
        each.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for each in node.names
    ]
    assert {*typed} - {"TYPE_CHECKING", "Any", "import_module"} == {*bristle_sim.__all__}


def test_the_docstring_runs():
    found = doctest.testmod(bristle_sim)
    assert found.attempted >= 4
    assert found.failed == 0


def test_the_import_takes_no_library_and_few_modules():
    """The modules beyond those of a bare interpreter: this package's face alone, and of the standard library a handful."""
    script = "import sys; before = set(sys.modules); import bristle_sim;print(*sorted(set(sys.modules) - before))"
    run = subprocess.run(
        [sys.executable, "-I", "-c", script], capture_output=True, text=True, check=True
    )
    imported = run.stdout.split()
    tops = {name.partition(".")[0] for name in imported} - {"bristle_sim"}
    assert tops <= sys.stdlib_module_names
    assert [name for name in imported if name.startswith("bristle_sim.")] == []
    assert len(imported) < 50


WITHOUT_EXTRAS = """
import sys
sys.modules |= dict.fromkeys(["distributed", "joblib", "tqdm", "xarray", "zarr", "imageio_ffmpeg", "PIL", "pandas"])
import pydoc
import bristle_sim as bs
assert hasattr(bs, "sweep")
text = pydoc.plain(pydoc.render_doc(bs))
assert all(name in text for name in bs.__all__ if name != "__version__")
from bristle_sim import *
assert Tool and EnergeticContact
try:
    sweep(None, {})
except ImportError as error:
    print(error)
"""


def test_help_and_star_imports_work_without_the_extras():
    run = subprocess.run(
        [sys.executable, "-c", WITHOUT_EXTRAS], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.endswith("pip install 'bristle_sim[sweep]'\n")


def test_an_unknown_name_is_refused_and_a_sweep_names_its_extra(monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(AttributeError, match="no attribute 'Tol'"):
        bristle_sim.Tol  # noqa: B018
    monkeypatch.setitem(sys.modules, "xarray", None)
    monkeypatch.delitem(sys.modules, "bristle_sim.studies.sweep", raising=False)
    monkeypatch.delitem(sys.modules, "bristle_sim.studies.sweep_store", raising=False)
    monkeypatch.delitem(vars(bristle_sim), "sweep", raising=False)
    with pytest.raises(ImportError, match=r"pip install 'bristle_sim\[sweep\]'"):
        bristle_sim.sweep(None, {})
