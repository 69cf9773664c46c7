"""any_order: a depth test makes the order of drawing irrelevant, which can be checked.

A scene is drawn twice, the second time in reverse: its last draw first or, with a single draw, its
last triangle first. Unless depth alone decides which surface a pixel shows, the images differ. A
mistake in both images may go unnoticed. So the pass is drawn once more, small, with its own depth
tests and with tests that show the nearest surface; and, since the nearest surface can be seen
without any test, with the farthest in front. If its own tests are such tests, all of one kind,
there is nothing to compare. If draws cull, the nearest surfaces of either side are drawn as well:
the culled faces of a closed solid lie behind the others.

Two faces that meet in an edge have the same depth there. If both lie on the same side of it, as at
an outline, and a pixel's centre is on the edge itself, the one that is drawn first stays: both
are right. Such pixels lie in a line along the edge; where surfaces intersect, they fill areas.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shaderlab.model.case import Scene
from shaderlab.model.checked import checked_arguments
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Array, Frame, TypedNeed, every_component
from shaderlab.model.phases import phase
from shaderlab.model.scene import Draw, Pass
from shaderlab.model.state import Depth
from shaderlab.model.textures import Output

from .base import Context
from .exact import Exact, view_bits

SUFFIX = "-backwards"
EITHER_SIDE = "nearest surface of either side"
LARGEST_SIDE = 256
"""Pixels along the longer side of what is drawn once more."""
OPPOSITE_TESTS = {"less": "greater", "lequal": "gequal", "greater": "less", "gequal": "lequal"}


@checked_arguments
def both_ways(description: Pass) -> tuple[Pass, Pass]:
    """The pass with its draws in reverse order, named `…-backwards`, and the pass itself.

    >>> from shaderlab import Mesh, Target
    >>> triangle = Mesh(attributes={"aPos": np.zeros((3, 3))})
    >>> draws = [Draw(vertex=f"{k}.vert", fragment="a.frag", mesh=triangle) for k in (1, 2)]
    >>> backwards, same = both_ways(Pass(name="scene", target=Target(), draws=draws))
    >>> backwards.name, [draw.vertex for draw in backwards.draws]
    ('scene-backwards', ['2.vert', '1.vert'])
    """
    draws = tuple(reversed(description.draws))
    if len(draws) == 1:
        draws = (_backwards(draws[0]),)
    return replace(description, name=description.name + SUFFIX, draws=draws), description


@dataclass(frozen=True)
class Backwards(TypedNeed[Array]):
    """What an output shows that is drawn backwards; its own values where all are the same, and at
    pixels that differ along lines and have one depth both ways. A pass with other outputs is
    another program to a driver, which may round otherwise: it is compared with what these show."""

    pass_name: str
    output: str

    def answer(self, context: Context) -> Array:
        session, names = context.session, (self.pass_name, self.pass_name + SUFFIX)

        def read(attachment: str) -> list[Array]:
            return [session.query("attachment", name, attachment).values for name in names]

        values, others = read(self.output)
        # Where one of the passes names its formats, it may have a component that no shader writes.
        own = values.shape[-1]
        others = np.append(others[..., :own], values[..., others.shape[-1] :], axis=-1)
        apart = ~every_component(view_bits(values) == view_bits(others))
        if not apart.any():
            return values
        one, other = map(session.scene.find_pass, names)
        target = one.target
        if target.colors != other.target.colors:
            alike = replace(one, target=other.target)
            drawn = session.redraw_pass(alike, self.output, others.shape[1] + others.shape[0])
            apart &= ~every_component(view_bits(drawn[..., :own]) == view_bits(others[..., :own]))
            others = np.where(apart[..., None], others, values)
        if self.output == "depth" or target.depth is None or target.samples:
            return others
        depth, backwards = (each[..., 0] for each in read("depth"))
        met = apart & (depth == backwards) & ~_find_areas(apart)
        return np.where(met[..., None], values, others)


@dataclass(frozen=True)
class AnyOrder(Exact):
    """`output` is that of the pass drawn backwards, `equals`, bit for bit, but where two faces of
    one depth meet in an edge. If `tested`, it shows the nearest surfaces, and the farthest ones
    with all depth tests turned round; but for pixels where two surfaces are equally far."""

    tested: bool = True

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield from super().needs(scene, programs)
        yield self._backwards(scene)
        for needs in self._redraws(scene).values():
            yield from needs

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        found = super().judge(scene, frame)
        for front, needs in self._redraws(scene).items():
            own, strict, loose = (frame.answer(need) for need in needs)
            decided = _find_same(strict, loose)
            apart = decided & ~_find_same(own, strict)
            if front == EITHER_SIDE:
                apart &= _find_areas(apart)  # along an outline both sides may be as near
            wrong = int(apart.sum())
            outcome = replace(found.outcome, judged=found.outcome.judged + int(decided.sum()))
            if wrong and outcome.status == "pass":
                message = (
                    f"{wrong} of {decided.size} pixels do not show the {front}: a depth test is "
                    "off, is another one or does not write, or the nearest surface is culled"
                )
                outcome = replace(outcome, status="fail", message=message, outside=wrong)
            found = replace(found, outcome=outcome)
        return found

    def expected(self, values: Array, scene: Scene, frame: Frame) -> Array:
        found = frame.answer(self._backwards(scene))
        return found

    def _backwards(self, scene: Scene) -> Backwards:
        return Backwards(self.key(scene)[0], self.own_name(scene))

    def _redraws(self, scene: Scene) -> "Mapping[str, tuple[Redraw, ...]]":
        """For what is to be in front the pass by its own tests, and by tests for that, which let
        the first of equally far surfaces through, or the last; none where its own are one of the
        two, and without a depth buffer of the pass's own."""
        (name, _), output = self.key(scene), self.own_name(scene)
        description = scene.find_pass(name)
        if not self.tested or description.target.depth is None or description.onto:
            return {}
        near, far = ("less", "lequal"), ("greater", "gequal")
        if description.target.clear_depth < 0.5:
            near, far = far, near
        own, found = _common_test(description, near), {}
        if not own:
            turned_round = "farthest surface, tests turned round"
            fronts = {"nearest surface": (near, False), turned_round: (far, True)}
            found = {
                front: tuple(Redraw(name, output, turned, test) for test in ("", *tests))
                for front, (tests, turned) in fronts.items()
            }
        if any(draw.state.cull for draw in description.draws):
            either = (Redraw(name, output, False, test, culled=False) for test in near)
            found[EITHER_SIDE] = (Redraw(name, output, False, own), *either)
        return found


