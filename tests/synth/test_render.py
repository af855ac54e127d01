"""The whole line on a survey of thumbnails: products, resuming, refusing, exit codes."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import pytest

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import silent
from synth.__main__ import main
from synth.render import render_survey
from synth.spec import Cable, LensSpec, Material, Robot, Sensor, Spec, Station

ROOT = Path(__file__).parents[2]

TOML = """
seed = 3
depth_frames = [1]
[cable]
margin_m = 0.1
[cable.material]
texel_mm = 1.0
[[cable.station]]
name = "A"
position_m = 0.02
[robot]
cameras = 2
frames = 3
travel_m = 0.04
[lens]
focal_px = 120.0
width_px = 160
height_px = 100
division_lambda = -0.02
[sensor]
samples = 2
"""

THUMBNAILS = Spec(
    seed=3,
    depth_frames=(1,),
    cable=Cable(margin_m=0.1, material=Material(texel_mm=1.0), station=(Station(name="A", position_m=0.02),)),
    robot=Robot(cameras=2, frames=3, travel_m=0.04),
    lens=LensSpec(focal_px=120.0, width_px=160, height_px=100, division_lambda=-0.02),
    sensor=Sensor(samples=2, output="images"),
)


def pictures(folder):
    return {str(p.relative_to(folder)): cv2.imread(str(p)) for p in sorted(folder.glob("block*/*.png"))}


def test_the_command_renders_a_survey_and_a_second_call_finds_it_done(tmp_path, capfd):
    spec, out = tmp_path / "spec.toml", tmp_path / "out"
    spec.write_text(TOML)
    assert main(["render", str(spec), str(out), "--events", "json"]) == 0
    printed = capfd.readouterr()
    assert printed.out == f"{out / 'survey.toml'}\n"  # and none of Blender's own lines
    events = [json.loads(line) for line in printed.err.splitlines() if line.startswith("{")]
    assert [event["done"] for event in events] == [1, 2, 3, 4, 5, 6]
    assert {event["total"] for event in events} == {6}

    survey = tomllib.loads((out / "survey.toml").read_text())
    for block in survey["block"]:
        capture = cv2.VideoCapture(str(out / block["source"]))
        assert capture.get(cv2.CAP_PROP_FRAME_COUNT) == 3
        assert capture.read()[1].shape == (100, 160, 3)
    truth = json.loads((out / "truth.json").read_text())
    assert list(truth["poses"]) == ["Block1", "Block2"]
    with OpenEXR.File(str(out / "depth" / "block2_0001.exr")) as exr:
        assert exr.channels()["Z"].pixels[50, 80] == pytest.approx(0.3 - 0.055, abs=1e-4)

    before = (out / "block1.mp4").stat().st_mtime_ns
    assert main(["render", str(spec), str(out), "--quiet"]) == 0
    assert (out / "block1.mp4").stat().st_mtime_ns == before


def test_an_interrupted_run_goes_on_with_its_frames_and_ends_the_same(tmp_path):
    def stop_after_four(event):
        if event.done == 4:
            raise Cancelled

    with pytest.raises(Cancelled):
        render_survey(THUMBNAILS, tmp_path / "a", stop_after_four)
    kept = {p: p.stat().st_mtime_ns for p in (tmp_path / "a").glob("block*/*.png")}
    assert len(kept) == 4
    assert not (tmp_path / "a" / "survey.toml").exists()
    render_survey(THUMBNAILS, tmp_path / "a", silent)
    assert all(p.stat().st_mtime_ns == at for p, at in kept.items())

    render_survey(THUMBNAILS, tmp_path / "b", silent)
    resumed, fresh = pictures(tmp_path / "a"), pictures(tmp_path / "b")
    assert list(resumed) == list(fresh)
    assert len(fresh) == 6
    assert all(np.array_equal(resumed[name], fresh[name]) for name in fresh)


def test_another_specification_replaces_the_survey_and_leaves_other_files_alone(tmp_path):
    render_survey(THUMBNAILS, tmp_path, silent)
    (tmp_path / "notes.txt").write_text("mine")
    first = pictures(tmp_path)
    fewer = replace(THUMBNAILS, seed=4, robot=replace(THUMBNAILS.robot, frames=2))
    render_survey(fewer, tmp_path, silent)
    second = pictures(tmp_path)
    assert list(second) == ["block1/0000.png", "block1/0001.png", "block2/0000.png", "block2/0001.png"]
    assert np.abs(first["block1/0000.png"].astype(float) - second["block1/0000.png"]).mean() > 2.0
    assert json.loads((tmp_path / "truth.json").read_text())["spec"]["seed"] == 4
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_motion_blur_smears_along_the_travel_only(tmp_path):
    sharp = replace(
        THUMBNAILS,
        depth_frames=(),
        robot=replace(THUMBNAILS.robot, frames=2, angles_deg=(0.0,)),
        sensor=replace(THUMBNAILS.sensor, full_well_e=0.0, samples=8),
    )
    blurred = replace(sharp, sensor=replace(sharp.sensor, motion_blur_mm=8.0))
    contrast = []
    for name, spec in (("sharp", sharp), ("blurred", blurred)):
        render_survey(spec, tmp_path / name, silent)
        cable = pictures(tmp_path / name)["block1/0001.png"][35:65].astype(float).mean(axis=2)
        contrast.append([np.abs(np.diff(cable, axis=axis)).mean() for axis in (0, 1)])
    (sharp_across, sharp_along), (blurred_across, blurred_along) = contrast
    assert blurred_along < 0.6 * sharp_along
    assert blurred_across > 1.1 * blurred_along
    assert blurred_across < sharp_across


def test_a_rolling_shutter_leans_the_picture_and_leaves_its_middle_row(tmp_path):
    still = replace(
        THUMBNAILS,
        depth_frames=(1,),
        robot=replace(THUMBNAILS.robot, frames=2, angles_deg=(0.0,), travel_m=0.08),
        sensor=replace(THUMBNAILS.sensor, full_well_e=0.0, samples=4),
    )
    rolling = replace(still, sensor=replace(still.sensor, readout_share=0.9))
    for name, spec in (("still", still), ("rolling", rolling)):
        render_survey(spec, tmp_path / name, silent)
    before, after = (
        pictures(tmp_path / name)["block1/0001.png"].mean(axis=2) for name in ("still", "rolling")
    )

    def moved_px(rows):
        columns = np.arange(40, 120)
        misfit = [
            np.abs(after[rows][:, columns] - before[rows][:, columns - s]).mean() for s in range(-15, 16)
        ]
        return int(np.argmin(misfit)) - 15

    # rows 58 to 66 are read (62 / 100 - 0.5) * 0.9 * 80 mm = 8.6 mm later, at about 0.4 px a mm
    assert moved_px(slice(58, 66)) == pytest.approx(-4, abs=1)
    assert moved_px(slice(33, 41)) == pytest.approx(5, abs=1)
    with OpenEXR.File(str(tmp_path / "rolling" / "depth" / "block1_0001.exr")) as exr:
        depth = exr.channels()["Z"].pixels
    assert depth[50, 80] == pytest.approx(0.3 - 0.055, abs=1e-4)
    assert depth[34:66, 80].min() > 0.2


def test_the_seed_of_the_command_goes_before_that_of_the_specification(tmp_path):
    spec, out = tmp_path / "spec.toml", tmp_path / "out"
    spec.write_text(TOML.replace("frames = 3", "frames = 2"))
    assert main(["render", str(spec), str(out), "--quiet", "--seed", "9"]) == 0
    assert json.loads((out / "truth.json").read_text())["spec"]["seed"] == 9
    assert main(["render", str(spec), str(out), "--quiet", "--seed", "-1"]) == 2


def test_gloss_adds_glare_that_travels_with_the_lamps(tmp_path):
    matt = replace(
        THUMBNAILS,
        depth_frames=(),
        robot=replace(THUMBNAILS.robot, cameras=4, frames=2, travel_m=0.1),
        sensor=replace(THUMBNAILS.sensor, full_well_e=0.0),
        survey=replace(THUMBNAILS.survey, lost_blocks=("Block2", "Block3", "Block4")),
    )
    glossy = replace(matt, cable=replace(matt.cable, material=replace(matt.cable.material, gloss=1.0)))
    for name, spec in (("matt", matt), ("glossy", glossy)):
        render_survey(spec, tmp_path / name, silent)
    dull, bright = pictures(tmp_path / "matt"), pictures(tmp_path / "glossy")
    for frame in ("block1/0000.png", "block1/0001.png"):  # the glare stays in the middle of both
        glare = bright[frame].astype(float).mean(axis=2) - dull[frame].mean(axis=2)
        assert glare.max() > 25.0
        assert abs(np.argmax(cv2.GaussianBlur(glare, (0, 0), 3.0).max(axis=0)) - 80) < 15


def test_bad_input_ends_with_code_2_and_one_sentence(tmp_path, capsys):
    spec = tmp_path / "spec.toml"
    spec.write_text(TOML + "shutter = 3\n")
    assert main(["render", str(spec), str(tmp_path / "out")]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("spec: sensor.shutter is unknown; use one of:")
    assert printed.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_made_or_belongs_to_another_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StageError, match="cannot be written"):
        render_survey(THUMBNAILS, tmp_path / "file" / "out", silent)
    (tmp_path / "survey.toml").write_text("format = 1")
    with pytest.raises(StageError, match="a survey that synth did not write"):
        render_survey(THUMBNAILS, tmp_path, silent)
    assert (tmp_path / "survey.toml").read_text() == "format = 1"


def test_control_c_ends_with_code_130_and_leaves_no_survey(tmp_path):
    spec, out = tmp_path / "spec.toml", tmp_path / "out"
    spec.write_text(TOML.replace("frames = 3", "frames = 300"))
    command = [sys.executable, "-m", "synth", "render", str(spec), str(out), "--events", "json"]
    with subprocess.Popen(
        command, cwd=ROOT, stderr=subprocess.PIPE, text=True, env=dict(os.environ)
    ) as process:
        for line in process.stderr:
            if line.startswith("{"):  # the first frame is there
                break
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 130
    assert not (out / "survey.toml").exists()
    assert len(list(out.glob(".synth/frames/block1/*.png"))) >= 1


def test_changed_claims_rewrite_survey_and_truth_and_no_picture(tmp_path):
    render_survey(THUMBNAILS, tmp_path, silent)
    before = {file: file.stat().st_mtime_ns for file in tmp_path.glob("block*/*.png")}
    claim = replace(THUMBNAILS.survey, travel_error_percent=1.0, lost_blocks=("Block2",))
    render_survey(replace(THUMBNAILS, name="other", survey=claim), tmp_path, silent)
    assert {file: file.stat().st_mtime_ns for file in tmp_path.glob("block*/*.png")} == before
    survey = tomllib.loads((tmp_path / "survey.toml").read_text())
    assert (survey["name"], survey["cable"]["travel_m"]) == ("other", pytest.approx(0.0404))
    assert [block["name"] for block in survey["block"]] == ["Block1"]
    assert json.loads((tmp_path / "truth.json").read_text())["spec"]["survey"]["travel_error_percent"] == 1.0
