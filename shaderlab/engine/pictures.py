"""Writes a scene's pictures to the run's folder: its case's, its passes', the compared values'.

A scene is drawn once more in the size for people. What several drivers drew is stored here, too.
"""

import base64
import hashlib
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.compiler.glslang import disassemble
from shaderlab.drivers import Backend
from shaderlab.drivers.programs.prepare import Programs
from shaderlab.files import replace_file, write_bytes, write_if_changed
from shaderlab.model import pictures
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Image
from shaderlab.model.records import Attachment, PassRecord
from shaderlab.model.scene import Pass

Images = Mapping[tuple[str, str], Image]
"""What was drawn, by pass and output."""

# A case's picture on the front page is about so wide.
SMALL_SIDE = 170
# An attachment is shown so small that of larger ones some pixels are enough.
ATTACHMENT_SIDE = 136
# An exact comparison without a difference keeps at most so many bytes of numbers, or a corner.
LARGE = 4096
# The most elements of a buffer that its picture shows.
WIDEST = 1024


@dataclass(frozen=True)
class PictureFiles:
    """Picture files by what they show, relative to the run's folder, and how to read them.

    `values` is the file of the numbers behind them, or "".
    """

    files: Mapping[str, str] = field(default_factory=dict)
    captions: Mapping[str, str] = field(default_factory=dict)
    values: str = ""


