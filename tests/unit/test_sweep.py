"""Sweeps over named axes: what comes out, on what it runs, and what is kept when it is interrupted.

The point function is a closed form, so that every expected number is known without a sweep. Calls are counted by lines
in a file, which all processes append to.
"""

import functools
import math
import os
import signal
import subprocess
import sys
import textwrap
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")
xarray = pytest.importorskip("xarray", reason="needs the extra sweep")
joblib = pytest.importorskip("joblib", reason="needs the extra sweep")

from bristle_sim.studies import sweep_store  # noqa: E402
from bristle_sim.studies.sweep import sweep  # noqa: E402
from bristle_sim.studies.sweep_identity import identity_of  # noqa: E402
from sweep_points import counted, power  # noqa: E402

SPACE = {"x": [1.0, 2.0, 3.0, 4.0], "y": [0.5, 0.25]}


def calls(folder: Path) -> list[float]:
    """The finished calls, sorted."""
    return sorted(map(float, (folder / "calls").read_text().split()))


def test_a_grid_has_all_combinations_in_place():
    found = sweep(power, SPACE, units={"x": "m", "power": "m^y"})
    assert found["power"].dims == ("x", "y")
    for x in SPACE["x"]:
        for y in SPACE["y"]:
            assert found["power"].sel(x=x, y=y).item() == x**y
            assert found["pair"].sel(x=x, y=y).values.tolist() == [x, y]
    assert (found["x"].attrs, found["power"].attrs) == ({"units": "m"}, {"units": "m^y"})
    assert not any(found["failure"].values.ravel())


@pytest.mark.parametrize(
    ("space", "sizes"),
    [
        ({"x": ("sample", [1.0, 2.0, 3.0]), "y": ("sample", [4.0, 5.0, 6.0])}, {"sample": 3}),
        ({"x": ("sample", [1.0, 2.0]), "y": [0.5, 0.25, 2.0]}, {"sample": 2, "y": 3}),
        ({"x": [1.0, 2.0], "y": (("z", "x"), [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])}, {"x": 2, "z": 3}),
        ({"x": 2.0, "y": [1.0, 3.0]}, {"y": 2}),
        ({"x": 2.0, "y": 3.0}, {}),
    ],
)
def test_parameters_vary_together_along_shared_dimensions(space: dict[str, Any], sizes: dict[str, int]):
    """xarray's own broadcasting says which value belongs where."""
    found = sweep(power, space)
    assert dict(found["power"].sizes) == sizes
    x, y, values = (each.values for each in xarray.broadcast(found["x"], found["y"], found["power"]))
    assert np.array_equal(values, x**y)


def test_words_and_a_lone_number():
    found = sweep(lambda word, n: len(word) * n, {"word": ["ab", "abc"], "n": [1, 10]})
    assert found["result"].sel(word="abc", n=10).item() == 30.0


def test_a_point_that_raises_has_a_reason_and_the_rest_goes_on():
    found = sweep(lambda x: 1.0 / x if x < 3.0 else {"result": [1.0, 2.0]}, {"x": [1.0, 0.0, 2.0, 3.0]})
    assert np.array_equal(found["result"].values, [1.0, math.nan, 0.5, math.nan], equal_nan=True)
    reasons = found["failure"].values.tolist()
    assert reasons[1] == "ZeroDivisionError: float division by zero"
    assert "shape (2,)" in reasons[3]
    assert reasons[::2] == ["", ""]


def test_a_space_without_any_result():
    found = sweep(lambda x: math.sqrt(-x), {"x": [1.0, 2.0]})
    assert list(found.data_vars) == ["failure"]


@pytest.mark.parametrize(
    ("function", "space", "words"),
    [
        (power, {"x": [1.0], "z": [2.0]}, "unexpected keyword argument 'z'|missing a required argument"),
        (power, {"x": [1.0]}, "missing a required argument: 'y'"),
        (power, {"x": [], "y": [1.0]}, "x must hold at least one value"),
        (power, {"x": [object()], "y": 1.0}, "x must hold numbers or words"),
        (power, {"x": ("sample", [1.0, 2.0]), "y": ("sample", [1.0])}, "must be coordinates"),
        (power, {"x": ("sample", "extra", [1.0]), "y": 1.0}, "must be coordinates"),
        (lambda failure: failure, {"failure": [1.0]}, "failure must not be a parameter"),
        (lambda x: {"x": x}, {"x": [1.0]}, "must not be named as a parameter"),
        (lambda x: {"sample": x}, {"x": ("sample", [1.0])}, "must not be named as a parameter, dimension"),
        (3, {"x": [1.0]}, "function = 3: must be callable"),
    ],
)
def test_what_is_no_space_is_refused(function: Any, space: dict[str, Any], words: str):
    with pytest.raises(ValueError, match=words) as refusal:
        sweep(function, space)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("workers", [0, True, 1.5, "two"])
