"""Kinds of random scenes, each drawn on purpose: what is thrown about, flat, pressed, in rows, by laws, held."""

from __future__ import annotations

from dataclasses import replace

from tests.property.flat_scenes import flat
from tests.property.layout import Layout
from tests.property.yard import Push, Shape, Vector, Wall, Yard, crossed, turned

__all__ = ["KINDS", "Layout", "held", "pressed", "row", "system", "thrown", "touches"]

FIGURES = {  # shares of the shapes of bodies
    2: {"ball": 0.35, "box": 0.35, "hull": 0.15, "beam": 0.15},
    3: {"ball": 0.25, "box": 0.3, "hull": 0.15, "drum": 0.1, "capsule": 0.1, "beam": 0.1},
}
HOLDS = {"free": 0.55, "pin": 0.1, "rod": 0.07, "spring": 0.1, "drive": 0.06, "guide": 0.06, "hinge": 0.06}
GAPS = (0.0, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2)  # over the length
SYSTEMS = {2: ("cart", "polar"), 3: ("cart", "spherical", "cylindrical")}


def _one_of(yard: Yard, shares: dict[str, float]) -> str:
    return str(yard.rng.choice(list(shares), p=list(shares.values())))


def thrown(yard: Yard) -> Layout:
    """Bodies thrown at each other, a floor, thin walls and posts, free or held, with loads in time."""
    rng = yard.rng
    count = int(rng.choice([1, 2, 3], p=[0.45, 0.35, 0.2]))
    shapes: list[Shape] = []
    for k in range(count):
        shapes.append(_thrown(yard, k, count, shapes))
    pushes = tuple(_push(yard, int(rng.integers(count)), shapes) for _ in range(rng.integers(0, 3)))
    weight = rng.random() < 0.8
    lean = rng.uniform(-0.4, 0.4) if rng.random() < 0.3 else 0.0
    gravity = yard.down(lean) if weight else yard.at(0.0, 0.0)
    return Layout(tuple(shapes), gravity, _walls(yard, count), pushes)


def _thrown(yard: Yard, k: int, count: int, before: list[Shape]) -> Shape:
    """A body beside those before it, touching none of them nor the floor."""
    rng, L, speed = yard.rng, yard.length, yard.speed
    kind, numbers, mass = yard.figure(_one_of(yard, FIGURES[yard.dimension]))
    place = yard.at(1.2 * L * k, rng.uniform(0.45, 0.8) * L, rng.uniform(-0.2, 0.2) * L)
    along, up, aside = rng.uniform(-1.5, 1.5), rng.uniform(-2.0, 0.5), rng.uniform(-0.5, 0.5)
    if count > 1:  # towards each other
        along = rng.uniform(-0.3, 1.5) * (1.0 if 2 * k < count - 1 else -1.0)
    velocity = yard.at(along * speed, up * speed, aside * speed)
    shape = Shape(kind, numbers, mass, place, yard.any_turn(), velocity, yard.any_spin())
    hold = _one_of(yard, HOLDS)
    if hold == "hinge" and (k == 0 or "beam" in (kind, before[-1].kind)):
        hold = "free"
    return _held(yard, shape, hold, before)


def _held(yard: Yard, shape: Shape, hold: str, before: list[Shape]) -> Shape:
    """The body held somehow; its speeds are made to fit."""
    rng, L, (still, no_spin) = yard.rng, yard.length, yard.still
    at = tuple(float(x) * L for x in rng.uniform(-0.3, 0.3, yard.dimension))
    numbers: Vector = ()
    shape = replace(shape, hold=hold)
    if hold == "hinge":
        shape = replace(shape, turn=yard.upright())
        at = yard.at(0.5 * (before[-1].place[0] - shape.place[0]), 0.0)
    if shape.kind == "beam":
        at = yard.at(-0.5 * shape.numbers[0], 0.0)
    if hold == "spring":
        numbers = (float(10.0 ** rng.uniform(-2.5, -0.3)), float(rng.uniform(0.0, 0.1)))  # period [s], damping ratio
    elif hold == "drive":
        numbers = (float(10.0 ** rng.uniform(-1.8, 0.0)), float(rng.uniform(0.05, 0.6)))  # period [s], amplitude [rad]
    speed, spin = shape.speed, shape.spin
    if hold in ("weld", "rod", "drive", "guide", "hinge") or (before and before[-1].hold == "hinge"):
        speed = yard.at(shape.speed[0], 0.0) if hold == "guide" else still
        spin = no_spin
    elif hold == "pin":
        speed = tuple(map(float, -crossed(spin, turned(shape.turn, at))))
    if shape.kind == "beam" and hold not in ("free", "spring"):
        speed, spin = still, no_spin
    return replace(shape, at=at, hold_numbers=numbers, speed=speed, spin=spin)


