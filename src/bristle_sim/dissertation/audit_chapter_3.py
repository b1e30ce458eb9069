"""Figures of the printed numbers and statements of chapter 3 (Zhang 2020)."""

from __future__ import annotations

import math

import numpy as np

from bristle_sim.dissertation.audit_chapter_2 import resultant_impulse
from bristle_sim.dissertation.printed import Figure, Figures
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

# The force history, chapter 3.

BALL_TIME = 2.328e-3
"""t'_c as the dissertation rounds it, s (Zhang 2020, eq. 3.6)."""

IMPULSE_ROUNDING = 0.5e-6 / PRINTED_BRISTLE_IMPULSE
"""Relative rounding of the printed p_c."""

BRISTLE_AMPLITUDE = BRISTLE.amplitude[0]

segments = 1e4 * segment_impulses(BALL, PRINTED_BRISTLE_IMPULSE, compression_time=BALL_TIME)
table_sum = sum(float(each) for each in TABLE_3_1)
rescaled = BALL.rescaled(PRINTED_BRISTLE_IMPULSE, COMPRESSION_TIME)
table_fit = fit_force_history(
    COMPRESSION_TIME / len(TABLE_3_1) * (np.arange(len(TABLE_3_1)) + 0.5),
    1e-4 * np.array(TABLE_3_1, dtype=float) / (COMPRESSION_TIME / len(TABLE_3_1)),
    duration=BRISTLE.duration,
    peak_force=2.0 * BRISTLE.swing,
    start=0.0,
)
"""Fit of (3.3) to the forces of table 3.1, impulse over time at the middle of each segment, with F* = 60 N."""


def force_history_figures() -> Figures:
    """Return the figures of the force history, chapter 3."""
    return {
        "eq. 3.5: constant part of the bracket": Figure(
            ForceCurve.of_impact(1, 0, 2 * BALL.swing, BALL.duration).offset
        ),
        "eq. 3.5: t_o from T = 0.006 s": Figure(0.006 / 12),
        "eq. 3.5: amplitude c": Figure(None),
        "eq. 3.5: decay lambda": Figure(None),
        "eq. 3.6: time of the largest force": Figure(BALL.peak_time()),
        "eq. 3.7: compressive impulse of the ball": Figure(x := BALL.impulse(BALL_TIME), x),
        "eq. 3.17: compressive impulse of the ball": Figure(BALL.impulse(BALL_TIME)),
        "sec. 3.1: peak force within 5 % of the measured one": Figure(
            x := BALL.peak_force() / (2 * BALL.swing) - 1, holds=abs(x) < 0.05
        ),
        "sec. 3.1: inflection point within 5 % of the raw data": Figure(None, 1e3 * BALL.inflection_time()),
        "eq. 3.9: compressive impulse of the bristle": Figure(
            resultant_impulse(0.31),
            1
            / math.tan(
                IMPACT_ANGLE + math.acos(resultant_impulse(0) * math.sin(IMPACT_ANGLE) / PRINTED_BRISTLE_IMPULSE)
            ),
            1e3 * resultant_impulse(0.5),
        ),
        "table 3.1: impulse of segment 1": Figure(x := segments[0], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 2": Figure(x := segments[1], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 3": Figure(x := segments[2], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 4": Figure(x := segments[3], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 5": Figure(x := segments[4], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 6": Figure(x := segments[5], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 7": Figure(x := segments[6], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 8": Figure(
            x := segments[7], x * IMPULSE_ROUNDING, allowance=x * IMPULSE_ROUNDING
        ),
        "table 3.1: impulse of segment 9": Figure(x := segments[8], allowance=x * IMPULSE_ROUNDING),
        "table 3.1: impulse of segment 10": Figure(x := segments[9], allowance=x * IMPULSE_ROUNDING),
        "eq. 3.17: impulse of segment 1": Figure(0.0001 * segments[0]),
        "eq. 3.18: fourth summand": Figure(segments[3], table_sum),
        "eq. 3.18: sum of the segments": Figure(0.0001 * table_sum),
        "eq. 3.18: the normalized impulses add up to 1": Figure(
            x := table_sum / (1e4 * PRINTED_BRISTLE_IMPULSE), holds=abs(x - 1) < 0.005
        ),
        "eq. 3.19: constant part of the bracket": Figure(
            ForceCurve.of_impact(1, 0, 2 * BRISTLE.swing, BRISTLE.duration).offset
        ),
        "eq. 3.19: t_o from T = 0.00012 s": Figure(0.00012 / 12),
        "eq. 3.19: amplitude c": Figure(None, *tuple(table_fit.values)),
        "eq. 3.19: decay lambda": Figure(None, *tuple(table_fit.values)),
        "eq. 3.20: compression time": Figure(BRISTLE.peak_time()),
        "eq. 3.21: largest force": Figure(BRISTLE.peak_force()),
        "eqs. 3.9, 3.19: impulse of the fitted curve": Figure(
            x := BRISTLE.impulse(COMPRESSION_TIME),
            1 - x / PRINTED_BRISTLE_IMPULSE,
            BRISTLE_AMPLITUDE * PRINTED_BRISTLE_IMPULSE / x,
        ),
        "sec. 3.3: the two impacts are aligned in normalized time": Figure(
            x := np.max(np.abs(segment_impulses(BRISTLE, 1) - segment_impulses(BALL, 1))),
            x,
            rescaled.peak_force(),
            1e6 * rescaled.duration,
            holds=x < 0.001,
        ),
    }
