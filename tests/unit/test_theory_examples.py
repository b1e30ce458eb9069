"""Examples in the docstrings of formulas, and of many passes."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

from bristle_sim import theory

MODULES = [
    *(module.name for module in pkgutil.iter_modules(theory.__path__, f"{theory.__name__}.")),
    *("bristle_sim.passes.ensemble", "bristle_sim.studies.limits"),
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_print_what_they_say(name: str) -> None:
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_the_impact_laws_have_examples() -> None:
    """Two of the energetic law, one of each other one, with a line that makes the impact before both of the first."""
    assert doctest.testmod(importlib.import_module("bristle_sim.theory.impact")).attempted == 6


def test_the_formulas_have_examples() -> None:
    """Each file of formulas that a user calls; the laws' inner files are tested against them."""
    without = {
        name.rpartition(".")[2]
        for name in MODULES
        if not doctest.testmod(importlib.import_module(name)).attempted
    }
    assert without <= {
        "crater_kinematics", "impact_arguments", "impact_compliance", "impact_phases",
        "impact_springs", "impact_stick", "numbers",
    }  # fmt: skip
