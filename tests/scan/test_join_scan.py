"""A laser scan of a cable in its photo model's frame: right where marks tell, honest where nothing does."""

import json

import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from pipeline.__main__ import main
from pipeline.core.errors import Cancelled
from pipeline.core.events import silent
from pipeline.scan.product import make_scan_product
from pipeline.steel.survey_records import LengthUnit
from tests.scan.scanned_cable import (
    FIRST,
    LAST,
    RADIUS,
    dents,
    diameter_mm,
    outward,
    painted_scan,
    placement,
    ribs,
    scanned,
    smooth,
    surface,
    write_run,
)


def joined(folder, points, unit=LengthUnit.METRE, pairs=None):
    """scan.json of a run folder and scanned points."""
    cloud = folder / "scan.ply"
    columns = ("x", "y", "z", "intensity")[: points.shape[1]]
    rows = np.empty(len(points), [(name, "<f4") for name in columns])
    for name, values in zip(columns, points.T, strict=True):
        rows[name] = values
    PlyData([PlyElement.describe(rows, "vertex")]).write(str(cloud))
    make_scan_product(folder / "run", (cloud,), unit, None, "en", silent, pairs)
    return json.loads((folder / "run" / "scan" / "scan.json").read_text())


def errors_mm(found, seed):
    """How far the scan comes to lie off, in the cable frame: (x, along y, z) and around, of its surface."""
    rotation, move = placement(seed)
    azimuth, y = np.arange(500) * 0.3 * np.pi, np.linspace(FIRST, LAST, 500)
    true = surface(smooth, azimuth, y)
    back = found["cable_from_scan"]
    moved = back["scale"] * (true @ rotation.T + move) @ np.array(back["rotation"]).T + back["translation_m"]
    off = 1000 * (moved - true)
    tangent = np.cross([0.0, 1, 0], outward(azimuth))
    return off, float(np.mean(np.sum(off * tangent, axis=1)))


def ways(found):
    return {way["name"]: way for way in found["ways"]}


@pytest.fixture(scope="module")
def dented(tmp_path_factory):
    found = []
    for seed in (1, 2):
        folder = tmp_path_factory.mktemp("dented")
        write_run(folder / "run", dents, seed)
        found.append((joined(folder, scanned(dents, seed)), seed, folder))
    return found


def test_dents_bring_the_scan_home_out_of_a_room(dented):
    for found, seed, _ in dented:
        off, around = errors_mm(found, seed)
        sigma = ways(found)
        turn_mm = np.radians(sigma["turn"]["sigma"]) * 1000 * RADIUS
        assert abs(off[:, 1].mean()) < 3 * sigma["along"]["sigma"]
        assert abs(around) < 3 * turn_mm
        assert max(sigma["along"]["sigma"], turn_mm) < 2
        assert np.hypot(*off[:, [0, 2]].mean(axis=0)) < 0.05
        assert all(way["determined"] for way in found["ways"])
        assert found["scale"]["scan_over_model"] == pytest.approx(1, abs=3e-4)
        assert abs(found["deviation"]["mean_mm"]) < 0.02
        assert 0.4 < found["deviation"]["rms_mm"] < 0.7
        assert found["deviation"]["coverage"] > 0.98


def test_diameters_of_both_agree_within_their_sigmas(dented):
    for found, _, _ in dented:
        for row in found["diameters"]:
            assert abs(row["difference_mm"]) < 0.05
            assert row["scan_sigma_mm"] < 0.05
            assert row["coverage_deg"] == 360.0


def test_every_merged_point_says_where_it_came_from(dented):
    _, _, folder = dented[0]
    rows = PlyData.read(str(folder / "run" / "scan" / "merged.ply"))["vertex"].data
    photo, scan = rows[rows["origin"] == -1], rows[rows["origin"] == 0]
    assert len(photo) == 80_000
    assert 60_000 < len(scan) <= 71_000
    near = (scan["y"] > FIRST) & (scan["y"] < LAST)
    assert np.median(np.hypot(scan["x"], scan["z"])[near]) == pytest.approx(RADIUS, abs=1e-4)
    page = (folder / "run" / "scan" / "scan.html").read_text(encoding="utf-8")
    assert "扫描" in page
    assert "not determined" not in page


def test_a_smooth_cable_shows_neither_turn_nor_shift(tmp_path):
    write_run(tmp_path / "run", smooth)
    found = joined(tmp_path, scanned(smooth, 3))
    known = ways(found)
    assert not known["along"]["determined"]
    assert not known["turn"]["determined"]
    assert known["along"]["sigma"] > 20
    assert known["across"]["determined"]
    assert known["across"]["sigma"] < 0.1
    assert all(abs(row["difference_mm"]) < 0.05 for row in found["diameters"])
    page = (tmp_path / "run" / "scan" / "scan.html").read_text(encoding="utf-8")
    assert "not determined" in page


