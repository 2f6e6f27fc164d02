"""Contacts by a rule that is not listed: those of its pairs listed, at a cost that follows the number of bodies."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.contact import broad_phase
from lcpflex.contact.bounds import bound
from lcpflex.contact.detection import ContactTable, contact_table, detect
from lcpflex.contact.near import surfaces_of
from lcpflex.contact.rule_pairs import MORE_LAWS, law_of_pair, make_room, rule_pairs
from lcpflex.jit.struct import pack
from lcpflex.scene import contact_rules
from tests.rates import rate

STRIP = lf.Beam(length=1.0, width=0.1, thickness=0.05, density=1000.0, youngs_modulus=1e9, elements=12).reduce(modes=3)
SOFT = lf.Beam(length=0.5, width=0.05, thickness=0.05, density=1000.0, youngs_modulus=1e7, elements=8).reduce(modes=4)


def mixed(seed: int, n: int = 40, scale: float = 1.0) -> lf.Scene:
    """Discs, boxes and deformed beams of sizes over two decades, polygons and half-planes, some of them overlapping."""
    rng = np.random.default_rng(seed)
    scene = lf.Scene()
    ground = scene.ground
    ground.half_plane((0.0, -2.0 * scale), (0.1, 1.0))
    xs = np.linspace(-6.0, 6.0, 30) * scale
    ground.chain([(x, -1.5 * scale + 0.3 * scale * math.sin(3.0 * x / scale)) for x in xs[::-1]])
    ground.hole((0.0, 0.0), 7.0 * scale)
    for k in range(n):
        size = scale * 10.0 ** rng.uniform(-2.0, 0.0)
        place = {"position": scale * rng.uniform(-3.0, 3.0, 2), "angle": rng.uniform(0.0, 6.0)}
        if k % 4 == 0:
            scene.add(lf.Box(size, 0.3 * size, density=1.0), **place)
        elif k % 9 == 1 and scale == 1.0:
            body = (STRIP, SOFT)[k % 2]
            scene.add(body, **place, modal=rng.normal(size=body.modes) * 0.02)
        else:
            disc = scene.add(lf.Disc(0.5 * size, density=1.0), **place)
            if k % 5 == 2:
                disc.node(0.3 * size, 0.2 * size)
                disc.arc((0.0, 0.0), 0.6 * size, 0.3, 2.0)
    a, b = scene.body("body2"), scene.body("body3")
    scene.join(lf.Revolute(a.at(0.0, 0.0), b.at(0.0, 0.0)))
    scene.contact(scene.body("body5").surface(), scene.body("body7").surface(), friction=0.9, name="own")
    out = [(scene.body("body1"), scene.ground), (scene.body("body4").surface(), scene.body("body6"))]
    scene.contact_all(friction=0.3, exclude=out)
    scene.contact_all(friction=0.6, exclude=out[1:])
    return scene


def compiled(scene: lf.Scene, monkeypatch: pytest.MonkeyPatch, listed: bool) -> lf.CompiledScene:
    monkeypatch.setattr(contact_rules, "LISTED", 10**9 if listed else 3)
    return scene.compiled(project=True, indents=(lambda name: True) if listed else None)


@pytest.fixture
def overlapping(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scenes may begin with bodies in each other."""
    monkeypatch.setattr("lcpflex.compile.compilation.start_apart", lambda model, layout, hard, q, u, *_: (q, u, ()))


def found(made: lf.CompiledScene, q: np.ndarray, margin: float, collects: int = 2) -> list[tuple[object, ...]]:
    """Contacts in the order of detection, by what they are and all that is known of them."""
    model = pack(made.model)
    contacts = made.model.contacts
    table = contact_table(4096, len(contacts.surface_body), (), collects, rule_pairs(model.contacts), -math.inf)
    n = int(detect(model, q, margin, table))
    assert n <= 4096
    labels = [(int(b), *c) for b, c in zip(contacts.surface_body, contacts.surface_center.tolist(), strict=True)]
    entries = []
    for k in range(n):
        a, b = surfaces_of(contacts, int(table.key[k]))
        node, feature = divmod(int(table.key[k]), len(contacts.feature_kind))
        law = int(table.law[k])
        entries.append((
            labels[a], labels[b], node - contacts.node_start[a], feature - contacts.feature_start[b],
            contacts.friction[law], table.gap[k], *table.normal[k], table.s[k], *table.span[k], *table.body[k],
        ))  # fmt: skip
    return entries


