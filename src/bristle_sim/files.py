"""Files that appear only when complete."""

from __future__ import annotations

import itertools
import os
import shutil
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["complete_or_absent", "is_special"]

_COUNT = itertools.count()


@contextmanager
def complete_or_absent(target: Path) -> Iterator[Path]:
    """Yield the name of a partial file to write; it becomes the target on success and vanishes on failure.

    A symbolic link stays one, and the file it names is written. What is no regular file, such as a pipe or a device,
    receives the bytes when the partial file is complete. An OSError names the target.
    """
    special = is_special(target)
    final = target if special else Path(os.path.realpath(target))
    folder = Path(tempfile.gettempdir()) if special else final.parent
    partial = folder / f".bristle_sim.{os.getpid()}.{threading.get_ident()}.{next(_COUNT)}.part"
    try:
        yield partial
        if special:
            with partial.open("rb") as written, final.open("wb") as stream:
                shutil.copyfileobj(written, stream)
        else:
            partial.replace(final)
    except OSError as error:
        if error.filename is not None and os.fspath(error.filename) == str(partial):
            raise OSError(error.errno, error.strerror, str(target)) from None
        raise
    finally:
        partial.unlink(missing_ok=True)


def is_special(path: Path) -> bool:
    """Whether a path names something that is neither a regular file nor a folder: a device, a pipe, a socket."""
    return path.exists() and not path.is_file() and not path.is_dir()
