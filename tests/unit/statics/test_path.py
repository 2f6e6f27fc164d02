"""Rests in a row: drives, loads, scenes; jumps, ends, work, tables, charts, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from lcpflex.statics import following
from tests import libs

HALF, RISE, STIFF = 0.1, 0.03, 1e4  # of a shallow arch of two springs: half of its width, its rise [m]; [N/m]
FREE = math.hypot(HALF, RISE)
LIMIT = 2.0 * STIFF * (FREE ** (2 / 3) - HALF ** (2 / 3)) ** 1.5  # its largest force, at the height where L^3 = b^2 L0


def arch(*, driven: bool = False, gravity: float = 0.0) -> lf.Scene:
    """Two springs from the ground to a block between them, guided up and down: it snaps through (von Mises)."""
    scene = lf.Scene(gravity=(0.0, -gravity))
    block = scene.add(lf.Box(0.01, 0.01, mass=0.1), "block", position=(0.0, RISE))
    center, place = block.point("center"), scene.ground.at(0.0, 0.0)
    scene.join(lf.Prismatic(center, place, axis=(0.0, 1.0), name="guide"))
    for x in (-HALF, HALF):
        scene.load(lf.Spring(scene.ground.at(x, 0.0), center, STIFF, length=FREE))
    scene.load(lf.Force(center, (0.0, -2.0 if not driven else 0.0), name="press"))
    if driven:
        scene.join(lf.DrivenDisplacement(center, place, RISE, (0.0, 1.0), name="ram"))
    return scene


def of_arch(y: Any) -> Any:
    """Force of the springs upwards at a height [N]."""
    return 2.0 * STIFF * (FREE - np.hypot(HALF, y)) * y / np.hypot(HALF, y)


def sliding(friction: float = 0.4, size: float = 3.0) -> lf.Scene:
    """A block of 2 kg on a floor, pulled."""
    scene = lf.Scene()
    block = scene.add(lf.Box(0.2, 0.1, mass=2.0), "block", position=(0.0, 0.05))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(block.surface(), floor, friction=friction, name="floor")
    scene.load(lf.Force(block.point("center"), (size, 0.0), name="pull"))
    return scene


@pytest.fixture(scope="module")
def snapped() -> lf.EquilibriumPath:
    values = LIMIT * np.concatenate([np.linspace(0.0, 1.5, 16), np.linspace(1.5, -1.5, 31)[1:]])
    return lf.path(arch(), "press", values, progress=False)


def test_a_load_snaps_through(snapped: lf.EquilibriumPath) -> None:
    """At the largest force of the arch, up and down, to within a 64th of a step of the load; rests are those of it."""
    heights = np.array([rest.q[1] for rest in snapped])
    assert of_arch(heights) == pytest.approx(snapped.values, abs=1e-9 * LIMIT)
    assert snapped.travel == pytest.approx(RISE - heights, abs=1e-12)
    assert snapped.force is not None
    assert snapped.force == pytest.approx(snapped.values)
    assert len(snapped.jumps) == 2
    for jump, sign in zip(snapped.jumps, (1.0, -1.0), strict=True):
        low, high = sign * jump.values
        assert low <= LIMIT * (1.0 + 1e-9)
        assert high > LIMIT
        assert high - low == pytest.approx(0.1 * LIMIT / 64.0)
        assert "'block' moves along (0, " in jump.words
        assert jump.moved == pytest.approx(abs(jump.rests[1].q[1] - jump.rests[0].q[1]))


def test_work_is_what_is_stored_and_what_jumps_take(snapped: lf.EquilibriumPath) -> None:
    """Up to the first jump the energy of the springs, by trapezoids; then the load falls through the jump."""
    before = snapped.jumps[0].after
    stored = STIFF * (FREE - np.hypot(HALF, [rest.q[1] for rest in snapped])) ** 2
    assert snapped.work[before] == pytest.approx(stored[before], rel=1e-2)
    taken = LIMIT * snapped.jumps[0].moved
    fallen = snapped.work[before + 1] - snapped.work[before]
    assert fallen > taken
    assert fallen == pytest.approx(taken, rel=0.1)


def test_a_drive_holds_what_a_load_jumps_over() -> None:
    """The whole curve of the arch by its height, unstable under a load, with a weight beside; down and up alike."""
    values = np.concatenate([np.linspace(RISE, -RISE, 13), np.linspace(-RISE, RISE, 13)[1:]])
    path = lf.path(arch(driven=True, gravity=9.81), "ram", values, progress=False)
    assert path.force is not None
    assert path.force == pytest.approx(0.981 - of_arch(values), abs=1e-9 * LIMIT)
    assert path.travel == pytest.approx(values)
    assert not path.jumps
    assert path.work[-1] == pytest.approx(0.0, abs=1e-9 * LIMIT * RISE)


def test_a_path_that_ends_keeps_its_rests() -> None:
    """A block is pulled until nothing holds it: where, what was closed, and what moves is said."""
    path = lf.path(sliding(), "pull", np.arange(13.0), progress=False)
    assert len(path) == 8  # 0.4 * 2 * 9.81 = 7.85
    assert not path.complete
    assert path.values == pytest.approx(np.arange(8.0))
    assert "no rest was found at pull = 8 N; at pull = 7 N these were closed: 'floor (stick)'" in path.message
    assert "'block' moves along (1, 0), and nothing holds that" in path.message
    assert path.summary().splitlines()[-1] == path.message
    assert repr(path) == "<path of 'pull': 8 of 13 rests, 0 jumps>"
    with pytest.raises(lf.SolverError, match="nothing holds that"):
        lf.path(sliding(), "pull", [8.0], progress=False)


def test_a_motion_that_begins_just_before_a_value_is_no_jump() -> None:
    """A block on a spring of 300 N/m slides back from -1.696 N on, 0.054 N before a value."""
    scene = lf.Scene()
    block = scene.add(lf.Box(0.4, 0.2, mass=2.0), "block", position=(0.0, 0.1))
    scene.contact(block.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.4, name="floor")
    scene.load(lf.Spring(block.point("center"), scene.ground.at(1.0, 0.1), stiffness=300.0, length=1.0))
    scene.load(lf.Force(block.point("center"), (1.0, 0.0), name="pull"))
    path = lf.path(scene, "pull", [14.0, 1.75, 0.0, -1.75, -3.5], progress=False)
    assert path.travel[3] - path.travel[2] == pytest.approx((-1.75 - (14.0 - 2.0 * 0.4 * 2.0 * 9.81)) / 300.0, rel=1e-6)
    assert path.jumps == ()


def test_scenes_of_a_value() -> None:
    """A coefficient of friction that falls below what holds a block."""
    path = lf.path(sliding, None, [0.4, 0.3, 0.2, 0.1], progress=False)
    assert path.values == pytest.approx([0.4, 0.3, 0.2])
    assert path.drive == ""
    assert path.force is None
    assert path.contact("floor").normal == pytest.approx(3 * [2.0 * 9.81])
    assert path.contact("floor").state == ("stick",) * 3
    with pytest.raises(lf.ModelError, match="work: a path of scenes has no drive"):
        _ = path.work
    assert "ends after 3 of 4" in path.plot().axes[0].get_title(loc="left")


def test_a_turning_drive_and_a_torque() -> None:
    """An arm on a torsion spring and under its weight: the same curve by its angle, and by a torque."""
    scene = lf.Scene()
    arm = scene.add(lf.Box(0.4, 0.02, mass=1.0), "arm", position=(0.2, 0.0))
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    scene.load(lf.TorsionSpring(arm.point("left"), scene.ground.at(0.0, 0.0), 20.0))
    turned = scene.with_bodies({})
    scene.join(lf.DrivenAngle(arm.point("left"), scene.ground.at(0.0, 0.0), 0.0, name="cam"))
    turned.load(lf.Torque(turned.body("arm").point("left"), 0.0, name="twist"))
    angles = np.linspace(0.0, 0.5, 6)
    torque = 20.0 * angles + 0.2 * 9.81 * np.cos(angles)
    cam = lf.path(scene, "cam", angles, progress=False)
    assert cam.force == pytest.approx(torque, rel=1e-9)
    assert cam.units == {"values": "rad", "travel": "rad", "force": "N m"}
    twist = lf.path(turned, "twist", torque, progress=False)
    assert twist.travel == pytest.approx(angles - angles[0], abs=1e-9)


def test_a_force_that_follows() -> None:
    """Along the end of an arm on a torsion spring: its work is what the spring has taken."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    arm = scene.add(lf.Box(0.4, 0.02, mass=1.0), "arm", position=(0.2, 0.0))
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    scene.load(lf.TorsionSpring(arm.point("left"), scene.ground.at(0.0, 0.0), 20.0))
    scene.load(lf.Force(arm.point("right"), (0.0, 1.0), follower=True, name="push"))
    path = lf.path(scene, "push", np.linspace(0.0, 50.0, 51), progress=False)
    angle = path.joint("hinge").force  # two components, to be there
    assert angle.shape == (51, 2)
    turned = np.array([rest.q[2] for rest in path])
    assert 20.0 * turned == pytest.approx(0.4 * path.values, abs=1e-9)
    assert path.work[-1] == pytest.approx(10.0 * turned[-1] ** 2, rel=1e-3)  # by trapezoids


