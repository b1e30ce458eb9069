"""Free motion, integrated with scipy's DOP853 (Hairer, Norsett and Wanner 1993, order 8 with dense output)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from bristle_sim.reference.mechanics import Mechanics, Motion, State

__all__ = ["Step", "flight_steps"]


class Step(NamedTuple):
    """A step of the integrator with its dense output; ``evaluations`` counts right-hand sides since the last one."""

    motion: Motion
    start: float
    end: float
    evaluations: int


def flight_steps(mechanics: Mechanics, state: State, end: float, tolerance: float) -> Iterator[Step]:
    """Steps from a state up to a time, none longer than a radian of the fastest motion.

    Raises:
        RuntimeError: if the integrator cannot meet its tolerance.
    """
    if state.time >= end:
        return
    fastest = mechanics.fastest_rate
    solver = DOP853(
        mechanics.right_hand_side,
        state.time,
        np.array(state[1:]),
        end,
        max_step=1.0 / fastest if fastest else np.inf,
        rtol=tolerance,
        atol=tolerance * np.array([1.0, max(fastest, abs(state.rate))]),
    )
    counted = 0
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            raise RuntimeError(f"integration failed at {solver.t:g} s: {message}")
        motion = solver.dense_output()
        yield Step(motion, solver.t_old, solver.t, solver.nfev - counted)
        counted = solver.nfev
