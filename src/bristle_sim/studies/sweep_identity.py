"""Digest of a swept function and all that it refers to, so that a store never returns stale results.

joblib's hash walks the values. The user's functions, classes and modules stand for their instructions and values, installed
ones for name and version, this package for its files. A pickle by value would contain line numbers and random numbers.
"""

from __future__ import annotations

import dis
import functools
import sys
import sysconfig
import types
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pickle import PicklingError, whichmodule  # type: ignore[attr-defined]
from typing import Any

import numpy as np
from joblib.hashing import NumpyHasher

import bristle_sim

CODE = "co_code co_consts co_names co_varnames co_freevars co_argcount co_kwonlyargcount co_flags co_exceptiontable"
"""Parts of compiled code that determine its behaviour, unlike file names and line numbers."""

FUNCTION = "__qualname__ __code__ __defaults__ __kwdefaults__ __closure__"
ACCESSORS = (property, staticmethod, classmethod, functools.cached_property, functools._lru_cache_wrapper)


def name_of(function: Any) -> str:
    """Return a function's module and name, of ``functools.partial`` those of the function within."""
    inner = function.func if isinstance(function, functools.partial) else function
    return f"{getattr(inner, '__module__', '')}.{getattr(inner, '__qualname__', type(inner).__qualname__)}"


def identity_of(function: Callable[..., Any], version: str = "") -> str:
    """Return a digest of a function, of all that it refers to, of this package and of a given version.

    Raises ValueError if the function refers to an object whose changes cannot be seen, such as a lock or an open file.
    """
    package = Path(bristle_sim.__file__).parent
    files = [(path.relative_to(package).as_posix(), path.read_bytes()) for path in sorted(package.rglob("*.py"))]
    try:
        parts = files, *map(_version, ("numpy", "pymunk", "scipy")), version, function
        hasher = NumpyHasher(hash_name="sha256")
        hasher.reducer_override = _reduced
        return str(hasher.hash(parts))
    except (TypeError, ValueError, AttributeError, ImportError, RecursionError, PicklingError) as error:
        why = " ".join(str(error).split())
        raise ValueError(
            f"function = {name_of(function)}: must not refer to objects whose changes a store cannot see ({why})"
        ) from error


def _reduced(value: Any) -> Any:
    """Reduce a value for pickle to an empty tuple whose state is the value's parts, which may refer back to it."""
    parts = None if value is tuple else _parts(value)
    return NotImplemented if parts is None else (tuple, (), parts)


def _parts(value: Any) -> Any:
    """Return the parts that identify a value; None leaves the value to pickle."""
    module = value.__name__ if isinstance(value, types.ModuleType) else getattr(value, "__module__", "")
    found: Any = None
    if isinstance(value, types.ModuleType | types.FunctionType | type) and _is_library(module or "__main__"):
        found = module, getattr(value, "__qualname__", ""), _version(module)
    elif isinstance(value, frozenset):
        found = set(value)
    elif isinstance(value, types.MappingProxyType):
        found = dict(value)
    elif isinstance(value, types.CodeType):
        found = [getattr(value, name) for name in CODE.split()]
    elif isinstance(value, types.CellType):
        found = [] if value == types.CellType() else [value.cell_contents]
    elif isinstance(value, types.FunctionType):
        found = [getattr(value, name) for name in FUNCTION.split()], list(_named(value))
    elif isinstance(value, type):
        found = value.__qualname__, value.__bases__, [each for each in vars(value).items() if _is_own(*each)]
    elif isinstance(value, ACCESSORS):
        found = [getattr(value, each, None) for each in ("__wrapped__", "func", "fget", "fset", "fdel")]
    elif isinstance(value, np.ufunc) and not _is_library(whichmodule(value, value.__name__)):
        raise TypeError(f"{value.__name__} is known by its name alone")
    return found


def _named(function: types.FunctionType) -> Iterator[Any]:
    """Yield the values of the global names in a function, and of the modules that it imports."""
    steps = [each for code in _codes(function.__code__) for each in dis.get_instructions(code)]
    names = {str(each.argval) for each in steps}
    for kind, name in sorted({(each.opname, str(each.argval)) for each in steps}):
        if kind in ("LOAD_GLOBAL", "LOAD_NAME"):
            yield name, _used(function.__globals__.get(name), names)
        elif kind == "IMPORT_NAME" and find_spec(name) and not _is_library(name):
            yield name, _used(import_module(name), names)


def _is_own(name: str, value: Any) -> bool:
    """Whether the user has written this attribute of a class, and not Python."""
    hidden = name.startswith("__") and not isinstance(value, (types.FunctionType, *ACCESSORS))
    return not (
        hidden or name == "_abc_impl" or isinstance(value, types.MemberDescriptorType | types.GetSetDescriptorType)
    )


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """Yield a function's code, and that of the functions within it."""
    yield code
    yield from (inner for each in code.co_consts if isinstance(each, types.CodeType) for inner in _codes(each))


def _used(value: Any, names: set[str]) -> Any:
    """Return a value; for a user's module return its values that have one of the names."""
    if not isinstance(value, types.ModuleType) or _is_library(value.__name__):
        return value
    return {name: _used(vars(value)[name], names - {name}) for name in sorted(names & vars(value).keys())}


@functools.cache
def _is_library(module: str) -> bool:
    """Whether a module is installed, or built into Python."""
    if module == "__main__" or module.startswith("bristle_sim.scenarios."):  # a work tree has them beside the package
        return False
    if module.partition(".")[0] == "bristle_sim":
        return True
    file = getattr(sys.modules.get(module) or import_module(module), "__file__", None)
    installed = {"site-packages", "dist-packages"} & {*Path(file or "").parts}
    return file is None or bool(installed) or Path(file).is_relative_to(sysconfig.get_path("stdlib"))


def _version(module: str) -> str:
    return str(getattr(sys.modules.get(module.partition(".")[0]), "__version__", ""))
