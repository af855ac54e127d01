"""State of the area *export*: where the copies go, and which."""

import bpy

FILES = (
    ("report", "report.html"),
    ("diameters", "diameters.csv"),
    ("model_glb", "model.glb"),
    ("model_ply", "model.ply"),
    ("cloud", "cloud.ply"),
    ("unrolled", "unrolled.png"),
)
"""Property and file name."""


class CableTwinExport(bpy.types.PropertyGroup):
    """What is handed on."""

    folder: bpy.props.StringProperty(
        name="Folder", description="Where the copies go; older ones are replaced", subtype="DIR_PATH"
    )
    report: bpy.props.BoolProperty(
        name="Report", description="report.html: one page with pictures, tables and plots", default=True
    )
    diameters: bpy.props.BoolProperty(
        name="Diameters (CSV)", description="diameters.csv: the stations, for a spreadsheet", default=True
    )
    model_glb: bpy.props.BoolProperty(
        name="Textured model (GLB)", description="model.glb: the cable with its texture", default=True
    )
    model_ply: bpy.props.BoolProperty(
        name="Model (PLY)", description="model.ply: the cable with a colour for each vertex", default=True
    )
    cloud: bpy.props.BoolProperty(
        name="Point cloud (PLY)", description="cloud.ply: the dense points with normals and colours"
    )
    unrolled: bpy.props.BoolProperty(
        name="Unrolled surface (PNG)", description="unrolled.png: the whole surface laid flat, to scale"
    )

    def names(self) -> tuple[str, ...]:
        """The chosen files."""
        return tuple(name for key, name in FILES if getattr(self, key))


classes = (CableTwinExport,)
