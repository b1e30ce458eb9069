"""March random impacts of a tangential compliance in time and compare the law with them. ``python tests/benchmarks/law_march.py 100000``

Penetration, stretch of the tangential spring, velocity and impulse are integrated by DOP853, all impacts at once, each in its own
phase and by its own steps of at most a seventh of its fastest time scale, where the error of a step is rounding. A phase ends where one
of its functions becomes positive; the instant is found on the step that contains it, integrated again over its part up to there.
Nothing is shared with the law but the springs: k and k/e*^2 along the normal, k/eta^2 along the surface, k = 1.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from typing import NamedTuple

import numpy as np
from scipy.integrate._ivp.dop853_coefficients import A, B

from bristle_sim.theory.impact import Impact, energetic_impact

STAGES = 12
STEP = 0.15
FIRST_STEP = 1e-6
GROWTH = 4.0
"""Longest and first step of a phase over the fastest time scale, and their growth: stick may leave an edge of the cone for a moment."""

MOST_PHASES = 40
MOST_STEPS = 4_000
"""Limits of a march: with mu_2 > mu_1 some points are pressed on and released again and again."""

CHUNK = 50_000  # impacts that are marched together

DONE = "marched"
PHASES = "too many phases"
STEPS = "too many steps"


class March(NamedTuple):
    """Impacts on their way; ``state`` has the rows penetration, stretch, v_n, v_t, p_n and p_t, and ``slip`` is 0 in stick."""

    number: np.ndarray
    matrix: np.ndarray  # rows K_nn, K_nt, K_tt
    mu_1: np.ndarray
    mu_2: np.ndarray
    kappa: np.ndarray  # 1/e*^2
    squared: np.ndarray
    state: np.ndarray
    deepest: np.ndarray
    loading: np.ndarray
    slip: np.ndarray
    step: np.ndarray
    phases: np.ndarray
    steps: np.ndarray

    def take(self, chosen: np.ndarray) -> March:
        return March(*(each[..., chosen] for each in self))

    def put(self, at: np.ndarray, other: March) -> None:
        for mine, new in zip(self, other, strict=True):
            mine[..., at] = new

    @property
    def friction(self) -> np.ndarray:
        return np.where(self.loading, self.mu_1, self.mu_2)

    @property
    def stiffness(self) -> np.ndarray:
        return np.where(self.loading, 1.0, self.kappa)

    @property
    def longest_step(self) -> np.ndarray:
        half = 0.5 * (self.matrix[0] - self.matrix[2])
        mean = 0.5 * (self.matrix[0] + self.matrix[2])
        stiffest = np.maximum(self.kappa, 1.0 / self.squared)
        return STEP / np.sqrt((mean + np.hypot(half, self.matrix[1])) * stiffest)

    def push(self, state: np.ndarray) -> np.ndarray:
        return np.where(
            self.loading, state[0], self.deepest - (self.deepest - state[0]) * self.kappa
        )

    def rub(self, state: np.ndarray) -> np.ndarray:
        return np.where(
            self.slip == 0.0,
            -state[1] / self.squared,
            -self.slip * self.friction * self.push(state),
        )

    def rates(self, state: np.ndarray) -> np.ndarray:
        normal = self.push(state)
        along = self.rub(state)
        k_nn, k_nt, k_tt = self.matrix
        speeds = (k_nn * normal + k_nt * along, k_nt * normal + k_tt * along)
        return np.array([-state[2], state[3], *speeds, normal, along])

    def advanced(self, step: np.ndarray) -> np.ndarray:
        """Return the state after a step of DOP853."""
        slopes = np.empty((STAGES, *self.state.shape))
        for stage in range(STAGES):
            used = np.flatnonzero(A[stage, :stage])
            moved = np.tensordot(A[stage, used], slopes[used], 1) if used.size else 0.0
            slopes[stage] = self.rates(self.state + step * moved)
        return self.state + step * np.tensordot(B, slopes, 1)

    def events(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return functions that become positive where the phase ends, and their rates: line, apart, and two edges or the foot's stop."""
        _, _, normal_rate, tangential_rate, push, _ = self.rates(state)
        _, _, v_n, v_t, *_ = state
        mu = self.friction
        kappa = self.stiffness
        slips = self.slip != 0.0
        line = np.where(self.loading, v_n, state[0] - self.deepest)
        line_rate = np.where(self.loading, normal_rate, -v_n)
        apart = np.where(self.loading, -1.0, -push)
        apart_rate = np.where(self.loading, 0.0, kappa * v_n)
        growth = mu * self.squared * kappa
        foot = self.slip * v_t + growth * v_n
        foot_rate = self.slip * tangential_rate + growth * normal_rate
        rub = -state[1] / self.squared
        rub_rate = -v_t / self.squared
        edges = [np.where(slips, -foot, rub - mu * push), np.where(slips, -1.0, -rub - mu * push)]
        edge_rates = [np.where(slips, -foot_rate, rub_rate + mu * kappa * v_n)]
        edge_rates.append(np.where(slips, 0.0, -rub_rate + mu * kappa * v_n))
        return np.array([line, apart, *edges]), np.array([line_rate, apart_rate, *edge_rates])


