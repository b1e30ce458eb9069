"""The audit: its verdicts, and a second value of every figure that differs from print.

The values were worked out from the dissertation's formulas with numpy and scipy alone: by closed forms, adaptive quadrature,
Richardson's extrapolation of the sums over plies, and an integration of the pass with another engine.
"""

import functools
import math

import numpy as np
import pytest

from bristle_sim.dissertation.audit import (
    DIFFERS,
    NOT_COMPUTABLE,
    REPRODUCED,
    AuditView,
    audit_report,
    audit_row,
    audit_rows,
    half_unit,
)
from bristle_sim.dissertation.printed import Figure, Printed


@functools.cache
def audited():
    """The rows of the audit, computed once."""
    return audit_rows()


def rows_by_place():
    return {row.where: row for row in audited()}


OMEGA = 261.8
RADIUS = 0.0275
LENGTH = 0.027
MASS = 8.387e-5
GAMMA = math.radians(23.4)
INERTIA = MASS * LENGTH**2 / 3
THETA = math.radians(44.5)
END = 5e-5
DECAY = 92400.0
PLAIN_RATE = math.sqrt(math.degrees(0.00041) / INERTIA)

COMPUTED = {
    "eq. 2.33: speed ratio R": THETA * PLAIN_RATE / OMEGA,
    "eq. 2.2: belt stiffness k_T": INERTIA * (845.6 / THETA) ** 2,
    "fig. 1.5: natural frequency": PLAIN_RATE / (2 * math.pi),
    # (2.1) for a quarter period on the belt alone, from the printed distance of the bar.
    "eq. 2.3: bar position S_H": 50.9410279,
    "eq. 2.3: bar position S_V": 21.1754238,
    "sec. 2.2: design forecast within 5 %": 1 - 21.1754238 / 22.5,
    # m v_C/(3 (sin(gamma) + mu cos(gamma))) at 15 to 30 degrees: its span over its mean.
    "fig. 2.7: p_cy converges to a common value as friction approaches 1": 0.109625675,
    "sec. 5.1: elevated friction leads to the greatest compressive impulse": 0.550411174,
    "sec. 2.3.2: tangential work is one order of magnitude greater than normal work": 0.31
    / math.tan(GAMMA),
    "fig. 2.22: equal or different friction makes minimal distinction": 0.363935628,
    "above eq. 2.51: in our model L = r_h": 55 / 54,
    # Quadratures of (3.5) and (3.19), letter by letter.
    "eq. 3.7: compressive impulse of the ball": 0.462875655,
    "eq. 3.9: compressive impulse of the bristle": 1.28949243e-3,
    "eq. 3.18: fourth summand": 1.17739213,
    "eqs. 3.9, 3.19: impulse of the fitted curve": 1.61156693e-3,
    "sec. 3.3: the two impacts are aligned in normalized time": 4.93794899e-3,
    "fig. 4.3: excursion at 50 us": 325 * (1 - math.exp(-DECAY * END)),
    "eq. 4.6: initial rate": 1111 - 266.65,
    "eq. 4.7: v_G at rest": RADIUS * OMEGA / 2,
    # Richardson's extrapolation in powers of 1/sqrt(n) of sums over 1e5 to 1.6e6 plies, with the rounded angles.
    "sec. 4.2.2: the depth is converged at n = 300": 142.277121,
    # Three coefficients from three values of the energy.
    "eq. 4.59: coefficient of exp(-lambda t)": 3.03843606e-3,
    "eq. 4.59: constant": 7.29152571e-4,
    "fig. 4.19: crater depth by work and energy": 9.64834898e-3,
    "sec. 4.3: the energy estimate converges": 1.37537299,
    "eqs. 4.54, 4.59: the work of the force is the energy given up": 4.0530559,
    "eqs. 4.4, 4.54: the force brakes the motion": MASS / 3 * 30 * DECAY,
    # Cutting alone stops the tip there, integrated along its path, with the energy of 30.03 m/s.
    "sec. 4.3: energy is not suitable for the crater's depth": 171.715128,
}

