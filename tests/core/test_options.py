"""Options are built strictly from a mapping; what does not fit is told with the key's full name."""

from dataclasses import FrozenInstanceError, dataclass, field
from enum import StrEnum

import pytest

from pipeline.core.errors import StageError
from pipeline.core.options import build, override


class Method(StrEnum):
    SWEEP = "sweep"
    PATCH = "patch-match"


@dataclass(frozen=True, kw_only=True)
class Window:
    width_px: int = 7
    weights: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Layer:
    name: str
    depth_mm: float = field(metadata={"above": 0.0, "maximum": 100.0})


@dataclass(frozen=True, kw_only=True)
class Options:
    spacing_mm: float = field(metadata={"minimum": 0.0})
    method: Method = Method.SWEEP
    seed: int | None = None
    fast: bool = False
    window: Window = field(default_factory=Window)
    layers: tuple[Layer, ...] = field(default=(), metadata={"key": "layer"})


def refused(values, *words):
    with pytest.raises(StageError) as caught:
        build(Options, values, key="options.dense", stage="survey")
    for word in words:
        assert word in str(caught.value)
    return caught.value


def test_builds_nested_records_tuples_and_enums():
    options = build(
        Options,
        {
            "spacing_mm": 3,
            "method": "patch-match",
            "window": {"width_px": 9, "weights": [1, 2.5]},
            "layer": [{"name": "sheath", "depth_mm": 5}],
        },
    )
    assert options == Options(
        spacing_mm=3.0,
        method=Method.PATCH,
        window=Window(width_px=9, weights=(1.0, 2.5)),
        layers=(Layer(name="sheath", depth_mm=5.0),),
    )
    assert isinstance(options.spacing_mm, float)
    with pytest.raises(FrozenInstanceError):
        options.fast = True


def test_left_out_keys_take_their_defaults():
    assert build(Options, {"spacing_mm": 1.5}) == Options(spacing_mm=1.5)


def test_unknown_key_is_told_in_full_with_the_nearest_one():
    error = refused(
        {"spacing_mm": 1, "window": {"widht_px": 3}},
        "options.dense.window.widht_px",
        "options.dense.window.width_px",
    )
    assert error.stage == "survey"


def test_unknown_key_far_from_any_lists_the_known_ones():
    refused({"spacing_mm": 1, "zzz": 3}, "options.dense.zzz", "spacing_mm", "layer")


def test_missing_key_is_named():
    refused({}, "options.dense.spacing_mm is missing")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"spacing_mm": "3"}, ['options.dense.spacing_mm is "3"', "a number"]),
        ({"spacing_mm": True}, ["spacing_mm is true", "a number"]),
        ({"spacing_mm": float("nan")}, ["spacing_mm is nan", "finite"]),
        ({"spacing_mm": 1, "seed": 1.5}, ["options.dense.seed is 1.5", "whole number"]),
        ({"spacing_mm": 1, "fast": 1}, ["options.dense.fast is 1", "true or false"]),
        ({"spacing_mm": 1, "method": "magic"}, ['method is "magic"', "sweep, patch-match"]),
        ({"spacing_mm": 1, "window": 3}, ["options.dense.window is 3", "a table"]),
        ({"spacing_mm": 1, "window": {"weights": [1, 2, 3]}}, ["window.weights has 3 values", "give 2"]),
        ({"spacing_mm": 1, "window": {"weights": [1, "x"]}}, ["window.weights[2]"]),
        ({"spacing_mm": 1, "layer": {"name": "a"}}, ["options.dense.layer is a table", "square brackets"]),
        ({"spacing_mm": -1}, ["spacing_mm is -1", "at least 0"]),
    ],
)
def test_a_wrong_value_is_told_with_key_value_and_what_to_write(values, words):
    refused(values, *words)


def test_an_item_of_a_list_is_called_by_its_name_or_else_its_number():
    refused({"spacing_mm": 1, "layer": [{"name": "sheath", "depth_mm": 0}]}, "layer[sheath].depth_mm is 0")
    refused({"spacing_mm": 1, "layer": [{"depth_mm": 1}]}, "layer[1].name is missing")
    refused({"spacing_mm": 1, "layer": [{"name": "a", "depth_mm": 101}]}, "at most 100")


@pytest.mark.parametrize(
    ("assignment", "changed"),
    [
        ("spacing_mm=2", Options(spacing_mm=2.0)),
        ("method = sweep", Options(spacing_mm=1.0, method=Method.SWEEP)),
        ("method='patch-match'", Options(spacing_mm=1.0, method=Method.PATCH)),
        ("window.width_px=11", Options(spacing_mm=1.0, window=Window(width_px=11))),
        ("window.weights=[0, 1]", Options(spacing_mm=1.0, window=Window(weights=(0.0, 1.0)))),
        ("fast=true", Options(spacing_mm=1.0, fast=True)),
        ("seed=4", Options(spacing_mm=1.0, seed=4)),
    ],
)
def test_override_replaces_one_value(assignment, changed):
    assert override(Options(spacing_mm=1.0), assignment) == changed


@pytest.mark.parametrize(
    ("assignment", "word"),
    [
        ("spacing_mm", "no assignment"),
        ("=3", "no assignment"),
        ("spacing=2", "perhaps dense.spacing_mm"),
        ("window.width=2", "perhaps dense.window.width_px"),
        ("spacing_mm.x=2", "no keys of its own"),
        ("spacing_mm=wide", 'dense.spacing_mm is "wide"'),
        ("spacing_mm=-2", "at least 0"),
    ],
)
def test_override_refuses_what_does_not_fit(assignment, word):
    with pytest.raises(StageError, match="options: ") as caught:
        override(Options(spacing_mm=1.0), assignment, key="dense")
    assert word in str(caught.value)
