"""An evaluation finds errors that were put in on purpose, each with its size and sign."""

import json
from math import cos, radians, sin

import cv2  # noqa: F401 - before pycolmap
import numpy as np
import pycolmap
import pytest

from pipeline.core.errors import StageError
from pipeline.evaluate import evaluate, format_table, write_evaluation

PAPER = {"A": (112.383, 111.4), "B": (112.125, 110.8), "C": (111.748, 110.7), "D": (111.731, 111.1)}
FRAMES = 12
TRAVEL_M = 0.46
THETA_DEG = np.arange(0.0, 360.0, 2.0)
POSITION_M = np.linspace(0.0, TRAVEL_M, 47)


def turn(axis, angle_deg):
    a = radians(angle_deg)
    x, y = [k for k in range(3) if k != axis] if axis != 1 else (2, 0)
    R = np.eye(3)
    R[x, x] = R[y, y] = cos(a)
    R[x, y], R[y, x] = -sin(a), sin(a)
    return R


def true_pose(block, frame):
    """(R, centre) of a camera that looks at the axis; its x axis along the travel."""
    a = radians(90.0 * block)
    forward, right = np.array([-cos(a), 0, sin(a)]), np.array([0.0, 1.0, 0.0])
    R = np.stack([right, np.cross(forward, right), forward])
    return R, np.array([0.3 * cos(a), TRAVEL_M * frame / (FRAMES - 1), -0.3 * sin(a)])


def true_radius(theta_deg, position_m):
    theta, position = np.meshgrid(np.radians(theta_deg), position_m)
    return 55.5 + 0.2 * np.cos(2 * theta) + 0.3 * np.sin(8 * position)


def matrix(R, centre):
    return np.column_stack([R, -R @ centre])


def write_sparse(folder, block, change, frames=range(FRAMES), name="{:06d}.png"):
    """A COLMAP model of one block, each true pose changed by a function (R, centre) -> (R, centre)."""
    model = pycolmap.Reconstruction()
    camera = pycolmap.Camera(
        model="SIMPLE_PINHOLE", width=960, height=600, params=[720, 480, 300], camera_id=1
    )
    model.add_camera_with_trivial_rig(camera)
    for number, frame in enumerate(frames, start=1):
        pose = pycolmap.Rigid3d(matrix(*change(*true_pose(block, frame))))
        image = pycolmap.Image(name=name.format(frame), camera_id=1, image_id=number)
        model.add_image_with_trivial_frame(image, pose)
    folder.mkdir(parents=True)
    model.write(str(folder))


def same(R, centre):
    return R, centre


@pytest.fixture
def case(tmp_path):
    """A function that writes a run and its truth, with errors as asked, and gives both paths."""

    def write(change=same, blocks=(0, 1, 2, 3), radius_mm=None, lens=(), stations=None, frames=range(FRAMES)):
        run = tmp_path / f"run{len(list(tmp_path.iterdir()))}"
        lenses = {
            f"Block{b + 1}": {
                "focal_px": 720.0,
                "principal_point_px": [480.0, 300.0],
                "division_lambda": -0.02,
                "lambda_radius": "half-diagonal",
                "width_px": 960,
                "height_px": 600,
            }
            for b in blocks
        }
        of_run = {key: value for key, value in lenses["Block1"].items() if not key.endswith("_px")}
        report = {
            "format": 1,
            "name": "test",
            "stations": stations
            or [
                {
                    "name": n,
                    "position_m": 0.1 * k,
                    "diameter_mm": model,
                    "sigma_mm": 0.5,
                    "coverage_deg": 350.0,
                }
                for k, (n, (model, _)) in enumerate(PAPER.items(), start=1)
            ],
            "blocks": [{"name": name, **of_run, "focal_px": 720.0, **dict(lens)} for name in lenses],
            "axis": {"straightness_mm_per_m": 0.12},
        }
        truth = {
            "format": 1,
            "stations": [
                {"name": n, "position_m": 0.1 * k, "diameter_mm": true}
                for k, (n, (_, true)) in enumerate(PAPER.items(), start=1)
            ],
            "radius_mm": {
                "theta_deg": THETA_DEG.tolist(),
                "position_m": POSITION_M.tolist(),
                "values": true_radius(THETA_DEG, POSITION_M).tolist(),
            },
            "poses": {
                f"Block{b + 1}": [
                    {"frame": k, "cam_from_world": matrix(*true_pose(b, k)).tolist()} for k in range(FRAMES)
                ]
                for b in blocks
            },
            "lenses": lenses,
            "travel_m": TRAVEL_M,
            "spec": {},
        }
        for b in blocks:
            write_sparse(run / "blocks" / f"Block{b + 1}" / "sparse", b, change, frames)
        theta, position = np.arange(0.5, 360, 2.5), np.linspace(0.005, 0.455, 61)
        radius = true_radius(theta, position) if radius_mm is None else radius_mm(theta, position)
        np.savez(run / "radius_map.npz", theta_deg=theta, position_m=position, radius_mm=radius)
        (run / "report.json").write_text(json.dumps(report))
        (tmp_path / "truth.json").write_text(json.dumps(truth))
        return run, tmp_path / "truth.json"

    return write


