"""The audit: its verdicts, and a second, independent computation of every figure that differs from print.

The figures here are worked out from the dissertation's formulas with numpy and scipy alone; nothing but the audit itself
is imported from the package. The two figures of the simulated pass come from an integration with another engine.
"""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

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

ROWS = {row.where: row for row in audit_rows()}

OMEGA, RADIUS, LENGTH, MASS, GAMMA = 261.8, 0.0275, 0.027, 8.387e-5, math.radians(23.4)
INERTIA, THETA = MASS * LENGTH**2 / 3, math.radians(44.5)
STIFFNESS = math.degrees(0.00041)
TIP_SPEED = (3.23 * LENGTH + RADIUS) * OMEGA
END, DECAY = 5e-5, 92400.0
SINE, COSINE = math.sin(GAMMA), math.cos(GAMMA)


def bar(turn):
    """Bar position in mm for a hub turn during the cue (2.1), S from the printed position."""
    lag = math.atan2(LENGTH * math.sin(THETA), RADIUS + LENGTH * math.cos(THETA))
    gamma = math.acos((RADIUS + LENGTH - 0.0045) / (RADIUS + LENGTH))
    distance, direction = math.hypot(50.37, 22.5), lag + turn + gamma
    return distance * math.sin(direction), distance * math.cos(direction)


PLAIN_RATE = math.sqrt(STIFFNESS / INERTIA)
PLAIN_BAR = bar(OMEGA * 0.5 * math.pi / PLAIN_RATE)


def normal_impulse(mu, gamma=GAMMA):
    return MASS * TIP_SPEED / (3 * (np.sin(gamma) + mu * np.cos(gamma)))


def final_impulse(mu_1, mu_2):
    s_1, s_2 = SINE + mu_1 * COSINE, SINE - mu_2 * COSINE
    return MASS * TIP_SPEED / 3 * (s_2 + 0.42 * np.sqrt(s_1 * s_2)) / (s_1 * s_2)


def resultant(mu):
    return normal_impulse(mu) * math.hypot(1.0, mu)


def ball(t):
    return 1.3935 * np.exp(-101.6189 * t) * (145 - 167.5 * np.cos(2 * np.pi * (t + 0.0005) / 0.006))


def bristle(t):
    return 1.0160 * np.exp(-5.499 * t) * (26 - 30 * np.cos(2 * np.pi * (t + 0.00001) / 0.00012))


def integral(function, low, high):
    return quad(function, low, high, epsrel=1e-11, epsabs=0.0)[0]


def shares(function, end):
    edges = np.linspace(0.0, end, 11)
    parts = np.array([integral(function, *pair) for pair in itertools.pairwise(edges)])
    return parts / parts.sum()


def width(t):
    return 2 * np.sqrt(3.55e-4**2 - (1.39e-4 + 2.16e-4 * np.exp(-DECAY * t)) ** 2)


def depth_limit():
    """Limit of the ply sum by Richardson's extrapolation in powers of 1/sqrt(n), with the rounded angles, um."""
    sums = []
    for n in (100_000, 400_000, 1_600_000):
        t = np.linspace(0.0, END, n + 1)
        sums.append(np.sum(np.diff(bristle(t)) / width(t[1:])))
    first = [2 * b - a for a, b in itertools.pairwise(sums)]
    limit = first[1] + (first[1] - first[0]) / 3
    return 1e6 * limit * math.sin(math.radians(25)) * math.cos(math.radians(65)) * COSINE / 1.2e8


def energy(t, v_0=15.0, v_1=3.615, w_0=1111.0, w_1=266.65):
    e = np.exp(-DECAY * t)
    return 0.5 * MASS * (v_0 * e + v_1) ** 2 + MASS * LENGTH**2 / 24 * (w_0 * e - w_1) ** 2


def printed_energy(t):
    return 0.0126 * np.exp(-2 * DECAY * t) + 0.00303 * np.exp(-DECAY * t) + 7.25e-4


