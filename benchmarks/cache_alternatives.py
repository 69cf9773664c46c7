"""The compile cache against ready-made parts: `python -m benchmarks.cache_alternatives`.

Needs msgspec (`pip install msgspec`). Shows the microseconds of the processor that one small
program takes to encode, decode, write and read, minimum of nine rounds of 200; and what each
package takes to import after `shaderlab.pipeline`, minimum of nine processes.
"""

from __future__ import annotations

import sqlite3
import subprocess
import sys
import tempfile
import time
import timeit
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks import running_programs
from shaderlab.compiler import Shaders, compile_program
from shaderlab.compiler.compile_cache import Entry, Store, decode, encode

IMPORTING = """
import time, shaderlab.pipeline
start = time.process_time()
import {0}
print(time.process_time() - start)
"""


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        for name, call in ways(Path(folder)).items():
            seconds = min(timeit.repeat(call, timer=time.process_time, repeat=9, number=200))
            print(f"{name:<16} {seconds / 200 * 1e6:>8.0f}")
    for name in ("msgspec", "sqlite3"):
        command = [sys.executable, "-c", IMPORTING.format(name)]
        least = min(float(subprocess.check_output(command)) for _ in range(9))
        print(f"import {name:<9} {least * 1e6:>8.0f}")


def ways(folder: Path) -> dict[str, Callable[[], object]]:
    """What is measured, by name."""
    import msgspec

    running_programs.write(folder / "programs", 1, 64)
    program = compile_program([Shaders([folder / "programs"]).load("light_0.frag")])
    entry = Entry(program.verdicts, program.spirv, program.logs, program.interface)
    pack: Any = msgspec.msgpack.Encoder()
    unpack: Any = msgspec.msgpack.Decoder(Entry)
    packed, ours = zlib.compress(pack.encode(entry), 1), encode(entry)
    store, key = Store(folder / "files"), "0a" * 32
    table = sqlite3.connect(folder / "table", isolation_level=None)
    table.execute("PRAGMA journal_mode = WAL")
    table.execute("PRAGMA synchronous = OFF")
    table.execute("CREATE TABLE entries (key TEXT PRIMARY KEY, content BLOB) WITHOUT ROWID")
    insert = "INSERT OR REPLACE INTO entries VALUES (?, ?)"
    select = "SELECT content FROM entries WHERE key = ?"
    return {
        "JSON, encode": lambda: encode(entry),
        "JSON, decode": lambda: decode(ours),
        "msgspec, encode": lambda: zlib.compress(pack.encode(entry), 1),
        "msgspec, decode": lambda: unpack.decode(zlib.decompress(packed)),
        "a file, write": lambda: store.put(key, ours),
        "a file, read": lambda: store.get(key),
        "sqlite3, write": lambda: table.execute(insert, (key, ours)),
        "sqlite3, read": lambda: table.execute(select, (key,)).fetchone(),
    }


if __name__ == "__main__":
    main()
