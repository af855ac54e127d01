"""Synthetic scans of a steel space frame, with known truth: ``python -m synth scan SPEC.toml OUT``.

- ``spec``, ``spec_hall``: SPEC.toml, read strictly;
- ``frame``: the structure as built; ``layout``: where stations and targets stand;
- ``primitives``: the world as exact surfaces; ``hits``: one surface against many rays;
- ``cable``: a stay cable in the hall, for bringing its photo model and a scan together;
- ``panorama``: a station's rays against all surfaces; ``scanner``: noise, mixed pixels, losses;
- ``lists``: targets noted by hand, gross errors among them;
- ``clouds``: the file formats; ``truth``, ``survey``: truth.json and survey.toml;
- ``flight``: where photos are taken; ``mesh``, ``photo_scene``, ``photos``: how (the last two need bpy);
- ``blender_rays``: Blender's own ray casting, the tests' second opinion on ``panorama`` (needs bpy);
- ``run``: the order of things.
"""
