"""State of a reconstruction: where it goes and what it is told."""

import bpy

STAGES = (
    ("frames", "Frames", "Choose the sharpest frames of each video"),
    ("lens", "Lens", "Lens distortion"),
    ("pos", "POS", "Predicted exterior orientation of each frame"),
    ("match", "Match", "Follow tie points through the frames"),
    ("adjust", "Adjust", "Bundle adjustment of each block"),
    ("closing", "Closing", "Marks that neighbouring blocks share"),
    ("joint", "Joint", "Adjustment of all cameras as one ring"),
    ("undistort", "Undistort", "Frames as a pinhole camera would have taken them"),
    ("dense", "Dense", "A point for each cell of the surface"),
    ("surface", "Surface", "Outliers out, small holes closed"),
    ("texture", "Texture", "Unrolled picture of each block"),
    ("crop", "Crop", "The limb and ragged edges cut away"),
    ("mosaic", "Mosaic", "Blocks joined"),
    ("ring", "Ring", "One surface of all blocks"),
    ("measure", "Measure", "Diameters and their uncertainty"),
    ("report", "Report", "Report and files"),
)


class CableTwinRun(bpy.types.PropertyGroup):
    """How and where the pipeline runs."""

    folder: bpy.props.StringProperty(
        name="Run folder",
        description="Where the results go; a run that was interrupted there goes on",
        subtype="DIR_PATH",
    )
    segment: bpy.props.IntProperty(
        name="Segment",
        description="Which segment of a long survey is shown, from 1; Reload shows another one",
        default=1,
        min=1,
    )
    start: bpy.props.EnumProperty(
        name="From",
        description="Make this stage and all after it again",
        items=STAGES,
        default="dense",
    )
    adjust: bpy.props.EnumProperty(
        name="Adjustment",
        description="How the cameras are oriented",
        items=(
            ("AUTO", "Automatic", "All cameras as one ring where they share a clock"),
            ("blocks", "Block by block", "Each camera alone, joined by the mosaic"),
        ),
    )
    truth: bpy.props.StringProperty(
        name="Truth",
        description="A truth.json to compare with, of a synthetic survey",
        subtype="FILE_PATH",
    )


classes = (CableTwinRun,)
