"""Figures and off-screen video; never steps physics."""
