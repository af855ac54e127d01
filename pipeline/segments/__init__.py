"""Surveys too long for one piece: cut, worked off segment by segment, tied to each other, joined.

The map, in the order of the data:

- ``plan``: how many frames make a segment, and where the survey is cut;
- ``leftovers``: what is cleared away of a survey that was cut otherwise before;
- ``part``: one segment through the stages, first at nominal and then at true scale (``scaling``);
- ``traverse``: the segments' scales and places, adjusted between the ends of the whole travel;
- ``bends``: how they lean out of each other, and the axis of the whole as one curve;
- ``told``: what a finished segment tells of the whole;
- ``straightened``: a segment's surface about its axis, for the joined one is straight;
- ``joined``: all of them as one product, from the joined surface (``whole_ring``) and report (``whole``);
- ``survey_run``: the order of all this, and what happens to a segment in which nothing can be found.
"""
