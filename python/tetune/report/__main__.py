# SPDX-License-Identifier: Apache-2.0
"""`tetune report IN OUT -o report.html`."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from .. import Error, read_mesh
from ._page import check_page, write_page


def _run(path: str) -> dict[str, Any]:
    try:
        run = json.loads(Path(path).read_text(encoding="utf-8"))
    except ValueError:
        run = None
    if not isinstance(run, dict) or "optimization" not in run:
        raise Error(f"{path}: this is not what `tetune optimize --report FILE.json` writes; give that file, or drop --run")
    return run


def _refuse_replacing(page: str, read: list[str]) -> None:
    for name in read:
        if os.path.exists(page) and os.path.exists(name) and os.path.samefile(page, name):
            raise Error(f"{page} would be written, but is read as well; give another name")


def write_report(before: str, after: str, page: str, run: dict[str, Any] | None) -> int:
    """Writes the page of two files. Prints what prevents it, and returns an exit code."""
    try:
        check_page(page)
        write_page(page, read_mesh(before), read_mesh(after), names=(before, after), run=run)
    except (Error, OSError, ImportError) as error:
        print(f"tetune: {error}", file=sys.stderr)
        return 2
    return 0


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="tetune report",
        description="Writes one self-contained HTML page that shows a mesh before and after: figures, histograms, and "
        "both in 3D side by side, with a clipping plane and the worst elements. It opens offline in any browser.",
    )
    parser.add_argument("before", metavar="IN", help="mesh before")
    parser.add_argument("after", metavar="OUT", help="mesh after")
    parser.add_argument("-o", "--output", required=True, metavar="FILE.html", help="page to write")
    parser.add_argument(
        "--run", metavar="FILE.json",
        help="what `tetune optimize --report` wrote: adds convergence, flips and time of each phase",
    )
    args = parser.parse_args(words)
    try:
        run = None if args.run is None else _run(args.run)
        _refuse_replacing(args.output, [args.before, args.after, *([] if args.run is None else [args.run])])
    except (Error, OSError) as error:
        print(f"tetune: {error}", file=sys.stderr)
        return 2
    return write_report(args.before, args.after, args.output, run)


if __name__ == "__main__":
    sys.exit(main())
