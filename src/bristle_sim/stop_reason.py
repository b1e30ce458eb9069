"""Why a run stopped, and what would let it run on: one enumeration for the scene and the reference."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

from bristle_sim.units import shown

EVENTS = (
    "bar touch", "bar release", "strike", "workpart touch", "workpart release", "wire touch", "wire release",
    "largest retraction", "highest relative speed", "retraction limit", "jam",
)  # fmt: skip
"""Events that a run records and that can end it, by name."""

LARGEST_RETRACTION = "largest retraction"  # an event: where the first link lags the hub most, before the strike

OBSTACLES = ("bar", "workpart", "wire")  # what a wire touches, by name

ABSENCES = {"bar not touched": "bar touch", "workpart not reached": "strike"}
"""Events recorded at the end of a run in which the other event never happened."""


class StopReason(StrEnum):
    """Why a run stopped; the value is the wording that people and saved files see.

    Attributes:
        remedy: what would let the run go further; ``{friction}`` stands for the key of the touched obstacle's friction.
        gives_up: whether the method failed, so that what comes after the stop is missing.
    """

    remedy: str
    gives_up: bool

    def __new__(cls, wording: str, remedy: str, gives_up: bool = False) -> StopReason:
        """Build a member from its wording, remedy and kind."""
        member = str.__new__(cls, wording)
        member._value_ = wording
        member.remedy, member.gives_up = remedy, gives_up
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
    ACCURACY = "no step is short enough for the requested accuracy", "a larger accuracy is easier", True
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

    def advice(self, obstacle: str | None = None) -> str:
        """Return the remedy with the key of the named obstacle's friction."""
        return self.remedy.format(friction="bar_friction" if obstacle == "bar" else "friction")


def checked_name(key: str, name: object, known: Iterable[str]) -> str:
    """Return a name that is known.

    Raises ValueError if nothing is called so; the message says which name is likely meant.
    """
    names = tuple(known)
    if isinstance(name, str) and name in names:
        return str(name)
    import difflib

    likely = difflib.get_close_matches(name, names, 1) if isinstance(name, str) else []
    hint = f"; did you mean {likely[0]!r}?" if likely else ""
    raise ValueError(f"{key} = {shown(name)}: must be one of {', '.join(names)}{hint}")
