"""Pairs chosen by hand are read as written, and everything else is refused in one clear sentence."""

import numpy as np
import pytest

from pipeline.cable.pairs import HandPair, check_adjustments, group_pairs, read_pairs, write_pairs
from pipeline.core.errors import StageError

BLOCKS = ("Block1", "Block2", "Block3")
HEADER = "block_a,x_a,y_a,z_a,block_b,x_b,y_b,z_b"
GOOD = "Block1,0.01,0.2,-0.03,Block2,0.04,0.25,-0.06"


def write(folder, *lines, header=HEADER, encoding="utf-8"):
    path = folder / "pairs.csv"
    path.write_text("\n".join([header, *lines]) + "\n", encoding=encoding)
    return path


def grouped(path):
    return group_pairs(read_pairs(path, BLOCKS))


def refusal(path):
    with pytest.raises(StageError) as told:
        read_pairs(path, BLOCKS)
    return str(told.value)


def test_a_pair_is_read_as_it_was_written(tmp_path):
    (pair,) = grouped(write(tmp_path, GOOD))
    assert (pair.first, pair.second) == (0, 1)
    np.testing.assert_array_equal(pair.points_first, [[0.01, 0.2, -0.03]])
    np.testing.assert_array_equal(pair.points_second, [[0.04, 0.25, -0.06]])


def test_pairs_of_the_same_two_blocks_come_together_in_their_order(tmp_path):
    lines = ("Block2,1,2,3,Block3,4,5,6", GOOD, "Block2,7,8,9,Block3,10,11,12")
    first, second = grouped(write(tmp_path, *lines))
    assert (first.first, first.second, len(first.points_first)) == (0, 1, 1)
    assert (second.first, second.second) == (1, 2)
    np.testing.assert_array_equal(second.points_first, [[1, 2, 3], [7, 8, 9]])
    np.testing.assert_array_equal(second.points_second, [[4, 5, 6], [10, 11, 12]])


def test_either_block_may_stand_first(tmp_path):
    (pair,) = grouped(write(tmp_path, GOOD, "Block2,4,5,6,Block1,1,2,3"))
    assert (pair.first, pair.second) == (0, 1)
    np.testing.assert_array_equal(pair.points_first[1], [1, 2, 3])
    np.testing.assert_array_equal(pair.points_second[1], [4, 5, 6])


def test_a_spreadsheet_s_mark_at_the_start_spaces_and_further_columns_do_no_harm(tmp_path):
    path = write(
        tmp_path, " Block1 , 1 ,2,3, Block3,4,5, 6 ,scratch", header=f"{HEADER},remark", encoding="utf-8-sig"
    )
    (pair,) = grouped(path)
    assert (pair.first, pair.second) == (0, 2)
    np.testing.assert_array_equal(pair.points_second, [[4, 5, 6]])


def test_a_missing_file_is_named(tmp_path):
    path = tmp_path / "none.csv"
    assert refusal(path) == (f"mosaic: cannot read {path} (No such file or directory); correct --pairs.")


@pytest.mark.parametrize("header", [HEADER, ""])
def test_an_empty_file_is_told(tmp_path, header):
    path = write(tmp_path, header=header)
    assert refusal(path) == f"mosaic: {path} holds no pairs; write one line for each two neighbours."


def test_another_alphabet_is_told(tmp_path):
    path = tmp_path / "pairs.csv"
    path.write_bytes(f"{HEADER}\n".encode() + "缆索1".encode("gb18030") + b",1,2,3,Block2,4,5,6\n")
    assert refusal(path) == f"mosaic: {path} is no CSV in UTF-8; correct --pairs."


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("Block9,1,2,3,Block2,4,5,6", "Block9"),
        ("Block1,1,2,3,block2,4,5,6", "block2"),
        (",1,2,3,Block2,4,5,6", ""),
        ("Block1,1,2,3", ""),
    ],
)
def test_a_block_that_the_survey_does_not_have_is_named_with_its_line(tmp_path, line, name):
    path = write(tmp_path, GOOD, line)
    assert refusal(path) == (
        f'mosaic: line 3 of {path} names the block "{name}", which the survey does not have; use one of '
        "Block1, Block2, Block3 under the columns block_a, x_a, y_a, z_a, block_b, x_b, y_b, z_b."
    )