def test_diameters_repeat_the_papers_table_2(case):
    found = evaluate(*case()).diameters
    assert found.mean_absolute_mm == pytest.approx(0.99675, abs=1e-5)
    a, b, c, d = found.stations
    # the paper prints -1.017 and 0.913 % for A, which contradicts its own diameters
    assert a.difference_mm == pytest.approx(0.983, abs=1e-9)
    assert [round(row.relative_percent, 3) for row in (b, c, d)] == [1.196, 0.947, 0.568]
    assert b.z == pytest.approx(1.325 / 0.5)
    assert found.largest_mm == pytest.approx(1.325)


def test_a_station_without_sigma_has_no_z(case):
    stations = [{"name": n, "position_m": 0.1 * k, "diameter_mm": 111.0} for k, n in enumerate("ABCD", 1)]
    stations[1]["sigma_mm"] = None
    found = evaluate(*case(stations=stations)).diameters.stations
    assert all(np.isnan(row.z) and np.isnan(row.sigma_mm) for row in found)


def test_a_perfect_run_has_no_errors(case):
    found = evaluate(*case())
    for row in (*found.cameras.as_they_stand, *found.cameras.fitted):
        assert row.position_mm < 1e-9
        assert row.attitude_deg < 1e-6
    assert [row.block for row in found.cameras.fitted] == ["Block1", "Block2", "Block3", "Block4", "all"]
    assert [row.frames for row in found.cameras.fitted] == [12, 12, 12, 12, 48]
    assert all(
        abs(row.focal_percent) + abs(row.lambda_error) + row.displacement_px == 0 for row in found.lenses
    )
    assert abs(found.surface.bias_mm) < 2e-3
    assert found.surface.noise_mm < 2e-3
    assert found.surface.wrong_percent == 0
    assert found.surface.coverage_percent == 100
    assert [(s.told_deg, s.right_deg, s.overclaimed_deg) for s in found.surface.stations] == [
        (350, 360, 0)
    ] * 4
    assert (found.axis, found.relief) == (None, None)  # this run is an older one, which tells neither
    assert found.straightness_mm_per_m == 0.12


def test_a_rigid_motion_of_the_whole_is_seen_as_it_stands_and_gone_after_the_fit(case):
    Q, shift = turn(1, 0.3), np.array([0.0, 0.002, 0.0])
    found = evaluate(*case(change=lambda R, c: (R @ Q.T, Q @ c + shift))).cameras
    stands, fitted = found.as_they_stand[-1], found.fitted[-1]
    assert stands.along_mm == pytest.approx(2.0, abs=1e-6)
    assert stands.around_mm == pytest.approx(300 * radians(0.3), rel=1e-3)
    assert stands.radial_mm < 0.01
    assert stands.attitude_deg == pytest.approx(0.3, abs=1e-6)
    assert fitted.position_mm < 1e-6
    assert fitted.attitude_deg < 1e-6
    assert found.fit_rotation_deg == pytest.approx(0.3, abs=1e-6)
    assert found.fit_translation_mm == pytest.approx(2.0, abs=1e-6)


def test_one_block_alone_is_fitted_though_its_centres_lie_on_a_line(case):
    Q = turn(1, 5.0)
    fitted = evaluate(*case(change=lambda R, c: (R @ Q.T, Q @ c), blocks=(0,))).cameras.fitted
    assert [row.block for row in fitted] == ["Block1", "all"]
    assert fitted[0].position_mm < 1e-6
    assert fitted[0].attitude_deg < 1e-6


