"""A start that penetrates is pushed out on request: by the least motion, told how far, or refused."""

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError

UNITS = pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), (1e3, 1e-3), (1e-3, 1e-15)])


def floored(*bodies, scale=1.0, friction=0.3, g=9.81):
    """A planar scene with a floor at 0: (body, name, position, angle) each."""
    scene = lf.Scene(gravity=(0.0, -g * scale))
    for body, name, position, angle in bodies:
        scene.add(body, name=name, position=np.array(position) * scale, angle=angle)
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all(friction=friction)
    return scene


def disc(scale=1.0, mass=1.0, radius=0.1):
    return lf.Disc(radius * scale, mass=mass)


def box(scale=1.0, mass=1.0):
    return lf.Box(0.2 * scale, 0.1 * scale, mass=mass)


def cuboid(mass=1.0):
    return lf.Cuboid(0.2, 0.2, 0.1, mass=mass)


def apart(compiled, size=1.0):
    """No gap is below zero by more than rounding."""
    return compiled.at(margin=0.5 * compiled.size).gaps.min(initial=np.inf) >= -2e-12 * size


def moved(scene):
    """The start as it is pushed, less the one that was given."""
    given = np.concatenate([one.start[0] for one in scene.parts().placed])
    return scene.compile(project=True).q - given


class TestTheRefusal:
    @pytest.mark.parametrize("depth", [1e-6, 1e-3, 0.05])
    def test_it_names_the_cure(self, depth):
        scene = floored((disc(), "disc", (0.0, 0.1 - depth), 0.0))
        for refused in (lambda: scene.compile(), lambda: lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3))):
            with pytest.raises(ModelError, match=f"penetrate by {depth:g} m .* project=True, which pushes them out"):
                refused()

    def test_others_that_assemble_joints_refuse_still(self):
        scene = floored((disc(), "disc", (0.0, 0.09), 0.0))
        with pytest.raises(ModelError, match=r"penetrate by 0\.01 m"):
            lf.equilibrium(scene)
        with pytest.raises(ModelError, match=r"penetrate by 0\.01 m"):
            lf.studies.small_vibrations(scene)

    def test_what_penetrates_by_a_law_stays(self):
        scene = lf.Scene()
        placed = scene.add(disc(), name="disc", position=(0.0, 0.099))
        floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        scene.contact(placed.surface(), floor, law=lf.Penalty(1e5))
        assert not moved(scene).any()


