"""Trajectory files: npz archives of arrays, with all other data as JSON.

A file of any other kind is refused.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Any, TypeVar, Union, get_args, get_origin, get_type_hints
from zipfile import ZipFile

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.files import complete_or_absent
from bristle_sim.settings import StopReason
from bristle_sim.trajectory.recorded_run import RecordedRun
from bristle_sim.trajectory.records import (
    SAMPLED,
    WIRE,
    ContactHistory,
    ContactRecord,
    Cost,
    Event,
    WireMotion,
)

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

FORMAT = 3  # number of the file format
MOST_UNPACKED = (
    # most bytes of unpacked arrays that any file may hold: a million samples of a rigid bristle
    256e6
)
# Largest ratio of unpacked to packed bytes of a larger file: motion packs to a half, rest to a
# thousandth.
MOST_PACKED = 100.0
HISTORY = tuple(each.name for each in dataclasses.fields(ContactHistory))
PLAIN = {"hub_speed": float, "parameters": dict, "stop_detail": str}
"""Names of the arrays of a contact's history; and parts of a run that JSON can hold, with their
types."""

T = TypeVar("T", bound="DataclassInstance")


def write(run: RecordedRun, path: str | Path) -> None:
    """Write a run to one npz file of exactly the given name; no suffix is added.

    The file appears only when it is complete.

    Raises:
        OSError: if the file cannot be written; the message names it.
    """
    arrays: dict[str, Any] = {name: getattr(run, name) for name in SAMPLED}
    if run.inner_samples is not None:
        arrays |= {f"inner_{name}": getattr(run.inner_samples, name) for name in WIRE}
    contacts = []
    for number, contact in enumerate(run.contacts):
        contacts.append(dataclasses.asdict(dataclasses.replace(contact, history=None)))
        if contact.history is not None:
            contacts[-1]["history"] = True
            arrays |= {
                f"contact{number}_{name}": getattr(contact.history, name) for name in HISTORY
            }
    meta = {
        "format": FORMAT,
        **{name: getattr(run, name) for name in PLAIN},
        "events": [dataclasses.asdict(event) for event in run.events],
        "contacts": contacts,
        "stop_reason": run.stop_reason.name,
        "cost": dataclasses.asdict(run.cost),
    }
    with complete_or_absent(Path(path)) as partial, partial.open("wb") as stream:
        np.savez_compressed(stream, metadata=np.array(json.dumps(meta)), **arrays)


def read(path: Path) -> dict[str, Any]:
    """Read a trajectory file; return the arguments of ``Trajectory``.

    Raises:
        OSError: if the file does not exist or cannot be read.
        ValueError: if the file is no trajectory file of this format; the message names the fault.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            _check_size(stored.zip, path.stat().st_size)
            meta = json.loads(str(stored["metadata"]), parse_float=_finite, parse_constant=_finite)
            if (found := meta.pop("format")) != FORMAT:
                advice = f"this version reads format {FORMAT}; simulate the run again"
                raise ValueError(f"written in format {found}, {advice}")
            return _checked(meta, stored)
    except OSError:
        raise
    except (
        Exception
    ) as error:  # zip, JSON and NumPy each raise their own errors for a file of another kind
        why = "Trajectory.save did not write it" if "allow_pickle" in str(error) else error
        raise ValueError(f"{path}: cannot be read as a trajectory ({why})") from error


def _check_size(members: ZipFile, size: int) -> None:
    """Refuse a file of ``size`` bytes whose unpacked members would fill the memory."""
    unpacked = sum(each.file_size for each in members.infolist())
    if unpacked > max(MOST_UNPACKED, MOST_PACKED * size):
        raise ValueError(
            f"its arrays take {unpacked:.3g} bytes, too many for a run in a file of {size:.3g} bytes"
        )


