# SPDX-License-Identifier: Apache-2.0
"""A progress line on the terminal."""

from __future__ import annotations

from types import TracebackType

from ._core import Progress


class ProgressBar:
    """Shows the fraction done, the smallest angle and the time left, if standard error is a terminal."""

    def __init__(self) -> None:
        try:
            from rich.console import Console
            from rich.progress import BarColumn, SpinnerColumn, TextColumn
            from rich.progress import Progress as Bar
        except ImportError as error:
            raise ImportError("progress=True needs the package rich: pip install rich") from error
        console = Console(stderr=True)
        self._bar = Bar(
            SpinnerColumn(),
            TextColumn("tetune"),
            BarColumn(bar_width=20),
            TextColumn("{task.description}"),
            console=console,
            disable=not console.is_terminal,
            transient=True,
        )
        self._task = self._bar.add_task("loading", total=1.0)

    def __enter__(self) -> ProgressBar:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def __call__(self, p: Progress) -> bool:
        left = "" if p.seconds_left < 0 else f", {p.seconds_left:.0f} s left"
        self._bar.update(
            self._task,
            completed=p.fraction,
            description=f"{100 * p.fraction:.0f} %  {p.phase}, sweep {p.iteration}, {p.worst_angle:.1f} degrees{left}",
        )
        return True