def test_a_drive_bears_the_friction_of_its_way() -> None:
    """A block that it pushes over a floor: balance leaves friction open, the way there does not."""
    scene = lf.Scene()
    block = scene.add(lf.Box(0.2, 0.1, mass=2.0), "block", position=(0.0, 0.05))
    scene.contact(block.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.4, name="floor")
    place = scene.ground.at(0.0, 0.05)
    scene.join(lf.DrivenDisplacement(block.point("center"), place, 0.0, (1.0, 0.0), name="push"))
    path = lf.path(scene, "push", [0.0, 0.01, 0.02, 0.01], progress=False)
    assert path.force is not None
    limit = 0.4 * 2.0 * 9.81
    assert path.force == pytest.approx([0.0, limit, limit, -limit], abs=1e-9)
    assert path.contact("floor").state == ("stick", "slip", "slip", "slip")
    assert path.rests[1].joint("push").unique


def test_friction_of_the_way_in_space() -> None:
    """Likewise, across: along the way, and none of it aside."""
    scene = lf.SpatialScene()
    block = scene.add(lf.Cuboid(0.2, 0.1, 0.1, mass=2.0), "block", position=(0.0, 0.0, 0.05))
    scene.contact(block.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=0.4, name="floor")
    place, way = scene.ground.at(0.0, 0.0, 0.05), np.array([0.6, 0.8, 0.0])
    scene.join(lf.DrivenDisplacement(block.point("center"), place, 0.0, way, name="push"))
    path = lf.path(scene, "push", [0.0, 0.01, 0.02, 0.01], progress=False)
    limit = 0.4 * 2.0 * 9.81
    assert path.force == pytest.approx([0.0, limit, limit, -limit], abs=1e-9)
    assert path.contact("floor").tangential[1:3] == pytest.approx(np.tile(-limit * way, (2, 1)), abs=1e-9)
    assert path.work[-1] == pytest.approx(0.015 * limit, rel=1e-6)  # by trapezoids from 0 and through 0


