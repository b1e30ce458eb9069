"""Passes in dimensionless numbers.

Lengths are divided by the bristle's length L. The hub angle serves as the time, so angular
velocities are divided by the hub's angular velocity omega. Moments of inertia are divided by the
bristle's moment of inertia I about its root, and torques by I omega^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array

Chosen = NDArray[Any]
"""Indices of passes, a Boolean mask of passes, or an integer code for each pass."""

FLIES, BAR, LIES, WORKPART, FOLDS, MISSED, LOCKED, TOO_MANY = range(8)
"""Codes of a pass's state.

In the first three states the wire is in flight, touches the bar, or lies on it. In the others the
pass has ended: the tip touches the workpart, the wire has folded by more than 90 degrees, the hub
has rotated to the end of the pass, friction locks the wire on the bar, or the touches of the bar are
endless. ``BAR`` and ``WORKPART`` are also the codes of these obstacles."""

QUARTER_TURN = 0.5 * np.pi  # angle from the radial direction beyond which a wire has folded, rad
LEAST = 1e-300  # lower bound of a dimensionless speed or impulse, against a division by zero


class Passes:
    """Constants and present state of passes that are being computed.

    Every attribute is a row of one table, with one column for each pass. New values are therefore
    assigned into a row: ``passes.rate[:] = ...``. L is the bristle's length.

    Attributes:
        table: all rows, shape (rows, passes).
        number: index of each pass in the request.
        code: code of the pass's state.
        radius: radius of the hub, r_h/L.
        stiffness, damping, centrifugal, gravity: coefficients k, d, b and g of the equation of
            motion in the module ``motion``.
        rate_scale: scale of the angular velocities, 1 + sqrt(k).
        bar_distance: distance of the bar's centre from the hub's axis, S/L.
        bar_angle: hub angle at which the root is nearest to the bar's centre, rad.
        reach: distance of the wire's centre line from the bar's centre in contact, (r_b + d/2)/L,
            with the bar's radius r_b and the wire's diameter d.
        wire_radius: radius of the wire, d/(2 L).
        bar_friction, bar_restitution: coefficients of friction and of restitution at the bar.
        flank: largest hub angle from ``bar_angle`` at which the bar can touch the wire's flank, rad;
            at larger angles it can touch only the wire's end.
        window: largest hub angle from ``bar_angle`` at which the wire can reach the bar, rad;
            negative if the wire never reaches it.
        depth: distance of the workpart's surface from the hub's axis, divided by L; infinite
            without a workpart.
        start, end: hub angles at which the pass starts and ends, rad.
        hub_angle, angle, rate: present hub angle psi (rad), angle alpha of the wire from the radial
            direction (rad), and its derivative d(alpha)/d(psi).
        touches: number of touches of the bar so far.
        side: 1 for a wire behind the bar, which holds the wire back; -1 for a wire ahead of the
            bar.
        release, release_angle: hub angle psi and wire angle alpha at the last contact with the bar,
            rad; NaN before the first contact.
        hop: estimated rotation of the hub from the last rebound to the next touch of the bar, rad.
            The estimate neglects the change of the gap's second derivative. It is infinite if the
            wire would not touch the bar again.
        lowest: smallest angle alpha so far, rad.
        error: estimated error of the angle alpha (rad), and also of its derivative ``rate`` divided
            by ``rate_scale``.
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
    reach: Array
    wire_radius: Array
    bar_friction: Array
    bar_restitution: Array
    flank: Array
    window: Array
    depth: Array
    start: Array
    end: Array
    hub_angle: Array
    angle: Array
    rate: Array
    touches: Array
    side: Array
    release: Array
    release_angle: Array
    hop: Array
    lowest: Array
    error: Array

    def __init__(self, table: Array) -> None:
        self.table = table
        self.__dict__.update(zip(ROWS, table, strict=True))

    @property
    def size(self) -> int:
        """Number of passes."""
        return len(self.number)

    @property
    def parting(self) -> Chosen:
        """Whether each wire leaves the bar at the present hub angle, so that the gap is zero."""
        return np.equal(self.hub_angle, self.release)

    def take(self, chosen: Chosen) -> Passes:
        """Return the passes with the given indices, which must be ascending.

        If all passes are chosen, the object itself is returned, not a copy.
        """
        return self if len(chosen) == self.size else Passes(self.table.take(chosen, axis=1))


ROWS = tuple(Passes.__annotations__)


def joined(groups: Sequence[Passes]) -> Passes:
    """Return the passes of several groups in one group."""
    filled = [each for each in groups if each.size]
    if len(filled) == 1:
        return filled[0]
    return Passes(np.concatenate([each.table for each in filled], axis=1))
