"""The tool's forces: the turn that a bristle repeats, impulses and energy, and what a load cell shows of them."""

import dataclasses
import functools
import math

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.settings import Settings
from bristle_sim.studies.turn_forces import Force, load_cell_response, quadrature, turn_forces
from bristle_sim.studies.whole_tool import (
    Assembly,
    TurnNotCompleted,
    load_cell_series,
    periodic_turn,
    whole_tool,
)

FINE = Settings(accuracy=1e-8)
SPEED = 261.8
RADIUS = 0.0275
LENGTH = 0.027
MASS = 8.387e-5
INERTIA = MASS * LENGTH**2 / 3.0


@functools.cache
def repeated(tool):
    """The turn that a bristle repeats, with the samples that a study takes."""
    (run,) = periodic_turn(tool, dataclasses.replace(FINE, samples_per_period=400)).runs
    return run


@functools.cache
def rows(tool=None, bristles=42.0):
    """Quantities by name, and the report."""
    found = whole_tool(Tool() if tool is None else tool, Assembly(bristles), FINE)
    return {each.name: each for each in found.quantities}, found


class TestTurn:
    """A sustained contact erases what came before."""

    @pytest.mark.parametrize("damping", [0.0, 0.05])
    def test_the_second_turn_repeats_the_first_even_undamped(self, damping):
        turn = periodic_turn(Tool(belt=Belt(damping_ratio=damping)), FINE)
        assert turn.repeats
        assert len(turn.changes) == 2
        assert (
            turn.changes[0] > 0.1
        )  # it starts at rest relative to the hub, and swings from then on
        assert turn.changes[1] < 1e-6  # a hundred times the accuracy

    def test_a_bristle_that_bounces_off_everything_repeats_as_its_damping_lets_it(
        self, monkeypatch
    ):
        """A turn leaves exp(-c T/(2 I)) of a free swing, 0.276 at a damping ratio of 0.05; the bar gives some back."""
        thrown = Tool(
            bar=Bar(restitution=1.0),
            belt=Belt(damping_ratio=0.05),
            workpart=Workpart(penetration=-0.01),
        )
        damped = periodic_turn(thrown, Settings(accuracy=1e-6))
        assert damped.repeats
        left = math.exp(-thrown.belt_damping * 2.0 * math.pi / SPEED / (2.0 * INERTIA))
        assert left == pytest.approx(0.276, abs=1e-3)
        ratio = (damped.changes[-1] / damped.changes[2]) ** (1.0 / (len(damped.changes) - 3))
        assert 0.5 * left < ratio < 2.0 * left
        monkeypatch.setattr("bristle_sim.studies.whole_tool.MOST_TURNS", 4)
        unsettled = periodic_turn(thrown, Settings(accuracy=1e-6))
        remarks = whole_tool(thrown, Assembly(), Settings(accuracy=1e-6)).remarks
        assert any("no turn of 4 repeats the one before" in each for each in remarks)
        assert not unsettled.repeats
        first, second = unsettled.runs
        assert second.time[-1] == pytest.approx(2.0 * math.pi / SPEED, rel=1e-12)
        # The second turn starts where the first one ended; the conversion of units rounds.
        assert (second.relative_angle[0], second.relative_rate[0]) == pytest.approx(
            (first.relative_angle[-1], first.relative_rate[-1]), rel=1e-14
        )

    def test_power_balances_where_the_bar_leaves_the_wires_flank_for_its_end(self):
        """Wire and bar then have two samples at one instant, with the forces before and after it; within a hundred accuracies."""
        tool = Tool(
            Hub(speed="3000 rpm"),
            bristle=Bristle(length=0.03),
            bar=Bar(horizontal=0.05489, vertical=0.00556),
        )
        (power,) = (
            each
            for each in whole_tool(tool, Assembly(), FINE).quantities
            if each.name == "drive_power"
        )
        assert power.simulated == pytest.approx(power.theory, rel=1e-6)

    def test_a_jam_completes_no_turn(self):
        jammed = Tool(bar=Bar(horizontal=0.055407))
        with pytest.raises(TurnNotCompleted, match=r"^the bristle completes no turn: jam at "):
            periodic_turn(jammed, FINE)
        found, report = rows(jammed)
        assert {each.simulated for each in found.values()} == {None}
        assert report.answer.startswith(
            "There is no mean force: the bristle completes no turn: jam at "
        )
        with pytest.raises(ValueError, match="no turn"):
            load_cell_series(report.subject)


