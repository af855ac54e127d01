"""Synth inside a Blender program, which starts ``__main__.py`` of this folder with ``--python``."""
