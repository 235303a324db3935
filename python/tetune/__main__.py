# SPDX-License-Identifier: Apache-2.0
"""The command line: the program in the wheel, and the report, which is written in Python."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = Path(__file__).parent / "bin" / "tetune"


def _wants_page(words: list[str]) -> bool:
    """Whether --report-html is among the words, with one dash or two, its value behind it or in it."""
    options = words[: words.index("--")] if "--" in words else words
    return any(w.lstrip("-").split("=")[0] == "report-html" for w in options if w.startswith("-"))


def _run_program(words: list[str], environment: dict[str, str]) -> int:
    """Runs the program and returns its exit code. It gets each SIGINT and SIGTERM once, on which it writes the mesh so far,
    and SIGHUP: in a session of its own it does not get those of the terminal."""
    with subprocess.Popen([PROGRAM, *words], env=environment, start_new_session=True) as process:
        before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
        for number, handler in before.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, lambda number, _: process.send_signal(number))
        code = process.wait()
    for number, handler in before.items():
        signal.signal(number, handler)
    return code if code >= 0 else 128 - code  # of a signal, as shells have it


def _run_with_page(words: list[str]) -> int:
    """Runs the program, which checks the name of the page with those of its other files, and then writes the page."""
    from .report._page import plotly_script
    from .report.__main__ import write_report

    try:
        plotly_script()
    except ImportError as error:
        print(f"tetune: --report-html: {error}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "run.json"
        done = _run_program(words, {**os.environ, "TETUNE_PAGE_DATA": str(data)})
        if not data.exists():  # no mesh was written, or that of --dry-run
            return done
        run = json.loads(data.read_text(encoding="utf-8"))
    failed = write_report(run["input"], run["output"], run["page"], run)
    # As for the program's other reports: the mesh was written.
    return 1 if failed else done


def main() -> int:
    words = sys.argv[1:]
    if words[:1] == ["report"]:
        from .report.__main__ import main as report

        return report(words[1:])
    if words[:1] in (["optimize"], ["move"]) and _wants_page(words):
        return _run_with_page(words)
    os.execv(PROGRAM, ["tetune", *words])


if __name__ == "__main__":
    sys.exit(main())
