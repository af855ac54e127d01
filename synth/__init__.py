"""Synthetic cables and steel frames with known truth: what the pipeline is measured with.

Shares records with the pipeline and never a formula: truth comes by an independent hand.

From a specification to a survey (``python -m synth render SPEC.toml OUT``):

- ``spec``, ``spec_cable``, ``spec_reader``, ``spec_check``: SPEC.toml, read strictly into frozen records;
- ``surface``, ``texture``, ``mesh``: the true shape and look of the cable;
- ``motion``, ``lens``, ``shutter``: where each camera truly is, what it does to a point, when rows see light;
- ``scene``, ``material``, ``lens_camera``, ``tracer``, ``render``: the pictures (these need bpy);
- ``sensor``, ``video``: grey values, and H.264;
- ``truth``: truth.json, and the survey.toml that claims what the specification lets it claim;
- ``stamps``, ``files``: what is rendered already is kept.

The other half, ``scan`` (``python -m synth scan SPEC.toml OUT``): a steel space frame and a laser scanner.

From surveys to a verdict: ``suite`` and ``suite_*`` (the benchmark: every scenario and seed rendered,
reconstructed, evaluated, compared with its target), ``gate`` (a few figures between two bounds, for CI).
``child`` runs programs, ``__main__`` is the command line, ``blender`` the same renderer for the extension,
``apart`` keeps our Blender away from a person's.
"""
