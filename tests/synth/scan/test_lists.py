"""The targets' lists: who is in view, how noisy, and which gross errors they hold."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.core.errors import StageError
from synth.scan.frame import build_frame
from synth.scan.layout import build_layout
from synth.scan.lists import station_lists
from synth.scan.spec import (
    Box,
    Gross,
    Misnamed,
    Moved,
    Room,
    Scanner,
    ScanSpec,
    Stations,
    Targets,
    read_scan_spec,
)

ROOT = Path(__file__).parents[3]


def played(spec):
    frame = build_frame(spec)
    layout = build_layout(spec, frame)
    return layout, station_lists(spec, frame, layout)


def residuals(layout, lists):
    """(rows, 3) radial and the two transverse errors, mm, and the distances, of all sightings."""
    errors, away = [], []
    places = {target.name: target for target in layout.targets}
    for number, (station, sightings) in enumerate(zip(layout.stations, lists, strict=True)):
        for sighting in sightings:
            truth = layout.target_at(places[sighting.true], number).centre
            ray = station.rotation.T @ (truth - station.centre)
            distance = np.linalg.norm(ray)
            ray /= distance
            side = np.cross([0.0, 0.0, 1.0], ray)
            side /= np.linalg.norm(side)
            off_mm = 1000.0 * (sighting.place - distance * ray)
            errors.append([off_mm @ ray, off_mm @ side, off_mm @ np.cross(ray, side)])
            away.append(distance)
    return np.array(errors), np.array(away)


def test_134_stations_see_6_to_10_targets_each_with_the_noise_that_is_stated():
    spec = read_scan_spec(ROOT / "specs/steel/chain_134.toml")
    layout, lists = played(spec)
    assert len(lists) == 134
    assert {len(sightings) for sightings in lists} <= {6, 7, 8, 9, 10}
    errors_mm, away_m = residuals(layout, lists)
    assert 1.85 < errors_mm[:, 0].std() < 2.15  # 1 300 numbers: within 2 % at one sigma
    across = errors_mm[:, 2] / (1000.0 * away_m * math.radians(8.0 / 3600.0))
    assert 0.92 < across.std() < 1.08
    assert np.abs(errors_mm.mean(axis=0)).max() < 0.2
    steps = np.linalg.norm(np.diff([s.centre for s in layout.stations], axis=0), axis=1)
    assert steps.max() < 12.0  # a walk: every station near the one before


def test_a_box_hides_a_target():
    spec = ScanSpec(
        name="x",
        stations=Stations(count=(0, 0), at_m=((0.5, 3.0),), height_m=1.7, clear_m=0.0),
        targets=Targets(stands=(0, 0), at_m=((5.5, 3.0, 1.5), (5.5, 1.0, 1.5)), least=0),
        room=Room(box=(Box(at_m=(3.0, 3.0), size_m=(1.0, 1.0, 3.0)),)),
    )
    _, (hidden,) = played(spec)
    assert [sighting.true for sighting in hidden] == ["T02"]
    _, (open_,) = played(replace(spec, room=Room()))
    assert [sighting.true for sighting in open_] == ["T01", "T02"]


def test_too_few_targets_in_view_are_refused():
    spec = ScanSpec(name="x", targets=Targets(stands=(2, 1), least=4))
    with pytest.raises(StageError, match=r"station S01 sees 2 targets, targets\.least is 4"):
        played(spec)


def test_a_knocked_target_is_50_mm_off_from_that_station_on():
    spec = read_scan_spec(ROOT / "specs/steel/gross.toml")
    exact = replace(spec, scanner=Scanner(range_sigma_mm=0.0, angle_sigma_arcsec=0.0))
    layout, lists = played(exact)
    before = next(target for target in layout.targets if target.name == "T15").centre
    for number, (station, sightings) in enumerate(zip(layout.stations, lists, strict=True)):
        for sighting in sightings:
            if sighting.true == "T15":
                off_mm = 1000.0 * np.linalg.norm(station.rotation @ sighting.place + station.centre - before)
                assert off_mm == pytest.approx(50.0 if number >= 8 else 0.0, abs=1e-6)
    seen = [any(s.true == "T15" for s in sightings) for sightings in lists]
    assert sum(seen[:8]) >= 2
    assert sum(seen[8:]) >= 2


def test_one_target_bears_a_name_that_its_station_does_not_see():
    _, lists = played(read_scan_spec(ROOT / "specs/steel/gross.toml"))
    wrong = [(n, s.true, s.name) for n, sightings in enumerate(lists) for s in sightings if s.true != s.name]
    ((number, true, name),) = wrong
    assert (number, true) == (2, "T05")
    assert [s.name for s in lists[2]].count(name) == 1


def test_gross_errors_that_cannot_be_are_refused():
    spec = read_scan_spec(ROOT / "specs/steel/hall_12_targets.toml")
    for gross, said in [
        (Gross(moved=(Moved(target="T99"),)), "gross.moved names T99"),
        (Gross(moved=(Moved(target="T01", from_station=99),)), "from_station is 99"),
        (Gross(moved=(Moved(target="T01", from_station=12),)), "T01 moves before S12 but is seen only"),
        (Gross(misnamed=(Misnamed(station="S99"),)), "gross.misnamed names S99"),
        (Gross(misnamed=(Misnamed(station="S01", target="T20"),)), "S01 does not see T20"),
        (Gross(misnamed=(Misnamed(station="S01", target="T01", called="T02"),)), "S01 lists T02 already"),
    ]:
        with pytest.raises(StageError, match=said):
            played(replace(spec, gross=gross))
