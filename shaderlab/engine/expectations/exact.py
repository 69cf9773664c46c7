"""exact: an output equals an array, or another pass's output, bit for bit, at every pixel."""

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs, Read
from shaderlab.model.frame import Array, Frame, every_component
from shaderlab.model.records import Outcome, Worst
from shaderlab.model.textures import Output

from ..judging.banded import to_tuple
from .base import OutputExpectation
from .needs import find_image


@dataclass(frozen=True)
class Exact(OutputExpectation):
    """Every pixel of `output` equals `equals` bit for bit.

    `equals` is a number or vector, an array (height, width, components) with row 0 at the
    bottom (a smaller one is repeated in equal blocks, as a table's cells are), or an
    `Output("pass.output")` to be compared with. What a dispatch left in a buffer is one row: an
    array of its length does too, (count,) or (count, components). Without `pictured` it is shown
    only if it fails, for what each pass's own picture shows already.
    """

    kind = "exact"

    output: str
    equals: Any
    _: KW_ONLY
    pictured: bool = True

    def __post_init__(self) -> None:
        if callable(self.equals):
            raise CaseError(f"exact {self.output!r}: equals is a function", remedy="use formula")

    def find_reads(self, scene: Scene) -> Iterable[Read]:
        yield Read(self.key(scene)[0], self.own_name(scene))
        if isinstance(self.equals, Output):
            yield Read(self.equals.pass_name, self.equals.name)

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        if isinstance(self.equals, Output):
            self._require_another(self.equals, scene)
        return ()

    def _require_another(self, other: Output, scene: Scene) -> None:
        own = scene.find_pass(scene.split_output(self.output)[0])
        twin = scene.find_pass(other.pass_name)
        if self.own_name(scene) != other.name:
            return
        if own is twin or is_twin(replace(own, name=twin.name), twin):
            what = "itself" if own is twin else f"pass {twin.name!r}, which draws the same"
            raise CaseError(
                f"exact {self.name!r}: {self.output} is compared with {what}, so it could not fail",
                remedy="compare what is drawn in two ways, or with colours",
            )

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        values = find_image(self.output, scene, frame).values
        wanted = self.expected(values, scene, frame)
        if wanted is values:
            same = np.ones(values.shape[:2], np.bool_)
        else:
            same = every_component(view_bits(values) == view_bits(wanted))
        outside = int((~same).sum())
        outcome = Outcome(
            name=self.name,
            kind=self.kind,
            status="fail" if outside else "pass",
            message=f"{outside} of {same.size} pixels differ" if outside else "",
            judged=same.size,
            outside=outside,
            worst=_find_first_difference(same, values, wanted) if outside else None,
        )
        if not outside and not self.pictured:
            return Judgement(outcome=outcome)

        def pictures() -> dict[str, Array]:
            distance = np.where(same, 0.0, np.inf)
            return {"measured": values, "reference": wanted, "distance": distance}

        return Judgement(outcome=outcome, pictures=pictures)

    def expected(self, values: Array, scene: Scene, frame: Frame) -> Array:
        """What the output, which has these values, is to be: (height, width, components)."""
        wanted = self.equals
        if isinstance(wanted, Output):
            wanted = find_image(wanted.path, scene, frame).values
        return spread_over(wanted, values, self.name)


def is_twin(one: Any, other: Any) -> bool:
    """Whether two parts of a scene are alike: equal, or made of the very same arrays."""
    if one is other:
        return True
    if type(one) is not type(other) or isinstance(one, np.ndarray):
        return False
    if is_dataclass(one):
        return all(is_twin(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, Mapping):
        # Textures get their units in the order of their names.
        return list(one) == list(other) and all(is_twin(one[k], other[k]) for k in one)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(is_twin, one, other))
    return bool(one == other)


def spread_over(expected: Any, values: Array, name: str) -> Array:
    """An expected colour or table, as an array of the image's own shape and type.

    A table of cells is laid over the image as `Cell` lays draws: cell k of n begins at pixel
    ⌊size·k/n⌋. Raises CaseError: its shape does not fit, or it holds numbers that the attachment
    can't."""
    height, width, components = values.shape
    table = np.asarray(expected)
    rows = {(width,), (width, components)} - {(components,)}
    if height == 1 < width and table.shape in rows:
        table = table.reshape(1, width, -1)
    table = table[..., None] if table.ndim in (0, 2) else table
    table = table[None, None] if table.ndim == 1 else table
    if table.ndim != 3 or table.shape[2] not in (1, components) or table.size == 0:
        raise CaseError(
            f"exact {name!r}: an image of shape {values.shape} can't be compared with an array "
            f"of shape {np.shape(expected)}"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        typed = table.astype(values.dtype)
    if values.dtype.kind in "iu" and (typed != table).any():
        raise CaseError(f"exact {name!r}: the attachment holds {values.dtype}, not {expected!r}")
    rows, columns = _cell_indices(height, table.shape[0]), _cell_indices(width, table.shape[1])
    return np.broadcast_to(typed[rows][:, columns], values.shape)


def _find_first_difference(same: Array, values: Array, wanted: Array) -> Worst:
    y, x = (int(k) for k in np.argwhere(~same)[0])
    measured, reference = to_tuple(values[y, x]), to_tuple(wanted[y, x])
    differs = [m != r for m, r in zip(measured, reference, strict=True)]
    return Worst(
        pixel=(x, y),
        component=differs.index(True) if any(differs) else 0,
        measured=measured,
        reference=reference,
        low=reference,
        high=reference,
        ulp=float("nan"),
        widths=float("inf"),
    )


def _cell_indices(pixels: int, cells: int) -> Any:
    starts = np.array([pixels * k // cells for k in range(cells)])
    return np.searchsorted(starts, np.arange(pixels), side="right") - 1


def view_bits(values: Array) -> Array:
    """Values as integers that are equal only for the very same bits."""
    if values.dtype.kind != "f":
        return values
    return np.ascontiguousarray(values).view({2: np.uint16, 4: np.uint32}[values.dtype.itemsize])


exact = Exact
