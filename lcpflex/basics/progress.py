"""Bars that show how far a run or a study has come."""

from __future__ import annotations

from typing import Any

from lcpflex.basics import libs

__all__ = ["progress_bar"]


def progress_bar(progress: bool | None, **options: Any) -> Any:
    """A bar of tqdm: True shows it, False does not, None does on a terminal, after two seconds."""
    return libs.tqdm(delay=0.0 if progress else 2.0, disable=None if progress is None else not progress, **options)
