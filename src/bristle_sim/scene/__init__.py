"""The time-domain simulation in pymunk.

Public: ``tool.simulate``, ``resume.resume``, and ``energetic_contact.EnergeticContact`` for scenes of one's own; the other
modules serve these.
"""