class TestForces:
    """Against the equations of motion, and against sums that are built otherwise."""

    @pytest.mark.parametrize(
        "tool",
        [
            Tool(),
            Tool(belt=Belt(damping_ratio=0.018), bar=Bar(friction=0.2)),
            Tool(bar=Bar(restitution=0.42), bristle=Bristle(knee_angle_deg=20.0)),
            Tool(workpart=Workpart(penetration=-0.001)),
            # The bar's force falls from 1.6 N to 0 within the last sample; at once where the wire's end leaves the bar.
            pytest.param(Tool(hub=Hub(speed=44.7)), marks=pytest.mark.nightly),
            Tool(hub=Hub(speed=478.13), bristle=Bristle(length=0.03965)),
        ],
    )
    def test_moments_of_the_forces_against_the_energy_lost_and_splines_against_impulses(self, tool):
        found, _ = rows(tool)
        # Required: 1e-6; the worst of these measured 4e-8.
        for name in ("mean_torque", "drive_power"):
            assert (found[name].ok, found[name].tolerance) == (True, 1e-6)
        assert [name for name, each in found.items() if each.theory is not None] == [
            "impact_rate",
            "mean_torque",
            "drive_power",
        ]
        run = repeated(tool)
        # On the bar the force may fall to 0 within its last sample, where no spline follows it.
        summed = [each.impulse for each in run.contacts if each.obstacle == "workpart"]
        drawn = 0.0
        for each in turn_forces(tool, run):
            if each.obstacle == "workpart" and each.course is None:
                drawn += each.integral[0]
            elif each.obstacle == "workpart":
                samples = (run.time >= each.edges[0]) & (run.time <= each.edges[-1])
                instants, weights = quadrature(run.time[samples])
                drawn += float((weights * each.course(instants)).sum())
        normal = np.sum(summed, axis=0)[0] if summed else 0.0
        assert drawn == pytest.approx(normal, rel=1e-6, abs=1e-12)

    def test_the_answer_is_that_of_the_numbers(self):
        found, report = rows()
        for name, unit in (
            ("mean_normal_force", "N"),
            ("mean_tangential_force", "N"),
            ("mean_hand_torque", "N m"),
        ):
            assert f" {found[name].simulated:.3g} {unit}" in report.answer
        assert f"{found['drive_power'].simulated:.4g} W" in report.answer
        _, lifted = rows(Tool(workpart=Workpart(penetration=-0.01)))
        assert lifted.answer == "The hand bears no force: no bristle touches the workpart."


class TestLoadCell:
    """Against Fourier series, in which a filter is a multiplication."""

    PERIOD = 5.7e-4

    def by_fourier(self, impacts, box, bandwidth, times):
        """Sum over harmonics k of F_k H(i k w) exp(i k w t), which falls like k^-2 for impulses."""
        number = np.arange(-4000, 4001)
        rate = 2.0 * math.pi * number / self.PERIOD
        force = sum(impulse * np.exp(-1j * rate * time) for time, impulse in impacts).astype(
            complex
        )
        begin, end, level = box
        middle = 0.5 * (begin + end)
        length = end - begin
        force += (
            level * length * np.sinc(rate * length / (2.0 * math.pi)) * np.exp(-1j * rate * middle)
        )
        cut = 2.0 * math.pi * bandwidth
        filtered = (
            force / self.PERIOD / (1.0 + math.sqrt(2.0) * 1j * rate / cut - (rate / cut) ** 2)
        )
        return (filtered * np.exp(1j * np.outer(times, rate))).sum(axis=1).real

    @pytest.mark.parametrize("bandwidth", [30.0, 1000.0, 2e4])
    def test_impulses_and_a_force_that_acts_longer_than_a_period(self, bandwidth):
        impacts = [(1.2e-3, 2.7e-3), (1e-4, 1e-3)]
        box = (2.0e-3, 3.1e-3, 0.8)
        times = np.linspace(0.0, self.PERIOD, 50, endpoint=False)
        forces = [Force("workpart", (time,), np.array([impulse])) for time, impulse in impacts]
        forces.append(
            Force("workpart", box[:2], np.array([]), lambda at: np.full(at.shape, box[2]))
        )
        shown = load_cell_response(forces, self.PERIOD, bandwidth, times)
        # The series is cut off at k = 4000: each impulse leaves 2 J/T (cut T/(2 pi))^2/4000, 2e-5 of J/T at 1 kHz.
        left = 4.0 * 3.7e-3 / self.PERIOD * (bandwidth * self.PERIOD) ** 2 / 4000.0
        assert shown == pytest.approx(
            self.by_fourier(impacts, box, bandwidth, times), abs=left + 1e-10
        )

    def test_a_force_that_jumps_where_slip_reverses_keeps_its_mean(self):
        """A slow hub and a bent wire: the tip first slides back on the workpart, then forward, with a tenth of the force."""
        tool = Tool(
            Hub(speed="478 rpm"),
            Belt(stiffness=0.0172, damping_ratio=1.2),
            Bristle(length=0.0257, knee_angle_deg=20.0),
            workpart=Workpart(penetration=0.00347),
        )
        found, report = rows(tool)
        assert any(len(each.edges) > 2 for each in report.subject.forces[0])
        series = load_cell_series(report.subject)["normal_force (N)"]
        # The rectangle rule as below.
        assert series.mean() == pytest.approx(found["mean_normal_force"].simulated, rel=1e-5)

    def test_the_band_holds_the_mean_and_narrows_with_the_bandwidth(self):
        found, report = rows()
        series = load_cell_series(report.subject)
        # The rectangle rule over a period of a force with kinks: (1/2000)^2 of a swing of 8 N.
        assert series["normal_force (N)"].mean() == pytest.approx(
            found["mean_normal_force"].simulated, rel=1e-5
        )
        low, high = found["force_envelope_low"].simulated, found["force_envelope_high"].simulated
        assert low < found["mean_normal_force"].simulated < high
        slow = load_cell_series(
            dataclasses.replace(report.subject, assembly=Assembly(bandwidth=50.0))
        )
        assert np.ptp(slow["normal_force (N)"]) < 0.01 * (high - low)
