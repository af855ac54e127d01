"""Recordings that cannot be worked with are refused by the name of the file and the number of the frame."""

import pytest

from tests.bad_input import cylinder

PROMISED = cylinder.FRAMES


def cut(path, share):
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])


def test_a_truncated_video_tells_how_much_of_it_is_there(survey, refused):
    cut(survey / "block2.mp4", 0.75)
    said = refused(before="lens")
    assert str(survey / "block2.mp4") in said
    assert "truncated" in said
    assert f"promises {PROMISED} frames" in said


@pytest.mark.parametrize("content", [b"", b"This is no video.\n" * 100], ids=["empty", "text"])
def test_a_file_that_is_no_video(survey, refused, content):
    (survey / "block2.mp4").write_bytes(content)
    assert str(survey / "block2.mp4") in refused(before="lens")


def test_a_video_with_no_cable_in_it(survey, refused):
    cylinder.write_video(survey / "block2.mp4", [cylinder.sky(seed) for seed in range(PROMISED)])
    said = refused(before="pos")
    assert "shows no cable" in said
    assert "Block2" in said
    assert "frame 0" in said


def test_frames_without_any_content(survey, refused):
    images = cylinder.views(90.0)
    images[3] = images[3] * 0
    cylinder.write_video(survey / "block2.mp4", images)
    said = refused(before="lens")
    assert f"frame 3 of {survey / 'block2.mp4'}" in said
    assert "blank" in said


def test_synchronised_blocks_of_different_length(survey, refused):
    cylinder.write_video(survey / "block2.mp4", cylinder.views(90.0, count=6))
    said = refused(before="lens")
    assert "Block1 has 5 frames and Block2 has 6" in said
    assert "robot.synchronised" in said


def test_too_few_frames(survey, refused):
    for number in (1, 2):
        cylinder.write_video(survey / f"block{number}.mp4", cylinder.views(90.0, count=2))
    said = refused(before="lens")
    assert "block1.mp4" in said
    assert "2 frames" in said


@pytest.mark.parametrize("division_lambda", [-1.0, 1.3])
def test_a_lens_that_folds_within_its_picture(survey, refused, division_lambda):
    toml = survey / "survey.toml"
    toml.write_text(toml.read_text().replace("division_lambda = 0.0", f"division_lambda = {division_lambda}"))
    said = refused(before="lens")
    assert "block[Block1].lens" in said
    assert f"division_lambda = {division_lambda:g}" in said
    assert "folds" in said
