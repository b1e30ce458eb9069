"""Sweeps over named axes: their results, on any workers, and what a store keeps when it is interrupted or damaged.

The point function is a closed form, so that every expected number is known without a sweep. Calls are counted by lines
in a file, which all processes append to.
"""

import functools
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")
xarray = pytest.importorskip("xarray", reason="needs the extra sweep")
joblib = pytest.importorskip("joblib", reason="needs the extra sweep")

from bristle_sim.studies import sweep_store  # noqa: E402
from bristle_sim.studies.sweep import sweep  # noqa: E402
from sweep_points import counted, power  # noqa: E402

SPACE = {"x": [1.0, 2.0, 3.0, 4.0], "y": [0.5, 0.25]}


def calls(folder: Path) -> list[float]:
    """The finished calls, sorted."""
    return sorted(map(float, (folder / "calls").read_text().split()))


@pytest.mark.parametrize(
    ("space", "sizes"),
    [
        (SPACE, {"x": 4, "y": 2}),
        ({"x": ("sample", [1.0, 2.0, 3.0]), "y": ("sample", [4.0, 5.0, 6.0])}, {"sample": 3}),
        ({"x": ("sample", [1.0, 2.0]), "y": [0.5, 0.25, 2.0]}, {"sample": 2, "y": 3}),
        ({"x": [1.0, 2.0], "y": (("z", "x"), [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])}, {"x": 2, "z": 3}),
        ({"x": 2.0, "y": 3.0}, {}),
    ],
)
def test_every_combination_stands_in_its_place(space: dict[str, Any], sizes: dict[str, int]):
    """A grid, or parameters that vary together along shared dimensions; xarray's broadcasting says which value belongs where."""
    found = sweep(power, space, units={"x": "m", "power": "m^y"})
    assert dict(found["power"].sizes) == sizes
    x, y, values = xarray.broadcast(found["x"], found["y"], found["power"])
    assert np.array_equal(values, x.values**y.values)
    pairs = found["pair"].transpose(..., *values.dims)
    assert np.array_equal(pairs, [x, y])
    assert (found["x"].attrs, found["power"].attrs) == ({"units": "m"}, {"units": "m^y"})
    assert not found["failure"].values.any()


def kind(word: Any) -> float:
    return float(isinstance(word, int))


def test_words_and_numbers_stay_what_they_are(tmp_path: Path):
    found = sweep(lambda self, function: len(self) * function, {"self": ["ab", "abc"], "function": [1, 10]})
    assert found["result"].values.tolist() == [[2.0, 20.0], [3.0, 30.0]]
    for store in (None, tmp_path, tmp_path):
        mixed = sweep(kind, {"word": [1, "a", "1"]}, store=store)
        assert mixed["result"].values.tolist() == [1.0, 0.0, 0.0]
        assert mixed["word"].values.tolist() == [1, "a", "1"]
        fixed = sweep(kind, {"word": np.array(["a", "bc"])}, store=store)  # an array of words of one width
        assert fixed["word"].values.tolist() == ["a", "bc"]


def test_a_point_that_raises_has_a_reason_and_the_rest_goes_on():
    found = sweep(lambda x: 1.0 / x if x < 3.0 else {"result": [1.0, 2.0]}, {"x": [1.0, 0.0, 2.0, 3.0]})
    assert np.array_equal(found["result"].values, [1.0, math.nan, 0.5, math.nan], equal_nan=True)
    reasons = found["failure"].values.tolist()
    assert reasons[1] == "ZeroDivisionError: float division by zero"
    assert "shape (2,)" in reasons[3]
    assert reasons[::2] == ["", ""]
    assert list(sweep(lambda x: math.sqrt(-x), {"x": [1.0, 2.0]}).data_vars) == ["failure"]
    # In the words of README's example, which reads the impulse of a contact that there is not.
    run = SimpleNamespace(first_contact=lambda _: None)
    found = sweep(lambda x: run.first_contact("workpart").impulse[0] * x, {"x": [1.0]})
    assert found["failure"].item().startswith("no strike: impulse was read of None")


