"""Every word that the extension shows is there in Simplified Chinese too, and no translation is left over."""

import ast
from pathlib import Path

import pytest

ADDON = Path(__file__).parents[2] / "addon"
SHOWN_KEYWORDS = {"name", "description", "text", "heading", "message"}
SHOWN_ATTRIBUTES = {"bl_label", "bl_description"}
TRANSLATORS = {"n_", "translated", "pgettext_iface", "pgettext_rpt", "pgettext_tip", "poll_message_set"}
PROPERTIES = {
    "Bool",
    "BoolVector",
    "Int",
    "IntVector",
    "Float",
    "FloatVector",
    "String",
    "Enum",
    "Pointer",
    "Collection",
}


def sources():
    return [p for p in sorted(ADDON.rglob("*.py")) if "translations" not in p.parts]


def texts(node):
    """String constants in an expression, both sides of a conditional included."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.IfExp):
        yield from texts(node.body)
        yield from texts(node.orelse)


def items(node):
    """Names and descriptions of an enumeration: tuples of identifier, name, description and more."""
    for item in node.elts if isinstance(node, ast.Tuple | ast.List) else ():
        if isinstance(item, ast.Tuple) and len(item.elts) >= 3:
            for element in item.elts[1:3]:
                yield from texts(element)


def called(node):
    function = node.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def untranslated_call(node):
    return any(
        k.arg == "translate" and isinstance(k.value, ast.Constant) and not k.value.value
        for k in node.keywords
    )


def shown_in_call(node):
    name = called(node)
    if name in TRANSLATORS:
        yield from texts(node.args[0])
    is_property = name.removesuffix("Property") in PROPERTIES and name.endswith("Property")
    draws = isinstance(node.func, ast.Attribute) and name in {
        *(
            "label",
            "operator",
            "prop",
            "row",
            "column",
            "progress",
            "menu",
            "popover",
            "prop_search",
            "prop_menu_enum",
        ),
        *("operator_menu_enum", "prop_enum"),
    }
    for keyword in node.keywords if not untranslated_call(node) else ():
        if (is_property or draws) and keyword.arg in SHOWN_KEYWORDS:
            yield from texts(keyword.value)
        if is_property and keyword.arg == "items":
            yield from items(keyword.value)
    if name == "report":
        yield from texts(node.args[1])


def shown(path):
    """Every text that this file shows."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            yield from shown_in_call(node)
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            if node.targets[0].id in SHOWN_ATTRIBUTES:
                yield from texts(node.value)
            elif node.targets[0].id.isupper():
                yield from items(node.value)


def areas():
    """Area to its English and Chinese texts."""
    found = {}
    for path in sorted((ADDON / "translations").glob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "ZH":
                found[path.stem] = ast.literal_eval(node.value)
    return found


def catalogue():
    return {english: chinese for area in areas().values() for english, chinese in area.items()}


def needs_words(text):
    return any(c.isalpha() for c in text) and len(text) > 1


@pytest.mark.parametrize("path", sources(), ids=lambda p: p.relative_to(ADDON).as_posix())
def test_every_text_is_there_in_chinese(path):
    known = catalogue()
    assert sorted({text for text in shown(path) if needs_words(text)} - set(known)) == []


def test_no_translation_is_left_over():
    used = {text for path in sources() for text in shown(path)}
    assert sorted(set(catalogue()) - used) == []


def test_a_text_is_translated_in_one_place():
    everywhere = [english for area in areas().values() for english in area]
    assert sorted({e for e in everywhere if everywhere.count(e) > 1}) == []


def test_placeholders_are_the_same_in_both_languages():
    assert [e for e, c in catalogue().items() if e.count("{") != c.count("{")] == []


def test_every_area_is_registered():
    text = (ADDON / "translations" / "__init__.py").read_text(encoding="utf-8")
    areas = {p.stem for p in (ADDON / "translations").glob("*.py")} - {"__init__"}
    assert {a for a in areas if f"{a}," in text or f" {a}\n" in text} == areas
