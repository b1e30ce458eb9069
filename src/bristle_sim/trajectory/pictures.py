"""Access to the module that draws runs.

That module is in a higher layer of the package; it is imported only when a picture is requested.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

DRAWN_BY = "bristle_sim.render.of_run"


@dataclass(frozen=True, slots=True)
class Html:
    """HTML text that a notebook displays."""

    text: str

    def _repr_html_(self) -> str:
        return self.text


def drawn_by() -> ModuleType:
    """Return the module that draws runs; it provides ``plot``, ``film``, ``view`` and
    ``summary_page``.
    """
    return import_module(DRAWN_BY)
