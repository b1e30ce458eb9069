"""A function's identity is all that it refers to: whatever of it changes is noticed, and nothing else."""

from __future__ import annotations

import functools
import math
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim.studies.sweep_identity import identity_of

SOURCES = {
    "number": ("P = {}", "P * x"),
    "NumPy number": ("import numpy as np\nP = np.float64({})", "P * x"),
    "tuple": ("P = ({},)", "P[0] * x"),
    "list": ("P = [{}]", "P[0] * x"),
    "dict": ("P = {{'mu': {}}}", "P['mu'] * x"),
    "set of words": ("P = {{'a', 'b', 'c', str({})}}", "'a' in P"),
    "frozen set": ("P = frozenset({{'a', str({})}})", "'a' in P"),
    "read-only dict": ("import types\nP = types.MappingProxyType({{'mu': {}}})", "P['mu'] * x"),
    "array": ("import numpy as np\nP = np.array([{}])", "P[0] * x"),
    "tool": ("import bristle_sim as bs\nP = bs.Tool(hub=bs.Hub(speed={}))", "P.hub.speed * x"),
    "function": ("def g(x): return x * {}", "g(x)"),
    "recursive function": ("def g(x): return g(x - 1) if x > 0 else {}", "g(x)"),
    "lambda": ("g = lambda x: x * {}", "g(x)"),
    "partial": ("import functools, math\ng = functools.partial(math.pow, {})", "g(x)"),
    "cached function": ("import functools\n@functools.cache\ndef g(x): return x * {}", "g(x)"),
    "static method": ("class C:\n    @staticmethod\n    def g(x): return x * {}", "C.g(x)"),
    "property": ("class C:\n    @property\n    def g(self): return {}", "C().g"),
    "base class": ("class B:\n    k = {}\nclass C(B): pass", "C.k"),
    "instance": ("class C:\n    def __init__(self, k): self.k = k\nP = C({})", "P.k"),
    "dataclass": ("import dataclasses\n@dataclasses.dataclass(slots=True)\nclass C:\n    k: float = {}", "C().k"),
    "comprehension": ("P = {}", "sum([P * k for k in (x,)])"),
    "inner lambda": ("P = {}", "(lambda y: P * y)(x)"),
    "default": ("", "(lambda y, k={}: k * y)(x)"),
}
"""What a function refers to, and how; a number stands for {}."""


def made(source: str, expression: str, number: float) -> Callable[..., Any]:
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(f"{source.format(number)}\ndef f(x): return {expression.replace('{}', str(number))}", names)
    return names["f"]


@pytest.mark.parametrize("name", SOURCES)
def test_a_change_of_anything_that_a_function_refers_to_is_noticed(name: str):
    before, same, after = (identity_of(made(*SOURCES[name], number)) for number in (0.3, 0.3, 0.6))
    assert before == same != after


def test_a_function_stands_for_itself_wherever_and_whenever_it_is_defined(tmp_path: Path):
    """Neither its lines nor the order of sets, which differs from process to process, have a part in it."""
    body = "\n".join(f"{source.format(0.3)}\ndef f{i}(x): return {expression.replace('{}', '0.3')}"
                     for i, (source, expression) in enumerate(SOURCES.values()))  # fmt: skip
    shown = "\nfrom bristle_sim.studies.sweep_identity import identity_of\n"
    shown += f"print([identity_of(f) for f in [{', '.join(f'f{i}' for i in range(len(SOURCES)))}]])"
    outputs = set()
    for name, start in (("one.py", ""), ("two.py", "\n\n# moved\n")):
        (tmp_path / name).write_text(start + body + shown)
        run = subprocess.run([sys.executable, tmp_path / name], capture_output=True, text=True, check=True)
        outputs.add(run.stdout)
    assert len(outputs) == 1


@pytest.mark.parametrize("within", [False, True])
def test_a_module_of_the_user_counts_as_far_as_it_is_used(within: bool, tmp_path: Path):
    """Imported at the top or within the function; a lock that is not used does no harm."""
    main = "{top}def f(x):\n    {inner}return helper.g(x)\nfrom bristle_sim.studies.sweep_identity import identity_of\n"
    line = "import helper\n"
    script = main.format(top="" if within else line, inner=f"{line}    " if within else "") + "print(identity_of(f))"
    (tmp_path / "script.py").write_text(script)
    found = []
    for number, more in ((1, ""), (1, "UNUSED = 3"), (2, "")):
        helper = f"import threading\nLOCK = threading.Lock()\ndef g(x): return {number} * x\n{more}\n"
        (tmp_path / "helper.py").write_text(helper)
        command = [sys.executable, "-B", str(tmp_path / "script.py")]
        found.append(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert found[0] == found[1] != found[2]


class Adder:
    """Adds what it was made with."""

    def __init__(self, more: float) -> None:
        self.more = more

    def add(self, x: float) -> float:
        return x + self.more


def test_methods_stand_for_their_object_and_installed_functions_for_their_name():
    assert identity_of(Adder(1.0).add) == identity_of(Adder(1.0).add) != identity_of(Adder(2.0).add)
    assert len({identity_of(each) for each in (math.sin, max, np.sin, np.cos, functools.partial(max, 1))}) == 5
    assert identity_of(max) != identity_of(max, version="2")


LOCK = threading.Lock()


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda x: x if LOCK else 0.0, "lock"),
        (functools.partial(max, (each for each in ())), "generator"),
        (np.frompyfunc(lambda x: x, 1, 1), "known by its name alone"),
    ],
)
def test_an_object_whose_changes_cannot_be_seen_is_refused_in_one_line(function: Callable[..., Any], words: str):
    with pytest.raises(
        ValueError, match=f"must not refer to objects whose changes a store cannot see .*{words}"
    ) as refusal:
        identity_of(function)
    assert "\n" not in str(refusal.value)
