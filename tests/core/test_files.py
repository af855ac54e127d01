"""A result appears whole or not at all."""

import json
from enum import StrEnum
from pathlib import Path

import cv2
import numpy as np
import pytest

from pipeline.core import files
from pipeline.core.errors import StageError


class Kind(StrEnum):
    LEFT = "left"


def test_a_finished_file_has_its_place_and_no_temporary_stays(tmp_path):
    with files.replacing(tmp_path / "new" / "a.txt") as temporary:
        temporary.write_text("whole")
        assert not (tmp_path / "new" / "a.txt").exists()
        assert temporary.suffix == ".txt"
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["a.txt"]


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, ValueError])
def test_an_interrupted_write_leaves_the_old_file(tmp_path, interruption):
    place = tmp_path / "a.txt"
    place.write_text("old")

    def write_half():
        with files.replacing(place) as temporary:
            temporary.write_text("half")
            raise interruption

    with pytest.raises(interruption):
        write_half()
    assert place.read_text() == "old"
    assert list(tmp_path.iterdir()) == [place]


def test_a_folder_is_replaced_as_a_whole(tmp_path):
    for content in ("one", "two"):
        with files.replacing(tmp_path / "sparse") as temporary:
            temporary.mkdir()
            (temporary / content).write_text(content)
    assert [path.name for path in (tmp_path / "sparse").iterdir()] == ["two"]
    assert [path.name for path in tmp_path.iterdir()] == ["sparse"]


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StageError, match=r"cannot write .*a\.txt .*; choose another folder"):
        files.write_text(tmp_path / "file" / "a.txt", "text")


def test_trouble_with_another_file_is_not_taken_for_trouble_with_this_one(tmp_path):
    with pytest.raises(FileNotFoundError), files.replacing(tmp_path / "a" / "a.txt"):
        (tmp_path / "elsewhere" / "input").read_text()


def test_json_holds_arrays_enums_and_paths_and_never_a_nan(tmp_path):
    value = {
        "a": np.array([1.5, np.nan]),
        "n": np.int64(3),
        "k": Kind.LEFT,
        "p": Path("b"),
        "x": (float("inf"), 1),
    }
    files.write_json(tmp_path / "a.json", value)
    written = json.loads((tmp_path / "a.json").read_text())
    assert written == {"a": [1.5, None], "n": 3, "k": "left", "p": "b", "x": [None, 1]}


def test_csv_floats_read_back_the_same(tmp_path):
    files.write_csv(tmp_path / "a.csv", ["name", "x"], [["one", 0.1 + 0.2], ["two, too", 1e-17]])
    assert (tmp_path / "a.csv").read_text() == 'name,x\none,0.30000000000000004\n"two, too",1e-17\n'


def test_bytes_are_written_as_they_are(tmp_path):
    content = bytes(range(256))
    assert files.write_bytes(tmp_path / "deep" / "a.bin", content).read_bytes() == content


@pytest.mark.parametrize("compression", [0, 1, 9])
def test_png_keeps_every_pixel(tmp_path, compression):
    image = np.random.default_rng(1).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    files.write_png(tmp_path / "a.png", image, compression)
    np.testing.assert_array_equal(cv2.imread(str(tmp_path / "a.png")), image)


def test_few_frames_are_left_uncompressed_and_many_are_not():
    assert files.frame_compression(24, 960, 600) == 0
    assert files.frame_compression(150, 960, 600) == 0
    assert files.frame_compression(160, 960, 600) == 1


def test_natural_order_counts_as_people_do():
    names = ["f10.png", "f9.png", "f9b.png", "a100.png", "1.png"]
    ordered = sorted((Path(name) for name in names), key=files.natural_key)
    assert [path.name for path in ordered] == ["1.png", "a100.png", "f9.png", "f9b.png", "f10.png"]


def test_brackets_of_an_existing_folder_are_no_pattern(tmp_path):
    folder = tmp_path / "cable [7]"
    folder.mkdir()
    for name in ("f2.png", "f10.png", "notes.txt"):
        (folder / name).write_text("")
    assert not files.is_pattern(folder)
    assert files.is_pattern(folder / "*.png")
    assert [path.name for path in files.matching(folder / "*.png")] == ["f2.png", "f10.png"]
    assert files.matching(folder / "*.jpg") == ()


def open_elsewhere(monkeypatch, times):
    """Windows' answer while another program has the file open."""
    tried, really = [], files.os.replace

    def refuse(source, target):
        tried.append(target)
        if len(tried) <= times:
            raise PermissionError(13, "Access is denied", str(source))
        really(source, target)

    monkeypatch.setattr(files.os, "replace", refuse)
    return tried


def test_a_file_that_is_open_elsewhere_for_a_moment_is_replaced_when_it_is_free(tmp_path, monkeypatch):
    (tmp_path / "new").write_text("new")
    tried = open_elsewhere(monkeypatch, times=2)
    files.put_in_place(tmp_path / "new", tmp_path / "old", pauses_s=(0.0, 0.0, 0.0))
    assert (tmp_path / "old").read_text() == "new"
    assert len(tried) == 3


def test_a_file_that_stays_open_elsewhere_is_given_up_after_the_last_pause(tmp_path, monkeypatch):
    (tmp_path / "new").write_text("new")
    tried = open_elsewhere(monkeypatch, times=9)
    with pytest.raises(PermissionError):
        files.put_in_place(tmp_path / "new", tmp_path / "old", pauses_s=(0.0, 0.0))
    assert len(tried) == 3


def test_a_file_that_is_open_elsewhere_is_told_with_its_way_out(tmp_path):
    place = tmp_path / "diameters.csv"
    place.write_text("in a spreadsheet")
    error = PermissionError(13, "Access is denied")
    error.winerror = 32  # only Windows sets it
    assert str(files.unwritable(place, error)) == (
        f"output: cannot write {place} (access is denied); "
        "close the program that has it open, or choose another folder."
    )
