"""Both languages are complete and carry the same numbers."""

import string

import pytest

from pipeline.report.labels import TEXTS, label


def placeholders(text):
    return {name for _, name, _, _ in string.Formatter().parse(text) if name}


@pytest.mark.parametrize("key", TEXTS)
def test_a_label_is_complete_in_both_languages(key):
    en, zh = TEXTS[key]
    assert en.strip()
    assert zh.strip()
    assert placeholders(en) == placeholders(zh)
    # English holds no Chinese characters; a title of one word may be the same in both.
    assert not any("\u4e00" <= character <= "\u9fff" for character in en)


def test_a_label_is_filled_in_both_languages():
    filled = label("mean_diameter_note", value="4")
    assert filled.text("en") == "over 4 stations"
    assert filled.text("zh") == "4 个测点的平均"


def test_plot_texts_are_told_apart_by_their_english():
    english = [en for key, (en, _) in TEXTS.items() if key.startswith(("plot_", "stage_"))]
    assert len(english) == len(set(english))


def test_an_unknown_label_is_an_error():
    with pytest.raises(KeyError):
        label("no such label")
