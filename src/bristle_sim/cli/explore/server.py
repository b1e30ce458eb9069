"""The web server of the bench, the interactive page of a tool.

Each request carries all values of the page, so the server keeps no state of its users.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import io
import ipaddress
import mimetypes
import re
import threading
from collections.abc import Sequence
from typing import Any
from urllib.parse import urlsplit

from flask import Flask, Response, jsonify, request
from werkzeug.serving import BaseWSGIServer, WSGIRequestHandler, make_server

from bristle_sim.cli.explore import bench
from bristle_sim.cli.explore.worker import Workers
from bristle_sim.cli.scenario import main_scenario
from bristle_sim.render.report import filled

OF_THE_PAGE = ("pin", "on", "fine")  # parts of a request that are not parameters of the tool
READ_TIMEOUT = 30.0  # longest wait for the next bytes of a request, s

NAMES = ("localhost", "127.0.0.1", "::1")
"""Names of this machine that a request may carry.

A foreign page can make a name of its own point to this machine (DNS rebinding). Its requests carry
that name and are refused."""


def application(start: Sequence[str] = (), host: str = NAMES[0]) -> Flask:
    """Return the web application that serves the interactive page of a tool.

    ``start`` holds the assignments ``KEY=VALUE`` of the tool that is shown first. ``host`` is the
    address on which the server listens.

    Raises:
        ValueError: for a refused value.
    """
    app = Flask("bristle_sim.cli.explore", static_folder=None)
    pass_of = main_scenario()
    workers = Workers()
    page = filled(
        "explore.html.jinja",
        keys=bench.knobs(pass_of, start),
        presets=bench.PRESETS,
        downloads=bench.DOWNLOADS,
        quantities=bench.COLOURS,
    )

    def typed() -> list[str]:
        return [f"{key}={value}" for key, value in request.args.items() if key not in OF_THE_PAGE]

    _guard(app, host, content_policy(page))

    def client() -> str:
        return request.headers.get("X-Client", "")

    @app.get("/")
    def index() -> Response:
        return Response(page, mimetype="text/html")

    @app.get("/run")
    def run() -> Response:
        return jsonify(workers.answer(client(), "run", list(start), typed()))

    @app.get("/progress")
    def progress() -> Response:
        return jsonify(done=workers.progress(client()))

    @app.get("/<any(radial, map, limits, design, surface):kind>")
    def searched(kind: str) -> Response:
        options = [request.args[each] for each in ("on", "fine") if each in request.args]
        return jsonify(workers.answer(client(), kind, [*start, *typed()], *options))

    @app.get("/download/<kind>")
    def download(kind: str) -> Response:
        """Answer with the results of a pass as a file; ``kind`` is the file's suffix."""
        if kind not in bench.DOWNLOADS:
            return Response(status=404)
        found = workers.answer("", "download", kind, [*start, *typed()])
        if "error" in found:
            return Response(found["error"] + "\n", status=400, mimetype="text/plain")
        headers = {"Content-Disposition": f"attachment; filename=tool.{kind}"}
        content = base64.b64decode(found["content"])
        return Response(
            content,
            mimetype=mimetypes.types_map.get(f".{kind}", "application/toml"),
            headers=headers,
        )

    return app


def _guard(app: Flask, host: str, policy: str) -> None:
    """Let an application refuse requests that are not meant for it, and send headers that protect
    the page.
    """

    @app.before_request
    def check_host() -> Response | None:
        """Refuse a request whose Host header does not name this server."""
        if meant_for(request.headers.get("Host", ""), host, request.environ["SERVER_PORT"]):
            return None
        return Response(
            "Host: must be the address that the command printed\n",
            status=421,
            mimetype="text/plain",
        )

    @app.after_request
    def protect(response: Response) -> Response:
        """Add the headers that restrict a browser to the page's own script and to this server."""
        response.headers["Content-Security-Policy"] = policy
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Cache-Control"] = "no-store"
        return response


def meant_for(header: str, host: str, port: str) -> bool:
    """Return whether the Host header of a request names this server.

    It must name this machine or the address ``host``, with the server's port. If the server listens
    on every address of the machine, any numerical address is accepted, since no other site can
    redirect a numerical address to this server.
    """
    with contextlib.suppress(ValueError):
        named = urlsplit(f"//{header}")
        name = named.hostname or ""
        if str(named.port or 80) != port:
            return False
        if name in (*NAMES, host.lower()):
            return True
        if host in ("0.0.0.0", "::"):
            ipaddress.ip_address(name)  # raises ValueError for a name
            return True
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


def server(start: Sequence[str] = (), *, host: str = "127.0.0.1", port: int = 0) -> BaseWSGIServer:
    """Return a listening web server of the interactive page; each request has its own thread.

    Args:
        start: assignments ``KEY=VALUE`` of the tool that is shown first.
        host: address on which the server listens.
        port: port; 0 for any free one.

    Raises:
        OSError: if the server cannot listen on the host and port.
        ValueError: for a refused value.
    """
    taken = io.StringIO()
    try:
        with contextlib.redirect_stderr(taken):
            return make_server(
                host, port, application(start, host), threaded=True, request_handler=_Quiet
            )
    except SystemExit:  # werkzeug raises it for a port in use
        raise OSError(f"--host {host} --port {port}: {taken.getvalue().splitlines()[0]}") from None


class _Quiet(WSGIRequestHandler):
    """Request handler that logs nothing and stops reading a request after READ_TIMEOUT seconds."""

    timeout = READ_TIMEOUT

    def log(self, type: str, message: str, *args: Any) -> None:
        """Suppress the log line of a request."""


def serve(start: Sequence[str] = ()) -> str:
    """Serve the interactive page from a thread of this process, and return its address.

    Raises:
        ValueError: for a refused value.
    """
    serving = server(start)
    threading.Thread(target=serving.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{serving.server_port}/"
