"""What is finished is kept; what depends on a change, or was interrupted, is made again."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from pipeline.core import runfolder
from pipeline.core.errors import StageError
from pipeline.core.runfolder import Product, RunFolder


@dataclass(frozen=True, kw_only=True)
class Number:
    value: float


@dataclass(frozen=True, kw_only=True)
class Written:
    file: Path


class Work:
    """Four stages, source -> left -> end and source -> right, that note when they are really made."""

    def __init__(self, path, fresh=(), only=None):
        self.folder = RunFolder(path, frozenset(fresh), None if only is None else frozenset(only))
        self.made = []

    def stage(self, name, value, *needs, block=""):
        def build():
            self.made.append(name + block)
            return Number(value=value)

        return self.folder.product(name, Number, build, *needs, block=block)

    def run(self, source=1.0, left=2.0, right=3.0):
        first = self.stage("source", source, source)
        second = self.stage("left", first.value.value + left, first, left)
        self.stage("right", first.value.value + right, first, right)
        return self.stage("end", 10 * second.value.value, second).value.value


def test_a_run_that_is_started_again_makes_nothing_twice(tmp_path):
    first, second = Work(tmp_path), Work(tmp_path)
    assert first.run() == second.run() == 30.0
    assert first.made == ["source", "left", "right", "end"]
    assert second.made == []


@pytest.mark.parametrize(
    ("change", "remade", "result"),
    [
        ({"source": 2.0}, ["source", "left", "right", "end"], 40.0),
        ({"left": 4.0}, ["left", "end"], 50.0),
        ({"right": 4.0}, ["right"], 30.0),
    ],
)
def test_a_changed_option_makes_again_exactly_what_depends_on_it(tmp_path, change, remade, result):
    Work(tmp_path).run()
    again = Work(tmp_path)
    assert again.run(**change) == result
    assert again.made == remade


def test_a_new_version_of_the_program_takes_no_old_product_for_a_new_one(tmp_path, monkeypatch):
    Work(tmp_path).run()
    monkeypatch.setattr(runfolder, "VERSION", "next")
    again = Work(tmp_path)
    again.run()
    assert again.made == ["source", "left", "right", "end"]


def test_blocks_are_kept_apart(tmp_path):
    work = Work(tmp_path)
    for block in ("Block1", "Block2"):
        work.stage("match", 1.0, 5, block=block)
    assert work.made == ["matchBlock1", "matchBlock2"]
    again = Work(tmp_path)
    again.stage("match", 1.0, 5, block="Block1")
    again.stage("match", 1.0, 6, block="Block2")
    assert again.made == ["matchBlock2"]


@pytest.mark.parametrize("stop", [KeyboardInterrupt, StageError])
def test_an_interrupted_stage_leaves_nothing_and_is_made_at_the_next_start(tmp_path, stop):
    def interrupted():
        raise stop("match", "the lamp fell off", "put it back") if stop is StageError else stop

    folder = RunFolder(tmp_path)
    with pytest.raises(stop):
        folder.product("match", Number, interrupted, 1)
    assert list((tmp_path / "products").iterdir()) == []
    work = Work(tmp_path)
    assert work.stage("match", 4.0, 1).value.value == 4.0
    assert work.made == ["match"]


def test_an_interruption_never_leaves_an_old_product_under_a_new_stamp(tmp_path):
    def interrupted():
        raise KeyboardInterrupt

    Work(tmp_path).stage("match", 1.0, "old option")
    with pytest.raises(KeyboardInterrupt):
        RunFolder(tmp_path).product("match", Number, interrupted, "new option")
    assert Work(tmp_path).stage("match", 2.0, "new option").value.value == 2.0


def test_an_interruption_never_leaves_a_new_product_under_an_old_stamp(tmp_path, monkeypatch):
    """The power goes between the product and its stamp: nobody may take the new one for the old."""

    def no_power(path, text, stage):
        raise KeyboardInterrupt

    Work(tmp_path).stage("match", 1.0, "old option")
    with monkeypatch.context() as dark:
        dark.setattr(runfolder, "write_text", no_power)
        with pytest.raises(KeyboardInterrupt):
            Work(tmp_path).stage("match", 2.0, "new option")
    again = Work(tmp_path)
    assert again.stage("match", 1.0, "old option").value.value == 1.0
    assert again.made == ["match"]


@pytest.mark.parametrize("gone", ["products/all-write.npz", "products/all-write.stamp", "picture.png"])
def test_what_someone_tidied_away_is_made_again(tmp_path, gone):
    def write(folder):
        (folder.path / "picture.png").write_bytes(b"x")
        return Written(file=folder.path / "picture.png")

    made = []
    for _ in range(3):
        folder = RunFolder(tmp_path)
        product = folder.product("write", Written, lambda f=folder: made.append(1) or write(f), 1)
        assert product.value.file.exists()
        if len(made) == 1:
            (tmp_path / gone).unlink()
    assert len(made) == 2


def test_a_moved_run_goes_on_where_it_was(tmp_path):
    """Products that hold files of the run folder, and all that depends on them, survive a move."""

    def run(path):
        folder, made = RunFolder(path), []

        def write():
            made.append("write")
            (folder.path / "picture.png").write_bytes(b"x")
            return Written(file=folder.path / "picture.png")

        def count():
            made.append("count")
            return Number(value=1.0)

        written = folder.product("write", Written, write, 1)
        folder.product("count", Number, count, written)
        return made

    assert run(tmp_path / "here") == ["write", "count"]
    (tmp_path / "here").rename(tmp_path / "there")
    assert run(tmp_path / "there") == []


def test_a_part_of_a_product_carries_the_stamp_of_the_part_and_its_origin():
    part = Product.of(Number(value=1.0), "first.mp4")
    assert part.stamp == Product.of(Number(value=1.0), "first.mp4").stamp
    assert part.stamp != Product.of(Number(value=2.0), "first.mp4").stamp
    assert part.stamp != Product.of(Number(value=1.0), "second.mp4").stamp


def test_files_of_the_run_folder_count_by_their_place_in_it(tmp_path):
    def part(folder, name):
        return Product.of(Written(file=tmp_path / folder / name), root=tmp_path / folder).stamp

    assert part("here", "picture.png") == part("there", "picture.png")
    assert part("here", "picture.png") != part("here", "other.png")


def test_fresh_stages_are_made_again_though_nothing_changed(tmp_path):
    Work(tmp_path).run()
    again = Work(tmp_path, fresh=["left", "end"])
    again.run()
    assert again.made == ["left", "end"]


def test_only_one_stage_runs_on_what_is_finished(tmp_path):
    Work(tmp_path).run()
    again = Work(tmp_path, fresh=["left"], only=["left"])
    source = again.stage("source", 1.0, 1.0)
    again.stage("left", 3.0, source, 2.0)
    assert again.made == ["left"]


def test_only_one_stage_is_refused_while_another_is_missing(tmp_path):
    work = Work(tmp_path / "stay-07", only=["left"])
    with pytest.raises(StageError) as told:
        work.stage("source", 1.0, 1.0)
    assert str(told.value) == (
        "run: the stage source is not finished in stay-07 with this survey and these options; "
        "run it first, without --only."
    )
    assert work.made == []


def test_only_one_stage_is_refused_when_what_it_stands_on_has_changed(tmp_path):
    Work(tmp_path).run()
    with pytest.raises(StageError, match="source is not finished"):
        Work(tmp_path, only=["left"]).run(source=5.0)


def test_a_folder_that_cannot_be_written_is_refused_in_one_sentence(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StageError) as told:
        RunFolder(tmp_path / "file" / "run")
    assert str(told.value).startswith("run: cannot write to ")
    assert str(told.value).endswith("; choose another --out folder.")


def test_a_block_folder_that_cannot_be_made_is_refused_in_one_sentence(tmp_path):
    folder = RunFolder(tmp_path)
    assert folder.block("Block1") == tmp_path / "blocks" / "Block1"
    (tmp_path / "blocks" / "Block2").write_text("in the way")
    with pytest.raises(StageError, match=r"^run: cannot write .*Block2 .*; choose another"):
        folder.block("Block2")


def test_the_time_of_a_stage_is_the_sum_of_its_blocks_and_is_remembered(tmp_path):
    folder = RunFolder(tmp_path)
    folder.note_time("match", "Block1", 1.5)
    folder.note_time("match", "Block2", 2.0)
    folder.note_time("mosaic", "", 0.25)
    folder.note_time("match", "Block1", 1.0)
    seconds = RunFolder(tmp_path).stage_seconds()
    assert seconds == {"match": 3.0, "mosaic": 0.25}
    assert list(seconds) == ["match", "mosaic"]


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("name", ["all-left.npz", "timing.json"])
def test_what_a_power_cut_left_half_written_is_made_again(tmp_path, name, share):
    Work(tmp_path).run()
    file = tmp_path / "products" / name
    file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
    again = Work(tmp_path)
    assert again.run() == 30.0
    assert again.made == (["left"] if name == "all-left.npz" else [])