class TestLeastMotion:
    @UNITS
    def test_a_disc_is_lifted(self, length, mass):
        scene = floored((disc(length, mass), "disc", (0.3, 0.09), 0.2), scale=length)
        assert moved(scene) == pytest.approx([0.0, 0.01 * length, 0.0], abs=1e-14 * length)

    @UNITS
    def test_two_discs_share_it_by_their_masses(self, length, mass):
        bodies = [(disc(length, k * mass), f"d{k}", (0.19 * (k == 3), 1.0), 0.0) for k in (1, 3)]
        shift = moved(floored(*bodies, scale=length)).reshape(2, 3)
        assert shift[:, 0] == pytest.approx([-0.0075 * length, 0.0025 * length])
        assert not shift[:, 1:].any()

    @pytest.mark.parametrize("depth", [1e-6, 1e-4, 1e-3])
    def test_a_tilted_box_turns_as_it_is_lifted(self, depth):
        """Least m y^2 + I theta^2 with y + a theta = depth: y = depth I / (I + m a^2), to first order."""
        angle = 0.3
        corner = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ [-0.1, -0.05]
        shift = moved(floored((box(), "box", (0.0, -corner[1] - depth), angle)))
        inertia = (0.2**2 + 0.1**2) / 12.0
        share = inertia / (inertia + corner[0] ** 2)
        assert shift[1] == pytest.approx(depth * share, rel=10.0 * depth + 1e-9)
        assert shift[2] == pytest.approx(depth * (1.0 - share) / corner[0], rel=30.0 * depth + 1e-9)
        assert shift[0] == 0.0

    def test_a_stack_goes_up_as_a_whole(self):
        scene = floored(*((box(), f"box {k}", (0.01 * k, 0.048 + 0.099 * k), 0.0) for k in range(5)))
        compiled = scene.compile(project=True)
        assert apart(compiled)
        assert compiled.q.reshape(5, 3)[:, 1] == pytest.approx(0.05 + 0.1 * np.arange(5), abs=1e-14)

    def test_what_does_not_penetrate_stays_to_the_bit(self):
        scene = floored((disc(), "low", (0.0, 0.099), 0.0), (disc(), "far", (1.0, 0.1), 0.3))
        assert moved(scene)[3:].tolist() == [0.0, 0.0, 0.0]
        sound = floored((disc(), "a", (0.0, 0.1), 0.0), (box(), "b", (1.0, 0.05 - 1e-14), 0.0))
        assert sound.compile(project=True).q.tobytes() == sound.compile().q.tobytes()

    def test_many_discs_at_random(self):
        """No motion that an independent optimiser finds is shorter."""
        scipy = pytest.importorskip("scipy.optimize")
        random = np.random.default_rng(5)
        places = np.array([[0.17 * (k % 3), 0.09 + 0.17 * (k // 3)] for k in range(6)]) + random.normal(0, 0.01, (6, 2))
        masses = random.uniform(0.5, 5.0, 6)
        scene = floored(*((disc(mass=m), f"d{k}", p, 0.0) for k, (m, p) in enumerate(zip(masses, places, strict=True))))
        compiled = scene.compile(project=True)
        assert apart(compiled)
        found = compiled.q.reshape(6, 3)[:, :2] - places

        def gaps(x):
            at = places + x.reshape(6, 2)
            return np.array(
                [np.hypot(*(at[i] - at[j])) - 0.2 for i in range(6) for j in range(i)] + [y - 0.1 for y in at[:, 1]]
            )

        def cost(x):
            return float((masses[:, None] * x.reshape(6, 2) ** 2).sum())

        best = scipy.minimize(
            cost, found.ravel() + 1e-3, method="SLSQP", constraints={"type": "ineq", "fun": gaps}, tol=1e-14
        )
        assert cost(found.ravel()) == pytest.approx(best.fun, rel=1e-6)


class TestJoints:
    def test_a_pendulum_swings_out(self):
        """The rod keeps its pin: it turns about it until its tip is on the floor."""
        scene = lf.Scene()
        rod = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), name="rod", position=(0.0, 0.5), angle=-0.3)
        scene.join(lf.Revolute(rod.at(-0.5, 0.0), scene.ground.at(-0.5 * np.cos(0.3), 0.5 + 0.5 * np.sin(0.3))))
        tip = rod.node(0.5, 0.0, radius=0.05)
        floor = scene.ground.half_plane((0.0, 0.5 - 0.5 * np.sin(0.3) - 0.04), (0.0, 1.0))
        scene.contact(tip, floor, name="tip")
        compiled = scene.compile(project=True)
        assert apart(compiled)
        at = compiled.at()
        assert np.abs(at.joint_gaps).max() < 1e-12
        assert at.gaps == pytest.approx([0.0], abs=1e-12)
        assert 0.0 < compiled.q[2] + 0.3 < 0.1
        assert "tip by 0.01 m" in compiled.notes[-1]

    def test_velocities_keep_joints(self):
        scene = lf.Scene()
        rod = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), name="rod", position=(0.5, 0.0), angular_velocity=2.0)
        scene.join(lf.Revolute(rod.at(-0.5, 0.0), scene.ground.at(0.0, 0.0)))
        scene.contact(rod.node(0.5, 0.0), scene.ground.half_plane((0.0, 0.02), (0.0, 1.0)))
        compiled = scene.compile(project=True)
        at = compiled.at()
        assert np.abs(at.joint_rates).max() < 1e-12
        assert apart(compiled)

    def test_what_joints_hold_is_refused(self):
        scene = floored((disc(), "disc", (0.0, 0.09), 0.0))
        scene.join(lf.Weld(scene.body("disc").at(0.0, 0.0), scene.ground.at(0.0, 0.09)))
        with pytest.raises(ModelError, match=r"'disc.outline/ground.half_plane1': .* by 0.01 m .*no place without"):
            scene.compile(project=True)


