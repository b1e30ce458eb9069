"""Parameters of the comparison with measured impacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bristle_sim.parameters.force import Text
from bristle_sim.units import Declared, declared_field, described, quantity


def _file() -> Any:
    meaning = "measured impacts of an ellipse: MATLAB file with an array bounce_array"
    return declared_field(None, Text("data", "none: the file is its authors'", "file", meaning))


@described
@dataclass(frozen=True, slots=True)
class Measured(Declared):
    """The law that is compared with measured impacts, and the file of those that the user has."""

    tangential_compliance: float = quantity(
        1.15,
        "0 <= tangential_compliance <= 1e4",
        "stiffness of the contact along its normal over that along the surface, eta^2",
        "(2 - nu)/(2 (1 - nu)) with nu = 0.23, soda-lime glass and aluminium oxide (Stronge 2018, ch. 5)",
    )
    data: str | None = _file()
