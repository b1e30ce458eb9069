"""The bristle's pass in one generalized coordinate, integrated with scipy: the scene's independent referee.

The bristle's angle alpha relative to the radial direction is all that moves; the hub's angle is psi = psi_0 + omega t.
With the scene it shares the parameters, the result's type and the impact law, and nothing else.

Files: ``mechanics`` the equation of motion, ``touch`` kinematics where the bristle touches, ``bar`` and ``obstacles``
what can be touched and where, ``crossing`` where a function of time changes sign, ``watch`` what is watched for,
``flight`` and ``hold`` the two kinds of motion, ``run`` flight, impact and hold in turn, ``log`` the ledger,
``simulate`` the entry.
"""

from bristle_sim.reference.simulate import simulate_reference

__all__ = ["simulate_reference"]