@dataclass(frozen=True)
class Redraw(TypedNeed[Array]):
    """An output of a pass that is drawn once more: from the other end of the depth buffer if
    `turned`, with depth test `test` in each draw, or its own; nothing is culled unless `culled`."""

    pass_name: str
    output: str
    turned: bool
    test: str
    culled: bool = True

    def answer(self, context: Context) -> Array:
        description = context.session.scene.find_pass(self.pass_name)
        depth = description.target.clear_depth
        other = replace(
            description,
            target=replace(
                description.target, clear_depth=1.0 - depth if self.turned else depth, samples=0
            ),
            draws=tuple(self._change(draw) for draw in description.draws),
        )
        with phase("draw", f"drawing pass {self.pass_name!r} with other depth tests"):
            return context.session.redraw_pass(other, self.output, LARGEST_SIDE)

    def _change(self, draw: Draw) -> Draw:
        test = Depth(func=self.test) if self.test else _depth_test(draw, turned=self.turned)
        cull = draw.state.cull if self.culled else None
        return replace(draw, state=replace(draw.state, depth=test, cull=cull))


@checked_arguments
def any_order(output: str, *, tested: bool = True) -> AnyOrder:
    """An output, named with its pass, does not depend on the order of drawing; a pixel whose centre
    lies on the very edge of two faces may show either.

    Args:
        output: of a pass that `both_ways` gave.
        tested: whether each draw is to show the nearest surface, by a depth test, and whichever
            side it culls; False if one does not on purpose, as an outline over all, or a wall that
            is seen through from behind.

    >>> same = any_order("scene.FragColor")
    >>> same.output, same.equals.pass_name, same.equals.name
    ('scene.FragColor', 'scene-backwards', 'FragColor')
    """
    pass_name, _, name = output.partition(".")
    other = Output(f"{pass_name}{SUFFIX}.{name}")
    title = f"{output}: any order of drawing"
    return AnyOrder(output, other, name=title, pictured=False, tested=tested)


def _find_same(one: Array, other: Array) -> Array:
    return every_component((one == other) | ((one != one) & (other != other)))


def _find_areas(apart: Array) -> Array:
    """Those pixels that lie in a square of two by two of them."""
    whole = apart[1:, 1:] & apart[:-1, 1:] & apart[1:, :-1] & apart[:-1, :-1]
    found = np.zeros_like(apart)
    for rows in (slice(1, None), slice(-1)):
        for columns in (slice(1, None), slice(-1)):
            found[rows, columns] |= whole
    return found


def _depth_test(draw: Draw, *, turned: bool) -> Depth | None:
    test = draw.state.depth
    if test is None or not turned:
        return test
    return replace(test, func=OPPOSITE_TESTS.get(test.func, test.func))


def _common_test(description: Pass, tests: Sequence[str]) -> str:
    own = [draw.state.depth for draw in description.draws]
    return next((test for test in tests if all(one == Depth(func=test) for one in own)), "")


def _backwards(draw: Draw) -> Draw:
    mesh = draw.mesh
    if mesh is None or mesh.primitive != "triangles" or mesh.indices is None:
        return draw
    triangles = np.asarray(mesh.indices).reshape(-1, 3)
    return replace(draw, mesh=replace(mesh, indices=triangles[::-1].ravel()))
