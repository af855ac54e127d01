"""From the scene's cable and the area *synthesise* to SPEC.toml, right before a rendering.

Gives a mapping laid out as the specification (docs/synth.md) and its text.  Leaves out checking: synth's own
reader does that, in its own process, and names the key.
"""

import json
import math
from collections.abc import Iterator, Mapping

import bpy

from pipeline.core.errors import StageError

from .properties.synthesise import CableTwinSynthesise
from .synthetic_cable import Inputs, asset_modifier, read_inputs, scene_cable

MOVED_M = 1e-6


def gather_spec(scene: bpy.types.Scene) -> dict[str, object]:
    """What SPEC.toml shall say.

    Raises:
        StageError: there is no cable, or it is not where the survey's frame is.
    """
    settings = scene.cabletwin.synthesise
    cable = scene_cable(scene)
    if cable is None:
        raise StageError("synthesise", "the scene has no cable", "add one in the panel Synthesise")
    rows = zip(cable.matrix_world, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)), strict=True)
    if any(abs(a - b) > MOVED_M for row, unit in rows for a, b in zip(row, unit, strict=True)):
        raise StageError(
            "synthesise",
            f"{cable.name} was moved, turned or scaled out of the survey's frame",
            "clear its location, rotation and scale (Alt G, Alt R, Alt S)",
        )
    modifier = asset_modifier(cable, "cable")
    inputs = read_inputs(modifier) if modifier else {}
    return {
        "name": settings.name,
        "seed": settings.seed,
        "cable": _cable(inputs, settings),
        "robot": _robot(inputs, settings),
        "light": {"lamp_strength": _short(settings.lamp_strength), "daylight": _short(settings.daylight)},
        "lens": _lens(settings),
        "sensor": _sensor(settings),
        "survey": {
            "calibrated": settings.calibrated,
            "lambda_given": settings.lambda_given,
            "focal_error_percent": _short(settings.focal_error_percent),
            "travel_error_percent": _short(settings.travel_error_percent),
        },
    }


def spec_toml(values: Mapping[str, object]) -> str:
    """The text of SPEC.toml."""
    return "\n".join(_table(values, "")).lstrip() + "\n"


def _cable(inputs: Inputs, settings: CableTwinSynthesise) -> dict[str, object]:
    cable: dict[str, object] = {
        "diameter_mm": _short(inputs["", "Diameter (mm)"]),
        "ovality_mm": _short(inputs["", "Ovality (mm)"]),
        "ovality_angle_deg": _degrees(inputs["", "Ovality angle"]),
        "margin_m": _short(inputs["", "Margin"]),
        "bow_mm": _short(inputs["Bow", "Bow (mm)"]),
        "bow_azimuth_deg": _degrees(inputs["Bow", "Bow azimuth"]),
        "material": {
            "kind": settings.kind,
            **{
                key: _short(getattr(settings, key))
                for key in (
                    "grain",
                    "dirt",
                    "streaks",
                    "scratches",
                    "speckle",
                    "mottling",
                    "gloss",
                    "texel_mm",
                )
            },
        },
    }
    if stations := _stations(inputs):
        cable["station"] = stations
    if inputs["Fillet", "Fillet"]:
        cable["fillet"] = {
            "height_mm": _short(inputs["Fillet", "Height (mm)"]),
            "width_mm": _short(inputs["Fillet", "Width (mm)"]),
            "pitch_m": _short(inputs["Fillet", "Pitch"]),
            "angle_deg": _degrees(inputs["Fillet", "Angle"]),
        }
    defects = [_defect(inputs, name) for name in ("Defect 1", "Defect 2") if inputs[name, name]]
    # a defect of no height is none
    if defects := [d for d in defects if d["height_mm"]]:
        cable["defect"] = defects
    return cable


def _stations(inputs: Inputs) -> list[dict[str, object]]:
    found = []
    for name in "ABCD"[: inputs["Stations", "Stations"]]:
        station: dict[str, object] = {
            "name": name,
            "position_m": _short(inputs["Stations", f"{name} position"]),
        }
        if inputs["Stations", "Own diameters"]:
            station["diameter_mm"] = _short(inputs["Stations", f"{name} diameter (mm)"])
        found.append(station)
    return found


def _defect(inputs: Inputs, name: str) -> dict[str, object]:
    height_mm = _short(inputs[name, "Height (mm)"])
    return {
        "kind": "bulge" if height_mm > 0 else "dent",
        "height_mm": abs(height_mm),
        "position_m": _short(inputs[name, "Position"]),
        "azimuth_deg": _degrees(inputs[name, "Azimuth"]),
        "length_mm": _short(inputs[name, "Length (mm)"]),
        "width_mm": _short(inputs[name, "Width (mm)"]),
    }


def _robot(inputs: Inputs, settings: CableTwinSynthesise) -> dict[str, object]:
    return {
        "cameras": settings.cameras,
        "standoff_m": _short(settings.standoff),
        "travel_m": _short(inputs["", "Travel"]),
        "frames": settings.frames,
        "travel_in_image": settings.travel_in_image,
        "synchronised": settings.synchronised,
        "sway_deg": _degrees(settings.sway),
        "sway_mm": _short(settings.sway_mm),
        "speed_wander_mm": _short(settings.speed_wander_mm),
        "mounting_deg": _degrees(settings.mounting),
        "mounting_mm": _short(settings.mounting_mm),
    }


def _lens(settings: CableTwinSynthesise) -> dict[str, object]:
    return {
        "focal_px": _short(settings.focal_px),
        "width_px": settings.width_px,
        "height_px": settings.height_px,
        "division_lambda": _short(settings.division_lambda),
        "lambda_radius": settings.lambda_radius,
        "focal_spread_percent": _short(settings.focal_spread_percent),
    }


def _sensor(settings: CableTwinSynthesise) -> dict[str, object]:
    quiet = {} if settings.noise else {"full_well_e": 0.0, "read_noise_e": 0.0}
    return {
        "exposure": _short(settings.exposure),
        **quiet,
        "motion_blur_mm": _short(settings.motion_blur_mm),
        "readout_share": _short(settings.readout_share),
        "samples": settings.samples,
        "output": settings.output,
    }


def _short(value: float) -> float:
    """A 32-bit number with the digits that were typed: it holds seven."""
    return float(f"{value:.7g}")


def _degrees(angle_rad: float) -> float:
    """Degrees of an angle; radians in 32 bits hold six digits of a round number of degrees."""
    return float(f"{math.degrees(angle_rad):.6g}")


def _table(values: Mapping[str, object], path: str) -> Iterator[str]:
    """A table's own lines, then those of the tables in it."""
    inner = []
    for key, value in values.items():
        if isinstance(value, Mapping) or (
            isinstance(value, list) and value and isinstance(value[0], Mapping)
        ):
            inner.append((f"{path}.{key}" if path else key, value))
        else:
            yield f"{key} = {_scalar(value)}"
    for place, value in inner:
        for table in value if isinstance(value, list) else [value]:
            yield ""
            yield f"[[{place}]]" if isinstance(value, list) else f"[{place}]"
            yield from _table(table, place)


def _scalar(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # JSON's escapes are TOML's, but for DEL, which TOML wants escaped too
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
