"""That scenes are declared and compiled in a time that follows their size: lines of Python that run, counted."""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable
from types import FrameType
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.rates import rate

LINEAR = 1.1
SIZES = (20, 80, 320)


def lines_run(work: Callable[[], object]) -> int:
    """How many lines of the library ``work`` runs, each turn of a loop and of a comprehension counted."""
    count = 0

    def trace(frame: FrameType, event: str, arg: Any) -> Any:
        nonlocal count
        if "lcpflex" not in frame.f_code.co_filename:
            return None
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        work()
    finally:
        sys.settrace(before)
    return count


def discs_on_floor(n: int) -> lf.Scene:
    """n discs beside each other, each declared against the floor."""
    scene = lf.Scene()
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k in range(n):
        disc = scene.add(lf.Disc(0.1, density=1.0), position=(0.3 * k, 0.2))
        scene.contact(disc.surface(), floor, friction=0.3)
    return scene


def chain(n: int) -> lf.Scene:
    """n links, hinged to each other."""
    scene = lf.Scene()
    end = scene.ground.at(0.0, 0.0)
    for k in range(n):
        link = scene.add(lf.Box(1.0, 0.1, density=1.0), position=(k + 0.5, 0.0))
        scene.join(lf.Revolute(link.at(-0.5, 0.0), end))
        end = link.at(0.5, 0.0)
    return scene


def loose_chain(n: int) -> lf.Scene:
    """n links, each with a pin in a hole of the one before, and a surface of its own beside."""
    scene = lf.Scene()
    end = scene.ground.at(0.0, 0.0)
    for k in range(n):
        link = scene.add(lf.Box(1.0, 0.1, density=1.0), position=(k + 0.5, 0.0))
        scene.revolute_with_clearance(link.at(-0.5, 0.0), end, 0.01, 0.02)
        link.circle((0.0, 0.0), 0.03)
        end = link.at(0.5, 0.0)
    return scene


SCENES = pytest.mark.parametrize("scene", [discs_on_floor, chain, loose_chain])


@SCENES
def test_a_scene_is_declared_in_a_time_that_follows_its_size(scene: Callable[[int], lf.Scene]) -> None:
    assert rate(SIZES, [lines_run(lambda n=n: scene(n)) for n in SIZES]) < LINEAR


@SCENES
def test_a_scene_is_compiled_in_a_time_that_follows_its_size(scene: Callable[[int], lf.Scene]) -> None:
    scene(1).compile()  # imports
    made = [scene(n) for n in SIZES]
    assert rate(SIZES, [lines_run(one.compile) for one in made]) < LINEAR


def test_a_chain_is_compiled_in_memory_that_follows_its_length() -> None:
    chain(1).compile()
    peaks = []
    for n in SIZES[1:]:
        one = chain(n)
        tracemalloc.start()
        one.compile()
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert rate(SIZES[1:], peaks) < LINEAR


def test_the_size_of_a_scene_is_that_of_its_largest_body_whatever_their_number_and_order() -> None:
    rng = np.random.default_rng(5)
    for _ in range(5):
        widths = rng.uniform(0.1, 2.0, 6)
        scene = lf.Scene()
        for k, width in enumerate(widths):
            box = scene.add(lf.Box(width, 0.1, density=1.0), position=(10.0 * k, 0.0))
            if k % 2:
                box.at(0.0, 0.0)
        disc = scene.add(lf.Disc(0.7 * float(rng.uniform()), density=1.0), position=(0.0, 20.0))
        assert scene.compile().size == max([*widths, 2.0 * disc.surface().shape.radius])


@pytest.mark.parametrize("swapped", [False, True])
def test_a_contact_that_is_declared_twice_is_told_by_the_name_of_the_first(swapped: bool) -> None:
    scene = discs_on_floor(5)
    floor = scene.ground.half_plane((0.0, -1.0), (0.0, 1.0))
    disc = scene.body("body3").surface()
    name = scene.contact(disc, floor)
    again = (floor, disc) if swapped else (disc, floor)
    with pytest.raises(lf.ModelError, match=f"given twice, '{name}' is between them"):
        scene.contact(*again, name="another")