def test_winding_ribs_tie_the_turn_to_the_shift(tmp_path):
    """Turned by one degree along its ribs, which rise by 0.6 m a turn, a cable fits 1.67 mm farther on."""
    write_run(tmp_path / "run", ribs)
    found = joined(tmp_path, scanned(ribs, 4, noise_m=0.0003))
    assert not ways(found)["turn"]["determined"]
    assert found["screw_mm_per_deg"] == pytest.approx(600 / 360, rel=0.1)


def test_paint_resolves_what_ribs_leave_open(tmp_path):
    write_run(tmp_path / "run", ribs, painted=True)
    found = joined(tmp_path, painted_scan(ribs, 11))
    off, around = errors_mm(found, 11)
    known = ways(found)
    assert known["turn"]["held_by"] == known["along"]["held_by"] == "brightness"
    assert abs(off[:, 1].mean()) < 3 * known["along"]["sigma"] < 1.5
    assert abs(around) < 3 * np.radians(known["turn"]["sigma"]) * 1000 * RADIUS < 1.5


def test_pairs_pointed_out_place_a_smooth_cable(tmp_path):
    write_run(tmp_path / "run", smooth)
    rotation, move = placement(5)
    on_cable = surface(smooth, np.array([0.2, 2.0, 4.0, 5.5]), np.array([0.05, 0.4, 0.2, 0.33]))
    rng = np.random.default_rng(2)
    lines = ["name,cable_x,cable_y,cable_z,scan_x,scan_y,scan_z"]
    for name, here in zip("abcd", on_cable, strict=True):
        there = here @ rotation.T + move + rng.normal(scale=0.0005, size=3)
        lines.append(",".join([name, *(f"{v:.5f}" for v in (*here, *there))]))
    (tmp_path / "pairs.csv").write_text("\n".join(lines))
    found = joined(tmp_path, scanned(smooth, 5), pairs=tmp_path / "pairs.csv")
    off, around = errors_mm(found, 5)
    assert abs(off[:, 1].mean()) < 2
    assert abs(around) < 2
    assert len(found["pairs"]) == 4
    assert ways(found)["turn"]["held_by"] == ways(found)["along"]["held_by"] == "pairs"


def test_a_model_of_the_wrong_scale_is_seen_as_such(tmp_path):
    """The photo model is 0.4 % too large: the scan's diameters stay true, and the scale says why."""
    write_run(tmp_path / "run", dents, photo_scale=1.004)
    found = joined(tmp_path, scanned(dents, 6))
    assert found["scale"]["scan_over_model"] == pytest.approx(1 / 1.004, abs=3e-4)
    for row in found["diameters"]:
        assert row["scan_mm"] == pytest.approx(diameter_mm(dents, row["position_m"] / 1.004), abs=0.08)
        assert row["difference_mm"] == pytest.approx(-0.44, abs=0.1)


def test_half_a_circumference_in_millimetres_is_enough_and_says_what_it_saw(tmp_path):
    write_run(tmp_path / "run", dents)
    points = scanned(dents, 7, azimuths=(0.0, np.pi), room=False)
    found = joined(tmp_path, 1000 * points, LengthUnit.MILLIMETRE)
    # without the limb, 15 degrees on either side
    assert all(140 <= row["coverage_deg"] <= 160 for row in found["diameters"])
    assert all(abs(row["difference_mm"]) < 0.15 for row in found["diameters"])
    assert 0.38 < found["deviation"]["coverage"] < 0.46


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("run", "is no finished run of a cable: it has no report.json"),
        ("scan", "no-such.laz does not exist"),
        ("kind", "is no cloud that is known here"),
        ("unit", "give --unit m"),
        ("other", "no cable of about 110 mm diameter"),
        ("pairs", "has no pairs in the columns"),
    ],
)
def test_bad_input_gets_its_sentence(wrong, said, tmp_path, capsys):
    run, cloud = tmp_path / "run", tmp_path / "scan.xyz"
    write_run(run, smooth)
    rng = np.random.default_rng(3)
    np.savetxt(cloud, np.column_stack([rng.uniform(-2, 2, (40_000, 2)), np.zeros(40_000)]), fmt="%.4f")
    arguments = [str(run), "--scan", str(cloud), "--events", "none"]
    if wrong == "run":
        (run / "report.json").unlink()
    if wrong == "scan":
        arguments[2] = str(tmp_path / "no-such.laz")
    if wrong == "kind":
        arguments[2] = str(run / "report.json")
    if wrong == "unit":
        arguments += ["--unit", "mm"]
    if wrong == "pairs":
        arguments += ["--pairs", str(run / "report.json")]
    assert main(["join-scan", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert not (run / "scan").exists()


def test_it_can_be_cancelled(tmp_path):
    write_run(tmp_path / "run", smooth)
    cloud = tmp_path / "scan.xyz"
    np.savetxt(cloud, scanned(smooth, 8, room=False), fmt="%.5f")

    def stop(event):
        raise Cancelled

    with pytest.raises(Cancelled):
        make_scan_product(tmp_path / "run", (cloud,), LengthUnit.METRE, None, "en", stop)
    assert not (tmp_path / "run" / "scan").exists()
