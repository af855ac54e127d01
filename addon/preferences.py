"""What belongs to the person and not to a survey: language of the report, size of the displayed clouds."""

import bpy


class CABLETWIN_preferences(bpy.types.AddonPreferences):
    """The add-on's preferences."""

    bl_idname = __package__ or ""

    report_language: bpy.props.EnumProperty(
        name="Report language",
        description="Language in which the report opens",
        items=(("en", "English", "English"), ("zh", "Chinese", "Simplified Chinese")),
    )
    cloud_points: bpy.props.IntProperty(
        name="Points shown",
        description="Most points of a cloud that are loaded; larger clouds are thinned evenly, files are not",
        default=2_000_000,
        min=1000,
        soft_max=10_000_000,
    )

    def draw(self, context: bpy.types.Context) -> None:
        """Show the two settings."""
        self.layout.use_property_split = True
        self.layout.prop(self, "report_language")
        self.layout.prop(self, "cloud_points")


def preferences(context: bpy.types.Context) -> CABLETWIN_preferences:
    """The add-on's preferences."""
    return context.preferences.addons[__package__].preferences


register, unregister = bpy.utils.register_classes_factory((CABLETWIN_preferences,))