@pytest.mark.parametrize(
    ("function", "space", "words"),
    [
        (power, {"x": [1.0], "z": [2.0]}, "unexpected keyword argument 'z'|missing a required argument"),
        (power, {"x": [1.0]}, "missing a required argument: 'y'"),
        (power, {"x": [], "y": [1.0]}, "x must hold at least one value"),
        (power, {"x": [object()], "y": 1.0}, "x must hold numbers or words"),
        (power, {"x": ("sample", [1.0, 2.0]), "y": ("sample", [1.0])}, "must be coordinates"),
        (lambda failure: failure, {"failure": [1.0]}, "failure must not be a parameter"),
        (lambda x: {"x": x}, {"x": [1.0]}, "must not have the name of a parameter or"),
        (lambda x: {"sample": x}, {"x": ("sample", [1.0])}, "must not have the name of a parameter or dimension"),
        (lambda x: {"a/b": x}, {"x": [1.0]}, "its result 'a/b' must have a name without /"),
        (lambda x: {"": x}, {"x": [1.0]}, "its result '' must have a name"),
        (dict, {"a/b": [1.0]}, "its parameter 'a/b' must have a name without /"),
        (3, {"x": [1.0]}, "function = 3: must be callable"),
        *((power, SPACE | {"workers": each}, "workers = .*must be") for each in (0, True, 1.5, "two", 10**6)),
        *((power, SPACE | {"store": each}, "store = .*must be") for each in ("", 3, __file__)),
    ],
)
def test_bad_input_is_refused_in_one_line(function: Any, space: dict[str, Any], words: str):
    options = {name: space[name] for name in ("workers", "store") if name in space}
    with pytest.raises(ValueError, match=words) as refusal:
        sweep(function, {name: each for name, each in space.items() if name not in options}, **options)
    assert "\n" not in str(refusal.value)


def test_progress_tells_the_time_left(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """Of a long sweep, where standard error is no terminal too, unless it is not wanted; of a short one if it is."""
    for patience, progress, words in (
        (5.0, True, "4/4 [00:0"),
        (5.0, None, ""),
        (0.01, None, "4/4"),
        (0.01, False, ""),
    ):
        monkeypatch.setattr("bristle_sim.studies.sweep.PATIENCE", patience)
        sweep(lambda x: time.sleep(0.01 * x), {"x": np.ones(4)}, progress=progress)
        shown = capsys.readouterr()
        assert words in shown.err
        assert bool(shown.err) is bool(words)
        assert shown.out == ""


def test_every_kind_of_worker_gives_the_serial_results_bit_for_bit():
    space = {"x": np.linspace(0.1, 9.7, 40), "y": [1 / 3, 0.7]}
    expected = sweep(power, space)
    assert sweep(power, space, workers=2).identical(expected)
    with joblib.parallel_config(backend="threading", n_jobs=2):
        assert sweep(power, space).identical(expected)
    with ThreadPoolExecutor(2) as executor:
        assert sweep(power, space, workers=executor).identical(expected)


LOCK = threading.Lock()


def test_a_function_that_cannot_be_sent_is_refused_in_one_line():
    assert sweep(lambda x: x if LOCK else 0.0, {"x": [1.0]})["result"].item() == 1.0
    with pytest.raises(ValueError, match="must be picklable, to be sent to the workers") as refusal:
        sweep(functools.partial(power, y=LOCK), {"x": [1.0, 2.0]}, workers=2)
    assert "\n" not in str(refusal.value)


def test_a_cluster_gives_the_serial_results_and_survives_the_loss_of_a_worker(tmp_path: Path):
    """Two processes behind TCP; one of them is killed in the middle and its points are computed by others."""
    distributed = pytest.importorskip("distributed", reason="needs the extra sweep")
    space = {"x": np.arange(24.0)}
    function = functools.partial(counted, folder=str(tmp_path), killed_at=11.0)
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, protocol="tcp://", dashboard_address=":0", silence_logs=50
    )
    with cluster, distributed.Client(cluster) as client:
        with joblib.parallel_config(backend="dask"):
            found = sweep(function, space, store=tmp_path / "store")
        assert sweep(power, SPACE, workers=client.get_executor()).identical(sweep(power, SPACE))
    assert np.array_equal(found["result"], space["x"] ** 2)
    assert (tmp_path / "death0").exists()
    assert sorted(set(calls(tmp_path))) == space["x"].tolist()


def test_a_point_that_always_kills_its_process_is_named_and_the_others_are_kept(tmp_path: Path):
    function = functools.partial(counted, folder=str(tmp_path), killed_at=3.0, times=99)
    with pytest.raises(RuntimeError, match=r"workers were lost 3 times near the point \{'x': 3\.0\}"):
        sweep(function, {"x": np.arange(6.0)}, workers=2, store=tmp_path / "store")
    (kept,) = (tmp_path / "store").glob("*.zarr")
    reasons = xarray.open_zarr(kept, consolidated=False)["failure"].values.tolist()
    assert reasons == ["", "", "", "not computed", "", ""]
    with ProcessPoolExecutor(2) as executor, pytest.raises(RuntimeError, match="workers were lost 1 times"):
        sweep(function, {"x": [3.0]}, workers=executor)


