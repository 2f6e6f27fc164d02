"""Pressure, area and radius of a contact in space against Hertz's, and what has none of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.model.arrays import STICK
from lcpflex.results.contact_history import ContactHistory, ContactPoints, untouched

RADIUS, PEAK = 0.8e-3, 1.2e9  # of a circle of contact [m], and the pressure in its middle [Pa]


def hertz(cells: int = 80, unit: float = 1.0) -> tuple[Any, Any, Any]:
    """Places, forces and areas of squares, ``cells`` along the radius, on a circle of contact.

    Lengths are in ``unit`` of a metre, and so are places, far from the origin and in no plane of the world.
    """
    h = RADIUS / cells
    x, y = np.meshgrid(h * (np.arange(-cells, cells) + 0.5), h * (np.arange(-cells, cells) + 0.5), indexing="ij")
    share = 1.0 - (x**2 + y**2) / RADIUS**2
    inside = share > 0.0
    first, second = np.array([0.6, 0.8, 0.0]), np.array([-0.48, 0.36, 0.8])
    places = np.array([0.3, -2.0, 1.0]) + np.outer(x[inside], first) + np.outer(y[inside], second)
    force = PEAK * np.sqrt(share[inside]) * h**2
    return places / unit, force, np.full(len(force), (h / unit) ** 2)


def history_of(instants: list[tuple[Any, Any, Any]], before: int = 0) -> ContactHistory:
    """A contact with these places, normal forces and areas at instants a millisecond apart, beside another contact."""
    counts = [len(force) for _, force, _ in instants]
    places, force, area = (np.concatenate([one[k] for one in instants]) for k in range(3))
    record, k = np.repeat(np.arange(len(instants)), counts), len(force)
    points = ContactPoints(
        np.concatenate([np.zeros(before, np.int64), record]),
        np.concatenate([np.zeros(before, np.int64), np.ones(k, np.int64)]),
        np.concatenate([np.zeros((before, 3)), places.reshape(-1, 3)]),
        np.tile([0.0, 0.0, 1.0], (before + k, 1)),
        np.column_stack([np.concatenate([np.ones(before), force]), np.zeros((before + k, 3))]),
        np.full(before + k, STICK, np.int8),
        np.concatenate([np.zeros(before), area]),
    )
    m = len(instants)
    sums = np.zeros((m, 4))
    return ContactHistory(
        "hit", np.linspace(0.0, 1e-3 * (m - 1), m), sums, sums, np.zeros(m, np.int8), np.zeros(m),
        np.zeros(m, np.int64), np.inf, _every=points, _own=np.arange(before, before + k),
    )  # fmt: skip


NOTHING = np.zeros((0, 3)), np.zeros(0), np.zeros(0)


def test_pressure_area_and_radius_are_those_of_hertz() -> None:
    """80 squares along the radius: their rim is jagged, their middles are not."""
    half = [part / np.array(2.0) if k == 1 else part for k, part in enumerate(hertz())]
    hit = history_of([NOTHING, hertz(), (half[0], half[1], half[2])], before=3)
    places, pressure = hit.pressure(1.2e-3)
    away = np.linalg.norm(places - [0.3, -2.0, 1.0], axis=1)
    assert pressure == pytest.approx(PEAK * np.sqrt(1.0 - (away / RADIUS) ** 2), rel=1e-9)
    assert hit.area == pytest.approx(np.pi * RADIUS**2 * np.array([0.0, 1.0, 1.0]), rel=2e-3)
    assert hit.radius == pytest.approx(RADIUS * np.array([0.0, 1.0, 1.0]), rel=1e-3)
    assert hit.pressure(2e-3)[1].max() == pytest.approx(PEAK / 2.0, rel=1e-3)
    assert [len(part) for part in hit.pressure(0.0)] == [0, 0]


@pytest.mark.parametrize("unit", [1e-30, 1e-3, 1e30])
@pytest.mark.parametrize("force", [1e-200, 1.0, 1e200])
def test_units_do_not_matter(unit: float, force: float) -> None:
    places, forces, areas = hertz(20, unit)
    plain, scaled = history_of([hertz(20)]), history_of([(places, force * forces, areas)])
    assert scaled.radius * unit == pytest.approx(plain.radius, rel=1e-12)
    assert scaled.pressure(0.0)[1] / force * unit**-2 == pytest.approx(plain.pressure(0.0)[1], rel=1e-12)


def test_the_radius_needs_no_areas_and_knows_single_points() -> None:
    places, forces, areas = hertz(20)
    bare = history_of([(places, forces, 0.0 * areas), (places[:1], forces[:1], areas[:1])])
    assert bare.radius == pytest.approx([history_of([hertz(20)]).radius[0], 0.0], rel=1e-14)


def test_a_force_on_no_area_is_no_pressure() -> None:
    places, forces, areas = hertz(4)
    areas[7] = 0.0
    hit = history_of([NOTHING, (places, forces, areas)])
    for asked in (lambda: hit.pressure(1e-3), lambda: hit.area):
        with pytest.raises(ModelError, match=r'contact \'hit\': 1 of 52 touching points .*points="areas".* quadratic'):
            asked()
    assert len(hit.pressure(0.0)[1]) == 0  # nothing touches
    forces[7] = 0.0
    hit = history_of([(places, forces, areas)])
    assert len(hit.pressure(0.0)[1]) == 51
    assert hit.area == pytest.approx([51 * areas[0]], rel=1e-12)


def test_what_pulls_has_a_negative_pressure_and_no_area() -> None:
    places, forces, areas = hertz(4)
    forces[3] *= -1.0
    hit = history_of([(places, forces, areas)])
    assert hit.pressure(0.0)[1][3] == forces[3] / areas[3] < 0.0
    assert hit.area == pytest.approx([51 * areas[0]], rel=1e-12)
    assert hit.radius == pytest.approx(
        history_of([tuple(np.delete(x, 3, axis=0) for x in (places, forces, areas))]).radius
    )


@pytest.mark.parametrize("t", [-1e-9, 3e-3, np.nan, "now", None])
def test_other_instants_are_refused(t: Any) -> None:
    with pytest.raises(ModelError, match=r"^t: .* was given, expected a finite number"):
        history_of([hertz(2), NOTHING]).pressure(t)


@pytest.mark.parametrize("asked", [lambda hit: hit.pressure(0.0), lambda hit: hit.area, lambda hit: hit.radius])
def test_there_is_no_patch_in_the_plane(asked: Callable[[ContactHistory], Any]) -> None:
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 0.1))
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor")
    floor = lf.simulate(scene, 2e-3, lf.MoreauJean(1e-3)).contact("floor")
    assert len(floor.points.record) > 0
    with pytest.raises(ModelError, match="contact 'floor': its patch is in the plane"):
        asked(floor)


def test_what_never_touched_has_no_patch() -> None:
    never = untouched("a on b", np.array([0.0, 1.0]), 4)
    assert (never.area.tolist(), never.radius.tolist()) == ([0.0, 0.0], [0.0, 0.0])
    places, pressure = never.pressure(1.0)
    assert (places.shape, pressure.shape) == ((0, 3), (0,))
    none = untouched("a on b", np.zeros(0), 4)
    assert len(none.area) == len(none.radius) == 0
    with pytest.raises(ModelError, match="without stored instants"):
        none.pressure(0.0)


def test_points_without_a_place_have_no_radius() -> None:
    places, forces, areas = hertz(2)
    hit = history_of([(np.nan * places, forces, areas)])
    with pytest.raises(ModelError, match="no places"):
        _ = hit.radius
