"""Formulas made of formulas; their inputs are found by name like any reference's."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

from shaderlab.glslmath import either, mul, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.transforms import in_view

Law = Callable[..., Any]


def unchanged(name: str) -> Law:
    """An input as it is: what a vertex shader hands on, or a fragment shader writes down.

    >>> unchanged("aColor")(aColor=0.25)
    0.25
    """

    def same(**inputs: Any) -> Any:
        return inputs[name]

    return _with_inputs(same, (name,))


def sampled(sampler: str, at: str = "TexCoords") -> Law:
    """The texel of a sampler under coordinates, by the sampler's own filter and wrap modes.

    >>> inputs_of(sampled("image"))
    ('image', 'TexCoords')
    """

    def texel(**inputs: Any) -> Any:
        return texture(inputs[sampler], inputs[at])

    return _with_inputs(texel, (sampler, at))


def entry(index: Any, entries: Sequence[Any]) -> Any:
    """The entry that an index means, both being values: of an array, or of a primitive's corners.

    >>> float(entry(1.0, [0.25, 0.5, 0.75]))
    0.5
    """
    found = entries[0]
    for k, other in enumerate(entries[1:], 1):
        found = where(index > k - 0.5, other, found)
    return found


def device_place(aPos: Any) -> Any:
    """Clip coordinates of a vertex that is given in device coordinates: w is 1."""
    return vec4(aPos, 1.0)


def pixel_place(aPos: Any, size: Any) -> Any:
    """Clip coordinates of a vertex that is given in pixels of a target of this size."""
    return vec4(2.0 * aPos / size - 1.0, 0.0, 1.0)


def opaque(law: Law) -> Law:
    """A colour's law with an alpha of 1.

    >>> opaque(lambda Color: Color)(Color=[0.25, 0.5, 1.0]).tolist()
    [0.25, 0.5, 1.0, 1.0]
    """

    @wraps(law)
    def color(*args: Any, **inputs: Any) -> Any:
        return vec4(law(*args, **inputs), 1.0)

    return color


def renamed(law: Law, **words: str) -> Law:
    """The law with the first words of its inputs exchanged, for a struct of another name.

    >>> list(inspect.signature(renamed(lambda light_color, x: x, light="lamp")).parameters)
    ['lamp_color', 'x']
    """

    def other(name: str) -> str:
        first, dot, rest = name.partition("_")
        return words.get(first, first) + dot + rest

    names = {other(name): name for name in inputs_of(law)}

    @wraps(law)
    def same(**inputs: Any) -> Any:
        return law(**{names[name]: given for name, given in inputs.items()})

    return _with_inputs(same, tuple(names))


def projected(law: Law, *, homogeneous: bool = False) -> Law:
    """Clip coordinates of the places that a law gives in the world, by `view` and `projection`.

    Args:
        law: gives (…, 3), or (…, 4) if it is `homogeneous`.

    >>> inputs_of(projected(lambda aPos, offset: aPos + offset))
    ('aPos', 'offset', 'view', 'projection')
    """

    @wraps(law)
    def position(view: Any, projection: Any, **inputs: Any) -> Any:
        place = law(**inputs)
        if homogeneous:
            return mul(projection, mul(view, place))
        return in_view(place, view, projection)

    return _with_inputs(position, (*inputs_of(law), "view", "projection"))


def summed(*laws: Law) -> Law:
    """The sum of several laws, each of its own inputs.

    >>> summed(lambda a: a, lambda a, b: a * b)(a=2.0, b=3.0)
    8.0
    """
    wanted = [inputs_of(law) for law in laws]

    def total(**inputs: Any) -> Any:
        first, *others = (
            law(**{name: inputs[name] for name in names})
            for law, names in zip(laws, wanted, strict=True)
        )
        for other in others:
            first = first + other
        return first

    return _with_inputs(total, tuple(dict.fromkeys(name for names in wanted for name in names)))


def gated_or_not(law: Law, **without: Law) -> Law:
    """A law of light, with the gate of its highlight or without: that has a check of its own.

    Args:
        law: has a highlight on faces towards the lamp only.
        without: arguments that open the gate, such as `highlight=mirrored_lobe`.

    >>> float(gated_or_not(lambda x, highlight=abs: highlight(x), highlight=float)(x=3.0))
    3.0
    """

    @wraps(law)
    def either_of_both(**inputs: Any) -> Any:
        return either(law(**inputs), law(**inputs, **without))

    return _with_inputs(either_of_both, inputs_of(law))


def inputs_of(law: Law) -> tuple[str, ...]:
    """The names that a law asks for; what has a default is a choice, and no input.

    >>> inputs_of(lambda x, y, power=2.0: x)
    ('x', 'y')
    """
    parameters = inspect.signature(law).parameters.values()
    return tuple(p.name for p in parameters if p.default is p.empty)


def _with_inputs(law: Law, names: tuple[str, ...]) -> Law:
    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [inspect.Parameter(name, keyword) for name in names]
    vars(law)["__signature__"] = inspect.Signature(parameters)
    return law
