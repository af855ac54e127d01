"""Figures and sentences of the panel *Steel structure*, in the person's language and the scene's units."""

import bpy
from bpy.app.translations import pgettext_iface as translated
from bpy.app.translations import pgettext_n as n_

WINDS = {
    "north": n_("north"),
    "north-east": n_("north-east"),
    "east": n_("east"),
    "south-east": n_("south-east"),
    "south": n_("south"),
    "south-west": n_("south-west"),
    "west": n_("west"),
    "north-west": n_("north-west"),
    "nowhere": n_("nowhere"),
}
_MM_PER_INCH = 25.4


def size_text(scene: bpy.types.Scene, size_mm: float, digits: int = 1) -> str:
    """A small length in millimetres, in inches where the scene is imperial; a dash where it is not known."""
    if size_mm < 0:
        return "–"
    if scene.unit_settings.system == "IMPERIAL":
        return f"{size_mm / _MM_PER_INCH:.{digits + 2}f} in"
    return f"{size_mm:.{digits}f} mm"


def gross_text(scene: bpy.types.Scene, item: bpy.types.PropertyGroup) -> str:
    """One line about a gross error."""
    if item.kind == "moved":
        text = translated("{target} moved by {size}: {stations}")
    elif item.fits:
        text = translated("{target} is {fits} in {stations}")
    else:
        text = translated("{target} is misnamed in {stations}")
    size = size_text(scene, item.size_mm)
    return text.format(target=item.target, size=size, stations=item.stations, fits=item.fits)
