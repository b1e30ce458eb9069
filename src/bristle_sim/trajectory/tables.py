"""A run as tables of pandas and xarray."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle_sim.trajectory.records import SAMPLED

if TYPE_CHECKING:
    import pandas as pd
    import xarray

DIMENSIONS = {"n": "time", "l": "link", "c": "corner", "2": "axis"}
SINGULAR = {"angles": "angle", "rates": "rate"}
"""Names of the variables of a dataset that differ from the names of the run's arrays, which are the
keys. ``DIMENSIONS`` holds the names of a dataset's dimensions by the letters of ``SAMPLED``."""


def to_dataframe(run: Any) -> pd.DataFrame:
    """Return all sampled quantities of a trajectory as a pandas DataFrame, one row for each sample.

    The frame's ``attrs["units"]`` holds the units by column.

    Raises:
        ImportError: if pandas is not installed.
    """
    library = installed("pandas")
    frame: pd.DataFrame = library.DataFrame(run.columns())
    units = dict(title.removesuffix(")").split(" (") for title in frame)
    frame.columns = library.Index(units)
    frame.attrs["units"] = units
    return frame


def to_xarray(run: Any) -> xarray.Dataset:
    """Return all sampled quantities of a trajectory as an xarray Dataset, with units.

    The coordinate ``instant`` is the recorded time of each sample, s. The coordinate ``time`` is
    the same, except that equal times are made distinct: the later of two equal times is increased
    to the next floating-point number. ``time`` therefore increases strictly, as
    ``interp(time=...)`` requires. ``interp`` is linear; ``Trajectory.at`` interpolates to a higher
    order.

    Raises:
        ImportError: if xarray is not installed.
    """
    ascending = run.time.copy()
    for later in range(1, len(ascending)):
        ascending[later] = max(ascending[later], np.nextafter(ascending[later - 1], np.inf))
    sampled = SAMPLED | {"relative_angle": ("n", "rad"), "relative_rate": ("n", "rad/s")}
    variables: dict[str, Any] = {
        SINGULAR.get(name, name): (
            [DIMENSIONS[each] for each in letters],
            getattr(run, name),
            {"units": unit},
        )
        for name, (letters, unit) in sampled.items()
        if name != "time"
    }
    variables["event_time"] = (
        "event",
        np.array([event.time for event in run.events]),
        {"units": "s"},
    )
    coordinates = {
        "time": ("time", ascending, {"units": "s"}),
        "instant": ("time", run.time, {"units": "s"}),
        "link": np.arange(1, run.angles.shape[1] + 1),
        "axis": ["x", "y"],
        "event": [event.name for event in run.events],
    }
    about = {"stop_reason": str(run.stop_reason), "hub_speed": run.hub_speed}
    found: xarray.Dataset = installed("xarray").Dataset(variables, coords=coordinates, attrs=about)
    return found


def installed(library: str) -> Any:
    """Import an optional library and return it.

    Raises:
        ImportError: if the library is not installed; the message states how to install it.
    """
    try:
        return import_module(library)
    except ImportError as error:
        raise ImportError(
            f"{library}: must be installed: pip install bristle-sim[sweep]"
        ) from error
