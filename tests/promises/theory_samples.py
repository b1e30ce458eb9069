"""Good arguments for every public function of the theory, from which one at a time is then spoilt."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.theory.force_history import BRISTLE
from bristle_sim.theory.merchant import PRINTED_ANGLES

MODULES = (
    "cueing",
    "monofilament",
    "pendulums",
    "impact",
    "merchant",
    "force_history",
    "force_fit",
    "crater",
    "crater_cutting",
)
"""Modules of the theory with functions that take numbers."""

RAMP = np.linspace(0.0, 1.0, 6)
TIMES = np.linspace(0.0, 1e-4, 12)[1:-1]

TOOL: dict[str, Any] = (
    {"hub_radius": 0.0275, "length": 0.027, "penetration": 0.0045, "bar_reach": 0.0047}
    | {"bar_horizontal": 0.05037, "bar_vertical": 0.0225, "distance": 0.055, "direction": 1.15, "retraction": 0.7}
    | {"hub_speed": 261.8, "speed_ratio": 3.23, "natural_rate": 1000.0, "stiffness": 0.0235, "centrifugal": 2e-3}
    | {
        "mass": 8.4e-5,
        "inertia": 2e-8,
        "damping_ratio": 0.1,
        "speed_share": 0.9,
        "relative_speed": 870.0,
    }
)
IMPACTS: dict[str, Any] = (
    {"tip_speed": 30.0, "impact_angle": 0.4, "impulse": 1e-3, "friction": 0.5, "restitution": 0.42}
    | {"restitution_friction": 0.3, "inverse_mass": np.array([[1.0, 0.2], [0.2, 2.0]]), "velocity": (-1.0, 0.5)}
    | {"rod_mass": 5.0, "mass_ratio": 1.0, "rod_length": 1.0, "angle_1": 0.35, "angle_2": 0.5}
    | {"rate": -800.0, "rate_1": -0.1, "rate_2": -0.2}
)
CRATERS: dict[str, Any] = (
    {"slope": 0.1, "rake": 0.5, "width": 5e-4, "force": 30.0}
    | {"shear_yield_stress": 1.2e8, "depth": 1e-4, "path": 1e-4, "energy": 1e-3, "specific_energy": 1e9}
    | {"cutting_force": 30.0, "speed": 30.0, "effective_mass": 3e-5, "plies": 20, "compression_time": 5e-5}
    | {"time": 1e-5, "decay": 92400.0, "segments": 10}
)
SAMPLES = TOOL | IMPACTS | CRATERS
"""Samples by the arguments' names."""

OWN: dict[str, dict[str, Any]] = {
    "fit_force_history": {"time": TIMES, "force": BRISTLE(TIMES), "duration": 1e-4, "peak_force": 60.0}
    | {"start": 0.0},
    "constant_for_crater_depth": {"depth": 1e-4},
    "friction_for_crater_depth": {"depth": 1.6e-4},
    "crater_depth_from_contact": {
        "time": RAMP * 5e-5,
        "normal_force": RAMP * 50.0,
        "tangential_force": RAMP * 15.0,
        "penetration": RAMP * 1e-4,
        "normal_velocity": (RAMP - 1.0) * 10.0,
        "tangential_velocity": (RAMP - 1.0) * -20.0,
    },
}
"""Samples of functions whose arguments of these names are something else."""

WHOLE: dict[str, Any] = {"tool": Tool(), "curve": BRISTLE, "angles": PRINTED_ANGLES}
"""Arguments that are no numbers; not spoilt."""


def public_functions(module: str) -> list[Callable[..., Any]]:
    """Return the functions that a module of the theory defines for others."""
    loaded = importlib.import_module(f"bristle_sim.theory.{module}")
    found = (each for name, each in vars(loaded).items() if not name.startswith("_") and inspect.isfunction(each))
    return [each for each in found if each.__module__ == loaded.__name__]


def samples_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Return a good value for each of a function's numbers; optional ones only where there is a sample."""
    own, found = OWN.get(function.__name__, {}), {}
    for name, parameter in inspect.signature(function).parameters.items():
        if name in own or name in SAMPLES:
            # Another function's argument of the name may be a curve: then it has a default that is no number.
            if name in own or not callable(parameter.default) or parameter.default is inspect.Parameter.empty:
                found[name] = own.get(name, SAMPLES.get(name))
        elif parameter.default is inspect.Parameter.empty:
            found[name] = WHOLE[name]
    return found
