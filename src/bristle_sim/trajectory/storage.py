"""Trajectory files: npz archives that hold arrays, and all other data as JSON.

A file also holds a digest of its content. A file of another kind, or one whose content has been
changed, is refused.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from bristle_sim.files import complete_or_absent, named_path
from bristle_sim.settings import StopReason
from bristle_sim.trajectory.records import (
    SAMPLED,
    ContactHistory,
    ContactRecord,
    Cost,
    Event,
)

FORMAT = 4  # version of the file format
MOST_UNPACKED = (
    # Size of the unpacked arrays, bytes, up to which any file is read. A million samples of a rigid
    # bristle have this size.
    256e6
)
# Largest ratio of unpacked to packed size of a file with larger arrays. Compression reduces the
# arrays of a motion to a half of their size, and the arrays of a wire at rest to a thousandth.
MOST_PACKED = 100.0
HISTORY = tuple(each.name for each in dataclasses.fields(ContactHistory))
PLAIN = ("hub_speed", "parameters", "stop_detail")
"""Attributes of a run that JSON can hold as they are; ``HISTORY`` holds the names of the arrays of
a contact's history."""


def write(run: Any, path: str | Path) -> None:
    """Write a trajectory to one npz file with exactly the given name; no suffix is added.

    The file appears only when it is complete.

    Raises:
        OSError: if the file cannot be written; the message names the file.
    """
    arrays: dict[str, Any] = {name: getattr(run, name) for name in SAMPLED}
    for number, contact in enumerate(run.contacts):
        if contact.history is not None:
            arrays |= {
                f"contact{number}_{name}": getattr(contact.history, name) for name in HISTORY
            }
    meta = {
        "format": FORMAT,
        **{name: getattr(run, name) for name in PLAIN},
        "events": [dataclasses.asdict(event) for event in run.events],
        "contacts": [
            dataclasses.asdict(dataclasses.replace(contact, history=None))
            for contact in run.contacts
        ],
        "stop_reason": run.stop_reason.name,
        "cost": dataclasses.asdict(run.cost),
    }
    arrays["metadata"] = np.array(json.dumps(meta))
    with complete_or_absent(named_path(path)) as partial, partial.open("wb") as stream:
        np.savez_compressed(stream, digest=np.array(digest(arrays)), **arrays)


def digest(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return a SHA-256 digest of the names, types, shapes and bytes of arrays."""
    total = hashlib.sha256()
    for name in sorted(arrays):
        array = arrays[name]
        total.update(f"{name} {array.dtype} {array.shape}".encode())
        total.update(array.tobytes())
    return total.hexdigest()


def read(path: Path) -> dict[str, Any]:
    """Read a trajectory file; return the keyword arguments of ``Trajectory``.

    Raises:
        OSError: if the file does not exist or cannot be read.
        ValueError: if the file is not a trajectory file of this format; the message states the
            fault.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            _check_size(stored.zip, path.stat().st_size)
            meta = json.loads(str(stored["metadata"]))
            if (found := meta.pop("format")) != FORMAT:
                advice = f"this version reads format {FORMAT}; simulate the run again"
                raise ValueError(f"written in format {found}, {advice}")
            arrays = dict(stored)
        if str(arrays.pop("digest")) != digest(arrays):
            raise ValueError("its content differs from what Trajectory.save wrote")
        return _arguments(meta, arrays)
    except OSError:
        raise
    except (
        Exception
    ) as error:  # zip, JSON and NumPy each raise their own errors for a file of another kind
        why = "Trajectory.save did not write it" if "allow_pickle" in str(error) else error
        raise ValueError(f"{path}: cannot be read as a trajectory ({why})") from error


def _check_size(members: ZipFile, size: int) -> None:
    """Check that the arrays of a file are not so large that they fill the memory when unpacked.

    Args:
        members: members of the packed file.
        size: size of the packed file, bytes.

    Raises:
        ValueError: if the arrays are too large.
    """
    unpacked = sum(each.file_size for each in members.infolist())
    if unpacked > max(MOST_UNPACKED, MOST_PACKED * size):
        raise ValueError(
            f"its arrays take {unpacked:.3g} bytes, too many for a run in a file of {size:.3g} bytes"
        )


def _arguments(meta: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """Return the keyword arguments of ``Trajectory`` from a file's metadata and arrays."""
    contacts = []
    for number, row in enumerate(meta["contacts"]):
        values: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in row.items()
        }
        if f"contact{number}_time" in arrays:
            values["history"] = ContactHistory(
                **{name: arrays[f"contact{number}_{name}"] for name in HISTORY}
            )
        contacts.append(ContactRecord(**values))
    return {
        **meta,
        **{name: arrays[name] for name in SAMPLED},
        "events": tuple([Event(**row) for row in meta["events"]]),
        "contacts": tuple(contacts),
        "stop_reason": StopReason[meta["stop_reason"]],
        "cost": Cost(**meta["cost"]),
    }
