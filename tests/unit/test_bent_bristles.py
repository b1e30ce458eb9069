"""Bristles with a knee: geometry by quadrature, and the three shapes of the film."""

import dataclasses
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bristle_sim.parameters import Belt, Bristle, Contact, Hub, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.bent_bristles import bent_bristles, slide_of

TOOL = Tool(
    hub=Hub(speed=272.27),
    belt=Belt(damping_ratio=0.05),
    bristle=Bristle(knee_angle_deg=30.0),
    contact=Contact("compliant", 1e-4),
)


@pytest.mark.parametrize("angle", [-60.0, -5.0, 20.0, 90.0])
@pytest.mark.parametrize("position", [0.2, 0.75])
def test_centre_and_inertia_by_quadrature(angle: float, position: float) -> None:
    """The wire cut into 20 000 points of equal mass; its sums are good to the square of a piece, 1e-8."""
    bristle = Bristle(knee_position=position, knee_angle_deg=angle)
    along = (np.arange(20_000) + 0.5) / 20_000 * bristle.length
    shank, bend = position * bristle.length, math.radians(angle)
    over = np.maximum(along - shank, 0.0)
    x, y = over * math.sin(bend), -np.minimum(along, shank) - over * math.cos(bend)
    assert bristle.centre == pytest.approx((x.mean(), y.mean()), rel=1e-6, abs=1e-9)
    assert bristle.inertia_about_root == pytest.approx(bristle.mass * (x**2 + y**2).mean(), rel=1e-6)
    assert math.dist((0.0, 0.0), bristle.path[0]) == pytest.approx(shank)
    assert math.dist(bristle.path[0], bristle.tip) == pytest.approx(bristle.length - shank)


def test_a_vanishing_knee_is_a_straight_bristle() -> None:
    """A knee of 1e-9 rad moves the tip by 1e-9 of the wire; the pass must not notice more than that and its accuracy."""
    bent = dataclasses.replace(TOOL.bristle, knee_angle_deg=math.degrees(1e-9))
    straight = dataclasses.replace(TOOL.bristle, knee_angle_deg=0.0)
    runs = [
        simulate(dataclasses.replace(TOOL, bristle=each), Settings(accuracy=1e-8), stop_after="strike")
        for each in (bent, straight)
    ]
    first, second = (run.first_contact("workpart") for run in runs)
    assert first is not None
    assert second is not None
    assert first.time == pytest.approx(second.time, rel=1e-7)
    assert first.rates_before == pytest.approx(second.rates_before, rel=1e-7)
    assert first.impulse == pytest.approx(second.impulse, rel=1e-6)


def test_order_of_the_three_shapes() -> None:
    """Film (Zhang 2020, fig. 1.4): the forward bent tip retracts at once, the other two slide first."""
    report = bent_bristles(TOOL, Settings())
    slides = report.subject.slides
    assert slides["forward"].turns_in_compression
    assert not slides["reverse"].turns_in_compression
    after = {row.name: row.simulated for row in report.quantities}
    backwards = [after[f"{shape}_tip_speed_along_after"] for shape in ("reverse", "straight", "forward")]
    assert backwards == sorted(backwards, reverse=True)
    assert backwards[-1] < backwards[0] < 0.0


def test_slide_is_the_tips_displacement() -> None:
    """The path integrated from the contact's velocity is how far the tip has moved between its ends, within the
    trapezoidal rule on some thirty samples."""
    run = simulate(TOOL, Settings(), stop_after="strike")
    contact = run.first_contact("workpart")
    assert contact is not None
    slide = slide_of(contact)
    assert slide.total == pytest.approx(run.tip[-1, 0] - run.tip[-2, 0], rel=5e-3)
    assert slide.forward > slide.total


def test_needs_a_contact_in_time() -> None:
    with pytest.raises(ValueError, match="contact = energetic"):
        bent_bristles(dataclasses.replace(TOOL, contact=Contact()), Settings())


def test_script() -> None:
    script = Path(__file__).parents[2] / "scenarios" / "bent_bristles.py"
    done = subprocess.run([sys.executable, str(script), "--json", "-"], capture_output=True, text=True, check=True)
    names = {row["name"] for row in json.loads(done.stdout)["quantities"]}
    assert {"reverse_forward_slide", "straight_forward_slide", "forward_forward_slide"} <= names


def test_a_spent_budget_is_no_result() -> None:
    with pytest.raises(ValueError, match="step budget spent"):
        bent_bristles(Tool(contact=Contact("compliant", 1e-4)), Settings(maximum_steps=100))
