"""Hard cases: difficult simulations with the conditions ("promises") that their results must
satisfy, and the report of the results.

The choice of cases is declared here, so that the command line can refuse bad input before it loads
an engine.
"""

from __future__ import annotations

from dataclasses import dataclass

from bristle_sim.declared import Declared
from bristle_sim.fields import choice

THEMES = (
    "mass_ratio",
    "belt_stiffness",
    "damping",
    "jam",
    "grazing",
    "hub_speed",
    "tunnelling",
    "long_run",
    "chatter",
    "touching",
)
"""Kinds of hard cases; each name is also that of the function that yields the cases."""


@dataclass(frozen=True, slots=True)
class HardCaseChoice(Declared):
    """Choice of the theme whose numerically hard cases are run; by default all themes."""

    theme: str = choice(
        "theme: kind of hard case that is tried [chosen: every theme]", "all", *THEMES
    )
