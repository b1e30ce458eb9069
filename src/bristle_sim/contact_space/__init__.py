"""Impacts between the bodies of any pymunk space, with joints between them.

Apart from NumPy, SciPy and pymunk, the package needs only the impact law; it does not depend on the
model of the bristle tool. Its modules in reading order:

- ``joints``: velocity constraints J V = b of pymunk's joints.
- ``projection``: the projection of velocities onto the closest velocities that obey the joints.
- ``impulse``: the inverse mass matrix at a contact, and the change of all velocities by an impulse.
- ``collision_rule``: two collision types with their coefficients and law; the record of an impact.
- ``touching``: the motion of bodies in the engine's last step, and the contact points at the
  instant of touch.
- ``rest_filter``: the division of a step's contacts into contacts at rest, which the engine
  resolves, and impacts, which an impact law resolves.
- ``sequence``: impacts resolved one after the other.
- ``simultaneous``: all impacts of connected bodies resolved simultaneously, if there are too many
  for a sequence.
- ``tunnelling``: a warning if a step is so long that shapes pass through each other.
- ``energetic_contact``: :class:`EnergeticContact`, the impact law in a user's own space.
"""
