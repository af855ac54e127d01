"""A product comes back from disk as it went in, wherever its folder has moved; a stamp tells inputs apart."""

from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.core import store
from pipeline.core.vocabulary import Array


class Colour(StrEnum):
    RED = "red"
    GREEN = "green"


@dataclass(frozen=True, kw_only=True)
class Leaf:
    size: float
    colour: Colour
    values: Array


@dataclass(frozen=True, kw_only=True)
class Tree:
    name: str
    count: int
    alive: bool
    leaves: tuple[Leaf, ...]
    pair: tuple[str, float]
    best: Leaf | None
    limits: Array | None
    shares: dict[str, float]
    tables: dict[str, Array]
    mask: NDArray[np.bool_]
    numbers: NDArray[np.int32]
    inside: tuple[Path, ...]
    outside: Path


@dataclass(frozen=True, kw_only=True)
class Named:
    file: Path


def leaf(size=1.5, colour=Colour.GREEN):
    return Leaf(size=size, colour=colour, values=np.array([[1.0, np.nan], [np.inf, -0.0]]))


def make_tree(root, outside):
    files = tuple(root / "frames" / f"{k}.png" for k in range(2))
    files[0].parent.mkdir(parents=True, exist_ok=True)
    for file in (*files, outside):
        file.write_bytes(b"x")
    return Tree(
        name="Brücke 7",
        count=3,
        alive=True,
        leaves=(leaf(), leaf(float("inf"), Colour.RED)),
        pair=("A", 0.1 + 0.2),
        best=None,
        limits=np.zeros((0, 3)),
        shares={"one": 1 / 3},
        tables={"b": np.eye(2), "a": np.ones(1, dtype=np.float32)},
        mask=np.array([True, False]),
        numbers=np.array([7, -7], dtype=np.int32),
        inside=files,
        outside=outside,
    )


def same(first, second):
    assert type(first) is type(second)
    if isinstance(first, np.ndarray):
        assert first.dtype == second.dtype
        np.testing.assert_array_equal(first, second)
    elif isinstance(first, tuple):
        assert len(first) == len(second)
        for one, other in zip(first, second, strict=True):
            same(one, other)
    elif isinstance(first, dict):
        assert first.keys() == second.keys()
        for key, value in first.items():
            same(value, second[key])
    elif hasattr(first, "__dataclass_fields__"):
        for name in first.__dataclass_fields__:
            same(getattr(first, name), getattr(second, name))
    else:
        assert first == second


def test_everything_a_product_may_hold_comes_back_the_same(tmp_path):
    root = tmp_path / "run"
    tree = make_tree(root, tmp_path / "video.mp4")
    store.save(tree, root / "products" / "tree.npz", root)
    same(store.load(Tree, root / "products" / "tree.npz", root), tree)


def test_optional_values_come_back_where_they_are_there(tmp_path):
    tree = replace(make_tree(tmp_path, tmp_path / "v"), best=leaf(2.0), limits=None)
    store.save(tree, tmp_path / "tree.npz", tmp_path)
    same(store.load(Tree, tmp_path / "tree.npz", tmp_path), tree)


def test_a_moved_run_folder_still_loads_and_names_the_files_at_their_new_place(tmp_path):
    tree = make_tree(tmp_path / "run", tmp_path / "video.mp4")
    store.save(tree, tmp_path / "run" / "tree.npz", tmp_path / "run")
    moved = (tmp_path / "run").rename(tmp_path / "elsewhere")
    found = store.load(Tree, moved / "tree.npz", moved)
    assert found.inside == (moved / "frames" / "0.png", moved / "frames" / "1.png")
    assert found.outside == tmp_path / "video.mp4"


@pytest.mark.parametrize("gone", ["frames/1.png", "tree.npz"])
def test_a_product_whose_files_are_gone_is_as_good_as_missing(tmp_path, gone):
    store.save(make_tree(tmp_path, tmp_path / "v"), tmp_path / "tree.npz", tmp_path)
    (tmp_path / gone).unlink()
    with pytest.raises(FileNotFoundError, match=gone):
        store.load(Tree, tmp_path / "tree.npz", tmp_path)


@pytest.mark.parametrize("value", [{1, 2}, object(), 1j, b"bytes"])
def test_what_a_product_cannot_hold_is_refused_and_leaves_the_old_one(tmp_path, value):
    file = tmp_path / "named.npz"
    (tmp_path / "a").touch()
    store.save(Named(file=tmp_path / "a"), file, tmp_path)
    with pytest.raises(TypeError, match=type(value).__name__):
        store.save(Named(file=value), file, tmp_path)
    assert store.load(Named, file, tmp_path).file == tmp_path / "a"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "named.npz"]


def test_equal_inputs_have_equal_stamps_whoever_made_them():
    assert store.stamp(leaf(), ("a", 1)) == store.stamp(leaf(), ("a", 1))
    assert store.stamp({"a": 1, "b": 2}) == store.stamp({"b": 2, "a": 1})
    swapped = np.arange(6.0).reshape(2, 3)
    assert store.stamp(swapped.T) == store.stamp(np.ascontiguousarray(swapped.T))


BASE = (leaf(), np.arange(6), "text", 1.0, None, Path("a/b"))
CHANGES = {
    "a number": (leaf(), np.arange(6), "text", 1.0 + 1e-15, None, Path("a/b")),
    "a text": (leaf(), np.arange(6), "texts", 1.0, None, Path("a/b")),
    "a path": (leaf(), np.arange(6), "text", 1.0, None, Path("a/c")),
    "an optional value": (leaf(), np.arange(6), "text", 1.0, 0, Path("a/b")),
    "a field": (replace(leaf(), size=1.6), np.arange(6), "text", 1.0, None, Path("a/b")),
    "an enum": (leaf(colour=Colour.RED), np.arange(6), "text", 1.0, None, Path("a/b")),
    "one element": (leaf(), np.array([0, 1, 2, 3, 4, 6]), "text", 1.0, None, Path("a/b")),
    "the shape": (leaf(), np.arange(6).reshape(2, 3), "text", 1.0, None, Path("a/b")),
    "the type": (leaf(), np.arange(6, dtype=np.int32), "text", 1.0, None, Path("a/b")),
    "the order": (np.arange(6), leaf(), "text", 1.0, None, Path("a/b")),
    "the count": (leaf(), np.arange(6), "text", 1.0, None),
}


@pytest.mark.parametrize("what", CHANGES)
def test_a_stamp_changes_with_each_ingredient(what):
    assert store.stamp(*CHANGES[what]) != store.stamp(*BASE)


def test_arrays_that_only_join_up_the_same_are_told_apart():
    assert store.stamp(np.arange(2), np.arange(2, 5)) != store.stamp(np.arange(3), np.arange(3, 5))


def test_a_file_is_known_by_its_content_and_not_by_its_name(tmp_path):
    for name, content in (("a", b"one"), ("b", b"one"), ("c", b"two")):
        (tmp_path / name).write_bytes(content)
    one, same_again, other = (store.stamp_file(tmp_path / name) for name in "abc")
    assert one == same_again != other
