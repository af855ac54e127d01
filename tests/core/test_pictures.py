"""A picture is read whole whatever its path is called, or refused by name."""

import cv2
import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.core.pictures import read_colour, read_grey


def test_a_path_with_chinese_letters_is_read(tmp_path):
    file = tmp_path / "拉索" / "第1帧.png"
    file.parent.mkdir()
    picture = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    file.write_bytes(cv2.imencode(".png", picture)[1].tobytes())
    np.testing.assert_array_equal(read_colour(file, "lens"), picture)
    np.testing.assert_array_equal(read_grey(file, "lens"), cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY))


def test_what_is_no_picture_is_refused_by_name(tmp_path):
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"no picture")
    for file in (broken, tmp_path / "gone.png"):
        with pytest.raises(
            StageError, match=rf"dense: .*{file.stem}\.png cannot be read as an image"
        ) as refusal:
            read_grey(file, "dense")
        assert refusal.value.remedy == "restore the file or take it out"
