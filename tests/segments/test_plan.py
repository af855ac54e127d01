"""Where a long survey is cut."""

from itertools import pairwise

import pytest

from pipeline.segments.plan import SegmentOptions, cut


def test_a_survey_of_few_frames_stays_in_one_piece():
    (only,) = cut(60, SegmentOptions())
    assert (only.first, only.last) == (0, 59)


def test_zero_means_never_cut():
    assert len(cut(5000, SegmentOptions(frames=0))) == 1


@pytest.mark.parametrize("count", [61, 62, 75, 100, 109, 137, 6667])
@pytest.mark.parametrize("options", [SegmentOptions(), SegmentOptions(frames=20, shared=8)])
def test_neighbours_share_frames_and_nothing_is_lost(count, options):
    segments = cut(count, options)
    assert len(segments) > 1
    assert (segments[0].first, segments[-1].last) == (0, count - 1)
    assert [s.number for s in segments] == list(range(1, len(segments) + 1))
    longest = max(options.frames, 3 * options.shared + 1)
    for one, other in pairwise(segments):
        assert one.last - other.first + 1 == options.shared
    for one, third in zip(segments, segments[2:], strict=False):
        assert one.last < third.first, "no frame belongs to three"
    lengths = [s.last - s.first + 1 for s in segments]
    assert max(lengths) <= longest
    assert max(lengths) - min(lengths) <= 1


def test_the_name_is_that_of_a_folder_that_sorts():
    assert [s.name for s in cut(200, SegmentOptions())][:3] == ["001", "002", "003"]
