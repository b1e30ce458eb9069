"""Numerical settings of a simulation, the names of its events, and the reasons why it may stop."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from bristle_sim.declared import Choice, Declared
from bristle_sim.fields import ANY, count, quantity

MAXIMUM_STEPS = 500_000
"""Default of the largest number of engine steps of a simulation.

This number suffices for sixty whole passes of a rigid bristle, or for one pass of a wire of 8
links. So many steps take 2 to 6 s of CPU time for a rigid bristle, 12 to 20 s for a wire of
links."""


@dataclass(frozen=True, slots=True)
class Settings(Declared):
    """Accuracy, duration, step budget and sampling of a simulation."""

    accuracy: float = quantity(
        1e-6,
        "1e-11 <= accuracy <= 0.1: relative accuracy requested of the simulation"
        " [chosen; less than 1e-11 is more than double precision gives]",
        usual=ANY,
    )
    maximum_steps: int = count(
        MAXIMUM_STEPS,
        "1 <= maximum_steps <= 1e15: number of engine steps after which a simulation stops; a step with more than 32 links"
        " counts once for every 32 links [chosen: sixty passes of a rigid bristle]",
        listed=False,
    )
    hub_turn: float = quantity(
        4.71238898038469,
        "1e-12 <= hub_turn <= 1e6 rad: angle by which the hub turns in the pass [three quarters of a revolution]",
        usual=ANY,
    )
    samples_per_period: int | None = count(
        None,
        "1 <= samples_per_period <= 1e9: least number of samples in a period of the bristle on its belt; none: 8 to 24, such"
        " that cubic interpolation meets the accuracy as far as 24 samples suffice [chosen]",
        listed=False,
    )


EVENTS = (
    "bar touch", "bar release", "strike", "workpart touch", "workpart release", "wire touch", "wire release",
    "largest retraction", "highest relative speed", "retraction limit", "jam",
)  # fmt: skip
"""Names of the events that a simulation records and that can end it."""

STOP_AFTER = Choice("stop_after", options=EVENTS)
"""Declaration of the event that ends a simulation."""

# Name of the event, before the strike, at which the first link lags the hub most
LARGEST_RETRACTION = "largest retraction"

OBSTACLE = Choice("obstacle", options=("bar", "workpart", "wire"))
"""Declaration of an obstacle that a wire can touch."""

ABSENCES = {"bar not touched": "bar touch", "workpart not reached": "strike"}
"""Events at the end of a simulation which state that another event has not happened, each with the
name of the other event."""


class StopReason(StrEnum):
    """Reason why a simulation stopped. The value is the text in messages and saved files.

    Attributes:
        remedy: sentence that states which change of a parameter would prevent this stop. In the
            sentence ``{friction}`` stands for the key of the friction coefficient of the obstacle
            touched last.
        gives_up: whether the method failed, so that the motion after the stop is unknown.
    """

    remedy: str
    gives_up: bool

    def __new__(cls, wording: str, remedy: str, gives_up: bool = False) -> StopReason:
        """Create a member from its text, its remedy and ``gives_up``."""
        member = str.__new__(cls, wording)
        member._value_ = wording
        member.remedy = remedy
        member.gives_up = gives_up
        return member

    END = "end of the planned time", "a larger hub_turn makes the run longer"
    EVENT = "requested event", "without stop_after the run continues"
    JAM = "jam", "less {friction}, or another place of the bar, leaves the wire free"
    RETRACTION_LIMIT = (
        "retraction limit",
        "a stiffer belt, or a bar that bends the wire back less, keeps it off the hub",
    )
    STEP_BUDGET = (
        "step budget spent",
        "a shorter hub_turn or a larger accuracy takes fewer steps",
        True,
    )
    ACCURACY = (
        "no step is short enough for the requested accuracy",
        "a larger accuracy is easier",
        True,
    )
    NO_GRIP = (
        "no grip for the engine's contact",
        "a softer belt, or a bar that the wire does not leave over its end, gives grip",
        True,
    )
    UNRESOLVED = (
        "contact that could not be resolved in time",
        "another contact_duration, or a larger accuracy, may do",
        True,
    )
