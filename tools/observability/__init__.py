"""What a survey can tell of its focal length, shown on simulated measurements (docs/accuracy.md)."""
