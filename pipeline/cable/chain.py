"""One survey through the stages: asks for each stage's products, block by block where it works so.

What depends on what is in :mod:`pipeline.cable.block_stages` and :mod:`pipeline.cable.ring_stages`.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from pipeline.cable.cautions import numbering_cautions, rig_cautions
from pipeline.cable.records import BlockRun, CableRun
from pipeline.cable.ring_stages import RingStages
from pipeline.cable.survey import Block
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.runfolder import Product

type _PerBlock = Callable[[int, Block, Emit], Product[Any]]


class Chain(RingStages):
    """Runs stages by name and gathers what they found."""

    def run(self, name: str, pairs: Path | None) -> None:
        """Make one stage's products, of every block where it works block by block."""
        if name == "frames":
            self.made[name] = self._frames()
        elif name == "mosaic":
            self.made[name] = [self._mosaic(pairs)]
        elif name in ("closing", "joint"):
            self.made[name] = [getattr(self, f"_{name}")()] if self.together else []
        elif name in ("ring", "measure"):
            self.made[name] = [getattr(self, f"_{name}")()]
        else:
            self.made[name] = self._block_by_block(name)
        self._emit(Event(stage=name, done=1, total=1, message=" ".join(self._cautions(name))))

    def _block_by_block(self, name: str) -> list[Product[Any]]:
        """A stage's products of all blocks, which know nothing of each other: side by side."""
        stage: _PerBlock = getattr(self, f"_{name}")
        blocks = self._survey.blocks
        jobs = [partial(stage, n, block) for n, block in enumerate(blocks)]
        with self._folder.side_by_side(name):
            return side_by_side(jobs, self._emit, workers_for(len(blocks)))

    def require(self, name: str) -> None:
        """Refuse where a stage that was asked for by name has no part in this survey's run.

        Raises:
            StageError: the blocks are adjusted each for itself.
        """
        if not self.made[name]:
            raise StageError(
                "run",
                f"the stage {name} has no part in this run, whose blocks are adjusted each for itself",
                "leave --only out, or see that there are two cameras or more of one clock, no pos and "
                "joint.together = true",
            )

    def _cautions(self, name: str) -> tuple[str, ...]:
        """What a finished stage gives cause to say."""
        if name == "frames":
            return numbering_cautions(self._survey.blocks)
        if name == "joint" and self.made[name]:
            return rig_cautions([p.value for p in self.made["adjust"]], self._value(name).blocks)
        return ()

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
            cautions=tuple(said for stage in self.made for said in self._cautions(stage)),
        )
