"""CableTwin inside Blender: gathers what a person says, calls the pipeline, and shows what it found.

The rooms, in the order in which they are registered:

- ``translations``: English to Simplified Chinese, by area;
- ``preferences``: what belongs to the person and not to a survey;
- ``properties``: the state, one group for each area, all under ``Scene.cabletwin``; the job that runs
  under ``WindowManager.cabletwin_job``;
- ``operators``: what a button does, by area; thin;
- ``panels``: the sidebar tab, by area, in the order of the work.

- ``opened``: the run that a scene shows, kept in memory until another file is loaded;
- ``results.lens_view``: the preview of a lens, which follows undo;
- ``overlay``: what is written over the 3D views.

Beside them: ``gather`` and ``apply`` turn properties into the pipeline's records and back, ``jobs`` runs the
command line in a process of its own, ``results`` builds the datablocks, ``library`` knows where the staged
pipeline and the bundled wheels lie.  No algorithm is here: those are in ``pipeline``.
"""

from . import opened, operators, overlay, panels, preferences, properties, translations
from .results import lens_view

_ROOMS = (translations, preferences, properties, opened, lens_view, operators, panels, overlay)


def register() -> None:
    """Add everything to Blender."""
    for room in _ROOMS:
        room.register()


def unregister() -> None:
    """Take everything out again, in reverse."""
    for room in reversed(_ROOMS):
        room.unregister()
