"""Measured force histories from files."""
