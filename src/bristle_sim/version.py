"""Version of this package, and commit of its source."""

import functools
from pathlib import Path

__version__ = "0.1.0"


@functools.cache
def commit() -> str:
    """Return the git commit of this package's source; empty if it is unknown.

    The commit is read from the checkout, or from a file in the installed distribution. For a
    modified checkout the text ends in ``-dirty``.
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
    except (OSError, subprocess.SubprocessError):  # no git, or the checkout has another owner
        return ""


def named_commit() -> dict[str, str]:
    """Return a dictionary with the entry ``commit`` for JSON output.

    The dictionary is empty if the commit is unknown.
    """
    return {"commit": commit()} if commit() else {}
