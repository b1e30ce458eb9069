"""Smooth motion: engine steps extrapolated to the requested accuracy, and how fast a scene moves by itself."""
