"""Description of the machine on which a measurement runs: processor, system, load and package
versions.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
from pathlib import Path
from typing import Any

PACKAGES = ("bristle_sim", "pymunk", "numpy", "scipy", "mujoco", "heyoka")


def installed() -> set[str]:
    """Return the names of the packages in ``PACKAGES`` that are installed."""
    return {name for name in PACKAGES if importlib.util.find_spec(name) is not None}


def surroundings() -> dict[str, Any]:
    """Return a description of the computer and its software.

    Its keys are processor, number of cores, system, load average and package versions.
    """
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
    """Return the name of the processor or, if it is not available, the computer's architecture."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())
