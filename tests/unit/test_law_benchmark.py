"""The benchmarks run. No cost is required, as machines are noisy; errors are."""

import numpy as np

from benchmarks.law_benchmark import costs
from benchmarks.scene_benchmark import table


def test_every_way_is_measured() -> None:
    found = costs(rounds=1, size=1000)
    assert {
        "law, arrays",
        "law, one impact",
        "scene, one rod",
        "scene, two rods",
        "step at rest, 50, contact",
    } <= set(found)
    assert all(0.0 < seconds < 10.0 for seconds in found.values())


def test_drops_are_of_second_order_and_nothing_is_worse_than_the_engine() -> None:
    """A quarter of the step: a sixteenth of the error but for its scatter, where no joint turns, which the engine solves to first order."""
    found = {
        (kind, steps, way): np.median(errors, axis=0) for kind, steps, way, errors in table(cases=8)
    }
    for kind, steps, _ in [each for each in found if each[2] == "pymunk"]:
        own = found[kind, steps, "EnergeticContact"]
        engines = found[kind, steps, "pymunk"]
        if "drop" in kind:
            assert (own < 0.2 * engines).all(), kind
        else:
            assert (own < 2.0 * engines + 1e-12).all(), kind
    for kind in ("circle, drop", "box, drop"):
        assert (
            found[kind, 240, "EnergeticContact"] < found[kind, 60, "EnergeticContact"] / 6.0
        ).all(), kind
