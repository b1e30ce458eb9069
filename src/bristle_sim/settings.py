"""Numerical settings of a simulation, names of its events, and reasons for which it stops."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from numbers import Integral

from bristle_sim.declared import Declared
from bristle_sim.fields import ANY, quantity
from bristle_sim.units import shown

MAXIMUM_STEPS = 500_000
"""Default of the largest number of engine steps of a simulation.

It suffices for sixty whole passes of a rigid bristle, or for one pass of a wire of 8 links. The
steps take 2 to 6 s of CPU time; for a wire that bends, 12 to 20 s."""

# largest number of samples in a period, more than the memory for a simulation could hold
MOST_SAMPLES = 1_000_000_000

LEAST_NEEDED = 8
MOST_NEEDED = 24
"""Smallest and largest default number of samples in a period of the bristle on its belt.

Fewer samples give a poor picture. More are not worth their computing time, although cubic
interpolation between 24 samples in a period has an error of 1e-5."""


@dataclass(frozen=True, slots=True)
class Settings(Declared):
    """Accuracy, duration, step budget and sampling of a simulation.

    ``maximum_steps`` is the number of engine steps after which a simulation stops. A step with more
    than 32 links counts once for every 32 links.

    ``samples_per_period`` is the least number of samples in a period of the bristle on its belt.
    None chooses a number from 8 to 24 such that cubic interpolation meets the accuracy, as far as
    24 samples suffice: the relative error is h^4/384 for samples at intervals of h rad of the
    oscillation.
    """

    accuracy: float = quantity(
        1e-6,
        "1e-11 <= accuracy <= 0.1: relative accuracy requested of the simulation"
        " [chosen; less than 1e-11 is more than double precision gives]",
        usual=ANY,
    )
    maximum_steps: int = MAXIMUM_STEPS
    hub_turn: float = quantity(
        4.71238898038469,
        "1e-12 <= hub_turn <= 1e6 rad: angle by which the hub turns in the pass [three quarters of a turn]",
        usual=ANY,
    )
    samples_per_period: int | None = None

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        for name in ("maximum_steps", "samples_per_period"):
            value = getattr(self, name)
            if value is None and name == "samples_per_period":
                continue
            if isinstance(value, bool) or not isinstance(value, Integral) or value < 1:
                raise ValueError(f"{name} = {shown(value)}: must be a whole number of at least 1")
            object.__setattr__(self, name, int(value))
        if self.samples > MOST_SAMPLES:
            raise ValueError(
                f"samples_per_period = {shown(self.samples_per_period)}: must be at most {MOST_SAMPLES:g}"
            )

    @property
    def samples(self) -> int:
        """Least number of samples in a period, as given or as required by the accuracy."""
        if self.samples_per_period is not None:
            return self.samples_per_period
        needed: int = math.ceil(math.tau / (384.0 * self.accuracy) ** 0.25)
        return min(max(LEAST_NEEDED, needed), MOST_NEEDED)


EVENTS = (
    "bar touch", "bar release", "strike", "workpart touch", "workpart release", "wire touch", "wire release",
    "largest retraction", "highest relative speed", "retraction limit", "jam",
)  # fmt: skip
"""Names of the events that a simulation records and that can end it."""

# name of the event at which, before the strike, the first link lags the hub most
LARGEST_RETRACTION = "largest retraction"

OBSTACLES = ("bar", "workpart", "wire")  # names of the obstacles that a wire can touch

ABSENCES = {"bar not touched": "bar touch", "workpart not reached": "strike"}
"""Names of records at the end of a simulation, with the event whose absence each one states."""


class StopReason(StrEnum):
    """Reason for which a simulation stopped; its value is the text in messages and saved files.

    Attributes:
        remedy: sentence on the change of a parameter that lets the simulation continue;
            ``{friction}`` stands for the key of the touched obstacle's coefficient of friction.
        gives_up: whether the method failed, so that the motion after the stop is missing.
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
    EVENT = "requested event", "without stop_after the run goes on"
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


def checked_name(key: str, name: object, known: Iterable[str]) -> str:
    """Return a name after a check that it is one of the known names.

    Args:
        key: name of the checked argument, for the message.
        name: the name to check.
        known: the known names.

    Raises:
        ValueError: for an unknown name; the message suggests the most similar known name.
    """
    names = tuple(known)
    if isinstance(name, str) and name in names:
        return str(name)
    likely = difflib.get_close_matches(name, names, 1) if isinstance(name, str) else []
    hint = f"; did you mean {likely[0]!r}?" if likely else ""
    raise ValueError(f"{key} = {shown(name)}: must be one of {', '.join(names)}{hint}")
