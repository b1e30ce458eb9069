"""Passes in dimensionless numbers: lengths are over the bristle's length, the hub angle is the
time, and moments are over the bristle's moment of inertia.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

Chosen = NDArray[Any]
"""Indices of passes, a Boolean mask of passes, or an integer code for each pass."""


class Place(NamedTuple):
    """Geometry that decides the gaps of wires to bar and workpart; the attributes are those of
    ``Passes``.
    """

    radius: Array
    bar_x: Array
    bar_y: Array
    reach: Array
    depth: Array


@dataclass(slots=True, eq=False)
class Passes:
    """State and constants of passes under way; every attribute is an array of shape (passes,).

    Attributes:
        number: index of each pass in the request.
        radius: radius of the hub, r_h/L.
        stiffness, damping, centrifugal, gravity: coefficients k, d, b and g of the equation of
            motion in the module ``motion``.
        rate_scale: scale of the rates, 1 + sqrt(k).
        bar_distance: distance of the bar's centre from the hub's axis, S/L.
        bar_angle: hub angle at which the root is nearest to the bar's centre, rad.
        bar_x, bar_y: position of the bar's centre, over L.
        reach: distance of the wire's centre line from the bar's centre at a touch, (r_b + d/2)/L.
        wire_radius: radius of the wire, d/(2 L).
        bar_friction, bar_restitution: coefficients of friction and of restitution at the bar.
        window: half the turn of the hub in which the wire reaches the bar, rad; negative if the
            wire never reaches it.
        depth: distance of the workpart's surface from the hub's axis, over L; infinite without a
            workpart.
        start, end: hub angles at which the pass starts and ends, rad.
        hub_angle, angle, rate: present hub angle psi, relative angle alpha and rate
            d(alpha)/d(psi).
        touching: whether the wire has just left the bar, so that the gap begins at zero.
        touches: number of touches of the bar so far.
        release, release_angle: hub angle and relative angle at the last contact with the bar, rad;
            NaN before the first contact.
        lowest: least relative angle so far, rad.
        error: estimated error of the relative angle, rad, and of the rate over ``rate_scale``.
    """

    number: Chosen
    radius: Array
    stiffness: Array
    damping: Array
    centrifugal: Array
    gravity: Array
    rate_scale: Array
    bar_distance: Array
    bar_angle: Array
    bar_x: Array
    bar_y: Array
    reach: Array
    wire_radius: Array
    bar_friction: Array
    bar_restitution: Array
    window: Array
    depth: Array
    start: Array
    end: Array
    hub_angle: Array
    angle: Array
    rate: Array
    touching: Chosen
    touches: Chosen
    release: Array
    release_angle: Array
    lowest: Array
    error: Array

    @property
    def size(self) -> int:
        """Number of passes."""
        return len(self.number)

    @property
    def heavy(self) -> bool:
        """Whether any bristle has weight."""
        return bool(self.gravity.any())

    def take(self, chosen: Chosen) -> Passes:
        """Return the chosen passes."""
        return Passes(*(each[chosen] for each in self._columns()))

    def place(self, chosen: Chosen) -> Place:
        """Return the geometry that decides the gaps of the chosen passes."""
        return Place(*(getattr(self, name)[chosen] for name in Place._fields))

    def put(self, chosen: Chosen, some: Passes) -> None:
        """Copy the state of ``some`` passes to the chosen passes of this object."""
        for name in STATE:
            getattr(self, name)[chosen] = getattr(some, name)

    def joined(self, *others: Passes) -> Passes:
        """Return these passes followed by other passes."""
        columns = zip(self._columns(), *(each._columns() for each in others), strict=True)
        return Passes(*map(np.concatenate, columns))

    def _columns(self) -> list[NDArray[Any]]:
        return [getattr(self, name) for name in COLUMNS]


COLUMNS = tuple(each.name for each in dataclasses.fields(Passes))
STATE = COLUMNS[COLUMNS.index("hub_angle") :]
"""Names of all columns of passes, and of the columns that change during a pass."""
