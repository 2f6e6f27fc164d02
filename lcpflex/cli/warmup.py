"""``lcpflex warmup``: every kernel into the cache, once for this machine."""

from __future__ import annotations

import argparse
from time import perf_counter
from typing import Any

from lcpflex.basics import libs
from lcpflex.cli import later

__all__ = ["add_warmup"]


def add_warmup(commands: Any) -> None:
    """Add the command to the subparsers."""
    warmup = commands.add_parser("warmup", help="compile every kernel into the cache, once for this machine")
    warmup.set_defaults(command=_warmup)


def _warmup(request: argparse.Namespace) -> int:
    """Run short scenes that between them use every kernel."""
    start = perf_counter()
    with libs.tqdm(later.warmup_cases(), desc="compiling", unit="scene") as bar:
        for case in bar:
            bar.set_postfix_str(f"{case.name}, {type(case.stepper).__name__}")
            later.simulate(case.build(), case.duration, case.stepper, progress=False, project=True)
    if later.lost:
        print(f"{len(later.lost)} kernels were compiled and could not be kept; {perf_counter() - start:.1f} s")
        return 1
    print(f"every kernel is in the cache; {perf_counter() - start:.1f} s")
    return 0
