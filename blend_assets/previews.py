"""Small pictures of the assets for the Asset Browser, rendered with Cycles on the CPU.

Takes an asset and what shall stand before the camera; gives the asset its preview.  Samples,
seed and size are fixed, so the same code gives the same picture.
"""

from collections.abc import Iterable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

SIZE_PX = 256
SAMPLES = 32


class Studio:
    """A scene with a camera and three lamps.

    Args:
        work: folder for the picture while it is made.
    """

    def __init__(self, work: Path) -> None:
        self._file = work / "preview.png"
        self.scene = bpy.context.scene
        render, cycles = self.scene.render, self.scene.cycles
        render.engine = "CYCLES"
        render.resolution_x = render.resolution_y = SIZE_PX
        render.threads_mode, render.threads = "FIXED", 2
        render.film_transparent = True
        render.image_settings.media_type = "IMAGE"
        render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGBA"
        render.filepath = str(self._file)
        cycles.device, cycles.samples, cycles.seed = "CPU", SAMPLES, 1
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        self.scene.view_settings.view_transform = "Standard"
        self.scene.world = bpy.data.worlds.new("Studio")
        self._background()
        self._camera = self._placed("Camera", bpy.data.cameras.new("Camera"))
        self._camera.data.lens, self._camera.data.clip_start = 70.0, 0.001
        self.scene.camera = self._camera
        for name, place, watts, size in (
            ("Key", (0.9, -0.5, 1.0), 8.0, 0.5),
            ("Fill", (0.3, -1.2, 0.3), 3.0, 0.8),
            ("Rim", (-0.9, 0.9, 0.7), 8.0, 0.4),
        ):
            data = bpy.data.lights.new(name, "AREA")
            data.energy, data.size = watts, size
            self._look(self._placed(name, data), Vector(place), Vector((0.0, 0.1, 0.0)))

    def picture(
        self,
        asset: bpy.types.ID,
        shown: Iterable[bpy.types.Object],
        eye: tuple[float, ...],
        at: tuple[float, ...],
    ) -> None:
        """Render some objects and give the picture to the asset.

        Args:
            asset: what gets the preview.
            shown: put into the scene for the time.
            eye, at: places of the camera and of what it looks at, metres.
        """
        shown = tuple(shown)
        for item in shown:
            self.scene.collection.objects.link(item)
        self._look(self._camera, Vector(eye), Vector(at))
        bpy.ops.render.render(write_still=True)
        for item in shown:
            self.scene.collection.objects.unlink(item)
        image = bpy.data.images.load(str(self._file))
        pixels = np.empty(SIZE_PX * SIZE_PX * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        preview = asset.preview_ensure()
        preview.image_size = (SIZE_PX, SIZE_PX)
        preview.image_pixels_float.foreach_set(pixels)

    def _background(self) -> None:
        nodes = self.scene.world.node_tree.nodes
        sky = next(node for node in nodes if node.bl_idname == "ShaderNodeBackground")
        sky.inputs["Color"].default_value = (0.55, 0.65, 0.8, 1.0)
        sky.inputs["Strength"].default_value = 0.35

    def _placed(self, name: str, data: bpy.types.ID) -> bpy.types.Object:
        made = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(made)
        return made

    def _look(self, item: bpy.types.Object, eye: Vector, at: Vector) -> None:
        item.location = eye
        item.rotation_euler = (at - eye).to_track_quat("-Z", "Y").to_euler()


def set_input(item: bpy.types.Object, panel: str, name: str, value: float | bool) -> None:
    """Set one input of an object's only modifier by its names."""
    modifier = item.modifiers[0]
    socket = next(
        s
        for s in modifier.node_group.interface.items_tree
        if s.item_type == "SOCKET" and s.name == name and (s.parent.name if s.parent else "") == panel
    )
    getattr(modifier.properties.inputs, socket.identifier).value = value
    item.update_tag()
