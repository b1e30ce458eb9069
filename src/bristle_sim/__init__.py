"""Time-domain cross-check of the bristle-blasting impact model."""
