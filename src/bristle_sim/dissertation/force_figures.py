"""Figures 3.1-3.3 and table 3.1: the force history (Zhang 2020, chapter 3)."""

from __future__ import annotations

import functools
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.dissertation.redrawn import Redrawn
from bristle_sim.parameters import Bristle, Hub, Strike, Surface
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.curves import Axis, Mark, Panel, curve_of
from bristle_sim.studies.force_fits import noisy_points
from bristle_sim.studies.timed_contact import timed_contact
from bristle_sim.theory.crater_kinematics import IMPACT_ANGLE
from bristle_sim.theory.force_fit import fit_force_history
from bristle_sim.theory.force_history import (
    BALL,
    BRISTLE,
    PRINTED_BRISTLE_IMPULSE,
    TABLE_3_1,
    ForceCurve,
    segment_impulses,
)

NOISE, POINTS = 5.0, 61
"""Noise (N) and number of the points that stand in for the measured ones."""

MILLISECONDS = Axis("time since first touch", "ms", 1e3)
MICROSECONDS = Axis("time since first touch", "µs", 1e6)
FORCE = Axis("force", "N")
SEGMENTS = len(TABLE_3_1)


def points_figure() -> Redrawn:
    """Figure 3.1: points of the ball's impact."""
    time, force = noisy_points(BALL, POINTS, NOISE)
    fit = fit_force_history(time, force, duration=BALL.duration, peak_force=2.0 * BALL.swing, start=0.0)
    shown = f"fit: c = {fit.values[0]:.3f}, $\\lambda$ = {fit.values[1]:.0f} /s"
    curve = curve_of(shown, fit.curve, np.linspace(0.0, BALL.duration, 201), {"sampled": (time, force)})
    return Redrawn(
        "3.1",
        "force of a steel ball on a steel plate over time",
        (Panel(MILLISECONDS, FORCE, (curve,)),),
        "the measured points are not in print: these are drawn from (3.5), c = 1.3935, $\\lambda$ = 101.6 /s",
    )


def fit_figure() -> Redrawn:
    """Figure 3.2: the fitted curve, its inflection point and its largest force."""
    at = np.linspace(0.0, 5e-3, 11)
    printed = 1.3935 * np.exp(-101.6189 * at) * (145.0 - 167.5 * np.cos(2.0 * np.pi * (at + 0.0005) / 0.006))
    curve = curve_of("(3.5)", BALL, np.linspace(0.0, BALL.duration, 201), {"printed": (at, printed)})
    bend, peak = BALL.inflection_time(), BALL.peak_time()
    marks = (
        Mark(bend, float(BALL(bend)), f"rises fastest at {1e3 * bend:.3f} ms"),
        Mark(peak, BALL.peak_force(), f"{BALL.peak_force():.1f} N at {1e3 * peak:.3f} ms", "above"),
    )
    note = f"impulse up to the largest force {float(BALL.impulse(peak)):.4f} N·s; printed as 0.4269 N·m"
    return Redrawn(
        "3.2", "force history of the ball, by (3.5)", (Panel(MILLISECONDS, FORCE, (curve,), marks=marks),), note
    )


def bristle_figure() -> Redrawn:
    """Figure 3.3: the bristle's force curve, the segments of table 3.1, and a simulated contact of its impulse."""
    step = BRISTLE.peak_time() / SEGMENTS
    middles = step * (np.arange(SEGMENTS) + 0.5)
    mean = 1e-4 * np.array([float(each) for each in TABLE_3_1]) / step
    grid = np.linspace(0.0, BRISTLE.duration, 201)
    contact = bristle_contact(impulse=True)
    scaled = BALL.rescaled(PRINTED_BRISTLE_IMPULSE, BRISTLE.peak_time())
    own = {"table": (middles, mean), "contact": (contact.time, contact.resultant.values)}
    curves = (
        curve_of("(3.19)", BRISTLE, grid, {law: _within(points, BRISTLE) for law, points in own.items()}),
        curve_of("ball's curve rescaled", scaled, np.linspace(0.0, scaled.duration, 201)),
    )
    peak = BRISTLE.peak_time()
    marks = (Mark(peak, BRISTLE.peak_force(), f"{BRISTLE.peak_force():.1f} N", "above"),)
    note = f"simulated: resultant of a contact with the curve's impulse, largest {contact.peak_force:.1f} N"
    return Redrawn(
        "3.3", "force on the bristle's tip, by (3.19)", (Panel(MICROSECONDS, FORCE, curves, marks=marks),), note
    )


def table() -> Redrawn:
    """Table 3.1: ten segments of the compression by print, by (3.15), by (3.19) and simulated."""
    contact = bristle_contact(impulse=True)
    edges = np.linspace(0.0, contact.compression_time, SEGMENTS + 1).tolist()
    simulated = [1e4 * contact.resultant.integral(*pair) for pair in pairwise(edges)]
    scaled = 1e4 * segment_impulses(BALL, PRINTED_BRISTLE_IMPULSE)
    own = 1e4 * segment_impulses(BRISTLE, float(BRISTLE.impulse(BRISTLE.peak_time())))
    columns = zip(TABLE_3_1, scaled, own, simulated, strict=True)
    rows = [
        (str(i), f"{1e6 * low:.0f}-{1e6 * high:.0f}", printed, *(f"{each:.3f}" for each in computed))
        for i, ((low, high), (printed, *computed)) in enumerate(zip(pairwise(edges), columns, strict=True), start=1)
    ]
    totals = (
        f"{sum(float(each) for each in TABLE_3_1):.2f}",
        *(f"{sum(each):.3f}" for each in (scaled, own, simulated)),
    )
    head = ("segment", "time (µs)", "printed", "by (3.15)", "by (3.19)", "simulated")
    return Redrawn(
        "table_3.1",
        "ten-segment impulse of the bristle",
        note="0.1 mN·s; (3.15) shares the printed 1.619 mN·s out as the ball's curve does, (3.19) carries 0.46 % less",
        table=(head, *rows, ("sum", "", *totals)),
    )


@functools.cache
def bristle_contact(*, impulse: bool) -> TimedContact:
    """The bristle's contact with (3.19)'s compression time and impulse, or with the operating point's speed instead."""
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


def _within(points: tuple[ArrayLike, ArrayLike], curve: ForceCurve) -> tuple[Array, Array]:
    """Points that the curve's duration covers, each instant once."""
    time, first = np.unique(np.asarray(points[0]), return_index=True)
    kept = time <= curve.duration
    return time[kept], np.asarray(points[1])[first][kept]
