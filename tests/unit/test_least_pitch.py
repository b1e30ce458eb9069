"""Pitch from which two wires touch: closed form, brute force on another interpolation, and what is known of the tool."""

import functools
import math

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from bristle_sim.parameters import Belt, Tool, Workpart
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.least_pitch import least_pitch, polyline_distance

RADIUS, LENGTH, DIAMETER = 0.0275, 0.027, 7.1e-4


@functools.cache
def lone_pass(damping=0.0):
    tool = Tool(belt=Belt(damping_ratio=damping))
    return simulate(tool, Settings(accuracy=1e-8, samples_per_period=150))


def strike(run):
    return run.first_contact("workpart").time


def test_wires_that_turn_with_the_hub_touch_at_their_roots():
    """2 r_h sin(beta/2) = d."""
    free = Tool(bar=None, workpart=Workpart(penetration=-0.01))
    run = simulate(free, Settings(hub_turn=1.0))
    found = least_pitch(run, DIAMETER, largest=math.radians(5.0))
    assert found == pytest.approx(2.0 * math.asin(DIAMETER / (2.0 * RADIUS)), rel=1e-6)  # tolerance of the root search


def by_brute_force(run, pitch, until):
    """Least distance of points on both wires at instants, closed in on by finer and finer grids of all three.

    The wires' positions follow from angles and rates, and not from the recorded centre lines.
    """
    cuts = np.flatnonzero(np.diff(run.time) <= 0.0) + 1
    parts = [part for part in np.split(np.arange(run.time.size), cuts) if part.size > 1]
    splines = [CubicHermiteSpline(run.time[part], run.angles[part, 0], run.rates[part, 0]) for part in parts]
    starts = np.array([spline.x[0] for spline in splines])

    def points(time, along):
        hub_angle = run.hub_angle[0] + run.hub_speed * time
        number = np.searchsorted(starts, np.maximum(time, 0.0), side="right") - 1
        angle = np.select([number == each for each in range(len(splines))], [spline(time) for spline in splines])
        angle = np.where(time < 0.0, hub_angle, angle)
        shape = (len(time), 1)
        x = RADIUS * np.sin(hub_angle).reshape(shape) + LENGTH * along * np.sin(angle).reshape(shape)
        y = -RADIUS * np.cos(hub_angle).reshape(shape) - LENGTH * along * np.cos(angle).reshape(shape)
        return np.stack([x, y], axis=-1)

    low, high = np.array([0.0, 0.0, 0.0]), np.array([until, 1.0, 1.0])
    grids = (1200, 28, 28)
    least = math.inf
    for _ in range(9):
        time, first, second = (np.linspace(*each) for each in zip(low, high, grids, strict=True))
        ahead, behind = points(time, first), points(time - pitch / run.hub_speed, second)
        distance = np.linalg.norm(ahead[:, :, np.newaxis] - behind[:, np.newaxis], axis=-1)
        at = np.unravel_index(distance.argmin(), distance.shape)
        least = min(least, float(distance[at]))
        middle = np.array([time[at[0]], first[at[1]], second[at[2]]])
        size = 3.0 * (high - low) / (np.array(grids) - 1)
        low, high = np.maximum(middle - size, 0.0), np.minimum(middle + size, [until, 1.0, 1.0])
        grids = (40, 28, 28)
    return least


@pytest.mark.parametrize("whole", [False, True])
def test_the_least_pitch_by_brute_force(whole):
    """Touching 1e-4 degrees below it, not touching 1e-4 degrees above it, nor at larger pitches."""
    run = lone_pass()
    until = float(run.time[-1]) if whole else strike(run)
    found = least_pitch(run, DIAMETER, until=until, largest=math.radians(48.0 if whole else 18.0))
    near = math.radians(1e-4)
    assert by_brute_force(run, found - near, until) < DIAMETER < by_brute_force(run, found + near, until)
    for larger in np.linspace(found + 0.01, 1.5, 4):
        assert by_brute_force(run, larger, until) > DIAMETER


def test_distances_of_bent_lines_against_points_on_them():
    chance = np.random.default_rng(5)
    lines = chance.normal(size=(2, 25, 3, 2))
    fraction = np.linspace(0.0, 1.0, 200)[:, np.newaxis]
    dense = [
        np.concatenate([line[:, i, np.newaxis] * (1.0 - fraction) + line[:, i + 1, np.newaxis] * fraction for i in (0, 1)], axis=1)
        for line in lines
    ]  # fmt: skip
    expected = np.linalg.norm(dense[0][:, :, np.newaxis] - dense[1][:, np.newaxis], axis=-1).min(axis=(1, 2))
    found = polyline_distance(*lines)
    # Points are at most half of 1/199 of a piece, some 5 long, away from the nearest ones.
    assert found == pytest.approx(expected, abs=0.03)
    assert (found <= expected + 1e-12).all()
    assert (found == 0.0).sum() > 2
