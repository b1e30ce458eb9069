"""One point of a sweep: what comes out, and what it depends on apart from its parameters.

The latter are the function, what it uses, and the software. Results that are kept on disk are found again by a digest of
these. Worker processes import this module and not those that label and store results.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path
from pickle import PicklingError
from types import CodeType, FunctionType
from typing import Any

import joblib
import numpy as np

import bristle_sim
from bristle_sim.arrays import Array
from bristle_sim.units import shown

Outcome = tuple[dict[str, Array], str]
"""Results of a point by name, and the reason why there are none, empty where there are."""

LIBRARIES = ("numpy", "pymunk", "scipy")
"""Those whose version may change a digit of a result."""

CONSTANTS = (bool, int, float, complex, str, bytes, tuple, frozenset)
"""Types of a module's variables that count as constants."""


def evaluate_point(function: Callable[..., Any], identity: str, **arguments: Any) -> Outcome:  # noqa: ARG001
    """Results of a function, or why it raised; the identity makes it another entry of the cache when that changes."""
    try:
        result = function(**arguments)
        named = result if isinstance(result, Mapping) else {"result": result}
        return {str(name): np.asarray(value, dtype=float) for name, value in named.items()}, ""
    except Exception as error:
        return {}, " ".join(f"{type(error).__name__}: {error}".split())


def check_arguments(function: Callable[..., Any], arguments: Mapping[str, Any]) -> None:
    """Raise ValueError for a function that does not take these keyword arguments."""
    if not callable(function):
        raise ValueError(f"function = {shown(function)}: must be callable")
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # some built-in functions have none
        return
    try:
        signature.bind(**arguments)
    except TypeError as error:
        raise ValueError(f"space: must have the arguments of {_name(function)} ({error})") from error


def described(function: Callable[..., Any]) -> dict[str, str]:
    """A function's name, the arguments bound to it, and the software, in words."""
    software = [f"bristle_sim {_package_digest():.12}", *(f"{name} {metadata.version(name)}" for name in LIBRARIES)]
    bound = {name: str(value) for name, value in getattr(function, "keywords", {}).items()}
    return {"function": _name(function), **bound, "software": ", ".join(software)}


def identity_of(function: Callable[..., Any], version: str = "") -> str:
    """A digest of a function, of what it is bound to, of this package and its libraries, and of a given version.

    Source text stands for a function, together with the constants and functions of its own module that it uses; functions
    of other modules are not looked into.

    Raises:
        ValueError: if what the function is bound to cannot be pickled.
    """
    parts = (_parts(function, set()), _package_digest(), [metadata.version(name) for name in LIBRARIES], version)
    try:
        return str(joblib.hash(parts))
    except (PicklingError, TypeError, AttributeError) as error:
        raise ValueError(f"function = {_name(function)}: what is bound to it must be picklable ({error})") from error


def _parts(function: Any, seen: set[int]) -> Any:
    """Plain values that differ when what the function computes may differ."""
    if isinstance(function, functools.partial):
        bound = {name: _parts(each, seen) for name, each in function.keywords.items()}
        return _parts(function.func, seen), [_parts(each, seen) for each in function.args], bound
    if inspect.ismethod(function):
        return _parts(function.__func__, seen), function.__self__
    if not isinstance(function, FunctionType):
        # A callable object: its attributes are its state. Anything else stands for itself.
        own = vars(type(function)).get("__call__")
        return (_parts(own, seen), function) if isinstance(own, FunctionType) else function
    if id(function) in seen:
        return function.__qualname__
    seen.add(id(function))
    used = inspect.getclosurevars(function)
    own_constants = {
        name: each
        for name, each in used.globals.items()
        if isinstance(each, CONSTANTS) or (isinstance(each, FunctionType) and each.__module__ == function.__module__)
    }
    values = {name: _parts(each, seen) for name, each in {**own_constants, **used.nonlocals}.items()}
    name = (function.__module__, function.__qualname__)
    return name, _source(function), function.__defaults__, function.__kwdefaults__, values


def _source(function: FunctionType) -> Any:
    """Return a function's source text, or its compiled instructions where there is no file."""

    def instructions(code: CodeType) -> Any:
        constants = [instructions(each) if isinstance(each, CodeType) else repr(each) for each in code.co_consts]
        return code.co_code, code.co_names, constants

    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        return instructions(function.__code__)


@functools.cache
def _package_digest() -> str:
    """Digest of this package's source files."""
    digest = hashlib.sha256()
    folder = Path(bristle_sim.__file__).parent
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _name(function: Any) -> str:
    inner = function.func if isinstance(function, functools.partial) else function
    return f"{getattr(inner, '__module__', '')}.{getattr(inner, '__qualname__', type(inner).__qualname__)}"
