"""The version of this package, and the commit that its source stands at."""

import functools
from pathlib import Path

__version__ = "0.1.0"


@functools.cache
def commit() -> str:
    """Return the commit of the checkout, or of the distribution's source; empty where neither is known.

    The commit of a modified checkout ends in ``-dirty``.
    """
    package = Path(__file__).parent
    built = package / "commit.txt"
    checkout = package.parents[1]
    if built.is_file():
        return built.read_text(encoding="utf-8").strip()
    if not (checkout / ".git").exists():
        return ""
    import subprocess

    describe = [
        "git",
        "-C",
        str(checkout),
        "describe",
        "--always",
        "--dirty",
        "--abbrev=12",
        "--exclude=*",
    ]
    try:
        return subprocess.run(
            describe, capture_output=True, text=True, check=True, timeout=10.0
        ).stdout.strip()
    except (OSError, subprocess.SubprocessError):  # without git, or not its owner
        return ""


def named_commit() -> dict[str, str]:
    """Return the commit as an entry of a JSON object; an empty mapping if it is not known."""
    return {"commit": commit()} if commit() else {}
