"""Files that hold a run completely or not at all, and refuse in one line whatever is no run."""

from __future__ import annotations

import dataclasses
import json
import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Contact, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.simulate import simulate, simulate_row
from bristle_sim.trajectory import Trajectory, storage


@pytest.fixture(scope="module")
def run() -> Trajectory:
    """A pass with a contact in time, up to its strike."""
    return simulate(Tool(contact=Contact("compliant", 1e-4)), stop_after="strike")


@pytest.fixture
def saved(run: Trajectory, tmp_path: Path) -> Path:
    run.save(tmp_path / "run.npz")
    return tmp_path / "run.npz"


def test_a_file_holds_everything(run: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """To the last bit, under the name given; what was there before is replaced."""
    monkeypatch.chdir(tmp_path)
    Path("pass").write_text("something else")
    bare = dataclasses.replace(run, contacts=(), events=(), parameters={})
    for each in (run, bare):
        each.save("pass")
        assert [path.name for path in tmp_path.iterdir()] == ["pass"]
        assert Trajectory.load("pass") == each


def refused(path: Path, why: str = "") -> None:
    with pytest.raises(
        ValueError, match=rf"{re.escape(path.name)}: cannot be read as a trajectory [^\n]*{why}"
    ):
        Trajectory.load(path)


@pytest.mark.parametrize(
    "content", [b"", b"hello", b"PK\x03\x04 not a zip", b"\x80\x04K\x01.", b"\x93NUMPY"]
)
def test_other_files_are_refused(content: bytes, tmp_path: Path):
    (tmp_path / "other.npz").write_bytes(content)
    refused(tmp_path / "other.npz")
    np.savez(tmp_path / "arrays.npz", time=np.zeros(3))
    refused(tmp_path / "arrays.npz")


def rewrite(
    path: Path,
    change: Callable[[dict[str, Any]], Any] = lambda meta: meta,
    dtype: Any = None,
    **arrays: Any,
):
    """Change the metadata or arrays of a saved file."""
    with np.load(path) as stored:
        every = dict(stored)
    meta = json.loads(str(every.pop("metadata")))
    np.savez(path, metadata=np.array(json.dumps(change(meta)), dtype=dtype), **{**every, **arrays})


def contact(meta: dict[str, Any], **values: Any) -> dict[str, Any]:
    """The metadata with values of the last contact changed."""
    return meta | {"contacts": [*meta["contacts"][:-1], meta["contacts"][-1] | values]}


CHANGED = "its content differs from what Trajectory.save wrote"


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda meta: meta | {"format": 1}, "written in format 1, this version reads format 4"),
        (lambda _: [], ""),
        (lambda meta: {key: value for key, value in meta.items() if key != "cost"}, CHANGED),
        (lambda meta: meta | {"hub_speed": "fast"}, CHANGED),
        (lambda meta: meta | {"hub_speed": np.nan}, CHANGED),
        (lambda meta: meta | {"parameters": [1]}, CHANGED),
        (lambda meta: meta | {"events": [{"name": 1, "time": 1.0}]}, CHANGED),
        (lambda meta: meta | {"events": meta["events"][::-1]}, CHANGED),
        (lambda meta: meta | {"cost": meta["cost"] | {"steps": "many"}}, CHANGED),
        (lambda meta: meta | {"contacts": ["bar"]}, CHANGED),
        (lambda meta: contact(meta, time=True), CHANGED),
        (lambda meta: contact(meta, impulse=[1.0]), CHANGED),
        (lambda meta: contact(meta, angles=[0.0, 0.0]), CHANGED),
        (
            lambda meta: meta | {"contacts": meta["contacts"][-1:]},
            CHANGED,
        ),  # its history is stored under another number
    ],
)
def test_other_metadata_are_refused(run: Trajectory, saved: Path, change, why: str):
    rewrite(saved)
    assert Trajectory.load(saved) == run
    rewrite(saved, change)
    refused(saved, why)


ARRAYS = (
    "time", "hub_angle", "angles", "rates", "centre_line", "centre_line_velocity", "kinetic_energy", "potential_energy",
    "normal_force", "contact0_time", "contact0_normal_force",
)  # fmt: skip


CHANGES = {
    "shorter": lambda array: array[:-3],
    "another shape": lambda array: array[:, None],
    "text": lambda array: array.astype(str),
    "complex": lambda array: array.astype(complex),
    "one not finite": lambda array: np.where(
        np.arange(array.size).reshape(array.shape) == 5, np.nan, array
    ),
    "one in its last digit": lambda array: np.where(
        np.arange(array.size).reshape(array.shape) == 5, np.nextafter(array, np.inf), array
    ),
    "reversed": lambda array: array[::-1],
}


@pytest.mark.parametrize("name", ARRAYS)
def test_other_arrays_are_refused(saved: Path, name: str):
    whole = saved.read_bytes()
    with np.load(saved) as stored:
        number = next(key for key in stored if key.startswith("contact") and key.endswith("_time"))[
            :-4
        ]
        own = name.replace("contact0_", number)
        array = stored[own]
    for change in CHANGES.values():
        saved.write_bytes(whole)
        rewrite(saved, **{own: change(array)})
        refused(saved, CHANGED)


def test_a_small_file_of_large_arrays_is_refused_before_they_are_read(
    saved: Path, monkeypatch: pytest.MonkeyPatch
):
    """A run at rest packs to a thousandth, which is read below the bound."""
    with np.load(saved) as stored:
        every = dict(stored) | {"further": np.zeros(1_000_000)}
    del every["digest"]
    np.savez_compressed(saved, digest=storage.digest(every), **every)
    assert Trajectory.load(saved)
    monkeypatch.setattr(storage, "MOST_UNPACKED", 1e6)
    refused(saved, "its arrays take 8.* bytes, too many for a run in a file of")


def test_damaged_files_are_refused_or_read_completely(run: Trajectory, saved: Path):
    """Single bytes anywhere, and files cut short: no other error than ValueError. Only names and dates are unguarded."""
    whole = saved.read_bytes()
    damaged = saved.with_name("damaged.npz")
    dice = random.Random(1)
    refusals = 0
    for _ in range(100):
        content = bytearray(whole)
        content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
        damaged.write_bytes(content[: dice.choice((len(content), dice.randrange(len(content))))])
        try:
            assert Trajectory.load(damaged) == run
        except ValueError:
            refusals += 1
    assert refusals > 50


def test_no_code_is_written_to_a_file_nor_run_from_one(run: Trajectory, saved: Path):
    """Pickled objects are refused, not opened, even in the place of a known member."""
    with pytest.raises(TypeError):
        dataclasses.replace(run, parameters={"law": object()}).save(saved)
    assert Trajectory.load(saved) == run
    rewrite(saved, dtype=object)
    refused(saved)


@pytest.mark.parametrize(
    "simulated",
    [
        lambda: simulate(Tool(bristle=Bristle(knee_angle_deg=30.0, links=2)), stop_after="strike"),
        lambda: simulate(Tool(bar=None, workpart=None), start_relative_angle=-0.5),
        lambda: simulate_reference(Tool(), hub_turn=1.3),
        lambda: simulate_row(
            Tool(), bristles=2, pitch=0.3, neighbour_friction=0.2, neighbour_restitution=0.4
        )[1],
    ],
    ids=["bent wire of links", "nothing to touch", "reference", "row"],
)
def test_runs_of_every_kind_are_read_again(simulated: Callable[[], Trajectory], tmp_path: Path):
    run = simulated()
    run.save(tmp_path / "run.npz")
    assert Trajectory.load(tmp_path / "run.npz") == run
