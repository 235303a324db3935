# SPDX-License-Identifier: Apache-2.0
"""What the report of a run says on criteria, targets and warnings, as texts for the tables of the page."""

from __future__ import annotations

from typing import Any

# Volumes that differ by more than this factor are rarely those of one part.
UNRELATED_VOLUMES = 2.0


def _number(value: float | None, absent: str) -> str:
    return absent if value is None else f"{value:.6g}"


def _judged(result: dict[str, Any]) -> str:
    """The result of one criterion on one mesh."""
    if result["count"] == 0:
        return f"{result['verdict']}: there is nothing to measure"
    missed = [
        f"{result[key]:,} of {result['count']:,} {word}"
        for key, word in (("failed", "fail"), ("warned", "warn"))
        if result[key] > 0
    ]
    # JSON has null for numbers that are not finite.
    worst = f"worst {_number(result['worst'], 'not finite')}"
    return f"{result['verdict']}: {', '.join([*missed, worst])}"


def acceptance(run: dict[str, Any] | None) -> dict[str, Any] | None:
    """The verdict, and a row for each criterion; None for a run without criteria."""
    judged = None if run is None else run.get("acceptance")
    if judged is None:
        return None
    before, after = judged["before"], judged["after"]
    rows = [
        (
            now["measure"],
            _number(now["warn"], "none"),
            _number(now["fail"], "none"),
            f"{now['allowed_percent']:.4g} %",
            _judged(then),
            _judged(now),
        )
        for then, now in zip(before["results"], after["results"])
    ]
    notes = [f"no rounds of work on what fails, as {judged['no_rounds']}"] if "no_rounds" in judged else []
    if run is not None and run.get("after", {}).get("curved"):
        notes.append("criteria judge tetrahedra with straight edges")
    verdicts = before["verdict"], after["verdict"]
    return {"criteria": after["criteria"], "verdicts": verdicts, "rows": rows, "notes": notes}


def targets(run: dict[str, Any] | None) -> list[tuple[str, str, str, str, str]]:
    """A row for each target."""
    if run is None:
        return []
    return [
        (
            t["measure"],
            f"{t['value']:.6g}",
            "met" if t["met"] else "missed",
            f"{t['missed']:,} of {t['tetrahedra']:,}",
            ", ".join(f"{why} ({n:,})" for why, n in t["held_by"].items() if n > 0),
        )
        for t in run["optimization"].get("targets", [])
    ]


def warnings(run: dict[str, Any] | None, volumes: tuple[float, float]) -> list[str]:
    """Those of the run, and one on meshes that are hardly of one part."""
    texts = [] if run is None else list(run.get("warnings", []))
    small, large = sorted(volumes)
    if large > UNRELATED_VOLUMES * small:
        texts.append(
            f"The volumes differ by more than a factor of {UNRELATED_VOLUMES:g} ({volumes[0]:.6g} before, "
            f"{volumes[1]:.6g} after): check that both files are meshes of the same part, in the same unit."
        )
    return texts
