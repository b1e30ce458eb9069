"""Files that appear only when complete."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["complete_or_absent"]


@contextmanager
def complete_or_absent(target: Path) -> Iterator[Path]:
    """Yield a name next to the target to write to; it replaces the target on success and vanishes on failure."""
    partial = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield partial
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
