"""truth.json: what the survey really was, computed from the spec alone, and the survey.toml that claims it.

Layout of truth.json: ``format`` 1; ``stations`` [{name, position_m, diameter_mm, base_diameter_mm}], where
diameter_mm is the mean over the azimuth of 2 r (fillets and defects included) and base_diameter_mm the same
without them; ``radius_mm`` {theta_deg, position_m, values}, one row of values per position, about the local
axis; ``axis`` [{position_m, x_mm, z_mm}], that axis; ``defects`` [{kind, position_m, azimuth_deg, length_mm,
width_mm, height_mm, peak_mm}], where peak_mm is how far the surface stands out over the sheath at the centre,
negative for a dent; ``poses`` {block: [{frame, cam_from_world}]}, 3 x 4; ``lenses`` {block: {...}};
``travel_m``; ``spec``.
"""

import json
import math
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from pipeline.core.vocabulary import Array
from synth.lens import block_lenses, principal_point
from synth.motion import block_poses
from synth.spec import Output, Spec
from synth.spec_reader import effective
from synth.surface import axis_m, base_radius_m, mean_diameter_mm, mean_radius_m, radius_m

RADIUS_STEP_DEG = 1.0  # a rib of 8 mm covers eight of them
RADIUS_STEP_M = 0.002
PRINCIPAL_POINT_ERROR_DIRECTION = (0.8, 0.6)  # x and y of the image


def truth_of(spec: Spec) -> dict[str, Any]:
    """Everything that evaluation compares against, as plain JSON values."""
    return {
        "format": 1,
        "stations": _stations(spec),
        "radius_mm": _radius_map(spec),
        "axis": _axis(spec),
        "defects": _defects(spec),
        "poses": _poses(spec),
        "lenses": _lenses(spec),
        "travel_m": spec.robot.travel_m,
        "spec": effective(spec),
    }


def _stations(spec: Spec) -> list[dict[str, Any]]:
    return [
        {
            "name": station.name,
            "position_m": station.position_m,
            "diameter_mm": round(mean_diameter_mm(spec.cable, station.position_m), 9),
            "base_diameter_mm": float(2000.0 * mean_radius_m(spec.cable, np.array(station.position_m))),
        }
        for station in spec.cable.station
    ]


def _radius_map(spec: Spec) -> dict[str, Any]:
    theta_deg = np.arange(0.0, 360.0, RADIUS_STEP_DEG)
    position_m = _positions_m(spec)
    values_mm = 1000.0 * radius_m(spec.cable, np.radians(theta_deg)[None, :], position_m[:, None])
    return {
        "theta_deg": theta_deg.tolist(),
        "position_m": position_m.tolist(),
        "values": np.round(values_mm, 6).tolist(),
    }


def _positions_m(spec: Spec) -> Array:
    rows = math.ceil(spec.robot.travel_m / RADIUS_STEP_M) + 1
    return np.linspace(0.0, spec.robot.travel_m, rows)


def _axis(spec: Spec) -> list[dict[str, float]]:
    position_m = _positions_m(spec)
    x_m, z_m = axis_m(spec.cable, spec.robot.travel_m, position_m)
    return [
        {"position_m": float(y), "x_mm": round(1000.0 * float(x), 9), "z_mm": round(1000.0 * float(z), 9)}
        for y, x, z in zip(position_m, x_m, z_m, strict=True)
    ]


def _defects(spec: Spec) -> list[dict[str, Any]]:
    """What the spec says of each, and what overlapping ones make of it."""
    bare = replace(spec.cable, defect=())
    found = []
    for defect in spec.cable.defect:
        place = np.array(math.radians(defect.azimuth_deg)), np.array(defect.position_m)
        peak_m = float(radius_m(spec.cable, *place) - radius_m(bare, *place))
        found.append({**asdict(defect), "kind": str(defect.kind), "peak_mm": round(1000.0 * peak_m, 9)})
    return found


def _poses(spec: Spec) -> dict[str, Any]:
    return {
        block: [
            {"frame": frame, "cam_from_world": np.column_stack([rotation, translation]).tolist()}
            for frame, (rotation, translation) in enumerate(
                zip(poses.rotations, poses.translations, strict=True)
            )
        ]
        for block, poses in zip(spec.blocks, block_poses(spec), strict=True)
    }


def _lenses(spec: Spec) -> dict[str, Any]:
    return {
        block: {
            "focal_px": lens.focal_px,
            "principal_point_px": list(lens.principal_point_px),
            "division_lambda": lens.division_lambda,
            "lambda_radius": str(lens.lambda_radius),
            "width_px": lens.width_px,
            "height_px": lens.height_px,
        }
        for block, lens in zip(spec.blocks, block_lenses(spec), strict=True)
    }


def survey_toml(spec: Spec) -> str:
    """The survey.toml of the contract, with the claims of ``spec.survey`` instead of the truth."""
    claim, robot = spec.survey, spec.robot
    lines = ["format = 1", f"name = {_text(spec.name)}", "", "[cable]"]
    lines.append(f"travel_m = {_num(robot.travel_m * (1.0 + claim.travel_error_percent / 100.0))}")
    if claim.travel_sigma_mm:
        lines.append(f"travel_sigma_mm = {_num(claim.travel_sigma_mm)}")
    if claim.diameter_given:
        lines.append(f"diameter_mm = {_num(round(2000.0 * base_radius_m(spec.cable)))}")
    for station in spec.cable.station:
        lines += [
            "[[cable.station]]",
            f"name = {_text(station.name)}",
            f"position_m = {_num(station.position_m)}",
        ]
    lines += ["", "[robot]", f"standoff_m = {_num(robot.standoff_m)}"]
    lines.append(f"synchronised = {str(robot.synchronised).lower()}")
    for index, block in enumerate(spec.blocks):
        if block not in claim.lost_blocks:
            lines += _block_lines(spec, index)
    return "\n".join(lines) + "\n"


def _block_lines(spec: Spec, index: int) -> list[str]:
    claim, lens = spec.survey, spec.lens
    lines = [
        "",
        "[[block]]",
        f'name = "{spec.blocks[index]}"',
        f'source = "{source_name(spec, index)}"',
        f"angle_deg = {_num(spec.angles_deg[index])}",
        f'travel_in_image = "{spec.robot.travel_in_image}"',
        "[block.lens]",
        f"focal_px = {_num(lens.focal_px * (1.0 + claim.focal_error_percent / 100.0))}",
    ]
    off_px = claim.principal_point_error_percent / 100.0 * lens.width_px
    if lens.principal_point_px is not None or off_px:
        x, y = np.add(principal_point(lens), off_px * np.array(PRINCIPAL_POINT_ERROR_DIRECTION))
        lines.append(f"principal_point_px = [{_num(x)}, {_num(y)}]")
    if claim.lambda_given:
        lines.append(f"division_lambda = {_num(lens.division_lambda + claim.lambda_error)}")
        lines.append(f'lambda_radius = "{lens.lambda_radius}"')
    lines.append(f"calibrated = {str(claim.calibrated).lower()}")
    return lines


def source_name(spec: Spec, index: int) -> str:
    """File or folder of a block's frames, relative to survey.toml."""
    stem = spec.blocks[index].lower()
    return f"{stem}.mp4" if spec.sensor.output == Output.VIDEO else stem


def _text(value: str) -> str:
    """A basic TOML string, which escapes as JSON does."""
    return json.dumps(value, ensure_ascii=False)


def _num(value: float) -> str:
    return repr(round(float(value), 12))
