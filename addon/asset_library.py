"""The extension's asset library: where it lies, taking assets out of it, telling Blender of it.

Blender learns of the library only when a person asks for it: its place is then in the preferences.
"""

from pathlib import Path

import bpy

from pipeline.core.errors import StageError

NAME = "CableTwin"
FOLDER = "assets"
FILE = "cabletwin.blend"


def library_folder() -> Path:
    """The folder of the library, which tools/extension puts into the extension.

    Raises:
        StageError: it is not there.
    """
    folder = Path(__file__).resolve().parent / FOLDER
    if not (folder / FILE).is_file():
        raise StageError("assets", f"{folder / FILE} is missing", "install the extension again")
    return folder


def append_object(name: str) -> bpy.types.Object:
    """A copy of one of the library's objects, in no collection yet."""
    with bpy.data.libraries.load(str(library_folder() / FILE)) as (source, target):
        target.objects = [n for n in source.objects if n == name]
    return _own(target.objects)


def append_collection(name: str) -> bpy.types.Collection:
    """A copy of one of the library's collections, in no scene yet."""
    with bpy.data.libraries.load(str(library_folder() / FILE)) as (source, target):
        target.collections = [n for n in source.collections if n == name]
    return _own(target.collections)


def is_known(context: bpy.types.Context) -> bool:
    """Whether the preferences name the library already."""
    here = Path(__file__).resolve().parent / FOLDER
    return any(Path(known.path) == here for known in context.preferences.filepaths.asset_libraries)


def make_known(context: bpy.types.Context) -> None:
    """Name the library in the preferences, so that the Asset Browser shows it.

    Raises:
        StageError: it is not there.
    """
    folder = library_folder()
    if not is_known(context):
        context.preferences.filepaths.asset_libraries.new(name=NAME, directory=str(folder))
        context.preferences.is_dirty = True


def _own(found: list[bpy.types.ID]) -> bpy.types.ID:
    """The asset as part of this file, no asset any more."""
    if not found or found[0] is None:
        raise StageError("assets", f"{FILE} lacks what it should hold", "install the extension again")
    found[0].asset_clear()
    found[0].use_fake_user = False
    return found[0]
