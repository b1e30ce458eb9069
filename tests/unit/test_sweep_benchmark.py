"""The benchmark of sweeps prints a row for each way, and every pass of it strikes."""

from __future__ import annotations

import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")
pytest.importorskip("psutil", reason="comes with the extra sweep")

from benchmarks import sweep_benchmark


def test_rows_and_machine(capsys: pytest.CaptureFixture[str]):
    assert sweep_benchmark.main(["--passes", "3", "--ways", "serial"]) == 0
    _, plain, stored, *told = capsys.readouterr().out.splitlines()
    for row, store in ((plain, "no"), (stored, "yes")):
        assert [row.split()[i] for i in (0, 1, -1)] == ["serial", store, "yes"]
    assert any(line.startswith("processor: ") for line in told)
    assert not sweep_benchmark.measured("serial", 10)[2]["failure"].values.any()