class PictureWriter:
    """Writes pictures below images/ in a run's folder; without a folder it writes nothing.

    Names are made of the case's id, the variant and a label, and always end up inside the folder.
    """

    def __init__(self, folder: Path | None, case_id: str, variant: str) -> None:
        self._folder = folder
        self._stem = f"{_to_file_name(case_id)}--{_to_file_name(variant)}"
        self._saved: dict[tuple[object, ...], str] = {}
        self._picture: tuple[Image, PictureFiles] | None = None

    def write_picture(self, image: Image) -> PictureFiles:
        if self._folder is None:
            return PictureFiles()
        display = _display(image)
        files = {"picture": self._save("picture", display.image, 256)}
        if (factor := max(display.image.shape) // SMALL_SIDE) > 1:
            files["small"] = self._save("small", pictures.shrink(display.image, factor))
        self._picture = image, PictureFiles(files, {"picture": display.caption})
        return self._picture[1]

    def write_passes(self, scene: Scene, images: Images) -> tuple[PassRecord, ...]:
        """Describe a scene's passes, with a small picture of each attachment if it has several.

        The one that is the case's picture has that file.
        """
        if self._folder is None or (len(scene.passes) == 1 and len(images) == 1):
            return ()
        return tuple(self._pass_record(description, images) for description in scene.passes)

    def _pass_record(self, description: Pass, images: Images) -> PassRecord:
        own = {name: image for (where, name), image in images.items() if where == description.name}
        sizes = [image.values.shape[1::-1] for image in own.values()]
        return PassRecord(
            name=description.name,
            draws=tuple(draw.shaders for draw in description.draws),
            reads=tuple(dict.fromkeys(o.path for d in description.draws for o in d.outputs_read())),
            attachments=tuple(
                self._attachment(f"{description.name}.{name}", name, image)
                for name, image in own.items()
            ),
            size=sizes[0] if sizes else None,
        )

    def _attachment(self, label: str, name: str, image: Image) -> Attachment:
        if self._picture is not None and self._picture[0] is image:
            file = self._picture[1].files["picture"]
        else:
            step = max(1, max(image.values.shape[:2]) // ATTACHMENT_SIDE)
            small = replace(image, values=image.values[::step, ::step])
            file = self._save(f"pass-{label}", _display(small).image)
        return Attachment(name=name, format=image.format, image=file)

    def write_comparison(
        self,
        label: str,
        arrays: Mapping[str, Any],
        worst: tuple[int, int] | None = None,
        *,
        passed: bool = False,
    ) -> PictureFiles:
        """Write measured and reference values in common colours, their distance, and the numbers.

        Args:
            label: distinguishes this comparison from others of the scene.
            arrays: as in `Judgement.pictures`.
            worst: the pixel to keep where only a part of the numbers is kept.
            passed: writes the measured values' picture alone: the page draws the others, which
                look the same and pale, from the numbers.
        """
        if self._folder is None:
            return PictureFiles()
        names = ("measured",) if passed else ("measured", "reference")
        shown = {what: _get_array(arrays, what) for what in names}
        covered = arrays.get("covered")
        if covered is not None and covered.all():
            covered = None
        span = _common_range(tuple(shown.values()), covered)
        files: dict[str, str] = {}
        captions: dict[str, str] = {}
        for what, values in shown.items():
            display = pictures.to_display(values, value_range=span)
            seen = display.image
            if covered is not None:
                seen = np.where(covered[..., None], seen, np.array(pictures.UNCOVERED, np.uint8))
            captions[what] = display.caption
            files[what] = self._save(f"{label}-{what}", seen)
        if not passed:
            distance = _get_array(arrays, "distance")
            seen, palette = pictures.distance_picture(distance, np.abs(distance) > 1.0)
            files["distance"] = self._save(f"{label}-distance", seen, palette=palette)
        relative, path = self._file(label, "values")
        numbers = pictures.judged_part(arrays, worst)
        equal = "covered" not in arrays and not numbers.outside.any()
        _write_numbers(path, numbers, equal)
        return PictureFiles(files, captions, relative)

    def write_live(self, recording: bytes) -> str:
        """Write the calls that draw the picture, as a script, which a page on a disk may load."""
        relative, path = self._file("live", "js")
        text = base64.b64encode(recording).decode()
        write_if_changed(path, f'globalThis.shaderlabRecording = "{text}";\n'.encode())
        return relative

    def write_assembly(self, spirv: Mapping[str, Mapping[str, bytes]]) -> str:
        """Write a program's modules, by target and stage, as SPIR-V assembly; equal ones share a
        file.

        Returns:
            the file, relative to the run's folder; "" where there is none.
        """
        modules = {
            f"{to} {stage}": data for to, own in spirv.items() for stage, data in own.items()
        }
        if self._folder is None or not modules:
            return ""
        whole = b"".join(part for title, data in modules.items() for part in (title.encode(), data))
        name = hashlib.blake2s(whole, digest_size=8).hexdigest()
        relative = f"spirv/{name}.spvasm"
        path = self._folder / relative
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            # Other workers may write the same file at the same time.
            texts = (f"; {stage}\n{disassemble(data)}" for stage, data in modules.items())
            write_bytes(path, "\n".join(texts).encode("utf-8"))
        return relative

    def _save(self, label: str, image: Array, side: int = 1, palette: Array | None = None) -> str:
        """Write a picture; equal ones of a scene are one file, named by the first label."""
        pixels = np.ascontiguousarray(image)
        factor = max(1, -(-side // min(pixels.shape[:2])))
        key = pixels.shape, factor, hashlib.blake2b(pixels.data, digest_size=16).digest()
        if key not in self._saved:
            relative, path = self._file(label, "png")
            pictures.save_png(path, pixels, min_side=side, palette=palette)
            self._saved[key] = relative
        return self._saved[key]

    def _file(self, label: str, suffix: str) -> tuple[str, Path]:
        assert self._folder is not None
        relative = f"images/{self._stem}--{_to_file_name(label)}.{suffix}"
        path = self._folder / relative
        path.parent.mkdir(parents=True, exist_ok=True)
        return relative, path


def _get_array(arrays: Mapping[str, Any], name: str) -> Array:
    array = arrays[name]
    return np.asarray(array() if callable(array) else array)


def _write_numbers(path: Path, numbers: pictures.Values, equal: bool) -> None:
    """Write numbers, or those of a corner where every bit is equal and the data do not compress."""
    packed = pictures.pack(numbers)
    if equal and len(packed) > LARGE:
        packed = pictures.pack(numbers.corner())
    write_if_changed(path, packed)


def _display(image: Image) -> pictures.Display:
    """The image as people see it. A single row, as of a buffer, is shown as a strip: of as many
    pixels as a picture is wide at most, and an eighth as high."""
    display = pictures.to_display(image.values[..., :3])  # as a window shows it
    height, width = display.image.shape[:2]
    if height > 1 or width == 1:
        return display
    chosen = display.image[:, np.linspace(0, width - 1, min(width, WIDEST)).round().astype(int)]
    strip = np.repeat(chosen, max(1, chosen.shape[1] // 8), axis=0)
    return display._replace(image=strip)


def _common_range(shown: Sequence[Array], covered: Array | None) -> tuple[float, float] | None:
    """One range of values for all pictures, so that equal colours mean equal values."""
    if shown[0].shape[-1] != 1:
        return None
    both = np.concatenate([np.ravel(v if covered is None else v[covered]) for v in shown])
    finite = both[np.isfinite(both)]
    return (float(finite.min()), float(finite.max())) if finite.size else None


def _to_file_name(word: str) -> str:
    """`word` as part of a file name; different words stay different."""
    plain = re.sub(r"[^A-Za-z0-9.]+", "-", word).strip("-.")[:80]
    if plain == word:
        return plain
    return f"{plain}-{hashlib.blake2s(os.fsencode(word), digest_size=3).hexdigest()}"


def enlarge(
    backend: Backend, scene: Scene, programs: Programs, images: Images, side: int
) -> Images:
    """Draw a scene with `side` × `side` pixels where its targets have no size of their own: the
    passes that depend on the size, and those that they read. The rest is taken from `images`, drawn
    in another size. Raises ShaderError, UnsupportedError, CaseError: it can't be drawn."""
    needed = with_read_passes(scene, resized_passes(scene))
    if not needed:
        return images
    with backend.session(scene, programs, (side, side)) as session:
        return {**images, **session.draw(needed).images}


def resized_passes(scene: Scene) -> Sequence[str]:
    """The passes that depend on the frame's size: by their own targets or by what they read."""
    found: dict[str, None] = {}
    for description in scene.passes:
        own = description.target.size is None and not description.computes
        if own or not find_read_passes(description).isdisjoint(found):
            found[description.name] = None
    return list(found)


def with_read_passes(scene: Scene, names: Iterable[str]) -> set[str]:
    """Some passes, and those that they take to be drawn."""
    needed = set(names)
    for description in reversed(scene.passes):
        if description.name in needed:
            needed |= find_read_passes(description)
    return needed


def find_read_passes(description: Pass) -> set[str]:
    """The earlier passes whose outputs a pass reads or draws onto."""
    read = {output.pass_name for draw in description.draws for output in draw.outputs_read()}
    return read | ({description.onto} if description.onto else set())


def save_frames(folder: Path, case_id: str, variant: str, images: Images) -> None:
    """Store a scene's images as "pass.output", uncompressed: they are read once and deleted. Raises
    OSError: they can't be written."""
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {".".join(key): image.values for key, image in images.items()}
    with replace_file(_frames_file(folder, case_id, variant)) as draft, draft.open("wb") as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def load_frames(folder: Path, case_id: str, variant: str) -> dict[str, Array]:
    """The images that `save_frames` stored; empty if the scene was not drawn."""
    try:
        with np.load(_frames_file(folder, case_id, variant), allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except FileNotFoundError:
        return {}


def digest_values(values: Array) -> str:
    """A digest of an array's values, type and shape; zeros of both signs differ."""
    found = hashlib.blake2s(f"{values.dtype.str}{values.shape}".encode(), digest_size=12)
    found.update(np.ascontiguousarray(values).data)
    return found.hexdigest()


def _frames_file(folder: Path, case_id: str, variant: str) -> Path:
    name = hashlib.blake2s(os.fsencode(f"{case_id}\0{variant}")).hexdigest()[:24]
    return folder / f"{name}.npz"
