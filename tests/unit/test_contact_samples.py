"""Samples between those of a contact's intervals lie on the contact's course: a half wave, known in closed form."""

import math

import numpy as np
import pytest

from bristle_sim.scene.contact.contact_samples import with_samples_between

MASS = np.array([[2.0, -0.5], [-0.5, 3.0]])
STIFFNESS, FRICTION = 5.0, 0.4
DRIVE = MASS[0, 0] - FRICTION * MASS[0, 1]
RATE = math.sqrt(STIFFNESS * DRIVE)


def slipping(time: np.ndarray) -> np.ndarray:
    """A contact that slips throughout: T = -mu N, d v_n/dt = (K_nn - mu K_nt) N, d v_t/dt = (K_nt - mu K_tt) N."""
    depth, speed = np.sin(RATE * time) / RATE, -np.cos(RATE * time)
    normal = STIFFNESS * depth
    tangential_speed = 4.0 + (MASS[1, 0] - FRICTION * MASS[1, 1]) / DRIVE * (speed + 1.0)
    return np.stack([time, normal, -FRICTION * normal, depth, speed, tangential_speed], axis=1)


@pytest.mark.parametrize("pieces", [2, 4, 8])
def test_half_a_wave(pieces: int) -> None:
    """The quintic's error is below h^6/46080 of the sixth derivative, in units of the wave; five times that for slopes."""
    coarse = slipping(np.linspace(0.0, 0.5 * math.pi / RATE, pieces + 1))
    fine = with_samples_between(coarse, MASS)
    assert len(fine) == 3 * pieces + 1
    assert np.all(np.diff(fine[:, 0]) > 0.0)
    allowed = (0.5 * math.pi / pieces) ** 5 / 46080.0 * 6.0
    exact = slipping(fine[:, 0])
    np.testing.assert_allclose(fine, exact, rtol=0.0, atol=allowed * np.abs(exact).max())


def test_given_samples_stay() -> None:
    coarse = slipping(np.linspace(0.0, 1.0, 5))
    np.testing.assert_array_equal(with_samples_between(coarse, MASS)[::3], coarse)


def test_nothing_between_two_phases() -> None:
    """Two samples at one instant, on both sides of a turn of slip, whose friction differs."""
    before = slipping(np.linspace(0.0, 0.4, 3))
    after = slipping(np.linspace(0.4, 0.6, 2)) * (1.0, 1.0, -1.0, 1.0, 1.0, 1.0)
    every = with_samples_between(np.concatenate([before, after]), MASS)
    assert len(every) == 7 + 4
    assert every[6, 2] == -every[7, 2]
    assert np.isfinite(every).all()


def test_rounding_between_two_sides_of_an_instant_is_no_speed() -> None:
    """An instant found twice, 1e-9 of the contact apart, with positions rounded: no sample between has a speed of 0.1."""
    coarse = slipping(np.array([0.0, 0.2, 0.4, 0.4 + 6e-10, 0.6]))
    coarse[3, 3] = coarse[2, 3] + 1e-10
    every = with_samples_between(coarse, MASS)
    assert len(every) == 2 * 3 + 1 + 3 + 1
    # The wave's highest speed is 1.
    assert np.abs(every[:, 4]).max() <= 1.0


def test_a_contact_that_has_no_force() -> None:
    """At the knife edge of a jam nothing changes from one sample to the next."""
    still = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0, 0.0, 1.0]])
    every = with_samples_between(still, MASS)
    np.testing.assert_array_equal(every[:, 1:], np.broadcast_to(still[0, 1:], (4, 5)))
