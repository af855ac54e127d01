"""The Blender extension: staged, given its wheels, packed and checked (docs/developer.md, "The extension").

``assets`` builds the asset library, ``imports`` makes the library's imports relative, ``staging`` lays out
the folder, ``packages`` says what Blender lacks, ``wheels`` fetches it, ``manifest`` names it, ``blender``
packs, checks and installs with Blender's own tools, and ``build`` is the order of all this.
"""
