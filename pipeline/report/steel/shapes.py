"""Figures in space as triangles: tubes, balls, arrows; many at once.

Takes ends, centres and radii in metres, gives vertices and faces with one colour a vertex.  Leaves out files
(``model``).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.core.vocabulary import Array

HEAD_SHARE, HEAD_WIDTH = 0.3, 2.4
"""An arrow's head: part of its length, and how much wider than the shaft."""


@dataclass(frozen=True, kw_only=True)
class Shape:
    """Triangles.

    Attributes:
        vertices: (n, 3) metres.
        faces: (m, 3) numbers of vertices, counter-clockwise from outside.
        colours: (n, 3) uint8.
    """

    vertices: Array
    faces: NDArray[np.int64]
    colours: NDArray[np.uint8]

    @staticmethod
    def joined(parts: list["Shape"]) -> "Shape":
        """All of them as one."""
        starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
        return Shape(
            vertices=np.concatenate([np.zeros((0, 3)), *(part.vertices for part in parts)]),
            faces=np.concatenate(
                [
                    np.zeros((0, 3), dtype=np.int64),
                    *(part.faces + start for part, start in zip(parts, starts[:-1], strict=True)),
                ]
            ),
            colours=np.concatenate([np.zeros((0, 3), dtype=np.uint8), *(part.colours for part in parts)]),
        )


def tube(
    start: ArrayLike, end: ArrayLike, radii: ArrayLike, colour: tuple[int, int, int], sides: int = 16
) -> Shape:
    """A closed tube of (k,) radii along an axis; a cone where the last radius is 0.

    Args:
        start, end: (3,) ends of the axis.
        radii: one for both ends, or (start, end).
        colour: of all its vertices.
        sides: of its section.
    """
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    axis = (b - a) / max(float(np.linalg.norm(b - a)), 1e-12)
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    turn = 2 * np.pi * np.arange(sides) / sides
    ring = np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v
    first, last = np.broadcast_to(np.asarray(radii, dtype=float), (2,))
    vertices = np.concatenate([a + first * ring, b + last * ring, a[None], b[None]])
    k = np.arange(sides)
    n = (k + 1) % sides
    low, high = np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    faces = np.concatenate(
        [
            np.stack([k, n, n + sides], axis=1),
            np.stack([k, n + sides, k + sides], axis=1),
            np.stack([low, n, k], axis=1),
            np.stack([high, k + sides, n + sides], axis=1),
        ]
    )
    return Shape(vertices=vertices, faces=faces, colours=_paint(colour, len(vertices)))


def ball(centre: ArrayLike, radius: float, colour: tuple[int, int, int], rings: int = 10) -> Shape:
    """A sphere of ``rings`` rows of triangles from pole to pole."""
    sides = 2 * rings
    polar = np.pi * np.arange(1, rings) / rings
    turn = 2 * np.pi * np.arange(sides) / sides
    rows = [
        np.stack([np.sin(p) * np.cos(turn), np.sin(p) * np.sin(turn), np.full(sides, np.cos(p))], axis=1)
        for p in polar
    ]
    vertices = np.concatenate([*rows, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    k = np.arange(sides)
    n = (k + 1) % sides
    faces = []
    for row in range(rings - 2):
        upper, lower = row * sides, (row + 1) * sides
        faces.append(np.stack([upper + k, lower + k, lower + n], axis=1))
        faces.append(np.stack([upper + k, lower + n, upper + n], axis=1))
    top, bottom = len(vertices) - 2, len(vertices) - 1
    last = (rings - 2) * sides
    faces.append(np.stack([np.full(sides, top), k, n], axis=1))
    faces.append(np.stack([np.full(sides, bottom), last + n, last + k], axis=1))
    return Shape(
        vertices=np.asarray(centre, dtype=float) + radius * vertices,
        faces=np.concatenate(faces),
        colours=_paint(colour, len(vertices)),
    )


def arrow(start: ArrayLike, end: ArrayLike, radius: float, colour: tuple[int, int, int]) -> Shape:
    """A shaft of that radius, m, and a head."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    neck = b - HEAD_SHARE * (b - a)
    return Shape.joined(
        [tube(a, neck, radius, colour, 10), tube(neck, b, (HEAD_WIDTH * radius, 0.0), colour, 10)]
    )


def _paint(colour: tuple[int, int, int], count: int) -> NDArray[np.uint8]:
    return np.tile(np.array(colour, dtype=np.uint8), (count, 1))
