"""The server of the bench. Each request carries the whole state, so users share no state."""

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
from bristle_sim.cli.scripts import main_scenario
from bristle_sim.render.report import explore_page

OF_THE_PAGE = ("pin", "on", "fine")  # parts of an address that are not keys of the tool
READ_TIMEOUT = 30.0  # longest wait for further bytes of a request, s

NAMES = ("localhost", "127.0.0.1", "::1")
"""Names of this machine in requests to its own server.

Another page can let a name of its own point here (DNS rebinding); its requests carry that name and
are refused."""


def application(start: Sequence[str] = (), host: str = NAMES[0]) -> Flask:
    """Return the bench as a web application for a host; the first tool has the given assignments.

    Raises:
        ValueError: for a refused value.
    """
    app = Flask("bristle_sim.cli.explore", static_folder=None)
    pass_of = main_scenario()
    workers = Workers()
    page = explore_page(
        bench.knobs(pass_of, start),
        presets=bench.PRESETS,
        downloads=bench.DOWNLOADS,
        quantities=bench.COLOURS,
    )

    def typed() -> list[str]:
        return [f"{key}={value}" for key, value in request.args.items() if key not in OF_THE_PAGE]

    policy = content_policy(page)

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
        """Add the headers that limit a browser to the page's own script and this server."""
        response.headers["Content-Security-Policy"] = policy
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Cache-Control"] = "no-store"
        return response

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
        """Answer with a file of the run."""
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


def meant_for(header: str, host: str, port: str) -> bool:
    """Return whether a Host header names this server: this machine or its host, with its port.

    A server that listens on every address of the machine may be called by any address, since an
    address cannot be made to point elsewhere.
    """
    try:
        named = urlsplit(f"//{header}")
        name = named.hostname or ""
        same_port = str(named.port or 80) == port
    except ValueError:
        return False
    return same_port and (
        name in (*NAMES, host.lower()) or (host in ("0.0.0.0", "::") and _is_address(name))
    )


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def content_policy(page: str) -> str:
    """Return the policy by which a browser runs only the page's own script and requests only this
    server.
    """
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
    """Return a listening server of the bench, which answers each request in a thread of its own.

    Raises:
        OSError: if it cannot listen on the host and port.
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
    """Request handler without a log line for each request, and with the timeout READ_TIMEOUT."""

    timeout = READ_TIMEOUT

    def log(self, type: str, message: str, *args: Any) -> None:
        """Write nothing."""


def serve(start: Sequence[str] = ()) -> str:
    """Serve the bench from a thread of this process, and return its address.

    Raises:
        ValueError: for a refused value.
    """
    serving = server(start)
    threading.Thread(target=serving.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{serving.server_port}/"
