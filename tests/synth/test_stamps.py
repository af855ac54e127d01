"""Stamps: what belongs to the pictures, and what only to what is told of them."""

from dataclasses import replace

from synth.spec import Spec
from synth.stamps import claims_stamp, pictures_stamp

PLAIN = Spec()


def test_name_and_claims_are_no_part_of_the_pictures():
    for other in (
        replace(PLAIN, name="other"),
        replace(PLAIN, survey=replace(PLAIN.survey, travel_error_percent=0.1)),
        replace(PLAIN, survey=replace(PLAIN.survey, lost_blocks=("Block3",))),
    ):
        assert pictures_stamp(other) == pictures_stamp(PLAIN)
        assert claims_stamp(other) != claims_stamp(PLAIN)


def test_everything_else_is():
    for other in (
        replace(PLAIN, seed=2),
        replace(PLAIN, cable=replace(PLAIN.cable, bow_mm=1.0)),
        replace(PLAIN, sensor=replace(PLAIN.sensor, samples=9)),
    ):
        assert pictures_stamp(other) != pictures_stamp(PLAIN)
        assert claims_stamp(other) != claims_stamp(PLAIN)
