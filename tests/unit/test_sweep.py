"""Sweeps over named axes: their results, on any workers, and what a store keeps when it is interrupted or damaged.

The point function is a closed form, so that every expected number is known without a sweep. Calls are counted by lines
in a file, which all processes append to.
"""

import errno
import functools
import itertools
import logging
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Container
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")
xarray = pytest.importorskip("xarray", reason="needs the extra sweep")
joblib = pytest.importorskip("joblib", reason="needs the extra sweep")

from bristle_sim.studies import sweep_store, sweep_workers  # noqa: E402
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
        (
            {"x": [1.0, 2.0], "y": (("z", "x"), [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])},
            {"x": 2, "z": 3},
        ),
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
    found = sweep(
        lambda self, function: len(self) * function, {"self": ["ab", "abc"], "function": [1, 10]}
    )
    assert found["result"].values.tolist() == [[2.0, 20.0], [3.0, 30.0]]
    for store in (None, tmp_path, tmp_path):
        mixed = sweep(kind, {"word": [1, "a", "1"]}, store=store)
        assert mixed["result"].values.tolist() == [1.0, 0.0, 0.0]
        assert mixed["word"].values.tolist() == [1, "a", "1"]
        fixed = sweep(
            kind, {"word": np.array(["a", "bc"])}, store=store
        )  # an array of words of one width
        assert fixed["word"].values.tolist() == ["a", "bc"]


def test_a_point_that_raises_has_a_reason_and_the_rest_goes_on():
    found = sweep(
        lambda x: 1.0 / x if x < 3.0 else {"result": [1.0, 2.0]}, {"x": [1.0, 0.0, 2.0, 3.0]}
    )
    assert np.array_equal(found["result"].values, [1.0, math.nan, 0.5, math.nan], equal_nan=True)
    reasons = found["failure"].values.tolist()
    assert reasons[1] == "ZeroDivisionError: float division by zero"
    assert "shape (2,)" in reasons[3]
    assert reasons[::2] == ["", ""]
    assert list(sweep(lambda x: math.sqrt(-x), {"x": [1.0, 2.0]}).data_vars) == ["failure"]
    assert sweep(lambda x: sys.exit(3), {"x": [1.0]})["failure"].item() == "SystemExit: 3"  # noqa: ARG005
    # In the words of README's example, which reads the impulse of a contact that there is not.
    run = SimpleNamespace(first_contact=lambda _: None)
    found = sweep(lambda x: run.first_contact("workpart").impulse[0] * x, {"x": [1.0]})
    assert found["failure"].item().startswith("impulse was read of None")


class Mute(Exception):
    """An exception without words."""

    def __str__(self) -> str:
        raise RuntimeError("no words")


def odd(x: float) -> dict[str, Any]:
    if x == 1.0:
        raise ValueError("file \udce9 is bad")
    if x == 2.0:
        raise Mute
    return {"nothing": np.ones(0), "x_squared": x**2}


def test_odd_messages_and_empty_arrays_do_not_end_a_sweep(tmp_path: Path):
    for store in (None, tmp_path, tmp_path):
        found = sweep(odd, {"x": [0.0, 1.0, 2.0, 3.0]}, store=store)
        assert found["failure"].values.tolist() == [
            "",
            "file \\udce9 is bad",
            "Mute: its message cannot be read",
            "",
        ]
        assert found["nothing"].shape == (4, 0)
        assert found["x_squared"].values[[0, 3]].tolist() == [0.0, 9.0]


