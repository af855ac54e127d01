"""The whole flow in a real window, by mouse and keyboard; ``make test-ui BLENDER=…``."""