def test_a_wider_ring_stays_after_the_fit(case):
    found = evaluate(*case(change=lambda R, c: (R, c * [1.002, 1, 1.002]))).cameras
    for rows in (found.as_they_stand, found.fitted):
        assert rows[-1].radial_mm == pytest.approx(0.6, abs=1e-3)
        assert rows[-1].around_mm + rows[-1].along_mm < 1e-3


def test_attitude_errors_of_single_frames_stay_after_the_fit(case):
    def nod(R, c):
        return turn(0, 0.1 if round(c[1] / TRAVEL_M * 11) % 2 else -0.1) @ R, c

    found = evaluate(*case(change=nod)).cameras
    assert found.as_they_stand[-1].attitude_deg == pytest.approx(0.1, rel=1e-5)
    assert found.fitted[-1].attitude_deg == pytest.approx(0.1, rel=0.01)


def test_selected_frames_are_compared_with_their_own_truth(case):
    found = evaluate(*case(frames=[0, 5, 11])).cameras.as_they_stand
    assert found[-1].frames == 12
    assert found[-1].position_mm < 1e-9


def test_a_longer_focal_length_moves_the_corner_by_its_share(case):
    (row, *_) = evaluate(*case(lens={"focal_px": 727.2})).lenses
    assert row.focal_percent == pytest.approx(1.0)
    # undistorted, the corner of lambda = -0.02 lies at half the diagonal / 0.98
    assert row.displacement_px == pytest.approx(np.hypot(480, 300) / 0.98 * (1 - 1 / 1.01), rel=1e-6)


def test_lambda_is_compared_in_the_unit_of_the_truth(case):
    half_width = {"division_lambda": -0.02 * (480 / np.hypot(480, 300)) ** 2, "lambda_radius": "half-width"}
    (row, *_) = evaluate(*case(lens=half_width)).lenses
    assert row.lambda_error == pytest.approx(0, abs=1e-12)
    assert row.displacement_px < 1e-9


def test_a_wrong_lambda_is_told_in_its_unit_and_in_pixels(case):
    (row, *_) = evaluate(*case(lens={"division_lambda": -0.03})).lenses
    corner = np.hypot(480, 300)
    assert row.lambda_error == pytest.approx(-0.01)
    assert row.displacement_px == pytest.approx(corner / 0.97 - corner / 0.98, rel=1e-6)


def test_a_lens_that_folds_is_infinitely_wrong(case):
    (row, *_) = evaluate(*case(lens={"division_lambda": -1.5})).lenses
    assert row.displacement_px == float("inf")


def test_bias_and_noise_of_the_surface_are_found_as_put_in(case):
    def noisy(theta, position):
        shape = (len(position), len(theta))
        noise = np.random.default_rng(4).normal(0, 0.03, shape)
        noise[5, ::7] = 3.0  # a few wild cells do not count as noise
        low = 0.2 * np.cos(2 * np.radians(theta)) * np.linspace(-1, 1, shape[0])[:, None]
        return true_radius(theta, position) + 0.05 + noise + low

    found = evaluate(*case(radius_mm=noisy)).surface
    assert found.bias_mm == pytest.approx(0.05, abs=0.01)
    assert 0.028 < found.noise_mm < 0.032
    assert 0.15 < found.within_95_mm < 0.35


def about_bowed_axis(theta, position, rise_mm):
    """Radii about the y axis of the true surface moved by an axis that bows towards azimuth 90 degrees,
    -z."""
    offset = rise_mm * 4 * (position / TRAVEL_M) * (1 - position / TRAVEL_M)
    rows = []
    for y, e in zip(position, offset, strict=True):
        a = np.radians(np.arange(0.0, 360.0, 0.25))  # about the bowed axis, then seen from the y axis
        r = true_radius(np.degrees(a), [y])[0]
        x, z = r * np.cos(a), -r * np.sin(a) - e
        seen, order = np.degrees(np.arctan2(-z, x)) % 360, None
        order = np.argsort(seen)
        rows.append(np.interp(theta, seen[order], np.hypot(x, z)[order], period=360))
    return np.array(rows)


def test_a_map_about_a_straight_axis_agrees_with_a_truth_about_a_bowed_one(case):
    found = evaluate(*case(radius_mm=lambda t, p: about_bowed_axis(t, p, 3.0))).surface
    assert abs(found.bias_mm) < 2e-3  # a first harmonic alone would leave up to e^2 / 4 r = 0.04 mm
    assert found.within_95_mm < 4e-3
    assert found.wrong_percent == 0


