"""The motion of wires of rigid links, integrated with SciPy: an independent solution with which the
simulation by the physics engine (the package ``scene``) is compared.

The unknowns are the absolute angles of the links. The hub angle is prescribed, psi = psi_0 + omega
t. A rigid bristle is a single link. The two solutions share only the parameters, the types of the
result, the impact law, and the stiffness and damping of a wire's hinges.

The modules in reading order:

- ``mechanics`` states the equations of motion.
- ``contacts`` computes the kinematics of contacts with bar, workpart or another wire.
- ``forces`` defines states and sustained contacts, and computes the contact forces.
- ``log`` records a run.
- ``system`` holds the wires with their obstacles and sustained contacts.
- ``decisions`` resolves impacts and applies the other consequences of events.
- ``events`` lists the events that end an interval of smooth motion.
- ``crossing`` finds the times at which a function changes its sign.
- ``run`` contains the main loop.
- ``simulate`` contains the public functions.
"""

from bristle_sim.reference.simulate import (
    TooStiffError,
    simulate_reference,
    simulate_row_reference,
    strike_reference,
)

__all__ = ["TooStiffError", "simulate_reference", "simulate_row_reference", "strike_reference"]
