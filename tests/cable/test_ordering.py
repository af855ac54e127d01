"""Photographs without order get their places along the cable from the pictures; strays are named."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pipeline.cable.frames import FrameOptions, extract_frames
from pipeline.cable.ordering import OrderOptions, travel_fractions
from pipeline.cable.survey import survey_from
from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import silent
from tests.cable import scene

TAKEN = [6, 2, 9, 0, 7, 5, 1]  # of ten even steps, 3, 4 and 8 are missing
NAMES = [f"img_{k}.png" for k in range(len(TAKEN))]
SIZES = [(scene.WIDTH_PX, scene.HEIGHT_PX)]


@pytest.fixture(scope="module")
def pictures(barrel_view):
    return [barrel_view.picture(k) for k in range(scene.FRAMES)]


@pytest.fixture
def survey(tmp_path, pictures):
    """Two unordered blocks; the second camera saw the same."""
    for block in ("Block1", "Block2"):
        (tmp_path / block).mkdir()
        for name, k in zip(NAMES, TAKEN, strict=True):
            cv2.imwrite(str(tmp_path / block / name), pictures[k])
    return survey_of(tmp_path)


def survey_of(folder, blocks=("Block1",), synchronised=False, travel_m=scene.TRAVEL_M, diameter_mm=110.0):
    cable = {"travel_m": travel_m} | ({"diameter_mm": diameter_mm} if diameter_mm else {})
    lens = {"focal_px": scene.FOCAL_PX, "division_lambda": scene.BARREL}
    same = {"travel_in_image": "right", "ordered": False, "lens": lens}
    return survey_from(
        {
            "format": 1,
            "name": "photographs",
            "cable": cable,
            "robot": {"standoff_m": scene.STANDOFF_M, "synchronised": synchronised},
            "block": [
                {"name": name, "source": name, "angle_deg": 90 * k, **same} for k, name in enumerate(blocks)
            ],
        },
        folder,
    )


def fractions_of(survey):
    return travel_fractions(survey, SIZES * len(survey.blocks), OrderOptions(), silent)


def told(survey):
    with pytest.raises(StageError) as caught:
        fractions_of(survey)
    assert caught.value.stage == "frames"
    return str(caught.value)


def true_fractions(view):
    along = view.poses.centres[TAKEN, 1]
    return (along - along.min()) / np.ptp(along)


def test_order_and_uneven_steps_are_found(survey, barrel_view):
    (found,) = fractions_of(survey)
    assert np.argsort(found).tolist() == np.argsort(TAKEN).tolist()
    assert (found.min(), found.max()) == (0.0, 1.0)
    # a sway of 0.15 degrees looks like 0.7 mm along the cable
    error_mm = 1000 * scene.TRAVEL_M * (found - true_fractions(barrel_view))
    assert 0.01 < np.abs(error_mm).max() < 3.0


def test_without_a_nominal_diameter_the_outline_gives_the_radius(survey, tmp_path):
    (outlined,) = fractions_of(survey_of(tmp_path, diameter_mm=None))
    (nominal,) = fractions_of(survey)
    np.testing.assert_allclose(outlined, nominal, atol=0.01)


def test_frames_come_in_the_order_of_travel_with_their_places(survey, tmp_path):
    options = FrameOptions(spacing_mm=0.0)
    (frames,) = extract_frames(survey, options, tmp_path / "run", silent)
    expected = np.argsort(TAKEN)
    assert [file.name for file in frames.files] == [NAMES[k] for k in expected]
    assert frames.source_indices.tolist() == expected.tolist()
    true_m = scene.STEP_M * np.sort(TAKEN)
    np.testing.assert_allclose(frames.places_m(scene.TRAVEL_M), true_m, atol=0.003)


def test_synchronised_blocks_share_one_set_of_places(survey, tmp_path):
    together = survey_of(tmp_path, ("Block1", "Block2"), synchronised=True)
    first, second = fractions_of(together)
    np.testing.assert_array_equal(first, second)


def test_synchronised_blocks_of_another_order_are_refused(survey, tmp_path):
    one, other = (tmp_path / "Block2" / name for name in NAMES[:2])
    swapped = one.read_bytes(), other.read_bytes()
    one.write_bytes(swapped[1])
    other.write_bytes(swapped[0])
    sentence = told(survey_of(tmp_path, ("Block1", "Block2"), synchronised=True))
    assert "of Block1 was taken elsewhere on the way" in sentence
    assert "robot.synchronised = false" in sentence


def test_an_image_of_another_cable_is_named(survey, tmp_path, barrel_view):
    stray = replace(barrel_view, texture=scene.Texture(seed=9))
    cv2.imwrite(str(tmp_path / "Block1" / "stray.png"), stray.picture(3))
    assert "Block1: stray.png cannot be tied to the other images" in told(survey)


def test_a_travel_that_the_pictures_contradict_is_refused(survey, tmp_path):
    sentence = told(survey_of(tmp_path, travel_m=0.26))
    assert "show about 0.18 m of way, but cable.travel_m is 0.26" in sentence


def test_progress_never_goes_back_and_may_cancel(survey, tmp_path):
    shares = []
    extract_frames(
        survey, FrameOptions(spacing_mm=0), tmp_path, lambda event: shares.append(event.done / event.total)
    )
    assert shares == sorted(shares)
    assert shares[-1] == 1.0

    def cancel(event):
        raise Cancelled

    with pytest.raises(Cancelled):
        travel_fractions(survey, SIZES, OrderOptions(), cancel)