def first_event(march: March, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of the first event within each impact's step, -1 without one, and its time."""
    values, rates = march.events(march.state)
    last, last_rates = march.events(ends)
    crosses = (values <= 0.0) & (last > 0.0)
    # A function that is highest within the step may have been positive there.
    which, at = np.nonzero((values <= 0.0) & ~crosses & (rates > 0.0) & (last_rates < 0.0))
    highest = root(march.take(at), which, march.step[at], crest=True)
    chosen = march.take(at)
    over = chosen.events(chosen.advanced(highest))[0][which, np.arange(at.size)] > 1e-12
    beyond, crossing = np.nonzero(crosses)
    which = np.concatenate([beyond, which[over]])
    at = np.concatenate([crossing, at[over]])
    times = root(march.take(at), which, np.concatenate([march.step[crossing], highest[over]]))
    event = np.full(march.number.size, -1)
    when = np.full(march.number.size, np.inf)
    for index in range(len(values)):
        mine = which == index
        sooner = times[mine] < when[at[mine]]
        when[at[mine][sooner]], event[at[mine][sooner]] = times[mine][sooner], index
    return event, when


def root(march: March, which: np.ndarray, ends: np.ndarray, *, crest: bool = False) -> np.ndarray:
    """Return where each impact's function ``which``, positive at the end of its step, becomes so, or where it is highest.

    Newton's method, or Illinois' for the crest, within a bracket that is halved where they leave it.
    """
    each = np.arange(ends.size)
    tolerance = 1e-8 if crest else 2e-16

    def function(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values, rates = (part[which, each] for part in march.events(state))
        return (-rates, np.zeros(ends.size)) if crest else (values, rates)

    low = np.zeros(ends.size)
    high = ends.copy()
    tried = ends
    below, (above, rate) = function(march.state)[0], function(march.advanced(ends))
    value = above
    done = np.zeros(ends.size, dtype=bool)
    for _ in range(60):
        with np.errstate(invalid="ignore", divide="ignore"):
            change = above * (high - low) / (above - below) if crest else value / rate
        best = (high if crest else tried) - change
        best = np.where((best > low) & (best < high), best, 0.5 * (low + high))
        moved = abs(best - tried)
        tried = np.where(done, tried, best)
        value, rate = function(march.advanced(tried))
        up = value > 0.0
        low, high = np.where(up, low, tried), np.where(up, tried, high)
        below, above = np.where(up, 0.5 * below, value), np.where(up, value, 0.5 * above)
        done |= (moved <= tolerance * ends) | (high - low <= tolerance * ends) | (value == 0.0)
        if done.all():
            break
    return tried


def turned(march: March, event: np.ndarray) -> March:
    """Return the impacts at the beginning of the phase after an event."""
    state = march.state.copy()
    push = march.push(march.state)
    rub = march.rub(march.state)
    line = event == 0
    slips = march.slip != 0.0
    deepest = line & march.loading
    state[2, deepest] = 0.0
    after = march._replace(
        state=state,
        deepest=np.where(deepest, state[0], march.deepest),
        loading=np.where(line, ~march.loading, march.loading),
    )
    limit = after.friction * push
    clipped = np.clip(rub, -limit, limit)
    stops = slips & ~line
    edge = ~line | (abs(clipped) >= limit * (1.0 - 1e-12))
    side = np.where(edge & ~stops, -np.sign(clipped), 0.0)
    # Rounding leaves the cone too, where the foot's velocity does not.
    slip = np.where(
        side * state[3] + after.friction * march.squared * after.stiffness * state[2] > 0.0,
        side,
        0.0,
    )
    # Within the cone after slip, so that rounding does not leave it at once.
    force = np.where(line, clipped, np.where(slip == 0.0, rub * (1.0 - 1e-13), rub))
    state[1] = -force * march.squared
    return after._replace(
        slip=slip, step=march.longest_step * FIRST_STEP / STEP, phases=march.phases + 1
    )


def begun(impacts: dict[str, np.ndarray]) -> March:
    """Return impacts at their first touch."""
    matrix = impacts["inverse_mass"]
    velocity = impacts["velocity"].T
    mu = impacts["friction"]
    size = mu.size
    none = np.zeros(mu.size)
    foot = abs(velocity[1]) + mu * impacts["tangential_compliance"] * velocity[0]
    march = March(
        number=np.arange(size),
        matrix=np.array([matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 1]]),
        mu_1=mu,
        mu_2=impacts.get("restitution_friction", mu),
        kappa=impacts["restitution"] ** -2.0,
        squared=impacts["tangential_compliance"],
        state=np.array([none, none, *velocity, none, none]),
        deepest=none.copy(),
        loading=none == 0.0,
        slip=np.where(foot > 0.0, np.sign(velocity[1]), 0.0),
        step=none,
        phases=np.zeros(size, dtype=int),
        steps=np.zeros(size, dtype=int),
    )
    return march._replace(step=march.longest_step * FIRST_STEP / STEP)


def marched(
    impacts: dict[str, np.ndarray], most_steps: int = MOST_STEPS, most_phases: int = MOST_PHASES
) -> tuple[np.ndarray, Counter[str]]:
    """Return impulses and velocities, (n, 4), NaN where an impact is skipped, and how many were for which reason."""
    size = impacts["friction"].size
    reasons = Counter[str]()
    found = np.full((size, 4), np.nan)
    for begin in range(0, size, CHUNK):
        march = begun({key: value[begin : begin + CHUNK] for key, value in impacts.items()})
        while march.number.size:
            ends = march.advanced(march.step)
            event, when = first_event(march, ends)
            at = np.flatnonzero(event >= 0)
            chosen = march.take(at)
            step = np.minimum(GROWTH * march.step, march.longest_step)
            march = march._replace(state=ends, steps=march.steps + 1, step=step)
            if at.size:
                march.put(at, turned(chosen._replace(state=chosen.advanced(when[at])), event[at]))
            over = event == 1
            found[begin + march.number[over]] = march.state[[4, 5, 2, 3]][:, over].T
            phases = ~over & (march.phases > most_phases)
            steps = ~over & (march.steps > most_steps)
            reasons += Counter(
                {
                    DONE: int(over.sum()),
                    PHASES: int(phases.sum()),
                    STEPS: int((steps & ~phases).sum()),
                }
            )
            if (over | phases | steps).any():
                march = march.take(~(over | phases | steps))
    return found, reasons


def random_impacts(seed: int, size: int, reach: float = 0.95) -> dict[str, np.ndarray]:
    """Approaching points with eta^2 from 0.01 to 10; mu_2 is mu_1 in half of them."""
    rng = np.random.default_rng(seed)
    diagonal = 10.0 ** rng.uniform(-1, 1, (2, size))
    correlation = rng.uniform(-reach, reach, size)
    coupling = correlation * np.sqrt(diagonal.prod(axis=0))
    matrix = np.array([[diagonal[0], coupling], [coupling, diagonal[1]]]).transpose(2, 0, 1)
    velocity = rng.normal(size=(size, 2))
    velocity[:, 0] = -np.abs(velocity[:, 0]) - 0.01
    friction = rng.uniform(0.02, 2.0, size)
    return {
        "inverse_mass": matrix,
        "velocity": velocity,
        "friction": friction,
        "restitution": rng.uniform(0.05, 1.0, size),
        "restitution_friction": np.where(
            rng.random(size) < 0.5, friction, rng.uniform(0.02, 2.0, size)
        ),
        "tangential_compliance": 10.0 ** rng.uniform(-2, 1, size),
    }


def nearly_singular_impacts(seed: int, size: int) -> dict[str, np.ndarray]:
    """Approaching points with det K from 1e-5 to 1e-2 of K_nn K_tt: their modes' rates differ up to a thousandfold."""
    rng = np.random.default_rng(seed)
    impacts = random_impacts(seed, size)
    matrix = impacts["inverse_mass"]
    coupling = np.sqrt(
        matrix[:, 0, 0] * matrix[:, 1, 1] * (1.0 - 10.0 ** rng.uniform(-5, -2, size))
    )
    matrix[:, 0, 1] = matrix[:, 1, 0] = rng.choice([-1.0, 1.0], size) * coupling
    same = {"restitution_friction": impacts["friction"], "restitution": rng.uniform(0.3, 1.0, size)}
    return impacts | same


def impulse_and_velocity(found: Impact) -> np.ndarray:
    return np.stack(
        [
            found.impulse_normal,
            found.impulse_tangential,
            found.velocity_normal,
            found.velocity_tangential,
        ],
        axis=-1,
    )


def differences(law: np.ndarray, march: np.ndarray) -> np.ndarray:
    """Return the largest differences over the largest impulse, or speed, of each impact; NaN where it was not marched."""
    sizes = np.repeat(abs(march).reshape(-1, 2, 2).max(axis=-1), 2, axis=-1)
    return (abs(law - march) / sizes).max(axis=-1)


def main(size: int, seed: int = 1) -> None:
    """Print how far the law is from the march, and how many impacts were skipped and why."""
    begin = time.process_time()
    impacts = random_impacts(seed, size)
    found, reasons = marched(impacts)
    apart = differences(impulse_and_velocity(energetic_impact(**impacts)), found)
    compared = np.sort(apart[np.isfinite(apart)])
    print(f"{size} random impacts, seed {seed}; {time.process_time() - begin:.0f} s of CPU")
    for reason, number in reasons.items():
        print(f"{number:8d} {reason}")
    print(f"{np.count_nonzero(compared > 1e-9):8d} of the marched ones differ by more than 1e-9")
    print(
        f"differences, median {np.median(compared):.1e}, one in a thousand above {compared[-len(compared) // 1000]:.1e}"
    )
    print(
        "largest:",
        " ".join(
            f"{each:.1e} (no. {np.flatnonzero(apart == each)[0]})" for each in compared[:-6:-1]
        ),
    )
    print(f"command: python tests/benchmarks/law_march.py {size} {seed}")


if __name__ == "__main__":
    main(*(int(each) for each in sys.argv[1:] or ["2000"]))
