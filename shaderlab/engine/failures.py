"""What goes wrong while a scene is evaluated, as its record says it."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager

from shaderlab.errors import (
    AssetError,
    CaseError,
    DeviceLostError,
    DriverError,
    ShaderlabError,
    UnsupportedError,
)
from shaderlab.model.records import Status

from .record_builder import RecordBuilder


def failure_of(error: BaseException, driver: str | None) -> tuple[Status, ShaderlabError]:
    """The record's status after an exception, and the message."""
    match error:
        case UnsupportedError():
            return "unsupported", error
        case DeviceLostError():
            return "crash", DriverError(f"{driver}: {error.message}")
        case MemoryError():
            return "error", ShaderlabError(f"out of memory: {error}".rstrip(": "))
        case ShaderlabError():
            return "error", error
        case Exception():
            return "error", _defect(error)
    return "error", _raised(error)  # SystemExit, say, which only a case's own code raises


@contextmanager
def unless_unwritable(builder: RecordBuilder, what: str = "a picture") -> Iterator[None]:
    """A file for people that can't be written, on a full disk say, changes no verdict: the record
    gets a notice."""
    try:
        yield
    except AssetError as error:
        builder.add_notice(error.message)
    except OSError as error:
        builder.add_notice(f"can't write {what} ({error.strerror or error})")


def _raised(error: BaseException) -> ShaderlabError:
    """What a case raised, with the place where it did."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    message = f"raised {type(error).__name__}: {error}".rstrip(": ")
    return CaseError(message, file=place.filename, line=place.lineno)


def _defect(error: Exception) -> ShaderlabError:
    """An unforeseen error, with the place in the code where it happened."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return ShaderlabError(
        f"unforeseen {type(error).__name__}: {error}",
        file=place.filename,
        line=place.lineno,
        remedy="this is a defect of shaderlab; SHADERLAB_DEBUG=1 shows the whole traceback",
    )
