"""A Blender of our own that leaves a person's Blender alone.

``read_factory_settings`` knows of no extensions, so it deletes the packages that the extensions in the user's
folder have brought: those of a Blender that a person uses, this very extension's among them.
"""

import atexit
import os
import shutil
import tempfile

VARIABLE = "BLENDER_USER_RESOURCES"


def keep_apart() -> None:
    """Give Blender a user folder of this process; call before bpy is imported.  One that is named is kept."""
    if VARIABLE not in os.environ:
        folder = os.environ[VARIABLE] = tempfile.mkdtemp(prefix="cabletwin-blender-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
