"""Good arguments for every public function of the theory, from which one at a time is then spoilt."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

MODULES = ("impact",)
"""Modules of the theory whose functions are public and check their arguments."""

SAMPLES: dict[str, Any] = {"friction": 0.5, "restitution": 0.42, "restitution_friction": 0.3} | {
    "inverse_mass": np.array([[1.0, 0.2], [0.2, 2.0]]),
    "velocity": (-1.0, 0.5),
}
"""Samples by the arguments' names."""


def public_functions(module: str) -> list[Callable[..., Any]]:
    """Return the functions that a module of the theory defines for others."""
    loaded = importlib.import_module(f"bristle_sim.theory.{module}")
    found = (each for name, each in vars(loaded).items() if not name.startswith("_") and inspect.isfunction(each))
    return [each for each in found if each.__module__ == loaded.__name__]


def samples_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Return a good value for each of a function's numbers; optional ones only where there is a sample."""
    return {name: SAMPLES[name] for name in inspect.signature(function).parameters if name in SAMPLES}