def configurations(made: lf.CompiledScene, seed: int, count: int = 3) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    moved = [made.q + 0.3 * rng.normal(size=len(made.q)) for _ in range(count)]
    return [made.q.copy(), *moved]


@pytest.mark.usefixtures("overlapping")
@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 6))])
def test_a_rule_finds_the_contacts_of_its_pairs_in_their_order(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mixed(seed)
    listed, kept = (compiled(scene, monkeypatch, choice) for choice in (True, False))
    assert len(listed.layout.contacts) > 700
    assert len(kept.layout.contacts) < 60
    most = 0
    for q in configurations(listed, seed):
        for margin in (-1e-3, 0.0, 0.05, 0.5, 20.0):
            expected = found(listed, q, margin)
            assert found(kept, q, margin) == expected
            most = max(most, len(expected))
    assert most > 500


@pytest.mark.usefixtures("overlapping")
@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e6])
def test_it_does_so_in_other_units(scale: float, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mixed(11, scale=scale)
    listed, kept = (compiled(scene, monkeypatch, choice) for choice in (True, False))
    for margin in (0.0, 0.1 * scale):
        expected = found(listed, listed.q.copy(), margin)
        assert len(expected) > 5
        assert found(kept, listed.q.copy(), margin) == expected


@pytest.mark.usefixtures("overlapping")
def test_it_does_so_far_from_the_origin_and_on_the_edges_of_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    for origin in ((0.0, 0.0), (1e6, -3e5), (-4e9, 4e9)):
        scene = lf.Scene()
        for k in range(60):
            place = np.array(origin) + 0.25 * np.array([k % 8, k // 8])
            scene.add(lf.Disc((0.125, 0.25, 0.0625)[k % 3], density=1.0), position=place)
        scene.contact_all()
        listed, kept = (compiled(scene, monkeypatch, choice) for choice in (True, False))
        for margin in (0.0, 0.125, 0.25):
            assert found(kept, listed.q.copy(), margin) == found(listed, listed.q.copy(), margin) != []


@pytest.mark.slow
@pytest.mark.usefixtures("overlapping")
def test_what_is_too_much_to_be_listed_is_found_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mixed(3)
    listed, kept = (compiled(scene, monkeypatch, choice) for choice in (True, False))
    pairs = rule_pairs(kept.model.contacts)
    model = pack(kept.model)
    table = contact_table(8192, len(kept.model.contacts.surface_body), (), 2, pairs, -math.inf)
    bound(model, kept.q, table)
    few = broad_phase.near_pairs(model, table, 0.0)
    assert 0 < few <= len(pairs.found)
    monkeypatch.setattr("lcpflex.contact.rule_pairs.FOUND", 1)
    assert broad_phase.near_pairs.py_func is not None
    scarce = contact_table(
        8192, len(kept.model.contacts.surface_body), (), 2, rule_pairs(kept.model.contacts), -math.inf
    )
    bound(model, kept.q, scarce)
    assert broad_phase.near_pairs(model, scarce, 5.0) == -1
    assert found(kept, listed.q.copy(), 5.0) == found(listed, listed.q.copy(), 5.0)


def test_what_is_not_finite_ends_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mixed(1, n=36)
    monkeypatch.setattr("lcpflex.compile.compilation.start_apart", lambda model, layout, hard, q, u, *_: (q, u, ()))
    kept = compiled(scene, monkeypatch, False)
    for bad in (math.nan, math.inf, -math.inf, 1e300, -1e308):
        for entry in (0, 4, -1):
            q = kept.q.copy()
            q[entry] = bad
            table = contact_table(
                4096, len(kept.model.contacts.surface_body), (), 2, rule_pairs(kept.model.contacts), -math.inf
            )
            detect(pack(kept.model), q, 0.0, table)


def discs(n: int) -> lf.CompiledScene:
    """n discs on a square grid, a little apart, above a floor."""
    scene = lf.Scene()
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    side = math.ceil(math.sqrt(n))
    for k in range(n):
        scene.add(lf.Disc(0.05, density=1.0), position=(0.101 * (k % side), 0.051 + 0.101 * (k // side)))
    scene.contact_all()
    return scene.compiled()


def looks(made: lf.CompiledScene, margin: float, monkeypatch: pytest.MonkeyPatch) -> tuple[int, int]:
    """How often two surfaces are compared, and how many pairs come of it."""
    count = 0

    def counted(function: Callable[..., bool]) -> Callable[..., bool]:
        def call(*values: object) -> bool:
            nonlocal count
            count += 1
            return bool(function(*values))

        return call

    model = pack(made.model)
    table = contact_table(16, len(made.model.contacts.surface_body), (), 2, rule_pairs(made.model.contacts), -math.inf)
    bound(model, made.q, table)
    for name in ("may_meet", "above_half_plane"):
        monkeypatch.setattr(broad_phase, name, counted(getattr(broad_phase, name)))
    for name in ("find_on_level", "find_by_half_planes", "fill_cells", "sort_pairs", "note_near", "radius_of"):
        function = getattr(broad_phase, name)
        monkeypatch.setattr(broad_phase, name, getattr(function, "py_func", function))
    pairs = broad_phase.near_pairs.py_func(model, table, margin)
    monkeypatch.undo()
    return count, pairs


def test_looks_and_memory_follow_the_number_of_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = (100, 400, 1600)
    made = [discs(n) for n in sizes]
    counts = [looks(one, 0.01, monkeypatch) for one in made]
    assert rate(sizes, [count for count, _ in counts]) < 1.1
    assert counts[-1][1] > 3000  # neighbours and the floor
    for one in made:
        assert one.layout.contacts == ()
    words = [sum(np.size(part) for part in vars(rule_pairs(one.model.contacts)).values()) for one in made]
    arrays = [sum(np.size(part) for group in one.model for part in group) for one in made]
    assert rate(sizes, words) < 1.1
    assert rate(sizes, arrays) < 1.1


def test_a_body_that_spans_all_others_costs_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = lf.Scene()
    scene.add(lf.Disc(50.0, density=1.0), position=(0.0, -50.0))
    for k in range(300):
        scene.add(lf.Disc(0.05, density=1.0), position=(0.101 * (k % 20), 0.051 + 0.101 * (k // 20)))
    scene.add(lf.Disc(1e-7, density=1.0), position=(-1.0, 1.0))
    scene.contact_all()
    count, pairs = looks(scene.compiled(), 2e-3, monkeypatch)
    assert count < 40 * 300
    assert pairs > 500


# ---- laws of pairs


def table_with_laws(made: lf.CompiledScene, touching: float) -> tuple[object, ContactTable]:
    model = pack(made.model)
    pairs = rule_pairs(made.model.contacts)
    return model, contact_table(4096, len(made.model.contacts.surface_body), (), 2, pairs, touching)


@pytest.mark.slow
def test_a_pair_gets_a_law_when_it_touches_and_keeps_it() -> None:
    made = discs(49)
    model, table = table_with_laws(made, 0.0)
    n = detect(model, made.q, 0.01, table)
    assert n == 91
    assert set(table.law[:n].tolist()) == {0}
    q = made.q.copy()
    q[0::3] *= 0.1 / 0.101 - 1e-6  # columns of neighbours side by side touch, rows do not
    q[1::3] += 0.01 + 0.02 * np.round((q[1::3] - 0.051) / 0.101)
    n = detect(model, q, 0.001, table)
    laws = table.law[:n].tolist()
    assert n == 42
    assert laws == list(range(1, 43))
    assert detect(model, made.q, 0.01, table) == 91  # apart again: a law is kept
    assert sorted(set(table.law[:91].tolist())) == list(range(43))


def test_laws_run_out_and_go_on_with_more_room() -> None:
    made = discs(400)
    model, table = table_with_laws(made, math.inf)
    room = len(table.pairs.pair)
    assert detect(model, made.q, 0.01, table) == MORE_LAWS
    given = [table.pairs.pair[law].tolist() for law in range(1, room)]
    while detect(model, made.q, 0.01, table) == MORE_LAWS:
        room *= 2
        make_room(table.pairs, room)
    for law, (i, j) in enumerate(given, 1):
        assert law_of_pair(table.pairs, i, j) == law
    n = int(detect(model, made.q, 0.01, table))
    assert n > room // 4
    assert table.law[:n].tolist() == list(range(1, n + 1))
    assert law_of_pair(table.pairs, 0, 399) == -1
