"""Inventories of the libraries that the pages refer to, written from the lists in ``docs/inventories``: no network is asked.

A list's first line is the address of the library's documentation; each further line is a name, its role and its page.
"""

import tempfile
import zlib
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.config import Config


def write_inventory(source: Path, target: Path) -> str:
    """Write the list of names as an inventory that intersphinx reads, and return the address of the documentation."""
    address, *lines = source.read_text(encoding="utf-8").split("\n")
    entries = [line.split() for line in lines if line.strip()]
    body = "".join(f"{name} py:{role} 1 {page} -\n" for name, role, page in entries)
    head = f"# Sphinx inventory version 2\n# Project: {source.stem}\n# Version: \n# The remainder of this file is compressed using zlib.\n"
    target.write_bytes(head.encode() + zlib.compress(body.encode()))
    return address


def _configure(app: Sphinx, config: Config) -> None:
    folder = Path(tempfile.mkdtemp())
    for source in sorted((Path(app.srcdir) / "inventories").glob("*.txt")):
        target = folder / f"{source.stem}.inv"
        config.intersphinx_mapping[source.stem] = (write_inventory(source, target), (str(target),))


def setup(app: Sphinx) -> dict[str, Any]:
    """Set the mapping before intersphinx checks it."""
    app.connect("config-inited", _configure, priority=1)
    return {"parallel_read_safe": True}
