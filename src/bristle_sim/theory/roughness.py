"""Roughness of profiles and surfaces: the Gaussian filter of ISO 16610-21, measures of ISO 21920-2
and ISO 25178-2.

A profile is the last axis of an array of heights at equal distances; measures are means over all
profiles. Heights and lengths in m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

SECTIONS = 5  # section lengths of an evaluation length (ISO 21920-3)
LEAST_HEIGHT = 0.1  # of Rz: an element of a profile has a hill and a dale beyond it (ISO 21920-2)
GAUSSIAN = math.sqrt(math.log(2.0) / math.pi)
"""alpha of ISO 16610-21, 0.4697: the filter halves a wave as long as the cut-off."""


@dataclass(frozen=True, slots=True)
class ProfileMeasures:
    """Means over all profiles, m. ``sections`` is the number of section lengths of each.

    ``rsm`` is None where no profile has an element.
    """

    rz: float
    ra: float
    rq: float
    rsm: float | None
    sections: int


def roughness_profiles(heights: Array, cell: float, cutoff: float) -> Array:
    """Return the heights less their Gaussian mean line along the last axis, m; the profiles are
    periodic.

    The filter multiplies a wave of length lambda by 1 - exp(-pi (alpha cutoff/lambda)^2) (ISO
    16610-21), in the frequency domain, so that a periodic profile has no end effects. A wave as
    long as the cut-off keeps half its height:

    >>> wave = np.sin(2.0 * np.pi * np.arange(400) / 100.0)
    >>> print(f"{roughness_profiles(wave, 1e-5, 1e-3).max():.6f}")
    0.500000
    """
    points = heights.shape[-1]
    lengths = cutoff * np.fft.rfftfreq(points, cell)
    mean_line = np.fft.rfft(heights, axis=-1) * np.exp(-math.pi * (GAUSSIAN * lengths) ** 2)
    return np.asarray(heights - np.fft.irfft(mean_line, points, axis=-1))


def section_heights(profiles: Array, cell: float, section: float, sections: int) -> Array:
    """Return the highest peak less the lowest valley of each section length, m, shape (...,
    sections).
    """
    edges = _edges(cell, section, sections)
    evaluated = profiles[..., : edges[-1]]
    highest = np.maximum.reduceat(evaluated, edges[:-1], axis=-1)
    return np.asarray(highest - np.minimum.reduceat(evaluated, edges[:-1], axis=-1))


def _edges(cell: float, section: float, sections: int) -> NDArray[np.int_]:
    edges: NDArray[np.int_] = np.rint(np.arange(sections + 1) * section / cell).astype(int)
    return edges


def profile_measures(
    profiles: Array, cell: float, section: float, sections: int
) -> ProfileMeasures:
    """Return the measures of roughness profiles, filtered before, over their first section lengths.

    Rz is the mean over section lengths of the highest peak less the lowest valley; Ra, Rq and RSm
    are over the evaluation length (ISO 21920-2).

    Args:
        profiles: roughness profiles, m, shape (..., points).
        cell: distance of two points, m.
        section: section length, m.
        sections: number of section lengths; the profiles must be that long.
    """
    rz = section_heights(profiles, cell, section, sections).mean(axis=-1)
    evaluated = profiles[..., : _edges(cell, section, sections)[-1]]
    evaluated = evaluated - evaluated.mean(axis=-1, keepdims=True)
    lines = np.reshape(evaluated, (-1, evaluated.shape[-1]))
    spacings = [_mean_spacing(*each) for each in zip(lines, LEAST_HEIGHT * rz.ravel(), strict=True)]
    known = [cell * each for each in spacings if each is not None]
    return ProfileMeasures(
        rz=float(rz.mean()),
        ra=float(np.abs(evaluated).mean()),
        rq=float(np.sqrt((evaluated**2).mean(axis=-1)).mean()),
        rsm=float(np.mean(known)) if known else None,
        sections=sections,
    )


def _mean_spacing(profile: Array, least: float) -> float | None:
    """Return the mean length of a profile's elements in points; None without a whole element.

    An element reaches from one rise through the mean line to the next, with a hill above and a dale
    below it by at least ``least`` (ISO 21920-2: RSm). The crossings are interpolated linearly.
    """
    beyond = np.flatnonzero(np.abs(profile) > least)
    rises = np.flatnonzero((profile[beyond[:-1]] < 0.0) & (profile[beyond[1:]] > 0.0))
    if rises.size < 2:
        return None

    def crossing(rise: int) -> float:
        first = beyond[rise] + np.flatnonzero(profile[beyond[rise] : beyond[rise + 1]] < 0.0)[-1]
        return float(first + profile[first] / (profile[first] - profile[first + 1]))

    return (crossing(rises[-1]) - crossing(rises[0])) / (rises.size - 1)


def arithmetic_mean_height(heights: Array) -> float:
    """Return Sa, the mean distance of a surface from its mean height (ISO 25178-2), m.

    >>> print(arithmetic_mean_height(np.array([[1.0, -1.0], [3.0, 1.0]])))
    1.0
    """
    return float(np.abs(heights - heights.mean()).mean())


def developed_area_ratio(heights: Array, step: float, cell: float) -> float:
    """Return Sdr, by how much a surface's area exceeds its projection, as a fraction of the latter
    (ISO 25178-2).

    Points are a ``step`` apart along the last axis and a ``cell`` along the first, m. Each cell is
    divided into two triangles along either diagonal, and the two areas are averaged (annex D). A
    plane that rises at 45 deg has sqrt(2) - 1:

    >>> print(f"{developed_area_ratio(np.add.outer(np.arange(5.0), np.zeros(4)), 1.0, 1.0):.6f}")
    0.414214
    """
    across = np.diff(heights, axis=0) / cell
    along = np.diff(heights, axis=1) / step
    corners = (
        np.sqrt(1.0 + along[one] ** 2 + across[:, other] ** 2).mean()
        for one in (np.s_[:-1], np.s_[1:])
        for other in (np.s_[:-1], np.s_[1:])
    )
    return float(sum(corners) / 4.0 - 1.0)
