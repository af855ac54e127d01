"""State of the area *crop*: what is cut away of each block, and whether a preview of it is shown."""

import math

import bpy


def _preview(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.crop_preview import refresh_preview

    if self.previewing:
        refresh_preview(self.id_data)


class CableTwinCropShare(bpy.types.PropertyGroup):
    """How much of a block stays; its ``name`` is the block's."""

    share: bpy.props.FloatProperty(name="Stays", description="Share of the surface that stays", min=0, max=1)


class CableTwinCrop(bpy.types.PropertyGroup):
    """Options of the stage, as ``[options.crop]`` holds them, and the preview.

    Angles are in radians and lengths in metres, as Blender wants them; :mod:`addon.gather` converts.
    """

    incidence: bpy.props.FloatProperty(
        name="Angle",
        description="Largest angle between the line of sight and the surface's normal",
        subtype="ANGLE",
        unit="ROTATION",
        default=math.radians(62),
        min=math.radians(1),
        max=math.radians(85),
        step=50,
        precision=2,
        update=_preview,
    )
    least_score: bpy.props.FloatProperty(
        name="Agreement",
        description="Smallest agreement of the frames",
        default=0.2,
        min=0,
        max=1,
        step=1,
        precision=2,
        update=_preview,
    )
    fringe: bpy.props.FloatProperty(
        name="Fringe",
        description="Protrusions and islands narrower than this are cut",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.003,
        min=0,
        soft_max=0.02,
        step=0.01,
        precision=4,
        update=_preview,
    )
    use_start: bpy.props.BoolProperty(
        name="Start at", description="Cut what lies before a station", update=_preview
    )
    start: bpy.props.FloatProperty(
        name="Start at",
        description="Along the axis from the first frame",
        subtype="DISTANCE",
        unit="LENGTH",
        step=1,
        precision=4,
        update=_preview,
    )
    use_end: bpy.props.BoolProperty(
        name="End at", description="Cut what lies behind a station", update=_preview
    )
    end: bpy.props.FloatProperty(
        name="End at",
        description="Along the axis from the first frame",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.4,
        step=1,
        precision=4,
        update=_preview,
    )
    previewing: bpy.props.BoolProperty(description="What is cut is shown on the uncropped blocks")
    shares: bpy.props.CollectionProperty(type=CableTwinCropShare)
    message: bpy.props.StringProperty(description="Why the options cannot be used")
    hidden: bpy.props.StringProperty(description="Collections that the preview has hidden, one a line")


classes = (CableTwinCropShare, CableTwinCrop)
