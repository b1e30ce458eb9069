"""The pass of wires of rigid links, integrated with scipy: an independent solution that the scene is compared with.

The links' absolute angles are the unknowns; the hub's angle is psi = psi_0 + omega t. One link is the rigid bristle. It
shares only these with the scene: the parameters, the types of the result, the impact law, and the stiffness and damping of
a wire's hinges.

Files: ``mechanics`` equations of motion, ``contacts`` kinematics of a touch of bar, workpart or another wire, ``forces``
forces of sustained contacts, ``system`` a state with its contacts, ``events`` the ends of intervals of smooth motion,
``crossing`` the search for them and for extremes, ``decisions`` their consequences and impacts, ``run`` the loop, ``log``
the record, ``simulate`` the entries.
"""

from bristle_sim.reference.simulate import (
    TooStiffError,
    simulate_reference,
    simulate_row_reference,
    strike_reference,
)

__all__ = ["TooStiffError", "simulate_reference", "simulate_row_reference", "strike_reference"]
