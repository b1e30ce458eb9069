"""A contact of a given compression time and impulse: harmonic motion, energy balance, and chapter 3 beside it."""

import math

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, ForceHistory, Hub, Measurement, Surface
from bristle_sim.settings import Settings
from bristle_sim.studies.force_comparison import force_comparison
from bristle_sim.studies.timed_contact import timed_contact
from bristle_sim.theory.force_history import BRISTLE

GAMMA = math.radians(23.4)
RATE = 3.23 * 261.8
SPEED = 0.027 * RATE + 0.0275 * 261.8


def contact(friction=0.31, restitution=0.42, *, time=5e-5, angle=GAMMA, hub=None, **asked):
    asked = asked or {"rate": RATE}
    surface = Surface(friction=friction, restitution=restitution)
    return timed_contact(
        hub or Hub(), Bristle(), surface, angle, Settings(), compression_time=time, **asked
    )


def report(history=None, measurement=None, friction=0.31, hub=None):
    surface = Surface(friction=friction)
    return force_comparison(
        hub or Hub(),
        Bristle(),
        surface,
        history or ForceHistory(),
        measurement or Measurement(),
        Settings(),
    )


def row(found, name):
    return next(each for each in found.quantities if each.name == name)


def test_a_short_contact_is_a_quarter_of_a_sine_wave_with_the_rigid_bodys_impulse_and_energy():
    """One degree of freedom on a linear spring: F = F_max sin(pi t/(2 t_c)), whatever the friction."""
    short = contact(0.31, 0.0, time=1e-9)
    # The hub turns by 3e-7 rad in 1 ns, and slip stops that much before the tip is deepest.
    assert short.peak_force * short.compression_time / short.compressive_impulse == pytest.approx(
        math.pi / 2, rel=1e-4
    )
    for part in (0.1, 0.5, 0.9):
        fraction = (
            short.resultant.integrate(0.0, part * short.compression_time)
            / short.compressive_impulse
        )
        assert fraction == pytest.approx(1.0 - math.cos(part * math.pi / 2.0), rel=1e-4, abs=1e-5)
    # p_cy and W_x + W_y at the operating point, from the closed forms by hand.
    assert short.compressive_impulse == pytest.approx(1.231668e-3 * math.hypot(1.0, 0.31), rel=2e-4)
    # v = v_C cos(pi t/(2 t_c)): the path is 2/pi v_C t_c.
    assert short.path[np.argmax(short.history.penetration)] == pytest.approx(
        2.0 / math.pi * SPEED * 1e-9, rel=1e-4
    )


@pytest.mark.parametrize("friction", [0.0, 0.31, 0.5])
def test_a_contact_of_given_time_and_impulse(friction):
    found = contact(friction, 0.0, impulse=1.6e-3)
    # To the 1e-6 of the adjustment.
    assert found.compression_time == pytest.approx(5e-5, rel=2e-6)
    assert found.compressive_impulse == pytest.approx(1.6e-3, rel=2e-6)
    assert found.resultant.integrate(0.0, found.compression_time) == found.compressive_impulse


@pytest.mark.parametrize(
    ("asked", "line"),
    [
        ({"rate": -1e3}, "approaches at"),
        (
            {"rate": RATE, "compression_time": 2e-4, "angle": 0.001},
            "turns too far|not over|approaches at",
        ),
        ({"rate": RATE, "compression_time": 2.0}, "more than the bristle's length"),
    ],
)
def test_contacts_that_there_are_not(asked, line):
    asked = {"compression_time": 5e-5, **asked}
    angle = asked.pop("angle", GAMMA)
    with pytest.raises(ValueError, match=line):
        timed_contact(Hub(), Bristle(), Surface(), angle, Settings(), **asked)


def test_the_report_beside_print():
    found = report()
    peak, time, impulse = (
        row(found, name) for name in ("peak_force", "compression_time", "compressive_impulse")
    )
    assert peak.theory == pytest.approx(57.0, abs=0.5)  # printed to the newton (3.21)
    assert time.theory == pytest.approx(5e-5, rel=1e-4)  # read off a camera (3.20)
    assert impulse.theory == pytest.approx(1.61157e-3, rel=2e-4)  # (3.19) integrated to 50 us
    assert time.ok
    assert impulse.ok
    assert peak.ok is None
    # A spring's quarter wave of that impulse and time has pi/2 p/t = 50.6 N; the turning hub takes some per cent.
    assert peak.simulated == pytest.approx(math.pi / 2.0 * impulse.theory / time.theory, rel=0.05)
    below = f"{100.0 * (1.0 - peak.simulated / peak.theory):.0f} % below"
    assert report().answer == (
        f"The simulated force peaks at {peak.simulated:.3g} N, {below} the 56.9 N of chapter 3's curve, at the same impulse of"
        " 1.61 mN s and compression time of 50 µs."
    )


