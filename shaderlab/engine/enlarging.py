"""A scene in the size for people: only what depends on the size is drawn once more."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, replace

from shaderlab.drivers import Backend
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.drivers.programs.textures import COLOR
from shaderlab.model.case import Scene
from shaderlab.model.frame import Image
from shaderlab.model.textures import Output, Sampling, Texture

Images = Mapping[tuple[str, str], Image]


def enlarged(
    backend: Backend, scene: Scene, programs: Programs, images: Images, side: int
) -> Images:
    """A scene's images with `side` × `side` pixels where its targets have no size of their own.

    A pass of a size of its own has its image in `images` already. Where others sample that, they
    get a texture with the same texels; it is drawn once more where they read it in another way.

    Args:
        backend: the device.
        scene: what to draw.
        programs: its compiled draws.
        images: what was drawn of it in another size, by pass and output.
        side: the size in pixels.

    Raises:
        ShaderError, UnsupportedError, CaseError: it can't be drawn.
    """
    drawn = set(resized(scene))
    if not drawn:
        return images
    textures = {
        output: texture
        for description in scene.passes
        for draw in description.draws
        for output in draw.outputs_read()
        if output.pass_name not in drawn and (texture := _texture(scene, output, images))
    }
    others = dict(programs)
    for description in reversed(scene.passes):
        if description.name in drawn:
            prepared = tuple(_sampling(draw, textures) for draw in programs[description.name])
            others[description.name] = prepared
            read = (output for one in prepared for output in one.draw.outputs_read())
            drawn |= {output.pass_name for output in read} | {description.onto} - {""}
    with backend.session(scene, others, (side, side)) as session:
        return {**images, **session.draw(drawn).images}


def resized(scene: Scene) -> Iterator[str]:
    """The passes that depend on the frame's size: by their own targets or by what they read."""
    found: set[str] = set()
    for description in scene.passes:
        read = {output.pass_name for draw in description.draws for output in draw.outputs_read()}
        own = description.target.size is None and not description.computes
        if own or found & {*read, description.onto}:
            found.add(description.name)
            yield description.name


def _texture(scene: Scene, output: Output, images: Images) -> Texture | None:
    """A texture that samplers read as they read an output; None where there may be none."""
    image = images.get((output.pass_name, output.name))
    if image is None or image.layers or scene.find_pass(output.pass_name).target.samples:
        return None
    kind = COLOR.get(image.format)  # depths are rounded to their codes once more
    if kind is None or kind.integer or kind.components != image.values.shape[-1]:
        return None
    same = {field.name: getattr(output, field.name) for field in fields(Sampling)}
    return Texture(image=image.values, format=image.format, mipmaps=output.mipmaps, **same)


def _sampling(prepared: PreparedDraw, textures: Mapping[Output, Texture]) -> PreparedDraw:
    """The draw with textures in place of the outputs that it samples."""
    draw = prepared.draw
    sampled = {
        name: textures.get(source, source) if isinstance(source, Output) else source
        for name, source in draw.textures.items()
    }
    return replace(prepared, draw=replace(draw, textures=sampled))