def energy_sum(n):
    t = np.linspace(0.0, END, n + 1)
    return COSINE * np.sum(-np.diff(printed_energy(t)) / bristle(t[1:]))


def cutting_depth():
    """Depth in um at which cutting alone has stopped the tip, integrated along the path; energy of 30.03 m/s."""
    specific = 1.2e8 * math.cos(X) / (0.5 * (1 - math.sin(X)))
    long = 7.1e-4 / math.cos(math.radians(39.5))

    def chord(path):
        y = 1 - 2 * path * SINE / math.sin(math.radians(28)) / long
        return 7.1e-4 * math.sqrt(1 - y * y)

    def left(end):
        return integral(lambda s: specific * chord(s) * s * math.tan(GAMMA), 0.0, end) - MASS / 6 * SPEED_4**2

    return 1e6 * SINE * brentq(left, 1e-4, 5e-4, xtol=1e-15)


X = math.atan(1 / 0.5) - GAMMA
SPEED_4 = RADIUS * OMEGA + LENGTH * 845.6


def back_to_the_workpart():
    """Time in ms from the strike of the simulated pass to the next contact, from its state then."""
    stiff = MASS * RADIUS * LENGTH / 2 * OMEGA**2
    strike, lag, rate = 4.5300e-3, -math.radians(2.743), 877.09 + OMEGA
    start = OMEGA * strike - 0.5 * math.pi
    root = OMEGA * RADIUS * np.array([math.cos(start), math.sin(start)])
    arm = LENGTH * np.array([math.cos(start + lag), math.sin(start + lag)])
    # The general law for one degree of freedom: compression to v_y = 0, restitution by work, slip reversing on the way.
    after = rebound(arm, root, rate)

    def slopes(_, state):
        return [state[1], -(STIFFNESS * state[0] + stiff * math.sin(state[0])) / INERTIA]

    def height(t, state):
        psi = start + OMEGA * t
        return RADIUS + LENGTH - 0.0045 - RADIUS * math.cos(psi) - LENGTH * math.cos(psi + state[0])

    height.terminal, height.direction = True, -1
    run = solve_ivp(slopes, (0.0, 5e-3), [lag, after - OMEGA], events=height, rtol=1e-10, atol=1e-12, max_step=1e-5)
    return 1e3 * run.t_events[0][0]


def rebound(arm, root, rate, mu=0.31, restitution=0.42):
    """Rate after an impact with friction, by small steps of normal impulse: Coulomb's law and the works, step by step."""
    step, work, compressed = 3e-8, 0.0, None
    while True:
        tangential, normal = root + arm * rate
        if compressed is None and normal >= 0.0:
            compressed, work = work, 0.0
        if compressed is not None and work >= -(restitution**2) * compressed:
            return rate
        change = (arm[1] - mu * np.sign(tangential) * arm[0]) / INERTIA * step
        work += step * (normal + 0.5 * arm[1] * change)
        rate += change


SIMULATED = {
    # Another engine's integration of the pass to the digits given.
    "sec. 2.3.1: the bristle is radial when it strikes": (lambda: 2.743, 5e-4),
    "fig. 2.2: the retraction at release is the largest": (lambda: 44.995, 2e-5),
    # The strike's state is given to 1e-4, of which 1.67 ms later nothing but such shares is left.
    "sec. 2.3: no secondary contact": (back_to_the_workpart, 2e-3),
}

