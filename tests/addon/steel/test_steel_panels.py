"""What the panels write, in both languages and in the scene's units."""

import json
import math
from types import SimpleNamespace

import blf
import bpy
import pytest

from tests.addon.shown_run import library
from tests.addon.steel.scene import job, named, told
from tests.addon.test_labels import BESIDE_FIELD_PX, FONT_PX
from tests.guards.test_translations import catalogue


class Written:
    """Stands where a panel draws, and keeps what it writes."""

    def __init__(self):
        self.texts, self.icons, self.operators = [], [], []

    def _keep(self, text="", icon="NONE", **_):
        self.texts.append(text)
        self.icons.append(icon)
        return self

    label = _keep

    def operator(self, name, **words):
        self.operators.append(name)
        return self._keep(**words)

    def prop(self, data, key, **words):
        assert key in data.bl_rna.properties
        return self._keep(**words)

    def same(self, *_, **__):
        return self

    def progress(self, text="", **_):
        return self._keep(text=text)

    row = column = box = split = template_list = same


@pytest.fixture(autouse=True)
def whole_sentences(cabletwin, monkeypatch):
    """How a sentence is cut into lines depends on a region, which only a window has."""
    monkeypatch.setattr(library("panels.steel"), "sentence", lambda page, text, icon: page.label(text=text))


def drawn(name, item=None):
    """What a panel, or the row of an item in a list, writes."""
    kind, page = getattr(library("panels.steel"), name), Written()
    if item is not None:
        kind.draw_row(SimpleNamespace(), page, item)
    elif not hasattr(kind, "poll") or kind.poll(bpy.context):
        kind.draw(SimpleNamespace(layout=page), bpy.context)
    icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
    assert set(page.icons) <= set(icons.keys())
    assert all(hasattr(getattr(bpy.ops, w.split(".")[0]), w.split(".")[1]) for w in page.operators)
    return page.texts


def test_rows_say_what_the_tables_of_the_report_say(shown):
    row = drawn("CABLETWIN_UL_steel_columns", shown.columns["A-1"])
    assert row[:4] == ["A-1", "50.0 mm", "north-east", "1/100"]
    row = drawn("CABLETWIN_UL_steel_nodes", shown.nodes["N02"])
    assert row[:3] == ["N02", "10.0 mm", "0.20 mm"]


def test_figures_follow_the_scenes_units(shown):
    bpy.context.scene.unit_settings.system = "IMPERIAL"
    assert drawn("CABLETWIN_UL_steel_columns", shown.columns["A-1"])[1] == "1.969 in"


def test_the_panels_tell_the_verdicts(shown):
    texts = drawn("CABLETWIN_PT_steel")
    assert {"2 of 3", "12.5 mm (N03)", "24.0 mm"} <= set(texts)
    (moved,) = [text for text in drawn("CABLETWIN_PT_steel_gross") if "moved" in text]
    assert moved.startswith("T15 moved by 5")
    for name in ("columns", "nodes", "display"):
        assert drawn(f"CABLETWIN_PT_steel_{name}")


def test_every_stage_has_a_chinese_name(cabletwin):
    for _, label, description in library("properties.steel").STEEL_STAGES:
        assert not catalogue()[label].isascii()
        assert not catalogue()[description].isascii()
    assert set(library("wording")._LABELS) >= {
        name for name, _, _ in library("properties.steel").STEEL_STAGES
    }


def test_a_failure_stands_in_the_panel_of_its_job():
    job().kind, job().failure = "steel", "targets: what is wrong; what to do."
    assert "targets: what is wrong; what to do." in drawn("CABLETWIN_PT_steel")
    job().kind = "reconstruct"
    assert "targets: what is wrong; what to do." not in drawn("CABLETWIN_PT_steel")


def test_an_empty_scene_draws_too():
    assert "Reconstruct" in drawn("CABLETWIN_PT_steel")
    for name in ("columns", "nodes", "gross", "display"):
        assert drawn(f"CABLETWIN_PT_steel_{name}") == []


def test_progress_is_drawn_with_the_steel_stages_names():
    job().running, job().kind, job().stage = True, "steel", "register"
    texts = drawn("CABLETWIN_PT_steel")
    job().running = False
    assert "0 %  Registration" in texts
    assert "Reconstruct" not in texts


@pytest.mark.parametrize("language", ["en", "zh"])
def test_names_beside_fields_fit(cabletwin, language):
    blf.size(0, FONT_PX)
    rna = bpy.context.scene.cabletwin.steel.bl_rna.properties
    for key in ("survey", "run_folder", "truth", "arrow_scale", "error_scale"):
        name = rna[key].name
        text = catalogue()[name] if language == "zh" else name
        assert rna[key].description
        assert blf.dimensions(0, text)[0] <= BESIDE_FIELD_PX, text


def test_no_figure_is_lost_where_nothing_is_known(framed):
    tree = told(framed)
    tree["nodes"][0] |= {"rods_m": [None] * 3, "eccentricity_mm": [None] * 3, "size_mm": None}
    tree["columns"][1] |= {"top_m": [None] * 3, "deviation_mm": None, "ratio": None, "direction": "nowhere"}
    (framed / "report.json").write_text(json.dumps(tree))
    assert bpy.ops.cabletwin.steel_choose(directory=str(framed)) == {"FINISHED"}
    steel = bpy.context.scene.cabletwin.steel
    assert drawn("CABLETWIN_UL_steel_nodes", steel.nodes["N01"])[:2] == ["N01", "–"]
    assert drawn("CABLETWIN_UL_steel_columns", steel.columns["A-2"])[:4] == ["A-2", "–", "nowhere", "–"]
    assert "A-2" not in named("Columns")
    assert all(math.isfinite(v) for item in named("Arrows").values() for v in item.scale)
