"""Arguments that may be arrays are numbers in range, or are refused in one line."""

import pytest

from bristle_sim.theory.numbers import RANGES, checked_numbers, numbers, require


def test_numbers_that_no_machine_word_holds_are_numbers() -> None:
    """10^30 is a Python integer of 100 bits; no value at all (None) is nan, which rules refuse."""
    assert numbers("mass", 10**30, "must be real numbers") == 1e30
    with pytest.raises(ValueError, match=r"^mass = nan: must be above 0"):
        require("mass", None, numbers("mass", None, "") > 0.0, "must be above 0 (in kg)")


def test_every_range_of_the_table_is_one_with_its_reason() -> None:
    """A bound comes from physics or from rounding, and says from which."""
    for name, found in RANGES.items():
        assert found.key == name
        assert found.lowest < found.highest
        assert found.source.startswith(("physics", "rounding"))


def test_single_numbers_by_name() -> None:
    assert checked_numbers(rod_mass=2, rate=-1.0) == [2.0, -1.0]
    with pytest.raises(ValueError, match=r"^rate = \[1\.0\]: must be a finite number"):
        checked_numbers(rate=[1.0])  # type: ignore[arg-type]
