"""Inclination of columns: both components, direction, ratio, limit, and what hidden parts cost."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.steel.columns import ColumnOptions, measure_columns
from pipeline.steel.survey_records import ColumnSpec
from tests.steel.members_by_hand import members, rod


def column(east_mm=0.0, north_mm=0.0, height=14.0, place=(0.0, 0.0), seen=(0.0, 1.0), rng=None, name="C01"):
    """A column whose top is off its foot; ``seen``: the shares of its height between which it was seen."""
    foot = np.array([*place, 0.0])
    top = np.add(foot, [east_mm / 1000, north_mm / 1000, height])
    first, last = foot + seen[0] * (top - foot), foot + seen[1] * (top - foot)
    return rod(name, first, last, rng, radius=0.15)


def spec(name="8-N", place=(0.1, -0.2), bottom=0.0, top=14.0):
    return ColumnSpec(name=name, place_m=place, bottom_m=bottom, top_m=top)


def test_a_column_of_table_1_reads_as_in_the_paper():
    (found,) = measure_columns(members(columns=[column(17.3, 32.1)]), [spec()], ColumnOptions())
    np.testing.assert_allclose(found.tilt_mm, [17.3, 32.1], atol=1e-6)
    assert found.leans == ("north 32.1 mm", "east 17.3 mm")
    assert found.ratios == pytest.approx([14000 / 17.3, 14000 / 32.1])
    assert found.deviation_mm == pytest.approx(np.hypot(17.3, 32.1))
    assert found.azimuth_deg == pytest.approx(np.degrees(np.arctan2(17.3, 32.1)))
    assert found.over


@pytest.mark.parametrize(
    ("north_deg", "words"),
    [(90.0, ("north 30.0 mm", "east 0.0 mm")), (180.0, ("west 30.0 mm", "north 0.0 mm"))],
)
def test_north_is_where_the_survey_says(north_deg, words):
    # clockwise from +y: with 90 degrees north is +x, with 180 degrees it is -y and east -x
    options = ColumnOptions(north_deg=north_deg)
    (found,) = measure_columns(members(columns=[column(30.0, 0.0)]), [spec()], options)
    assert {w.split()[0] for w in found.leans if float(w.split()[1]) > 0.01} == {words[0].split()[0]}
    assert found.deviation_mm == pytest.approx(30.0, abs=1e-6)


def test_a_fall_towards_the_foot_is_the_same_as_one_towards_the_top():
    upside_down = column(17.3, 32.1)
    turned = rod("C01", upside_down.end, upside_down.start, radius=0.15)
    (found,) = measure_columns(members(columns=[turned]), [spec()], ColumnOptions())
    np.testing.assert_allclose(found.tilt_mm, [17.3, 32.1], atol=1e-6)


def test_sigma_is_honest_and_grows_where_the_foot_is_hidden():
    rng = np.random.default_rng(5)
    for seen, hidden in (((0.0, 1.0), 0.0), ((0.4, 0.9), 7000.0)):
        errors, sigmas = [], []
        for _ in range(200):
            one = column(20.0, -10.0, seen=seen, rng=rng)
            (found,) = measure_columns(members(columns=[one]), [spec()], ColumnOptions())
            errors.append(found.tilt_mm - [20.0, -10.0])
            sigmas.append(np.sqrt(np.diag(found.tilt_covariance)))
            assert found.hidden_mm == pytest.approx(hidden, abs=30)
        assert np.mean(np.abs(errors) <= 2 * np.array(sigmas)) >= 0.92
        assert np.mean(sigmas) == pytest.approx(np.std(errors), rel=0.15)


def test_the_limit_may_come_from_millimetres_or_from_a_code():
    one = members(columns=[column(20.0, 0.0)])
    for limit_mm, ratio, limit in ((35.0, None, 35.0), (35.0, 1000.0, 14.0), (None, 500.0, 28.0)):
        options = ColumnOptions(limit_mm=limit_mm, limit_ratio=ratio)
        (found,) = measure_columns(one, [spec()], options)
        assert found.limit_mm == pytest.approx(limit)
        assert found.over == (limit < 20.0)


def test_without_entries_every_column_is_judged_where_it_was_seen():
    found = measure_columns(
        members(columns=[column(0, 28.0), column(14.0, 0, place=(6, 0), name="C02")]), [], ColumnOptions()
    )
    assert [c.name for c in found] == ["C01", "C02"]
    assert found[0].tilt_mm == pytest.approx([0.0, 28.0], abs=1e-6)
    assert found[0].hidden_mm == pytest.approx(0.0)


def test_entries_with_nothing_there_are_named_all_at_once():
    given = [spec(), spec("9-A", (6.0, 0.0)), spec("9-B", (0.0, 6.0))]
    with pytest.raises(StageError, match=r"column\[9-A\] at \(6, 0\), column\[9-B\] at \(0, 6\)"):
        measure_columns(members(columns=[column()]), given, ColumnOptions())


def test_heights_upside_down_are_refused():
    with pytest.raises(StageError, match=r"column\[8-N\]: top_m 1 is not above bottom_m 5"):
        measure_columns(members(columns=[column()]), [spec(bottom=5.0, top=1.0)], ColumnOptions())
