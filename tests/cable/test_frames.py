"""Frames come out of videos and folders whole, in order, and well chosen; broken sources are told by name."""

from dataclasses import replace
from itertools import pairwise

import cv2
import numpy as np
import pytest

from pipeline.cable import frame_files
from pipeline.cable.frame_files import sharpness
from pipeline.cable.frames import (
    FrameOptions,
    combined_sharpness,
    every_frame,
    extract_frames,
    select_frames,
    select_spread,
)
from pipeline.cable.sources import count_frames, read_frame, read_frames
from pipeline.cable.survey import survey_from
from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import silent
from pipeline.core.vocabulary import TravelDirection

SIZE = (160, 96)
EVERY = FrameOptions(spacing_mm=0.0)
GROUND = cv2.resize(np.random.default_rng(3).integers(0, 256, (24, 200), dtype=np.uint8), (800, 96))


def picture(index, blur_px=0.0):
    grey = GROUND[:, 8 * index : 8 * index + SIZE[0]]
    if blur_px:
        grey = cv2.GaussianBlur(grey, (0, 0), blur_px)
    return cv2.cvtColor(np.ascontiguousarray(grey), cv2.COLOR_GRAY2BGR)


def write_video(path, images):
    kind = "mp4v" if path.suffix == ".mp4" else "MJPG"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*kind), 10, SIZE)
    for image in images:
        writer.write(image)
    writer.release()


def write_images(folder, images, names):
    folder.mkdir()
    for image, name in zip(images, names, strict=True):
        cv2.imwrite(str(folder / name), image)


def survey_of(folder, *sources, synchronised=True, travel_m=0.2):
    """A survey of blocks Block1, Block2, ... with these sources."""
    block = {"travel_in_image": "left", "lens": {"focal_px": 100.0}}
    return survey_from(
        {
            "format": 1,
            "name": "test",
            "cable": {"travel_m": travel_m},
            "robot": {"standoff_m": 0.3, "synchronised": synchronised},
            "block": [
                {"name": f"Block{k}", "source": source, "angle_deg": 90 * k, **block}
                for k, source in enumerate(sources, start=1)
            ],
        },
        folder,
    )


def refusal(survey, folder, options=EVERY):
    with pytest.raises(StageError) as caught:
        extract_frames(survey, options, folder / "run", silent)
    assert caught.value.stage in ("frames", "survey")
    return str(caught.value)


def test_a_video_becomes_numbered_images(tmp_path):
    write_video(tmp_path / "a.mp4", [picture(k) for k in range(6)])
    (sequence,) = extract_frames(survey_of(tmp_path, "a.mp4"), EVERY, tmp_path / "run", silent)
    folder = tmp_path / "run" / "Block1" / "frames"
    assert sequence.files == tuple(folder / f"{k:06d}.png" for k in range(6))
    assert sorted(folder.iterdir()) == list(sequence.files)
    assert (sequence.block, sequence.source_count) == ("Block1", 6)
    assert (sequence.width_px, sequence.height_px) == SIZE
    for k, path in enumerate(sequence.files):
        difference = np.abs(cv2.imread(str(path)).astype(int) - picture(k))
        # the codec blurs, but frame k is nearer to picture k than to its neighbours
        assert difference.mean() < 0.5 * np.abs(picture(k + 1).astype(int) - picture(k)).mean()


def test_a_video_too_large_to_be_held_is_decoded_again_to_the_same_images(tmp_path, monkeypatch):
    write_video(tmp_path / "a.mp4", [picture(k) for k in range(6)])
    survey = survey_of(tmp_path, "a.mp4")
    extract_frames(survey, EVERY, tmp_path / "held", silent)
    monkeypatch.setattr(frame_files, "HELD_BYTES", 4 * picture(0).nbytes)
    extract_frames(survey, EVERY, tmp_path / "again", silent)
    for file in sorted((tmp_path / "held").rglob("*.png")):
        again = tmp_path / "again" / file.relative_to(tmp_path / "held")
        np.testing.assert_array_equal(cv2.imread(str(again)), cv2.imread(str(file)))


