"""The shared vocabulary, geometry, lens, fits, and the run folder; knows nothing of stages."""
