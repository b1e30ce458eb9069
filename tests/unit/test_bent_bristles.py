"""Bristles with a knee: geometry by quadrature, and the three shapes of the film."""

import dataclasses

import pytest

from bristle_sim.parameters import Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.bent_bristles import against_film, answer, bent_bristles, slide_measures

TOOL = Tool(
    hub=Hub(speed=272.27),
    belt=Belt(damping_ratio=0.05),
    bristle=Bristle(knee_angle_deg=30.0),
    contact=Contact("compliant", 1e-4),
)


def test_order_of_the_three_shapes() -> None:
    """Film (Zhang 2020, fig. 1.4): the forward bent tip retracts at once, the other two slide first."""
    report = bent_bristles(TOOL, Settings())
    reverse, straight, forward, _ = report.remarks
    assert "compression reverse slip" in forward
    for remark in (reverse, straight):
        assert "compression reverse slip" not in remark
        assert "restitution reverse slip" in remark
    after = {row.name: row.simulated for row in report.quantities}
    backwards = [
        after[f"{shape}_tip_speed_along_after"] for shape in ("reverse", "straight", "forward")
    ]
    assert backwards == sorted(backwards, reverse=True)
    assert backwards[-1] < backwards[0] < 0.0


def test_slide_is_the_tips_displacement() -> None:
    """The path integrated from the contact's velocity is how far the tip has moved between its ends, within the
    trapezoidal rule on some thirty samples."""
    run = simulate(TOOL, Settings(), stop_after="strike")
    contact = run.first_contact("workpart")
    assert contact is not None
    slide = slide_measures(contact)
    begin = float(run.at(contact.time).tip[0])
    assert slide["slide_in_touch"] == pytest.approx(run.tip[-1, 0] - begin, rel=5e-3)
    assert slide["forward_slide"] > slide["slide_in_touch"]


def test_the_answer_is_that_of_the_slides() -> None:
    report = bent_bristles(
        dataclasses.replace(TOOL, bristle=Bristle(knee_angle_deg=60.0)), Settings()
    )
    slides = report.subject.slides
    reverse, straight, forward = (slides[shape] for shape in ("reverse", "straight", "forward"))
    assert f"{100.0 * forward / (0.5 * (reverse + straight)):.0f} % as far" in report.remarks[-1]
    first = f"The reverse bent tip slides {1e3 * reverse:.2f} mm, the straight tip slides {1e3 * straight:.2f} mm"
    assert report.answer.startswith(first)
    away = dataclasses.replace(TOOL, workpart=Workpart(penetration=-0.001))
    assert (
        bent_bristles(away, Settings()).answer
        == "No tip slides, because none strikes the workpart."
    )


def test_a_tip_that_retracts_at_once_is_named() -> None:
    """As in the film: a forward slide of a hundredth of the others'."""
    words = answer({"reverse": 1e-3, "straight": 1e-3, "forward": 1e-5})
    assert "the forward bent tip retracts at once" in words
    assert against_film({"reverse": 0.0, "straight": 0.0, "forward": 1e-3}).startswith("neither")
    words = answer({"reverse": None, "straight": 1e-3, "forward": 1e-3})
    assert words.startswith("The reverse bent tip never strikes, the straight tip slides 1.00 mm")
