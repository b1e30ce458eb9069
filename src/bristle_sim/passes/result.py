"""The result of many passes: arrays by name, a table, a labelled data set or a picture."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array, EqualByValue
from bristle_sim.parameters import KEYS
from bristle_sim.trajectory.tables import installed

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

QUANTITIES = {
    "release_time": "s",
    "release_retraction": "rad",
    "largest_retraction": "rad",
    "contact_time": "s",
    "lag_at_contact": "rad",
    "relative_speed_at_contact": "rad/s",
    "tip_speed_at_contact": "m/s",
    "normal_compressive_impulse": "N s",
    "normal_final_impulse": "N s",
    "tangential_compressive_impulse": "N s",
    "normal_compressive_work": "J",
    "tangential_compressive_work": "J",
    "entry_angle_at_contact": "rad",
    "final_bristle_rate": "rad/s",
    "error_estimate": "1",
}
"""Unit of each quantity of a pass."""

DRAWN_BY = "bristle_sim.render.sweep_figures"  # in a higher layer, imported only when a picture is requested


@dataclass(frozen=True, slots=True, eq=False)
class Ensemble(EqualByValue):
    """The results of many passes, in arrays of one shape.

    A quantity that a pass does not have is NaN.

    Attributes:
        keys: values of the tool's keys that were given, in SI units. Their shapes broadcast to the
            results' shape.
        release_time: time of the last contact with the bar before the strike, from the start of the
            pass, s.
        release_retraction: retraction, the angle of the wire behind the radial direction, at the
            release time, rad.
        largest_retraction: largest retraction before the strike, rad.
        contact_time: time of the strike, from the start of the pass, s.
        lag_at_contact: angle of the wire behind the radial direction at the strike, rad.
        relative_speed_at_contact: angular velocity of the wire relative to the hub at the strike,
            rad/s.
        tip_speed_at_contact: speed of the tip at the strike, m/s.
        normal_compressive_impulse: normal impulse on the tip up to the end of compression, N s.
        normal_final_impulse: normal impulse on the tip over the whole impact, N s.
        tangential_compressive_impulse: tangential impulse on the tip up to the end of compression,
            N s.
        normal_compressive_work: work of the normal force up to the end of compression, J.
        tangential_compressive_work: work of the tangential force up to the end of compression, J.
        entry_angle_at_contact: angle between the surface and the tip's path at the strike, rad.
        final_bristle_rate: absolute angular velocity of the wire after the strike, rad/s.
        error_estimate: estimated error at the strike, dimensionless. The estimate holds for the
            wire's angle (rad), and for the relative angular velocity divided by omega +
            sqrt(k_T/I), with the hub's speed omega, the belt's stiffness k_T and the wire's moment
            of inertia I about the root. The estimate includes the factor by which the impact
            magnifies an error. It is 1 if an error as small as the accuracy could change the number
            of touches or the outcome.
        outcome: ``rebounds``, ``reverses its slip``, ``sticks and rebounds``, ``stays``, ``jams``,
            ``does not strike`` or ``refused``.
        reason: why a pass was refused, or why it has no strike, no release or no valid error
            estimate; empty otherwise.
    """

    keys: dict[str, Array]
    release_time: Array
    release_retraction: Array
    largest_retraction: Array
    contact_time: Array
    lag_at_contact: Array
    relative_speed_at_contact: Array
    tip_speed_at_contact: Array
    normal_compressive_impulse: Array
    normal_final_impulse: Array
    tangential_compressive_impulse: Array
    normal_compressive_work: Array
    tangential_compressive_work: Array
    entry_angle_at_contact: Array
    final_bristle_rate: Array
    error_estimate: Array
    outcome: NDArray[Any]
    reason: NDArray[Any]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape to which the values of the keys broadcast."""
        return self.outcome.shape

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of keys and results by name, all broadcast to the ensemble's shape."""
        keys = {key: np.broadcast_to(each, self.shape) for key, each in self.keys.items()}
        return keys | {name: getattr(self, name) for name in (*QUANTITIES, "outcome", "reason")}

    def to_dataframe(self) -> pd.DataFrame:
        """Return a DataFrame of keys and results, with one row for each pass.

        The last axis varies fastest. ``attrs["units"]`` holds the units by name.

        Raises:
            ImportError: if pandas is not installed.
        """
        frame: pd.DataFrame = installed("pandas").DataFrame(
            {name: each.ravel() for name, each in self.columns().items()}
        )
        frame.attrs["units"] = self._units()
        return frame

    def to_xarray(self) -> xr.Dataset:
        """Return a Dataset of the results with the keys as coordinates.

        An axis along which only one key varies has the name of this key.

        Raises:
            ImportError: if xarray is not installed.
        """
        units = self._units()
        names = self._axes()
        variables = {
            name: (names, each, {"units": units[name]} if name in units else {})
            for name, each in self.columns().items()
        }
        coordinates = {
            key: (key, self.keys[key].ravel(), variables[key][2])
            if key in names
            else variables[key]
            for key in self.keys
        }
        variables = {name: each for name, each in variables.items() if name not in self.keys}
        found: xr.Dataset = installed("xarray").Dataset(variables, coords=coordinates)
        return found

    def plot(self) -> Any:
        """Return a matplotlib figure of every quantity over the one or two keys that vary.

        Raises:
            ValueError: if there are more than two axes, if not exactly one key varies along an
                axis, or if no pass has a result.
        """
        names = self._axes()
        if not 1 <= len(names) <= 2 or not set(names) <= set(self.keys):
            raise ValueError(
                f"shape = {self.shape}: must be one or two axes, along each of which one key varies"
            )
        return import_module(DRAWN_BY).ensemble_figure(self, names)

    def _units(self) -> dict[str, str]:
        return {key: KEYS[key].unit for key in self.keys} | QUANTITIES

    def _axes(self) -> list[str]:
        """Return the name of each axis.

        An axis has the name of a key if only this key varies along it, and the key varies along no
        other axis. Otherwise its name is ``axis_`` with the axis's index.
        """
        names = []
        for axis, size in enumerate(self.shape):
            after = len(self.shape) - axis
            own = [
                key
                for key, each in self.keys.items()
                if each.ndim >= after and each.shape[-after] == size > 1
            ]
            single = len(own) == 1 and self.keys[own[0]].size == size
            names.append(own[0] if single else f"axis_{axis}")
        return names
