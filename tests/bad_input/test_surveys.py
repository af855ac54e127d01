"""A survey.toml that cannot be worked with is refused at once, naming the file or the key's full name."""

import pytest

KEY = [
    # what is written, instead of what, the words that the sentence must hold
    ("travel_m = 0.0", "travel_m = 0.06", ["cable.travel_m", "zero"]),
    ("travel_m = -0.06", "travel_m = 0.06", ["cable.travel_m", "-0.06"]),
    ("travel_m = nan", "travel_m = 0.06", ["cable.travel_m", "nan"]),
    ("travel_m = inf", "travel_m = 0.06", ["cable.travel_m", "inf"]),
    ('travel_m = "6 cm"', "travel_m = 0.06", ["cable.travel_m", '"6 cm"', "number"]),
    ("", "travel_m = 0.06", ["cable.travel_m", "missing"]),
    ("travel_m = 0.06\ncolour = 1", "travel_m = 0.06", ["cable.colour", "unknown"]),
    ("travel_m = 0.06\ntravle_m = 1", "travel_m = 0.06", ["cable.travle_m", "perhaps cable.travel_m"]),
    ("travel_m = 0.06\ntravel_m = 0.07", "travel_m = 0.06", ["survey.toml", "no TOML"]),
    ("diameter_mm = 700", "diameter_mm = 110", ["robot.standoff_m", "inside"]),
    ("position_m = 0.4", "position_m = 0.04", ["cable.station[B].position_m", "0.4"]),
    ("position_m = -0.04", "position_m = 0.04", ["cable.station[B].position_m"]),
    ('name = "A"', 'name = "B"', ["cable.station.name", '"a"']),
    ("standoff_m = 0", "standoff_m = 0.3", ["robot.standoff_m"]),
    ("synchronised = 1", "synchronised = true", ["robot.synchronised", "true or false"]),
    ('name = "Block1"', 'name = "Block2"', ["block.name", '"block1"']),
    ('name = "../Block2"', 'name = "Block2"', ["block.name", "../Block2"]),
    ("angle_deg = 360.0", "angle_deg = 90.0", ["block[Block1].angle_deg", "block[Block2].angle_deg"]),
    ('source = "block7.mp4"', 'source = "block2.mp4"', ["block[Block2].source", "block7.mp4"]),
    ('source = "frames/*.png"', 'source = "block2.mp4"', ["block[Block2].source", "frames/*.png"]),
    ('source = "block2.mp4"\npos = "p.csv"', 'source = "block2.mp4"', ["block[Block2].pos", "p.csv"]),
    ("format = 2", "format = 1", ["format is 2", "format = 1"]),
    ("this is no TOML", "format = 1", ["survey.toml", "no TOML", "line 1"]),
]

LENS = [
    # instead of Block2's focal length
    ("", ["block[Block2].lens", "focal"]),
    ("focal_px = -120.0", ["block[Block2].lens.focal_px", "-120"]),
    ("focal_px = nan", ["block[Block2].lens.focal_px", "nan"]),
    ("focal_px = 120.0\nfocal_mm = 4.0", ["block[Block2].lens", "both"]),
    ("focal_px = 120.0\nlambda = -0.02", ["unknown key block[Block2].lens.lambda", "perhaps"]),
    ('focal_px = 120.0\nlambda_radius = "diagonal"', ["block[Block2].lens.lambda_radius", "half-diagonal"]),
]

OPTION = [
    ("[options.measure]\nslize_mm = 8", ["options.measure.slize_mm", "options.measure.slice_mm"]),
    ("[options.measure]\nslice_mm = 0", ["options.measure.slice_mm", "above 0"]),
    ("[options.mesure]\nslice_mm = 8", ["options.mesure", "options.measure"]),
]


def write(survey, new, old, last=True):
    text = (survey / "survey.toml").read_text()
    assert old in text
    before, _, after = text.rpartition(old) if last else text.partition(old)
    (survey / "survey.toml").write_text(before + new + after)


@pytest.mark.parametrize(("new", "old", "named"), KEY, ids=[case[0] or "missing" for case in KEY])
def test_a_key_that_does_not_fit(survey, refused, new, old, named):
    write(survey, new, old, last=new != "format = 2")
    said = refused()
    assert [word for word in named if word.lower() not in said.lower()] == []


@pytest.mark.parametrize(("new", "named"), LENS, ids=[case[0] or "missing" for case in LENS])
def test_a_lens_that_does_not_fit(survey, refused, new, named):
    write(survey, new, "focal_px = 120.0")
    said = refused()
    assert [word for word in named if word not in said] == []


@pytest.mark.parametrize(("table", "named"), OPTION, ids=[case[0] for case in OPTION])
def test_an_option_that_does_not_fit(survey, refused, table, named):
    with (survey / "survey.toml").open("a") as file:
        file.write(f"\n{table}\n")
    said = refused()
    assert [word for word in named if word not in said] == []


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", None, "folder"], ids=["binary", "missing", "a folder"])
def test_a_survey_that_is_no_text(survey, refused, content):
    toml = survey / "survey.toml"
    toml.unlink()
    if content == "folder":
        toml.mkdir()
    elif content:
        toml.write_bytes(content)
    assert str(toml) in refused()
