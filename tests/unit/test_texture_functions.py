"""A function that makes a texture is called once, while what was made has room."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shaderlab.drivers.programs.textures import texture_contents
from shaderlab.model.frame import Array
from shaderlab.model.textures import Texture


class Noise:
    """Makes other texels each time that it is called."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> Array:
        self.calls += 1
        return np.full((4, 4, 3), self.calls / 255.0)


class Unhashable(Noise):
    __hash__ = None  # type: ignore[assignment]


def codes(make: Noise, format: str = "rgb8") -> int:
    (layer,) = texture_contents(Texture(image=make, format=format), Path(), {}).layers
    return int(layer[0, 0, 0])


def test_it_is_called_once_for_all_scenes_and_formats() -> None:
    make, other = Noise(), Noise()
    assert [codes(make), codes(make), codes(other)] == [1, 1, 1]
    assert make.calls == other.calls == 1
    (layer,) = texture_contents(Texture(image=make, format="rgb32f"), Path(), {}).layers
    assert make.calls == 1 and layer[0, 0, 0] == np.float32(1 / 255.0)


def test_nobody_can_change_what_is_kept() -> None:
    make = Noise()
    (layer,) = texture_contents(Texture(image=make, format="rgb8"), Path(), {}).layers
    layer[:] = 9  # an upload's own copy
    assert codes(make) == 1


def test_an_object_that_has_no_hash_is_called_each_time() -> None:
    make = Unhashable()
    assert [codes(make), codes(make)] == [1, 2]
