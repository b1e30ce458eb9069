"""Figure and film of an impact show the computed motion, to scale, and say where there is none."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Contact, Hub, Strike, Surface
from bristle_sim.render.impact_pictures import ImpactFilm, impact_figure
from bristle_sim.render.style import save_figure
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_laws import Impacts, energetic_course
from bristle_sim.studies.impacts import oblique_impact
from bristle_sim.studies.timed_contact import with_visible_contact
from impact_cases import TRAPEZOIDAL, bristle, data, rods, words


@pytest.fixture(scope="module")
def strike() -> Impacts:
    return bristle()


@pytest.fixture(scope="module")
def pendulum() -> Impacts:
    return rods()


@pytest.mark.parametrize("contact", [Contact(), Contact("compliant"), Contact("engine")])
def test_films_show_the_printed_compression_and_say_so(contact: Contact) -> None:
    """50 us of compression, millimetres and some ten newtons instead of nanometres and meganewtons."""
    shown = with_visible_contact(bristle(contact=contact))
    scene = ImpactFilm(shown, width=320, height=180)
    deepest = scene.motion.time[np.argmin(scene.motion.vectors["path"][0])]
    assert deepest == pytest.approx(5e-5, rel=1e-5)
    # Impulse over duration: the mean force of 2.8 mN s in some 100 us; the peak is at most pi/2 of it in either half.
    assert 20.0 < scene.motion.vectors["force"][0].max() < 100.0
    written = "\n".join(each.get_text() for each in scene.figure.texts)
    assert "compression 50 µs (as printed, for the film)" in written


def test_films_show_a_requested_duration_and_a_tip_that_stays() -> None:
    shown = with_visible_contact(bristle(contact=Contact("compliant", 2e-5)))
    assert (
        shown.timing,
        ImpactFilm(shown, width=320, height=180).motion.phases[-1].caption[:7],
    ) == (
        "contact_duration as requested",
        "rebound",
    )
    sticking = ImpactFilm(with_visible_contact(bristle(friction=0.9)), width=320, height=180)
    assert sticking.motion.phases[-1].caption == "stiction: the tip stays"


def test_films_of_rods_too_small_or_slow_for_it_show_the_limit_and_say_so() -> None:
    tiny = oblique_impact(
        Hub(), Bristle(length=1e-5), Strike(), Surface(), Contact(), Settings()
    ).subject
    slow = rods(rate_1=-1e-5, rate_2=-2e-5)
    for impacts in (tiny, slow):
        shown = with_visible_contact(impacts)
        assert shown.timing == "rigid-body limit"
        assert shown.strikes == impacts.strikes


def test_film_shows_the_motion(pendulum: Impacts) -> None:
    scene = ImpactFilm(pendulum, width=320, height=180, duration=4.0)
    stop = next(
        phase.start for phase in scene.motion.phases if phase.caption == "restitution reverse slip"
    )
    film_time = float(scene.warp.film_time(stop))
    scene.show(film_time)
    for hand in scene.hands:
        instant = hand.get_xdata()[0] / scene.clock.factor
        assert instant == pytest.approx(stop, rel=1e-3)  # the warp is linear between 4001 nodes
        expected = scene.speed.factor * scene.motion.at(instant, "velocity")[0]
        # The read-out has two digits after the point.
        shown = scene.texts[3].split()[1].replace("\N{MINUS SIGN}", "-")
        assert float(shown) == pytest.approx(expected, abs=0.006)
    for later, caption in (
        (-0.1, "restitution: the tip slips"),
        (0.1, "restitution: the tip slips back"),
    ):
        scene.show(film_time + later)
        assert scene.texts[0] == caption
    scene.show(scene.warp.film[-1])
    assert scene.texts[0] == "rebound"


def test_no_film_of_a_tip_that_does_not_approach(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no contact"):
        ImpactFilm(rods(rate_1=1.0, rate_2=1.0))
    with pytest.raises(ValueError, match=r"\.avi"):
        ImpactFilm(rods()).write(tmp_path / "impact.avi")
    unresolved = dataclasses.replace(rods(), strikes={})
    with pytest.raises(ValueError, match="no motion to film"):
        ImpactFilm(unresolved)
    assert not list(tmp_path.iterdir())


def test_impulse_plane_shows_the_course_and_the_contact_resolved_in_time(strike: Impacts) -> None:
    (plane,) = impact_figure(strike).axes
    course = energetic_course(strike.chain, strike.surface)
    assert "mN·s" in plane.get_xlabel()
    for name in ("normal_velocity", "tangential_velocity"):
        x, y = data(plane, name)
        np.testing.assert_allclose(x, course.impulse * 1e3)
        np.testing.assert_allclose(y, getattr(course, name))
        x, y = data(plane, f"{name}, resolved in time")
        assert x.size > 24
        np.testing.assert_allclose(
            y,
            np.interp(x, course.impulse * 1e3, getattr(course, name)),
            atol=3.0 * TRAPEZOIDAL * np.ptp(getattr(course, name)),
        )


def test_figures_of_what_does_not_happen_say_so(tmp_path: Path) -> None:
    resting = impact_figure(rods(rate_1=0.0, rate_2=0.0))
    (plane,) = resting.axes
    assert "no contact" in words(plane)
    save_figure(resting, tmp_path / "resting.png")
    unresolved = rods()
    del unresolved.strikes["compliant"]
    (plane,) = impact_figure(unresolved).axes
    names = {each.get_gid() for each in plane.get_lines()}
    assert not any(name and "resolved" in name for name in names)
