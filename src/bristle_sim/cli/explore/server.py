"""The web server of the bench, the interactive page of a tool.

Each request contains all values of the page, so the server keeps no values between requests.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import json
import mimetypes
import re
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from bristle_sim.cli.explore import bench
from bristle_sim.cli.explore.worker import KINDS, Workers
from bristle_sim.cli.scenario import Values, main_scenario
from bristle_sim.render.report import filled

READ_TIMEOUT = 30.0  # longest wait for the next bytes of a request, s

PLAIN = "text/plain; charset=utf-8"

THIS_MACHINE = "127.0.0.1"  # address on which the server listens

NAMES = ("localhost", THIS_MACHINE, "::1")
"""Names of this machine that a request may carry.

A foreign page can make a name of its own point to this machine (DNS rebinding). Its requests carry
that name and are refused."""


class Server(ThreadingHTTPServer):
    """A listening web server of the interactive page; each request has its own thread."""

    def __init__(self, start: Values | None = None, port: int = 0) -> None:
        """Make the page and begin to listen.

        Args:
            start: values of the tool that is shown first, by key; by default the default tool.
            port: port; 0 for any free one.

        Raises:
            OSError: if the server cannot listen on the port.
            ValueError: for a refused value.
        """
        self.start = dict(start or {})
        self.page = filled(
            "explore.html.jinja",
            keys=bench.knobs(main_scenario(), self.start),
            presets=bench.PRESETS,
            downloads=bench.DOWNLOADS,
            quantities=bench.COLOURS,
        )
        self.protection = {
            "Content-Security-Policy": content_policy(self.page),
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
        }
        self.workers = Workers()
        try:
            super().__init__((THIS_MACHINE, port), Request)
        except OSError as error:
            raise OSError(f"--port = {port}: must be a free port ({error.strerror})") from None

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{THIS_MACHINE}:{self.server_port}/"

    def serve_forever(self, poll_interval: float = 0.5) -> None:
        """Answer requests until the server is shut down; then close its socket."""
        with self:
            super().serve_forever(poll_interval)


class Request(BaseHTTPRequestHandler):
    """A request of the page, with its answer."""

    timeout = READ_TIMEOUT
    server: Server

    def handle(self) -> None:
        """Answer the request. It is not an error if the browser no longer waits for the answer."""
        with contextlib.suppress(ConnectionError):
            super().handle()

    def do_GET(self) -> None:
        """Answer with the page, the result of a computation as JSON, or a file."""
        server = self.server
        url = urlsplit(self.path)
        kind, _, suffix = url.path.removeprefix("/").partition("/")
        given = dict(parse_qsl(url.query, keep_blank_values=True))
        given.pop("pin", None)
        options: list[Any] = [given.pop(name) for name in ("on", "fine") if name in given]
        if kind == "run":
            options = [server.start]
        elif kind == "download":
            options = [suffix]
        client = self.headers.get("X-Client", "")
        if not meant_for(self.headers.get("Host", ""), server.server_port):
            self._send("Host: must be the address that the command printed\n", PLAIN, 421)
        elif not kind:
            self._send(server.page, "text/html; charset=utf-8")
        elif kind == "progress":
            self._send({"done": server.workers.progress(client)})
        elif kind not in KINDS or suffix not in ("", *bench.DOWNLOADS):
            self._send("", PLAIN, 404)
        else:
            found = server.workers.answer(client, kind, server.start | given, *options)
            if not suffix:
                self._send(found)
            elif "error" in found:
                self._send(f"{found['error']}\n", PLAIN, 400)
            else:
                mime = mimetypes.types_map.get(f".{suffix}", "application/toml")
                self._send(found["content"], mime, name=f"tool.{suffix}")

    def _send(
        self,
        content: Any,
        mime: str = "application/json",
        status: int = 200,
        name: str = "",
    ) -> None:
        """Send an answer: bytes, a text, or a dictionary as JSON.

        Headers restrict a browser to the page's own script and to this server.

        Args:
            content: content of the answer.
            mime: media type of the content.
            status: HTTP status.
            name: name of the file in which the browser saves the answer; empty for an answer to the
                page.
        """
        text = json.dumps(content) if isinstance(content, dict) else content
        data = text.encode() if isinstance(text, str) else text
        length = str(len(data))
        of_content = {"Content-Type": mime, "Content-Length": length}
        self.send_response(status)
        for header, value in (self.server.protection | of_content).items():
            self.send_header(header, value)
        if name:
            self.send_header("Content-Disposition", f"attachment; filename={name}")
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing."""


def meant_for(header: str, port: int) -> bool:
    """Return whether the Host header of a request names this machine and the server's port."""
    with contextlib.suppress(ValueError):  # the header's port is not a number
        named = urlsplit(f"//{header}")
        return named.hostname in NAMES and (named.port or 80) == port
    return False


def content_policy(page: str) -> str:
    """Return the header value that restricts a browser to the page's own script and to this server."""
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digests = [
        base64.b64encode(hashlib.sha256(each.encode()).digest()).decode() for each in scripts
    ]
    own = " ".join(f"'sha256-{digest}'" for digest in digests)
    # A notebook on this machine may show the page in a frame.
    frames = "'self' http://localhost:* http://127.0.0.1:* vscode-webview:"
    return (
        f"default-src 'none'; script-src {own}; style-src 'unsafe-inline'; img-src data:; connect-src 'self';"
        f" base-uri 'none'; form-action 'none'; frame-ancestors {frames}"
    )
