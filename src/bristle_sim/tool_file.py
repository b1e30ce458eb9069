"""Reading and writing of a tool as a TOML file.

The file has the keys of the option ``--set``, each with its meaning and source in a comment. A
value is a text with a unit, such as ``"27 mm"``, or a number in SI units, or in degrees if the key
ends in ``_deg``. ``bar = false`` leaves out the bar. An omitted key has its default.
"""

import json
import textwrap
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bristle_sim.declared import Computed, Declaration, Range
from bristle_sim.files import complete_or_absent, named_path
from bristle_sim.parameters import FIELDS, KEYS, Tool
from bristle_sim.parameters.tool import checked_tool
from bristle_sim.units import exact_text, likely_key, shown

MAY_BE_ABSENT = ("bar", "workpart")


def read_keys(path: str | Path, further: Iterable[str] = ()) -> dict[str, Any]:
    """Return the keys and values of a parameter file, without a check of the values.

    Args:
        path: name of the file.
        further: keys that may be in the file besides the keys of the tool.

    Returns:
        Values by key, each a text or a number. The name of a part that the file declares absent has
        the value False.

    Raises:
        ValueError: in one line, for a file that is not TOML, an unknown key, or a table.
        OSError: for a file that cannot be read.
    """
    content = named_path(path).read_bytes()
    try:
        found = tomllib.loads(
            content.decode("utf-8-sig")
        )  # some editors write a byte order mark first
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path}: must be a TOML file ({error})") from error
    known = {*KEYS, *further}
    typed = dict[str, Any]()
    for key, value in found.items():
        if isinstance(value, dict):
            raise ValueError(f"{path}: [{key}]: must have no tables, but one line for each key")
        if key in MAY_BE_ABSENT:
            if value is not False:
                raise ValueError(
                    f"{path}: {key} = {shown(value)}: must be false, where the tool has none"
                )
        elif key not in known:
            raise ValueError(f"{path}: unknown key {shown(key)}; {likely_key(key, known)}")
        typed[key] = value
    return typed


def read_tool(path: str | Path) -> Tool:
    """Read a tool from a TOML file; an omitted key has its default.

    Raises:
        ValueError: in one line, for a file that is not TOML, an unknown key, or a value out of
            range.
        OSError: for a file that cannot be read.
    """
    typed = read_keys(path)
    absent = {part: None for part in MAY_BE_ABSENT if part in typed}
    idle = {*absent, *(each.key for part in absent for each in FIELDS[part].values())}
    try:
        return Tool().replace(
            **absent, **{key: value for key, value in typed.items() if key not in idle}
        )
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def write_tool(tool: Tool, path: str | Path) -> None:
    """Write a tool to a TOML file with a comment for each key.

    ``read_tool`` reads back exactly the same values.

    Raises:
        ValueError: if ``tool`` is not a Tool.
        OSError: if the file cannot be written; the message names the file.
    """
    tool = checked_tool(tool)
    lines = [
        '# A tool of bristle_sim. A text carries its unit: "27 mm"; a bare number is in SI units, or in degrees in keys with _deg.'
    ]
    for part, fields in FIELDS.items():
        owner = getattr(tool, part) if part else tool
        lines += ["", f"# The {part}."] if part else []
        if owner is None:
            lines.append(f"{part} = false  # absent")
            continue
        for name, declared in fields.items():
            lines += _entry(declared, getattr(owner, name))
    with complete_or_absent(named_path(path)) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _entry(declared: Declaration, value: Any) -> list[str]:
    """Return the lines of a file for one key: comment and value.

    If the value is absent or computed from other keys, its line is also a comment.
    """
    words = f"{declared.meaning} (default: {declared.source})"
    comment = textwrap.wrap(words, 116, initial_indent="# ", subsequent_indent="#   ")
    if isinstance(value, Computed | None):
        return [*comment, f"# {declared.key} = none"]
    if isinstance(declared, Range) and declared.unit != "1":
        value = exact_text(value, declared.key, declared.unit)
    return [*comment, f"{declared.key} = {json.dumps(value)}"]