@pytest.mark.parametrize("first", [[], [0.0]])
def test_the_way_to_the_first_value_counts(first: list[float]) -> None:
    """Of a drive: the motion of the scene is elsewhere, and the path begins where the bodies stand, at -0.01."""
    scene = lf.Scene()
    block = scene.add(lf.Box(0.2, 0.1, mass=2.0), "block", position=(-0.01, 0.05))
    scene.contact(block.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.4, name="floor")
    place = scene.ground.at(0.0, 0.05)
    scene.join(lf.DrivenDisplacement(block.point("center"), place, 0.02, (1.0, 0.0), name="push"))
    path = lf.path(scene, "push", [*first, 0.01, 0.02], progress=False)
    assert path.force == pytest.approx(np.full(len(path), 0.4 * 2.0 * 9.81), rel=1e-9)
    run = lf.simulate(scene, 0.01, lf.MoreauJean(1e-3), initial=path[-1], progress=False)
    assert np.abs(run.q - run.q[0]).max() < 1e-12


def test_a_turning_drive_in_space() -> None:
    """As in the plane: an arm on a torsion spring about -y; by its angle, from elsewhere, and by a torque."""

    def arm() -> tuple[lf.SpatialScene, Any, Any]:
        scene = lf.SpatialScene()
        placed = scene.add(lf.Cuboid(0.4, 0.02, 0.02, mass=1.0), "arm", position=(0.2, 0.0, 0.0))
        end, place = placed.at(-0.2, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)
        scene.join(lf.Revolute(end, place, axis=(0.0, -1.0, 0.0), name="hinge"))
        scene.load(lf.TorsionSpring(end, place, 20.0, axis=(0.0, -1.0, 0.0)))
        return scene, end, place

    angles = np.linspace(0.0, 0.5, 6)
    torque = 20.0 * angles + 0.2 * 9.81 * np.cos(angles)
    driven, end, place = arm()
    driven.join(lf.DrivenAngle(end, place, 0.4, axis=(0.0, -1.0, 0.0), name="cam"))
    assert lf.path(driven, "cam", angles, progress=False).force == pytest.approx(torque, rel=1e-9)
    loaded, end, _ = arm()
    loaded.load(lf.Torque(end, (0.0, -1.0, 0.0), name="twist"))
    twist = lf.path(loaded, "twist", torque, progress=False)
    assert twist.travel == pytest.approx(angles, abs=1e-9)
    assert twist.joint("hinge").moment.shape == (6, 3)


