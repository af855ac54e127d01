"""What is committed names no machine, and pages that exist in two languages keep step."""

import re
from itertools import groupby
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("addon", "blend_assets", "docs", "pipeline", "specs", "synth", "tests", "tools", ".ci")
TEXTS = {".py", ".toml", ".md", ".sh", ".js", ".css", ".html", ".osl", ".csv", ".json", ".txt", ".lock", ""}

# the folders of one person's machine, put together here so that this file does not name them itself
PLACES = "|".join(("home", "root", "work", "Users", "tmp", "mnt", "var"))
ABSOLUTE = re.compile(
    rf"""(?<![\w.~/{{}}$*)\]-])(/(?:{PLACES})/|[A-Za-z]:[\\/](?:{PLACES}|Windows|Program))"""
)
REGISTRY = re.compile(r"(--(extra-)?index-url|--find-links|--trusted-host|@ (file|https?)://)")
HEADING = re.compile(r"^(#+) .*$")


def texts():
    folders = [path for room in ROOMS for path in (ROOT / room).rglob("*") if "__pycache__" not in path.parts]
    files = [path for path in (*folders, *ROOT.iterdir()) if path.is_file() and path.suffix in TEXTS]
    return [path for path in files if path != Path(__file__) and path.name not in ("LICENSE", ".git")]


def lines_with(pattern):
    return [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:100]}"
        for path in texts()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if pattern.search(line)
    ]


def test_the_pattern_knows_an_absolute_path():
    assert ABSOLUTE.search('open("/' + 'home/me/video.mp4")')
    assert ABSOLUTE.search("C:" + "\\Users\\me")
    assert not ABSOLUTE.search('"$HOME/tmp/x" https://example.org/home/x out/tmp/y')


def test_no_absolute_path_is_committed():
    assert len(texts()) > 30
    assert lines_with(ABSOLUTE) == []


def test_no_registry_is_named():
    assert lines_with(REGISTRY) == []


def test_every_pinned_package_has_its_hashes():
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    entries = [e for e in re.split(r"\n(?=[A-Za-z0-9])", lock) if re.match(r"[A-Za-z0-9]", e)]
    assert len(entries) > 10
    assert [e.split()[0] for e in entries if "==" not in e.split()[0] or "--hash=sha256:" not in e] == []


def skeleton(page):
    """The levels of the headings and the fences of code in their order: what both languages must share."""
    found, fenced = [], False
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("```"):
            fenced = not fenced
            found.append("code" if fenced else "end")
        elif not fenced and (heading := HEADING.match(line)):
            found.append(heading[1])
    return found


def pages_in_two_languages():
    pages = [*ROOT.glob("*.zh.md"), *(ROOT / "docs").rglob("*.zh.md")]
    return [(page.with_name(page.name.removesuffix(".zh.md") + ".md"), page) for page in sorted(pages)]


@pytest.mark.parametrize(("english", "chinese"), pages_in_two_languages(), ids=lambda page: page.name)
def test_both_languages_have_the_same_sections(english, chinese):
    assert english.is_file(), f"{chinese.name} has no English page"
    assert skeleton(english) == skeleton(chinese)


@pytest.mark.parametrize(("english", "chinese"), pages_in_two_languages(), ids=lambda page: page.name)
def test_both_languages_show_the_same_commands(english, chinese):
    def commands(page):
        lines = page.read_text(encoding="utf-8").splitlines()
        parts = [
            list(part) for fence, part in groupby(lines, lambda line: line.startswith("```")) if not fence
        ]
        return [re.sub(r"\s*#.*", "", line) for part in parts[1::2] for line in part]

    assert commands(english) == commands(chinese)
