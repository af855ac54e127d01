"""What looks wrong though it can be worked with is said in one sentence that names the likely cause."""

from dataclasses import replace

import pytest
from scipy.spatial.transform import Rotation

from pipeline.cable.cautions import numbering_cautions, rig_cautions
from pipeline.cable.joint import JointOptions, adjust_ring
from pipeline.cable.survey_records import Block, LensSpec
from pipeline.core.vocabulary import TravelDirection
from tests.cable import ring_scene, scene


@pytest.fixture
def pictures(tmp_path):
    """A block whose pictures bear the given names."""

    def made(*names, block="Block1", ordered=True):
        folder = tmp_path / block
        folder.mkdir()
        for name in names:
            (folder / name).touch()
        return Block(
            name=block,
            source=folder,
            angle_deg=0.0,
            travel_in_image=TravelDirection.RIGHT,
            lens_spec=LensSpec(focal_px=700.0),
            ordered=ordered,
        )

    return made


def numbered(numbers, pattern="IMG_{:04d}.jpg"):
    return [pattern.format(n) for n in numbers]


class TestNumbering:
    def test_pictures_that_skip_numbers_are_told_with_the_place_and_what_to_do(self, pictures):
        block = pictures(*numbered([7, 8, 9, 13, 14, 15]))
        (said,) = numbering_cautions([block])
        assert said == (
            "The pictures of Block1 skip numbers (in Block1, IMG_0013.jpg comes next after IMG_0009.jpg), "
            "but are taken to lie at even steps of the travel: bring the missing pictures, or set "
            "ordered = false in every such block, so that their places are found from the pictures."
        )

    def test_several_blocks_make_one_sentence(self, pictures):
        gap, whole = numbered([1, 2, 3, 5]), numbered([1, 2, 3, 4])
        blocks = [pictures(*names, block=b) for b, names in (("A", gap), ("B", whole), ("C", gap))]
        (said,) = numbering_cautions(blocks)
        assert said.startswith("The pictures of A, C skip numbers (in A, IMG_0005.jpg")

    @pytest.mark.parametrize(
        "names",
        [
            numbered(range(8, 13), "{}.png"),
            numbered(range(0, 60, 5)),
            numbered([2, 3, 5, 8, 13, 21, 34]),
            numbered([7, 8, 9, 12], "IMG{}_v2.jpg"),
            ["first.png", "second.png", "third.png"],
            ["a1.png", "a2.png", "b4.png", "b5.png"],
        ],
        ids=["from 8 to 12", "every fifth", "times of day", "versions", "words", "two cameras"],
    )
    def test_other_names_tell_of_no_gap(self, pictures, names):
        assert numbering_cautions([pictures(*names)]) == ()

    def test_every_fifth_picture_with_one_left_out(self, pictures):
        (said,) = numbering_cautions([pictures(*numbered([0, 5, 10, 20, 25]))])
        assert "IMG_0020.jpg comes next after IMG_0010.jpg" in said

    def test_pictures_whose_places_are_found_anyway_may_skip(self, pictures):
        assert numbering_cautions([pictures(*numbered([7, 8, 9, 13]), ordered=False)]) == ()

    def test_a_video_has_no_names(self, pictures, tmp_path):
        (tmp_path / "1.mp4").touch()
        assert numbering_cautions([replace(pictures("1.png"), source=tmp_path / "1.mp4")]) == ()


@pytest.fixture(scope="module")
def blocks():
    """Four cameras on one body; each alone leaves the noise of its marks."""
    return alone(ring_scene.views())


def alone(views):
    made = ring_scene.blocks(views, 0.05, 6, count=200)
    return tuple(replace(b, orientation=replace(b.orientation, reprojection_px=0.06)) for b in made)


def claimed(block, angle_deg):
    """The block as it would have come with another angle written down."""
    turn = Rotation.from_euler("y", angle_deg - block.azimuth_deg, degrees=True).as_matrix()
    turned = replace(
        block.orientation, points=block.orientation.points @ turn.T, poses=scene.poses(angle_deg)
    )
    return replace(block, azimuth_deg=angle_deg, orientation=turned)


def said_of(blocks):
    found = adjust_ring(blocks, ring_scene.no_marks(), ring_scene.robot(), JointOptions(), scene.silent)
    return rig_cautions([b.orientation for b in blocks], found.blocks)


class TestRig:
    def test_cameras_that_fit_give_no_cause_to_speak(self, blocks):
        assert said_of(blocks) == ()

    @pytest.mark.parametrize("pair", [(0, 1), (1, 3)], ids=["neighbours", "opposite ones"])
    def test_swapped_angles_are_told(self, blocks, pair):
        swapped, (i, j) = list(blocks), pair
        swapped[i], swapped[j] = (claimed(blocks[k], blocks[m].azimuth_deg) for k, m in (pair, pair[::-1]))
        (said,) = said_of(tuple(swapped))
        assert "each block alone by 0.06 px" in said
        assert "likely angle_deg of two blocks are swapped, or the cameras share no clock" in said

    def test_a_camera_that_shares_no_clock_is_told(self, blocks):
        """Its body swayed another way at the same frames."""
        stranger = alone(ring_scene.views(seed=9))[1]
        (said,) = said_of((blocks[0], stranger, *blocks[2:]))
        assert "set robot.synchronised = false" in said

    @pytest.mark.parametrize(("together_px", "told"), [(0.44, 0), (0.47, 1)])
    def test_coarse_marks_may_miss_by_more(self, blocks, together_px, told):
        """0.27 px alone, as on a sheath with streaks: half as much again is chance, beyond is none."""
        before, behind = (
            [replace(b.orientation, reprojection_px=px) for b in blocks] for px in (0.27, together_px)
        )
        assert len(rig_cautions(before, behind)) == told
        assert len(rig_cautions(before, [*before[:3], behind[3]])) == told
