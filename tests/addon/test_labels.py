"""No name beside a field is cut in a sidebar of the usual width, in English or in Chinese.

PyPI's bpy has no window and no languages, but it has Blender's fonts: the texts are measured, not drawn.
"""

import ast
from pathlib import Path

import blf
import bpy
import pytest

from tests.guards.test_translations import catalogue

ADDON = Path(__file__).parents[2] / "addon"
FONT_PX = 11
BESIDE_FIELD_PX = 89
"""What a panel's column of names holds at scale 1 in a new sidebar; "Nominal diameter" (93) was cut there."""

GROUPS = ("survey", "lens", "pos", "run", "results", "crop", "mosaic", "measure", "export", "synthesise")


def drawn():
    """Keys that the panels draw with the property's own name."""
    for path in sorted((ADDON / "panels").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            is_field = isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "prop"
            if not is_field or any(k.arg == "text" for k in node.keywords):
                continue
            if len(node.args) > 1 and isinstance(node.args[1], ast.Constant):
                yield node.args[1].value


def names(cabletwin):
    """Key to the names of the properties of that key; check boxes have room for theirs behind them."""
    data = bpy.context.scene.cabletwin
    groups = [getattr(data, key).bl_rna for key in GROUPS]
    groups.append(data.survey.bl_rna.properties["blocks"].fixed_type)
    found = {}
    for group in groups:
        for item in group.properties:
            if item.type != "BOOLEAN":
                found.setdefault(item.identifier, set()).add(item.name)
    return found


@pytest.mark.parametrize("language", ["en", "zh"])
def test_names_beside_fields_fit(cabletwin, language):
    blf.size(0, FONT_PX)
    known, asked = names(cabletwin), set(drawn())
    assert len(asked & set(known)) > 30
    said = {name for key in asked & set(known) for name in known[key]}
    texts = {name: catalogue().get(name, name) if language == "zh" else name for name in said}
    cut = {text: width for text in texts.values() if (width := blf.dimensions(0, text)[0]) > BESIDE_FIELD_PX}
    assert cut == {}


def test_a_name_that_was_cut_would_be_found(cabletwin):
    blf.size(0, FONT_PX)
    assert blf.dimensions(0, "Nominal diameter")[0] > BESIDE_FIELD_PX
    assert blf.dimensions(0, "测" * 9)[0] > BESIDE_FIELD_PX
