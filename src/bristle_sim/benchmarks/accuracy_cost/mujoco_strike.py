"""MuJoCo at the strikes: a soft contact as close to the energetic law as it gets."""

from __future__ import annotations

import functools
import itertools
import math

from bristle_sim.benchmarks.accuracy_cost.cases import StrikeCase
from bristle_sim.benchmarks.accuracy_cost.compliant_contact import TipContact
from bristle_sim.benchmarks.accuracy_cost.measure import Attempt, Run
from bristle_sim.benchmarks.accuracy_cost.mujoco_model import SOFT, Model, hub, rod
from bristle_sim.scene.strike import Chain

__all__ = ["spring_of", "strike_attempts"]

STEP_COUNTS = (8, 16, 32, 64, 128, 256, 1024)

CONTACT_TIME = 1e-5
"""Duration of an impact over the time in which the chain turns by a radian: it keeps its shape."""

TIP_RADIUS = 1e-9
"""Of the ball that touches, in lengths of the last rod."""


def strike_attempts(case: StrikeCase) -> list[Attempt]:
    """The soft contact, tuned to e* without friction, over steps in a contact."""
    strike = _Strike(case)
    return [
        Attempt("mujoco soft contact", f"steps={count}", functools.partial(strike.hit, count)) for count in STEP_COUNTS
    ]


class _Strike(Model):
    """A chain whose tip touches a plane."""

    LASTS = 3
    """Contact times that are simulated: friction makes a contact longer."""

    def __init__(self, case: StrikeCase) -> None:
        chain, size = case.chain, case.chain.lengths[-1]
        self.chain, self.fastest = chain, max(map(abs, (*chain.rates, chain.hub_speed)))
        plane = f"""<geom name="plane" type="plane" size="1 1 1" zaxis="0 1 0" contype="1" conaffinity="0" priority="1"
            pos="0 {_tip_height(chain) / size - TIP_RADIUS!r} 0" condim="3" solimp="{SOFT} {SOFT} 1"
            friction="{case.surface.friction!r} 0 0"/>"""
        ball = f'<geom type="sphere" size="{TIP_RADIUS}" pos="0 -1 0" contype="0" conaffinity="1" mass="0"/>'
        inside = ball
        for mass, length in zip(reversed(chain.masses), reversed(chain.lengths), strict=True):
            below = inside if inside == ball else f'<body pos="0 {-length / size!r} 0">{inside}</body>'
            inside = rod(mass / chain.masses[-1], length / size, 0.0, below)
        super().__init__(plane + hub(chain.hub_radius / size, inside), "implicitfast")
        self._tune(case)

    def _tune(self, case: StrikeCase) -> None:
        """Set the spring so that without friction it returns e*.

        Where impedance is small, the force is that of the spring over the tool's own estimate of the contact's inverse
        mass, which its regularization R = (1 - d)/d times that estimate tells; the spring is scaled by what is true.
        """
        spring = spring_of(case.surface.restitution, CONTACT_TIME)
        self._begin(CONTACT_TIME / 100.0)
        self.step(2)
        estimate = float(self.data.efc_R[0]) * SOFT / (1.0 - SOFT)
        true = TipContact(case.chain, case.surface).normal_inverse_mass * case.chain.masses[-1]
        self.model.geom("plane").solref = [-each * estimate / true for each in spring]

    def _begin(self, step: float) -> None:
        chain = self.chain
        rates = (chain.hub_speed / self.fastest, *(rate / self.fastest for rate in chain.rates))
        self.start(_relative((chain.hub_angle, *chain.angles)), _relative(rates), step)

    def hit(self, count: int) -> Run:
        """So many steps in a contact."""
        self._begin(CONTACT_TIME / count)
        self.step(self.LASTS * count)
        after = self.data.qvel.cumsum()[1:] * self.fastest
        return Run(tuple(after.tolist()), self.LASTS * count)


def _tip_height(chain: Chain) -> float:
    rods = sum(length * math.cos(angle) for length, angle in zip(chain.lengths, chain.angles, strict=True))
    return -chain.hub_radius * math.cos(chain.hub_angle) - rods


def _relative(values: tuple[float, ...]) -> tuple[float, ...]:
    """Absolute angles or rates as hinges count them: each from the one before."""
    return (values[0], *(after - before for before, after in itertools.pairwise(values)))


def spring_of(restitution: float, duration: float) -> tuple[float, float]:
    """(k, b) of r'' = -b r' - k r whose impact lasts so long and returns so much of the speed, if its force only pushes.

    With the damping ratio sin a it lets go, at zero acceleration, after (pi - 2 a)/(omega cos a), and returns
    e^(-tan a (pi - 2 a)) of the speed (Schwager and Poeschel 2007); less than e^-2 takes more than critical damping.
    """
    if not math.exp(-2.0) < restitution <= 1.0:
        raise ValueError(f"restitution = {restitution:g}: more than e^-2 and at most 1 is allowed (dimensionless)")
    low, high = 0.0, 0.5 * math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        returned = math.exp(-math.tan(middle) * (math.pi - 2.0 * middle))
        low, high = (middle, high) if returned > restitution else (low, middle)
    rate = (math.pi - 2.0 * low) / (duration * math.cos(low))
    return rate**2, 2.0 * math.sin(low) * rate
