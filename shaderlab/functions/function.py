"""One GLSL function as a Python callable: NumPy in, NumPy out."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import TracebackType
from typing import Any

from shaderlab.compiler.sources import Source
from shaderlab.engine.judging.laws import Law
from shaderlab.errors import CallError, ShaderlabError
from shaderlab.functions import checking
from shaderlab.functions.binding import Call, bound, replaced
from shaderlab.functions.laws import CallLaw
from shaderlab.functions.notes import Notes, notes
from shaderlab.functions.running import evaluate
from shaderlab.functions.signatures import Signature
from shaderlab.functions.substitutes import loads


class Function:
    """A GLSL function.

    Called with arrays, it is called for each of their elements: arguments broadcast as NumPy's do,
    and scalars give scalars. Floats are rounded to float32. Struct parameters take mappings,
    samplers a `shaderlab.Texture` or an array (height, width[, channels]), matrices arrays
    (…, rows, columns). Uniforms and other globals that it reads are given by their names. With
    `out` parameters it returns a named tuple of all that it writes.

    Where it asks for its pixel's neighbours (`dFdx`), those are its neighbours along the arguments'
    last two axes. What it discards is masked.
    """

    def __init__(
        self, source: Source, overloads: Sequence[Signature], folder: str, given: Mapping[str, Any]
    ) -> None:
        self._source = source
        self._overloads = tuple(overloads)
        self._folder = folder
        self._given = given
        self.__name__ = overloads[0].name
        self.__doc__ = "\n".join(map(str, overloads))

    @property
    def signatures(self) -> tuple[Signature, ...]:
        """Its overloads."""
        return self._overloads

    @property
    def folder(self) -> str:
        """What paths of textures are relative to."""
        return self._folder

    @property
    def place(self) -> tuple[str, int]:
        """The file and the line of its first definition."""
        return self.place_of(self._overloads[0])

    def __getitem__(self, types: str) -> Function:
        """The overload with parameters of these types, such as `f["vec3, float"]`."""
        wanted = [word.strip() for word in types.split(",") if word.strip()]
        for one in self._overloads:
            if [str(p.type) for p in one.parameters] == wanted:
                return Function(self._source, [one], self._folder, self._given)
        raise CallError(
            f"{self.__name__} has no overload ({types})",
            remedy=f"there is {', '.join(map(str, self._overloads))}",
        )

    def __repr__(self) -> str:
        file, line = self.place
        return f"<{'; '.join(map(str, self._overloads))} of {file}:{line}>"

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """The function's results for its arguments; see the class.

        Raises:
            CallError: the arguments fit no overload, or the call hangs or crashes.
            ShaderError: the function does not compile.
        """
        __tracebackhide__ = True
        try:
            call = self.bind(*arguments, **named)
            self._note(call)
            return self.evaluate(call)
        except ShaderlabError as error:
            raise error.with_traceback(_way_of(error)) from error.__cause__

    def check(
        self, law: Law | CallLaw | Callable[..., Any], /, *arguments: Any, **named: Any
    ) -> None:
        """Check the function at these arguments.

        Args:
            law: a reference, a formula written with `shaderlab.glslmath`, in whose band every value
                has to lie; or a law, such as `glsl.monotone("d")`. A reference's parameters are
                found by the names of the function's (`light.constant` is light_constant) or, if it
                has other names, stand in their order. For a structure, or with `out` parameters,
                it returns a mapping, a named tuple or a tuple of all parts; for an array a list.
            arguments, named: as in a call.

        Raises:
            AssertionError: it does not hold; says where.
            CallError, ShaderError: as in a call; or the reference takes other arguments.
        """
        __tracebackhide__ = True
        try:
            call = self.bind(*arguments, **named)
            outcomes = checking.judged(self, law, call)
        except ShaderlabError as error:
            raise error.with_traceback(_way_of(error)) from error.__cause__
        found = self._note(call)
        if found is not None:
            line = sys._getframe(1).f_lineno
            found.outcomes += [replace(outcome, line=line) for outcome in outcomes]
        if any(outcome.status != "pass" for outcome in outcomes):
            raise AssertionError(checking.text_of(call, outcomes))

    def _note(self, call: Call) -> Notes | None:
        """Note a call for the test that runs, or that no test makes it."""
        found = notes()
        if found is not None:
            found.add_call(self._source, checking.source_of_glsl(self, call))
        elif (known := loads()) is not None:
            known.called_outside.add(self._source.path)
        return found

    def again(self, call: Call, values: Mapping[str, Any]) -> Any:
        """The results of a call with other values of some arguments, by name."""
        return self.evaluate(replaced(call, values))

    def place_of(self, signature: Signature) -> tuple[str, int]:
        """The file and the line of an overload's definition."""
        return self._source.place(signature.line)

    def bind(self, *arguments: Any, **named: Any) -> Call:
        """The overload that arguments fit, with them. Raises CallError."""
        return bound(self._overloads, arguments, named, self._given)

    def evaluate(self, call: Call) -> Any:
        """The results of a call that `bind` made."""
        return evaluate(self._source, self._folder, call)


def _way_of(error: ShaderlabError) -> TracebackType | None:
    """The way that an error took through the lab, which is no matter of a test's."""
    return error.__traceback__ if os.environ.get("SHADERLAB_DEBUG") else None
