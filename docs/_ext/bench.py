"""The directive ``{bench}``: set knobs of the bench, and show its answer, and its page as Chromium draws it.

    ```{bench}
    :set: hub_speed=3000rpm
    :picture: yes
    :radial: yes
    ```

Without playwright and a Chromium the picture is left out.
"""

import functools
import shutil
import threading
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from bristle_sim.cli.explore import bench, searches
from bristle_sim.cli.explore.server import Server
from bristle_sim.cli.scenario import assigned, main_scenario

SIZE = {"width": 1280, "height": 820}

PATIENCE = 600_000
"""Longest wait for the page, ms. Alone the machine takes 8 s for it; the tests run beside the build."""


@functools.cache
def served() -> int:
    """Serve the bench until the build ends, and return the port: its processes load the libraries once for all pictures."""
    serving = Server()
    threading.Thread(target=serving.serve_forever, daemon=True).start()
    return serving.server_port


def picture(assignments: list[str], path: Path) -> bool:
    """Write the page of the bench as a browser shows it, and return whether that was possible."""
    chromium = next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
    )
    try:
        from playwright.sync_api import sync_playwright
    except ModuleNotFoundError:
        return False
    if chromium is None:
        return False
    query = urlencode([tuple(each.split("=", 1)) for each in assignments])
    with sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=chromium, args=["--no-sandbox", "--disable-background-networking"]
        )
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(PATIENCE)
        page.goto(f"http://127.0.0.1:{served()}/?{query}")
        page.wait_for_selector("#legend span")  # of the map, which comes last
        page.screenshot(path=str(path))
        browser.close()
    return True


class BenchDirective(SphinxDirective):
    """Shows what the bench shows."""

    option_spec = {  # noqa: RUF012 - docutils reads it from the class
        "set": directives.unchanged,
        "picture": directives.flag,
        "radial": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        """Return the address, the answer, and the picture if one is requested; nothing if no example runs."""
        if self.config.nb_execution_mode == "off":
            return []
        pass_of = main_scenario()
        typed = assigned("set", self.options.get("set", "").split())
        if "radial" in self.options:
            typed |= searches.radial_bar(pass_of, typed)["assignments"]
        assignments = [f"{key}={value}" for key, value in typed.items()]
        found = bench.run_of(pass_of, typed, {})
        address = "/?" + "&".join(assignments) if assignments else "/"
        shown: list[nodes.Node] = [nodes.literal_block(address, address, language="text")]
        shown.append(nodes.paragraph(text=found["answer"], classes=["answer"]))
        if "picture" in self.options:
            name = (
                "bench_"
                + "_".join(each.replace("=", "_") for each in assignments or ["start"])
                + ".png"
            )
            made = Path(self.env.srcdir) / "_made" / name
            made.parent.mkdir(exist_ok=True)
            if made.exists() or picture(assignments, made):
                uri = f"/_made/{name}"
                shown.append(nodes.image(uri=uri, alt=f"The bench: {found['answer']}"))
        return shown


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("bench", BenchDirective)
    return {"parallel_read_safe": False}
