"""What a user waits for before the first step: import, the first call with an empty cache and with a filled one."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

MAIN_JOB = """
import json, time
began = time.perf_counter()
import lcpflex as lf
imported = time.perf_counter()
from lcpflex import gallery
first = lf.simulate(gallery.pendulum(), 1e-3, lf.MoreauJean(step=1e-5), progress=False)
done = time.perf_counter()
print(json.dumps({"import": imported - began, "first": done - imported}))
"""


def fresh_process(cache: Path) -> dict[str, float]:
    """Seconds of the import and of the first run of a new interpreter."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", MAIN_JOB]
    shown = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(shown.stdout)
    return found


def test_first_call(benchmark: Any, report: Callable[[str], None], tmp_path: Path) -> None:
    cold = fresh_process(tmp_path)
    cached: list[dict[str, float]] = []
    benchmark.pedantic(lambda: cached.append(fresh_process(tmp_path)), rounds=5)
    median = {name: statistics.median(run[name] for run in cached) for name in ("import", "first")}
    report(f"import lcpflex                             {1e3 * median['import']:11.1f} ms")
    report(f"first run of the pendulum, empty cache     {1e3 * cold['first']:11.1f} ms")
    report(f"first run of the pendulum, filled cache    {1e3 * median['first']:11.1f} ms")
    benchmark.extra_info["milliseconds"] = {"cold": 1e3 * cold["first"], **{k: 1e3 * v for k, v in median.items()}}
    assert cold["first"] >= 5.0 * median["first"]
