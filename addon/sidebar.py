"""The tab of the sidebar that all panels share, and drawing it anew without drawing anything else."""

import bpy

TAB = "CableTwin"
"""Name of the tab."""

_UNTOLD = "UNSUPPORTED"
"""What Blender says of a sidebar that was never drawn."""


def redraw_sidebars(context: bpy.types.Context) -> None:
    """Draw the tab again where it is open, and not the views.

    A view that is drawn once is drawn eight times more, while Blender smooths its edges; on a machine without
    a graphics card each of these takes a third of a second.
    """
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI" and region.active_panel_category in {TAB, _UNTOLD}:
                        region.tag_redraw()