class TestWedged:
    @pytest.mark.parametrize("width", [0.05, 0.19, 0.1999])
    def test_between_walls(self, width):
        scene = floored((disc(), "disc", (0.0, 0.5), 0.0))
        for side in (-1.0, 1.0):
            scene.ground.half_plane((side * width / 2, 0.0), (-side, 0.0))
        with pytest.raises(ModelError, match=r"penetrate by .*project=True finds no place .*wedged"):
            scene.compile(project=True)
        with pytest.raises(ModelError, match="wedged"):
            lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), project=True)

    def test_a_groove_lets_it_out(self):
        scene = lf.Scene()
        scene.add(disc(), name="disc", position=(0.0, 0.1))
        for side in (-1.0, 1.0):
            scene.ground.half_plane((0.0, 0.0), (-side, 1.0))
        scene.contact_all()
        compiled = scene.compile(project=True)
        assert compiled.q == pytest.approx([0.0, 0.1 * np.sqrt(2.0), 0.0], abs=1e-13)

    def test_in_space(self):
        scene = lf.SpatialScene()
        scene.add(cuboid(), name="box", position=(0.0, 0.0, 0.5))
        for side in (-1.0, 1.0):
            scene.ground.plane((0.09 * side, 0.0, 0.0), (-side, 0.0, 0.0))
        scene.contact_all()
        with pytest.raises(ModelError, match="wedged"):
            scene.compile(project=True)


class TestFlexible:
    def test_a_free_beam_is_lifted_and_hardly_bent(self):
        scene = lf.Scene()
        whole = lf.Beam(1.0, 0.02, 0.01, 7800.0, 2e11, elements=10)
        beam = whole.reduce(modes=4, interfaces=["left", "center", "right"])
        placed = scene.add(beam, name="beam", position=(0.0, -0.01))
        for x in (0.0, 0.5, 1.0):
            scene.contact(placed.node(x, 0.0), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name=f"at {x}")
        compiled = scene.compile(project=True)
        assert apart(compiled)
        assert compiled.q[:3] == pytest.approx([0.0, 0.0, 0.0], abs=2e-8)
        assert np.abs(compiled.q[3:]).max() < 1e-7

    def test_a_clamped_beam_is_bent_with_the_least_energy(self):
        """Tip lifted by d: the force of the static deflection, k d, with the k of its modes."""
        scene = lf.Scene(gravity=(0.0, 0.0))
        beam = lf.Beam(1.0, 0.02, 0.01, 7800.0, 2e11, elements=10).reduce(modes=5, interfaces=["left", "right"])
        placed = scene.add(beam, name="beam")
        scene.join(lf.Weld(placed.point("left"), scene.ground.at(0.0, 0.0)))
        scene.contact(placed.node(1.0, 0.0), scene.ground.half_plane((0.0, 0.01), (0.0, 1.0)))
        compiled = scene.compile(project=True)
        at = compiled.at()
        assert apart(compiled)
        energy = 0.5 * compiled.q @ at.stiffness @ compiled.q
        exact = 0.5 * 3.0 * 2e11 * (0.02 * 0.01**3 / 12.0) * 0.01**2
        assert energy == pytest.approx(exact, rel=2e-3)


class TestSpace:
    def test_a_stack_of_cuboids(self):
        scene = lf.SpatialScene()
        for k in range(3):
            scene.add(cuboid(), name=f"box {k}", position=(0.01 * k, 0.0, 0.049 + 0.0995 * k))
        scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.contact_all(friction=0.3)
        compiled = scene.compile(project=True)
        assert apart(compiled)
        q = compiled.q.reshape(3, 7)
        assert q[:, 2] == pytest.approx([0.05, 0.15, 0.25], abs=1e-12)
        assert q[:, 3] == pytest.approx(1.0)

    def test_spheres_share_it_and_keep_their_spin(self):
        scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        for k, (x, m) in enumerate(((0.0, 1.0), (0.19, 3.0))):
            scene.add(lf.Sphere(0.1, mass=m), name=f"s{k}", position=(x, 0.0, 0.0), angular_velocity=(1.0, 2.0, 3.0))
        scene.contact_all()
        compiled = scene.compile(project=True)
        q = compiled.q.reshape(2, 7)
        assert q[:, 0] == pytest.approx([-0.0075, 0.1925])
        assert compiled.u.reshape(2, 6)[:, 3:] == pytest.approx(np.tile([1.0, 2.0, 3.0], (2, 1)))

    def test_a_tilted_cuboid_turns_and_keeps_its_spin_in_the_world(self):
        scipy = pytest.importorskip("scipy.spatial.transform")
        turn = scipy.Rotation.from_rotvec([0.2, 0.1, 0.0])
        corners = turn.apply([[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.05, 0.05)])
        scene = lf.SpatialScene()
        spin = (0.0, 0.0, 5.0)
        height = -corners[:, 2].min() - 0.005
        scene.add(cuboid(), name="box", position=(0, 0, height), orientation=turn, angular_velocity=spin)
        scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.contact_all()
        compiled = scene.compile(project=True)
        assert apart(compiled)
        A = scipy.Rotation.from_quat(np.roll(compiled.q[3:7], -1))
        assert (A * turn.inv()).magnitude() > 0.01
        assert A.apply(np.array(compiled.u[3:])) == pytest.approx(spin, abs=1e-12)


