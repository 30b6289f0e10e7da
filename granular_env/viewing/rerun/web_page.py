"""The web viewer's page, handed on from rerun's own server with a policy that keeps the browser on this machine.

Rerun's page asks for fonts, looks for news and reports its use to servers on the internet. The page served here is the same
without its links to other servers, and with a Content-Security-Policy that lets a browser ask for nothing but two ports of this
machine.
"""

from __future__ import annotations

import re
import threading
from http.client import HTTPConnection, HTTPException
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import quote

from .process import LOCALHOST, RerunProcess, free_port

_WAIT_SECONDS = 30.0
_FOREIGN_LINK = re.compile(rb"<link[^>]*https://[^>]*>")
_FORWARDED = ("Content-Type", "Content-Encoding")


class WebPage:
    """The web viewer of one run, served on 127.0.0.1 by a thread; for a process that `web_arguments` started.

    Attributes:
        address: what to open in a browser.
    """

    def __init__(self, viewer: RerunProcess, source: int) -> None:
        """Serve the page.

        Args:
            viewer: it holds the data.
            source: the port at which rerun serves its own page.
        """
        names = (LOCALHOST, "localhost")
        self._server = ThreadingHTTPServer((LOCALHOST, 0), _handler(source, _policy(viewer.port)))
        self._server.daemon_threads = True
        port = self._server.server_address[1]
        self._server.hosts = {f"{name}:{port}" for name in names}  # type: ignore[attr-defined]
        threading.Thread(target=self._server.serve_forever, name="granular-env web page", daemon=True).start()
        # Rerun's light theme leaves the pictures' dark ground as slabs.
        self.address = f"http://{LOCALHOST}:{port}/?url={quote(viewer.url, safe='')}&theme=dark"

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()


def web_arguments() -> tuple[int, tuple[str, ...]]:
    """Return the port of rerun's own page, and the arguments that make rerun serve it."""
    port = free_port()
    return port, ("--serve-web", "--web-viewer-port", str(port))


def _policy(data: int) -> str:
    """Return what the page may do: run its own program, and ask for nothing but itself and the port of the data."""
    return (
        "default-src 'none'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        f"img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' data: blob: http://{LOCALHOST}:{data}; "
        "worker-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


def _handler(source: int, policy: str) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        """Answers a request with what rerun's server says to it."""

        def do_GET(self) -> None:
            # Another site could let its name lead here (DNS rebinding); it cannot change what its page says for a host.
            if self.headers.get("Host") not in self.server.hosts:  # type: ignore[attr-defined]
                return self.send_error(403)
            connection = HTTPConnection(LOCALHOST, source, timeout=_WAIT_SECONDS)
            try:
                connection.request("GET", self.path)
                answer = connection.getresponse()
                # A policy does not keep a browser from connecting ahead of a request.
                content = _FOREIGN_LINK.sub(b"", answer.read()) if self.path.startswith("/?") else answer.read()
            except (OSError, HTTPException):
                return self.send_error(502, "rerun's server does not answer")
            finally:
                connection.close()
            self.send_response(answer.status)
            for name in _FORWARDED:
                if value := answer.headers.get(name):
                    self.send_header(name, value)
            # By it the page shows how much of its program has come.
            self.send_header("rerun-final-length", str(len(content)))
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Content-Security-Policy", policy)
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            """Say nothing."""

    return Handler
