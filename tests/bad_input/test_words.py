"""Words of the command line that do not fit, and places that cannot be written."""

import cv2
import pytest

from tests.bad_input import cylinder
from tests.bad_input.conftest import assert_nothing_half_done, assert_refused
from tests.command import pipeline

SET = {
    "measure.slize_mm=8": ["measure.slize_mm", "measure.slice_mm"],
    "mesure.slice_mm=8": ["mesure", "measure"],
    "measure.slice_mm=thick": ["measure.slice_mm", '"thick"'],
    "measure.profile_mm=0": ["measure.profile_mm", "0"],
    "measure.slice_mm": ["measure.slice_mm", "key=value"],
    "frames.most_frames=2.5": ["frames.most_frames", "whole number"],
    "adjust.sigma_px=0": ["adjust.sigma_px", "0"],
    "dense.baselines_mm=[]": ["dense.baselines_mm", "empty"],
}


@pytest.mark.parametrize(("word", "named"), SET.items(), ids=SET)
def test_an_option_that_cannot_be_set(refused, word, named):
    said = refused("--set", word)
    assert [part for part in named if part not in said] == []


def test_one_stage_of_a_run_that_has_not_come_so_far(refused, tmp_path):
    said = refused("--only", "match", before="lens")
    assert "the stage frames is not finished" in said
    assert "without --only" in said


def test_the_stage_before_is_not_made_by_the_way(survey, tmp_path):
    out = tmp_path / "run"
    assert pipeline("run", survey / "survey.toml", "--out", out, "--only", "frames").code == 0
    done = pipeline("run", survey / "survey.toml", "--out", out, "--only", "match", "--events", "none")
    assert_refused(done)
    assert "the stage lens is not finished" in done.stderr
    assert [f.name for f in (out / "products").glob("*.npz")] == ["all-frames.npz"]


class TestPlacesThatCannotBeWritten:
    # a folder without rights would be no test: root may write there
    def test_a_file_where_the_run_folder_should_be(self, refused, tmp_path):
        (tmp_path / "run").write_text("in the way")
        assert str(tmp_path / "run") in refused()
        assert (tmp_path / "run").read_text() == "in the way"

    def test_a_file_on_the_way_to_it(self, refused, tmp_path):
        (tmp_path / "file").write_text("in the way")
        assert str(tmp_path / "file" / "deep" / "run") in refused(out=tmp_path / "file" / "deep" / "run")

    def test_a_file_where_the_blocks_should_be(self, refused, tmp_path):
        (tmp_path / "run").mkdir()
        (tmp_path / "run" / "blocks").write_text("in the way")
        assert str(tmp_path / "run" / "blocks") in refused(before="lens")

    def test_a_folder_where_a_product_should_be(self, refused, tmp_path):
        (tmp_path / "run" / "products" / "all-frames.npz" / "x").mkdir(parents=True)
        said = refused(before="frames-product", out=tmp_path / "run")
        assert "all-frames.npz" in said

    @pytest.mark.parametrize("room_bytes", [200, 12_000])
    def test_a_disk_that_is_full(self, survey, tmp_path, room_bytes):
        words = ("run", survey / "survey.toml", "--out", tmp_path / "run", "--events", "none")
        done = pipeline(*words, largest_file_bytes=room_bytes)
        assert_refused(done)
        assert f"cannot write {tmp_path / 'run'}" in done.stderr
        assert "make room" in done.stderr
        assert_nothing_half_done(tmp_path / "run")


BOARD = {
    "9by6": ['"9by6"', "9x6"],
    "9x6": ["holds-no-board", "9x6 inner corners"],
}


class TestCalibration:
    """``lens --chessboard``."""

    @pytest.mark.parametrize(("board", "named"), BOARD.items(), ids=BOARD)
    def test_pictures_or_a_board_that_cannot_be(self, tmp_path, board, named):
        folder = tmp_path / "holds-no-board"
        folder.mkdir()
        cv2.imwrite(str(folder / "1.png"), cylinder.sky())
        done = pipeline("lens", folder, "--chessboard", board)
        assert_refused(done)
        assert [word for word in named if word not in done.stderr] == []

    def test_a_folder_that_is_not_there(self, tmp_path):
        done = pipeline("lens", tmp_path / "none", "--chessboard", "9x6")
        assert_refused(done)
        assert str(tmp_path / "none") in done.stderr