def test_workers_are_a_number_or_an_executor(workers: Any):
    with pytest.raises(ValueError, match=r"workers = .*must be a whole number other than 0"):
        sweep(power, SPACE, workers=workers)


def test_blocks_cover_the_grid_once_in_the_order_of_its_points(monkeypatch: pytest.MonkeyPatch):
    for most in (1, 3, 4, 7, 100):
        monkeypatch.setattr(sweep_store, "BLOCK", most)
        for shape in ((), (5,), (2, 3), (3, 1, 4), (2, 2, 2, 2)):
            numbers = np.arange(math.prod(shape)).reshape(shape)
            chunk = sweep_store.chunk_shape(shape)
            assert math.prod(chunk) <= most
            seen = [n for region in sweep_store.regions(shape, chunk) for n in numbers[region].ravel()]
            assert seen == list(range(numbers.size))


def test_results_do_not_depend_on_the_size_of_a_block(monkeypatch: pytest.MonkeyPatch):
    expected = sweep(power, SPACE)
    monkeypatch.setattr(sweep_store, "BLOCK", 3)
    assert sweep(power, SPACE).identical(expected)


def test_progress_tells_the_time_left(capsys: pytest.CaptureFixture[str]):
    sweep(power, SPACE, progress=True)
    shown = capsys.readouterr()
    assert "8/8 [00:0" in shown.err
    assert shown.out == ""
    sweep(power, SPACE)
    assert capsys.readouterr().err == ""


def test_every_kind_of_worker_gives_the_serial_results_bit_for_bit():
    space = {"x": np.linspace(0.1, 9.7, 40), "y": [1 / 3, 0.7]}
    expected = sweep(power, space)
    assert sweep(power, space, workers=2).identical(expected)
    with joblib.parallel_config(backend="threading", n_jobs=2):
        assert sweep(power, space).identical(expected)
    with ThreadPoolExecutor(2) as executor:
        assert sweep(power, space, workers=executor).identical(expected)


class CountingExecutor(ThreadPoolExecutor):
    """Counts what is submitted to it."""

    submitted = 0

    def submit(self, *arguments: Any, **keywords: Any) -> Any:
        self.submitted += 1
        return super().submit(*arguments, **keywords)


def test_cheap_points_are_computed_in_batches():
    """A point takes microseconds, a batch some tenths of a second: far fewer batches than points."""
    with CountingExecutor(2) as executor:
        found = sweep(power, {"x": np.arange(2000.0), "y": 2.0}, workers=executor)
    assert np.array_equal(found["power"], np.arange(2000.0) ** 2)
    assert executor.submitted < 500


def test_the_space_given_is_left_as_it_is():
    axis = xarray.DataArray([1.0, 2.0], dims="x", attrs={"note": "mine"})
    assert sweep(power, {"x": axis, "y": 1.0}, units={"x": "m"})["x"].attrs == {"units": "m"}
    assert axis.attrs == {"note": "mine"}


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
    assert calls(tmp_path) == space["x"].tolist()


def test_a_killed_worker_process_changes_nothing(tmp_path: Path):
    space = {"x": np.arange(40.0)}
    function = functools.partial(counted, folder=str(tmp_path), pause=0.005, killed_at=23.0)
    found = sweep(function, space, workers=2, store=tmp_path / "store")
    assert np.array_equal(found["result"], space["x"] ** 2)
    assert (tmp_path / "death0").exists()
    assert calls(tmp_path) == space["x"].tolist()


def test_a_point_that_always_kills_its_process_ends_the_sweep_in_one_line(tmp_path: Path):
    function = functools.partial(counted, folder=str(tmp_path), killed_at=3.0, times=99)
    with pytest.raises(RuntimeError, match=r"workers were lost 3 times near the point \{'x': \d"):
        sweep(function, {"x": np.arange(6.0)}, workers=2)


