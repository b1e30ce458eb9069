"""What sweeps compute in tests, in a module of its own: what else a test needs is not imported by workers."""

import math
import os
import signal
import time
from pathlib import Path
from typing import Any


def power(x: float, y: float) -> dict[str, Any]:
    """A number and a small array."""
    return {"power": x**y, "pair": (x, y)}


def counted(
    x: float, folder: str, pause: float = 0.0, killed_at: float = math.nan, times: int = 1
) -> float:
    """x squared, noted in a file; kills its process where told, a number of times over all processes."""
    deaths = len(list(Path(folder).glob("death*")))
    if x == killed_at and deaths < times:
        Path(folder, f"death{deaths}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(pause)
    descriptor = os.open(f"{folder}/calls", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.write(descriptor, f"{x}\n".encode())
    os.close(descriptor)
    return x**2
