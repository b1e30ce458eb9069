"""The bench's server. Each request carries the whole state, so that several users share none."""

from __future__ import annotations

import contextlib
import io
import multiprocessing
import threading
from collections.abc import Sequence
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from flask import Flask, Response, jsonify, request
from werkzeug.serving import BaseWSGIServer, WSGIRequestHandler, make_server

from bristle_sim.cli.command import whole_pass
from bristle_sim.cli.explore import bench
from bristle_sim.render.report import explore_page

GIVE_UP = 120.0
"""Longest time that a run may take, s; a wire of many links takes more."""

MOST_CLIENTS = 64
"""Slow runs at once; the server then refuses another."""


class SlowRuns:
    """Runs in processes of their own, where a client's newer run stops its older one."""

    def __init__(self) -> None:
        """Begin without a run."""
        self._running: dict[str, BaseProcess] = {}
        self._lock = threading.Lock()
        self._context = multiprocessing.get_context("spawn")

    def compute(self, client: str, start: Sequence[str], typed: Sequence[str]) -> dict[str, Any]:
        """Return the run, or its ``error`` in one line."""
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=_compute, args=(theirs, list(start), list(typed)), daemon=True)
        with self._lock:
            self.stop(client)
            if len(self._running) >= MOST_CLIENTS:
                return {"error": "the server is busy; try again in a minute"}
            self._running[client] = process
            process.start()
        theirs.close()
        try:
            found: dict[str, Any] = (
                ours.recv() if ours.poll(GIVE_UP) else {"error": f"not done in {GIVE_UP:g} s; take fewer links"}
            )
        except EOFError:
            found = {"error": "stopped by a newer run"}
        with self._lock:
            if self._running.get(client) is process:
                self.stop(client)
        return found

    def stop(self, client: str) -> None:
        """End the client's run, if there is one."""
        process = self._running.pop(client, None)
        if process is not None:
            process.terminate()


def _compute(pipe: Connection, start: list[str], typed: list[str]) -> None:
    pipe.send(bench.run_of(whole_pass(), start, typed))


def application(start: Sequence[str] = ()) -> Flask:
    """Return the bench as a web application that begins with the tool of these assignments.

    Raises:
        ValueError: for values that are refused.
    """
    app = Flask("bristle_sim.cli.explore", static_folder=None)
    pass_of, slow = whole_pass(), SlowRuns()
    page = explore_page(bench.knobs(pass_of, start))

    def typed() -> list[str]:
        return [f"{key}={value}" for key, value in request.args.items() if key != "pin"]

    @app.get("/")
    def index() -> Response:
        return Response(page, mimetype="text/html")

    @app.get("/run")
    def run() -> Response:
        if bench.takes_seconds(pass_of, [*start, *typed()]):
            return jsonify(slow.compute(request.headers.get("X-Client", ""), start, typed()))
        return jsonify(bench.run_of(pass_of, start, typed()))

    @app.get("/radial")
    def radial() -> Response:
        return jsonify(bench.radial_bar(pass_of, [*start, *typed()]))

    @app.get("/download/<any(toml, json, csv, html):kind>")
    def download(kind: str) -> Response:
        try:
            text, media = bench.download(pass_of, kind, [*start, *typed()])
        except (ValueError, ArithmeticError) as error:
            return Response(" ".join(str(error).split()) + "\n", status=400, mimetype="text/plain")
        return Response(text, mimetype=media, headers={"Content-Disposition": f"attachment; filename=tool.{kind}"})

    return app


def server(start: Sequence[str] = (), *, host: str = "127.0.0.1", port: int = 0) -> BaseWSGIServer:
    """Return a server of the bench that listens, and answers each request from a thread of its own.

    Raises:
        OSError: if it cannot listen there.
        ValueError: for values that are refused.
    """
    taken = io.StringIO()
    try:
        with contextlib.redirect_stderr(taken):
            return make_server(host, port, application(start), threaded=True, request_handler=_Quiet)
    except SystemExit:  # werkzeug's answer to a port that is taken
        raise OSError(f"--host {host} --port {port}: {taken.getvalue().splitlines()[0]}") from None


class _Quiet(WSGIRequestHandler):
    """Answers requests without a log line for each."""

    def log(self, type: str, message: str, *args: Any) -> None:
        """Write nothing."""


def serve(start: Sequence[str] = ()) -> str:
    """Serve the bench from a thread of this process, and return its address.

    Raises:
        ValueError: for values that are refused.
    """
    serving = server(start)
    threading.Thread(target=serving.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{serving.server_port}/"