def test_a_ring_out_of_the_middle_is_no_error_of_the_surface_and_an_oval_one_is(case):
    def shifted(theta, position):
        return true_radius(theta, position) + 0.4 * np.cos(np.radians(theta - 40))

    def oval(theta, position):
        return true_radius(theta, position) + 0.4 * np.cos(2 * np.radians(theta - 40))

    assert evaluate(*case(radius_mm=shifted)).surface.within_95_mm < 6e-3
    assert 0.39 < evaluate(*case(radius_mm=oval)).surface.within_95_mm < 0.41


def test_holes_lower_the_coverage_and_an_open_ring_is_compared_as_it_stands(case):
    def strip(theta, position):
        radius = true_radius(theta, position) + 0.1 * np.cos(np.radians(theta))
        radius[:, theta > 120] = np.nan
        return radius

    found = evaluate(*case(radius_mm=strip)).surface
    assert found.coverage_percent == pytest.approx(100 / 3, abs=0.2)
    assert 0.09 < found.within_95_mm < 0.11


def test_what_is_told_as_seen_and_is_not_right_is_overclaimed(case):
    def guessed(theta, position):
        radius = true_radius(theta, position)
        radius[:, (theta > 90) & (theta < 180)] += 1.0  # a quarter is made up
        radius[:, (theta > 300) & (theta < 330)] = np.nan
        return radius

    found = evaluate(*case(radius_mm=guessed)).surface
    assert found.wrong_percent == pytest.approx(100 * 90 / 330, abs=0.5)
    for station in found.stations:
        assert station.right_deg == pytest.approx(240, abs=3)
        assert station.overclaimed_deg == pytest.approx(110, abs=3)


def told(path, **keys):
    """Add keys to a report or a truth."""
    spoil(path, lambda values: values.update(keys))


def axis_rows(position_m, x_mm, z_mm):
    return [
        {"position_m": float(y), "x_mm": float(x), "z_mm": float(z)}
        for y, x, z in zip(position_m, x_mm, z_mm, strict=True)
    ]


def test_bow_and_course_of_the_axis_are_compared_less_their_lines(case):
    run, truth = case()
    y = np.linspace(0, TRAVEL_M, 47)
    bend = 4 * (y / TRAVEL_M) * (1 - y / TRAVEL_M)
    told(truth, axis=axis_rows(y, 1.5 * bend, -2.0 * bend))
    crooked = axis_rows(
        y, 1.5 * 1.1 * bend + 0.3 + 2 * y, -2.0 * 1.1 * bend - 5 * y
    )  # tilted, shifted, 10 % more
    crooked[7].update(x_mm=None, z_mm=None)
    told(run / "report.json", axis={"straightness_mm_per_m": 1.0, "profile": crooked})
    found = evaluate(run, truth).axis
    assert found.places == 46
    assert found.length_m == pytest.approx(0.46)
    assert (found.true_bow_mm, found.bow_mm) == (pytest.approx(2.5, abs=2e-3), pytest.approx(2.75, abs=2e-3))
    assert found.bow_difference_mm == pytest.approx(0.25, abs=1e-3)
    # a parabola h 4 s (1 - s) less its best line has the root mean square 2 h / sqrt(45)
    assert found.rms_mm == pytest.approx(0.25 * 2 / 45**0.5, rel=0.07)  # the ends count for more
    assert "diff +0.250 mm" in format_table(evaluate(run, truth))


BULGE = {"kind": "bulge", "position_m": 0.145, "azimuth_deg": 20.0, "height_mm": 1.5, "peak_mm": 1.5}
DENT = {"kind": "dent", "position_m": 0.325, "azimuth_deg": 250.0, "height_mm": 1.0, "peak_mm": -1.0}


def find(kind, position_m, azimuth_deg, height_mm):
    return {
        "kind": kind,
        "position_m": position_m,
        "azimuth_deg": azimuth_deg,
        "height_mm": height_mm,
        "sigma_mm": 0.02,
    }


