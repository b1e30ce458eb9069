"""The time-domain simulation in pymunk."""
