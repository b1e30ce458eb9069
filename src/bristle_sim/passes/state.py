"""Passes in dimensionless numbers: lengths are over the bristle's length, the hub angle is the
time, and moments are over the bristle's moment of inertia.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

Chosen = NDArray[Any]
"""Indices of passes, a Boolean mask of passes, or an integer code for each pass."""

FLIES, BAR, WORKPART, FOLDS, MISSED, LOCKED, TOO_MANY = range(7)
"""Codes of a pass's state: in flight; touching the bar; ended by a touch of the workpart, by a wire
folded by more than a quarter turn, by the end of the hub's turn, by friction on the bar, or by
endless touches of the bar. ``BAR`` and ``WORKPART`` are also the codes of these obstacles."""

QUARTER_TURN = 0.5 * np.pi  # relative angle beyond which a wire has folded, rad
LEAST = 1e-300  # lower bound of a dimensionless speed or impulse, against a division by zero


class Passes:
    """State and constants of passes under way.

    Every attribute is a row of one table, with one column for each pass. New values are therefore
    assigned into a row: ``passes.rate[:] = ...``.

    Attributes:
        table: all rows, shape (rows, passes).
        number: index of each pass in the request.
        code: code of the pass's state.
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
        touching: 1 where the wire has just left the bar, so that the gap begins at zero, otherwise
            0.
        touches: number of touches of the bar so far.
        release, release_angle: hub angle and relative angle at the last contact with the bar, rad;
            NaN before the first contact.
        lowest: least relative angle so far, rad.
        error: estimated error of the relative angle (rad) and of the rate over ``rate_scale``.
    """

    number: Array
    code: Array
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
    touching: Array
    touches: Array
    release: Array
    release_angle: Array
    lowest: Array
    error: Array

    def __init__(self, table: Array) -> None:
        self.table = table
        self.__dict__.update(zip(ROWS, table, strict=True))

    @property
    def size(self) -> int:
        """Number of passes."""
        return len(self.number)

    def take(self, chosen: Chosen) -> Passes:
        """Return the passes with the given indices, which increase; all passes are not copied."""
        return self if len(chosen) == self.size else Passes(self.table.take(chosen, axis=1))

    def put(self, chosen: Chosen, some: Passes) -> None:
        """Copy ``some`` passes to the given indices of these passes."""
        self.table[:, chosen] = some.table


ROWS = tuple(Passes.__annotations__)


def joined(*groups: Passes) -> Passes:
    """Return the passes of several groups in one group."""
    filled = [each for each in groups if each.size] or groups
    if len(filled) == 1:
        return filled[0]
    return Passes(np.concatenate([each.table for each in filled], axis=1))