def test_each_rest_knows_where_the_drive_was() -> None:
    """Its own scene: a run that begins at one and a picture of it are of that load."""
    path = lf.path(sliding(), "pull", [0.0, 2.0, 6.0], progress=False)
    forces = [float(rest.contact("floor").tangential.sum()) for rest in path]
    assert np.abs(forces) == pytest.approx([0.0, 2.0, 6.0])
    for rest, value in zip(path, path.values, strict=True):
        model = rest.compiled.model
        number = int(model.loads.force_signal[0, 0])
        assert model.signals.coefficients[model.signals.first[number], 0] == value


def test_time_is_that_of_other_loads() -> None:
    """Half of the friction is taken by another force at time 1; at time 0 it moves by itself, which is no drive."""
    scene = sliding()
    block = scene.body("block")
    scene.load(lf.Force(block.point("center"), (lf.Table([0.0, 1.0], [0.0, 4.0]), 0.0)))
    values = np.arange(8.0)
    assert len(lf.path(scene, "pull", values, progress=False)) == 8
    assert len(lf.path(scene, "pull", values, time=1.0, progress=False)) == 4


def test_table(snapped: lf.EquilibriumPath) -> None:
    pytest.importorskip("pandas")
    table = snapped.to_dataframe()
    assert table.index.name == "press"
    assert table["force"].to_numpy() == pytest.approx(snapped.values)
    assert table["block.y"].to_numpy() == pytest.approx([rest.q[1] for rest in snapped])
    units = table.attrs["units"]
    assert set(units) == {"press", *table.columns}
    assert (units["travel"], units["work"]) == ("m", "J")
    assert units["guide.moment"] == "N m"


def test_chart(snapped: lf.EquilibriumPath) -> None:
    """Ways by their names, jumps dotted from side to side, arrows along all of it."""
    ax = snapped.plot().axes[0]
    lines = {str(line.get_label()): line for line in ax.lines}
    assert {"rising values", "falling values", "jump"} <= set(lines)
    x = np.asarray(lines["jump"].get_xdata(), dtype=float)
    ends = 1e3 * np.array([jump.travel for jump in snapped.jumps])
    assert x.reshape(-1, 3)[:, :2] == pytest.approx(ends)
    assert ax.get_xlabel() == "travel of press [mm]"
    arrows = [one for one in ax.texts if isinstance(one, libs.Annotation)]
    assert len(arrows) > 6
    figure, own = libs.plt.subplots()
    assert snapped.plot(own) is figure
    libs.plt.close(figure)


def test_summary(snapped: lf.EquilibriumPath) -> None:
    lines = snapped.summary().splitlines()
    assert lines[0] == "path of 'press': 46 rests from 0 N to 14.92 N to -14.92 N"
    assert lines[1] == "force from -14.92 N to 14.92 N"
    assert [line.split(":")[0] for line in lines if line.startswith("jump")] == [
        "jump between 9.95 N and 9.965 N",
        "jump between -9.95 N and -9.965 N",
    ]
    assert str(snapped) == snapped.summary()


def test_summary_of_many_contacts() -> None:
    """Of discs in a row on a floor, the heaviest first; pairs that are far are not told."""
    scene = lf.Scene()
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k in range(12):
        disc = scene.add(lf.Disc(0.1, mass=1.0 + k), f"disc {k}", position=(0.3 * k, 0.1))
        scene.contact(disc.surface(), floor, friction=0.3, name=f"floor {k}")
    last = scene.body("disc 11")
    scene.contact(last.surface(), scene.ground.half_plane((9.0, 0.0), (-1.0, 0.0)), name="wall")
    scene.load(lf.Force(last.point("center"), (0.0, -1.0), name="press"))
    lines = lf.path(scene, "press", [1.0, 2.0], progress=False).summary().splitlines()
    told = [line for line in lines if line.startswith("contact")]
    assert told[0].startswith("contact 'floor 11': at most 119.7 N; ")
    assert len(told) == 10
    assert "2 more contacts" in lines


