"""How the stages that join the blocks hang together: what each is made from, so when it is made again.

Builds on the block by block stages; holds no algorithm and no order.
"""

from dataclasses import replace
from pathlib import Path

from pipeline.cable.block_stages import BlockStages
from pipeline.cable.closing import ClosingBlock, SharedMarks
from pipeline.cable.closing_lenses import close_ring, lens_known
from pipeline.cable.joint import JointBlock, JointOptions, RingOrientation, adjust_ring
from pipeline.cable.measure import Measurement, measure_ring
from pipeline.cable.mosaic import Mosaic, MosaicBlock, PointPairs, mosaic_blocks
from pipeline.cable.pairs import (
    adjustment_stamp,
    check_adjustments,
    check_pairs,
    group_pairs,
    read_pairs,
)
from pipeline.cable.pos import RobotPriors, robot_priors, travel_share_sigma
from pipeline.cable.ring import Ring, build_ring
from pipeline.cable.uncertainty import Uncertainty
from pipeline.core.runfolder import Product
from pipeline.core.store import stamp_file
from pipeline.core.vocabulary import FrameSequence, Lens, TravelDirection


class RingStages(BlockStages):
    """The products of all blocks together: ``made["mosaic"][0]`` is the only one."""

    _joint_product = "joint"

    @property
    def together(self) -> bool:
        """Whether the cameras are adjusted as one rig: one clock, and no POS that says otherwise."""
        survey = self._survey
        return (
            self._options.joint.together
            and survey.robot.synchronised
            and len(survey.blocks) > 1
            and all(b.pos is None for b in survey.blocks)
        )

    def _closing(self) -> Product[SharedMarks]:
        def make() -> SharedMarks:
            blocks = tuple(
                ClosingBlock(
                    frames=self._value("frames", n),
                    orientation=self._value("adjust", n),
                    azimuth_deg=block.angle_deg,
                )
                for n, block in enumerate(self._survey.blocks)
            )
            return close_ring(
                blocks, self._to_adjust(), robot, self._options.closing, self._options.joint, self._emit
            )

        robot = self._robot()
        needs = [*self._all("frames", "adjust"), self._mounted(), self._options.closing]
        if not all(lens_known(p.value.lens) for p in self.made["adjust"]):
            plain = JointOptions()
            needs += [
                robot,
                replace(  # the ring that tells the lenses knows no surface
                    self._options.joint,
                    surface_sigma_mm=plain.surface_sigma_mm,
                    surface_patch_mm=plain.surface_patch_mm,
                    surface_used=plain.surface_used,
                ),
            ]
        return self._folder.product("closing", SharedMarks, make, *needs)

    def _joint(self) -> Product[RingOrientation]:
        robot = self._robot()

        def make() -> RingOrientation:
            marks = self._value("closing")
            return adjust_ring(self._to_adjust(), marks, robot, self._options.joint, self._emit, stations)

        # without a surface prior nothing is looked at station by station
        stations = tuple((s.name, s.position_m) for s in self._survey.cable.stations)
        stations = stations if self._options.joint.surface_sigma_mm > 0 else ()
        needs = [*self._all("adjust", "closing"), robot, self._mounted(), self._options.joint, stations]
        return self._folder.product(self._joint_product, RingOrientation, make, *needs)

    def _to_adjust(self) -> tuple[JointBlock, ...]:
        return tuple(
            JointBlock(
                name=block.name,
                azimuth_deg=block.angle_deg,
                travel_in_image=block.travel_in_image,
                orientation=self._value("adjust", n),
            )
            for n, block in enumerate(self._survey.blocks)
        )

    def _robot(self) -> RobotPriors:
        survey = self._survey
        frames: FrameSequence = self._value("frames", 0)
        return robot_priors(survey.robot, survey.cable, frames, self._options.pos)

    def _mounted(self) -> list[tuple[float, TravelDirection]]:
        return [(b.angle_deg, b.travel_in_image) for b in self._survey.blocks]

    def _joined(self) -> tuple[MosaicBlock, ...]:
        return tuple(
            MosaicBlock(
                name=block.name,
                surface=self._value("surface", n),
                keep=self._value("crop", n).keep,
                picture=self._value("texture", n),
                datum_origin=self._oriented(n).value.datum_origin,
                datum_information=self._oriented(n).value.datum_information,
            )
            for n, block in enumerate(self._survey.blocks)
        )

    def _mosaic(self, pairs: Path | None) -> Product[Mosaic]:
        names = tuple(b.name for b in self._survey.blocks)

        def make() -> Mosaic:
            given: tuple[PointPairs, ...] | None = None
            if pairs:
                picked = read_pairs(pairs, names)
                stamps = [adjustment_stamp(self._oriented(n).value) for n in range(len(names))]
                check_adjustments(pairs, picked, names, stamps)
                given = group_pairs(picked)
                check_pairs(pairs, given, self._joined())
            settled = self._value("joint").covariance if self.made["joint"] else None
            return mosaic_blocks(self._joined(), given, settled, self._options.mosaic, self._emit)

        needs = [
            *self._all("surface", "crop", "texture", "adjust", "joint"),
            stamp_file(pairs) if pairs else None,
            self._options.mosaic,
        ]
        return self._folder.product("mosaic", Mosaic, make, *needs)

    def _ring(self) -> Product[Ring]:
        return self._folder.product(
            "ring",
            Ring,
            lambda: build_ring(
                self._joined(),
                tuple(p.value for p in self.made["crop"]),
                self._value("mosaic"),
                self._survey.cable.travel_m,
                self._options.ring,
                self._emit,
            ),
            *self._all("surface", "crop", "texture", "mosaic"),
            self._survey.cable.travel_m,
            self._options.ring,
        )

    def _measure(self) -> Product[Measurement]:
        survey = self._survey
        stations = tuple((s.name, s.position_m) for s in survey.cable.stations)
        uncertainty = self._uncertainty()
        window_mm = max(p.value.window_mm for p in self.made["dense"])
        return self._folder.product(
            "measure",
            Measurement,
            lambda: measure_ring(
                self._joined(),
                tuple(p.value for p in self.made["crop"]),
                self._value("mosaic"),
                self._value("ring"),
                uncertainty,
                stations,
                survey.cable.travel_m,
                window_mm,
                self._options.measure,
                self._options.relief,
                self._emit,
            ),
            *self._all("surface", "crop", "mosaic", "ring"),
            uncertainty,
            stations,
            survey.cable.travel_m,
            window_mm,
            self._options.measure,
            self._options.relief,
        )

    def _uncertainty(self) -> Uncertainty:
        lenses: list[Lens] = [self._oriented(n).value.lens for n in range(len(self._survey.blocks))]
        ring: RingOrientation | None = self._value("joint") if self.made["joint"] else None
        return Uncertainty(
            noise_mm=tuple(p.value.noise_mm for p in self.made["dense"]),
            window_mm=tuple(p.value.window_mm for p in self.made["dense"]),
            focal_shares=tuple(lens.focal_sigma_px / lens.focal_px for lens in lenses),
            travel_share=travel_share_sigma(self._survey.cable),
            together=None if ring is None else ring.strips,
        )
