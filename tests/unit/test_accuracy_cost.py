"""Accuracy against cost: exact answers, measuring, and every tool's model."""

import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from bristle_sim.benchmarks import machine
from bristle_sim.benchmarks.accuracy_cost import (
    Effort,
    cases,
    measure,
    methods,
    peers,
    study,
)
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Point
from bristle_sim.benchmarks.accuracy_cost.study import accuracy_cost

FLIGHT = cases.release_flight()


def errors(case, attempts, method):
    """Errors of one method, from coarse to fine."""
    return [case.error(each.run().values) for each in attempts if each.method == method]


def attempt_named(attempts, method, setting):
    return next(each for each in attempts if (each.method, each.setting) == (method, setting))


class TestCases:
    @pytest.mark.parametrize("method", ["scipy dop853", "scipy lsoda", "scipy ode dopri5"])
    def test_closed_form_of_the_flight_is_what_integrators_find(self, method):
        # Requested 1e-12; LSODA is known to miss its tolerance by a factor of ten.
        assert errors(FLIGHT, methods.scipy_flight(FLIGHT), method)[-1] < 1e-11

    def test_a_pass_by_events_of_scipy(self):
        """A pass at 1e-2 is a coarse one."""
        whole = cases.whole_pass_case()
        assert whole.error(methods.scipy_pass(whole)[0].run().values) < 1.0

    def test_the_strikes_settle_to_the_printed_rates(self):
        # Zhang 2020, sec. 2.4.2 evaluated, to the digits given there; kappa omega L from eq. 2.34 for the bristle.
        np.testing.assert_allclose(
            cases.double_pendulum().exact, (0.19893234, -0.22313679), atol=5e-9
        )
        np.testing.assert_allclose(cases.strike().exact, (-456.550,), atol=5e-4)


class TestMeasuring:
    def test_the_cheapest_is_within_the_target_with_all_finer_settings(self):
        """A lucky setting does not count."""
        found = ((1e-9, 1.0), (1e-3, 2.0), (1e-7, 3.0))
        points = [Point("case", "a", "setting", error, cpu_s, 1) for error, cpu_s in found]
        assert measure.cheapest(points, 1e-6).cpu_s == 3.0
        assert measure.cheapest(points, 1e-8) is None

    def test_a_failure_is_shown_and_never_cheapest(self):
        def fail():
            raise ValueError("stepped\ntoo far")

        point = measure.measure(FLIGHT, [Attempt("a b", "x", fail)], 1)[0]
        assert point.failure == "stepped too far"
        assert measure.cheapest([point], 1e9) is None

    def test_cpu_time_and_not_waiting_is_counted(self, monkeypatch):
        """The process's clock is one that computing alone moves on."""
        computed = [0.0]
        monkeypatch.setattr(measure.clock, "process_time", lambda: computed[0])

        def work():
            computed[0] += 0.01

        waiting, working = measure.cpu_times([lambda: None, work], 2)
        assert working == pytest.approx(0.01)
        assert waiting == 0.0


@pytest.mark.parametrize("accuracy", ["0.001", "1e-06", "1e-09"])
def test_the_requested_accuracy_is_reached(accuracy):
    run = attempt_named(
        methods.own_flight(FLIGHT), "bristle_sim simulate", f"accuracy={accuracy}"
    ).run()
    assert FLIGHT.error(run.values) < float(accuracy)


@pytest.mark.parametrize(
    "case", [cases.strike(), cases.double_pendulum()], ids=lambda case: case.name
)
def test_the_energetic_law_is_exact(case):
    run = attempt_named(methods.own_strike(case), "bristle_sim energetic", "closed phases").run()
    assert case.error(run.values) < 1e-13


