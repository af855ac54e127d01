"""CableTwin's pipeline: from the videos of a cable-climbing robot to a measured, textured model."""
