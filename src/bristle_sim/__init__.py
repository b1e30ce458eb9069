"""Simulation of a bristle-blasting tool, and comparison with the formulas of a dissertation.

Simulate one pass of a bristle at the dissertation's operating point, and print its strike on the
workpart:

>>> import bristle_sim as bs
>>> tool = bs.Tool(workpart=bs.Workpart(friction=0.31, restitution=0.42))
>>> run = bs.simulate(tool, bs.Settings(accuracy=1e-6))
>>> strike = run.first_contact("workpart")
>>> print(f"{strike.outcome} at {1e3 * strike.time:.2f} ms, impulse {1e3 * strike.impulse[0]:.2f} mN s")
rebound at 4.53 ms, impulse 2.75 mN s

The names that this module exports keep their meaning from version to version; all other names may
change. Each name is imported when it is first used, so a program that needs only the impact law
does not load the physics engine pymunk.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle_sim.cli.explore.entry import explore
    from bristle_sim.contact_space.collision_rule import LocatedImpact
    from bristle_sim.contact_space.energetic_contact import EnergeticContact
    from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Surface, Tool, Workpart
    from bristle_sim.passes.ensemble import ensemble
    from bristle_sim.passes.result import Ensemble
    from bristle_sim.reference import simulate_reference
    from bristle_sim.scene.simulate import simulate, simulate_row
    from bristle_sim.scene.snapshots import ContactState, Snapshot, snapshots
    from bristle_sim.settings import Settings, StopReason
    from bristle_sim.studies.design import Design, design
    from bristle_sim.studies.limits import limits
    from bristle_sim.studies.surface import BlastedSurface, surface
    from bristle_sim.studies.sweep import sweep
    from bristle_sim.theory.impact import energetic_impact, newton_impact, poisson_impact
    from bristle_sim.theory.impact_phases import Impact
    from bristle_sim.tool_file import read_tool, write_tool
    from bristle_sim.trajectory import (
        ContactHistory,
        ContactRecord,
        Cost,
        Event,
        Motion,
        Trajectory,
        WireMotion,
    )
    from bristle_sim.trajectory.pictures import Html
    from bristle_sim.version import __version__

__all__ = [
    "Bar", "Belt", "BlastedSurface", "Bristle", "Contact", "ContactHistory", "ContactRecord", "ContactState", "Cost", "Design",
    "EnergeticContact", "Ensemble", "Event", "Html", "Hub", "Impact", "LocatedImpact", "Motion", "Settings",
    "Snapshot", "StopReason", "Surface", "Tool", "Trajectory", "WireMotion", "Workpart", "__version__",
    "design", "energetic_impact", "ensemble", "explore", "limits", "newton_impact", "poisson_impact",
    "read_tool", "simulate", "simulate_reference", "simulate_row", "snapshots", "surface", "sweep", "write_tool",
]  # fmt: skip

_MODULES = {
    "BlastedSurface": "studies.surface",
    "ContactHistory": "trajectory",
    "ContactRecord": "trajectory",
    "ContactState": "scene.snapshots",
    "Cost": "trajectory",
    "Design": "studies.design",
    "EnergeticContact": "contact_space.energetic_contact",
    "Ensemble": "passes.result",
    "Event": "trajectory",
    "Html": "trajectory.pictures",
    "Impact": "theory.impact_phases",
    "LocatedImpact": "contact_space.collision_rule",
    "Motion": "trajectory",
    "Settings": "settings",
    "Snapshot": "scene.snapshots",
    "StopReason": "settings",
    "Trajectory": "trajectory",
    "WireMotion": "trajectory",
    "__version__": "version",
    "design": "studies.design",
    "energetic_impact": "theory.impact",
    "ensemble": "passes.ensemble",
    "explore": "cli.explore.entry",
    "limits": "studies.limits",
    "newton_impact": "theory.impact",
    "poisson_impact": "theory.impact",
    "read_tool": "tool_file",
    "simulate": "scene.simulate",
    "simulate_reference": "reference",
    "simulate_row": "scene.simulate",
    "snapshots": "scene.snapshots",
    "surface": "studies.surface",
    "sweep": "studies.sweep",
    "write_tool": "tool_file",
}
"""Module, within this package, that defines each public name; public names not listed here are in
``parameters``."""


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    try:
        value = getattr(import_module(f"{__name__}.{_MODULES.get(name, 'parameters')}"), name)
    except ModuleNotFoundError as error:
        if name != "sweep":
            raise
        return _sweep_without_extra(error)
    globals()[name] = value
    return value


def _sweep_without_extra(error: ModuleNotFoundError) -> Any:
    """Return the function that replaces ``sweep`` if its optional dependencies are not installed.

    A call raises an ImportError that names the missing extra and quotes ``error``. Because the name
    ``sweep`` exists, ``help`` and star imports work without the extra.
    """

    def sweep(*_: Any, **__: Any) -> Any:
        """Evaluate a function at many points; needs the extra: pip install 'bristle_sim[sweep]'."""
        raise ImportError(
            f"bristle_sim.sweep: {error}; pip install 'bristle_sim[sweep]'"
        ) from error

    return sweep


def __dir__() -> list[str]:
    return sorted(__all__)