@pytest.mark.parametrize(
    ("function", "space", "words"),
    [
        (
            power,
            {"x": [1.0], "z": [2.0]},
            "unexpected keyword argument 'z'|missing a required argument",
        ),
        (power, {"x": [1.0]}, "missing a required argument: 'y'"),
        (power, {"x": [], "y": [1.0]}, "x must hold at least one value"),
        (power, {"x": [object()], "y": 1.0}, "x must hold numbers or words"),
        (power, {"x": ("sample", [1.0, 2.0]), "y": ("sample", [1.0])}, "must be coordinates"),
        (lambda failure: failure, {"failure": [1.0]}, "failure must not be a parameter"),
        (lambda x: x, {"x": ("failure", [1.0])}, "failure must not be a parameter"),
        (lambda x: {"x": x}, {"x": [1.0]}, "must not have the name of a parameter or"),
        (
            lambda x: {"sample": x},
            {"x": ("sample", [1.0])},
            "must not have the name of a parameter or dimension",
        ),
        (lambda x: {"a/b": x}, {"x": [1.0]}, "its result 'a/b' must have a name without /"),
        (lambda x: {"": x}, {"x": [1.0]}, "its result '' must have a name"),
        (dict, {"a/b": [1.0]}, "its parameter 'a/b' must have a name without /"),
        (3, {"x": [1.0]}, "function = 3: must be callable"),
        *(
            (power, SPACE | {"workers": each}, "workers = .*must be")
            for each in (0, True, 1.5, "two", 10**6)
        ),
        *((power, SPACE | {"store": each}, "store = .*must be") for each in ("", 3, __file__)),
    ],
)
def test_bad_input_is_refused_in_one_line(function: Any, space: dict[str, Any], words: str):
    options = {name: space[name] for name in ("workers", "store") if name in space}
    with pytest.raises(ValueError, match=words) as refusal:
        sweep(
            function, {name: each for name, each in space.items() if name not in options}, **options
        )
    assert "\n" not in str(refusal.value)


def test_progress_tells_the_time_left(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
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
    for number in (2, np.int64(2)):
        assert sweep(power, space, workers=number).identical(expected)
    with ThreadPoolExecutor(2) as executor:
        assert sweep(power, space, workers=executor).identical(expected)


@pytest.mark.nightly  # five processes start
def test_processes_of_a_sweep_leave_joblib_its_own():
    """In a process of its own, so that joblib has no processes yet."""
    program = "; ".join(
        (
            "import joblib, math",
            "from bristle_sim.studies.sweep import sweep",
            "sweep(lambda x: -x, {'x': [1.0, 2.0]}, workers=2)",
            "print(joblib.Parallel(2)(joblib.delayed(math.sqrt)(x) for x in (4.0, 9.0)))",
        )
    )
    done = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True
    )
    assert done.stdout == "[2.0, 3.0]\n", done.stderr


LOCK = threading.Lock()


def test_a_function_that_cannot_be_sent_is_refused_in_one_line():
    assert sweep(lambda x: x if LOCK else 0.0, {"x": [1.0]})["result"].item() == 1.0
    with pytest.raises(ValueError, match="must be picklable, to be sent to the workers") as refusal:
        sweep(functools.partial(power, y=LOCK), {"x": [1.0, 2.0]}, workers=2)
    assert "\n" not in str(refusal.value)
    with ProcessPoolExecutor(1) as executor:
        assert sweep(lambda x: x, {"x": [1.0]}, workers=executor)["result"].item() == 1.0
    with ThreadPoolExecutor(1) as executor:
        assert (
            sweep(lambda x: x if LOCK else 0.0, {"x": [1.0]}, workers=executor)["result"].item()
            == 1.0
        )


def test_a_cluster_gives_the_serial_results_and_survives_the_loss_of_a_worker(tmp_path: Path):
    """Two processes behind TCP; one of them is killed in the middle and its points are computed by others."""
    distributed = pytest.importorskip("distributed", reason="needs the extra sweep")
    space = {"x": np.arange(24.0)}
    function = functools.partial(counted, folder=str(tmp_path), killed_at=11.0)
    cluster = distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        protocol="tcp://",
        dashboard_address=":0",
        silence_logs=50,
    )
    with cluster, distributed.Client(cluster) as client:
        found = sweep(function, space, workers=client, store=tmp_path / "store")
        for workers in (client, client.get_executor()):
            assert sweep(power, SPACE, workers=workers).identical(sweep(power, SPACE))
    assert np.array_equal(found["result"], space["x"] ** 2)
    assert (tmp_path / "death0").exists()
    assert sorted(set(calls(tmp_path))) == space["x"].tolist()


class StandInClient:
    """A Dask client whose cluster gets its only worker as soon as the log says that it has none."""

    def __init__(self, threads: ThreadPoolExecutor) -> None:
        self.threads = threads
        self.started = threading.Event()

    get_executor = scheduler_info = None

    def ncores(self) -> dict[str, int]:
        return {"worker": 1} if self.started.is_set() else {}

    def submit(self, *call: Any, pure: bool) -> Any:
        assert not pure
        return self.threads.submit(lambda: self.started.wait() and call[0](*call[1:]))