def _checked(meta: dict[str, Any], stored: Mapping[str, Array]) -> dict[str, Any]:
    sizes = {"2": 2}
    arrays = _arrays(stored, "", SAMPLED, sizes)
    inner = None
    _require("time", arrays["time"].size > 0, "have at least one sample")
    if "inner_time" in stored:
        inner = WireMotion(**_arrays(stored, "inner_", WIRE, {name: sizes[name] for name in "lc2"}))
    for name, kind in PLAIN.items():
        _require(name, _fits(meta[name], kind), f"be of type {kind.__name__}")
    events = tuple(_record(Event, row) for row in meta["events"])
    _require(
        "events",
        all(one.time <= other.time for one, other in pairwise(events)),
        "be in order of time",
    )
    contacts = []
    for number, row in enumerate(meta["contacts"]):
        values = {
            key: tuple(value) if isinstance(value, list) else value for key, value in row.items()
        }
        if values["history"] is not None:
            values["history"] = ContactHistory(**_arrays(stored, f"contact{number}_", HISTORY, {}))
        contacts.append(_record(ContactRecord, values))
        for name in ("angles", "rates_before", "rates_after"):
            _require(f"contacts: {name}", len(values[name]) == sizes["l"], "be one for each link")
    parts = {"events": events, "contacts": tuple(contacts), "inner_samples": inner}
    return {
        **meta,
        **arrays,
        **parts,
        "stop_reason": StopReason[meta["stop_reason"]],
        "cost": _record(Cost, meta["cost"]),
    }


def _arrays(
    stored: Mapping[str, Array], prefix: str, names: Iterable[str], sizes: dict[str, int]
) -> dict[str, Array]:
    """Return stored arrays after a check of their dimensions against the known sizes.

    Sizes that are new are added to ``sizes``.
    """
    found = {}
    for name in names:
        array, (letters, _), whole = (
            stored[f"{prefix}{name}"],
            SAMPLED.get(name, ("n", "")),
            f"{prefix}{name}",
        )
        found[name] = array
        _require(whole, array.dtype == float, f"be floats, not {array.dtype}")
        wanted = [
            sizes.get(letter, size) for letter, size in zip(letters, array.shape, strict=False)
        ]
        shape = f"have the shape ({', '.join(str(sizes.get(each, each)) for each in letters)})"
        _require(whole, array.ndim == len(letters) and [*array.shape] == wanted, shape)
        _require(whole, bool(np.isfinite(array).all()), "be finite")
        sizes |= dict(zip(letters, array.shape, strict=True))
    _require(f"{prefix}time", bool(np.all(np.diff(found["time"]) >= 0.0)), "not descend")
    return found


def _record(kind: type[T], row: dict[str, Any]) -> T:
    found = kind(**row)
    for name, hint in get_type_hints(kind).items():
        _require(f"{kind.__name__}.{name}", _fits(getattr(found, name), hint), f"be of type {hint}")
    return found


def _fits(value: Any, hint: Any) -> bool:
    """Return whether a value is of a type: a class, a tuple of fixed or any length, or a union of
    types.
    """
    origin = get_origin(hint)
    parts = get_args(hint)
    if origin in (Union, UnionType):
        return any(_fits(value, part) for part in parts)
    if origin is tuple:
        wanted = (
            parts[:1] * len(value) if isinstance(value, tuple) and parts[-1] is Ellipsis else parts
        )
        return (
            isinstance(value, tuple)
            and len(value) == len(wanted)
            and all(map(_fits, value, wanted))
        )
    if hint is float:
        return isinstance(value, float | int) and not isinstance(value, bool)
    return isinstance(value, hint)


def _finite(number: str) -> float:
    """Return a number of the metadata, which must be finite: JSON may contain ``NaN`` and
    ``Infinity``.
    """
    _require(number, math.isfinite(float(number)), "be finite")
    return float(number)


def _require(name: str, holds: bool, what: str) -> None:
    if not holds:
        raise ValueError(f"{name}: must {what}")
