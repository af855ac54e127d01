"""State of the area *measure*: how sections and deviations are drawn, what is known between stations."""

from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from pipeline.opened import OpenedRun

SAME_PLACE_M = 5e-6
"""Positions closer than this are one: Blender keeps them in 32 bits."""


def _redraw_sections(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.stations import redraw_sections

    redraw_sections(self.id_data)


def _colour_surface(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.deviation import colour_surface
    from ..results.view import show_colours

    colour_surface(self.id_data)
    show_colours(context, self.id_data)


class CableTwinProfilePoint(bpy.types.PropertyGroup):
    """A place of the profile along the cable; NaN where too little was seen."""

    position_m: bpy.props.FloatProperty()
    diameter_mm: bpy.props.FloatProperty()
    sigma_mm: bpy.props.FloatProperty()
    centre_mm: bpy.props.FloatVectorProperty(size=2)


class CableTwinFeature(bpy.types.PropertyGroup):
    """Something that stands out of the surface."""

    kind: bpy.props.StringProperty()
    height_mm: bpy.props.FloatProperty()
    sigma_mm: bpy.props.FloatProperty()
    position_m: bpy.props.FloatProperty()
    azimuth_deg: bpy.props.FloatProperty()
    length_mm: bpy.props.FloatProperty()
    width_mm: bpy.props.FloatProperty()


class CableTwinMeasure(bpy.types.PropertyGroup):
    """How the measured surface is looked at."""

    profile: bpy.props.CollectionProperty(type=CableTwinProfilePoint)
    features: bpy.props.CollectionProperty(type=CableTwinFeature)
    mean_diameter_mm: bpy.props.FloatProperty()
    factor: bpy.props.FloatProperty(
        name="Exaggeration",
        description="How much larger than true the section's deviation from its mean circle is drawn",
        default=20,
        min=1,
        soft_max=200,
        max=1000,
        precision=0,
        step=100,
        update=_redraw_sections,
    )
    colour_by: bpy.props.EnumProperty(
        name="Surface",
        description="What the colour of the surface shows",
        items=(
            ("TEXTURE", "Texture", "The surface as the cameras saw it"),
            (
                "MEAN",
                "Deviation from mean",
                "Distance from a tube of the mean diameter about the axis",
            ),
            ("NOMINAL", "Deviation from nominal", "Distance from a tube of the nominal diameter"),
            ("BASE", "Relief", "Height over the base surface: what stands proud or is dented"),
        ),
        update=_colour_surface,
    )
    limit_mm: bpy.props.FloatProperty(
        name="Range (mm)",
        description="Deviation at which the colours end, outwards and inwards, in millimetres",
        default=0.5,
        min=0.01,
        soft_max=5,
        max=100,
        precision=2,
        step=5,
        update=_colour_surface,
    )

    def take(self, run: "OpenedRun") -> None:
        """Keep what is known between the stations."""
        self.profile.clear()
        self.features.clear()
        measured = run.measurement
        if measured is None:
            self.property_unset("mean_diameter_mm")
            return
        from pipeline.report.deviation import mean_diameter_mm

        self.mean_diameter_mm = mean_diameter_mm(measured)
        for row in range(len(measured.profile_y_m)):
            point = self.profile.add()
            point.position_m = measured.profile_y_m[row]
            point.diameter_mm = measured.profile_diameter_mm[row]
            point.sigma_mm = measured.profile_sigma_mm[row]
            point.centre_mm = measured.profile_centre_mm[row]
        for feature in measured.relief.features:
            item = self.features.add()
            item.kind = feature.kind.value
            for key in ("height_mm", "sigma_mm", "position_m", "azimuth_deg", "length_mm", "width_mm"):
                setattr(item, key, getattr(feature, key))


def measured_at(results: bpy.types.PropertyGroup, position_m: float) -> bpy.types.PropertyGroup | None:
    """The measured station at a place, or None: a station that was moved since is not measured."""
    return next((s for s in results.stations if abs(s.position_m - position_m) < SAME_PLACE_M), None)


classes = (CableTwinProfilePoint, CableTwinFeature, CableTwinMeasure)
