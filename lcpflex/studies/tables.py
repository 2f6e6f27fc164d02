"""Tables of studies in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["aligned_table", "failed"]

SHOWN = 60  # characters of a reason


def aligned_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of Markdown with columns of one width, to be read as it is, too."""
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    return "\n".join(
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |"
        for row in (head, ["-" * width for width in widths], *rows)
    )


def failed(failure: str) -> str:
    """Why a run failed, short enough for a cell; empty if it did not."""
    reason = " ".join(failure.replace("|", "/").split())
    return f"failed: {reason[:SHOWN]}{'...' if len(reason) > SHOWN else ''}" if reason else ""
