"""Measured force histories from files. Public: ``read.read_force_csv``."""
