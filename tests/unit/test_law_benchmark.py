"""The benchmark runs and tells every way's cost; no figure is required here, as machines are noisy."""

from benchmarks.law_benchmark import costs


def test_every_way_is_measured() -> None:
    found = costs(rounds=1, size=1000)
    assert {"law, arrays", "law, one impact", "scene, one rod", "scene, two rods", "step at rest, 50, contact"} <= set(
        found
    )
    assert all(0.0 < seconds < 10.0 for seconds in found.values())
