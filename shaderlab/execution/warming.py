"""What a worker can have ready before it is forked, apart from its own modules."""

from __future__ import annotations

from collections.abc import Callable

from shaderlab.compiler import engines


def warm_up() -> Callable[[], None]:
    """Start the compilers in the background; the function that waits for them also imports the
    driver's packages, without a device."""
    wait_for_compilers = engines.warm_up()

    def wait() -> None:
        from shaderlab.backends import preload

        preload()
        wait_for_compilers()

    return wait