def _walls(yard: Yard, count: int) -> tuple[Wall, ...]:
    """Floor, thin box, post."""
    rng, L = yard.rng, yard.length
    walls = [floor(yard)] if rng.random() < 0.85 else []
    if rng.random() < 0.5 or not walls:
        thin = float(10.0 ** rng.uniform(-2.0, -0.5)) * L
        side = -0.75 * L - thin if rng.random() < 0.5 else (1.2 * count - 0.45) * L
        walls.append(Wall("slab", yard.at(side, -0.5 * L, -2.0 * L), yard.at(thin, 3.0 * L, 4.0 * L)))
    if rng.random() < 0.25:
        place = yard.at(rng.uniform(0.0, 1.2 * (count - 1)) * L, -0.05 * L)
        walls.append(Wall("post", place, (float(rng.uniform(0.05, 0.12)) * L,)))
    return tuple(walls)


def floor(yard: Yard, height: float = 0.0) -> Wall:
    """Level."""
    return Wall("plane", yard.at(0.0, height), yard.at(0.0, 1.0))


def _push(yard: Yard, body: int, shapes: list[Shape]) -> Push:
    """A load that moves its body by something like its size."""
    rng = yard.rng
    kinds = ["constant", "harmonic", "pulse", "steps", "function"]
    kind = str(rng.choice(kinds, p=[0.1, 0.35, 0.3, 0.15, 0.1]))
    turns = bool(rng.random() < 0.3)
    period = float(10.0 ** rng.uniform(-3.5, -0.5))
    start = float(rng.uniform(0.0, 0.25))
    size = shapes[body].mass * float(rng.uniform(-1.0, 1.0)) * yard.speed  # an impulse [N s]
    if turns:
        size *= 0.2 * yard.length
    # a harmonic throws its body off by its first half period, on the average, however short that is
    time = 0.3 if kind in ("constant", "steps") else period
    return Push(body, int(rng.integers(yard.dimension)), kind, size / time, period, start, turns)


def pressed(yard: Yard) -> Layout:
    """Without gravity: bodies that forces press on a floor, into a corner, on a wall, or on one between them."""
    rng, L = yard.rng, yard.length
    friction = float(rng.choice([0.0, 0.3, 0.6]))
    form = str(rng.choice(["floor", "corner", "wall", "grip"]))
    edge = yard.edges(0.15, 0.4)
    count = {"floor": 1, "corner": 1, "wall": 2, "grip": 3}[form]
    kind, numbers, mass = ("ball", (0.2 * L,), yard.mass_of(0.03 * L**3)) if form == "corner" else ("box", edge, 0.0)
    width, height = (0.4 * L, 0.4 * L) if form == "corner" else (edge[0], edge[-1])
    mass = mass or yard.mass_of(edge[0] * edge[-1] * L)
    still, no_spin = yard.still
    shapes = [
        Shape(kind, numbers, mass * yard.choice([1.0, 1.0, 1e-3, 1e3, 1e8]) ** (k == 1), yard.at(
            (k + 0.5) * width, 0.5 * height if form in ("floor", "corner") else 0.0
        ), yard.upright(), still, no_spin)
        for k in range(count)
    ]  # fmt: skip
    walls = [floor(yard)] if form in ("floor", "corner") else []
    if form in ("corner", "wall"):
        walls.append(Wall("plane", yard.at(0.0, 0.0), yard.at(1.0, 0.0)))
    normal = mass * yard.g * float(10.0 ** rng.uniform(-1.0, 1.0))
    tangential = max(friction, 0.1) * normal * yard.choice([0.0, 0.3, 0.9, 1.1, 2.0])
    varies = str(rng.choice(["constant", "harmonic", "ramp"]))
    period = float(rng.uniform(0.02, 0.3))

    def loads(body: int, way: int, size: float, kind: str = "constant", at: Vector = ()) -> Push:
        return Push(body, way, kind, float(size), period, 0.0, at=at)

    up, last = yard.dimension - 1, count - 1
    foot = yard.at(0.0, -0.5 * height)  # where it does not tip the body
    if form == "floor":
        pushes = [loads(0, up, -normal, at=foot), loads(0, 0, tangential, varies, foot)]
    elif form == "corner":
        pushes = [loads(0, up, -normal), loads(0, 0, -normal * rng.uniform(0.2, 2.0), varies)]
    elif form == "wall":
        pushes = [loads(last, 0, -normal), loads(int(rng.integers(2)), up, tangential, varies)]
    else:
        pushes = [loads(0, 0, normal), loads(last, 0, -normal), loads(1, up, 2.0 * tangential, varies)]
        pushes += [loads(k, up, -tangential, varies) for k in (0, last)]
    return Layout(tuple(shapes), still, tuple(walls), tuple(pushes), friction=friction)


