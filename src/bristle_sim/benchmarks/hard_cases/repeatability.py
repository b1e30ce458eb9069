"""Same input, same bits: again, among other runs, in threads and processes, optimized, saved, loaded and gone on with."""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import itertools
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import bristle_sim
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, same_bits, within, worst
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Surface, Tool, Workpart
from bristle_sim.scene.resume import resume
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["bits", "cases", "fingerprint", "guards"]

THEME = "repeatability"

SETTINGS = Settings(accuracy=1e-6)

AGREEMENT = 2.0
"""Two runs that are each within the accuracy asked for differ by at most so many times as much."""

TOOLS = {
    "energetic": Tool(),
    "engine": Tool(contact=Contact("engine")),
    "compliant": Tool(contact=Contact("compliant")),
    "compliant, 0.1 ms": Tool(contact=Contact("compliant", 1e-4)),
    "damped, bar that throws back": Tool(belt=Belt(damping_ratio=0.05), bar=Bar(restitution=0.9)),
    "bent, rough bar and workpart": Tool(
        bristle=Bristle(knee_angle_deg=20.0), bar=Bar(friction=0.2), workpart=Workpart(friction=0.6)
    ),
}
"""Passes by each contact law and with what else a scene can hold."""

RODS = Chain((5.0, 5.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))

STOPS = ("bar touch", "bar release", "largest retraction", "highest relative speed", "strike", "workpart release")
"""Events at which a run is interrupted: in flight, just thrown back, held, just released."""

PROCESSES = (("-O", "1"), ("-OO", "2"), ("-B", "3"))
"""An option of the interpreter, and a seed of its hashes."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Quick: each kind of repetition with the run or two that say most."""
    names = tuple(runs()) if full else FEW
    tools = tuple(TOOLS) if full else FEW[:2]
    stops = STOPS if full else ("bar release", "strike")
    return (
        *(_case(f"{name}: again, after another run", "same bits", partial(_again, name)) for name in names),
        _case("four threads at a time", "same bits as one after the other", partial(_threads, names)),
        *(
            _case(
                f"another process, python {option}, other hash seed",
                "same bits",
                partial(_process, option, seed, names),
            )
            for option, seed in PROCESSES[: 3 if full else 2]
        ),
        *(_case(f"{name}: saved and loaded", "equal to the bit", partial(_loaded, name)) for name in tools),
        *(
            _case(
                f"{name}: stopped at an event, loaded, gone on",
                f"as from memory to the bit; as not stopped to {AGREEMENT:g} times the accuracy"
                f" {SETTINGS.accuracy:g}, as no state holds cached impulses and choice of stretches",
                partial(_gone_on, name, stops),
            )
            for name in tools
        ),
        _case("asserts in the source", "none guards input or acts: python -O leaves them out", _asserts),
    )


def _case(name: str, promise: str, measure: Callable[[], Finding]) -> HardCase:
    return HardCase(THEME, name, promise, measure)


Run = Callable[[], object]

FEW = ("energetic", "compliant, 0.1 ms", "two rods, compliant")
"""Of all runs, those that a quick round repeats."""


def runs() -> dict[str, Run]:
    """What is repeated."""
    passes: dict[str, Run] = {name: partial(simulate, tool, SETTINGS) for name, tool in TOOLS.items()}
    strikes: dict[str, Run] = {
        f"two rods, {law}": partial(_strike, law) for law in ("energetic", "compliant", "engine")
    }
    steps = partial(simulate, Tool(), Settings(step=2e-5))
    return {**passes, **strikes, "plain steps": steps}


def _strike(law: str) -> ContactRecord:
    return strike(RODS, Surface(0.5, None, 0.5), Contact(law), SETTINGS).contact


def bits(result: object) -> str:
    """Every bit of a result but what it cost in time, as a short text."""
    digest = hashlib.sha256()
    _take(digest.update, result)
    return digest.hexdigest()[:16]


def _take(update: Callable[[bytes], None], part: object) -> None:
    if dataclasses.is_dataclass(part):
        for each in dataclasses.fields(part):
            if each.name not in ("wall_s", "cpu_s"):
                _take(update, getattr(part, each.name))
    elif isinstance(part, tuple | list):
        update(b"(")
        for each in part:
            _take(update, each)
    elif hasattr(part, "tobytes"):
        update(part.tobytes())
    else:
        update(repr(part).encode())


def fingerprint(*names: str) -> str:
    """Bits of the runs of these names, one after the other."""
    return " ".join(bits(runs()[name]()) for name in names)