def test_images_stay_where_they_are_in_natural_order(tmp_path):
    write_images(
        tmp_path / "images", [picture(k) for k in range(4)], ["f1.png", "f2.png", "f9.png", "f10.png"]
    )
    (tmp_path / "images" / "notes.txt").write_text("no image")
    for source in ("images", "images/f*.png"):
        (sequence,) = extract_frames(survey_of(tmp_path, source), EVERY, tmp_path / "run", silent)
        assert [path.name for path in sequence.files] == ["f1.png", "f2.png", "f9.png", "f10.png"]
        assert sequence.files[0].parent == tmp_path / "images"
        assert sequence.source_indices.tolist() == [0, 1, 2, 3]
    assert not (tmp_path / "run").exists()


def test_positions_are_fractions_of_the_travel(tmp_path):
    write_video(tmp_path / "a.avi", [picture(k) for k in range(11)])
    options = FrameOptions(spacing_mm=40.0, sharpness_window=0.0)
    (sequence,) = extract_frames(survey_of(tmp_path, "a.avi"), options, tmp_path / "run", silent)
    assert sequence.source_indices.tolist() == [0, 2, 4, 6, 8, 10]
    np.testing.assert_allclose(sequence.places_m(0.2), np.linspace(0, 0.2, 6), atol=1e-15)


def test_synchronised_blocks_get_the_same_frames_and_avoid_what_is_blurred_in_any(tmp_path):
    write_video(tmp_path / "a.avi", [picture(k, 2.0 if k == 4 else 0.0) for k in range(13)])
    write_video(tmp_path / "b.avi", [picture(k, 2.0 if k == 8 else 0.0) for k in range(13)])
    options = FrameOptions(spacing_mm=0.2 / 3 * 1000, sharpness_window=1.0)
    survey = survey_of(tmp_path, "a.avi", "b.avi")
    first, second = extract_frames(survey, options, tmp_path / "run", silent)
    assert first.source_indices.tolist() == second.source_indices.tolist()
    assert {4, 8}.isdisjoint(first.source_indices.tolist())
    alone = replace(survey, robot=replace(survey.robot, synchronised=False))
    first, second = extract_frames(alone, options, tmp_path / "run", silent)
    assert 4 not in first.source_indices
    assert 8 not in second.source_indices


def test_another_choice_leaves_no_stray_frames(tmp_path):
    write_video(tmp_path / "a.avi", [picture(k) for k in range(9)])
    survey = survey_of(tmp_path, "a.avi")
    extract_frames(survey, EVERY, tmp_path / "run", silent)
    (sequence,) = extract_frames(survey, FrameOptions(spacing_mm=100.0), tmp_path / "run", silent)
    assert sorted((tmp_path / "run" / "Block1" / "frames").iterdir()) == list(sequence.files)


def test_progress_counts_up_to_its_total_and_can_be_cancelled(tmp_path):
    write_video(tmp_path / "a.avi", [picture(k) for k in range(5)])
    events = []
    extract_frames(survey_of(tmp_path, "a.avi"), EVERY, tmp_path / "run", events.append)
    assert [event.done for event in events] == list(range(1, 11))
    assert {(event.stage, event.total, event.block) for event in events} == {("frames", 10, "Block1")}

    def stop(event):
        raise Cancelled

    with pytest.raises(Cancelled):
        extract_frames(survey_of(tmp_path, "a.avi"), EVERY, tmp_path / "stopped", stop)
    assert not (tmp_path / "stopped").exists()