SIMULATED = {
    "sec. 2.3.1: the bristle is radial when it strikes": (2.743, 5e-4),
    "fig. 2.2: the retraction at release is the largest": (44.995, 2e-5),
    # The strike's state is given to 1e-4, of which 1.67 ms later nothing but such fractions is left.
    "sec. 2.3: no secondary contact": (1.66743, 2e-3),
}
"""Another engine's integration of the pass, to the digits given."""

ZERO = {"fig. 2.19: total work behaves like tangential work over friction"}
"""Figures that are zero: of rounding alone."""


def test_every_difference_is_computed_a_second_time():
    rows = rows_by_place()
    differing = {where for where, row in rows.items() if row.status == DIFFERS}
    assert differing == set(COMPUTED) | set(SIMULATED) | ZERO
    assert all(rows[where].computed < 1e-12 for where in ZERO)


@pytest.mark.parametrize("where", [*COMPUTED, *SIMULATED])
def test_differences_by_an_independent_computation(where):
    # Nine digits; quadrature was requested to reach 1e-11, the limit's extrapolation left 1e-7.
    value, tolerance = SIMULATED[where] if where in SIMULATED else (COMPUTED[where], 1e-6)
    assert rows_by_place()[where].computed == pytest.approx(value, rel=tolerance)


def test_the_ratio_of_sums_is_the_printed_depth_at_five_plies_only():
    """The reason given for the printed depth by energy: (4.59) over (3.19), as printed."""
    gone = 0.0126 * (1 - math.exp(-2 * DECAY * END)) + 0.00303 * (1 - math.exp(-DECAY * END))
    found = []
    for n in range(1, 301):
        t = np.linspace(0.0, END, n + 1)[1:]
        force = (
            1.0160 * np.exp(-5.499 * t) * (26 - 30 * np.cos(2 * np.pi * (t + 0.00001) / 0.00012))
        )
        if abs(math.cos(GAMMA) * gone / np.sum(force) - 7.58e-5) <= 0.05e-6:
            found.append(n)
    assert found == [5]


@pytest.mark.parametrize(
    ("printed", "half"), [("1.619e-3", 5e-7), ("57", 0.5), ("0.00041", 5e-6), ("2.760", 5e-4)]
)
def test_half_a_unit_of_the_last_digit(printed, half):
    assert half_unit(printed) == pytest.approx(half, rel=1e-12)


@pytest.mark.parametrize(
    ("computed", "allowance", "status"),
    [
        (57.49, 0.0, REPRODUCED),
        (56.5, 0.0, REPRODUCED),
        (57.51, 0.0, DIFFERS),
        (57.51, 0.02, REPRODUCED),
    ],
)
def test_verdicts_on_numbers(computed, allowance, status):
    row = audit_row(Printed("place", "57", unit="N"), Figure(computed, allowance=allowance))
    assert row.status == status
    assert row.tolerance == pytest.approx(0.5 + allowance)


def test_verdicts_on_statements():
    grows = Printed("place", statement="grows")
    assert audit_row(grows, Figure(0.1, holds=True)).status == REPRODUCED
    assert audit_row(grows, Figure(-0.1, "by -2", holds=False)).why == "by -2"
    assert audit_row(grows, Figure(-0.1)).status == DIFFERS
    assert audit_row(grows, Figure(None)).status == NOT_COMPUTABLE
    with pytest.raises(ArithmeticError, match="place"):
        audit_row(grows, Figure(math.nan))


def test_the_answer_counts_the_rows(monkeypatch):
    monkeypatch.setattr("bristle_sim.dissertation.audit.audit_rows", audited)
    answer = audit_report(AuditView()).answer
    for status, words in (
        (REPRODUCED, "of 124"),
        (DIFFERS, "differ"),
        (NOT_COMPUTABLE, "cannot be computed"),
    ):
        assert f"{sum(row.status == status for row in audited())} {words}" in answer
