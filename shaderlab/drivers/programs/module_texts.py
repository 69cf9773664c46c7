"""Programs made into modules for other interfaces than OpenGL's: what those count or write
otherwise is put into the text."""

import itertools
import re
from collections.abc import Mapping, Sequence

from shaderlab.compiler.compile import Compiled
from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.model.scene import Draw

from . import stages

HEIGHT = stages.PREFIX + "height"
"""The uniform that says how high the target is in pixels (float)."""
_COORD = re.compile(r"\blayout\s*\(([^)]*)\)\s*in\s+vec4\s+gl_FragCoord\s*;")
_LOCATED = re.compile(r"\blayout\s*\([^)]*\blocation\s*=\s*(\d+)[^)]*\)\s*(?:flat\s+)?out\b")
_ADDED = re.compile(rf"^(?:flat )?out \w+ {stages.PREFIX}\w+;", re.MULTILINE)
_NO_FILES = Shaders(())


def apply_coord_layout(text: str) -> str:
    """The text with window coordinates counted as its own declaration of gl_FragCoord says."""
    declared = _COORD.search(text)
    if declared is None:
        return text
    y = f"{HEIGHT} - gl_FragCoord.y" if "origin_upper_left" in declared[1] else "gl_FragCoord.y"
    half = " - 0.5" if "pixel_center_integer" in declared[1] else ""
    named = f"{stages.PREFIX}frag_coord"
    counted = (
        f"uniform float {HEIGHT}; vec4 {named}() "
        f"{{ return vec4(gl_FragCoord.x{half}, {y}{half}, gl_FragCoord.zw); }}"
    )
    after = re.sub(r"\bgl_FragCoord\b", f"{named}()", text[declared.end() :])
    return f"{text[: declared.start()]}{counted}{after}"


def assign_locations(text: str) -> str:
    """The text, the outputs that the lab adds having locations where the author's have: glslang
    gives those without one the locations that others have already."""
    taken = {int(number) for number in _LOCATED.findall(text)}
    if not taken:
        return text
    free = itertools.filterfalse(taken.__contains__, itertools.count())
    return _ADDED.sub(lambda found: f"layout(location = {next(free)}) {found[0]}", text)


def make_sources(texts: Mapping[str, str], known: Sequence[Source] = ()) -> tuple[Source, ...]:
    """The stages with these texts, as compilers take them: `known` ones where they are the same."""
    own = {source.stage: source for source in known}
    return tuple(
        own[stage]
        if stage in own and own[stage].text == text
        else _NO_FILES.from_text(text, stage, own[stage].path if stage in own else f"<{stage}>")
        for stage, text in texts.items()
    )


def compile_to_modules(sources: Sequence[Source], target: str, api: str) -> Compiled:
    """Compile a program for "opengl" or "vulkan", so that its modules are there; errors call what
    they are for `api`. Raises ShaderError: it is no GLSL; UnsupportedError: it is GLSL, but none
    that can be made into modules."""
    compiling = cached_compiler()
    compiled = compiling(sources, ("glsl", "opengl") if target == "opengl" else (target,))
    if target in compiled.spirv:
        return compiled
    compiling(sources, ("glsl",)).require()
    try:
        compiled.require()
    except ShaderError as error:
        raise UnsupportedError(
            f"in {api}: {error.message}", file=error.file, line=error.line, remedy=error.remedy
        ) from error
    raise UnsupportedError(f"in {api}: the program has no modules", file=sources[0].path)


def write_point_texts(draw: Draw, texts: Mapping[str, str]) -> dict[str, str]:
    """The texts of a draw's program, whose last stage writes the size of points if it draws any."""
    # The points of a capture are no picture's: none is dropped, and they have a size already.
    plain = draw.mesh is not None and draw.mesh.primitive == "points" and "geometry" not in texts
    stores = stages.BLOCK in texts.get("geometry", texts["vertex"])
    if not stores and (plain or stages.emits_points(texts)):
        return _clip_drawn_points(texts, draw.state.point_size)
    return dict(texts)


def _clip_drawn_points(texts: Mapping[str, str], size: float | str | None) -> dict[str, str]:
    """Return the texts of a program that draws points: its last stage writes their `size` (as in
    `State.point_size`), and drops those that OpenGL clips. lavapipe (Mesa 22.3) and SwiftShader
    report that they do, and draw them; OpenGL ES has them drawn."""
    last = "geometry" if "geometry" in texts else "vertex"
    if isinstance(size, str) or (size is None and "gl_PointSize" in texts[last]):
        given = None
    else:
        given = 1.0 if size is None else float(size)
    return {**texts, last: stages.clip_points(texts[last], given)}
