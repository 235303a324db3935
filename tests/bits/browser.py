# SPDX-License-Identifier: Apache-2.0
"""The page of scripts/web in a browser, from a disk with one thread and from a server with several: its files are those
of the command line, and nothing else is requested.

python3 tests/bits/browser.py COMMAND ...    the words that start the command line; exit code 1 on a difference
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

from page_server import served

ROOT = pathlib.Path(__file__).parents[2]
BRACKET = ROOT / "data" / "bracket.meshb"


def optimize_in(tab, url, mesh, boundary, effort):
    """The bytes of the file that the page offers."""
    tab.goto(url)
    tab.wait_for_selector("html[data-ready=true]", state="attached")
    tab.locator("#file").set_input_files(mesh)
    tab.wait_for_selector("#start:enabled")
    tab.locator("#boundary").select_option(boundary)
    tab.locator("#effort").select_option(effort)
    tab.locator("#start").click()
    with tab.expect_download() as download:
        tab.locator("#downloads a").first.click()
    return download.value.path().read_bytes()


def expect_same(tab, url, folder, command):
    for boundary, effort in (("preserve", "fast"), ("slide", "standard")):
        expected = folder / "expected.meshb"
        words = ["optimize", BRACKET, "-o", expected, "--boundary", boundary, "--effort", effort, "--threads", "1", "--quiet"]
        subprocess.run([*command, *words], check=True)
        same = optimize_in(tab, url, BRACKET, boundary, effort) == expected.read_bytes()
        assert same, f"the page's file differs from the command line's: {url}, {boundary}, {effort}"


def watched(tab):
    """Errors of the page, and addresses that it requests."""
    errors, requests = [], []
    tab.set_default_timeout(60_000)
    tab.on("pageerror", lambda e: errors.append(str(e)))
    tab.on("request", lambda r: requests.append(r.url))
    return errors, requests


def check_served(tab, folder, command):
    errors, requests = watched(tab)
    with served(folder) as home:
        tab.goto(home)
        tab.wait_for_function("crossOriginIsolated")  # the page has been loaded again
        # A forced reload passes over the service worker, which is active.
        tab.evaluate("() => { window.before = true; }")
        tab.context.new_cdp_session(tab).send("Page.reload", {"ignoreCache": True})
        tab.wait_for_function("crossOriginIsolated && !window.before")
        expect_same(tab, home, folder, command)
    threads = tab.evaluate("navigator.hardwareConcurrency")
    assert threads == 1 or f"with {threads} threads" in tab.locator("#status").text_content()
    assert errors == [], errors
    assert [r for r in requests if not r.startswith((home, "data:", "blob:"))] == [], requests


def check_links(tab):
    """The page keeps no file that it no longer offers, and of two sets of files that are opened at once the second."""
    link = tab.locator("#downloads a").first.get_attribute("href")
    works = "(link) => fetch(link).then((answer) => answer.ok, () => false)"
    assert tab.evaluate(works, link)
    tab.evaluate("""() => {
      const open = (...names) => {
        const files = new DataTransfer();
        names.forEach((name) => files.items.add(new File(["no mesh\\n"], name)));
        dispatchEvent(new DragEvent("drop", { dataTransfer: files }));
      };
      open("first.node", "first.ele");
      open("second.mesh");
    }""")
    tab.get_by_text("second.mesh:1: this is not a MEDIT mesh").wait_for()
    assert not tab.evaluate(works, link)


def check_on_disk(tab, folder, command):
    errors, requests = watched(tab)
    expect_same(tab, (folder / "index.html").as_uri(), folder, command)
    assert tab.locator("#worst1 tbody tr").count() == 8
    tab.locator("#worst1 button").first.click()
    tab.locator("#whole").click()
    tab.locator("#effort").select_option("best")
    tab.locator("#start").click()
    tab.locator("#cancel").click()
    tab.get_by_text("Canceled.").wait_for()
    tab.wait_for_selector("#start:enabled")
    tab.locator("#effort").select_option("fast")
    tab.locator("#start").click()
    tab.wait_for_selector("#downloads a")
    check_links(tab)
    bad = folder / "bad.mesh"
    bad.write_text("no mesh\n")
    tab.locator("#file").set_input_files(bad)
    tab.get_by_text("bad.mesh:1: this is not a MEDIT mesh").wait_for()
    assert errors == [], errors
    assert [r for r in requests if not r.startswith(("file:", "data:", "blob:"))] == [], requests


def main():
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        print("browser: skipped, not installed: playwright (pip install playwright)")
        return
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        print("browser: skipped, not installed: chromium")
        return
    if shutil.which("em++") is None:
        print("browser: skipped, not installed: em++ (Debian: emscripten)")
        return
    with tempfile.TemporaryDirectory() as name, sync_playwright() as p:
        folder = pathlib.Path(name)
        subprocess.run([ROOT / "scripts" / "web", folder], check=True, stdout=subprocess.DEVNULL)
        switches = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = p.chromium.launch(executable_path=chromium, args=switches)
        for check in (check_on_disk, check_served):
            check(browser.new_page(viewport={"width": 1300, "height": 1000}), folder, sys.argv[1:])
        browser.close()
    print("browser: the page's files are the command line's, with one thread and with several")


if __name__ == "__main__":
    main()