@pytest.mark.parametrize(
    ("line", "column", "text"),
    [
        ("Block1,one,2,3,Block2,4,5,6", "x_a", "one"),
        ("Block1,1,2,3,Block2,4,,6", "y_b", ""),
        ("Block1,1,2,nan,Block2,4,5,6", "z_a", "nan"),
        ("Block1,1,2,3,Block2,4,5,inf", "z_b", "inf"),
        ('Block1,"0,01",2,3,Block2,4,5,6', "x_a", "0,01"),
    ],
)
def test_a_number_that_is_none_is_named_with_its_column_and_line(tmp_path, line, column, text):
    path = write(tmp_path, line)
    assert refusal(path) == f'mosaic: {column} in line 2 of {path} is "{text}"; give it in metres.'


def test_a_missing_column_is_named(tmp_path):
    path = write(tmp_path, "Block1,1,2,Block2,4,5,6", header="block_a,x_a,y_a,block_b,x_b,y_b,z_b")
    assert refusal(path) == f'mosaic: z_a in line 2 of {path} is ""; give it in metres.'


def test_a_block_is_not_paired_with_itself(tmp_path):
    path = write(tmp_path, "Block1,1,2,3,Block1,4,5,6")
    assert refusal(path) == f"mosaic: line 2 of {path} pairs a block with itself; name two blocks."


def test_pairs_that_were_written_read_back_to_the_last_digit(tmp_path):
    path, third = tmp_path / "pairs.csv", 1 / 3
    pairs = [
        HandPair(block_a=2, block_b=1, point_a=(third, 0.2, -third), point_b=(0.1, 0.2 / 3, 0.3)),
        HandPair(block_a=1, block_b=2, point_a=(0.7, 0.8, 0.9), point_b=(1e-9, 2.0, np.float32(0.1))),
    ]
    write_pairs(path, pairs, BLOCKS)
    (found,) = grouped(path)
    assert (found.first, found.second) == (1, 2)
    np.testing.assert_array_equal(found.points_first, [[0.1, 0.2 / 3, 0.3], [0.7, 0.8, 0.9]])
    np.testing.assert_array_equal(
        found.points_second, [[third, 0.2, -third], [1e-9, 2.0, float(np.float32(0.1))]]
    )


def test_the_adjustment_that_a_pair_was_picked_on_is_kept(tmp_path):
    pair = HandPair(
        block_a=0, block_b=1, point_a=(1, 2, 3), point_b=(4, 5, 6), adjustment_a="aa", adjustment_b="bb"
    )
    write_pairs(tmp_path / "pairs.csv", [pair], BLOCKS)
    assert read_pairs(tmp_path / "pairs.csv", BLOCKS) == (pair,)


def test_a_pair_of_an_earlier_adjustment_is_named(tmp_path):
    path = write(tmp_path, f"{GOOD},aa,bb", f"{GOOD},aa,old", header=f"{HEADER},adjustment_a,adjustment_b")
    with pytest.raises(StageError) as told:
        check_adjustments(path, read_pairs(path, BLOCKS), BLOCKS, ("aa", "bb", "cc"))
    assert str(told.value) == (
        f"mosaic: pair 2 of {path} was picked on Block2 before it was adjusted anew; "
        "pick it again on the new mesh, or join the blocks automatically."
    )


def test_a_file_written_by_hand_knows_no_adjustment_and_passes(tmp_path):
    path = write(tmp_path, GOOD)
    check_adjustments(path, read_pairs(path, BLOCKS), BLOCKS, ("aa", "bb", "cc"))
