"""CableTwin's asset library, built from code: ``python -m blend_assets.build OUT`` (or ``make assets``).

- ``formula``: node trees written as formulas;
- ``cable_inputs``, ``cable``: the cable, a modifier whose inputs say what SPEC.toml says of a cable;
- ``sheath``: what it is made of, for the eye;
- ``ring``: the robot's ring with cameras and lamps;
- ``catalogue``: catalogues, and what an asset tells of itself;
- ``previews``: small pictures of the assets;
- ``library``: the order of all this;
- ``build``: the command line; it needs bpy only where something has changed.

Shares no formula with the project: the cable is another writing of the definition in
``synth.surface``, and tests hold the two against each other.
"""
