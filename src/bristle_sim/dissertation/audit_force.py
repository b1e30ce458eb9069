"""Audit of the force history (Zhang 2020, chapter 3)."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.dissertation.audit_impact import resultant_impulse
from bristle_sim.dissertation.audit_row import Found, half_unit
from bristle_sim.theory.crater_kinematics import COMPRESSION_TIME, IMPACT_ANGLE
from bristle_sim.theory.force_fit import fit_force_history
from bristle_sim.theory.force_history import (
    BALL,
    BRISTLE,
    PRINTED_BRISTLE_IMPULSE,
    TABLE_3_1,
    ForceCurve,
    segment_impulses,
)
from bristle_sim.theory.force_least_squares import ForceFit

BALL_TIME = 2.328e-3
"""t'_c as the dissertation rounds it, s (Zhang 2020, eq. 3.6)."""

IMPULSE_ROUNDING = half_unit("1.619e-3") / PRINTED_BRISTLE_IMPULSE
"""Relative rounding of the printed p_c."""


def force_figures() -> dict[str, Found]:
    """Figures of chapter 3."""
    return {**_ball(), **_impulse(), **_table(), **_bristle()}


def friction_for_impulse(impulse: float) -> float:
    """Friction with which p_c at gamma = 23.4 deg is the impulse (N s).

    The resultant makes arccot(mu) - gamma with the tip's path, along which the impulse is m v_C/3 whatever mu.
    """
    along = float(resultant_impulse(0.0)) * math.sin(IMPACT_ANGLE)
    return 1.0 / math.tan(IMPACT_ANGLE + math.acos(along / impulse))


def table_fit() -> ForceFit:
    """Fit of (3.3) to the forces of table 3.1, impulse over time at the middle of each segment, with F* = 60 N."""
    step = COMPRESSION_TIME / len(TABLE_3_1)
    time = step * (np.arange(len(TABLE_3_1)) + 0.5)
    force = 1e-4 * np.array(TABLE_3_1, dtype=float) / step
    return fit_force_history(time, force, duration=BRISTLE.duration, peak_force=2.0 * BRISTLE.swing, start=0.0)


def _ball() -> dict[str, Found]:
    exact = ForceCurve.of_impact(1.0, 0.0, 2.0 * BALL.swing, BALL.duration)
    impulse = float(BALL.impulse(BALL_TIME))
    excess = BALL.peak_force() / (2.0 * BALL.swing) - 1.0
    return {
        "eq. 3.5: constant part of the bracket": Found(exact.offset),
        "eq. 3.5: t_o from T = 0.006 s": Found(0.006 / 12.0),
        "eq. 3.6: time of the largest force": Found(BALL.peak_time()),
        "eq. 3.7: compressive impulse of the ball": Found(impulse, told=(impulse,)),
        "eq. 3.17: compressive impulse of the ball": Found(impulse),
        "sec. 3.1: peak force within 5 % of the measured one": Found(excess, abs(excess) < 0.05),
        "sec. 3.1: inflection point within 5 % of the raw data": Found(None, told=(1e3 * BALL.inflection_time(),)),
    }


def _impulse() -> dict[str, Found]:
    computed = float(resultant_impulse(0.31))
    friction = friction_for_impulse(PRINTED_BRISTLE_IMPULSE)
    return {
        "eq. 3.9: compressive impulse of the bristle": Found(
            computed, told=(friction, 1e3 * float(resultant_impulse(0.5)))
        ),
    }


def _table() -> dict[str, Found]:
    shares = 1e4 * segment_impulses(BALL, PRINTED_BRISTLE_IMPULSE, compression_time=BALL_TIME)
    rows = {
        f"table 3.1: impulse of segment {i}": Found(share, None, (rounded,), rounded)
        for i, share in enumerate(shares, start=1)
        for rounded in [share * IMPULSE_ROUNDING]
    }
    total = sum(float(each) for each in TABLE_3_1)
    return {
        **rows,
        "eq. 3.17: impulse of segment 1": Found(1e-4 * shares[0]),
        "eq. 3.18: fourth summand": Found(shares[3], told=(total,)),
        "eq. 3.18: sum of the segments": Found(1e-4 * total),
        "eq. 3.18: the normalized impulses add up to 1": Found(
            total / (1e4 * PRINTED_BRISTLE_IMPULSE), abs(total / (1e4 * PRINTED_BRISTLE_IMPULSE) - 1.0) < 5e-3
        ),
    }


def _bristle() -> dict[str, Found]:
    exact = ForceCurve.of_impact(1.0, 0.0, 2.0 * BRISTLE.swing, BRISTLE.duration)
    carried = float(BRISTLE.impulse(COMPRESSION_TIME))
    scaled = BALL.rescaled(PRINTED_BRISTLE_IMPULSE, COMPRESSION_TIME)
    shape = float(np.max(np.abs(segment_impulses(BRISTLE, 1.0) - segment_impulses(BALL, 1.0))))
    fit = table_fit()
    return {
        "eq. 3.19: constant part of the bracket": Found(exact.offset),
        "eq. 3.19: t_o from T = 0.00012 s": Found(0.00012 / 12.0),
        "eq. 3.19: amplitude c": Found(None, told=(fit.values[0], fit.values[1])),
        "eq. 3.19: decay lambda": Found(None, told=(fit.values[0], fit.values[1])),
        "eq. 3.20: compression time": Found(BRISTLE.peak_time()),
        "eq. 3.21: largest force": Found(BRISTLE.peak_force()),
        "eqs. 3.9, 3.19: impulse of the fitted curve": Found(
            carried,
            told=(1.0 - carried / PRINTED_BRISTLE_IMPULSE, BRISTLE.amplitude[0] * PRINTED_BRISTLE_IMPULSE / carried),
        ),
        "sec. 3.3: the two impacts are aligned in normalized time": Found(
            shape, shape < 1e-3, (shape, scaled.peak_force(), 1e6 * scaled.duration)
        ),
    }
