"""What the rigid bristle overstates: the report, the study over stiffness and links, its figure and its film."""

from functools import partial

import numpy as np
import pytest

from bristle_sim.comparison import Report
from bristle_sim.parameters import Belt, Bristle, ContactStiffness, Hub, Strike, Surface
from bristle_sim.reference import strike_reference
from bristle_sim.render.wire_pictures import WireFilm
from bristle_sim.settings import Settings
from bristle_sim.studies.flexible_wire import flexible_wire, second_touch, wire_study

SMOOTH = Surface(0.0)


def struck(
    links: int, duration: float = 71e-6, surface: Surface = SMOOTH, **options: bool
) -> Report:
    """One strike of a wire of links at the operating point."""
    parts = (
        Hub(),
        Belt(),
        Bristle(links=links),
        Strike(),
        surface,
        ContactStiffness(duration),
        Settings(),
    )
    return flexible_wire(*parts, **options)


def rows(report: Report) -> dict:
    return {each.name: each for each in report.quantities}


@pytest.fixture(scope="module")
def short() -> Report:
    return struck(2)


def test_numbers_of_an_independent_prototype(short: Report) -> None:
    """3.154 mN s, 66.8 N and 73.7 us of the rigid bristle, half of the last digits; 1.2412 mN s of two links."""
    found = rows(short)
    assert found["normal_final_impulse"].theory == pytest.approx(3.154e-3, abs=0.5e-6)
    assert found["peak_force"].theory == pytest.approx(66.8, abs=0.05)
    assert found["time_in_touch"].theory == pytest.approx(73.7e-6, abs=0.06e-6)
    assert found["normal_final_impulse"].simulated == pytest.approx(1.2412e-3, abs=0.05e-6)
    assert found["impulse_ratio_to_rigid"].simulated == pytest.approx(1.2412 / 3.15384, rel=1e-4)
    assert short.outcome == "rebound"


def test_the_answer_has_both_sides_and_says_whether_the_wire_touches_again(short: Report) -> None:
    """The rigid bristle's 3.154 mN s and 66.8 N as above; a soft, elastic contact of six links throws the end back twice."""
    assert "With 2 links the impulse is 1.24 mN s," in short.answer
    assert (
        "the rigid bristle at the same contact stiffness has 3.15 mN s, 66.8 N and" in short.answer
    )
    wire = Bristle(links=6, modulus=70e9)
    parts = (
        Hub(),
        Belt(),
        wire,
        Strike(),
        Surface(0.0, None, 0.6),
        ContactStiffness(142e-6),
        Settings(1e-4),
    )
    report = flexible_wire(*parts, with_reference=False)
    found = second_touch(report.subject.wire)
    assert found is not None
    # By the second strike that starts from the wire's state then: its end approaches the workpart there.
    assert (
        f"The wire's end touches again {1e6 * found:.3g} µs after the first touch" in report.answer
    )
    height = report.subject.wire.centre_line[:, -1, 1] - report.subject.wire.centre_line[0, -1, 1]
    assert (
        np.interp(found - 2e-6, report.subject.wire.time, height)
        > height[report.subject.wire.time >= found][0]
    )
    assert "touches again" not in struck(2, duration=5e-6, with_reference=False).answer


def test_the_reference_judges_every_row(short: Report) -> None:
    """Two links have one bending mode; the second is the beam's alone."""
    judged = [each for each in short.quantities if each.name != "second_bending_frequency"]
    assert all(each.ok for each in judged)
    assert all(each.judge and each.judge[0] == "reference" for each in judged)
    assert rows(short)["second_bending_frequency"].simulated is None


@pytest.mark.parametrize("surface", [Surface(11.0), Surface(0.0, 1e9)])
def test_friction_that_takes_the_reference_too_long_leaves_it_out(surface: Surface) -> None:
    report = struck(2, surface=surface)
    assert {each.ok for each in report.quantities if "bending" not in each.name} == {None}
    assert any(
        each.startswith("There is a reference for the frequencies alone") for each in report.remarks
    )


def test_a_contact_that_is_too_stiff_for_the_reference_leaves_it_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A step of the integrator takes twelve evaluations, and a contact some steps."""
    few = partial(strike_reference, most_evaluations=24)
    monkeypatch.setattr("bristle_sim.reference.strike_reference", few)
    report = struck(2)
    assert {each.ok for each in report.quantities if "bending" not in each.name} == {None}
    assert any("must be less for the independent solution" in each for each in report.remarks)


def test_a_soft_contact_takes_the_wire_for_rigid() -> None:
    """At T = 10 ms, 30 periods of the bending mode, the part that vibrates is of order (0.34/10)^2, 1e-3: ten times that."""
    belt = Belt(stiffness=0.0)
    strike = Strike(speed_ratio=1e-3)
    parts = (
        Hub(speed=1.0),
        belt,
        Bristle(links=2),
        strike,
        SMOOTH,
        ContactStiffness(1e-2),
        Settings(),
    )
    ratio = rows(flexible_wire(*parts, with_reference=False))["impulse_ratio_to_rigid"].simulated
    assert ratio == pytest.approx(1.0, abs=1e-2)


def test_a_rigid_bristle_that_sticks_is_named() -> None:
    """mu = 0.5 > tan(23.4 deg): the rigid bristle jams at the end of compression; the wire bends and rebounds."""
    report = struck(2, surface=Surface(0.5))
    assert report.outcome == "rebound"
    assert any("The rigid bristle's outcome is stiction" in each for each in report.remarks)
    assert rows(report)["impulse_ratio_to_rigid"].reference is None
    assert rows(report)["normal_final_impulse"].ok


def test_study(short: Report) -> None:
    """Ratios at the requested stiffness are those of the report, to the study's accuracy; one link is the rigid bristle."""
    study = wire_study(short.subject.strike, stiffnesses=(1.0, 20.0))
    assert study.durations == pytest.approx([71e-6, 1420e-6])
    assert study.links.tolist() == [1.0, 2.0]
    for name in ("normal_final_impulse", "peak_force", "time_in_touch", "crater_depth"):
        row = rows(short)[name]
        expected = row.simulated / row.theory
        assert study.by_links[name] == pytest.approx([1.0, expected], rel=1e-3)
        assert study.by_duration[name][0] == pytest.approx(expected, rel=1e-3)
    # Nearer to rigid by far where the contact lasts four periods of bending.
    assert (
        abs(1.0 - study.by_duration["peak_force"][1])
        < 0.1
        < 1.0 - study.by_duration["peak_force"][0]
    )


def test_film_shows_the_wire_bend(short: Report) -> None:
    """To scale: the hinge is off the chord of root and tip by a quarter of the length times the bend, which is small."""
    scene = WireFilm(short.subject, width=320, height=240, duration=1.0)
    scene.show(float(scene.warp.film_time(3e-5)))
    points = scene.wires[0].wire.get_xydata()
    chord = points[-1] - points[0]
    first = points[1] - points[0]
    bend = (first[0] * chord[1] - first[1] * chord[0]) / np.linalg.norm(chord)
    angles = np.diff(
        [np.interp(3e-5, short.subject.wire.time, column) for column in short.subject.wire.angles.T]
    )
    assert bend == pytest.approx(0.25 * 27.0 * angles[0], rel=0.01)
    assert scene.texts[0]
    assert scene.texts[3].endswith("N")
