"""Impulses of a body's contacts, read after each step without pymunk's wrappers where the engine offers that bare."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Protocol

import pymunk

from bristle_sim.contact_space.engine_calls import bare_object, ffi, lib


class ImpulseRecord(Protocol):
    """Notes the impulses of contacts, step after step."""

    def begin(self) -> int:
        """Forget what was noted, note the last step's, and return how many numbers that are."""

    def note(self) -> None:
        """Note the last step's."""

    def read(self) -> Sequence[float]:
        """Return what was noted: impulse (x, y) and normal (x, y) of one contact after the other."""


def impulse_record(space: pymunk.Space, body: pymunk.Body) -> ImpulseRecord:
    """Return a record of a body's contacts, which are all that the space has while it is used."""
    bare = bare_object(space, "_space")
    return _Record(body) if bare is None else _BareRecord(bare)


class _Record:
    """Notes a body's contacts by pymunk's documented calls."""

    def __init__(self, body: pymunk.Body) -> None:
        self._body = body
        self._numbers: list[float] = []

    def begin(self) -> int:
        """Forget what was noted, note the last step's contacts, and return how many numbers that are."""
        self._numbers.clear()
        self.note()
        return len(self._numbers)

    def note(self) -> None:
        """Note the last step's contacts."""
        self._body.each_arbiter(lambda each: self._numbers.extend((*each.total_impulse, *each.normal)))

    def read(self) -> Sequence[float]:
        """Return what was noted."""
        return self._numbers


class _BareRecord:
    """Has the engine write down all its contacts, one step after the other, to be read at once."""

    def __init__(self, space: Any) -> None:
        self._numbers = ffi.gc(lib.pmFloatArrayNew(0), lib.pmFloatArrayFree)
        self._data = ffi.new("pmBatchedData *", (ffi.NULL, self._numbers, lib.TOTAL_IMPULSE | lib.NORMAL))
        write = ffi.addressof(lib, "pmSpaceArbiterIteratorFuncBatched")
        self.note = partial(lib.cpSpaceEachCachedArbiter, space, write, self._data)

    def begin(self) -> int:
        """Forget what was noted, note the last step's contacts, and return how many numbers that are."""
        self._numbers.num = 0
        self.note()
        count: int = self._numbers.num
        return count

    def read(self) -> Sequence[float]:
        """Return what was noted."""
        numbers: list[float] = ffi.unpack(self._numbers.arr, self._numbers.num)
        return numbers


def pushes(numbers: Sequence[float]) -> list[float]:
    """Return the normal part of each impulse of a record.

    Which way the engine's normal points, and the sign of its impulse, depend on the order of the shapes inside the engine; a
    contact only pushes, which settles both.
    """
    each = [iter(numbers)] * 4
    return [abs(p * x + q * y) for p, q, x, y in zip(*each, strict=True)]