def test_a_truncated_video_is_told_with_its_counts(tmp_path):
    write_video(tmp_path / "a.avi", [picture(k) for k in range(20)])
    whole = (tmp_path / "a.avi").read_bytes()
    (tmp_path / "a.avi").write_bytes(whole[: len(whole) * 6 // 10])
    message = refusal(survey_of(tmp_path, "a.avi"), tmp_path)
    assert "a.avi is truncated or damaged: it promises 20 frames and only 1" in message
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("part", [0.0, 0.6])
def test_a_video_without_its_index_cannot_be_opened(tmp_path, part):
    write_video(tmp_path / "a.mp4", [picture(k) for k in range(20)])
    whole = (tmp_path / "a.mp4").read_bytes()
    (tmp_path / "a.mp4").write_bytes(whole[: int(len(whole) * part)])
    assert "a.mp4 cannot be opened as a video" in refusal(survey_of(tmp_path, "a.mp4"), tmp_path)


def test_synchronised_blocks_of_different_length_are_told_with_their_counts(tmp_path):
    write_video(tmp_path / "a.avi", [picture(k) for k in range(6)])
    write_video(tmp_path / "b.avi", [picture(k) for k in range(5)])
    message = refusal(survey_of(tmp_path, "a.avi", "b.avi"), tmp_path)
    assert "Block1 has 6 frames and Block2 has 5" in message
    alone = survey_of(tmp_path, "a.avi", "b.avi", synchronised=False)
    assert [len(s) for s in extract_frames(alone, EVERY, tmp_path / "run", silent)] == [6, 5]


def test_too_few_frames_are_refused(tmp_path):
    write_video(tmp_path / "a.avi", [picture(k) for k in range(2)])
    assert "a.avi of Block1 holds 2 frames; give at least 3" in refusal(
        survey_of(tmp_path, "a.avi"), tmp_path
    )
    write_video(tmp_path / "b.avi", [picture(k) for k in range(9)])
    message = refusal(survey_of(tmp_path, "b.avi"), tmp_path, FrameOptions(spacing_mm=300.0))
    assert "leave 2 of 9 frames" in message
    assert "spacing_mm" in message


def test_a_blank_frame_is_named(tmp_path):
    pictures = [picture(k) for k in range(5)]
    pictures[3] = np.full_like(pictures[3], 128)
    write_video(tmp_path / "a.avi", pictures)
    message = refusal(survey_of(tmp_path, "a.avi"), tmp_path)
    assert "frame 3 of" in message
    assert "blank" in message


def test_an_unreadable_or_odd_image_is_named(tmp_path):
    names = ["f1.png", "f2.png", "f3.png"]
    write_images(tmp_path / "broken", [picture(k) for k in range(3)], names)
    (tmp_path / "broken" / "f2.png").write_bytes(b"no image")
    assert "f2.png cannot be read as an image" in refusal(survey_of(tmp_path, "broken"), tmp_path)
    (tmp_path / "broken" / "f2.png").write_bytes(b"")
    assert "f2.png cannot be read as an image" in refusal(survey_of(tmp_path, "broken"), tmp_path)
    write_images(tmp_path / "odd", [picture(0), picture(1), picture(2)[:90]], names)
    message = refusal(survey_of(tmp_path, "odd"), tmp_path)
    assert "f3.png is 160 x 90, the images before it are 160 x 96" in message
    (tmp_path / "empty").mkdir()
    assert "holds no images" in refusal(survey_of(tmp_path, "empty"), tmp_path)


def test_a_lens_that_does_not_fit_the_images_is_told_at_once(tmp_path):
    write_images(tmp_path / "images", [picture(k) for k in range(3)], ["1.png", "2.png", "3.png"])
    survey = survey_of(tmp_path, "images")
    lens = replace(survey.blocks[0].lens_spec, principal_point_px=(480.0, 300.0))
    survey = replace(survey, blocks=(replace(survey.blocks[0], lens_spec=lens),))
    assert "block[Block1].lens.principal_point_px" in refusal(survey, tmp_path)


def test_sharpness_falls_with_blur_and_hardly_with_light():
    values = [sharpness(picture(5, blur), TravelDirection.LEFT) for blur in (0.0, 1.0, 2.0, 4.0)]
    assert all(b < 0.7 * a for a, b in pairwise(values))
    darker = (picture(5) * 0.5).astype(np.uint8)
    assert sharpness(darker, TravelDirection.LEFT) == pytest.approx(values[0], rel=0.1)


def test_sharpness_looks_at_the_cable_only_and_one_glint_does_not_decide():
    blurred = picture(5, 3.0)
    value = sharpness(blurred, TravelDirection.RIGHT)
    framed = blurred.copy()
    framed[:30], framed[-30:] = picture(5)[:30], picture(5)[-30:]
    assert sharpness(framed, TravelDirection.RIGHT) == value
    glint = blurred.copy()
    glint[40:50, 60:64] = 255
    assert sharpness(glint, TravelDirection.RIGHT) == pytest.approx(value, rel=0.3)
    turned = np.ascontiguousarray(framed.transpose(1, 0, 2))
    assert sharpness(turned, TravelDirection.UP) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize("spacing_mm", [0.0, 3.0, 10.0, 17.0, 50.0])
@pytest.mark.parametrize("window", [0.0, 0.5, 1.0])
def test_the_choice_is_even_ordered_and_keeps_both_ends(spacing_mm, window):
    values = np.random.default_rng(7).random(120)
    chosen = select_frames(values, 0.6, FrameOptions(spacing_mm=spacing_mm, sharpness_window=window))
    assert (chosen[0], chosen[-1]) == (0, 119)
    steps = np.diff(chosen)
    assert steps.min() >= 1
    step = max(1, round(spacing_mm / (600 / 119)))
    assert len(chosen) == 1 + round(119 / step)
    assert steps.max() <= (1 + window) * 119 / (len(chosen) - 1) + 1


def test_the_sharpest_frame_of_each_window_is_taken():
    values = np.ones(41)
    values[[9, 22, 31]] = 2.0
    options = FrameOptions(spacing_mm=100.0, sharpness_window=0.5)
    assert select_frames(values, 0.4, options).tolist() == [0, 9, 22, 31, 40]
    narrow = FrameOptions(spacing_mm=100.0, sharpness_window=0.3)
    assert select_frames(values, 0.4, narrow).tolist() == [0, 9, 20, 31, 40]


def test_most_frames_is_a_limit():
    chosen = select_frames(np.ones(100), 1.0, FrameOptions(spacing_mm=0.0, most_frames=10))
    assert len(chosen) == 10
    assert (chosen[0], chosen[-1]) == (0, 99)


def test_a_moment_is_as_sharp_as_its_worst_image_each_in_its_own_measure():
    combined = combined_sharpness([np.array([1.0, 2.0, 1.0]), np.array([50.0, 100.0, 100.0])])
    assert combined.tolist() == [0.5, 1.0, 1.0]


def test_of_images_at_uneven_steps_the_sharpest_in_every_half_spacing_stays():
    fractions = np.array([1.0, 0.0, 0.52, 0.30, 0.55, 0.05, 0.97])
    values = np.array([1.0, 1.0, 2.0, 1.0, 3.0, 1.0, 9.0])
    options = FrameOptions(spacing_mm=50.0)
    chosen = select_spread(values, fractions, 0.2, options)  # eight cells of 25 mm
    assert chosen.tolist() == [1, 5, 3, 4, 6, 0]
    assert select_spread(values, fractions, 0.2, EVERY).tolist() == [1, 5, 3, 2, 4, 6, 0]
    few = FrameOptions(spacing_mm=0.0, most_frames=3)
    assert select_spread(values, fractions, 0.2, few).tolist() == [1, 6, 0]
    with pytest.raises(StageError, match="leave 2 of 7 frames"):
        select_spread(values, fractions, 0.2, FrameOptions(most_frames=2))


@pytest.mark.parametrize("name", ["one.mp4", "one"])
def test_one_frame_alone_is_the_same_as_in_the_row(tmp_path, name):
    images = [picture(k) for k in range(12)]
    if name.endswith(".mp4"):
        write_video(tmp_path / name, images)
    else:
        write_images(tmp_path / name, images, [f"img{k}.png" for k in range(12)])
    (block,) = survey_of(tmp_path, name).blocks
    whole = list(read_frames(block))
    assert count_frames(block) == len(whole) == 12
    for index in (7, 0, 11):
        alone = read_frame(block, index)
        assert (alone.index, alone.promised) == (index, 12)
        np.testing.assert_array_equal(alone.image, whole[index].image)
    for index in (-1, 12):
        with pytest.raises(
            StageError, match=f"has no frame {index}, for it holds 12; choose one from 0 to 11"
        ):
            read_frame(block, index)


def test_every_frame_is_named_as_the_chosen_ones_are(tmp_path):
    write_video(tmp_path / "one.mp4", [picture(k) for k in range(12)])
    survey = survey_of(tmp_path, "one.mp4")
    (chosen,) = extract_frames(survey, FrameOptions(spacing_mm=50.0), tmp_path / "out", silent)
    every = every_frame(survey.blocks[0])
    assert (len(every), every.source_count, every.width_px, every.height_px) == (12, 12, *SIZE)
    assert len(chosen) == 5
    assert [every.files[k].name for k in chosen.source_indices] == [file.name for file in chosen.files]
