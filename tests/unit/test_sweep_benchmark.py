"""The benchmark of sweeps prints a row for each way, on which machine, and how to measure again."""

from __future__ import annotations

import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")
pytest.importorskip("psutil", reason="comes with the extra sweep")

from benchmarks import sweep_benchmark


def test_rows_machine_and_command(capsys: pytest.CaptureFixture[str]):
    assert sweep_benchmark.main(["--passes", "3", "--ways", "serial"]) == 0
    head, plain, stored, *told = capsys.readouterr().out.splitlines()
    assert head.split()[0] == "way"
    for row, store in ((plain, "no"), (stored, "yes")):
        way, kept, *numbers, ratio, best, same = row.split()
        assert (way, kept, ratio, best, same) == ("serial", store, "1.00", "1.00", "yes")
        assert min(map(float, numbers)) >= 0.0
    assert any(line.startswith("processor: ") for line in told)
    assert told[-1].endswith("sweep_benchmark.py --passes 3")


def test_every_pass_strikes():
    """The intervals are those in which the bar cues the bristle: no point of the benchmark is cheap because it fails."""
    assert not sweep_benchmark.measured("serial", 10).found["failure"].values.any()


def test_passes_must_be_at_least_one(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit):
        sweep_benchmark.main(["--passes", "0"])
    assert "--passes = 0: must be at least 1" in capsys.readouterr().err
