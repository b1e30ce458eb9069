"""Writing of files that appear under their names only when they are complete."""

import itertools
import os
import re
import threading
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from bristle_sim.units import shown

_COUNT = itertools.count()

LONGEST_NAME = 255  # longest name of a file, without its folders, that file systems take, bytes

_STREAM = re.compile(r"/dev/(stdin|stdout|stderr)|/(?:dev|proc/self)/fd/(\d+)")
"""Pattern of the names of open streams: standard streams by name, any stream by number."""


def named_path(path: object) -> Path:
    """Return a path as an object of the class ``Path``.

    Raises:
        ValueError: for an object that is neither a text nor a path.
    """
    if not isinstance(path, str | Path):
        raise ValueError(f"path = {shown(path)}: must be the name of a file")
    return Path(path)


def checked_target(
    path: str | Path, suffixes: Collection[str] = (), *, option: str = "", folder: bool = False
) -> Path:
    """Check that a file or folder can be written, and return its path.

    Args:
        path: name of the file or folder.
        suffixes: permitted suffixes of a file's name, such as ``.png``; all if empty.
        option: name of the option that gave the path, for the message.
        folder: whether the path must be a folder instead of a file.

    Raises:
        ValueError: if the file or folder cannot be written. The message is one line that begins
            with the option, if given, or with the path.
    """
    target = named_path(path)
    named = f"{option} = {str(path)!r}" if option else str(path)
    if len(os.fsencode(target.name)) > LONGEST_NAME:
        raise ValueError(f"{named}: must be a file name of at most {LONGEST_NAME} bytes")
    if suffixes and not folder and target.suffix.lower() not in suffixes:
        raise ValueError(f"{named}: must be a file name that ends in {', '.join(suffixes)}")
    if target.is_dir() != folder and target.exists():
        raise ValueError(f"{named}: must be {'a folder' if folder else 'a file, not a folder'}")
    place = Path(os.path.realpath(target))
    writable = (
        target if is_special(target) else place if folder and place.is_dir() else place.parent
    )
    if not (writable.is_dir() or is_special(writable)) or not os.access(writable, os.W_OK):
        raise ValueError(f"{named}: must be in an existing, writable folder")
    return target


@contextmanager
def complete_or_absent(target: Path) -> Iterator[Path]:
    """Yield the path of a temporary file to write; the complete file replaces the target.

    If an error occurs, the temporary file is deleted and the target stays unchanged. If the target
    is a symbolic link, the link is kept and the file to which it points is replaced. A pipe, a
    device or an open stream such as ``/dev/stdout`` receives the bytes of the complete file.

    Raises:
        OSError: if the file cannot be written; the error names the target.
    """
    import tempfile

    special = is_special(target)
    final = target if special else Path(os.path.realpath(target))
    folder = Path(tempfile.gettempdir()) if special else final.parent
    partial = folder / f".bristle_sim.{os.getpid()}.{threading.get_ident()}.{next(_COUNT)}.part"
    try:
        yield partial
        if special:
            import shutil

            with partial.open("rb") as written, _opened(final) as stream:
                shutil.copyfileobj(written, stream)
        else:
            partial.replace(final)
    except OSError as error:
        named = error.filename and os.fspath(error.filename)
        if error.errno is not None and named in (None, str(partial)):
            raise OSError(error.errno, error.strerror, str(target)) from None
        raise
    finally:
        partial.unlink(missing_ok=True)


def is_special(path: Path) -> bool:
    """Return whether a path names an open stream, a device, a pipe or a socket."""
    return _descriptor(path) is not None or (
        path.exists() and not path.is_file() and not path.is_dir()
    )


def _descriptor(path: Path) -> int | None:
    """Return the number of the open stream that a path names; None for any other path."""
    found = _STREAM.fullmatch(str(path))
    if found is None:
        return None
    return int(found[2]) if found[2] else ("stdin", "stdout", "stderr").index(found[1])


def _opened(path: Path) -> BinaryIO:
    """Open a device, a pipe or an already open stream for writing.

    An open stream is duplicated, because opening it by name would empty the file behind it.
    """
    number = _descriptor(path)
    if number is None:
        return path.open("wb")
    try:
        return os.fdopen(os.dup(number), "wb")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
