"""``lcpflex warmup``, ``lcpflex warmup --target x86-64 --into FOLDER``."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from lcpflex.basics import libs
from lcpflex.cli import later
from lcpflex.errors import ModelError, shown
from lcpflex.jit import private
from lcpflex.jit.cache_folders import unsafe, use_only, writable

__all__ = ["add_warmup", "fill", "warm"]

FILL = "import sys; from lcpflex.cli.warmup import fill; sys.exit(fill(sys.argv[1]))"


def add_warmup(commands: Any) -> None:
    """Add the command to the subparsers ``commands``."""
    command = commands.add_parser(
        "warmup",
        help="compile every kernel into the cache, once for this machine",
        description="Compile every kernel into the cache, once for this machine; or into a folder, for this machine or "
        "for all processors of a kind. Such a folder serves wherever LCPFLEX_CACHE_PATH names it, or in the package "
        "as lcpflex/kernels, with the same lcpflex, numba, llvmlite and Python; others compile as without it.",
    )
    command.add_argument("--into", type=Path, metavar="FOLDER", help="fill this folder, with all kernels, instead")
    command.add_argument("--target", metavar="CPU", help="x86-64 (all of them) or x86-64-v3 (with AVX2); with --into")
    command.set_defaults(command=_warmup)


def _warmup(request: argparse.Namespace) -> int:
    if request.into is None:
        if request.target is not None:
            raise ModelError(f"--target: {shown(request.target)} was given without --into, expected a folder to fill")
        return warm()
    environment = dict(os.environ)
    if request.target is not None:
        _check_target(request.target)
        environment |= {"NUMBA_CPU_NAME": request.target, "NUMBA_CPU_FEATURES": ""}
    folder = _checked_folder(request.into)
    # numba takes its processor from the environment when it is imported, which has happened here
    return subprocess.run([sys.executable, "-c", FILL, str(folder)], env=environment).returncode


def _check_target(target: str) -> None:
    """Raise ModelError for a kind of processor that is none, or that this machine cannot stand in for."""
    if target not in later.LEVELS:
        raise ModelError(f"--target: {shown(target)}, expected one of {', '.join(later.LEVELS)}")
    if reason := private.why_not_thin():
        raise ModelError(f"--target: {target} was given, expected none, for kernels are linked by numba: {reason}")
    triple = libs.llvm.get_process_triple()
    present = {name for name, has in libs.llvm.get_host_cpu_features().items() if has}
    missing = later.LEVELS[target] - present if triple.startswith("x86_64") else {"that it is x86-64"}
    if missing:
        raise ModelError(
            f"--target: {target} was given, expected a processor that this one can stand in for: it runs the kernels "
            f"that it compiles, and lacks {', '.join(sorted(missing))}"
        )


def _checked_folder(folder: Path) -> Path:
    """The folder, made if need be; ModelError where kernels cannot be kept there, or would not be read."""
    folder = folder.expanduser().absolute()
    if not writable(folder):
        raise ModelError(f"--into: {shown(str(folder))}, expected a folder that can be written to")
    if reason := unsafe(folder):
        raise ModelError(f"--into: {shown(str(folder))}, expected a folder that others cannot change: {reason}")
    return folder


def fill(folder: str) -> int:
    """Compile every kernel into one folder, whatever others have."""
    use_only(Path(folder))
    return warm()


def warm() -> int:
    """Compile the kernels that are listed, then run short scenes that find the others; the exit code."""
    start = perf_counter()
    if not private.why_not_thin():
        later.compile_all_listed(partial(libs.tqdm, desc="compiling", unit="kernel"))
    with libs.tqdm(later.warmup_cases(), desc="trying", unit="scene") as bar:
        for case in bar:
            bar.set_postfix_str(f"{case.name}, {type(case.stepper).__name__}")
            later.simulate(case.build(), case.duration, case.stepper, progress=False, project=True)
    if not private.why_not_thin():
        later.compile_all()
    if later.lost:
        print(f"{len(later.lost)} kernels were compiled and could not be kept; {perf_counter() - start:.1f} s")
        return 1
    print(f"every kernel is in the cache; {perf_counter() - start:.1f} s")
    return 0
