"""The elastic bar on a wall against Siconos' Moreau-Jean: same bar, step, law of contact, and motion."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

import lcpflex as lf
from lcpflex.bodies.body import Body

PEER = Path(__file__).parent / "peers" / "siconos_bar.py"
PYTHON = os.environ.get("SICONOS_PYTHON", "/usr/bin/python3")  # Debian's package serves the system's interpreter
SPEED = 0.1


def siconos(elements: int, steps: int, warm: int) -> dict[str, Any]:
    """What the peer reports."""
    command = [PYTHON, str(PEER), str(elements), str(steps), str(warm)]
    found: dict[str, Any] = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return found


@pytest.fixture(scope="module", autouse=True)
def _installed() -> None:
    try:
        subprocess.run([PYTHON, "-c", "import siconos.kernel"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip(f"no siconos in {PYTHON} (Debian: apt install python3-siconos; or set SICONOS_PYTHON)")


def bar_on_wall(bar: Body, gap: float) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    placed = scene.add(bar, name="bar", position=(gap, 0.0), velocity=(-SPEED, 0.0))
    scene.contact(placed.node(0.0, 0.0), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)), name="wall")
    return scene


@pytest.mark.parametrize(("elements", "steps", "warm"), [(100, 200, 5), (1000, 40, 3)])
def test_bar_is_twenty_times_faster(
    interleave: Callable[..., Mapping[str, float]], elements: int, steps: int, warm: int
) -> None:
    material = lf.Bar(length=1.0, area=3.14e-4, density=7800.0, youngs_modulus=210e9, elements=elements)
    bar = material.reduce(modes=None)
    peer = siconos(elements, steps, warm)
    step, gap = peer["step"], peer["gap"]

    def ours() -> float:
        result = lf.simulate(
            bar_on_wall(bar, gap), (steps + warm) * step, lf.MoreauJean(step=step), record=step * steps, progress=False
        )
        assert result.impulse[-1, 0, 0] == pytest.approx(peer["impulse"], rel=0.02)  # one step more or less in contact
        return result.wall_time / result.steps

    def theirs() -> float:
        seconds: list[float] = siconos(elements, steps, warm)["seconds"]
        return statistics.median(seconds)

    medians = interleave({f"bar, {elements} elements": ours, f"Siconos, {elements} elements": theirs}, rounds=7)
    ours_, theirs_ = medians.values()
    assert theirs_ >= 20.0 * ours_
