"""What operators share: the pipeline's one sentence becomes Blender's report; a folder is asked for."""

from pathlib import Path

import bpy

from pipeline.core.errors import Cancelled, StageError

from ..wording import framed


class Operator(bpy.types.Operator):
    """An operator whose ``work`` may raise StageError; not registered itself."""

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do the work, or say in one sentence why not."""
        try:
            self.work(context)
        except StageError as error:
            self.report({"ERROR"}, framed(str(error)))
            return {"CANCELLED"}
        except Cancelled:
            self.report({"INFO"}, "Cancelled")
            return {"CANCELLED"}
        return {"FINISHED"}

    def work(self, context: bpy.types.Context) -> None:
        """Gather, call, apply."""
        raise NotImplementedError


class FolderChoice:
    """What an operator that opens a run folder has beside ``Operator``; it says how in ``show``."""

    directory: bpy.props.StringProperty(subtype="DIR_PATH", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the folder."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context: bpy.types.Context) -> None:
        """Read and show."""
        self.show(context, Path(bpy.path.abspath(self.directory)))

    def show(self, context: bpy.types.Context, folder: Path) -> None:
        """Show what the folder holds, and have the scene remember it where that went well."""
        raise NotImplementedError


def take_out(items: bpy.types.bpy_prop_collection, index: int) -> int:
    """Remove an item of a list; gives the index of the one to show then, 0 in an empty list."""
    items.remove(index)
    return max(min(index, len(items) - 1), 0)