def test_a_cluster_without_workers_says_so_and_goes_on_with_the_first(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(sweep_workers, "WITHOUT_WORKER", 0.05)
    lines = list[str]()
    with ThreadPoolExecutor(2) as threads:
        client = StandInClient(threads)

        def heard(line: logging.LogRecord) -> bool:
            lines.append(line.getMessage())
            client.started.set()
            return False

        logger = logging.getLogger(sweep_workers.__name__)
        logger.addFilter(heard)
        try:
            found = sweep(power, SPACE, workers=client)
        finally:
            logger.removeFilter(heard)
            client.started.set()
    assert found.identical(sweep(power, SPACE))
    (line,) = lines
    assert re.search(r"no worker for 0\.05 s; the sweep continues as soon as one is started", line)
    assert "\n" not in line


class Losing(ThreadPoolExecutor):
    """Threads that lose their calls for some numbers of a call."""

    def __init__(self, lost: Container[int]) -> None:
        super().__init__(1)
        self.lost = lost
        self.number = itertools.count()

    def submit(self, *call: Any) -> Any:
        if next(self.number) not in self.lost:
            return super().submit(*call)
        future = Future[Any]()
        future.set_exception(ConnectionError("connection lost"))
        return future


def test_batches_that_are_lost_are_computed_again():
    """Single ones and batches of many points, whatever the error is."""
    space = {"x": np.linspace(0.0, 1.0, 60), "y": [0.5]}
    with Losing({0, 3, 5, 6}) as threads:
        assert sweep(power, space, workers=threads).identical(sweep(power, space))


def test_a_sweep_whose_workers_are_gone_ends_in_one_line_and_keeps_its_points(tmp_path: Path):
    with Losing(range(2, 99)) as threads, pytest.raises(RuntimeError) as gone:
        sweep(power, {"x": np.arange(10.0), "y": 1.0}, workers=threads, store=tmp_path)
    words = r"workers: lost at the point {'x': \d.0, 'y': 1.0}, and none answers any more \(ConnectionError: connection lost\); "
    assert re.match(words, str(gone.value))
    assert "\n" not in str(gone.value)
    (kept,) = tmp_path.glob("*.zarr")
    assert {*xarray.open_zarr(kept, consolidated=False)["failure"].values} == {"", "not computed"}


@pytest.mark.nightly
def test_a_point_that_always_kills_its_process_is_a_failure_that_the_next_call_computes_again(
    tmp_path: Path,
):
    dying = functools.partial(counted, folder=str(tmp_path), killed_at=3.0, times=99)
    run = functools.partial(
        sweep, dying, {"x": np.arange(6.0)}, workers=2, store=tmp_path / "store"
    )
    first = run().load()
    assert np.array_equal(first["result"], [0.0, 1.0, 4.0, math.nan, 16.0, 25.0], equal_nan=True)
    reasons = first["failure"].values.tolist()
    assert reasons.pop(3).startswith("lost with its worker 3 times (")
    assert not any(reasons)
    for number in range(99):
        Path(tmp_path, f"death{number}").touch()
    assert run()["result"].values.tolist() == [0.0, 1.0, 4.0, 9.0, 16.0, 25.0]
    (tmp_path / "death98").unlink()
    with (
        ProcessPoolExecutor(2) as executor,
        pytest.raises(RuntimeError, match=r"none answers any more .*BrokenProcessPool"),
    ):
        sweep(dying, {"x": [3.0]}, workers=executor)


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


def renamed(path: Path) -> None:
    """One bit of the word "results" or "fill_value", which a description must have."""
    text = path.read_bytes()
    path.write_bytes(
        text.replace(b'"results"', b'"resultr"').replace(b'"fill_value"', b'"fill_valud"')
    )


@pytest.mark.parametrize(
    ("harm", "part", "recomputed"),
    [
        (emptied, "power/c/0/0", 2),
        (changed, "pair/c/1/0/0", 2),
        (changed, "failure/c/2/0", 2),
        (emptied, "x/c/0", 0),
        (Path.unlink, "power/zarr.json", 0),
        (renamed, "power/zarr.json", 0),
        (renamed, "zarr.json", 0),
        (emptied, "zarr.json", 0),
        (shutil.rmtree, "pair", 8),
    ],
)
def test_damaged_and_lost_parts_are_computed_again(
    harm: Any,
    part: str,
    recomputed: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: Any,
):
    """Of the four chunks of two points those that are damaged; a damaged description costs none."""
    monkeypatch.setattr(sweep_store, "BLOCK", 2)
    run = functools.partial(
        sweep, functools.partial(noted, folder=str(tmp_path)), SPACE, store=tmp_path / "store"
    )
    expected = run().load()
    (store,) = (tmp_path / "store").glob("*.zarr")
    harm(store / part)
    for _ in range(2):
        assert run().identical(expected)
        assert len(calls(tmp_path)) == 8 + recomputed
    assert bool(caplog.records) is bool(recomputed or part == "zarr.json")


def test_every_single_bit_of_a_description_may_be_wrong(tmp_path: Path):
    """One bit at a time, 61 bytes apart in each of three files: the results are those written, and none is computed again."""
    run = functools.partial(
        sweep,
        functools.partial(counted, folder=str(tmp_path)),
        {"x": [1.0]},
        store=tmp_path / "store",
    )
    expected = run().load()
    (store,) = (tmp_path / "store").glob("*.zarr")
    for path in (
        store / "zarr.json",
        store / "result" / "zarr.json",
        store / "failure" / "zarr.json",
    ):
        intact = path.read_bytes()
        for place in range(0, len(intact), 61):
            path.write_bytes(
                intact[:place] + bytes([intact[place] ^ 1 << place % 8]) + intact[place + 1 :]
            )
            assert run().identical(expected)
            assert path.read_bytes() == intact
    assert len(calls(tmp_path)) == 1


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS])
def test_a_complete_store_is_read_where_nothing_can_be_written(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Full or read-only disks; an incomplete store ends in the disk's error, and no file is gone."""
    run = functools.partial(
        sweep, functools.partial(noted, folder=str(tmp_path)), SPACE, store=tmp_path / "store"
    )
    expected = run().load()

    def refused(*_: Any, **__: Any) -> Any:
        raise OSError(number, os.strerror(number))

    usual = Path.open

    def opened(path: Path, mode: str = "r", *arguments: Any, **options: Any) -> Any:
        return usual(path, mode, *arguments, **options) if mode in ("r", "rb") else refused()

    monkeypatch.setattr(Path, "open", opened)
    for owner, name in (
        (Path, "write_bytes"),
        (os, "replace"),
        (Path, "replace"),
        (Path, "rename"),
        (Path, "unlink"),
    ):
        monkeypatch.setattr(owner, name, refused)
    files = {path: path.read_bytes() for path in (tmp_path / "store").rglob("*") if path.is_file()}
    assert run().identical(expected)
    part = next(path for path in files if path.match("power/c/*/*"))
    os.remove(part)  # noqa: PTH107
    with pytest.raises(OSError, match=os.strerror(number)):
        run()
    del files[part]
    left = {path: path.read_bytes() for path in (tmp_path / "store").rglob("*") if path.is_file()}
    assert {path: left.get(path) for path in files} == files


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


@pytest.mark.nightly
def test_a_killed_program_leaves_what_it_had_finished(tmp_path: Path):
    """The program and its workers are killed as one process group, then it is started again."""
    folder = tmp_path / "run"
    folder.mkdir()
    script = tmp_path / "script.py"
    here = str(Path(__file__).parents[1])
    store = str(tmp_path / "store")
    script.write_text(SCRIPT.format(here=here, folder=str(folder), store=store))
    program = subprocess.Popen(
        [sys.executable, script], start_new_session=True, stderr=subprocess.DEVNULL
    )
    while not (folder / "calls").exists() or len(calls(folder)) < 60:
        assert program.poll() is None
        time.sleep(0.01)
    os.killpg(program.pid, signal.SIGKILL)
    program.wait()
    subprocess.run([sys.executable, script], check=True)
    assert sorted(set(calls(folder))) == np.arange(100.0).tolist()
    # Two workers had a turn of 0.3 s each that was not returned, and 0.1 s that was not written: 35 points of 0.02 s.
    assert len(calls(folder)) <= 100 + 50


def test_a_space_that_is_no_mapping_is_refused_in_one_line():
    with pytest.raises(ValueError, match=r"^space: must be coordinates [^\n]+$"):
        sweep(power, [1.0])  # type: ignore[arg-type]
