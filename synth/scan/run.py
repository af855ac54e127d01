"""The order of things: frame, layout, lists, clouds, truth, survey; no algorithm.

Resumes: clouds and photos that an interrupted run of the same specification left are kept.
"""

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from synth.files import write_text
from synth.scan.cable import read_cable
from synth.scan.clouds import write_cloud
from synth.scan.frame import Frame, build_frame
from synth.scan.layout import Layout, build_layout
from synth.scan.lists import Sighting, station_lists
from synth.scan.primitives import build_world
from synth.scan.scanner import scan
from synth.scan.spec import Level, ScanSpec, check_scan_spec
from synth.scan.survey import PHOTOS, cloud_name, list_csv, list_name, survey_toml, writes_lists
from synth.scan.truth import truth_of
from synth.spec_reader import effective

Lists = tuple[tuple[Sighting, ...], ...]

STAMP = "scan_stamp.json"
VERSION = 1  # raise it when the same specification gives other clouds or photos


@dataclass(frozen=True, kw_only=True)
class Scanned:
    """What came of it: the survey.toml; new points, rays cast for them, and the seconds that casting took."""

    survey: Path
    points: int
    rays: int
    seconds: float


def scan_survey(spec: ScanSpec, out: Path, emit: Emit) -> Scanned:
    """Make a whole synthetic survey.

    Args:
        spec: what to scan.
        out: folder of the products; made if missing.
        emit: progress, a thousandth of a station at a time.

    Raises:
        StageError: the specification is impossible, or the folder cannot be written or is not synth's.
        Cancelled: from ``emit``.
    """
    check_scan_spec(spec)
    frame = build_frame(spec)
    layout = build_layout(spec, frame)
    lists = station_lists(spec, frame, layout)
    _open(spec, out)
    try:
        return _make(spec, frame, layout, lists, out, emit)
    except OSError as error:
        raise StageError(
            "scan", f"{out} cannot be written ({error})", "check the space on the disk"
        ) from error


def _make(spec: ScanSpec, frame: Frame, layout: Layout, lists: Lists, out: Path, emit: Emit) -> Scanned:
    if writes_lists(spec):
        for station, sightings in zip(layout.stations, lists, strict=True):
            write_text(out / list_name(station.name), list_csv(spec, sightings))
    if spec.photos is not None:
        from synth.scan.photos import take_photos  # bpy takes seconds to load: only where it is wanted

        take_photos(spec, spec.photos, build_world(spec, frame, layout, 0), out / PHOTOS, emit)
    points, rays, seconds = (
        _clouds(spec, frame, layout, out, emit) if spec.level == Level.CLOUDS else (0, 0, 0.0)
    )
    write_text(out / "truth.json", json.dumps(truth_of(spec, frame, layout, lists)))
    write_text(out / "survey.toml", survey_toml(spec, frame, layout))
    return Scanned(survey=out / "survey.toml", points=points, rays=rays, seconds=seconds)


def _clouds(spec: ScanSpec, frame: Frame, layout: Layout, out: Path, emit: Emit) -> tuple[int, int, float]:
    points = rays = 0
    seconds = 0.0
    total = 1000 * len(layout.stations)
    for number, station in enumerate(layout.stations):
        path = out / cloud_name(spec, station.name)
        if path.exists():
            continue
        world = build_world(spec, frame, layout, number).seen_from(station.rotation, station.centre)
        places, strengths = [], []
        for band in scan(world, spec.scanner, (spec.seed, number)):
            places.append(band.points)
            strengths.append(band.intensity)
            rays, seconds = rays + band.rays, seconds + band.seconds
            done = 1000 * number + round(1000 * band.share)
            emit(Event(stage="scan", done=done, total=total, block=station.name))
        cloud = np.concatenate(places)
        if not len(cloud):
            raise StageError("scan", f"{station.name} sees nothing", "check scanner.max_range_m")
        write_cloud(path, cloud, np.concatenate(strengths), spec.scanner.format, spec.scanner.unit)
        points += len(cloud)
    return points, rays, seconds


def _open(spec: ScanSpec, out: Path) -> None:
    """Make the folder; the survey goes first, so that a survey.toml always stands for a whole product."""
    survey, stamp = out / "survey.toml", out / STAMP
    shape = read_cable(spec)
    text = json.dumps(
        {"version": VERSION, **dataclasses.asdict(spec), "shape": None if shape is None else effective(shape)}
    )
    if survey.exists() and not stamp.exists():
        raise StageError("scan", f"{out} holds a survey that synth did not write", "name another folder")
    try:
        (out / "targets").mkdir(parents=True, exist_ok=True)
        survey.unlink(missing_ok=True)
        if stamp.exists() and stamp.read_text(encoding="utf-8") == text:
            return
        for files in ("targets/S*.csv", "clouds/S*.*", f"{PHOTOS}/P*.png"):
            for file in out.glob(files):
                file.unlink()
        write_text(stamp, text)
    except OSError as error:
        raise StageError(
            "scan", f"{out} cannot be written ({error})", "name a folder you may write"
        ) from error
