"""Progress is a line of JSON for programs, a bar for people at a terminal, and one line a stage in a log."""

import io
import json

import pytest

from pipeline import console
from pipeline.cable.run import STAGES
from pipeline.console import emitter
from pipeline.core.events import Event
from pipeline.progress import SHARES, Progress

BLOCKS = ("Block1", "Block2")


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        return True


class Clock:
    """Time that passes when it is told to."""

    def __init__(self):
        self.now = 100.0

    def monotonic(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(console.time, "monotonic", clock.monotonic)
    return clock


def bar(monkeypatch, stream):
    monkeypatch.setattr(console.sys, "stderr", stream)
    return emitter("bar", BLOCKS)


def run_two_stages(emit, clock):
    """A stage block by block, then one for all blocks together; each ends with an event of its own."""
    for block in BLOCKS:
        for done in range(4):
            emit(Event(stage="match", block=block, done=done, total=4))
            clock.now += 1.0
    emit(Event(stage="match", done=1, total=1))
    for done in range(3):
        emit(Event(stage="mosaic", done=done, total=3))
        clock.now += 0.5
    emit(Event(stage="mosaic", done=1, total=1))


def test_every_event_is_one_line_of_json(capsys):
    emit = emitter("json", BLOCKS)
    events = [
        Event(stage="match", block="Block1", done=3, total=24),
        Event(stage="run", done=0, total=1, message="Brücke\nfertig"),
        Event(stage="lens", done=1, total=2, segment=3, segments=9),
    ]
    for event in events:
        emit(event)
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert [json.loads(line) for line in lines] == [
        {"stage": "match", "done": 3, "total": 24, "block": "Block1", "message": ""},
        {"stage": "run", "done": 0, "total": 1, "block": "", "message": "Brücke\nfertig"},
        {"stage": "lens", "done": 1, "total": 2, "block": "", "message": "", "segment": 3, "segments": 9},
    ]
    assert "Brücke" in captured.err


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_what_a_finished_stage_has_to_say_is_a_line_of_its_own(clock, monkeypatch, stream):
    shown = stream()
    emit = bar(monkeypatch, shown)
    emit(Event(stage="joint", done=0, total=2, message="half way"))
    emit(Event(stage="joint", done=1, total=1, message="Block2 looks odd."))
    emit(Event(stage="dense", done=1, total=1))
    lines = shown.getvalue().split("\n")
    assert lines[-3] == "note: Block2 looks odd."
    assert len([line for line in lines if "note" in line]) == 1


def test_nothing_is_told_where_nothing_is_wanted(capsys):
    emitter("none", BLOCKS)(Event(stage="match", done=0, total=1))
    captured = capsys.readouterr()
    assert captured.out == captured.err == ""


def test_a_log_gets_one_line_a_finished_stage_and_no_bar(monkeypatch, clock):
    stream = io.StringIO()
    run_two_stages(bar(monkeypatch, stream), clock)
    lines = stream.getvalue().splitlines()
    assert [line.split() for line in lines] == [["match", "8.0", "s"], ["mosaic", "1.5", "s"]]
    assert "\r" not in stream.getvalue()
    assert "\x1b" not in stream.getvalue()


def test_a_terminal_sees_a_bar_that_grows_and_ends_full(monkeypatch, clock):
    stream = Terminal()
    run_two_stages(bar(monkeypatch, stream), clock)
    drawn = stream.getvalue().split("\r\x1b[K")[1:]
    match = [text for text in drawn if text.startswith("match")]
    filled = [text.count("█") for text in match]
    assert filled == sorted(filled)
    assert len(filled) >= 7
    assert filled[-1] == console.BAR
    assert all(text.count("█") + text.count("░") == console.BAR for text in drawn)
    assert [text for text in drawn if text.endswith("\n")] == [match[-1], drawn[-1]]


def test_the_second_block_begins_where_the_first_ended(monkeypatch, clock):
    stream = Terminal()
    emit = bar(monkeypatch, stream)
    clock.now += 1
    emit(Event(stage="match", block="Block2", done=0, total=10))
    assert stream.getvalue().count("█") == console.BAR // 2
    assert "Block2" in stream.getvalue()


def test_the_bar_is_not_redrawn_faster_than_an_eye_can_see(monkeypatch, clock):
    stream = Terminal()
    emit = bar(monkeypatch, stream)
    clock.now += 1
    for done in range(1000):
        emit(Event(stage="match", block="Block1", done=done, total=1000))
        clock.now += 0.01
    assert stream.getvalue().count("\r") == pytest.approx(10 / console.REDRAW_S, rel=0.12)


def test_the_time_left_is_told_once_enough_has_passed(monkeypatch, clock):
    stream = Terminal()
    emit = bar(monkeypatch, stream)
    emit(Event(stage="frames", done=0, total=10))
    clock.now += 1
    emit(Event(stage="frames", done=1, total=10))
    assert "left" not in stream.getvalue()
    clock.now += SHARES["frames"] / 2 - 1  # at a pace of one share a second
    emit(Event(stage="frames", done=5, total=10))
    left_s = sum(SHARES.values()) - SHARES["frames"] / 2
    assert f"about {int(left_s // 60)}:{int(left_s % 60):02d} left" in stream.getvalue()


def test_what_a_resumed_run_found_finished_does_not_count_for_the_time_left(monkeypatch, clock):
    """All before dense was on disk: those stages tell their end at once and nothing else."""
    stream = Terminal()
    emit = bar(monkeypatch, stream)
    names = list(SHARES)
    for stage in names[: names.index("dense")]:
        clock.now += 0.05
        emit(Event(stage=stage, done=1, total=1))
    emit(Event(stage="dense", done=0, total=10))
    clock.now += SHARES["dense"]
    emit(Event(stage="dense", done=5, total=10))  # half of it: two seconds a share
    after = sum(SHARES[n] for n in names[names.index("dense") + 1 :]) + SHARES["dense"] / 2
    minutes, seconds = stream.getvalue().rsplit("about ", 1)[1].split(" left")[0].split(":")
    assert int(minutes) * 60 + int(seconds) == pytest.approx(2 * after, rel=0.1)


def test_every_stage_has_its_share_of_the_time_in_the_order_of_the_run():
    assert list(SHARES) == [*STAGES, "report"]


def run_in_segments(emit, clock, segments, seconds=1.0):
    """A survey cut into segments: frames once, all segments up to the joint stage, then each to its end."""
    stages = tuple(SHARES)
    early, late = stages[1 : stages.index("undistort")], stages[stages.index("undistort") :]
    emit(Event(stage="frames", done=1, total=1))
    for pass_of in (early, late):
        for number in range(1, segments + 1):
            told = {"segment": number, "segments": segments}
            if pass_of is late:
                for stage in early:
                    emit(Event(stage=stage, done=1, total=1, **told))
            for stage in pass_of:
                emit(Event(stage=stage, done=0, total=2, **told))
                clock.now += seconds * SHARES[stage]
                emit(Event(stage=stage, done=1, total=1, **told))
    emit(Event(stage="report", done=0, total=1))


def test_a_survey_in_segments_moves_forward_all_the_time_and_foretells_its_end(clock):
    progress, seen, began = Progress(BLOCKS), [], clock.now

    def take(event):
        progress.take(event)
        seen.append((clock.now - began, progress.fraction, progress.seconds_left))

    run_in_segments(take, clock, 10)
    fractions = [fraction for _, fraction, _ in seen]
    assert fractions == sorted(fractions)
    whole = seen[-1][0]
    for passed, fraction, left in seen:
        if 0.2 < passed / whole < 0.98 and left is not None:
            assert fraction == pytest.approx(passed / whole, abs=0.03)
            assert passed + left == pytest.approx(whole, rel=0.1)
    assert fractions[-1] > 0.98


def test_the_bar_counts_segments_and_times_each_stage_of_each(monkeypatch, clock):
    stream = io.StringIO()
    run_in_segments(bar(monkeypatch, stream), clock, 3, seconds=0.1)
    lines = stream.getvalue().splitlines()
    assert "match      2/3    1.6 s" in lines
    assert "dense      3/3    1.5 s" in lines


def test_a_resumed_run_foretells_nothing_before_it_makes_something(clock):
    progress = Progress(BLOCKS)
    for stage in list(SHARES)[:11]:
        clock.now += 0.3
        progress.take(Event(stage=stage, done=1, total=1))
    assert progress.seconds_left is None
    progress.take(Event(stage="crop", done=0, total=2))
    clock.now += 2.0
    progress.take(Event(stage="mosaic", done=1, total=2))
    assert progress.seconds_left is not None
