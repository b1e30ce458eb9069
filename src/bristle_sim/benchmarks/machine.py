"""The machine of a measurement: processor, system, load and the versions of the packages."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
from pathlib import Path
from typing import Any

PACKAGES = ("bristle_sim", "pymunk", "numpy", "scipy", "mujoco", "heyoka")


def installed() -> set[str]:
    """Return those of the packages that can be imported."""
    return {name for name in PACKAGES if importlib.util.find_spec(name) is not None}


def surroundings() -> dict[str, Any]:
    """Return processor, system, load and versions."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "versions": {
            "python": platform.python_version(),
            **{name: _version(name) for name in PACKAGES if name in installed()},
        },
    }


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def _processor() -> str:
    """Return the processor's name where the system states it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())
