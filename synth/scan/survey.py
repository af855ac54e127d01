"""survey.toml of a scan: what a surveyor would write of it, without any truth."""

import json
from collections.abc import Sequence

import numpy as np

from pipeline.core.errors import StageError
from synth.scan.frame import Column, Frame
from synth.scan.layout import Layout
from synth.scan.lists import Sighting
from synth.scan.spec import STAGE, Level, ScanSpec
from synth.scan.truth import Site

PHOTOS = "photos"
CONTROL_SEED = 251
LEAST_SIGMA = 0.01  # a survey may not claim that there is no noise at all


def survey_toml(spec: ScanSpec, frame: Frame, layout: Layout) -> str:
    """The survey.toml of the contract."""
    lines = ["format = 1", 'kind = "steel"', f"name = {json.dumps(spec.name, ensure_ascii=False)}", ""]
    lines += _scanner(spec)
    for station in layout.stations:
        lines += ["", "[[station]]", f'name = "{station.name}"']
        if spec.level == Level.CLOUDS:
            lines += [f'cloud = "{cloud_name(spec, station.name)}"', f'unit = "{spec.scanner.unit}"']
        if writes_lists(spec):
            lines.append(f'targets = "{list_name(station.name)}"')
    lines += _control(spec, layout)
    lines += ["", *_structure(spec, frame, layout)]
    if spec.photos is not None:
        focal_px = spec.photos.focal_px * (1.0 + spec.photos.focal_error_percent / 100.0)
        lines += ["", "[photos]", f'source = "{PHOTOS}"', f"focal_px = {_num(focal_px)}"]
    site = Site(layout)
    for column in frame.columns:
        lines += ["", *_column(column, site)]
    return "\n".join(lines) + "\n"


def writes_lists(spec: ScanSpec) -> bool:
    """Whether the targets' lists are part of the survey."""
    return spec.level == Level.TARGETS or spec.survey.lists


def cloud_name(spec: ScanSpec, station: str) -> str:
    """File of a station's cloud, relative to survey.toml."""
    return f"clouds/{station}.{spec.scanner.format}"


def list_name(station: str) -> str:
    """File of a station's targets, relative to survey.toml."""
    return f"targets/{station}.csv"


def list_csv(spec: ScanSpec, sightings: Sequence[Sighting]) -> str:
    """A station's list: name,x,y,z[,sigma_mm], metres."""
    lines = ["name,x,y,z,sigma_mm" if spec.survey.named_sigma else "name,x,y,z"]
    for sighting in sightings:
        row = ",".join([sighting.name, *(f"{value:.6f}" for value in sighting.place)])
        lines.append(f"{row},{sighting.sigma_mm:.4f}" if spec.survey.named_sigma else row)
    return "\n".join(lines) + "\n"


def _scanner(spec: ScanSpec) -> list[str]:
    lines = [
        "[scanner]",
        f"range_sigma_mm = {_num(max(spec.scanner.range_sigma_mm, LEAST_SIGMA))}",
        f"angle_sigma_arcsec = {_num(max(spec.scanner.angle_sigma_arcsec, LEAST_SIGMA))}",
        "levelled = true",
    ]
    if spec.stations.level_sigma_arcsec > 0.0:
        lines.append(f"level_sigma_arcsec = {_num(spec.stations.level_sigma_arcsec)}")
    return [*lines, "", "[targets]", f"radius_mm = {_num(spec.targets.radius_mm)}"]


def _control(spec: ScanSpec, layout: Layout) -> list[str]:
    site, rng = Site(layout), np.random.default_rng([spec.seed, CONTROL_SEED])
    places = {target.name: target.centre for target in layout.targets}
    lines: list[str] = []
    for name in spec.survey.control:
        if name not in places:
            raise StageError(STAGE, f"survey.control names {name}", f"use T01 to {list(places)[-1]}")
        off_m = spec.survey.control_sigma_mm / 1000.0 * rng.standard_normal(3)
        place = ", ".join(_num(round(float(v), 6)) for v in site.point(places[name]) + off_m)
        lines += ["", "[[control]]", f'name = "{name}"', f"position_m = [{place}]"]
        lines.append(f"sigma_mm = {_num(spec.survey.control_sigma_mm)}")
    return lines


def _structure(spec: ScanSpec, frame: Frame, layout: Layout) -> list[str]:
    lines, structure = (
        ["[structure]", f"north_deg = {_num(round(Site(layout).north_deg, 4))}"],
        spec.structure,
    )
    if spec.survey.nominal:
        rods = sorted({structure.chord_diameter_mm, structure.diagonal_diameter_mm})
        lines += [
            f"rod_diameters_mm = [{', '.join(_num(rod) for rod in rods)}]",
            f"ball_diameters_mm = [{_num(structure.ball_diameter_mm)}]",
            f"column_diameters_mm = [{_num(structure.column_diameter_mm)}]",
        ]
    lines.append(f"span_m = {_num(frame.span_m)}")
    lines.append(f"deflection_limit = {_num(spec.survey.deflection_limit)}")
    return [*lines, f"column_limit_mm = {_num(spec.survey.column_limit_mm)}"]


def _column(column: Column, site: Site) -> list[str]:
    """Its place to a decimetre, as read off a plan; the heights as they will be judged."""
    bottom, top = site.point(column.bottom), site.point(column.top)
    place = np.round((bottom + top)[:2] / 2.0, 1)
    return [
        "[[column]]",
        f'name = "{column.name}"',
        f"place_m = [{_num(place[0])}, {_num(place[1])}]",
        f"bottom_m = {_num(round(float(bottom[2]), 4))}",
        f"top_m = {_num(round(float(top[2]), 4))}",
    ]


def _num(value: float) -> str:
    return repr(round(float(value), 12))
