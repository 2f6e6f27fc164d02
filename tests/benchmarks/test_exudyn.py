"""The flexible pendulum on its round stop against Exudyn's ANCF cable with penalty contact."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable, Mapping
from functools import partial
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery

PEER = Path(__file__).parent / "peers" / "exudyn_pendulum.py"
STEP = 1e-4
END = 0.456
WINDOW = 0.05
# The motion after the impact is sensitive to the step, and one run may be lucky: the error is the root mean square over
# runs with steps about STEP. Impulses in N s.
SHARES = (0.94, 0.96, 0.98, 1.0, 1.02, 1.04, 1.06)
PEER_CONVERGED = 0.669  # mean of six runs of the peer with steps from 1e-6 to 2e-6 s; they scatter by 0.014


def own_run(scene: lf.Scene, step: float) -> tuple[float, float]:
    """Seconds per step, and the impulse in the 50 ms after the first touch."""
    result = lf.simulate(scene, END, lf.MoreauJean(step=step), progress=False)
    impulse = np.hypot(*result.impulse[:, 0].T)
    touch = result.times[np.argmax(impulse > 0.0)]
    return result.wall_time / result.steps, float(np.interp(touch + WINDOW, result.times, impulse))


def peer_run(step: float) -> tuple[float, float]:
    """The same of Exudyn."""
    command = [sys.executable, "-W", "ignore", str(PEER), str(step), str(END)]
    found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[-1])
    return found["seconds"] / found["steps"], found["impulse"]


def test_pendulum_is_twenty_times_faster_at_equal_error(
    interleave: Callable[..., Mapping[str, float]], report: Callable[[str], None]
) -> None:
    if importlib.util.find_spec("exudyn") is None:
        pytest.skip("exudyn is not installed (pip install exudyn)")
    scene = gallery.pendulum(friction=0.0)
    impulses: dict[str, list[float]] = {"own": [], "peer": []}

    def contestant(name: str, run: Callable[[float], tuple[float, float]]) -> Callable[[], float]:
        steps = cycle(STEP * share for share in SHARES)

        def seconds() -> float:
            taken, impulse = run(next(steps))
            impulses[name].append(impulse)
            return taken

        return seconds

    contestants = {
        "pendulum, step 1e-4": contestant("own", partial(own_run, scene)),
        "Exudyn, step 1e-4": contestant("peer", peer_run),
    }
    medians = interleave(contestants, rounds=2 * len(SHARES))
    own_converged = own_run(scene, 1e-6)[1]
    error = {
        name: float(np.sqrt(np.mean((np.array(impulses[name][: len(SHARES)]) / exact - 1.0) ** 2)))
        for name, exact in (("own", own_converged), ("peer", PEER_CONVERGED))
    }
    report(f"error of the impulse: {error['own']:.3f} (of {own_converged:.4f} N s), Exudyn {error['peer']:.3f}")
    own, peer = medians.values()
    assert error["own"] <= error["peer"]
    assert peer >= 20.0 * own
