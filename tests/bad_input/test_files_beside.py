"""POS files, pairs and truths that do not fit are refused by file, line and column."""

import json

import pytest

from tests.bad_input import cylinder
from tests.bad_input.conftest import assert_refused
from tests.command import pipeline

POS_HEAD = "name,x,y,z,pitch,yaw,roll"
PAIRS_HEAD = "block_a,x_a,y_a,z_a,block_b,x_b,y_b,z_b"
PAIR = "Block1,0.039,0.02,-0.039,Block2,0.039,0.02,-0.039"


def pos_rows():
    places = (cylinder.TRAVEL_M * k / (cylinder.FRAMES - 1) for k in range(cylinder.FRAMES))
    return [f"{k},0.0,{y:.4f},-0.3,0,0,0" for k, y in enumerate(places)]


def without(rows, number):
    return rows[:number] + rows[number + 1 :]


POS = {
    "missing image": (POS_HEAD, without(pos_rows(), 3), ["000003.png"]),
    "duplicate name": (POS_HEAD, [*pos_rows()[:4], pos_rows()[3]], ["line 6", "3", "line 5"]),
    "NaN": (POS_HEAD, [*pos_rows()[:4], "4,0,nan,-0.3,0,0,0"], ["line 6", "y", "nan"]),
    "unknown image": (POS_HEAD, [*pos_rows()[:4], "99,0,0.06,-0.3,0,0,0"], ["line 6", "99"]),
    "no column": ("name,x,y,z,pitch,yaw", ["0,0,0,-0.3,0,0"], ["roll"]),
}

PAIRS = {
    "unknown block": (PAIRS_HEAD, PAIR.replace("Block2", "Block9"), ["line 2", "Block9", "Block1, Block2"]),
    "no number": (PAIRS_HEAD, PAIR.replace("0.02", "two", 1), ["line 2", "y_a", "two"]),
    "no column": (PAIRS_HEAD.replace(",z_b", ""), PAIR.rpartition(",")[0], ["z_b"]),
    "no pairs": (PAIRS_HEAD, "", ["no pairs"]),
    "binary": ("\x00\xff", "\xfe", []),
}


@pytest.mark.parametrize(("head", "rows", "named"), POS.values(), ids=POS)
def test_a_pos_file_that_does_not_fit(survey, refused, head, rows, named):
    toml = survey / "survey.toml"
    toml.write_text(toml.read_text().replace('"block2.mp4"', '"block2.mp4"\npos = "pos2.csv"'))
    (survey / "pos2.csv").write_text("\n".join([head, *rows]) + "\n")
    said = refused(before="match")
    assert [word for word in ["pos2.csv", *named] if word not in said] == []


@pytest.mark.parametrize(("head", "row", "named"), PAIRS.values(), ids=PAIRS)
def test_a_pairs_file_that_does_not_fit_is_refused_before_minutes_of_work(
    survey, refused, tmp_path, head, row, named
):
    (tmp_path / "pairs.csv").write_text(f"{head}\n{row}\n", encoding="latin-1")
    said = refused("--pairs", tmp_path / "pairs.csv")
    assert [word for word in ["pairs.csv", *named] if word not in said] == []


def test_a_pairs_file_that_is_not_there(refused, tmp_path):
    assert str(tmp_path / "pairs.csv") in refused("--pairs", tmp_path / "pairs.csv")


TRUTHS = {
    "missing": (None, []),
    "another cable": (
        json.dumps({"format": 1, "stations": [{"name": "Z", "position_m": 0.02, "diameter_mm": 90}]}),
        ["stations A, B"],
    ),
    "no JSON": ('{"format": 1, "stations"', ["JSON"]),
    "no diameter": (
        '{"format": 1, "stations": [{"name": "A", "position_m": 0.02}]}',
        ["stations[0].diameter_mm"],
    ),
}


@pytest.mark.parametrize(("text", "named"), TRUTHS.values(), ids=TRUTHS)
def test_a_truth_that_does_not_fit(refused, tmp_path, text, named):
    if text:
        (tmp_path / "truth.json").write_text(text)
    said = refused("--truth", tmp_path / "truth.json")
    assert [word for word in [str(tmp_path / "truth.json"), *named] if word not in said] == []


STATION = {"name": "A", "position_m": 0.02, "diameter_mm": 110.1, "sigma_mm": 0.1}
TRUTH = {"format": 1, "stations": [STATION]}


class TestEvaluate:
    """A run folder that is broken, or belongs to another cable."""

    @pytest.fixture
    def evaluation(self, tmp_path):
        """Evaluate a run with this report; gives the sentence."""

        def run(report, truth=None):
            (tmp_path / "run").mkdir(exist_ok=True)
            if report is not None:
                text = report if isinstance(report, str) else json.dumps(report)
                (tmp_path / "run" / "report.json").write_text(text)
            (tmp_path / "truth.json").write_text(json.dumps(truth or TRUTH))
            done = pipeline("evaluate", tmp_path / "run", "--truth", tmp_path / "truth.json")
            assert_refused(done)
            return done.stderr

        return run

    def test_no_run_folder(self, tmp_path):
        done = pipeline("evaluate", tmp_path / "none", "--truth", tmp_path / "truth.json")
        assert_refused(done)
        assert str(tmp_path / "none") in done.stderr

    def test_a_run_that_is_not_finished(self, evaluation):
        assert "report.json" in evaluation(None)

    def test_half_a_report(self, evaluation):
        said = evaluation('{"format": 1, "stations": [')
        assert "report.json" in said
        assert "JSON" in said

    def test_a_report_without_stations(self, evaluation):
        assert "stations is missing" in evaluation({"format": 1, "name": "tiny"})

    def test_a_station_of_another_cable(self, evaluation):
        said = evaluation({"format": 1, "name": "tiny", "stations": [{**STATION, "name": "Z"}]})
        assert "station A" in said

    def test_a_station_elsewhere(self, evaluation):
        said = evaluation({"format": 1, "name": "tiny", "stations": [{**STATION, "position_m": 0.05}]})
        assert "station A lies at 0.05 m, in the truth at 0.02 m" in said

    def test_a_run_without_its_sparse_models(self, evaluation):
        pose = {"frame": 0, "cam_from_world": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.3]]}
        truth = {"format": 1, "stations": [STATION], "poses": {"Block1": [pose]}}
        report = {"format": 1, "name": "tiny", "stations": [STATION], "blocks": [{"name": "Block1"}]}
        said = evaluation(report, truth)
        assert "blocks/Block1/sparse" in said

    def test_figures_that_cannot_be_written(self, evaluation, tmp_path):
        (tmp_path / "file").write_text("in the way")
        report = {"format": 1, "name": "tiny", "stations": [STATION]}
        (tmp_path / "run").mkdir()
        (tmp_path / "run" / "report.json").write_text(json.dumps(report))
        (tmp_path / "truth.json").write_text(json.dumps(TRUTH))
        words = ("--truth", tmp_path / "truth.json", "--json", tmp_path / "file" / "evaluation.json")
        done = pipeline("evaluate", tmp_path / "run", *words)
        assert done.code == 2
        assert done.stderr.startswith("error: evaluate: cannot write ")
        assert len(done.stderr.splitlines()) == 1
