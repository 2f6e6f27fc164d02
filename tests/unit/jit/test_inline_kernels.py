"""Kernels that are declared as inline: their code is copied into each caller, whatever LLVM thinks of it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from lcpflex.jit.kernel_file import KernelFile
from tests.unit.jit.tiny_kernels import jobs, package

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are started in another way")

INLINE = """
import math
from lcpflex.jit.kernel import kernel

@kernel(inline=INLINE)
def held(x):
    total = 0.0
    for i in range(7):
        total += math.exp(math.sin(x * i)) / (1.0 + i)
    return total

@kernel
def calls(x):
    return held(x) + held(2.0 * x)
"""


def test_an_inline_kernel_is_copied_however_large_it_is(tmp_path: Path) -> None:
    """Its callers need no symbol of it; declared otherwise they call it, and their numbers are the same."""
    sources, needs, values = package(tmp_path / "sources"), [], []
    for inline in (False, True):
        path = sources / f"tiny_inline_{inline}.py"
        path.write_text(INLINE.replace("INLINE", str(inline)))
        before = f"from lcpflex.tiny_inline_{inline} import calls\n"
        cache = tmp_path / str(inline)
        runs, _ = jobs(sources, {"cache": str(cache), "before": before, "value": "calls(0.3)"})
        files = [KernelFile.unpacked(kept.read_bytes(), kept.stem) for kept in cache.iterdir()]
        needs.append(sum(len(file.needs) for file in files if file is not None and file.entry))
        values.append(runs[0]["value"])
    assert needs == [1, 0]
    assert values[0] == values[1]
