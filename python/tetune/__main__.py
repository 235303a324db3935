# SPDX-License-Identifier: Apache-2.0
"""The command line: the program in the wheel, and the report, which is written in Python."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = Path(__file__).parent / "bin" / "tetune"


def _take_option(words: list[str], name: str) -> str | None:
    """Removes `NAME VALUE` or `NAME=VALUE` and returns the value."""
    for i, word in enumerate(words):
        if word == name and i + 1 < len(words):
            del words[i]
            return words.pop(i)
        if word.startswith(name + "="):
            return words.pop(i)[len(name) + 1 :]
    return None


def _optimize_with_page(words: list[str], page: str) -> int:
    from .report.__main__ import main as report

    words = [w for w in words if w != "--trace-angles"]
    with tempfile.TemporaryDirectory() as folder:
        figures = _take_option(words, "--report") or os.path.join(folder, "run.json")
        done = subprocess.run([PROGRAM, *words, "--trace-angles", "--report", figures]).returncode
        if done not in (0, 1):
            return done
        run = json.loads(Path(figures).read_text(encoding="utf-8")) if os.path.exists(figures) else {}
        if "optimization" not in run:  # no mesh was written: --untangle failed
            return done
        return report([run["input"], run["output"], "-o", page, "--run", figures]) or done


def main() -> int:
    words = sys.argv[1:]
    if words[:1] == ["report"]:
        from .report.__main__ import main as report

        return report(words[1:])
    page = _take_option(words, "--report-html") if words[:1] == ["optimize"] else None
    if page is not None:
        return _optimize_with_page(words, page)
    os.execv(PROGRAM, ["tetune", *words])


if __name__ == "__main__":
    sys.exit(main())
