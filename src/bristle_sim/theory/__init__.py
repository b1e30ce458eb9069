"""Closed forms: short pure functions and the impact law."""
