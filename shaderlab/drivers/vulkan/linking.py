"""Programs made on the device once each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from shaderlab.compiler.sources import Source
from shaderlab.model.activity import doing

from ..program_cache import ProgramCache
from ..programs.module_texts import sources_of
from .device import Device
from .modules import modules_of
from .program import Program


class Linker(ProgramCache[Program]):
    """Programs by their stages' text."""

    device: Device

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

        def linked() -> Program:
            with doing("compile"):
                modules = modules_of(sources_of(texts, known))
            with doing("link"):
                return Program(self.device, modules)

        return self.get(tuple(sorted(texts.items())), linked)
