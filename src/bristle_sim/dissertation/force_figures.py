"""Figures 3.1-3.3 and table 3.1: the force history (Zhang 2020, chapter 3)."""

from __future__ import annotations

import functools
from itertools import pairwise

import numpy as np

from bristle_sim.dissertation.printed import printed_number, printed_segments
from bristle_sim.dissertation.redrawn import Axis, Mark, Panel, Redrawn, curve_of
from bristle_sim.parameters import Bristle, Hub, Strike, Surface
from bristle_sim.settings import Settings
from bristle_sim.studies.timed_contact import TimedContact, timed_contact
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE
from bristle_sim.theory.force_fit import fit_decay
from bristle_sim.theory.force_history import BALL, BRISTLE, segment_impulses

NOISE = 5.0
POINTS = 61
SEED = 1
"""Standard deviation of the noise (N), number of noisy points, and seed of the random numbers.

The noisy points replace the measured points of figure 3.1, which are not in print."""

MILLISECONDS = Axis("time since first touch", "ms", 1e3)
MICROSECONDS = Axis("time since first touch", "µs", 1e6)
FORCE = Axis("force", "N")
TABLE_3_1 = printed_segments()
SEGMENTS = len(TABLE_3_1)
PRINTED_IMPULSE = printed_number("eq. 3.9: compressive impulse of the bristle")


def points_figure() -> Redrawn:
    """Return figure 3.1: a ball's contact force over time, as points and as a fitted curve.

    The measured points are not in print. Points of the printed curve with random noise replace
    them.
    """
    time = np.linspace(0.0, BALL.duration, POINTS)
    force = np.asarray(BALL(time)) + NOISE * np.random.default_rng(SEED).standard_normal(POINTS)
    fit = fit_decay(time, force, BALL.duration, 2.0 * BALL.swing)
    shown = f"fit: c = {fit.amplitude:.3f}, $\\lambda$ = {fit.decay:.0f} /s"
    curve = curve_of(shown, fit, np.linspace(0.0, BALL.duration, 201), {"sampled": (time, force)})
    note = "the measured points are not in print: these are drawn from (3.5), c = 1.3935, $\\lambda$ = 101.6 /s"
    title = "force of a steel ball on a steel plate over time"
    return Redrawn("3.1", title, (Panel(MILLISECONDS, FORCE, (curve,)),), note)


def fit_figure() -> Redrawn:
    """Return figure 3.2: the fitted force curve of the ball, with its inflection point and
    maximum.
    """
    at = np.linspace(0.0, 5e-3, 11)
    printed = (
        1.3935
        * np.exp(-101.6189 * at)
        * (145.0 - 167.5 * np.cos(2.0 * np.pi * (at + 0.0005) / 0.006))
    )
    curve = curve_of(
        "(3.5)", BALL, np.linspace(0.0, BALL.duration, 201), {"printed": (at, printed)}
    )
    bend = BALL.inflection_time()
    peak = BALL.peak_time()
    marks = (
        Mark(bend, float(BALL(bend)), f"rises fastest at {1e3 * bend:.3f} ms"),
        Mark(peak, BALL.peak_force(), f"{BALL.peak_force():.1f} N at {1e3 * peak:.3f} ms", "above"),
    )
    note = f"impulse up to the largest force {float(BALL.impulse(peak)):.4f} N·s; printed as 0.4269 N·m"
    panel = Panel(MILLISECONDS, FORCE, (curve,), marks=marks)
    return Redrawn("3.2", "force history of the ball, by (3.5)", (panel,), note)


def bristle_figure() -> Redrawn:
    """Return figure 3.3: the force on the bristle over time.

    The curves are the printed formula and the ball's rescaled formula. The points are the mean
    forces of the segments of table 3.1, and the forces of a simulated contact with the same
    compressive impulse as the formula.
    """
    step = BRISTLE.peak_time() / SEGMENTS
    middles = step * (np.arange(SEGMENTS) + 0.5)
    mean = 1e-4 * np.array([float(each) for each in TABLE_3_1]) / step
    grid = np.linspace(0.0, BRISTLE.duration, 201)
    contact = bristle_contact(impulse=True)
    scaled = BALL.rescaled(PRINTED_IMPULSE, BRISTLE.peak_time())
    # The contact outlasts the curve, and has two samples at some instants.
    time, first = np.unique(contact.time, return_index=True)
    kept = time <= BRISTLE.duration
    points = {"table": (middles, mean), "contact": (time[kept], contact.force[first][kept])}
    curves = (
        curve_of("(3.19)", BRISTLE, grid, points),
        curve_of("ball's curve rescaled", scaled, np.linspace(0.0, scaled.duration, 201)),
    )
    mark = Mark(BRISTLE.peak_time(), BRISTLE.peak_force(), f"{BRISTLE.peak_force():.1f} N", "above")
    note = f"simulated: resultant of a contact with the curve's impulse, largest {contact.peak_force:.1f} N"
    panel = Panel(MICROSECONDS, FORCE, curves, marks=(mark,))
    return Redrawn("3.3", "force on the bristle's tip, by (3.19)", (panel,), note)


def table() -> Redrawn:
    """Return table 3.1: the impulses of ten equal time segments of compression.

    The columns are the printed impulses, those that eq. (3.15) and eq. (3.19) give, and those of a
    simulated contact.
    """
    contact = bristle_contact(impulse=True)
    edges = np.linspace(0.0, contact.compression_time, SEGMENTS + 1).tolist()
    columns = (
        1e4 * segment_impulses(BALL, PRINTED_IMPULSE),
        1e4 * segment_impulses(BRISTLE, float(BRISTLE.impulse(BRISTLE.peak_time()))),
        [1e4 * contact.resultant.integrate(*pair) for pair in pairwise(edges)],
    )
    rows = [
        (
            str(i + 1),
            f"{1e6 * edges[i]:.0f}-{1e6 * edges[i + 1]:.0f}",
            printed,
            *(f"{each[i]:.3f}" for each in columns),
        )
        for i, printed in enumerate(TABLE_3_1)
    ]
    totals = (
        f"{sum(float(each) for each in TABLE_3_1):.2f}",
        *(f"{sum(each):.3f}" for each in columns),
    )
    head = ("segment", "time (µs)", "printed", "by (3.15)", "by (3.19)", "simulated")
    return Redrawn(
        "table_3.1",
        "ten-segment impulse of the bristle",
        note="in 0.1 mN·s; (3.15) divides the printed 1.619 mN·s like the ball's curve, (3.19) has 0.46 % less in all",
        table=(head, *rows, ("sum", "", *totals)),
    )


@functools.cache
def bristle_contact(*, impulse: bool) -> TimedContact:
    """Simulate a contact of the bristle with the compression time of the force in eq. (3.19).

    If ``impulse`` is true, the bristle strikes at the speed that gives the contact the compressive
    impulse of (3.19) too. Otherwise it strikes at the speed of the operating point.
    """
    peak = BRISTLE.peak_time()
    return timed_contact(
        Hub(),
        Bristle(),
        Surface(),
        IMPACT_ANGLE,
        Settings(),
        compression_time=peak,
        rate=None if impulse else Strike().speed_ratio * Hub().speed,
        impulse=float(BRISTLE.impulse(peak)) if impulse else None,
    )
