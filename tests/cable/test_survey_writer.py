"""A survey that is written reads back the same."""

from pathlib import Path

import pytest

from pipeline.cable.survey import read_survey, write_survey
from tests.cable.survey_text import CONTRACT, SECOND_BLOCK


def test_a_written_survey_reads_back_the_same(written, tmp_path):
    text = CONTRACT.replace("stay-07", 'Stahlseil \\"7\\" 缆') + SECOND_BLOCK
    survey = read_survey(
        written(text + '[options.frames]\nspacing_mm = 5\nmask = { top = [1, 2], kind = "x" }\n')
    )
    copy = tmp_path / "elsewhere" / "survey.toml"
    write_survey(survey, copy)
    assert read_survey(copy) == survey
    assert 'source = "../block1.mp4"' in copy.read_text(encoding="utf-8")
    assert not Path(tmp_path / "elsewhere").samefile(tmp_path)


@pytest.mark.parametrize("sigma_mm", [0.0, 0.46, 1.5])
def test_what_is_known_of_the_travel_is_written_too(written, tmp_path, sigma_mm):
    stated = CONTRACT.replace("[cable]\n", f"[cable]\ntravel_sigma_mm = {sigma_mm}\n")
    survey = read_survey(written(stated))
    assert survey.cable.travel_sigma_mm == sigma_mm
    write_survey(survey, tmp_path / "copy.toml")
    assert read_survey(tmp_path / "copy.toml").cable == survey.cable
