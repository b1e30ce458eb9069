"""Trajectories as tables of pandas and xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bristle_sim.arrays import Array

if TYPE_CHECKING:
    import pandas as pd
    import xarray

    from bristle_sim.trajectory.trajectory import Trajectory

MISSING = "must be installed: pip install bristle-sim[sweep]"

UNITS = {
    **dict.fromkeys(("hub_angle", "angle", "relative_angle"), "rad"),
    **dict.fromkeys(("rate", "relative_rate"), "rad/s"),
    **dict.fromkeys(("kinetic_energy", "potential_energy"), "J"),
    "centre_line": "m",
    "centre_line_velocity": "m/s",
    "normal_force": "N",
}
DIMENSIONS = {
    **dict.fromkeys(("angle", "rate"), ("time", "link")),
    **dict.fromkeys(("centre_line", "centre_line_velocity"), ("time", "corner", "axis")),
}
"""Dimensions of what has more than that of time."""


def to_dataframe(run: Trajectory) -> pd.DataFrame:
    """Return all sampled quantities as a pandas DataFrame, one row a sample; ``attrs["units"]`` has their units.

    Raises ImportError if pandas is not installed.
    """
    try:
        import pandas as pd
    except ImportError as error:
        raise ImportError(f"pandas: {MISSING}") from error
    frame = pd.DataFrame(run.columns())
    units = dict(title.removesuffix(")").split(" (") for title in frame)
    frame.columns, frame.attrs["units"] = pd.Index(units), units
    return frame


def to_xarray(run: Trajectory) -> xarray.Dataset:
    """Return all sampled quantities as an xarray Dataset with units as attributes.

    Its coordinate ``time`` strictly ascends, so that ``interp(time=...)`` works, which is linear between samples where
    ``at`` is of higher order: of samples that share an instant the later ones follow by the smallest step of a double.
    ``instant`` is the time as recorded.

    Raises ImportError if xarray is not installed.
    """
    try:
        import xarray
    except ImportError as error:
        raise ImportError(f"xarray: {MISSING}") from error
    recorded = {"angle": "angles", "rate": "rates"}
    variables = {
        name: (DIMENSIONS.get(name, ("time",)), getattr(run, recorded.get(name, name)), {"units": unit})
        for name, unit in UNITS.items()
    }
    events = ("event", np.array([event.time for event in run.events]), {"units": "s"})
    return xarray.Dataset(
        {**variables, "event_time": events},
        coords={
            "time": ("time", ascending(run.time), {"units": "s"}),
            "instant": ("time", run.time, {"units": "s"}),
            "link": np.arange(1, run.angles.shape[1] + 1),
            "axis": ["x", "y"],
            "event": [event.name for event in run.events],
        },
        attrs={"stop_reason": str(run.stop_reason), "hub_speed": run.hub_speed},
    )


def ascending(time: Array) -> Array:
    """Return times that strictly ascend: one that does not exceed its predecessor becomes the next double after it."""
    found = time.copy()
    for later in range(1, len(found)):
        if found[later] <= found[later - 1]:
            found[later] = np.nextafter(found[later - 1], np.inf)
    return found
