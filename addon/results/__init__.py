"""What puts the pipeline's products into the scene; the only rooms that build datablocks.

``show`` brings a run in, each kind of thing in a collection of its own (``collections``): ``clouds``,
``cameras``, ``meshes``, ``stations``; ``sketch`` draws the set-up of a survey before there is any result.
"""
