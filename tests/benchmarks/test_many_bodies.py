"""Scenes of many bodies under one rule: compiling them, and finding their contacts, with 300 to 10,000 discs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.contact.detection import contact_table, detect
from lcpflex.contact.rule_pairs import rule_pairs
from lcpflex.jit.struct import pack
from tests.rates import rate

SIZES = (300, 1000, 3000, 10_000)


def discs(n: int) -> lf.Scene:
    """A loose heap in a box: radii scattered by 2 %, neighbours a little apart."""
    rng = np.random.default_rng(n)
    side = math.ceil(math.sqrt(n))
    scene = lf.Scene()
    for point, normal in (((0.0, 0.0), (0.0, 1.0)), ((0.0, 0.0), (1.0, 0.0)), ((0.1 * side + 0.02, 0.0), (-1.0, 0.0))):
        scene.ground.half_plane(point, normal)
    for k in range(n):
        radius = 0.05 * (1.0 - 0.02 * rng.uniform())
        scene.add(lf.Disc(radius, density=1000.0), position=(0.051 + 0.1 * (k % side), 0.051 + 0.1 * (k // side)))
    scene.contact_all(friction=0.5)
    return scene


def least(job: Callable[[], object], rounds: int = 5) -> float:
    """Seconds of the fastest of some runs."""
    seconds = []
    for _ in range(rounds):
        began = time.perf_counter()
        job()
        seconds.append(time.perf_counter() - began)
    return min(seconds)


@pytest.mark.benchmark(group="many bodies")
def test_compiling_scenes(benchmark: Callable[[Callable[[], object]], object], report: Callable[[str], None]) -> None:
    scenes = [discs(n) for n in SIZES]
    scenes[0].compile()
    seconds = [least(scene.compile, 3) for scene in scenes]
    benchmark(scenes[0].compile)
    told = ", ".join(f"{1e3 * spent:.0f} ms of {n}" for n, spent in zip(SIZES, seconds, strict=True))
    report(f"compiling discs in a box: {told}; grows with the power {float(rate(SIZES, seconds)):.2f}")


@pytest.mark.benchmark(group="many bodies")
def test_finding_contacts(benchmark: Callable[[Callable[[], object]], object], report: Callable[[str], None]) -> None:
    jobs: list[Callable[[], object]] = []
    for n in SIZES:
        made = discs(n).compile()
        model = pack(made.model)
        table = contact_table(4 * n, n + 3, pairs=rule_pairs(made.model.contacts), touching=-math.inf)
        q = made.q.copy()
        assert n < detect(model, q, 0.003, table) < 4 * n
        jobs.append(lambda model=model, q=q, table=table: detect(model, q, 0.003, table))  # type: ignore[misc]
    seconds = [least(job) for job in jobs]
    benchmark(jobs[0])
    told = ", ".join(f"{1e3 * spent:.2f} ms of {n}" for n, spent in zip(SIZES, seconds, strict=True))
    report(f"contacts of discs in a box: {told}; grows with the power {float(rate(SIZES, seconds)):.2f}")
