"""Arguments that may be arrays are numbers in range, or are refused in one line."""

import numpy as np
import pytest

from bristle_sim.theory import checks
from bristle_sim.theory.checks import RANGES, checked_arguments, checked_numbers


def test_numbers_that_no_machine_word_holds_are_numbers() -> None:
    """10^30 is a Python integer of 100 bits; no value at all (None) is refused like nan."""
    for check in (checks.finite, checks.positive):
        check("mass", 10**30, "kg")
        with pytest.raises(ValueError, match=r"^mass = "):
            check("mass", None, "kg")


@pytest.mark.parametrize("value", [0, 51, 1.5, True, 10**30, [2, 3]])
def test_whole_numbers_in_a_range(value: object) -> None:
    """True is no number here, although Python counts it as 1."""

    @checked_arguments
    def first(modes: "int") -> int:
        return modes

    assert first(np.float64(50.0)) == 50  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"^modes = .*must be a (whole number from 1 to 50|single number)"):
        first(value)  # type: ignore[arg-type]


def test_every_range_of_the_table_is_one_with_its_reason() -> None:
    """A bound comes from physics or from rounding, and says from which."""
    for name, found in RANGES.items():
        assert found.key == name
        assert found.lowest < found.highest
        assert found.source.startswith(("physics", "rounding"))


def test_arguments_are_found_by_their_names() -> None:
    @checked_arguments
    def product(mass: float, other: object = abs) -> tuple[object, ...]:
        return mass, other

    assert product(2) == (2.0, abs)  # the table knows no other
    assert product(2.0, sum) == (2.0, sum)
    with pytest.raises(
        ValueError, match=r"^mass = 0\.0: must be a finite number with 1e-30 <= mass <= 1e\+06 \(in kg\)$"
    ):
        product(0.0)


def test_single_numbers_by_name() -> None:
    assert checked_numbers(rod_mass=2, rate=-1.0) == [2.0, -1.0]
    with pytest.raises(ValueError, match=r"^rate = \[1\.0\]: must be a finite number"):
        checked_numbers(rate=[1.0])  # type: ignore[arg-type]
