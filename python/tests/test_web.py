# SPDX-License-Identifier: Apache-2.0
"""The page that optimizes in the browser: its file is the command line's."""

import shutil
import subprocess

import pytest

from meshes import BRACKET, ROOT


@pytest.mark.parametrize("options", [["preserve", "fast"], ["slide", "standard"]])
def test_in_a_browser(options, tmp_path):
    sync = pytest.importorskip("playwright.sync_api")
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None or shutil.which("em++") is None:
        pytest.skip("chromium or emscripten is not installed: apt-get install chromium emscripten")
    made = subprocess.run([ROOT / "scripts" / "web", tmp_path / "page"], capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr
    page = tmp_path / "page" / "index.html"
    assert page.stat().st_size < 2e6
    from tetune.__main__ import PROGRAM

    expected = tmp_path / "expected.meshb"
    boundary, effort = options
    words = ["optimize", BRACKET, "-o", expected, "--boundary", boundary, "--effort", effort, "--quiet"]
    assert subprocess.run([PROGRAM, *words]).returncode == 0
    with sync.sync_playwright() as p:
        browser = p.chromium.launch(
            executable_path=chromium, args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        tab = browser.new_page(viewport={"width": 1300, "height": 1000})
        tab.set_default_timeout(60_000)
        errors, requests = [], []
        tab.on("pageerror", lambda e: errors.append(str(e)))
        tab.on("request", lambda r: requests.append(r.url))
        tab.goto(page.as_uri())
        tab.wait_for_selector("html[data-ready=true]", state="attached")
        tab.locator("#file").set_input_files(BRACKET)
        tab.wait_for_selector("#start:enabled")
        tab.locator("#boundary").select_option(boundary)
        tab.locator("#effort").select_option(effort)
        tab.locator("#start").click()
        tab.wait_for_selector("#downloads a")
        with tab.expect_download() as download:
            tab.locator("#downloads a").first.click()
        assert download.value.path().read_bytes() == expected.read_bytes()
        assert tab.locator("#worst1 tbody tr").count() == 8
        tab.locator("#worst1 button").first.click()
        tab.locator("#whole").click()
        tab.screenshot(path=tmp_path / "page.png", full_page=True)
        browser.close()
    assert errors == []
    assert [r for r in requests if not r.startswith(("file:", "data:", "blob:"))] == []
