"""What all operators share: the pipeline's one sentence becomes Blender's report."""

import bpy

from pipeline.core.errors import Cancelled, StageError


class Operator(bpy.types.Operator):
    """An operator whose ``work`` may raise StageError; not registered itself."""

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do the work, or say in one sentence why not."""
        try:
            self.work(context)
        except StageError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except Cancelled:
            self.report({"INFO"}, "Cancelled")
            return {"CANCELLED"}
        return {"FINISHED"}

    def work(self, context: bpy.types.Context) -> None:
        """Gather, call, apply."""
        raise NotImplementedError
