"""Impacts that pictures and films of them are drawn from, each computed once."""

from __future__ import annotations

import pytest

from bristle_sim.render.impact_film import ContactMotion, contact_motion
from bristle_sim.studies.impacts import Impacts
from impact_cases import bristle, rods


@pytest.fixture(scope="session")
def strike() -> Impacts:
    return bristle()


@pytest.fixture(scope="session")
def pendulum() -> Impacts:
    return rods()


@pytest.fixture(scope="session")
def strike_motion(strike: Impacts) -> ContactMotion:
    return contact_motion(strike.strikes["compliant"].contact)


@pytest.fixture(scope="session")
def pendulum_motion(pendulum: Impacts) -> ContactMotion:
    return contact_motion(pendulum.strikes["compliant"].contact)
