"""The files that a run leaves for other programs: report.json, diameters.csv, model, cloud, unrolled picture.

Takes records of ``types`` and a path, writes under a temporary name, renames, and gives the path back; every
function raises StageError where the path cannot be written.  The formats are described in docs/outputs.md.
The page for people is ``page``.
"""

import csv
import io
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from pipeline.core.files import write_bytes
from pipeline.report.glb import glb_bytes
from pipeline.report.metrics import compare_with_truth, mean, mean_absolute_error_mm
from pipeline.report.ply import cloud_ply_bytes, mesh_ply_bytes
from pipeline.report.types import (
    AxisSummary,
    Cloud,
    LensEffect,
    Mesh,
    ReportData,
    StationResult,
    TruthStation,
    UnrolledPicture,
)

STATION_FIELDS = (
    "name",
    "position_m",
    "diameter_mm",
    "sigma_mm",
    "min_mm",
    "max_mm",
    "coverage_deg",
    "base_diameter_mm",
    "base_sigma_mm",
)
FORMAT = 1


def write_report_json(path: Path, data: ReportData) -> Path:
    """Write the figures of the run; the contract's keys, and further ones beside them.  NaN becomes null."""
    text = json.dumps(_finite(_report_tree(data)), indent=2, ensure_ascii=False, allow_nan=False)
    return write_bytes(path, (text + "\n").encode(), "report")


def write_diameters_csv(
    path: Path, stations: tuple[StationResult, ...], truth: tuple[TruthStation, ...] = ()
) -> Path:
    """Write one line per station; with truth given, two columns more: truth_mm and difference_mm."""
    compared = compare_with_truth(stations, truth)
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([*STATION_FIELDS, *(("truth_mm", "difference_mm") if compared else ())])
    for station in stations:
        row = [_cell(getattr(station, name)) for name in STATION_FIELDS]
        if station.name in compared:
            row += [_cell(compared[station.name].truth_mm), _cell(compared[station.name].difference_mm)]
        elif compared:
            row += ["", ""]
        writer.writerow(row)
    return write_bytes(path, stream.getvalue().encode(), "report")


def write_model_ply(path: Path, mesh: Mesh) -> Path:
    """Write the mesh as binary PLY with normals, texture coordinates and a colour per vertex."""
    return write_bytes(path, mesh_ply_bytes(mesh), "report")


def write_model_glb(path: Path, mesh: Mesh) -> Path:
    """Write the mesh with its texture as binary glTF."""
    return write_bytes(path, glb_bytes(mesh), "report")


def write_cloud_ply(path: Path, cloud: Cloud) -> Path:
    """Write the points as binary PLY with normals and colours."""
    return write_bytes(path, cloud_ply_bytes(cloud), "report")


def write_unrolled_png(path: Path, picture: UnrolledPicture) -> Path:
    """Write the unrolled surface; its scale and ranges stand in the file's text chunks and its resolution."""
    text = PngInfo()
    for key, value in _unrolled_tree(picture).items():
        text.add_text(key, str(value))
    dots_per_inch = 25.4 / picture.mm_per_px
    stream = io.BytesIO()
    image = Image.fromarray(picture.image)
    # a surface full of noise shrinks by 4 % more at the usual level 6, in four times the time
    image.save(stream, "PNG", pnginfo=text, dpi=(dots_per_inch, dots_per_inch), compress_level=3)
    return write_bytes(path, stream.getvalue(), "report")


def _report_tree(data: ReportData) -> dict[str, Any]:
    compared = compare_with_truth(data.stations, data.truth)
    tree: dict[str, Any] = {
        "format": FORMAT,
        "name": data.name,
        "length_m": data.length_m,
        "mean_diameter_mm": mean([station.diameter_mm for station in data.stations]),
        "stations": [{key: getattr(station, key) for key in STATION_FIELDS} for station in data.stations],
        "blocks": [asdict(block) for block in data.blocks],
        "axis": _axis_tree(data.axis),
        "relief": [asdict(feature) for feature in data.relief.features] if data.relief else [],
        "lens_effect": [_lens_effect_tree(effect) for effect in data.lens_effects],
        "timing_s": dict(data.timing_s),
        "peak_memory_mb": data.peak_memory_mb,
        "warnings": list(data.warnings),
    }
    if compared:
        rows = [asdict(row) for row in compared.values()]
        tree["truth"] = {"stations": rows, "mean_absolute_error_mm": mean_absolute_error_mm(compared)}
    if data.unrolled is not None:
        tree["unrolled"] = _unrolled_tree(data.unrolled)
    if data.mosaic is not None:
        tree["mosaic"] = asdict(data.mosaic)
    tree["surface_prior"] = asdict(data.surface_prior) if data.surface_prior else None
    if data.segments:
        tree["segments"] = [asdict(segment) for segment in data.segments]
    return tree


def _axis_tree(axis: AxisSummary | None) -> dict[str, Any]:
    if axis is None or not len(axis.position_m):
        return {"straightness_mm_per_m": None, "bow_mm": None, "profile": []}
    bow_mm = np.hypot(axis.bow_mm[:, 0], axis.bow_mm[:, 1])
    rows = [
        {"position_m": y_m, "x_mm": x_mm, "z_mm": z_mm}
        for y_m, (x_mm, z_mm) in zip(axis.position_m, axis.centre_mm, strict=True)
    ]
    tree = {
        "straightness_mm_per_m": axis.straightness_mm_per_m,
        "bow_mm": float(bow_mm.max()),
        "profile": rows,
    }
    if axis.sigma_mm is not None:
        tree["bow_sigma_mm"] = float(axis.sigma_mm[bow_mm.argmax()])
        for row, sigma_mm in zip(rows, axis.sigma_mm, strict=True):
            row["bow_sigma_mm"] = sigma_mm
    return tree


def _lens_effect_tree(effect: LensEffect) -> dict[str, Any]:
    return {key: value for key, value in vars(effect).items() if not key.startswith("points_")}


def _unrolled_tree(picture: UnrolledPicture) -> dict[str, Any]:
    """Scale and ranges of the picture; the same keys in report.json and in the PNG."""
    return {
        "mm_per_px": picture.mm_per_px,
        "width_px": picture.image.shape[1],
        "height_px": picture.image.shape[0],
        "theta_left_deg": picture.theta_range_deg[0],
        "theta_right_deg": picture.theta_range_deg[1],
        "y_top_m": picture.y_range_m[0],
        "y_bottom_m": picture.y_range_m[1],
    }


def _finite(value: Any) -> Any:  # noqa: ANN401 - a JSON tree
    """The tree with plain numbers, and null for what is not known (JSON has no NaN)."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, (str, bool, int)) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None


def _cell(value: str | float) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.4f}" if math.isfinite(value) else ""
