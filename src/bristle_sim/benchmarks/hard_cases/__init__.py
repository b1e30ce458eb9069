"""Hard cases: tables of trials and promises, the measures that they share, and the report of the results.

Which cases are tried is declared here, so that the command line answers before an engine is loaded.
"""

from __future__ import annotations

from dataclasses import dataclass

from bristle_sim.units import Declared, choice

THEMES = (
    *(
        "mass_ratio",
        "belt_stiffness",
        "damping",
        "jam",
        "grazing",
        "hub_speed",
        "tunnelling",
        "long_run",
        "chatter",
    ),
    *("touching", "wires", "size", "budget"),
)
"""Kinds of hard cases, each the name of the function that yields its cases."""


@dataclass(frozen=True, slots=True)
class HardCaseChoice(Declared):
    """The cases to try."""

    theme: str = choice(
        "theme: kind of hard case that is tried [chosen: every theme]", "all", *THEMES
    )
    effort: str = choice(
        "effort: how much is tried: quick leaves out long cases [chosen: all cases]",
        "full",
        "quick",
    )
