"""What survey.toml says, as properties: cable, robot, blocks with their lenses, stations."""

import math

import bpy


def _redraw_setup(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.sketch import refresh_sketch

    refresh_sketch(self.id_data)


def _redraw_lens(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.lens_view import schedule

    schedule()


def _redraw_both(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    _redraw_setup(self, context)
    _redraw_lens(self, context)


def _lambda_by_hand(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    # whoever estimates sets what belongs to it afterwards
    self.property_unset("lambda_sigma")
    self.property_unset("lambda_from")
    _redraw_lens(self, context)


def _pos_named(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    self.pos_from = "CSV" if self.pos else "TRAVEL"


class CableTwinStation(bpy.types.PropertyGroup):
    """A place where the diameter is wanted; its ``name`` is the station's."""

    position: bpy.props.FloatProperty(
        name="Position",
        description="Along the axis from the first frame",
        subtype="DISTANCE",
        unit="LENGTH",
        min=0,
        precision=4,
        step=1,
        update=_redraw_setup,
    )
    provisional_mm: bpy.props.FloatProperty(
        description="Diameter of the profile there until the station is measured; 0 unknown"
    )


class CableTwinBlock(bpy.types.PropertyGroup):
    """One camera, its video and its lens; its ``name`` is the block's."""

    source: bpy.props.StringProperty(
        name="Video",
        description="Video of this camera, or a folder of images",
        subtype="FILE_PATH",
        update=_redraw_lens,
    )
    angle: bpy.props.FloatProperty(
        name="Angle",
        description="Place of the camera around the axis: 0 is +X, the right-hand rule about +Y",
        subtype="ANGLE",
        unit="ROTATION",
        step=100,
        update=_redraw_setup,
    )
    travel_in_image: bpy.props.EnumProperty(
        name="Travel in image",
        description="Direction of the image in which the robot's travel points",
        items=(
            ("right", "Right", "The robot travels towards the right edge"),
            ("left", "Left", "The robot travels towards the left edge"),
            ("up", "Up", "The robot travels towards the upper edge"),
            ("down", "Down", "The robot travels towards the lower edge"),
        ),
        update=_redraw_setup,
    )
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
    focal_in: bpy.props.EnumProperty(
        name="Focal length in",
        description="Unit of the focal length",
        items=(("PX", "Pixels", "In pixels"), ("MM", "Millimetres", "With the width of the sensor")),
        update=_redraw_both,
    )
    focal_px: bpy.props.FloatProperty(
        name="Focal length", description="In pixels", default=720, min=1, precision=2, update=_redraw_both
    )
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
        update=_redraw_lens,
    )
    principal_point_px: bpy.props.FloatVectorProperty(
        name="Principal point",
        description="In pixels from the top-left corner",
        size=2,
        min=0,
        precision=2,
        update=_redraw_lens,
    )
    lambda_known: bpy.props.BoolProperty(
        name="Lambda known", description="A value of the distortion is given; else it is estimated"
    )
    division_lambda: bpy.props.FloatProperty(
        name="Lambda",
        description="Distortion of the division model; negative is barrel",
        soft_min=-0.25,
        soft_max=0.25,
        precision=5,
        step=0.1,
        update=_lambda_by_hand,
    )
    lambda_sigma: bpy.props.FloatProperty(
        name="Sigma of lambda",
        description="Standard deviation of lambda where it was estimated or calibrated, else 0",
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
    lambda_radius: bpy.props.EnumProperty(
        name="Radius in",
        description="What the radius of lambda is measured in",
        items=(
            ("half-diagonal", "Half diagonal", "Of the image"),
            ("half-width", "Half width", "Of the image"),
            ("focal", "Focal length", "The focal length"),
            ("pixel", "Pixels", "A pixel"),
        ),
        update=_redraw_lens,
    )
    calibrated: bpy.props.BoolProperty(
        name="Calibrated", description="Focal length and lambda are trusted; else they are starting values"
    )


class CableTwinSurvey(bpy.types.PropertyGroup):
    """The survey of a scene."""

    filepath: bpy.props.StringProperty(
        name="Survey file", description="The survey.toml of this scene", subtype="FILE_PATH"
    )
    written: bpy.props.StringProperty(
        description="The survey as the file holds it (JSON): keeps digits and options that no property holds"
    )
    name: bpy.props.StringProperty(name="Name", description="Name of the survey", default="survey")
    travel: bpy.props.FloatProperty(
        name="Travel",
        description="Path of the robot between the first and the last frame: it gives the model its scale",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.46,
        min=0,
        precision=4,
        update=_redraw_setup,
    )
    travel_sigma_mm: bpy.props.FloatProperty(
        name="Its sigma (mm)",
        description="How well the travel is known, one standard deviation in millimetres",
        default=0.05,
        min=0,
        precision=3,
    )
    use_diameter: bpy.props.BoolProperty(
        name="Nominal diameter",
        description="Narrows the search, never enters a result",
        default=True,
        update=_redraw_setup,
    )
    diameter: bpy.props.FloatProperty(
        name="Diameter",
        description="Nominal diameter of the cable",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.11,
        min=0.001,
        precision=4,
        update=_redraw_setup,
    )
    standoff: bpy.props.FloatProperty(
        name="Stand-off",
        description="From the centre of a camera to the axis of the cable",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.3,
        min=0.001,
        precision=4,
        update=_redraw_setup,
    )
    synchronised: bpy.props.BoolProperty(
        name="Synchronised",
        description="All cameras share one clock: frame k of each is one moment",
        default=True,
    )
    blocks: bpy.props.CollectionProperty(type=CableTwinBlock)
    block_index: bpy.props.IntProperty(
        name="Block", description="The block that is shown", update=_redraw_lens
    )
    stations: bpy.props.CollectionProperty(type=CableTwinStation)
    station_index: bpy.props.IntProperty(name="Station", description="The station that is shown")

    def block(self) -> CableTwinBlock | None:
        """The block that is shown, or None."""
        return self.blocks[self.block_index] if 0 <= self.block_index < len(self.blocks) else None


def add_block(survey: CableTwinSurvey, count: int = 4) -> CableTwinBlock:
    """A further block, a quarter turn (or what ``count`` says) on from the last one."""
    number = len(survey.blocks)
    block = survey.blocks.add()
    block.name = f"Block{number + 1}"
    block.angle = (math.tau / count * number) % math.tau
    survey.block_index = number
    return block


classes = (CableTwinStation, CableTwinBlock, CableTwinSurvey)
