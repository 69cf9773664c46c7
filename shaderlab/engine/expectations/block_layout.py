"""block_layout: where the members of a uniform block lie, for the lab and for the driver."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass

from shaderlab.errors import CaseError, nearest
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import BlockReading, Frame
from shaderlab.model.records import Row

from .attribute_layout import memory_table
from .base import Asked, OfDraw


@dataclass(frozen=True)
class BlockLayout(OfDraw):
    """The members of a uniform block lie at these offsets, and it takes `size` bytes.

    Members are named as in `UniformBuffer`. Both the lab's layout and the driver's are judged;
    drivers may say that a block is larger than it need be, but not that it is smaller.
    """

    kind = "memory"

    block: str
    offsets: Mapping[str, int]
    _: KW_ONLY
    size: int | None = None

    def __post_init__(self) -> None:
        self.name_by_default(f"layout of {self.block}")

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield Asked("blocks", (self.key(scene),))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        readings = frame.answers[Asked("blocks", (self.key(scene),))]
        if self.block not in readings:
            raise CaseError(
                f"there is no uniform block {self.block!r}", remedy=nearest(self.block, readings)
            )
        reading: BlockReading = readings[self.block]
        rows = []
        for member, offset in self.offsets.items():
            if member not in reading.placed:
                raise CaseError(
                    f"the block {self.block} has no member {member!r}",
                    remedy=nearest(member, reading.placed),
                )
            ours, driver = reading.placed[member], reading.offsets.get(member)
            rows.append(
                Row(
                    label=f"{self.block}.{member}",
                    expected=f"byte {offset}",
                    measured=f"byte {ours}; driver: {'none' if driver is None else driver}",
                    ok=offset == ours == driver,
                )
            )
        if self.size is not None:
            rows.append(
                Row(
                    label=f"{self.block}, whole",
                    expected=f"{self.size} bytes",
                    measured=f"{reading.placed_size} bytes; driver: {reading.size}",
                    ok=self.size == reading.placed_size <= reading.size,
                )
            )
        return memory_table(self.name, rows)


block_layout = BlockLayout
