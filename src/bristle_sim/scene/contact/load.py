"""The forces of all contacts of a smooth motion as one load: rigid ones and springs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.rigid import RigidContacts
from bristle_sim.scene.contact.spring import SpringForce
from bristle_sim.scene.contact.sustained import Sustained


class ContactLoad:
    """Rigid contacts and springs that act together.

    The totals are those of the rigid contacts, ``TOTALS`` each, then those of the springs, six each.

    Attributes:
        symmetric: whether it acts alike forwards and backwards in time; springs do not.
    """

    def __init__(self, scene: Scene, rigid: RigidContacts | None, springs: Sequence[Sustained]) -> None:
        """Act by rigid contacts, if there are any, and by the springs of other contacts."""
        self.symmetric = not springs
        self._rigid = rigid
        forces = [SpringForce(scene, each.obstacle, each.spring) for each in springs if each.spring is not None]
        self._parts: list[RigidContacts | SpringForce] = ([] if rigid is None else [rigid]) + [*forces]

    def begin(self, step: float) -> Callable[[], None]:
        """Reset the sums. Return a callback to run before each step."""
        if len(self._parts) == 1:
            return self._parts[0].begin(step)
        acts = [each.begin(step) for each in self._parts]

        def act() -> None:
            """Let every contact act."""
            for each in acts:
                each()

        return act

    def totals(self) -> list[float]:
        """Return what was added up, with the last step."""
        return [number for each in self._parts for number in each.totals()]

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a rigid contact would have to pull."""
        return self._rigid is not None and min(self._rigid.normal(totals)) <= 0.0
