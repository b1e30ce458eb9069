"""Coefficients at the ends of their ranges keep their promises."""

import pytest

from bristle_sim.studies.hard_cases.case import HardCase
from bristle_sim.studies.hard_cases.limits import cases


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached
