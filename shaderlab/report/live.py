"""A report that reloads in the browser when it is written anew: served on this machine alone.

The report itself asks nothing of any network. So it is shown inside a page that waits for word, and
stays as it is.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

_HOST = "127.0.0.1"
_ALIVE = 15.0
"""Seconds after which a browser that has gone is noticed."""
_FRAME = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>shaderlab watch</title>
<style>
html, body, iframe { margin: 0; border: 0; width: 100%; height: 100%; display: block }
</style>
<iframe src="/report/index.html" title="report"></iframe>
<script>
const frame = document.querySelector("iframe");
new EventSource("/changes").onmessage = () => frame.contentWindow.location.reload();
frame.onload = () => { document.title = frame.contentDocument.title; };
</script>
</html>
"""


class LiveReport:
    """Serves the report in `folder` until it is closed; `changed` has browsers load it again."""

    def __init__(self, folder: Path) -> None:
        handler = functools.partial(_Handler, self, directory=str(folder))
        self._server = ThreadingHTTPServer((_HOST, 0), handler)
        self._server.daemon_threads = True
        self._condition = threading.Condition()
        self._version = 0
        self._closed = False
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    @property
    def address(self) -> str:
        return f"http://{_HOST}:{self._server.server_port}/"

    def changed(self) -> None:
        """The report was written anew."""
        with self._condition:
            self._version += 1
            self._condition.notify_all()

    def close(self) -> None:
        with self._condition:
            self._closed = True
            self._condition.notify_all()
        self._server.shutdown()
        self._server.server_close()

    @property
    def version(self) -> int:
        return self._version

    def changes(self, known: int) -> Iterator[bool]:
        """Yield True for each change after version `known`, False now and then, until closed."""
        while not self._closed:
            with self._condition:
                if self._version == known and not self._closed:
                    self._condition.wait(_ALIVE)
                new, known = self._version > known, self._version
            yield new

    def is_asked_by_name(self, host: str | None) -> bool:
        """Whether a request names this server itself: another name that leads here is a foreign
        page's."""
        return host in (
            f"{_HOST}:{self._server.server_port}",
            f"localhost:{self._server.server_port}",
        )


@contextmanager
def live_report(folder: Path) -> Iterator[LiveReport]:
    report = LiveReport(folder)
    try:
        yield report
    finally:
        report.close()


class _Handler(SimpleHTTPRequestHandler):
    def __init__(self, report: LiveReport, *arguments: Any, **named: Any) -> None:
        self._report = report
        super().__init__(*arguments, **named)

    def do_GET(self) -> None:
        if not self._report.is_asked_by_name(self.headers.get("Host")):
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path == "/":
            self._send_frame()
        elif self.path == "/changes":
            self._send_changes()
        elif self.path.startswith("/report/"):
            self.path = self.path.removeprefix("/report")
            super().do_GET()
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def do_HEAD(self) -> None:
        self.send_error(HTTPStatus.METHOD_NOT_ALLOWED)

    def end_headers(self) -> None:
        self.send_header("Cache-Control", "no-store")
        super().end_headers()

    def log_message(self, format: str, *arguments: Any) -> None:
        """Nothing: the terminal is for verdicts."""

    def _send_frame(self) -> None:
        data = _FRAME.encode()
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def _send_changes(self) -> None:
        known = self._report.version  # as the browser has loaded it
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/event-stream")
        self.end_headers()
        try:
            for changed in self._report.changes(known):
                self.wfile.write(b"data: changed\n\n" if changed else b": waiting\n\n")
                self.wfile.flush()
        except OSError:  # the browser has gone
            return