COMPUTED = {
    "eq. 2.33: speed ratio R": lambda: THETA * PLAIN_RATE / OMEGA,
    "eq. 2.2: belt stiffness k_T": lambda: INERTIA * (845.6 / THETA) ** 2,
    "fig. 1.5: natural frequency": lambda: PLAIN_RATE / (2 * math.pi),
    "eq. 2.3: bar position S_H": lambda: PLAIN_BAR[0],
    "eq. 2.3: bar position S_V": lambda: PLAIN_BAR[1],
    "sec. 2.2: design forecast within 5 %": lambda: 1 - PLAIN_BAR[1] / 22.5,
    "fig. 2.7: p_cy converges to a common value as friction approaches 1": lambda: (
        np.ptp(normal_impulse(1.0, np.radians([15, 20, 25, 30])))
        / np.mean(normal_impulse(1.0, np.radians([15, 20, 25, 30])))
    ),
    "sec. 5.1: elevated friction leads to the greatest compressive impulse": lambda: resultant(0.42) / resultant(0.0),
    "sec. 2.3.2: tangential work is one order of magnitude greater than normal work": lambda: 0.31 / math.tan(GAMMA),
    "fig. 2.22: equal or different friction makes minimal distinction": lambda: (
        1 - final_impulse(0.31, 0.0) / final_impulse(0.0, 0.0)
    ),
    "above eq. 2.51: in our model L = r_h": lambda: 55 / 54,
    "eq. 3.7: compressive impulse of the ball": lambda: integral(ball, 0.0, 2.328e-3),
    "eq. 3.9: compressive impulse of the bristle": lambda: resultant(0.31),
    "eq. 3.18: fourth summand": lambda: 16.19 * shares(ball, 2.328e-3)[3],
    "eqs. 3.9, 3.19: impulse of the fitted curve": lambda: integral(bristle, 0.0, END),
    "sec. 3.3: the two impacts are aligned in normalized time": lambda: np.abs(
        shares(ball, 2.327687880e-3) - shares(bristle, 4.999625585e-5)
    ).max(),
    "fig. 4.3: excursion at 50 us": lambda: 325 * (1 - math.exp(-DECAY * END)),
    "eq. 4.6: initial rate": lambda: 1111 - 266.65,
    "eq. 4.7: v_G at rest": lambda: RADIUS * OMEGA / 2,
    "sec. 4.2.2: the depth is converged at n = 300": depth_limit,
    # The three coefficients from three values of the energy.
    "eq. 4.59: coefficient of exp(-lambda t)": lambda: _coefficients()[1],
    "eq. 4.59: constant": lambda: _coefficients()[2],
    "fig. 4.19: crater depth by work and energy": lambda: energy_sum(300),
    "sec. 4.3: the energy estimate converges": lambda: energy_sum(3000) / energy_sum(300),
    "eqs. 4.54, 4.59: the work of the force is the energy given up": lambda: (
        1e3 * integral(lambda t: bristle(t) * 30 * math.exp(-DECAY * t), 0.0, END)
    ),
    "eqs. 4.4, 4.54: the force brakes the motion": lambda: MASS / 3 * 30 * DECAY,
    "sec. 4.3: energy is not suitable for the crater's depth": cutting_depth,
}


def _coefficients():
    t = np.array([0.0, 1e-5, 3e-5])
    e = np.exp(-DECAY * t)
    return np.linalg.solve(np.stack([e**2, e, np.ones(3)], axis=1), energy(t))


ZERO = {"fig. 2.19: total work behaves like tangential work over friction"}
"""Figures that are zero: of rounding alone."""


def test_every_difference_is_computed_a_second_time():
    differing = {where for where, row in ROWS.items() if row.status == DIFFERS}
    assert differing == set(COMPUTED) | set(SIMULATED) | ZERO


@pytest.mark.parametrize("where", COMPUTED)
def test_differences_by_an_independent_computation(where):
    # Quadrature is requested to reach 1e-11, the limit's extrapolation leaves 1e-7, solving for coefficients 1e-13.
    assert ROWS[where].computed == pytest.approx(COMPUTED[where](), rel=1e-6)


@pytest.mark.parametrize("where", SIMULATED)
def test_simulated_differences_by_an_independent_computation(where):
    value, tolerance = SIMULATED[where]
    assert ROWS[where].computed == pytest.approx(value(), rel=tolerance)


