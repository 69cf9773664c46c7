"""Programs made on the device once each; the most recently used ones are kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from shaderlab.activity import doing
from shaderlab.backends.vulkan.device import Device
from shaderlab.backends.vulkan.modules import modules_of, sources_of
from shaderlab.backends.vulkan.program import Program
from shaderlab.compiler.sources import Source

CAPACITY = 64


class Linker:
    """Programs by their stages' text, so that equal ones are made once.

    The `CAPACITY` most recently used ones are kept: a software driver's machine code takes a
    megabyte. A program is used before the next one is asked for.
    """

    def __init__(self, device: Device, first: Linker | None = None) -> None:
        """`first` is another linker, whose programs are used where it has them, and which is left
        as it is."""
        self.device = device
        self._first = first
        self._linked: dict[tuple[tuple[str, str], ...], Program] = {}

    def link(self, texts: Mapping[str, str], known: Sequence[Source] = ()) -> Program:
        """The program of these stages.

        Args:
            texts: by stage.
            known: sources, some of whose texts these may be.

        Raises:
            ShaderError: it is no GLSL.
            UnsupportedError: it can't be made into modules for Vulkan, or takes a feature that the
                device lacks.
        """
        key = tuple(sorted(texts.items()))
        program = self._linked.pop(key, None)
        if program is None and self._first is not None and key in self._first._linked:
            return self._first._linked[key]
        if program is None:
            with doing("compile"):
                modules = modules_of(sources_of(texts, known))
            with doing("link"):
                program = Program(self.device, modules)
        self._linked[key] = program
        if len(self._linked) > CAPACITY:
            self._linked.pop(next(iter(self._linked))).release()
        return program

    def release(self) -> None:
        """Release all programs."""
        while self._linked:
            self._linked.popitem()[1].release()
