"""The identity of a swept function: a digest of all that it refers to, so that a store never returns stale results.

The user's functions, classes and modules stand for their instructions and values, installed ones for name and version, this
package for its files. cloudpickle would note line numbers, and a random number for each class.
"""

from __future__ import annotations

import copyreg
import dis
import functools
import hashlib
import sys
import sysconfig
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from importlib.util import find_spec
from operator import methodcaller
from pathlib import Path
from pickle import PicklingError, whichmodule  # type: ignore[attr-defined]
from types import (
    CellType,
    CodeType,
    FunctionType,
    GetSetDescriptorType,
    MappingProxyType,
    MemberDescriptorType,
    ModuleType,
)
from typing import Any

import bristle_sim

PLAIN = (type(None), bool, int, float, complex, str, type(...), range)
"""Types whose representation is their value."""

CODE = "co_code co_consts co_names co_varnames co_freevars co_argcount co_kwonlyargcount co_flags co_exceptiontable"
"""Parts of compiled code that decide what it does, unlike file names and line numbers."""

ACCESSORS = (property, staticmethod, classmethod, functools.cached_property, functools._lru_cache_wrapper)
REFERENCES = ("LOAD_GLOBAL", "LOAD_NAME", "IMPORT_NAME")


def name_of(function: Any) -> str:
    """Return a function's module and name, of ``functools.partial`` those of the function within."""
    inner = function.func if isinstance(function, functools.partial) else function
    return f"{getattr(inner, '__module__', '')}.{getattr(inner, '__qualname__', type(inner).__qualname__)}"


def identity_of(function: Callable[..., Any], version: str = "") -> str:
    """Return a digest of a function, of all that it refers to, of this package and of a given version.

    Raises:
        ValueError: if the function refers to an object whose changes cannot be seen, such as a lock or an open file.
    """
    package, files = Path(bristle_sim.__file__).parent, hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        files.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes())
    try:
        parts = _digest(function, (), {}), files.digest(), *map(_version, ("numpy", "pymunk", "scipy")), version
    except (TypeError, ValueError, AttributeError, ImportError, RecursionError, PicklingError) as error:
        why = " ".join(str(error).split())
        raise ValueError(
            f"function = {name_of(function)}: must not refer to objects whose changes a store cannot see ({why})"
        ) from error
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _digest(value: Any, path: tuple[int, ...], known: dict[int, tuple[Any, str]]) -> str:
    """Return a digest of a value and all below it; ``path`` has the identities of the values that it is a part of."""
    if type(value) in PLAIN:
        return f"{type(value).__name__} {value!r}"
    if id(value) in path:
        return f"again {len(path) - path.index(id(value))}"
    if id(value) not in known:
        if isinstance(value, bytes):
            parts = [hashlib.sha256(value).hexdigest()]
        else:
            parts = [_digest(each, (*path, id(value)), known) for each in _content(value)]
        kind = type(value).__qualname__, sorted(parts) if isinstance(value, set | frozenset) else parts
        known[id(value)] = value, hashlib.sha256(repr(kind).encode()).hexdigest()  # with the value, which keeps its id
    return known[id(value)][1]


def _content(value: Any) -> Iterable[Any]:
    """Return the parts of a value that decide what it is."""
    module = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", "")
    found: Iterable[Any]
    if isinstance(value, ModuleType | FunctionType | type) and _is_library(module or "__main__"):
        found = module, getattr(value, "__qualname__", ""), _version(module)
    elif type(value) in (list, tuple, set, frozenset):
        found = list(value)
    elif type(value) in (dict, MappingProxyType):
        found = [each for item in value.items() for each in item]
    elif isinstance(value, CodeType):
        found = [getattr(value, name) for name in CODE.split()]
    elif isinstance(value, CellType):
        found = [] if value == CellType() else [value.cell_contents]
    elif isinstance(value, FunctionType):
        found = _function_content(value)
    elif isinstance(value, type):
        found = value.__qualname__, value.__bases__, [each for each in vars(value).items() if _is_own(*each)]
    elif isinstance(value, ACCESSORS):
        found = [getattr(value, each, None) for each in ("__wrapped__", "func", "fget", "fset", "fdel")]
    else:
        reduced = copyreg.dispatch_table.get(type(value), methodcaller("__reduce_ex__", 4))(value)
        if isinstance(reduced, str) and not _is_library(whichmodule(value, reduced)):
            raise TypeError(f"{reduced} is known by its name alone")
        found = [list(each) if isinstance(each, Iterator) else each for each in (type(value).__module__, *reduced)]
    return found


def _function_content(function: FunctionType) -> Iterator[Any]:
    """Yield a function's instructions, and the values of the names in them."""
    yield from (
        function.__qualname__,
        function.__code__,
        function.__defaults__,
        function.__kwdefaults__,
        function.__closure__,
    )
    steps = [each for code in _codes(function.__code__) for each in dis.get_instructions(code)]
    names = {str(each.argval) for each in steps}
    for kind, name in sorted({(each.opname, each.argval) for each in steps if each.opname in REFERENCES}):
        if kind != "IMPORT_NAME":
            yield name, _used(function.__globals__.get(name), names)
        elif find_spec(name) and not _is_library(name):
            yield name, _used(import_module(name), names)


def _is_own(name: str, value: Any) -> bool:
    """Whether an attribute of a class says what it does, unlike those that Python adds."""
    hidden = name.startswith("__") and not isinstance(value, (FunctionType, *ACCESSORS))
    return not (hidden or name == "_abc_impl" or isinstance(value, MemberDescriptorType | GetSetDescriptorType))


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a function's code, and that of the functions within it."""
    yield code
    yield from (inner for each in code.co_consts if isinstance(each, CodeType) for inner in _codes(each))


def _used(value: Any, names: set[str]) -> Any:
    """Return a value; of a module of the user the values in it that have one of the names."""
    if not isinstance(value, ModuleType) or _is_library(value.__name__):
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
