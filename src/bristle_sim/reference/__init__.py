"""The pass of wires of rigid links, integrated with SciPy: an independent solution to compare with
the scene.

The unknowns are the absolute angles of the links; the hub angle is psi = psi_0 + omega t. A rigid
bristle is a single link. The reference shares with the scene only the parameters, the types of the
result, the impact law, and the stiffness and damping of a wire's hinges.

Modules: ``mechanics`` has the equations of motion, ``contacts`` the kinematics of contacts with
bar, workpart or another wire, ``forces`` a state, sustained contacts and their forces, ``log`` the
record of a run, ``system`` the wires among their obstacles, ``decisions`` the impacts and other
consequences of events, ``events`` the ends of intervals of smooth motion, ``crossing`` the search
for changes of sign, ``run`` the main loop, and ``simulate`` the functions to call.
"""

from bristle_sim.reference.simulate import (
    TooStiffError,
    simulate_reference,
    simulate_row_reference,
    strike_reference,
)

__all__ = ["TooStiffError", "simulate_reference", "simulate_row_reference", "strike_reference"]
