"""Digest that identifies a swept function: its name, its source text, the values bound to it, and
the user's version.

For a function in a package the source text is that of all modules of the package; for a function in
a script or a notebook's cell it is the script or the cell alone. The digest covers neither the code
of other packages nor global variables that a program sets as it runs. joblib hashes the bound
values.
"""

import functools
import linecache
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path
from pickle import PicklingError
from types import CellType, FunctionType
from typing import Any

import joblib
import numpy as np
from joblib.hashing import NumpyHasher

INSTALLED = tuple(sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib"))


def name_of(function: Any) -> str:
    """Return the module and name of a function.

    For ``functools.partial`` they are those of the wrapped function.
    """
    inner = function.func if isinstance(function, functools.partial) else function
    return f"{getattr(inner, '__module__', '')}.{getattr(inner, '__qualname__', type(inner).__qualname__)}"


def identity_of(function: Callable[..., Any], version: str = "") -> str:
    """Return a digest by which a store of results notices that a function has changed.

    The digest covers the function's source, the values bound to it, this package, the versions of
    NumPy, pymunk and SciPy, and the user's ``version``.

    Raises:
        ValueError: if no version is given and the function has no source text, or is bound to an
            object that is not data.
    """
    libraries = [_version(name) for name in ("numpy", "pymunk", "scipy")]
    own = _folder_digest(Path(__file__).parents[1])
    try:
        return str(_Hasher(version).hash((own, libraries, version, function)))
    except Exception as error:  # an object that pickle cannot save may raise any error
        reason = " ".join(str(error).split())
        words = f"function = {name_of(function)}: a store cannot notice changes of {reason}"
        raise ValueError(words + ("" if version else "; pass version=...")) from error


class _Hasher(NumpyHasher):  # type: ignore[misc]
    """Hash of Python values, in which a function or class is represented by its source text.

    A function or class of an installed package is represented by its name and the package's
    version.
    """

    def __init__(self, version: str) -> None:
        super().__init__(hash_name="sha256")
        self.version = version
        self.digest = functools.cache(_folder_digest)

    def reducer_override(self, value: Any) -> Any:
        """Return the substitute that pickle writes for a function, class, frozen set or cache.

        The substitute is an empty tuple whose state holds all data that the hash must cover. Unlike
        the items of a tuple, a state may refer back to the value itself, as for a recursive
        function.
        """
        parts: Any
        if isinstance(value, FunctionType):
            cells = [cell.cell_contents for cell in value.__closure__ or () if cell != CellType()]
            text = self.source(value, value.__code__.co_filename)
            parts = (text, value.__defaults__, value.__kwdefaults__, cells)
        elif isinstance(value, type) and value.__module__ != "builtins":
            parts = self.source(value, getattr(sys.modules.get(value.__module__), "__file__", ""))
        elif isinstance(value, frozenset):  # joblib sorts a set, but not a frozen one
            parts = set(value)
        elif isinstance(value, functools._lru_cache_wrapper):
            parts = [value.__wrapped__]
        else:
            return NotImplemented
        return tuple, (), parts

    def save(self, value: Any) -> None:
        """Add a value to the hash.

        If pickle cannot save the value, for example a lock, its name is added instead.
        """
        try:
            super().save(value)
        except (TypeError, PicklingError):
            kind = f"an object of the type {type(value).__qualname__!r}"
            words = f"the ufunc {value.__name__!r}" if isinstance(value, np.ufunc) else kind
            super().save(self.name_alone(value, words))

    def source(self, value: Any, file: str) -> Any:
        """Return the data that identify the source of a function or class.

        The data are the name of ``value``, its position in the source file, the text of the file,
        and a digest of the package. For an installed package they are the module, the name and the
        package's version.
        """
        module = sys.modules.get(value.__module__)
        package = (getattr(module, "__package__", "") or value.__module__).partition(".")[0]
        built_in = not file and value.__module__ != "__main__"
        if built_in or "site-packages" in Path(file).parts or file.startswith(INSTALLED):
            return value.__module__, value.__qualname__, _version(package)
        linecache.checkcache(file)
        text = linecache.getlines(file)
        # Under the name "<string>" Python 3.13 keeps the text of ``python -c``, not that of ``eval``.
        if file == "<string>" or not text:
            return self.name_alone(value, f"{value.__qualname__!r}, which has no source text")
        place = list(value.__code__.co_positions()) if isinstance(value, FunctionType) else None
        folders = getattr(sys.modules.get(package), "__path__", ())
        return value.__qualname__, place, text, [self.digest(Path(each)) for each in folders]

    def name_alone(self, value: Any, words: str) -> str:
        """Return the name of a value that cannot be hashed, if the user gives a version.

        Raises:
            ValueError: with the message ``words``, if no version is given.
        """
        if not self.version:
            raise ValueError(words)
        return name_of(value)


def _folder_digest(folder: Path) -> str:
    """Return a digest of the names and texts of all Python files in a package's folder."""
    files = {
        str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*.py"))
    }
    return str(joblib.hash(files))


def _version(package: str) -> str:
    return str(getattr(sys.modules.get(package), "__version__", ""))