def test_finished_points_are_never_computed_again(tmp_path: Path):
    function = functools.partial(counted, folder=str(tmp_path))
    first = sweep(function, {"x": [1.0, 2.0, 3.0]}, store=tmp_path / "store")
    again = sweep(function, {"x": [1.0, 2.0, 3.0]}, store=tmp_path / "store")
    assert again.identical(first)
    wider = sweep(function, {"x": [0.0, 1.0, 2.0, 3.0]}, store=tmp_path / "store")
    assert wider["result"].values.tolist() == [0.0, 1.0, 4.0, 9.0]
    assert calls(tmp_path) == [0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    "change",
    [
        {"version": "2"},
        {"function": functools.partial(counted, pause=1e-9)},
    ],
)
def test_a_changed_version_or_argument_is_a_new_point(tmp_path: Path, change: dict[str, Any]):
    function = functools.partial(change.pop("function", counted), folder=str(tmp_path))
    plain = functools.partial(counted, folder=str(tmp_path))
    sweep(plain, {"x": [1.0]}, store=tmp_path / "store")
    sweep(function, {"x": [1.0]}, store=tmp_path / "store", **change)
    assert calls(tmp_path) == [1.0, 1.0]


def test_results_are_read_from_disk_when_they_are_used(tmp_path: Path):
    found = sweep(power, SPACE, store=tmp_path, units={"power": "1"})
    assert not found["power"].variable._in_memory
    assert found.load().identical(sweep(power, SPACE, units={"power": "1"}))


def test_a_result_half_written_is_computed_again(tmp_path: Path):
    function = functools.partial(counted, folder=str(tmp_path))
    sweep(function, {"x": [1.0, 2.0]}, store=tmp_path / "store")
    broken = next((tmp_path / "store").rglob("output.pkl"))
    broken.write_bytes(broken.read_bytes()[:-5])
    found = sweep(function, {"x": [1.0, 2.0, 3.0]}, store=tmp_path / "store")
    assert found["result"].values.tolist() == [1.0, 4.0, 9.0]
    assert len(calls(tmp_path)) == 4


SCRIPT = """
    import sys
    import functools
    import numpy as np
    sys.path.insert(0, {here!r})
    from sweep_points import counted
    from bristle_sim.studies.sweep import sweep
    if __name__ == "__main__":
        function = functools.partial(counted, folder={folder!r}, pause=0.02)
        sweep(function, {{"x": np.arange(60.0)}}, workers=2, store={store!r})
"""


def test_a_killed_program_leaves_what_it_had_finished(tmp_path: Path):
    """The program and its workers are killed as one process group, then it is started again."""
    folder = tmp_path / "run"
    folder.mkdir()
    script = tmp_path / "script.py"
    here, store = str(Path(__file__).parents[1]), str(tmp_path / "store")
    script.write_text(textwrap.dedent(SCRIPT.format(here=here, folder=str(folder), store=store)))
    program = subprocess.Popen([sys.executable, script], start_new_session=True, stderr=subprocess.DEVNULL)
    while not (folder / "calls").exists() or len(calls(folder)) < 10:
        assert program.poll() is None
        time.sleep(0.01)
    os.killpg(program.pid, signal.SIGKILL)
    program.wait()
    before = calls(folder)
    assert len(before) < 60
    subprocess.run([sys.executable, script], check=True)
    unfinished = [each for each in before if calls(folder).count(each) == 2]
    assert sorted(set(calls(folder))) == np.arange(60.0).tolist()
    # Between the note of a call and the end of its function lies no time but for the point that a process dies in.
    assert len(unfinished) <= 2


def scaled(x: float) -> float:
    return FACTOR * x


FACTOR = 2.0


def test_a_changed_function_is_another_one(monkeypatch: pytest.MonkeyPatch):
    found = {identity_of(each) for each in (power, counted, scaled, functools.partial(scaled, x=1.0), math.sin)}
    assert len(found) == 5
    before = identity_of(scaled)
    assert identity_of(scaled) == before
    monkeypatch.setattr(sys.modules[__name__], "FACTOR", 3.0)
    assert identity_of(scaled) != before


def test_functions_without_a_file_are_told_apart_by_their_instructions():
    def made(source: str) -> Any:
        names: dict[str, Any] = {}
        exec(source, names)
        return names["f"]

    one, same, other = (made(f"def f(x):\n    return (lambda: x + {n})()") for n in (1, 1, 2))
    assert identity_of(one) == identity_of(same)
    assert identity_of(one) != identity_of(other)


def test_what_cannot_be_pickled_is_refused():
    with pytest.raises(ValueError, match="what is bound to it must be picklable"):
        sweep(functools.partial(power, y=(each for each in ())), {"x": [1.0]})
