"""A lens from pictures of a chessboard: their folder typed in, *Calibrate*; Ctrl-Z takes it back."""

import math
from pathlib import Path

from driver import Steps
from sidebar import Person
from state import job, state, survey

FOCAL_PX, LAMBDA = 520.0, -0.08
"""The lens that the pictures were drawn through (tests/cable/test_chessboard.py)."""


def read_a_chessboard(person: Person, folder: Path) -> Steps:
    """In the closed panel below *Estimate*."""
    yield from person.panel("lens")
    yield from person.open_below("cabletwin.lens_estimate", columns=(0.3,))
    yield from person.write("lens.board_folder", f"{folder}/", columns=(0.6,))
    assert Path(state().lens.board_folder) == folder, state().lens.board_folder
    before = survey().block().focal_px
    yield from person.press("cabletwin.lens_chessboard", columns=(0.3,))
    yield from person.wait_for(lambda: job().running, 10)
    yield from person.wait_for(lambda: not job().running, 120)
    assert not job().failure, job().failure
    block = survey().block()
    assert (block.lambda_from, block.calibrated) == ("BOARD", True)
    assert math.isclose(block.focal_px, FOCAL_PX, rel_tol=0.005), block.focal_px
    assert math.isclose(block.division_lambda, LAMBDA, abs_tol=0.002), block.division_lambda
    yield from person.over(y=0.9)
    yield 1.0
    yield from person.shot("18-chessboard")
    yield from person.until(
        lambda: person.key("Z", ctrl=True), lambda: math.isclose(survey().block().focal_px, before)
    )
    yield from person.open_below("cabletwin.lens_estimate", columns=(0.3,))
    yield from person.panel("lens")