def test_every_defect_meets_the_nearest_find_of_its_kind(case):
    run, truth = case()
    told(truth, defects=[BULGE, DENT])
    finds = [
        find("bulge", 0.150, 25.0, 9.0),
        find("bulge", 0.146, -339.0, 1.55),  # 21 degrees, nearer
        find("dent", 0.145, 20.0, 1.0),  # at the bulge's place, but a dent
        find("dent", 0.325, 265.0, -0.9),  # 14.5 mm around
    ]
    told(run / "report.json", relief=finds)
    found = evaluate(run, truth).relief
    bulge, dent = found.entries
    assert (bulge.found_mm, bulge.difference_mm) == (1.55, pytest.approx(0.05))
    assert bulge.away_mm == pytest.approx(np.hypot(1.0, radians(1.0) * 55.5), abs=0.02)
    assert dent.difference_mm == pytest.approx(-0.1)
    assert dent.away_mm == pytest.approx(14.5, abs=0.1)
    assert (found.missed, found.false) == (0, 2)
    assert found.largest_mm == pytest.approx(0.1)
    assert "missed 0, false 2, ribs 0 of 0" in format_table(evaluate(run, truth))


def test_a_find_too_far_off_is_false_and_the_defect_missed(case):
    run, truth = case()
    told(truth, defects=[BULGE])
    told(run / "report.json", relief=[find("bulge", 0.170, 20.0, 1.5)])
    found = evaluate(run, truth).relief
    assert (found.missed, found.false) == (1, 1)
    assert np.isnan(found.entries[0].difference_mm)
    assert np.isnan(found.largest_mm)
    told(truth, defects=[{"kind": "bulge"}])
    with pytest.raises(StageError, match=r"defects\[0\]\.position_m is missing"):
        evaluate(run, truth)


def test_ribs_are_met_anywhere_along_their_crests(case):
    run, truth = case()
    fillet = {"height_mm": 2.0, "width_mm": 8.0, "pitch_m": 0.6, "angle_deg": 30.0}
    told(truth, defects=[], spec={"cable": {"fillet": fillet}})
    first = find("ridge", 0.3, 30.0 + 180.0 + 0.5, 1.9)  # half a pitch on, half a degree off
    second = find("ridge", 0.15, 30.0 + 180.0 + 90.0, 2.04)
    told(run / "report.json", relief=[first, second])
    found = evaluate(run, truth).relief
    assert [row.difference_mm for row in found.entries] == pytest.approx([-0.1, 0.04])
    slope = 2 * np.pi * 55.5 / 600
    assert found.entries[0].away_mm == pytest.approx(radians(0.5) * 55.5 / np.hypot(1, slope), abs=0.01)
    assert (found.ridges_true, found.ridges_found, found.missed, found.false) == (2, 2, 0, 0)
    told(run / "report.json", relief=[first, find("ridge", 0.15, 30.0, 2.0)])  # 90 degrees from either rib
    found = evaluate(run, truth).relief
    assert (found.ridges_found, found.missed, found.false) == (2, 1, 1)


def test_the_bare_sheath_is_compared_where_both_tell_it(case):
    run, truth = case()
    assert np.isnan(evaluate(run, truth).diameters.base_mean_absolute_mm)

    def bare(values, sigma=None):
        for station in values["stations"]:
            station["base_diameter_mm"] = station["diameter_mm"] - 0.1 - (0.02 if sigma else 0.0)
            station["base_sigma_mm"] = sigma

    spoil(truth, bare)
    spoil(run / "report.json", lambda values: bare(values, 0.03))
    found = evaluate(run, truth).diameters
    assert found.stations[1].base_difference_mm == pytest.approx(1.325 - 0.02)
    assert found.stations[1].base_sigma_mm == 0.03
    assert found.base_mean_absolute_mm == pytest.approx(found.mean_absolute_mm - 0.02)
    assert "MAE of the bare sheath 0.976" in format_table(evaluate(run, truth))


def test_stations_alone_are_truth_enough(case):
    run, path = case()
    truth = json.loads(path.read_text())
    path.write_text(json.dumps({"format": 1, "stations": truth["stations"]}))
    found = evaluate(run, path)
    assert found.diameters.mean_absolute_mm > 0.9
    assert (found.cameras, found.lenses, found.surface) == (None, None, None)
    assert "MAE 0.9967 mm" in format_table(found)


def test_the_table_shows_each_part_in_aligned_columns(case):
    lines = format_table(evaluate(*case())).splitlines()
    assert lines[1].split()[:9] == ["station", "at", "m", "model", "mm", "truth", "mm", "diff", "mm"]
    row = next(line for line in lines if line.startswith("B "))
    assert row.split() == ["B", "0.200", "112.125", "110.800", "+1.325", "1.196", "0.500", "2.7"]
    assert len({len(line) for line in lines[1:6]}) == 1
    assert "MAE 0.9967 mm, largest 1.325 mm (the paper's MAE: 1.0053 mm)" in lines
    assert sum(line.startswith("Block3") for line in lines) == 3


