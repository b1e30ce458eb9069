"""Integration of smooth motion: engine steps extrapolated to the requested accuracy, and a scene's time scales."""
