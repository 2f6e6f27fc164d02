"""A few kernels in a folder of their own that counts as part of the package, and jobs with them in fresh processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

LOW = """
import math
from lcpflex.jit.kernel import kernel

@kernel
def held(x, k):
    total = 0.0
    for i in range(7):
        total += math.exp(math.sin(x * i)) / (1.0 + k + i)
    return total

@kernel
def small(x):
    return 2.0 * x
"""
HIGH = """
from lcpflex.jit.kernel import kernel
from lcpflex.tiny_low import held, small

@kernel
def middle(x):
    return small(x) + held(x, 0)

@kernel
def top(x, n):
    return held(x, 0.0) + held(x, True) + held(x, n) + middle(x)
"""

# Each case runs in a process of its own: a fork of one that has numba and has compiled nothing.
JOBS = """
import json, os, sys, traceback
import numba
from numba.core import event
import lcpflex
from lcpflex.jit import private, thin
import lcpflex.jit.thin_dispatcher, lcpflex.jit.plain

folder, cases = sys.argv[1], json.loads(sys.argv[2])
lcpflex.__path__.append(folder)
thin.LARGEST = 20  # instructions: `held` is called, `small` is taken in
compiled = []

class Count(event.Listener):
    def on_start(self, found):
        compiled.append(found.data["dispatcher"].py_func.__name__)
    def on_end(self, found):
        pass

event.register("numba:compile", Count())

def run(case):
    os.environ["LCPFLEX_CACHE_PATH"] = case["cache"]
    exec(case.get("before", ""), globals())
    from lcpflex.tiny_high import top
    value = eval(case["value"]) if "value" in case else top(0.3, 2)
    return {"value": float(value).hex(), "compiled": compiled}

for case in cases:
    sys.stdout.flush()
    child = os.fork()
    if not child:
        try:
            print(json.dumps(run(case)), flush=True)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    if status:
        sys.exit(f"{case} ended with {status}")
"""


def package(folder: Path) -> Path:
    """The kernels as files in a folder."""
    folder.mkdir()
    (folder / "tiny_low.py").write_text(LOW)
    (folder / "tiny_high.py").write_text(HIGH)
    for path in folder.iterdir():
        os.utime(path, (1e9, 1e9))  # no source has changed since its import
    return folder


def jobs(folder: Path, *cases: dict[str, Any], **environment: str) -> tuple[list[dict[str, Any]], str]:
    """What the cases give, one after the other, and what they say.

    A case has ``cache``: folders; ``before``: what is run first; ``value``: an expression in place of ``top(0.3, 2)``.
    Each gives ``value``, to the bit, and ``compiled``, the names of kernels.
    """
    shown = subprocess.run(
        [sys.executable, "-c", JOBS, str(folder), json.dumps(cases)],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert shown.returncode == 0, shown.stderr
    return [json.loads(line) for line in shown.stdout.splitlines()], shown.stderr
