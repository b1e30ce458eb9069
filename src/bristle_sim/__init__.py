"""Time-domain cross-check of the bristle-blasting impact model."""

__version__ = "0.1.0"
