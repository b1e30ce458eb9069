"""A compiled MuJoCo model of rods on a hub, shared by the cases.

The hub is a hinge so heavy that nothing changes its speed, a belt the stiffness of the bristle's hinge. Units are the
scene's, so that numbers are near 1.

MuJoCo's contacts are soft. With impedance near 1 the contact point obeys a = -b v - k r, whatever friction does; with a
small impedance the contact pushes with the force of such a spring and damper. As it gets stiffer it becomes the
inelastic bar. As a restitution its damping can be tuned to e* without friction, but friction then changes what it
returns: no setting makes the returned work e*^2 of that taken up.
"""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["FREE", "HARD", "SOFT", "Model", "hub", "rod"]

HUB_INERTIA = 1e12
"""In scene units: the hub's speed changes by 1e-13 of itself in a pass."""

HARD, SOFT = 0.9999, 0.01
"""Impedance of a contact that dictates its point's acceleration, the largest allowed; and of one that is a force."""

FREE = '<flag contact="disable" constraint="disable"/>'
"""Leaves out of a free motion what it does not need."""


class Model:
    """A compiled model and its data."""

    def __init__(self, world: str, integrator: str, option: str = "") -> None:
        self.library: Any = importlib.import_module("mujoco")
        text = f"""<mujoco><option integrator="{integrator}" gravity="0 0 0" cone="elliptic" tolerance="0">{option}
            </option><worldbody>{world}</worldbody></mujoco>"""
        self.model = self.library.MjModel.from_xml_string(text)
        self.data = self.library.MjData(self.model)

    def start(self, angles: tuple[float, ...], rates: tuple[float, ...], step: float) -> None:
        """Back to time 0, in a given state."""
        self.library.mj_resetData(self.model, self.data)
        self.model.opt.timestep = step
        self.data.qpos[:] = angles
        self.data.qvel[:] = rates

    def step(self, count: int) -> None:
        """So many steps in compiled code."""
        self.library.mj_step(self.model, self.data, count)


def hub(hub_radius: float, bristle: str) -> str:
    """A hub that carries a body at its rim."""
    return f"""<body><joint type="hinge" axis="0 0 1" armature="{HUB_INERTIA!r}"/>
        <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><body pos="0 {-hub_radius!r} 0">{bristle}</body></body>"""


def rod(mass: float, length: float, stiffness: float, inside: str = "") -> str:
    """A slender rod that hangs from its hinge, along (0, -1)."""
    inertia = mass * length**2 / 12.0
    return f"""<joint type="hinge" axis="0 0 1" stiffness="{stiffness!r}"/>
        <inertial pos="0 {-length / 2.0!r} 0" mass="{mass!r}" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>{inside}"""
