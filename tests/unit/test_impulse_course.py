"""The course of an impact over its normal impulse: straight pieces, the scene's end, printed impulses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_laws import energetic_course, recorded_course, tip_velocity

IDENTICAL_RODS = Chain((5.0, 5.0), (1.0, 1.0), (-math.pi / 9.0, -math.pi / 6.0), (0.1, 0.2))
"""Stronge's double pendulum (Zhang 2020, fig. 2.28 at n = 1)."""

ROUNDING = 1e-11
"""Relative: a few hundred operations on doubles, amplified by what cancels in K near a jam."""
GAMMA = math.radians(23.4)
BRISTLE = Chain((8.387e-5,), (0.027,), (-GAMMA,), (3.23 * 261.8,), 0.0275, 261.8, -GAMMA)
THREE_RODS = Chain((3.0, 1.5, 0.7), (0.4, 0.9, 0.6), (0.3, -0.5, -0.9), (-1.0, 2.0, 3.0))
PRESSED = Chain((5.0, 5.0), (1.0, 1.0), (math.radians(-30.0), math.radians(40.0)), (0.3, -0.1))
"""Its slip goes the way that friction would press the tip back: with enough of it in restitution, slip at rest."""
STICKY = Surface(friction=0.7, restitution=0.5)
ROUGH = Surface(friction=0.5, restitution=0.5)


@pytest.mark.parametrize(
    ("chain", "surface"),
    [
        (BRISTLE, Surface()),
        (IDENTICAL_RODS, ROUGH),
        (IDENTICAL_RODS, STICKY),
        (IDENTICAL_RODS, Surface(friction=0.1, restitution=0.5, restitution_friction=0.8)),
        (PRESSED, Surface(friction=0.1, restitution=0.5, restitution_friction=5.0)),
        (THREE_RODS, ROUGH),
    ],
)
def test_course_ends_where_the_scene_does(chain: Chain, surface: Surface) -> None:
    """The scene's K comes from the engine's bodies and joints, the course's from the rods' kinetic energy."""
    course = energetic_course(chain, surface)
    contact = strike(chain, surface, Contact("energetic"), Settings()).contact
    speed = math.hypot(*contact.velocity_before)
    np.testing.assert_allclose(tip_velocity(chain), contact.velocity_before, rtol=ROUNDING)
    np.testing.assert_allclose(
        (course.normal_velocity[-1], course.tangential_velocity[-1]),
        contact.velocity_after,
        atol=ROUNDING * speed,
    )
    assert course.impulse[-1] == pytest.approx(contact.impulse[0], rel=ROUNDING)
    assert course.phases == contact.phases


@pytest.mark.parametrize(
    ("friction", "compressive", "final", "motions"),
    [
        (0.3, 0.45772963, 0.70237711, ("slip", "slip", "reverse slip")),
        (0.5, 0.37905577, 0.59199844, ("slip", "slip", "reverse slip")),
        (0.7, 0.32345998, 0.51199185, ("slip", "slip", "stick")),
    ],
)
def test_course_of_identical_rods(
    friction: float, compressive: float, final: float, motions: tuple[str, ...]
) -> None:
    """Impulses from Zhang 2020, eqs. 2.74-2.89, evaluated on their own to eight digits."""
    course = energetic_course(IDENTICAL_RODS, Surface(friction=friction, restitution=0.5))
    compression, slip = (1, 2)  # phases until compression and until slip ends
    assert course.impulse[compression] == pytest.approx(compressive, abs=5e-9)
    assert course.impulse[-1] == pytest.approx(final, abs=5e-9)
    assert tuple(phase.split(" ", 1)[1] for phase in course.phases) == motions
    assert course.normal_velocity[compression] == pytest.approx(0.0, abs=1e-15)
    assert course.tangential_velocity[slip] == pytest.approx(0.0, abs=1e-15)


def test_course_without_approach_is_a_point() -> None:
    course = energetic_course(Chain((1.0,), (1.0,), (-0.4,), (-1.0,)), Surface())
    assert course.impulse.tolist() == [0.0]
    assert course.phases == ()


@pytest.mark.parametrize(
    ("chain", "surface"), [(BRISTLE, Surface()), (IDENTICAL_RODS, ROUGH), (IDENTICAL_RODS, STICKY)]
)
def test_contact_resolved_in_time_lies_on_the_course(chain: Chain, surface: Surface) -> None:
    course = energetic_course(chain, surface)
    history = strike(chain, surface, Contact("compliant"), Settings()).contact.history
    assert history is not None
    recorded = recorded_course(history)
    # Where a phase is a single interval, at most pi/5 of half a wave of force, a chord leaves (pi/5)^3/12 of its impulse of 2.
    trapezoidal = (math.pi / 5.0) ** 3 / 24.0
    assert recorded.impulse[-1] == pytest.approx(course.impulse[-1], rel=trapezoidal)
    for name in ("normal_velocity", "tangential_velocity"):
        expected = np.interp(recorded.impulse, course.impulse, getattr(course, name))
        change = np.ptp(getattr(course, name))
        # The same share of the impulse moves a velocity by at most its steepest slope, at most 3 times the mean here.
        np.testing.assert_allclose(
            getattr(recorded, name), expected, atol=3.0 * trapezoidal * change
        )
