# SPDX-License-Identifier: Apache-2.0
"""The documentation's site: built without a warning, without a dead link, and shown without a request to elsewhere."""

import functools
import html.parser
import http.server
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path
from urllib.parse import unquote, urldefrag

import pytest

from meshes import ROOT


class Links(html.parser.HTMLParser):
    """Anchors of a page and where it points to."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.targets = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.anchors |= {given.get("id"), given.get("name")}
        self.targets += [given[k] for k in ("href", "src") if k in given and not (tag == "link" and given.get("rel") == "canonical")]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("material")
    if shutil.which("doxygen") is None:
        pytest.skip("doxygen is not installed: apt-get install doxygen")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        cwd=ROOT, capture_output=True, text=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_every_link_leads_somewhere(site):
    pages = {p: Links(p.read_text(encoding="utf-8")) for p in site.rglob("*.html")}
    assert len(pages) > 25
    for page, links in pages.items():
        for target in links.targets:
            path, anchor = urldefrag(target)
            if path.startswith(("https://", "http://", "data:", "mailto:")) or page.name == "404.html":
                continue
            to = (page.parent / unquote(path)).resolve() if path else page
            assert to.exists(), f"{page.relative_to(site)}: {target}"
            assert not anchor or to not in pages or unquote(anchor) in pages[to].anchors, f"{page.relative_to(site)}: {target}"


def test_the_reference_is_whole(site):
    """Every name that the package exports, and every type and function of the headers."""
    import tetune

    python = Links((site / "api/python.html").read_text(encoding="utf-8")).anchors
    for name in set(tetune.__all__) - {"__version__"}:
        assert f"tetune.{name}" in python, name
    assert {"tetune.Options.boundary", "tetune.Report.compound_flips"} <= python
    cpp = {a for p in (site / "api/cpp").glob("*.html") for a in Links(p.read_text(encoding="utf-8")).anchors}
    assert {"optimize", "Options.max_deviation", "Boundary.slide", "TetMesh.ridges", "write_mesh", "LimitingConstraint.none"} <= cpp


def test_in_a_browser(site):
    sync = pytest.importorskip("playwright.sync_api")
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("chromium is not installed: apt-get install chromium")

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=site))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    home = f"http://127.0.0.1:{server.server_port}/"
    errors, requests = [], []
    with sync.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for scheme, width in (("light", 1300), ("dark", 400)):
            tab = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
            tab.set_default_timeout(120_000)
            tab.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
            tab.on("pageerror", lambda e: errors.append(str(e)))
            tab.on("request", lambda r: requests.append(r.url))
            for page in ("index.html", "method.html", "formats.html", "benchmarks/peers.html", "api/python.html", "api/cpp/optimize.html"):
                tab.goto(home + page)
                assert tab.evaluate("document.documentElement.scrollWidth") <= width, f"{page} is wider than {width}"
            assert tab.evaluate("document.body.dataset.mdColorScheme") == {"light": "default", "dark": "slate"}[scheme]
            tab.goto(home + "method.html")
            assert tab.locator("math").count() > 100 and "\\(" not in tab.locator("article").inner_text()
            if scheme == "light":
                tab.locator("input.md-search__input").click()
                tab.locator("input.md-search__input").press_sequentially("max_deviation")
                tab.wait_for_selector(".md-search-result__item")
        browser.close()
    server.shutdown()
    assert errors == []
    assert [r for r in requests if not r.startswith((home, "data:", "blob:"))] == []
