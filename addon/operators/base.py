"""What all operators share: the pipeline's one sentence becomes Blender's report."""

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


def take_out(items: bpy.types.bpy_prop_collection, index: int) -> int:
    """Remove an item of a list; gives the index of the one to show then, 0 in an empty list."""
    items.remove(index)
    return max(min(index, len(items) - 1), 0)
