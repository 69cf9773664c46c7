"""Connecting to a Dask cluster whose machines have the same versions as this one.

A record must not depend on the machine that made it, so all versions have to agree.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from shaderlab.errors import UsageError

from .dask_bundles import identity

if TYPE_CHECKING:
    from distributed import Client

CONNECT_SECONDS = 10.0
_INSTALL = "pip install 'shaderlab[cluster]'"


def connected(address: str) -> Client:
    """A client of the scheduler at `address`.

    Raises:
        UsageError: Dask is not installed here, or no scheduler answers there.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError(f"--scheduler needs Dask ({error})", remedy=_INSTALL) from error
    try:
        with quiet():
            return Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise UsageError(
            f"no Dask scheduler answers at {address}",
            remedy="start one with `dask scheduler --port 8786`, and on each machine "
            "`dask worker tcp://HOST:8786`",
        ) from error
    except (ValueError, TypeError) as error:
        raise UsageError(
            f"{address!r} is no scheduler's address ({error})",
            remedy="write it as tcp://HOST:8786",
        ) from error


def check_workers(client: Client, address: str) -> None:
    """Check that there are workers, all with the versions of this machine. Raises UsageError."""
    from .dask_plugin import identify_worker

    with contextlib.suppress(TimeoutError):
        client.wait_for_workers(1, timeout=CONNECT_SECONDS)
    if not client.nthreads():
        raise UsageError(
            f"the Dask scheduler at {address} has no workers",
            remedy=f"start one on each machine: dask worker {address}",
        )
    versions: Any = client.get_versions()
    own = versions["client"]["packages"]
    for name, theirs in {"the scheduler": versions["scheduler"], **versions["workers"]}.items():
        found = theirs["packages"] if theirs else {}
        for package in ("python", "dask", "distributed"):
            if _comparable(found.get(package)) != _comparable(own[package]):
                raise other_version(
                    address, name, {package: str(found.get(package))}, {package: str(own[package])}
                )
    for worker, found in client.run(identify_worker()).items():
        if found != identity():
            raise other_version(address, worker, found)


def _comparable(version: Any) -> Any:
    """Python to its minor version ("3.11.7.final.0"), packages to the last digit."""
    text = str(version)
    return text.split(".")[:2] if ".final." in text else text


def other_version(
    address: str, worker: str, theirs: Mapping[str, str], own: Mapping[str, str] | None = None
) -> UsageError:
    """The error that says how a worker's versions differ from this machine's."""
    own = identity() if own is None else own
    if "error" in theirs:
        said = f"{worker} has no shaderlab ({theirs['error']})"
    else:
        different = (
            f"{name} {theirs.get(name, 'none')}, here {own[name]}"
            for name in own
            if own[name] != theirs.get(name)
        )
        said = f"{worker} has {'; '.join(different)}"
    return UsageError(
        f"Dask cluster {address}: {said}",
        remedy="install the same versions on all machines",
    )


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Silence Dask's own log: an error says the same in one line."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(before)
