"""Access to the module that draws runs.

The module is in a higher layer; it is imported only when a picture is requested.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

DRAWN_BY = "bristle_sim.render.of_run"


@dataclass(frozen=True, slots=True)
class Html:
    """A piece of HTML that a notebook shows."""

    text: str

    def _repr_html_(self) -> str:
        return self.text


def drawn_by() -> ModuleType:
    """Return the module that draws runs; its functions are ``plot``, ``film``, ``view`` and
    ``summary_page``.
    """
    return import_module(DRAWN_BY)
