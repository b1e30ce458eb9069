"""One line of refusal for arguments that may be arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["finite", "not_negative", "positive", "require", "whole"]


def require(name: str, value: Any, holds: Any, allowed: str) -> None:
    """Raise ValueError with the first value for which ``holds`` is false; value and holds broadcast."""
    values, passed = np.broadcast_arrays(np.asarray(value, dtype=float), np.asarray(holds, dtype=bool))
    if not passed.all():
        raise ValueError(f"{name} = {values[~passed][0]:g}: {allowed}")


def finite(name: str, value: Any, unit: str) -> None:
    """Refuse infinities and NaN."""
    require(name, value, np.isfinite(np.asarray(value, dtype=float)), f"finite numbers are allowed ({_in(unit)})")


def positive(name: str, value: Any, unit: str) -> None:
    """Refuse what is not finite and above zero."""
    array = np.asarray(value, dtype=float)
    holds = np.isfinite(array) & (array > 0.0)
    require(name, array, holds, f"a finite number with {name} > 0 is allowed ({_in(unit)})")


def not_negative(name: str, value: Any, unit: str) -> None:
    """Refuse what is not finite and at least zero."""
    array = np.asarray(value, dtype=float)
    holds = np.isfinite(array) & (array >= 0.0)
    require(name, array, holds, f"a finite number with {name} >= 0 is allowed ({_in(unit)})")


def whole(name: str, value: Any, highest: int) -> None:
    """Refuse what is not a whole number from 1 on."""
    array = np.asarray(value, dtype=float)
    holds = (array >= 1) & (array <= highest) & (array == np.floor(array)) & (np.asarray(value).dtype != bool)
    require(name, array, holds, f"a whole number with 1 <= {name} <= {highest} is allowed")


def _in(unit: str) -> str:
    return "dimensionless" if unit == "1" else f"in {unit}"
