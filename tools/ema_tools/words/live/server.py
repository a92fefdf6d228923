"""The live page's server: bound to this machine's loopback address, answers that page and its data, takes nothing."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ema_tools.base.errors import InputError
from ema_tools.base.files import reason
from ema_tools.words.live.page import POLICY

ADDRESS = "127.0.0.1"
# A page of another origin may point a name of its own at this address: what is asked for by another name is refused.
_NAMES = (ADDRESS, "localhost")


class LiveServer:
    """Serves `page` and what `state` gives for the version that the page has, None where it has the latest; from its own thread, until it is closed."""

    def __init__(self, page: str, state: Callable[[str], dict[str, Any] | None], port: int = 0) -> None:
        """`port` 0 takes a free one. Raises InputError where the port is taken."""
        try:
            self._server = ThreadingHTTPServer((ADDRESS, port), _handler(page.encode(), state))
        except OSError as error:
            raise InputError(f"--port {port}: {reason(error)}: leave it out, and a free one is taken") from None
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, name="live page", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{ADDRESS}:{self._server.server_address[1]}/"

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


def _handler(page: bytes, state: Callable[[str], dict[str, Any] | None]) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked = urlsplit(self.path)
            if (self.headers.get("Host") or "").rpartition(":")[0] not in _NAMES:
                self._answer(HTTPStatus.FORBIDDEN, b"asked for by another name than this machine's own\n", "text/plain")
            elif asked.path == "/":
                self._answer(HTTPStatus.OK, page, "text/html; charset=utf-8")
            elif asked.path == "/state":
                now = state("".join(parse_qs(asked.query).get("seen", [])))
                if now is None:
                    self._answer(HTTPStatus.NO_CONTENT, b"", "application/json")
                else:
                    self._answer(HTTPStatus.OK, json.dumps(now, allow_nan=False).encode(), "application/json")
            else:
                self._answer(HTTPStatus.NOT_FOUND, b"not here\n", "text/plain")

        def _answer(self, status: HTTPStatus, body: bytes, kind: str) -> None:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("Content-Security-Policy", POLICY)
            self.send_header("X-Content-Type-Options", "nosniff")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """Requests are no news."""

    return Handler