def test_total_work_is_constant():
    mu = np.linspace(0.0, 1.0, 11)
    work = -0.5 * TIP_SPEED * (SINE + mu * COSINE) * normal_impulse(mu)
    # Rounding.
    np.testing.assert_allclose(work, -MASS / 6 * TIP_SPEED**2, rtol=1e-13)
    assert all(ROWS[where].computed < 1e-12 for where in ZERO)


# Reasons


def test_the_energy_coefficients_follow_from_mixed_rounding():
    initial = 0.5 * MASS * (RADIUS * OMEGA + LENGTH / 2 * 845.6) ** 2 + MASS * LENGTH**2 / 24 * 845.6**2
    # Half a unit of the printed digits.
    assert abs(initial - 0.0126 - 7.25e-4 - 0.00303) < 5e-6
    rest = RADIUS * OMEGA / 2
    assert abs(0.5 * MASS * rest**2 + MASS * LENGTH**2 / 24 * 266.65**2 - 7.25e-4) < 5e-7
    assert abs(RADIUS * OMEGA + LENGTH / 2 * 845.6 - 15 - 3.615) < 5e-4


def test_the_ratio_of_sums_is_the_printed_depth_at_five_plies_only():
    found = []
    for n in range(1, 301):
        t = np.linspace(0.0, END, n + 1)
        ratio = COSINE * (printed_energy(0.0) - printed_energy(END)) / np.sum(bristle(t[1:]))
        if abs(ratio - 7.58e-5) <= 0.05e-6:
            found.append(n)
    assert found == [5]


def test_centrifugal_stiffening_brings_the_bar_within_five_per_cent():
    stiff = MASS * RADIUS * LENGTH / 2 * OMEGA**2

    def slopes(_, state):
        return [state[1], -(STIFFNESS * state[0] + stiff * math.sin(state[0])) / INERTIA]

    def radial(_, state):
        return state[0]

    radial.terminal = True
    run = solve_ivp(slopes, (0.0, 5e-3), [-THETA, 0.0], events=radial, rtol=1e-10, atol=1e-12)
    horizontal, vertical = bar(OMEGA * run.t_events[0][0])
    assert max(abs(horizontal / 50.37 - 1), abs(vertical / 22.5 - 1)) < 0.05
    assert f"{horizontal:.2f} and {vertical:.2f} mm" in ROWS["eq. 2.3: bar position S_H"].why


# The audit as a whole


@pytest.mark.parametrize(("printed", "half"), [("1.619e-3", 5e-7), ("57", 0.5), ("0.00041", 5e-6), ("2.760", 5e-4)])
def test_half_a_unit_of_the_last_digit(printed, half):
    assert half_unit(printed) == pytest.approx(half, rel=1e-12)


@pytest.mark.parametrize(
    ("computed", "allowance", "status"),
    [(57.49, 0.0, REPRODUCED), (56.5, 0.0, REPRODUCED), (57.51, 0.0, DIFFERS), (57.51, 0.02, REPRODUCED)],
)
def test_verdicts_on_numbers(computed, allowance, status):
    row = audit_row(Printed("place", "57", unit="N"), Figure(computed, allowance=allowance))
    assert row.status == status
    assert row.tolerance == pytest.approx(0.5 + allowance)


def test_verdicts_on_statements():
    grows = Printed("place", statement="grows", why="by {0:.1f}")
    assert audit_row(grows, Figure(0.1, 2.0, holds=True)).status == REPRODUCED
    assert audit_row(grows, Figure(-0.1, -2.0, holds=False)).why == "by -2.0"
    assert audit_row(grows, Figure(-0.1, -2.0)).status == DIFFERS
    assert audit_row(grows, Figure(None, 0.0)).status == NOT_COMPUTABLE
    with pytest.raises(ArithmeticError, match="place"):
        audit_row(grows, Figure(math.nan))


def test_the_answer_counts_the_rows():
    answer = audit_report(AuditView()).answer
    for status, words in ((REPRODUCED, "of 124"), (DIFFERS, "differ"), (NOT_COMPUTABLE, "cannot be computed")):
        assert f"{sum(row.status == status for row in ROWS.values())} {words}" in answer