class TestManyTogether:
    """Heaps whose bodies overlap at random: whatever touches them, all gaps are closed or open afterwards."""

    @pytest.mark.parametrize("kind", ["disc", "box", "flush box"])
    def test_in_the_plane(self, kind):
        random = np.random.default_rng(3)
        bodies = []
        for k in range(30):
            place = np.array([0.2 * (k % 6), 0.1 + 0.2 * (k // 6)]) + random.normal(0.0, 0.004, 2)
            body = lf.Disc(0.1, mass=1.0 + k % 3) if kind == "disc" else lf.Box(0.2, 0.2, mass=1.0 + k % 3)
            bodies.append((body, f"body {k}", place, random.normal(0.0, 0.04) if kind == "box" else 0.0))
        compiled = floored(*bodies).compile(project=True)
        assert apart(compiled)
        assert "and " in compiled.notes[-1]

    @pytest.mark.parametrize("kind", ["sphere", "cuboid"])
    def test_in_space(self, kind):
        scipy = pytest.importorskip("scipy.spatial.transform")
        random = np.random.default_rng(4)
        scene = lf.SpatialScene()
        for k in range(8):
            place = np.array([0.2 * (k % 2), 0.2 * (k // 2 % 2), 0.1 + 0.2 * (k // 4)]) + random.normal(0.0, 0.004, 3)
            turn = scipy.Rotation.from_rotvec(random.normal(0.0, 0.03, 3))
            body = lf.Sphere(0.1, mass=1.0) if kind == "sphere" else lf.Cuboid(0.2, 0.2, 0.2, mass=1.0)
            scene.add(body, name=f"body {k}", position=place, orientation=turn)
        scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.contact_all(friction=0.3)
        assert apart(scene.compile(project=True))

    def test_a_flexible_beam_in_space_on_its_clamp(self):
        scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        beam = lf.SpatialBeam(1.0, 1e-4, (1e-9, 1e-9), 2e-9, 7800.0, 2e11, 0.3, elements=10)
        placed = scene.add(beam.reduce(modes=6, interfaces=("left", "right")), name="beam")
        scene.join(lf.Weld(placed.point("left"), scene.ground.at(-0.5, 0.0, 0.0)))
        scene.contact(placed.sphere("right", 0.01), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        compiled = scene.compile(project=True)
        assert apart(compiled)
        at = compiled.at()
        modal = compiled.q[7:]
        energy = 0.5 * modal @ at.stiffness[6:, 6:] @ modal
        assert energy == pytest.approx(0.5 * 3.0 * 2e11 * 1e-9 * 0.01**2, rel=5e-3)


class TestRuns:
    @pytest.mark.parametrize(
        "stepper", [lf.MoreauJean(step=1e-3), lf.EventDriven(), lf.GeneralizedAlpha(step=1e-3)], ids=repr
    )
    def test_they_begin_there_and_say_so(self, stepper):
        scene = floored((box(), "low", (0.0, 0.049), 0.0), (box(), "high", (0.0, 0.148), 0.0))
        result = lf.simulate(scene, 0.05, stepper, project=True, progress=False)
        assert result.q[0, [1, 4]] == pytest.approx([0.05, 0.15], abs=1e-12)
        assert result.q[-1] == pytest.approx(result.q[0], abs=1e-6)
        (note,) = [text for text in result.notes if text.startswith("project: ")]
        assert "'low.outline/ground" not in note
        assert "low.outline/ground.half_plane1 by 0.001 m" in note
        assert "low.outline/high.outline by 0.001 m" in note
        assert "'high' was moved farthest, by 0.002 m" in note
        assert result.complete

    def test_nothing_is_said_where_nothing_was_pushed(self):
        scene = floored((box(), "box", (0.0, 0.05), 0.0))
        result = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), project=True, progress=False)
        assert not any(text.startswith("project") for text in result.notes)

    def test_a_run_goes_on_from_its_checkpoint(self, tmp_path):
        scene = floored((box(), "box", (0.0, 0.049), 0.0))
        path = tmp_path / "x.npz"
        first = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), project=True, progress=False, checkpoint=path)
        again = lf.resume(path, progress=False)
        assert again.q.tobytes() == first.q.tobytes()
