"""Data of the redrawn figures against the equations written out here, against print, and against themselves."""

import math

import numpy as np
import pytest

from bristle_sim.comparison import Quantity
from bristle_sim.dissertation import impact_figures
from bristle_sim.dissertation.figures import NUMBERS, _answer, redrawn
from bristle_sim.dissertation.redrawn import (
    SOURCES,
    Axis,
    Panel,
    Redrawn,
    curve_of,
    largest_differences,
)

MASS = 8.387e-5
LENGTH = 0.027
RADIUS = 0.0275
SPEED = 261.8
RATIO = 3.23
GAMMA = math.radians(23.4)


@pytest.fixture(scope="module")
def figures():
    return {number: redrawn(number) for number in NUMBERS}


def test_data_are_finite_and_points_stand_on_the_grid(figures):
    for figure in figures.values():
        assert figure.panels or figure.table
        for panel in figure.panels:
            assert panel.curves
            for curve in panel.curves:
                assert np.all(np.isfinite(curve.theory))
                assert np.all(np.diff(curve.x) > 0.0)
                assert len(curve.x) == len(curve.theory) >= 50
                for at, y in curve.points.values():
                    assert np.isin(at, curve.x).all()
                    assert np.all(np.isfinite(y))


def test_points_lie_on_their_curves(figures):
    """Simulated impacts by both laws, on every curve but that of the hub in 2.30, and the printed equations."""
    for number, figure in figures.items():
        found = largest_differences(figure)
        limits = {law: source.tolerance for law, source in SOURCES.items()}
        assert all(limits[law] is None or found[law] <= limits[law] for law in found), number
        if number in {*impact_figures.FIGURES, "2.26", "2.28", "2.29", "2.30"}:
            assert set(found) == {"energetic", "compliant"}
            curves = [
                curve for curve in figure.panels[0].curves if curve.name != "bristle on its hub"
            ]
            assert all(len(curve.points[law][0]) >= 4 for curve in curves for law in found)
        else:
            assert set(found) <= {"printed", "motion", "table", "contact", "sampled"}, number


@pytest.mark.parametrize(
    ("number", "x", "y"),
    [
        ("2.8", LENGTH, 1.231668e-3),
        ("2.10", 0.31, -7.344917e-3),
        ("2.21", RATIO, -1.260658e-2),
        ("2.24", GAMMA, -0.539903),
        ("2.30", 0.31, 2.4923689e-3),
        ("4.17", 1.2e8, 1.3940e-4),
    ],
)
def test_the_operating_point_is_marked(figures, number, x, y):
    (mark,) = figures[number].panels[0].marks
    assert (mark.label, mark.x) == ("", pytest.approx(x, rel=1e-12))
    # Seven digits of the closed forms, worked out apart from this program; five of the crater's.
    assert mark.y == pytest.approx(y, rel=1e-6 if number < "4" else 5e-5)


def test_force_figures(figures):
    ball = figures["3.2"].panels[0]
    bend, peak = ball.marks
    assert (peak.x, peak.y) == (
        pytest.approx(2.328e-3, abs=1.2e-6),
        pytest.approx(340.75, abs=0.01),
    )
    # The steepest rise of the points of the curve themselves.
    curve = ball.curves[0]
    steepest = curve.x[np.argmax(np.gradient(curve.theory, curve.x)[1:-1]) + 1]
    assert bend.x == pytest.approx(steepest, abs=3e-5)
    (fit,) = figures["3.1"].panels[0].curves
    # The fit to 61 points with 5 N each lies within a few tenths of that of the curve they are drawn from.
    printed = (
        1.3935
        * np.exp(-101.6189 * fit.x)
        * (145.0 - 167.5 * np.cos(2.0 * np.pi * (fit.x + 0.0005) / 0.006))
    )
    assert np.max(np.abs(fit.theory - printed)) < 3.0
    bristle = figures["3.3"].panels[0]
    assert bristle.marks[0].y == pytest.approx(57.0, abs=0.5)
    assert {*bristle.curves[0].points} == {"table", "contact"}


def test_the_table(figures):
    head, *rows, last = figures["table_3.1"].table
    assert [row[2] for row in rows] == [
        "0.13",
        "0.43",
        "0.79",
        "1.18",
        "1.56",
        "1.93",
        "2.24",
        "2.49",
        "2.67",
        "2.76",
    ]
    assert all(len(row) == len(head) for row in (*rows, last))
    for row in rows:
        assert float(row[3]) == pytest.approx(float(row[2]), abs=0.006)
    assert last[:3] == ("sum", "", "16.18")
    assert float(last[4]) == pytest.approx(16.1157, abs=0.003)
    assert float(last[5]) == pytest.approx(16.1157, abs=0.003)


def test_a_point_off_its_curve_is_seen():
    x = np.linspace(0.0, 1.0, 5)
    curve = curve_of("line", lambda grid: 2.0 * grid, x, {"printed": ([0.3, 0.5], [0.6, 1.01])})
    assert 0.3 in curve.x
    panel = Panel(Axis("x"), Axis("y"), (curve,))
    # 0.01 off where the larger of the two curve values is 1.
    assert largest_differences(Redrawn("0", "a line", (panel,))) == {"printed": pytest.approx(0.01)}
    judged = [
        Quantity(name, "1", off, 0.0, tolerance=0.001)
        for name, off in (("line", 0.01), ("arc", 0.0))
    ]
    assert _answer(judged) == "No: points are off their curves in 1 of 2 sets: line."
