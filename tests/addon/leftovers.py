"""What an add-on can leave behind in Blender, as sets that can be compared."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Traces:
    """Names of what is registered in Blender.

    Attributes:
        types: registered classes: operators, panels, groups, lists.
        operators: in bpy.ops.
        properties: on the types that add-ons extend.
        handlers: functions in bpy.app.handlers, by list.
        keymaps: entries of the add-on key configuration.
        menus: functions that add-ons have put into menus and headers.
    """

    types: frozenset[str]
    operators: frozenset[str]
    properties: frozenset[str]
    handlers: frozenset[str]
    keymaps: frozenset[str]
    menus: frozenset[str]


def traces():
    """What is registered now."""
    import bpy

    extended = ("Scene", "WindowManager", "Object", "Collection", "Mesh", "Image", "Material", "Screen")
    handlers = {
        f"{name}: {function.__module__}.{function.__qualname__}"
        for name in dir(bpy.app.handlers)
        if isinstance(functions := getattr(bpy.app.handlers, name), list)
        for function in functions
    }
    addon_keys = bpy.context.window_manager.keyconfigs.addon
    registered = set(dir(bpy.types))
    return Traces(
        types=frozenset(registered),
        operators=frozenset(
            f"{area}.{name}" for area in dir(bpy.ops) for name in dir(getattr(bpy.ops, area))
        ),
        properties=frozenset(
            f"{kind}.{name}" for kind in extended for name in dir(getattr(bpy.types, kind)) if name[0] != "_"
        ),
        handlers=frozenset(handlers),
        keymaps=frozenset(
            f"{keymap.name}: {item.idname}"
            for keymap in (addon_keys.keymaps if addon_keys else ())
            for item in keymap.keymap_items
        ),
        menus=frozenset(
            f"{name}: {function.__module__}.{function.__qualname__}"
            for name in registered
            if (draw := getattr(getattr(bpy.types, name, None), "draw", None))
            and hasattr(draw, "_draw_funcs")
            for function in draw._draw_funcs
        ),
    )
