"""Roughness of profiles and surfaces: the Gaussian filter of ISO 16610-21, measures of ISO 21920-2
and ISO 25178-2.

Profiles lie along the last axis of an array of heights at equal distances. Measures are means over
all profiles. Heights and lengths are in m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

SECTIONS = 5  # number of section lengths in an evaluation length (ISO 21920-3)
# Least height of a hill and least depth of a dale, as a fraction of Rz (ISO 21920-2).
LEAST_HEIGHT = 0.1
GAUSSIAN = math.sqrt(math.log(2.0) / math.pi)
"""Constant alpha = 0.4697 of the Gaussian filter (ISO 16610-21). With this constant the filter
halves a wave whose length is the cut-off."""


@dataclass(frozen=True, slots=True)
class ProfileMeasures:
    """Roughness measures of ISO 21920-2, as means over all profiles, m.

    Attributes:
        rz: Rz, mean over the section lengths of the highest peak minus the lowest valley.
        ra: Ra, mean distance from the mean line.
        rq: Rq, root mean square of the distance from the mean line.
        rsm: RSm, mean length of the profile elements, each a hill with a dale; None if no profile
            contains a whole element.
        sections: number of section lengths of each profile.
    """

    rz: float
    ra: float
    rq: float
    rsm: float | None
    sections: int


def roughness_profiles(heights: Array, cell: float, cutoff: float) -> Array:
    """Return the roughness profiles: the heights minus their Gaussian mean line, m.

    The filter of ISO 16610-21 multiplies a wave of length lambda by 1 - exp(-pi (alpha
    cutoff/lambda)^2), alpha = 0.4697. The filter acts in the frequency domain, so that there are no
    end effects.

    Args:
        heights: heights of periodic profiles along the last axis, m.
        cell: distance between two points of a profile, m.
        cutoff: cut-off wavelength of the filter, m.

    A wave as long as the cut-off is halved:

    >>> wave = np.sin(2.0 * np.pi * np.arange(400) / 100.0)
    >>> print(f"{roughness_profiles(wave, 1e-5, 1e-3).max():.6f}")
    0.500000
    """
    points = heights.shape[-1]
    lengths = cutoff * np.fft.rfftfreq(points, cell)
    mean_line = np.fft.rfft(heights, axis=-1) * np.exp(-math.pi * (GAUSSIAN * lengths) ** 2)
    return np.asarray(heights - np.fft.irfft(mean_line, points, axis=-1))


def section_heights(profiles: Array, cell: float, section: float, sections: int) -> Array:
    """Return the highest peak minus the lowest valley in each section length, m.

    ``cell`` is the distance between two points of a profile and ``section`` the section length, m.
    The shape of the result is (..., sections).
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
    """Return the roughness measures Rz, Ra, Rq and RSm of filtered profiles (ISO 21920-2).

    Rz is the mean over the section lengths of the highest peak minus the lowest valley. Ra, Rq and
    RSm are computed on the evaluation length, which consists of all section lengths.

    Args:
        profiles: roughness profiles (m), shape (..., points), as from ``roughness_profiles``.
        cell: distance between two points, m.
        section: section length, m.
        sections: number of section lengths, from the start of a profile. The profiles must be at
            least as long as the sections together.
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
    """Return the mean length of a profile's elements as a multiple of the distance between points.

    The result is None if the profile contains no whole element.

    An element extends from one rise through the mean line to the next. The element consists of a
    hill and a dale, whose extremes are at least ``least`` (m) from the mean line (RSm of ISO
    21920-2). The crossings of the mean line are interpolated linearly.
    """
    beyond = np.flatnonzero(np.abs(profile) > least)
    rises = np.flatnonzero((profile[beyond[:-1]] < 0.0) & (profile[beyond[1:]] > 0.0))
    if rises.size < 2:
        return None

    def crossing(rise: int) -> float:
        """Return the place of a rise through the mean line, in multiples of the point distance."""
        first = beyond[rise] + np.flatnonzero(profile[beyond[rise] : beyond[rise + 1]] < 0.0)[-1]
        return float(first + profile[first] / (profile[first] - profile[first + 1]))

    return (crossing(rises[-1]) - crossing(rises[0])) / (rises.size - 1)


def arithmetic_mean_height(heights: Array) -> float:
    """Return the mean distance of a surface from its mean height, Sa of ISO 25178-2, m.

    The deviations of this surface from its mean height 1 are 0, -2, 2 and 0:

    >>> print(arithmetic_mean_height(np.array([[1.0, -1.0], [3.0, 1.0]])))
    1.0
    """
    return float(np.abs(heights - heights.mean()).mean())


def developed_area_ratio(heights: Array, step: float, cell: float) -> float:
    """Return Sdr of ISO 25178-2, the relative excess of a surface's area over its projection.

    Each rectangle of four points is divided into two triangles, once along either diagonal, and the
    two areas are averaged (annex D).

    Args:
        heights: heights of the surface on a grid, m.
        step: distance between points along the last axis, m.
        cell: distance between points along the first axis, m.

    For a plane that rises at 45 deg, Sdr is sqrt(2) - 1:

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
