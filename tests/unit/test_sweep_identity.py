"""A function's identity: its name, its source text, the values bound to it, and the user's version."""

from __future__ import annotations

import functools
import linecache
import math
import subprocess
import sys
import threading
from collections import namedtuple
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bristle_sim as bs

pytest.importorskip("joblib", reason="needs the extra sweep")

from bristle_sim.studies.sweep_identity import identity_of

SHOWN = "from bristle_sim.studies.sweep_identity import identity_of\nprint(identity_of(f))\n"


def shown(folder: Path, *command: str) -> str:
    """The identity that a program prints; -B: a cached module would be taken for the new one of the same second."""
    line = [sys.executable, "-B", *command]
    return subprocess.run(line, cwd=folder, capture_output=True, text=True, check=True).stdout


def test_a_change_of_a_script_is_noticed_and_its_place_is_not(tmp_path: Path):
    script = "P = {{'a', 'b', str({})}}\ndef f(x, k=frozenset(P)): return len(P) * x\n" + SHOWN
    identities = []
    for name, number in (("one.py", 1), ("two.py", 1), ("one.py", 2)):
        (tmp_path / name).write_text(script.format(number))
        identities.append(shown(tmp_path, name))
    assert identities[0] == identities[1] != identities[2]


@pytest.mark.parametrize("helper", ["pk/h.py", "pk/sub/h.py", "h.py"])
def test_all_modules_of_a_package_count_and_others_do_not(helper: str, tmp_path: Path):
    (tmp_path / "pk" / "sub").mkdir(parents=True)
    (tmp_path / "pk" / "__init__.py").touch()
    (tmp_path / "pk" / "m.py").write_text("def f(x):\n    from .h import g\n    return g(x)\n")
    identities = set()
    for number in (1, 2):
        (tmp_path / helper).write_text(f"def g(x): return {number} * x")
        identities.add(shown(tmp_path, "-c", f"from pk.m import f\n{SHOWN}"))
    assert len(identities) == (2 if helper.startswith("pk") else 1)


def scaled(factor: Any) -> Callable[[float], float]:
    return lambda x, power=2: factor * x**power


class Adder:
    """Adds the value that it was made with."""

    def __init__(self, more: float) -> None:
        self.more = more

    def __call__(self, x: float) -> float:
        return x + self.more

    add = __call__


Pair = namedtuple("Pair", "first second")


@pytest.mark.parametrize(
    "bound",
    [
        lambda number: functools.partial(math.pow, number),
        lambda number: functools.partial(scaled, factor={"mu": [number]}),
        lambda number: functools.partial(scaled, np.array([number])),
        lambda number: functools.partial(scaled, bs.Tool(workpart=bs.Workpart(friction=number))),
        lambda number: functools.partial(scaled, Pair(number, 1.0)),
        lambda number: functools.partial(scaled, scaled(number)),
        lambda number: functools.lru_cache(scaled(number)),
        lambda number: scaled(frozenset(("a", "b", str(number)))),
        Adder,
        lambda number: Adder(number).add,
    ],
)
def test_values_bound_to_a_function_are_part_of_it(bound: Callable[[float], Any]):
    """By partial, a default, a surrounding function or an object."""
    assert identity_of(bound(0.3)) == identity_of(bound(0.3)) != identity_of(bound(0.6))


def test_functions_of_one_text_and_installed_ones_differ():
    one, two = (lambda x: x), (lambda x: 2 * x)
    assert identity_of(one) != identity_of(two)
    assert (
        len(
            {
                identity_of(each)
                for each in (math.sin, max, np.sin, np.cos, functools.partial(max, 1))
            }
        )
        == 5
    )
    assert identity_of(max) != identity_of(max, version="2")


def test_a_notebook_s_cell_is_its_source(monkeypatch: pytest.MonkeyPatch):
    """IPython keeps the text of a cell in linecache, under the name that it compiles it with."""
    identities = []
    for text in ("def f(x): return x", "def f(x): return 2 * x"):
        names: dict[str, Any] = {"__name__": "__main__"}
        exec(compile(text, "<cell 1>", "exec"), names)
        monkeypatch.setitem(linecache.cache, "<cell 1>", (len(text), None, [text], "<cell 1>"))
        identities.append(identity_of(names["f"]))
    assert len({*identities}) == 2


LOCK = threading.Lock()


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (functools.partial(max, LOCK), "an object of the type 'lock'"),
        (functools.partial(max, (each for each in ())), "an object of the type 'generator'"),
        (np.frompyfunc(lambda x: x, 1, 1), r"the ufunc '<lambda> \(vectorized\)'"),
        (eval("lambda x: x", {"__name__": "__main__"}), "'<lambda>', which has no source text"),
    ],
)
def test_a_function_whose_changes_cannot_be_noticed_needs_a_version(
    function: Callable[..., Any], words: str, monkeypatch: pytest.MonkeyPatch
):
    """Under the name of the text that ``eval`` compiles, Python 3.13 keeps the text of ``python -c``."""
    monkeypatch.setitem(linecache.cache, "<string>", (5, None, ["pass\n"], "<string>"))
    message = rf"^function = [^ ]+: a store cannot notice changes of {words}; pass version=\.\.\.$"
    with pytest.raises(ValueError, match=message):
        identity_of(function)
    assert (
        identity_of(function, version="1")
        == identity_of(function, version="1")
        != identity_of(function, version="2")
    )
