"""What was measured on and with, and the command that measures it again."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
from pathlib import Path
from typing import Any

from bristle_sim.benchmarks.accuracy_cost.measure import Effort

__all__ = ["PACKAGES", "installed", "machine", "surroundings"]

PACKAGES = ("bristle_sim", "pymunk", "numpy", "scipy", "mujoco", "exudyn", "pybullet")


def installed() -> set[str]:
    """The packages that can be imported."""
    return {name for name in PACKAGES if importlib.util.find_spec(name) is not None}


def machine(effort: Effort) -> dict[str, Any]:
    """Processor, system, load, versions and command, as plain values."""
    return {
        **surroundings(),
        "clock": f"process CPU time, the least of {effort.rounds} interleaved rounds",
        "command": f"python scenarios/accuracy_cost.py --set effort={effort.effort} --set peers={effort.peers}",
    }


def surroundings() -> dict[str, Any]:
    """Processor, system, load and versions, whatever is measured."""
    here = installed()
    versions = {name: importlib.metadata.version(name) for name in PACKAGES if name in here}
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "versions": {"python": platform.python_version(), **versions},
    }


def _processor() -> str:
    """The processor's name where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())
