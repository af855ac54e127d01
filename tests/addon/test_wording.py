"""What the pipeline says in English stands in a Chinese frame: the stage's name, and the way out."""

import pytest

from tests.addon.shown_run import library

SAID = "mosaic: pair 2 of pairs.csv was picked on Block1 before it was adjusted anew; pick it again."


@pytest.fixture
def chinese(cabletwin, monkeypatch):
    """PyPI's bpy is built without languages: the add-on's own catalogue stands in for Blender's."""
    (known,) = library("translations").catalogue().values()
    wording = library("wording")
    monkeypatch.setattr(wording, "translated", lambda text: known.get(("*", text), text))
    return wording


def test_a_sentence_is_framed(chinese):
    assert chinese.framed(SAID) == (
        "拼接：pair 2 of pairs.csv was picked on Block1 before it was adjusted anew。解决办法：pick it again."
    )


def test_every_stage_has_a_chinese_name(chinese):
    names = [name for name, _, _ in library("properties.run").STAGES]
    for name in [*names, "run", "survey", "export", "synthesise", "render"]:
        told = chinese.framed(f"{name}: cause; remedy.")
        label = told.removesuffix("：cause。解决办法：remedy.")
        assert label != told
        assert not label.isascii() or label == "POS", told


@pytest.mark.parametrize("words", ["the process ended with code 3", "Block1: no such thing", "fits: a; b."])
def test_what_is_no_such_sentence_stays_as_it_is(chinese, words):
    assert chinese.framed(words) == words


def test_english_stays_english(cabletwin):
    assert library("wording").framed(SAID) == SAID
