"""Passes in numbers without dimension: lengths over the bristle's, times as hub angles, masses over the bristle's inertia."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array


class Place(NamedTuple):
    """The columns of passes that gaps depend on."""

    radius: Array
    bar_x: Array
    bar_y: Array
    reach: Array
    depth: Array


@dataclass(slots=True, eq=False)
class Passes:
    """Bristles in flight; every attribute but ``heavy`` is an array of shape (passes,).

    Attributes:
        number: place of each pass in the request.
        radius: r_h/L.
        stiffness, damping, centrifugal, gravity: k, d, b and g of the module ``motion``.
        rate_scale: scale of the rates, 1 + sqrt(k).
        bar_distance, bar_angle: of the bar's centre from the hub's, S/L, and its direction as a hub angle, rad.
        bar_x, bar_y: the bar's centre.
        reach: (r_b + d/2)/L, at which the centre line touches the bar.
        wire_radius: d/(2 L).
        bar_friction, bar_restitution: at the bar.
        window: half the hub's turn in which the wire reaches the bar, rad; negative where it never does.
        depth: of the workpart below the hub's centre, over L; infinite without a workpart.
        start, end: hub angles at which the pass starts and ends, rad.
        hub_angle, angle, rate: psi, alpha and d(alpha)/d(psi) now.
        touching: whether the wire has just left the bar, so that the gap begins at zero.
        touches: number of touches of the bar.
        release, release_angle: psi and alpha at the last contact with the bar; NaN before one.
        lowest: least alpha so far, rad.
        error: estimated error of angle and of rate over ``rate_scale``.
        heavy: whether any bristle has weight.
    """

    number: Array
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
    heavy: bool = False

    @property
    def size(self) -> int:
        """Number of passes."""
        return len(self.number)

    def take(self, chosen: Array) -> Passes:
        """Return some of the passes, by a mask or by their places here."""
        return Passes(*(each[chosen] for each in self._columns()), heavy=self.heavy)

    def place(self, chosen: Array) -> Place:
        """Return the columns that gaps depend on, of some of the passes."""
        return Place(*(getattr(self, name)[chosen] for name in Place._fields))

    def put(self, chosen: Array, some: Passes) -> None:
        """Write the state of some passes back to their places."""
        for name in STATE:
            getattr(self, name)[chosen] = getattr(some, name)

    def joined(self, others: Passes) -> Passes:
        """Return these passes followed by others."""
        pairs = zip(self._columns(), others._columns(), strict=True)
        return Passes(*map(np.concatenate, pairs), heavy=self.heavy or others.heavy)

    def _columns(self) -> list[Array]:
        return [getattr(self, name) for name in COLUMNS]


COLUMNS = tuple(each.name for each in dataclasses.fields(Passes) if each.name != "heavy")
STATE = COLUMNS[COLUMNS.index("hub_angle") :]
"""Columns of a pass, and those that change during it."""
