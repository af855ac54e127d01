"""Tie points are the same spots of the cable in the original pixels; wrong matches are thrown out."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pipeline.cable import match
from pipeline.cable.match import MatchOptions, match_block
from pipeline.core.errors import StageError
from tests.cable import scene

OPTIONS = MatchOptions()


def find(frames, pos=None, emit=scene.silent):
    pos = pos or scene.pos_priors(scene.poses())
    return match_block(frames, scene.lens(scene.BARREL), pos, 0.0, 0.0545, OPTIONS, emit)


@pytest.fixture(scope="module")
def found(barrel_frames):
    return find(barrel_frames)


def disagreement(found, view):
    """Distance in pixels of every measurement from the spot that its point's own first sight shows."""
    spots = np.full((len(found.starts), 3), np.nan)
    nearest = np.full(len(found.starts), np.inf)
    for k in range(len(view.poses)):
        rows = np.flatnonzero(found.frame == k)
        away = np.abs(found.starts[found.point[rows], 1] - k * scene.STEP_M)
        better = away < nearest[found.point[rows]]
        spots[found.point[rows[better]]] = view.meet(k, found.pixels[rows[better]])
        nearest[found.point[rows[better]]] = away[better]
    return np.array(
        [
            np.linalg.norm(pixel - view.project(frame, spots[point : point + 1])[0])
            for frame, point, pixel in zip(found.frame, found.point, found.pixels, strict=True)
        ]
    )


def test_tie_points_are_given_in_the_pixels_of_the_original_frames(found, barrel_view):
    """They must agree with the independent barrel lens."""
    away = disagreement(found, barrel_view)
    assert 0.005 < np.median(away) < 0.06
    assert np.mean(away > 1.0) < 0.02


def test_every_point_is_seen_often_and_numbered_along_the_cable(found):
    views = np.bincount(found.point, minlength=len(found.starts))
    assert views.min() >= 3
    assert (np.diff(found.starts[:, 1]) >= 0).all()
    assert len(set(zip(found.frame.tolist(), found.point.tolist(), strict=True))) == len(found.frame)


def test_every_frame_has_its_share(found):
    counts = np.bincount(found.frame, minlength=scene.FRAMES)
    assert counts.min() > 200
    assert found.starts[:, 1].min() < -0.04
    assert found.starts[:, 1].max() > scene.TRAVEL_M + 0.04


def test_pairs_agree_with_the_geometry_of_their_points_better_than_with_a_rough_pos(found):
    assert len(found.epipolar_px) == scene.FRAMES - OPTIONS.epipolar_step
    assert found.epipolar_px.max() < 0.06
    assert np.median(found.pos_epipolar_px) > 3 * np.median(found.epipolar_px)


def test_a_true_pos_predicts_the_epipolar_geometry(barrel_frames, barrel_view):
    exact = find(barrel_frames, pos=scene.pos_priors(barrel_view.poses))
    assert exact.pos_epipolar_px.max() < 0.08


class _Mistaken(match.Tracker):
    """A tracker that is wrong in one measurement of twenty: off across the way the surface moves."""

    def track(self, home):
        track = super().track(home)
        wrong = np.random.default_rng(home).random(len(track.frame)) < 0.05
        wrong &= track.frame != home
        self.injected = getattr(self, "injected", 0) + int(wrong.sum())
        return replace(track, pixels=track.pixels + 7.0 * wrong[:, None] * [0, 1])


def test_wrong_matches_are_thrown_out_by_the_epipolar_check(barrel_frames, barrel_view, monkeypatch):
    monkeypatch.setattr(match, "Tracker", _Mistaken)
    checked = find(barrel_frames)
    away = disagreement(checked, barrel_view)
    assert np.mean(away > 5.0) < 0.001
    assert 0.05 < checked.rejected < 0.25  # the wrong ones and their partners, not half of all


def test_clean_pictures_lose_next_to_nothing_to_the_check(found):
    assert 0 <= found.rejected < 0.01


def barrel_stranger():
    return scene.Scene(poses=scene.poses(), lens=scene.lens(scene.BARREL), texture=scene.Texture(seed=99))


def frames_with(barrel_frames, barrel_view, folder, number, picture):
    folder.mkdir(exist_ok=True)
    files = list(barrel_frames.files)
    files[number] = folder / "odd.png"
    cv2.imwrite(str(files[number]), picture)
    return replace(barrel_frames, files=tuple(files))


@pytest.mark.parametrize("kind", ["blank", "unrelated"])
def test_a_frame_that_shares_nothing_with_the_others_is_named(barrel_frames, barrel_view, tmp_path, kind):
    stranger = barrel_stranger().picture(5)
    picture = np.full_like(stranger, 90) if kind == "blank" else stranger
    frames = frames_with(barrel_frames, barrel_view, tmp_path, 5, picture)
    with pytest.raises(StageError) as told:
        find(frames)
    assert "Block1: frame odd.png shares only" in str(told.value)
    assert str(told.value).startswith("match: ")
    assert "check that it is sharp, that the cable fills the picture" in str(told.value)
    assert "set ordered = false" in str(told.value)


def test_a_video_without_a_cable_is_refused(tmp_path, barrel_view):
    file = tmp_path / "nothing.png"
    cv2.imwrite(str(file), np.full((scene.HEIGHT_PX, scene.WIDTH_PX, 3), 90, dtype=np.uint8))
    with pytest.raises(StageError, match=r"nothing\.png shares only 0 points with the others"):
        find(scene.sequence([file] * scene.FRAMES))


def test_progress_is_told_frame_by_frame_then_pair_by_pair(barrel_frames):
    events = []
    find(barrel_frames, emit=events.append)
    assert {(e.stage, e.block) for e in events} == {("match", "Block1")}
    shares = [e.done / e.total for e in events]
    assert shares == sorted(shares)
    count = len(barrel_frames)
    np.testing.assert_allclose(shares[:count], 0.7 * np.arange(count) / count, atol=1e-3)
    pairs = (count - OPTIONS.epipolar_step) + (count - 1)
    assert len(shares) == count + pairs
    assert shares[count] == pytest.approx(0.7)
    assert 0.9 < shares[-1] < 1


def test_the_result_hangs_on_the_seed_alone(barrel_frames, found):
    again = find(barrel_frames)
    np.testing.assert_array_equal(again.pixels, found.pixels)
