"""Trajectories in files, one npz archive of arrays with everything else as JSON, and as tables of pandas and xarray."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.files import complete_or_absent
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory.records import ContactAtEnd, ContactHistory, ContactRecord, Cost, Event, InnerSamples

if TYPE_CHECKING:
    import pandas as pd
    import xarray

    from bristle_sim.trajectory.trajectory import Trajectory

FORMAT = 2  # number of the file format. Format 1 wrote the reason to stop as free text and had no centre lines.

INNER, HISTORY = (tuple(each.name for each in dataclasses.fields(kind)) for kind in (InnerSamples, ContactHistory))
ARRAYS = ("time", "hub_angle", *INNER[1:], "kinetic_energy", "potential_energy", "normal_force")
"""Names of the arrays of inner samples and of histories, which a file may leave out, and of those that it has."""


def write(run: Trajectory, path: str | Path) -> None:
    """Write everything to one npz file of exactly that name, with no suffix added; it appears only when complete.

    Raises OSError naming the file, if it cannot be written.
    """
    import json

    arrays: dict[str, Any] = {name: getattr(run, name) for name in ARRAYS}
    if run.inner_samples is not None:
        arrays |= {f"inner_{name}": getattr(run.inner_samples, name) for name in INNER}
    contacts = []
    for number, contact in enumerate(run.contacts):
        row = dataclasses.asdict(dataclasses.replace(contact, history=None))
        if contact.history is not None:
            row["history"] = True
            arrays |= {f"contact{number}_{name}": getattr(contact.history, name) for name in HISTORY}
        contacts.append(row)
    meta = {
        "format": FORMAT,
        **{name: getattr(run, name) for name in ("hub_speed", "parameters", "stop_detail")},
        "events": [dataclasses.asdict(event) for event in run.events],
        "contacts": contacts,
        "stop_reason": run.stop_reason.name,
        "cost": dataclasses.asdict(run.cost),
        "contact_at_end": dataclasses.asdict(run.contact_at_end),
    }
    with complete_or_absent(Path(path)) as partial, partial.open("wb") as stream:
        np.savez_compressed(stream, metadata=np.array(json.dumps(meta)), **arrays)


def read(path: Path) -> dict[str, Any]:
    """Read the arguments of a trajectory from a file.

    Raises:
        OSError: if there is no such file or it cannot be read.
        ValueError: for a file that holds something else.
    """
    import json

    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            meta = json.loads(str(stored["metadata"]))
            if (found := meta.pop("format")) != FORMAT:
                raise ValueError(
                    f"written in format {found}, this version reads format {FORMAT}; simulate the run again"
                )
            return {
                **meta,
                **{name: stored[name] for name in ARRAYS},
                "events": tuple(Event(**row) for row in meta["events"]),
                "contacts": tuple(_contact(row, number, stored) for number, row in enumerate(meta["contacts"])),
                "stop_reason": StopReason[meta["stop_reason"]],
                "cost": Cost(**meta["cost"]),
                "contact_at_end": ContactAtEnd(**meta["contact_at_end"]),
                "inner_samples": InnerSamples(*(stored[f"inner_{name}"] for name in INNER))
                if "inner_time" in stored
                else None,
            }
    except OSError:
        raise
    except Exception as error:  # zip, JSON and NumPy each have their own for a file that is something else
        raise ValueError(f"{path}: cannot be read as a trajectory ({error})") from error


def _contact(row: dict[str, Any], number: int, stored: Any) -> ContactRecord:
    """Return a contact from its row, with its history from the arrays."""
    values: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
    if values["history"] is not None:
        values["history"] = ContactHistory(*(stored[f"contact{number}_{name}"] for name in HISTORY))
    return ContactRecord(**values)


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