class TestPeers:
    """Each tool's model is the same mechanism: it converges to the closed form, at its integrator's order."""

    @pytest.mark.parametrize(
        ("method", "counts", "order", "within"),
        [
            # Asymptotic: the next order is below 1 % of the error at 512 plain steps, of some per cent at fewer.
            ("bristle_sim plain steps", (512, 1024), 1, 0.03),
            *(
                (f"mujoco {name}", (64, 128), order, 0.06)
                for name, order in (("euler", 1), ("implicitfast", 1), ("rk4", 4))
            ),
        ],
    )
    def test_order_in_flight(self, method, counts, order, within):
        package = method.split()[0]
        pytest.importorskip(package)
        flights = {"mujoco": peers.mujoco_flight}
        attempts = flights.get(package, methods.own_flight)(FLIGHT)
        coarse, fine = (
            FLIGHT.error(attempt_named(attempts, method, f"steps={n}").run().values) for n in counts
        )
        assert math.log2(coarse / fine) == pytest.approx(order, abs=within)
        if method == "mujoco rk4":
            # 512 steps leave 1e-12 of the method's own error, and the hub of finite inertia as much.
            assert FLIGHT.error(attempt_named(attempts, method, "steps=512").run().values) < 1e-11

    def test_mujoco_pass_reaches_the_strike(self):
        pytest.importorskip("mujoco")
        case = cases.whole_pass_case()
        run = attempt_named(peers.mujoco_pass(case), "mujoco rk4", "steps=2000").run()
        # A spring two steps stiff is 2e-3 of the pass soft, and what it keeps of that is a tenth.
        assert case.error(run.values) < 5e-4

    def test_heyoka_flight(self):
        pytest.importorskip("heyoka")
        attempts = peers.heyoka_flight(FLIGHT)
        # Each tolerance bounds a step's remainder; the flight takes some ten steps, and ends at rounding.
        assert all(
            FLIGHT.error(each.run().values) < 10.0 * 10.0**-k + 1e-14
            for k, each in enumerate(attempts, 1)
        )
        assert attempts[-1].run() == attempts[-1].run()

    @pytest.mark.parametrize("name", ["mujoco", "heyoka"])
    def test_a_peer_that_cannot_be_imported_is_named_and_left_out(
        self, name, tmp_path, monkeypatch
    ):
        """Installed, but built for another machine: its import fails, and the study goes on without it, unlike our own."""
        (tmp_path / f"{name}.py").write_text(
            'raise ImportError("lib.so: wrong\\nELF class")', encoding="utf-8"
        )
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.delitem(sys.modules, name, raising=False)
        missing = {}
        assert study._offered(name, study.FLIGHT[name], FLIGHT, missing) == []
        assert missing == {name: "installed, but ImportError: lib.so: wrong ELF class"}

        def fail(_):
            raise ImportError("pymunk")

        with pytest.raises(ImportError, match="pymunk"):
            study._offered("bristle_sim", fail, FLIGHT, {})


def test_a_machine_that_says_nothing_of_itself(monkeypatch):
    monkeypatch.setattr(machine, "Path", lambda _: Path("nowhere"))
    monkeypatch.setattr(machine, "PACKAGES", ("json", "numpy"))
    found = machine.surroundings()
    assert found["processor"]
    assert found["versions"]["json"] == "unknown"


def test_the_study_has_curves_of_all_cases_meets_the_requested_errors_and_counts_seconds():
    report = accuracy_cost(Effort("quick", "none"))
    curves = json.loads(json.dumps(report.extra, allow_nan=False))["curves"]
    assert {row["case"] for row in curves} == {
        "release_flight",
        "strike",
        "double_pendulum",
        "whole_pass",
    }
    assert all(row["method"].startswith("bristle_sim ") and not row["failure"] for row in curves)
    assert [row.ok for row in report.quantities if row.name.endswith("error_over_accuracy")] == [
        True
    ] * 4
    times = {row.name: row for row in report.quantities if "_cpu_" in row.name}
    (law,) = (
        row for row in curves if (row["method"], row["case"]) == ("bristle_sim energetic", "strike")
    )
    assert {row.unit for row in times.values()} == {"s"}
    assert times["strike_cpu_energetic"].simulated == law["cpu_s"]