def row(yard: Yard) -> Layout:
    """Equal or unequal bodies in a row or a column with small gaps, which restitution hands a motion along."""
    rng, L = yard.rng, yard.length
    count = int(rng.integers(2, 6))
    size = 0.25 * L
    column = rng.random() < 0.4
    kind = str(rng.choice(["ball", "box"], p=[0.7, 0.3]))
    equal = rng.random() < 0.5
    heavy = yard.mass_of(size**3)
    still, no_spin = yard.still
    shapes, at = [], yard.choice([1e-3, 0.02, 0.2]) * L if column else 0.0
    for k in range(count):
        numbers: Vector = (0.5 * size,) if kind == "ball" else (size,) * yard.dimension
        mass = heavy if equal else heavy * 10.0 ** rng.uniform(-1.0, 1.0)
        at += 0.5 * size + (yard.choice(GAPS) * L if k else 0.0)
        place = yard.at(0.0, at) if column else yard.at(at, 0.5 * size)
        shapes.append(Shape(kind, numbers, float(mass), place, yard.upright(), still, no_spin))
        at += 0.5 * size
    if not column:
        shapes[0] = replace(shapes[0], speed=yard.at(rng.uniform(0.1, 1.0) * yard.speed, 0.0))
        if rng.random() < 0.3:
            shapes[-1] = replace(shapes[-1], speed=yard.at(-rng.uniform(0.1, 1.0) * yard.speed, 0.0))
    lies = column or rng.random() < 0.5
    return Layout(
        tuple(shapes),
        yard.down() if lies else still,
        (floor(yard),) if lies else (),
        restitution=yard.choice([0.3, 0.5, 0.8, 1.0]),
        friction=yard.choice([0.0, 0.3]),
    )


def touches(yard: Yard) -> Layout:
    """Thrown bodies whose contacts are laws; a touch lasts a three hundredth to a sixteenth of the time of a fall."""
    layout = thrown(yard)
    while any(shape.kind == "beam" for shape in layout.shapes):
        layout = thrown(yard)
    shapes = tuple(replace(shape, mass=layout.shapes[0].mass) for shape in layout.shapes)  # whose touches last alike
    touch = 10.0 ** yard.rng.uniform(-2.5, -1.2) * yard.length / yard.speed
    walls = tuple(wall for wall in layout.walls if wall.kind != "slab")  # which are thinner than some laws give way
    return layout._replace(shapes=shapes, walls=walls or (floor(yard),), touch=float(touch))


def held(yard: Yard) -> Layout:
    """A beam, or a box, that is welded, pinned, driven or hung at one end, over a stop, and a ball falls on it."""
    rng, L = yard.rng, yard.length
    still, no_spin = yard.still
    beam = rng.random() < 0.75
    kind, numbers, mass = yard.figure("beam" if beam else "box")
    half = 0.5 * numbers[0]
    hold = _one_of(yard, {"weld": 0.4, "pin": 0.25, "drive": 0.2, "rod": 0.15})
    shape = Shape(kind, numbers, mass, yard.at(half, 0.0), yard.upright(), still, no_spin, hold, yard.at(-half, 0.0))
    if hold == "drive":
        numbers = (float(10.0 ** rng.uniform(-1.2, 0.0)), float(rng.uniform(0.02, 0.3)))
        shape = replace(shape, hold_numbers=numbers)
    lowest = -0.5 * (shape.numbers[1] if beam else shape.numbers[-1])
    gap = float(10.0 ** rng.uniform(-4.0, -1.0)) * L
    radius = float(rng.uniform(0.02, 0.08)) * L
    stop = str(rng.choice(["post", "floor", "none"], p=[0.5, 0.3, 0.2]))
    walls = []
    if stop == "post":
        # below the middle or the tip, where beams of space have spheres
        along = yard.choice([1.0, 2.0]) * half * (1.0 if yard.dimension == 3 else 0.95)
        walls.append(Wall("post", yard.at(along, lowest - gap - radius), (radius,)))
    elif stop == "floor":
        walls.append(floor(yard, lowest - gap))
    shapes = [shape]
    if rng.random() < 0.5 or stop == "none":
        along = yard.choice([1.0, 2.0]) * half * (1.0 if yard.dimension == 3 else 0.9)
        up = -lowest + radius + yard.choice([1e-3, 0.02, 0.1]) * L
        ball = float(mass * 10.0 ** rng.uniform(-1.5, 0.5))
        speed = yard.at(0.0, -rng.uniform(0.0, 1.0) * yard.speed)
        shapes.append(Shape("ball", (radius,), ball, yard.at(along, up), yard.upright(), speed, no_spin))
    return Layout(tuple(shapes), yard.down(), tuple(walls), held=True)


def system(yard: Yard) -> Layout:
    """A system of the user's own whose mass matrix changes: a cart with a pendulum, a particle in curved coordinates.

    Numbers: mass, length, gravity, a second mass, whether its potential is told, and a start of two or three numbers.
    """
    rng = yard.rng
    name = str(rng.choice(SYSTEMS[yard.dimension]))
    mass = yard.mass_of(0.03 * yard.length**3)
    start = tuple(map(float, rng.uniform(-1.0, 1.0, 6)))
    numbers = (mass, yard.length, yard.g, mass * 10.0 ** rng.uniform(-1.0, 1.0), float(rng.random() < 0.5), *start)
    return Layout((), yard.down(), system=(name, numbers), friction=yard.choice([0.0, 0.4]))


# of twenty seeds
KINDS = (
    thrown, flat, held, pressed, row, thrown, touches, flat, held, system,
    thrown, flat, pressed, row, touches, thrown, flat, held, pressed, flat,
)  # fmt: skip