def test_speed_and_time_may_be_given():
    found = report(ForceHistory(speed_ratio=3.23, compression_time=2e-5))
    contact = found.subject.contact
    assert contact.tip_speed == pytest.approx(SPEED, rel=1e-12)
    assert contact.compression_time == pytest.approx(2e-5, rel=2e-6)
    assert row(found, "compression_time").ok is None
    assert row(found, "compressive_impulse").ok is None
    assert "at an impulse of" in found.answer


def test_without_a_contact_there_is_still_the_curve():
    found = report(hub=Hub(speed=1e6))
    assert found.outcome == "no contact"
    assert row(found, "peak_force").simulated is None
    assert row(found, "compressive_impulse").ok is False
    assert found.answer.startswith("There is no simulated force: ")
    assert any("simulated: nothing" in line for line in found.remarks)


def points_of(path, force=BRISTLE, *, before=0, after=0, origin=0.0, baseline=0.0, noise=0.0):
    """A contact of 100 us, each microsecond, in ms and mN, with semicolons and decimal commas."""
    time = np.arange(-before, 101 + after) * 1e-6
    pushed = np.where((time >= 0.0) & (time <= 1e-4), force(np.clip(time, 0.0, 1e-4)), 0.0)
    pushed = pushed + baseline + noise * np.random.default_rng(3).standard_normal(time.size)
    lines = [
        f"{1e3 * (t + origin):.12g};{1e3 * f:.12g}".replace(".", ",")
        for t, f in zip(time, pushed, strict=True)
    ]
    path.write_text("\n".join(["Zeit (ms);Kraft (mN)", *lines]), encoding="utf-8")
    return Measurement(str(path))


@pytest.mark.parametrize(
    ("origin", "sides"),
    [(0.0, {}), (1.0, {"before": 100}), (0.01, {"before": 500, "after": 700, "baseline": 8.0})],
)
def test_a_file_on_another_clock_gives_the_same_contact(tmp_path, origin, sides):
    found = report(measurement=points_of(tmp_path / "scope.csv", origin=origin, **sides))
    # (3.19) to 50 us, and the 3e-4 by which its printed offset is not (3.3)'s.
    assert row(found, "compression_time").theory == pytest.approx(5e-5, rel=1e-3)
    assert row(found, "compressive_impulse").theory == pytest.approx(1.61157e-3, rel=1e-3)
    assert row(found, "peak_force").theory == pytest.approx(56.88, rel=1e-3)
    assert found.extra["measured_fit"]["start"] == pytest.approx(origin, abs=3e-8)
    assert found.extra["measured_fit"]["baseline"] == pytest.approx(
        sides.get("baseline", 0.0), abs=0.02
    )
    assert [each.name for each in found.quantities if each.ok is False] == []
    # Points and curve share their clock and zero: what is drawn coincides.
    measured = found.subject.measured
    inside = (measured.time >= 0.0) & (measured.time <= measured.fit.curve.duration)
    np.testing.assert_allclose(
        measured.force[inside], found.subject.curve(measured.time[inside]), atol=0.05
    )


FORMS = {
    "half sine": (lambda x: np.sin(np.pi * x), True),
    "Hertz": (lambda x: np.sin(np.pi * x) ** 1.5, True),
    "rectangle": (lambda x: np.where((x > 0.05) & (x < 0.95), 1.0, 0.0), False),
    "two humps": (lambda x: np.sin(2.0 * np.pi * x) ** 2 + 0.8 * np.sin(np.pi * x) ** 4, False),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_force_of_another_form_is_distinguished_from_the_curves(tmp_path, form):
    """A half sine differs from (3.3) by 0.027 of its peak, Hertz's form by 0.003, the others by far more than 0.05."""
    shape, like = FORMS[form]
    sides = {"before": 100, "after": 100, "noise": 1.0}
    found = report(
        measurement=points_of(tmp_path / "form.csv", lambda time: 57.0 * shape(1e4 * time), **sides)
    )
    assert (
        all(each.ok is not False for each in found.quantities if each.name.startswith("fit"))
        is like
    )
    if like:
        # 2/pi of the peak times the duration for a half sine; noise of 1 N of 57.
        whole = np.trapezoid(shape(np.linspace(0.0, 1.0, 10001)), dx=1e-8) * 57.0
        fitted = found.subject.curve.impulse(found.subject.curve.duration)
        assert fitted == pytest.approx(whole, rel=0.03)
