"""A cable in the hall: met on its true surface, dents and paint included, and placed as the truth says."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from synth.scan.cable import CableRelief, cable_relief
from synth.scan.hits import hit_cylinder
from synth.scan.run import scan_survey
from synth.scan.spec import CloudFormat, ScanSpec, read_scan_spec
from synth.scan.spec_hall import CablePlace
from synth.spec import Cable, Defect, Robot, Spec
from synth.spec_reader import read_spec
from synth.surface import radius_m
from synth.texture import surface_texture

ROOT = Path(__file__).parents[3]
TURNED = np.linalg.qr(np.random.default_rng(8).standard_normal((3, 3)))[0]
ROTATION = TURNED * np.sign(np.linalg.det(TURNED))


def relief_of(cable: Cable) -> CableRelief:
    spec = Spec(cable=cable, robot=Robot(travel_m=0.4))
    return CableRelief(
        spec=spec, owner=0, rotation=ROTATION, origin=np.array([1.5, 0.3, 0.2]), paint=np.full((7, 36), 0.3)
    )


def rays_at(relief: CableRelief, count: int = 4000):
    """Unit directions to places about the cable, some beside it."""
    rng = np.random.default_rng(2)
    places = np.column_stack(
        [rng.uniform(-0.08, 0.08, count), rng.uniform(-0.25, 0.6, count), rng.uniform(-0.08, 0.08, count)]
    )
    directions = relief.origin + places @ relief.rotation.T
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def test_a_plain_cable_is_a_cylinder():
    relief = relief_of(Cable(diameter_mm=110.0, margin_m=0.3))
    directions = rays_at(relief)
    ends = [relief.origin + y * relief.rotation[:, 1] for y in (-0.3, 0.7)]
    expected = hit_cylinder(np.array([*ends[0], *ends[1], 0.055]), directions)
    hit = relief.hit(directions)
    sure = np.abs(expected.inside_m) > 1e-4  # samples may miss what is barely grazed
    met = np.isfinite(expected.range_m)
    assert np.array_equal(np.isfinite(hit.range_m)[sure], met[sure])
    assert np.count_nonzero(met & sure) > 1000
    assert hit.range_m[met & sure] == pytest.approx(expected.range_m[met & sure], abs=1e-9)
    steep = met & (expected.cosine > 0.3)
    assert hit.cosine[steep] == pytest.approx(expected.cosine[steep], abs=3e-3)
    near = np.abs(expected.inside_m) < 0.0005  # where beams may graze
    near &= np.abs(directions @ relief.rotation[:, 1]) < 0.5
    assert np.count_nonzero(near) > 10
    assert hit.inside_m[near] == pytest.approx(expected.inside_m[near], abs=1e-4)


def test_every_point_lies_on_the_oval_dented_bowed_surface():
    seen_from = -relief_of(Cable()).origin @ ROTATION
    facing_deg = float(np.degrees(np.arctan2(-seen_from[2], seen_from[0])))
    dent = Defect(kind="dent", height_mm=2.0, position_m=0.2, azimuth_deg=facing_deg + 20.0)
    bulge = Defect(kind="bulge", height_mm=2.0, position_m=0.1, azimuth_deg=facing_deg - 20.0)
    cable = Cable(ovality_mm=3.0, bow_mm=4.0, defect=(dent, bulge))
    relief = relief_of(cable)
    directions = rays_at(relief)
    hit = relief.hit(directions)
    met = np.isfinite(hit.range_m)
    inside = (hit.range_m[met, None] * directions[met] - relief.origin) @ relief.rotation
    rise = 0.004 * 4.0 * (inside[:, 1] / 0.4) * (1.0 - inside[:, 1] / 0.4)  # towards azimuth 90: -z
    x, z = inside[:, 0], inside[:, 2] + rise
    off_m = np.hypot(x, z) - radius_m(cable, np.arctan2(-z, x), inside[:, 1])
    assert np.count_nonzero(met) > 1000
    assert np.abs(off_m).max() < 1e-6
    plain = np.hypot(x, z) - 0.055
    assert plain.max() > 0.0012
    assert plain.min() < -0.0009


def test_the_scans_put_into_the_cables_frame_lie_on_the_cable(tmp_path):
    text = (
        (ROOT / "specs/steel/fusion_cable.toml").read_text().replace("../bench/defects.toml", "coarse.toml")
    )
    (tmp_path / "spec.toml").write_text(text)
    coarse = (ROOT / "specs/bench/defects.toml").read_text() + "\n[cable.material]\ntexel_mm = 1.0\n"
    (tmp_path / "coarse.toml").write_text(coarse)
    spec, shape = read_scan_spec(tmp_path / "spec.toml"), read_spec(tmp_path / "coarse.toml")
    scanner = replace(spec.scanner, range_sigma_mm=0.0, angle_sigma_arcsec=0.0, divergence_mrad=0.0)
    spec = replace(spec, scanner=replace(scanner, step_deg=0.4, format=CloudFormat.XYZ))
    survey = tomllib.loads(scan_survey(spec, tmp_path / "out", silent).survey.read_text())
    truth = json.loads((tmp_path / "out/truth.json").read_text())
    cable = truth["cable"]
    rotation, origin = np.array(cable["rotation"]), np.array(cable["translation"])
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert np.degrees(np.arcsin(rotation[2, 1])) == pytest.approx(35.0, abs=0.01)
    seen = np.zeros(12, int)
    for station, pose in zip(survey["station"], truth["stations"], strict=True):
        rows = np.loadtxt(tmp_path / "out" / station["cloud"])
        inside = (rows[:, :3] @ np.array(pose["rotation"]).T + pose["translation"] - origin) @ rotation
        near = (np.hypot(inside[:, 0], inside[:, 2]) < 0.07) & (np.abs(inside[:, 1] - 0.2) < 0.3)
        assert np.count_nonzero(near) > 100
        assert rows[near, 3].std() > 0.01  # painted, and shaded
        azimuth = np.arctan2(-inside[near, 2], inside[near, 0]) % (2.0 * np.pi)
        off_m = np.hypot(inside[near, 0], inside[near, 2]) - radius_m(shape.cable, azimuth, inside[near, 1])
        assert np.abs(off_m).max() < 2e-5  # the file has hundredths of a millimetre
        seen += np.histogram(azimuth, 12, (0.0, 2.0 * np.pi))[0]
    assert seen.min() > 0  # from all sides
    assert truth["rods"] == truth["nodes"] == truth["columns"] == []


def test_a_cable_that_is_not_there_is_refused(tmp_path):
    text = (ROOT / "specs/steel/fusion_cable.toml").read_text().replace("../bench/defects.toml", "none.toml")
    (tmp_path / "spec.toml").write_text(text)
    with pytest.raises(StageError, match=r"none\.toml cannot be read"):
        scan_survey(read_scan_spec(tmp_path / "spec.toml"), tmp_path / "out", silent)


def test_the_scan_sees_the_paint_where_the_videos_do():
    """Paint averaged to cells keeps its place, also where the texels around are no multiple of a cell."""
    spec = Spec(cable=Cable(diameter_mm=111.0, margin_m=0.02), robot=Robot(travel_m=0.05))
    fine = surface_texture(spec.cable, spec.robot, spec.seed)[..., :3].mean(axis=-1)
    assert fine.shape[1] % 5
    scene = ScanSpec(name="x", cable=CablePlace(spec="", at_m=(0.0, 0.0, 0.0)))
    coarse = cable_relief(scene, spec, 0).paint.mean(axis=0)
    # against the fine paint turned by small angles: the best is none
    centres = (np.arange(len(coarse)) + 0.5) / len(coarse) * fine.shape[1]
    around = fine.mean(axis=0)
    smooth = np.array([np.roll(around, k) for k in (-2, -1, 0, 1, 2)]).mean(axis=0)

    def match(texels):
        return np.corrcoef(np.interp(centres + texels, np.arange(len(smooth)) + 0.5, smooth), coarse)[0, 1]

    shifts = np.arange(-3, 3.01, 0.25)
    assert abs(shifts[np.argmax([match(s) for s in shifts])]) <= 0.25
    assert match(0.0) > 0.97
