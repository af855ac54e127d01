"""One survey through the stages: asks for each stage's products, block by block where it works so.

What depends on what is in :mod:`pipeline.cable.block_stages` and :mod:`pipeline.cable.ring_stages`.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pipeline.cable.records import BlockRun, CableRun
from pipeline.cable.ring_stages import RingStages
from pipeline.cable.survey import Block
from pipeline.core.events import Event
from pipeline.core.runfolder import Product

type _PerBlock = Callable[[int, Block], Product[Any]]


class Chain(RingStages):
    """Runs stages by name and gathers what they found."""

    def run(self, name: str, pairs: Path | None) -> None:
        """Make one stage's products, of every block where it works block by block."""
        if name == "frames":
            self.made[name] = self._frames()
        elif name == "mosaic":
            self.made[name] = [self._mosaic(pairs)]
        elif name in ("closing", "joint"):
            self.made[name] = [getattr(self, f"_{name}")()] if self._together() else []
        elif name in ("ring", "measure"):
            self.made[name] = [getattr(self, f"_{name}")()]
        else:
            stage: _PerBlock = getattr(self, f"_{name}")
            self.made[name] = [stage(n, b) for n, b in enumerate(self._survey.blocks)]
        self._emit(Event(stage=name, done=1, total=1))

    def result(self) -> CableRun:
        """Everything found, from the finished products."""
        return CableRun(
            survey=self._survey,
            options=self._options,
            blocks=tuple(
                BlockRun(
                    block=block,
                    frames=self._value("frames", n),
                    lens=self._value("lens", n),
                    pos=self._value("pos", n),
                    tie_points=self._value("match", n),
                    orientation=self._oriented(n).value,
                    dense=self._value("dense", n),
                    surface=self._value("surface", n),
                    picture=self._value("texture", n),
                    crop=self._value("crop", n),
                )
                for n, block in enumerate(self._survey.blocks)
            ),
            together=self._value("joint") if self.made["joint"] else None,
            mosaic=self._value("mosaic"),
            ring=self._value("ring"),
            measurement=self._value("measure"),
        )