def _again(name: str) -> Finding:
    todo = runs()
    first = bits(todo[name]())
    others = itertools.cycle(todo)
    while next(others) != name:
        pass
    todo[next(others)]()
    return same_bits(first, bits(todo[name]()), "bits")


def _threads(names: Sequence[str]) -> Finding:
    with ThreadPoolExecutor(4) as pool:
        found = " ".join(pool.map(fingerprint, names))
    return same_bits(fingerprint(*names), found, f"{len(names)} runs")


def _process(option: str, seed: str, names: Sequence[str]) -> Finding:
    program = f"import sys; from {__name__} import fingerprint; print(fingerprint(*sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, option, "-c", program, *names],
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
        env=os.environ | {"PYTHONHASHSEED": seed},
    )
    if done.returncode:
        return Finding(f"exit status {done.returncode}: {' '.join(done.stderr.split())[-100:]}", False)
    return same_bits(fingerprint(*names), done.stdout.strip(), f"{len(names)} runs")


def _loaded(name: str) -> Finding:
    run = simulate(TOOLS[name], SETTINGS)
    return both(
        same_bits(bits(run), bits(_stored(run)), f"{run.time.size} samples, {len(run.contacts)} contacts"),
        same_bits((run.cost, run.parameters), (_stored(run).cost, _stored(run).parameters), "cost and parameters"),
    )


def _stored(run: Trajectory) -> Trajectory:
    with tempfile.TemporaryDirectory() as folder:
        run.save(Path(folder) / "run.npz")
        return Trajectory.load(Path(folder) / "run.npz")


def _gone_on(name: str, stops: Sequence[str]) -> Finding:
    whole = simulate(TOOLS[name], SETTINGS)
    stopped = [simulate(TOOLS[name], SETTINGS, stop_after=stop) for stop in stops if whole.event_time(stop) is not None]
    ours, loaded = [resume(run) for run in stopped], [resume(_stored(run)) for run in stopped]
    off = worst([difference(run, whole) for run in ours])
    return both(
        Finding(f"{len(stopped)} events", bool(stopped)),
        same_bits([bits(run) for run in ours], [bits(run) for run in loaded], "from memory and from the file"),
        within(off, AGREEMENT * SETTINGS.accuracy, "off the run not stopped by", sum(run.cost.steps for run in ours)),
    )


def difference(one: Trajectory, other: Trajectory) -> float:
    """Largest relative difference of two passes: time, rate and impulse of the strike, all impulses, and the end."""
    pairs = [(one.time[-1], other.time[-1]), (one.angles[-1, 0], other.angles[-1, 0])]
    pairs += [(sum(each.impulse[0] for each in one.contacts), sum(each.impulse[0] for each in other.contacts))]
    strikes = [run.first_contact("workpart") for run in (one, other)]
    if strikes[0] is not None and strikes[1] is not None:
        first, second = strikes[0], strikes[1]
        pairs += [(first.time, second.time), (first.impulse[0], second.impulse[0])]
        pairs += [(first.rates_before[0], second.rates_before[0]), (first.rates_after[0], second.rates_after[0])]
    fastest = abs(other.rates).max()
    ended = abs(one.rates[-1, 0] - other.rates[-1, 0]) / fastest
    return worst([float(ended), *(float(a / b - 1.0) for a, b in pairs)])


def _asserts() -> Finding:
    """``assert x is not None`` and ``assert isinstance(...)`` tell a type checker what is known already."""
    sources = {file.name: file.read_text(encoding="utf-8") for file in Path(bristle_sim.__file__).parent.rglob("*.py")}
    found = [f"{name}:{line}" for name, source in sorted(sources.items()) for line in guards(source)]
    return Finding(f"{', '.join(found) or 'none'} in {len(sources)} files", not found)


def guards(source: str) -> list[int]:
    """Lines of asserts that do more than tell a type."""
    if "assert " not in source:
        return []
    asserts = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Assert)]
    return [node.lineno for node in asserts if not _tells_a_type(node.test)]


def _tells_a_type(test: ast.expr) -> bool:
    if isinstance(test, ast.Compare):
        plain = isinstance(test.left, ast.Name | ast.Attribute)
        return plain and isinstance(test.ops[0], ast.IsNot) and ast.unparse(test.comparators[0]) == "None"
    return isinstance(test, ast.Call) and ast.unparse(test.func) == "isinstance"