def test_ended_by_hand_or_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was found before is kept; before the first rest nothing is."""
    found: list[Any] = []
    come_to_rest: Callable[..., Any] = following.come_to_rest

    def interrupted(*given: Any) -> Any:
        if len(found) == 3:
            raise KeyboardInterrupt
        found.append(come_to_rest(*given))
        return found[-1]

    monkeypatch.setattr(following, "come_to_rest", interrupted)
    path = lf.path(sliding(), "pull", np.arange(6.0), progress=False)
    assert len(path) == 3
    assert path.message == "interrupted before pull = 3 N"
    with pytest.raises(KeyboardInterrupt):
        lf.path(sliding(), "pull", np.arange(6.0), progress=False)
    monkeypatch.undo()
    with pytest.raises(lf.SolverError, match="budget"):
        lf.path(sliding(), "pull", np.arange(6.0), budget=1e-9, progress=False)


def two_of_a_name() -> lf.Scene:
    scene = sliding()
    scene.load(lf.Torque(scene.body("block").point("center"), 1.0, name="pull"))
    return scene


def other_joints(value: float) -> lf.Scene:
    return arch(driven=value > 1.0)


def other_bodies(value: float) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    for name in ("block", "more")[: int(value)]:
        scene.add(lf.Disc(0.1, mass=1.0), name, position=(len(name), 0.0))
    return scene


def flat_or_not(value: float) -> lf.Scene | lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0)) if value > 1.0 else lf.Scene(gravity=(0.0, 0.0))
    scene.add(lf.Sphere(0.1, mass=1.0) if value > 1.0 else lf.Disc(0.1, mass=1.0), "ball")
    return scene


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"scene": 3}, "scene: 3 was given, expected a Scene or a SpatialScene"),
        ({"drive": "pul"}, "drive: no drive or load 'pul'.*'pull'"),
        ({"drive": None}, "drive: no drive or load None"),
        ({"scene": arch(), "drive": "guide"}, "the joint 'guide' drives nothing, expected a DrivenDisplacement"),
        ({"scene": two_of_a_name()}, "2 drives and loads have the name 'pull'"),
        ({"scene": sliding(size=0.0)}, r"the load 'pull' is \[0.0, 0.0\] at 0 s, expected one that is not 0"),
        ({"values": []}, "values: none was given"),
        ({"values": [1.0, math.nan]}, "values: an array with nan in it"),
        ({"values": "up"}, "values: 'up' was given"),
        ({"budget": 0.0}, "budget: 0.0 was given"),
        ({"time": math.inf}, "time: inf was given"),
        ({"scene": sliding}, "drive: 'pull' was given with a function of the value, expected None"),
        ({"scene": lambda value: value, "drive": None}, "scene: 1.0 was given, expected a Scene"),
        ({"scene": lambda value: 1 / 0, "drive": None}, "scene: the function raised ZeroDivisionError"),
        (
            {"scene": other_joints, "drive": None, "values": [1.0, 2.0]},
            r"scene: at 2 the function returns one of the joints .*, expected those of the first value, ",
        ),
        (
            {"scene": other_bodies, "drive": None, "values": [1.0, 2.0]},
            r"scene: at 2 the function returns one of the bodies 'block', 'more', expected those of the first value, "
            r"'block'",
        ),
        (
            {"scene": flat_or_not, "drive": None, "values": [1.0, 2.0]},
            r"scene: at 2 the function returns one with 6 coordinates, .* as many modes .* \(3 coordinates\)",
        ),
    ],
)
def test_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(lf.ModelError, match=words):
        lf.path(**{"scene": sliding(), "drive": "pull", "values": np.ones(1), "progress": False, **given})


def test_names_that_are_not_there(snapped: lf.EquilibriumPath) -> None:
    with pytest.raises(lf.ModelError, match="name: no contact 'flor'"):
        snapped.contact("flor")
    with pytest.raises(lf.ModelError, match="name: no joint 'gide'"):
        snapped.joint("gide")
    places: FloatArray = snapped.point("block", "center")
    assert places[:, 1] == pytest.approx([rest.q[1] for rest in snapped])