def test_the_json_holds_every_number_and_null_for_what_is_unknown(case, tmp_path):
    def strip(theta, position):
        radius = true_radius(theta, position)
        radius[:, theta > 120] = np.nan
        return radius

    write_evaluation(evaluate(*case(radius_mm=strip)), tmp_path / "evaluation.json")
    written = json.loads((tmp_path / "evaluation.json").read_text())
    assert written["format"] == 1
    assert written["diameters"]["stations"][1]["difference_mm"] == pytest.approx(1.325)
    assert written["cameras"]["fitted"][-1]["block"] == "all"
    assert written["lenses"][0]["focal_percent"] == 0
    assert written["axis"] is None
    assert written["diameters"]["base_mean_absolute_mm"] is None


def spoil(path, change):
    values = json.loads(path.read_text())
    change(values)
    path.write_text(json.dumps(values))


@pytest.mark.parametrize(
    ("file", "change", "words"),
    [
        ("truth", lambda v: v.update(format=2), ["truth.json: format is 2"]),
        ("truth", lambda v: v.pop("stations"), ["stations is missing"]),
        ("truth", lambda v: v.update(stations=[]), ["stations is empty"]),
        ("truth", lambda v: v["stations"][0].pop("diameter_mm"), ["stations[0].diameter_mm is missing"]),
        (
            "truth",
            lambda v: v["stations"][0].update(diameter_mm="big"),
            ["stations[0].diameter_mm is no number"],
        ),
        ("truth", lambda v: v["stations"][0].update(position_m=0.2), ["station A lies at 0.1 m", "at 0.2 m"]),
        ("truth", lambda v: v["stations"][0].update(name="Z"), ["report.json", "station Z"]),
        ("truth", lambda v: v["lenses"].pop("Block3"), ["lenses.Block3 is missing"]),
        ("truth", lambda v: v["poses"]["Block2"].pop(4), ["poses.Block2 has no frame 4"]),
        (
            "truth",
            lambda v: v["poses"]["Block2"][4].update(cam_from_world=[1, 2]),
            ["cam_from_world", "3 x 4"],
        ),
        ("truth", lambda v: v["radius_mm"]["values"].pop(), ["radius_mm.values has the shape"]),
        ("truth", lambda v: v["radius_mm"]["values"][3].__setitem__(5, None), ["radius_mm has gaps"]),
        ("truth", lambda v: v["poses"].pop("Block2"), ["poses.Block2 is missing"]),
        (
            "report",
            lambda v: v["stations"][2].update(diameter_mm=None),
            ["stations[2].diameter_mm is missing"],
        ),
        (
            "report",
            lambda v: v["blocks"][0].update(lambda_radius="corner"),
            ["blocks[0].lambda_radius is corner"],
        ),
    ],
)
def test_files_that_do_not_fit_are_told_with_file_and_key(case, file, change, words):
    run, truth = case()
    spoil(truth if file == "truth" else run / "report.json", change)
    with pytest.raises(StageError) as caught:
        evaluate(run, truth)
    for word in words:
        assert word in str(caught.value)


def test_missing_and_broken_files_are_told(case, tmp_path):
    run, truth = case()
    with pytest.raises(StageError, match="nowhere is no folder"):
        evaluate(tmp_path / "nowhere", truth)
    with pytest.raises(StageError, match=r"none\.json cannot be read"):
        evaluate(run, tmp_path / "none.json")
    (run / "radius_map.npz").write_bytes(b"PK nothing")
    with pytest.raises(StageError, match=r"radius_map\.npz is no map of radii"):
        evaluate(run, truth)
    (run / "radius_map.npz").unlink()
    with pytest.raises(StageError, match=r"radius_map\.npz is missing"):
        evaluate(run, truth)
    (run / "blocks" / "Block1" / "sparse" / "images.bin").write_bytes(b"\1")
    with pytest.raises(StageError, match=r"Block1.sparse cannot be read as a COLMAP model"):
        evaluate(run, truth)
    (run / "report.json").write_text("{")
    with pytest.raises(StageError, match=r"report\.json is no JSON"):
        evaluate(run, truth)
