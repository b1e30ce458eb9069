"""A run as a short text, and as tables of pandas and xarray."""

from __future__ import annotations

import math
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle_sim.trajectory.recorded_run import RecordedRun
from bristle_sim.trajectory.records import SAMPLED

if TYPE_CHECKING:
    import pandas as pd
    import xarray

EVENTS_SHOWN = 6  # largest number of events in a summary

DIMENSIONS = {"n": "time", "l": "link", "c": "corner", "2": "axis"}
SINGULAR = {"angles": "angle", "rates": "rate"}
"""Variables of a dataset whose names differ from those of the run's arrays; ``DIMENSIONS`` holds
the names of its dimensions."""


def summary(run: RecordedRun) -> str:
    """Return a text with one line each for samples, strike, events, stop reason and cost of a run.

    If the accuracy was not reached, a further line states it.
    """
    first, last = (1e3 * float(instant) for instant in (run.time[0], run.time[-1]))
    contact = run.first_contact("workpart")
    strike = "none"
    if contact is not None:
        before, after = (
            math.hypot(*velocity) for velocity in (contact.velocity_before, contact.velocity_after)
        )
        speeds = f"{contact.point or 'tip'} speed {before:.4g} m/s before and {after:.4g} m/s after"
        strike = f"{contact.outcome} at {1e3 * contact.time:.4g} ms, {speeds}"
    lines = [
        f"Trajectory: {run.time.size} samples from {first:.4g} to {last:.4g} ms",
        f"strike: {strike}",
        *course_in_words(run),
        run.accuracy_not_reached,
    ]
    return "\n".join(filter(None, lines))


def course_in_words(run: RecordedRun) -> list[str]:
    """Return one line each for events, stop reason and cost of a run."""
    notable = run.notable_events
    events = ", ".join(
        f"{event.name} {1e3 * event.time:.4g} ms" for event in notable[:EVENTS_SHOWN]
    )
    more = f" and {len(notable) - EVENTS_SHOWN} more" if len(notable) > EVENTS_SHOWN else ""
    cost = run.cost
    error = "" if cost.error_estimate is None else f", error estimate {cost.error_estimate:.1e}"
    if cost.holds_until is not None:
        error += f" up to {1e3 * cost.holds_until:.4g} ms; later touches depend on the error itself"
    return [
        f"events: {events or 'none'}{more}",
        f"stopped: {run.stop_reason}",
        f"cost: {cost.steps} steps, {1e3 * cost.wall_s:.3g} ms{error}",
    ]


def to_dataframe(run: RecordedRun) -> pd.DataFrame:
    """Return all sampled quantities as a pandas DataFrame, with one row for each sample.

    Its ``attrs["units"]`` holds the units by column.

    Raises:
        ImportError: if pandas is not installed.
    """
    library = installed("pandas")
    frame: pd.DataFrame = library.DataFrame(run.columns())
    units = dict(title.removesuffix(")").split(" (") for title in frame)
    frame.columns = library.Index(units)
    frame.attrs["units"] = units
    return frame


def to_xarray(run: RecordedRun) -> xarray.Dataset:
    """Return all sampled quantities as an xarray Dataset with units as attributes.

    The coordinate ``time`` increases strictly, so that ``interp(time=...)`` works. It interpolates
    linearly; ``Trajectory.at`` has a higher order. Where samples have the same instant, the later
    samples are shifted by the smallest step of a double. The coordinate ``instant`` is the recorded
    time.

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
    """Return an optional library, imported.

    Raises:
        ImportError: if it is not installed; the message names the extra that installs it.
    """
    try:
        return import_module(library)
    except ImportError as error:
        raise ImportError(
            f"{library}: must be installed: pip install bristle-sim[sweep]"
        ) from error