def noted(x: float, y: float, folder: str) -> dict[str, Any]:
    counted(x, folder)
    return power(x, y)


def test_finished_points_are_never_computed_again(tmp_path: Path):
    function = functools.partial(noted, folder=str(tmp_path))
    for _ in range(2):
        found = sweep(function, SPACE, store=tmp_path / "store", units={"power": "1"})
        assert not found["power"].variable._in_memory
        assert found.load().equals(sweep(power, SPACE))
        assert found["power"].attrs == {"units": "1"}
    assert len(calls(tmp_path)) == 8
    sweep(function, SPACE, store=tmp_path / "store", version="2")
    assert len(calls(tmp_path)) == 8 + 8


def emptied(path: Path) -> None:
    path.write_bytes(b"")


def changed(path: Path) -> None:
    found = bytearray(path.read_bytes())
    found[len(found) // 2] ^= 1
    path.write_bytes(found)


@pytest.mark.parametrize(
    ("harm", "part", "recomputed"),
    [
        (emptied, "power/c/0/0", 2),
        (changed, "pair/c/1/0/0", 2),
        (changed, "failure/c/2/0", 2),
        (emptied, "x/c/0", 0),
        (Path.unlink, "power/zarr.json", 8),
        (emptied, "zarr.json", 8),
        (shutil.rmtree, "pair", 8),
    ],
)
def test_damaged_and_lost_parts_are_computed_again(
    harm: Any, part: str, recomputed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: Any
):
    """Of the four chunks of two points those that are damaged; a lost description costs its variable, or all."""
    monkeypatch.setattr(sweep_store, "BLOCK", 2)
    run = functools.partial(sweep, functools.partial(noted, folder=str(tmp_path)), SPACE, store=tmp_path / "store")
    expected = run().load()
    (store,) = (tmp_path / "store").glob("*.zarr")
    harm(store / part)
    for _ in range(2):
        assert run().identical(expected)
        assert len(calls(tmp_path)) == 8 + recomputed
    lost_without_trace = harm is Path.unlink and part.startswith(("failure", "zarr"))  # as if never computed
    assert bool(caplog.records) is bool(recomputed and not lost_without_trace)


def test_a_store_holds_data_alone(tmp_path: Path):
    """No pickle: its protocols begin with \\x80; and nothing of an interrupted writing is left, but a new one goes on."""
    sweep(power, SPACE, store=tmp_path)
    (store,) = tmp_path.iterdir()
    leftover = store / "power" / "c" / "0" / "0.abc.partial"
    written = leftover.with_name("0.def.partial")
    for each in (leftover, written):
        each.write_bytes(b"half")
    os.utime(leftover, (0, 0))
    sweep(power, SPACE, store=tmp_path)
    files = [each for each in store.rglob("*") if each.is_file()]
    assert leftover not in files
    assert written in files
    assert not [each for each in files if each.read_bytes().startswith(b"\x80")]


SCRIPT = """
import functools, sys
import numpy as np
sys.path.insert(0, {here!r})
from sweep_points import counted
from bristle_sim.studies import sweep
if __name__ == "__main__":
    sweep.WRITTEN_EVERY = 0.1
    function = functools.partial(counted, folder={folder!r}, pause=0.02)
    sweep.sweep(function, {{"x": np.arange(100.0)}}, workers=2, store={store!r})
"""


def test_a_killed_program_leaves_what_it_had_finished(tmp_path: Path):
    """The program and its workers are killed as one process group, then it is started again."""
    folder = tmp_path / "run"
    folder.mkdir()
    script = tmp_path / "script.py"
    here, store = str(Path(__file__).parents[1]), str(tmp_path / "store")
    script.write_text(SCRIPT.format(here=here, folder=str(folder), store=store))
    program = subprocess.Popen([sys.executable, script], start_new_session=True, stderr=subprocess.DEVNULL)
    while not (folder / "calls").exists() or len(calls(folder)) < 60:
        assert program.poll() is None
        time.sleep(0.01)
    os.killpg(program.pid, signal.SIGKILL)
    program.wait()
    subprocess.run([sys.executable, script], check=True)
    assert sorted(set(calls(folder))) == np.arange(100.0).tolist()
    # Two workers had a turn of 0.3 s each that was not returned, and 0.1 s that was not written: 35 points of 0.02 s.
    assert len(calls(folder)) <= 100 + 50
