"""One camera of a survey: its video, its place, where its POS comes from, and its lens."""

import bpy

from . import shared


def redraw_setup(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """The sketch in the view follows."""
    from ..results.sketch import refresh_sketch

    refresh_sketch(self.id_data)


def redraw_lens(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """The preview of the lens follows."""
    from ..results.lens_view import schedule

    schedule()


def _redraw_both(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    redraw_setup(self, context)
    redraw_lens(self, context)


def _lambda_by_hand(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    # whoever estimates sets what belongs to it afterwards
    self.property_unset("lambda_sigma")
    self.property_unset("lambda_from")
    redraw_lens(self, context)


def _unit_by_hand(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    if self.lambda_from == "HAND":
        redraw_lens(self, context)
    else:  # what was found is another lens in another unit
        _lambda_by_hand(self, context)


def _pos_named(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    self.pos_from = "CSV" if self.pos else "TRAVEL"


class BlockLens:
    """A camera's lens, as survey.toml's ``[block.lens]``; a part of the block."""

    focal_in: bpy.props.EnumProperty(
        name="Focal length in",
        description="Unit of the focal length",
        items=(("PX", "Pixels", "In pixels"), ("MM", "Millimetres", "With the width of the sensor")),
        update=_redraw_both,
    )
    focal_px: shared.focal_px(_redraw_both)
    focal_mm: bpy.props.FloatProperty(
        name="Focal length",
        description="In millimetres",
        default=4,
        min=0.01,
        precision=3,
        update=_redraw_both,
    )
    sensor_width_mm: bpy.props.FloatProperty(
        name="Sensor width",
        description="In millimetres",
        default=5.3,
        min=0.01,
        precision=3,
        update=_redraw_both,
    )
    use_principal_point: bpy.props.BoolProperty(
        name="Principal point",
        description="Known; else it is taken as the image's centre",
        update=redraw_lens,
    )
    principal_point_px: bpy.props.FloatVectorProperty(
        name="Principal point",
        description="In pixels from the top-left corner",
        size=2,
        min=0,
        precision=2,
        update=redraw_lens,
    )
    lambda_known: bpy.props.BoolProperty(
        name="Lambda known", description="A value of the distortion is given; else it is estimated"
    )
    division_lambda: shared.division_lambda(0.0, _lambda_by_hand)
    lambda_sigma: bpy.props.FloatProperty(
        name="Sigma of lambda",
        description="Standard deviation of lambda; 0 where none is stated: then it counts as a rough value",
        min=0,
        soft_max=0.1,
        step=0.01,
        precision=5,
    )
    lambda_from: bpy.props.EnumProperty(
        name="Lambda from",
        description="Where lambda came from",
        items=(
            ("HAND", "By hand", "Typed or read from the survey file"),
            ("EDGES", "The cable's edges", "Estimated from this camera's own video"),
            ("BOARD", "Chessboard", "Calibrated from pictures of a chessboard"),
        ),
    )
    lambda_radius: shared.lambda_radius(_unit_by_hand)
    calibrated: bpy.props.BoolProperty(
        name="Calibrated", description="Focal length and lambda are trusted; else they are starting values"
    )

    def sigma_counts(self) -> bool:
        """Whether a sigma of lambda is saved: a lambda that is unknown, or trusted, has none."""
        return self.lambda_known and not self.calibrated


class CableTwinBlock(BlockLens, bpy.types.PropertyGroup):
    """One camera, its video and its lens; its ``name`` is the block's."""

    source: bpy.props.StringProperty(
        name="Video",
        description="Video of this camera, or a folder of images",
        subtype="FILE_PATH",
        update=redraw_lens,
    )
    angle: bpy.props.FloatProperty(
        name="Angle",
        description="Place of the camera around the axis: 0 is +X, the right-hand rule about +Y",
        subtype="ANGLE",
        unit="ROTATION",
        step=100,
        update=redraw_setup,
    )
    travel_in_image: shared.travel_in_image(redraw_setup)
    pos: bpy.props.StringProperty(
        name="POS file",
        description="Measured exterior orientation (CSV); empty where it is constructed from the travel",
        subtype="FILE_PATH",
        update=_pos_named,
    )
    pos_from: bpy.props.EnumProperty(
        name="POS from",
        description="Where the exterior orientation of the frames comes from",
        items=(
            ("TRAVEL", "Travel", "Constructed from the travel: even steps along the axis, nominal attitude"),
            ("CSV", "CSV file", "Measured, read from a file"),
        ),
    )
    ordered: bpy.props.BoolProperty(
        name="In order",
        description="The images' names follow the travel at even steps",
        default=True,
    )


classes = (CableTwinBlock,)
