"""From a scene to a model: state, points, joints and loads; checks of the start; refusal of what cannot be."""

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.applied_forces import applied_forces, spring_energy
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.dynamics.mechanics import supply
from lcpflex.dynamics.start import violation


def rods(second_angle=0.0, **options):
    """Two rods of 1 m, the first from the ground at (0, 0), the second from its end."""
    scene = lf.Scene()
    rod = lf.RigidBody(mass=1.0, inertia=1.0 / 12.0, center=(0.5, 0.0), points={"left": (0, 0), "right": (1, 0)})
    upper = scene.add(rod, "upper", **options)
    lower = scene.add(rod, "lower", position=(1.0, 0.0), angle=second_angle)
    scene.join(lf.Revolute(upper.point("left"), scene.ground.at(0, 0), name="hinge"))
    scene.join(lf.Revolute(lower.point("left"), upper.point("right")))
    return scene, upper, lower


def external(compiled):
    return np.zeros((compiled.n_external, 3))


def test_state_names_and_points():
    scene = lf.Scene(gravity=(1.0, -2.0))
    box = lf.Box(width=0.4, height=0.2, mass=3.0)
    first = scene.add(box, position=(1, 2), angle=0.3, velocity=(4, 5), angular_velocity=6)
    second = scene.add(box, position=(-1, 0))
    compiled = scene.compiled()
    assert compiled.layout.bodies == ("body1", "body2") == (first.name, second.name)
    np.testing.assert_array_equal(compiled.q, [1, 2, 0.3, -1, 0, 0])
    np.testing.assert_array_equal(compiled.u, [4, 5, 6, 0, 0, 0])
    np.testing.assert_array_equal(compiled.model.loads.gravity, [1, -2])
    assert compiled.size == pytest.approx(0.4)
    assert {name for _, name in compiled.layout.points} == set(box.points)
    for (owner, name), index in compiled.layout.points.items():
        assert compiled.layout.bodies[compiled.model.points.body[index]] == owner
        np.testing.assert_array_equal(compiled.model.points.place[index], box.points[name].place)
    assert [(body, closed) for body, _, closed in compiled.layout.outlines] == [(0, True), (1, True)]


def test_compiling_twice_gives_the_same_arrays_and_leaves_the_scene_alone():
    scene, _, lower = rods()
    first = scene.compiled()
    again = scene.compiled()
    for group, same in zip(first.model, again.model, strict=True):
        for one, other in zip(group, same, strict=True):
            np.testing.assert_array_equal(one, other)
    scene.load(lf.Torque(lower.point("right"), 1.0))
    assert len(first.model.loads.force_kind) == 0
    with pytest.raises(ValueError, match="read-only"):
        first.q[0] = 1.0


def test_arrays_have_the_types_of_every_other_model():
    from lcpflex.model.arrays import bodiless_model

    scene, _, _ = rods()
    for group, reference in zip(scene.compiled().model, bodiless_model(1, 0, [], [], []), strict=True):
        for name, array, same in zip(group._fields, group, reference, strict=True):
            assert (array.dtype, array.ndim) == (same.dtype, same.ndim), name
            assert array.flags.c_contiguous, name
            assert not array.flags.writeable, name


def test_violated_start_is_refused_with_name_and_size():
    scene, _, _ = rods(position=(0.003, 0.004))
    with pytest.raises(lf.ModelError, match=r"'hinge'.*upper\.left.*position violates it by 0\.005 m.*project=True"):
        scene.compiled()
    scene, _, _ = rods(velocity=(0.0, 0.25))
    with pytest.raises(lf.ModelError, match=r"velocity violates it by 0\.25 m/s"):
        scene.compiled()


def test_projected_start_is_the_nearest_in_the_mass_metric():
    given = {"position": (0.02, -0.01), "angle": 0.05, "velocity": (0.3, 0.1), "angular_velocity": 0.7}
    scene, _, _ = rods(second_angle=0.4, **given)
    compiled = scene.compiled(project=True)
    found = violation(compiled.model, compiled.q.copy(), compiled.u.copy(), external(compiled))
    np.testing.assert_allclose(found.position, 0.0, atol=2e-12)
    np.testing.assert_allclose(found.velocity, 0.0, atol=1e-12)
    # u - u0 = M^-1 J^T x, so M (u - u0) has no part along the motions that the joints allow
    u0 = np.array([0.3, 0.1, 0.7, 0, 0, 0])
    push = mass_matrix(compiled.model, compiled.q) @ (compiled.u - u0)
    free = np.linalg.svd(found.jacobian)[2][len(found.position) :]
    np.testing.assert_allclose(free @ push, 0.0, atol=1e-12)
    assert np.abs(push).max() > 0.1


def test_a_consistent_start_is_projected_onto_itself_to_rounding():
    scene, _, _ = rods(second_angle=0.4)
    plain, projected = scene.compiled(), scene.compiled(project=True)
    np.testing.assert_allclose(projected.q, plain.q, atol=1e-15)
    np.testing.assert_allclose(projected.u, plain.u, atol=1e-15)


def test_contradicting_joints_are_refused_and_redundant_ones_are_not():
    scene, upper, _ = rods()
    scene.join(lf.Revolute(upper.point("left"), scene.ground.at(0, 0)))
    scene.compiled(project=True)
    scene.join(lf.Revolute(upper.point("left"), scene.ground.at(0.0, 0.1), name="elsewhere"))
    with pytest.raises(lf.ModelError, match="contradict"):
        scene.compiled(project=True)


def test_rest_values_are_those_of_the_start():
    scene = lf.Scene()
    box = lf.Box(width=1.0, height=1.0, mass=1.0)
    a = scene.add(box, "a", position=(0, 0), angle=0.2)
    b = scene.add(box, "b", position=(3, 4), angle=0.5)
    scene.join(lf.Distance(a.at(0, 0), b.at(0, 0)))
    scene.join(
        lf.Weld(
            a.at(0.3, 0.1),
            scene.ground.at(
                *(np.array([[math.cos(0.2), -math.sin(0.2)], [math.sin(0.2), math.cos(0.2)]]) @ [0.3, 0.1])
            ),
        )
    )
    scene.join(lf.DrivenAngle(b.at(0, 0), a.at(0, 0), lambda t: 0.0))
    scene.load(lf.Spring(a.at(0, 0), b.at(0, 0), stiffness=10.0))
    scene.load(lf.TorsionSpring(b.at(0, 0), a.at(0, 0), stiffness=10.0, angle=0.0))
    compiled = scene.compiled()
    np.testing.assert_allclose(compiled.model.joints.rest, [5.0, 0.0, 0.0, 0.2, 0.3])
    assert spring_energy(compiled.model, compiled.q.copy()) == pytest.approx(0.5 * 10.0 * 0.3**2, rel=1e-12)


def test_same_point_is_registered_once():
    scene, upper, lower = rods()
    for _ in range(3):
        scene.load(lf.Spring(upper.point("right"), lower.point("right"), stiffness=1.0))
    assert len(scene.compiled().model.points.body) == len(rods()[0].compile().model.points.body)


def test_mass_matrix_of_a_deformed_flexible_body():
    """Symmetric positive definite, and its kinetic energy is that of the finite elements."""
    beam = lf.Beam(length=0.7, width=0.03, thickness=0.02, density=2700, youngs_modulus=7e10, elements=6).reduce(
        modes=7
    )
    n = beam.modes
    random = np.random.default_rng(3)
    q = np.concatenate([[0.4, -0.2, 0.9], 1e-2 * random.normal(size=n)])
    u = np.concatenate([[1.0, 2.0, 3.0], random.normal(size=n)])
    scene = lf.Scene()
    placed = scene.add(beam, position=q[:2], angle=q[2], modal=q[3:])
    M = mass_matrix(scene.compiled().model, q)
    np.testing.assert_array_equal(M, M.T)
    assert np.linalg.eigvalsh(M).min() > 0.0
    # <v.v> / 2 of the absolute velocity field in body axes, v = A^T Rdot + omega J (x + Phi q) + Phi qdot
    cos, sin = math.cos(q[2]), math.sin(q[2])
    frame = np.array([cos * u[0] + sin * u[1], -sin * u[0] + cos * u[1]])

    def velocity(x):
        point = placed.at(x, 0.0).material
        s = point.place + q[3:] @ point.phi
        return frame + u[2] * np.array([-s[1], s[0]]) + u[3:] @ point.phi

    # consistent mass of a uniform beam: its shape functions are cubic, so 4 Gauss points an element are exact
    xi, weight = np.polynomial.legendre.leggauss(4)
    energy = 0.0
    for element in range(6):
        for g, w in zip(xi, weight, strict=True):
            x = 0.7 / 6 * (element + 0.5 * (1 + g))
            v = velocity(x)
            energy += 0.5 * 2700 * 0.03 * 0.02 * w * 0.7 / 12 * (v @ v)
    assert 0.5 * u @ M @ u == pytest.approx(energy, rel=1e-9)


def test_force_callbacks_see_the_state():
    scene = lf.Scene()
    beam = lf.Beam(length=0.5, width=0.03, thickness=0.01, density=2700, youngs_modulus=7e10, elements=8).reduce(
        modes=3
    )
    placed = scene.add(beam, "beam", position=(1, 2), angle=0.3, velocity=(0.5, 0.1), angular_velocity=2.0,
                       modal=[1e-3, 0, 0], modal_velocity=[0, 0.1, 0])  # fmt: skip
    tip = placed.point("right")
    seen = {}

    def pull(t, state):
        seen.update(
            place=state.position(tip), speed=state.velocity(tip), angle=state.angle(tip), body=state.angle(placed)
        )
        with pytest.raises(ValueError, match="read-only"):
            state.q[0] = 0.0
        return 3.0 * state.time, -2.0

    scene.load(lf.Force(tip, pull))
    compiled = scene.compiled()
    from types import SimpleNamespace

    from lcpflex.kinematics.points import point_angle, point_motion, point_position

    work = SimpleNamespace(free=SimpleNamespace(external=external(compiled)))
    compiled.system().hooks[supply](compiled.model, 0.5, compiled.q.copy(), compiled.u.copy(), work)
    np.testing.assert_array_equal(work.free.external[:, 0], [1.5, -2.0])
    model = compiled.model
    p = compiled.layout.points["beam", "right"]
    np.testing.assert_allclose(seen["place"], point_position(model.bodies, model.points, compiled.q, p), rtol=1e-14)
    np.testing.assert_allclose(
        seen["speed"], point_motion(model.bodies, model.points, compiled.q, compiled.u, p)[2:4], rtol=1e-13
    )
    assert seen["angle"] == pytest.approx(point_angle(model.bodies, model.points, compiled.q, p), rel=1e-14)
    assert seen["body"] == pytest.approx(0.3)
    driving = [np.zeros(len(compiled.q)) for _ in range(3)]
    applied_forces(model, 0.5, compiled.q.copy(), compiled.u.copy(), np.zeros(2), work.free.external, *driving)
    np.testing.assert_allclose(driving[2][:2], [1.5, -2.0], rtol=1e-15)


def test_a_scene_without_python_functions_stays_compiled():
    scene, _, lower = rods()
    scene.load(lf.Torque(lower.point("right"), lf.Harmonic(1.0, 2.0)))
    assert not scene.compiled().system().hooks
    scene.load(lf.Torque(lower.point("right"), math.sin))
    assert set(scene.compiled().system().hooks) == {supply}


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda t: (1.0, 2.0, 3.0), r"force at lower\.right: .*expected 2 finite numbers"),
        (lambda t: 1.0, "expected 2 finite numbers"),
        (lambda t: (math.nan, 0.0), "expected 2 finite numbers"),
        (lambda t: "push", "expected 2 finite numbers"),
        (lambda t: 1 / t, "raised ZeroDivisionError at t = 0 s"),
        (lambda t, state: state.speed, "raised AttributeError"),
    ],
)
def test_bad_force_functions_are_refused_when_compiled(function, message):
    scene, _, lower = rods()
    scene.load(lf.Force(lower.point("right"), function))
    with pytest.raises(lf.ModelError, match=message):
        scene.compiled()


def test_what_a_function_raises_is_chained():
    def broken(t):
        raise KeyError("missing")

    scene, _, lower = rods()
    scene.load(lf.Torque(lower.point("right"), broken, name="motor"))
    with pytest.raises(lf.ModelError, match="motor at lower") as caught:
        scene.compiled()
    assert isinstance(caught.value.__cause__, KeyError)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda s, a, b: s.add(lf.Box(1, 1, mass=1), "upper"), "name: 'upper' was given twice"),
        (lambda s, a, b: s.add(lf.Box(1, 1, mass=1), "ground"), "name: 'ground'"),
        (lambda s, a, b: s.add(lf.Beam(1, 0.1, 0.1, 1e3, 1e9)), "modes: none were given for Beam, expected a number"),
        (lambda s, a, b: s.add(lf.Box(1, 1, mass=1), position=(math.nan, 0)), "position"),
        (lambda s, a, b: s.add(lf.Box(1, 1, mass=1), velocity=(0, 0, 0)), "velocity"),
        (lambda s, a, b: s.add(lf.Box(1, 1, mass=1), angle=math.inf), "angle"),
        (lambda s, a, b: s.add(lf.Box(1, 1, mass=1), modal=[1.0]), "modal"),
        (lambda s, a, b: s.body("middle"), "no body 'middle', expected one of 'upper', 'lower'"),
        (lambda s, a, b: a.point("top"), "no point 'top', expected one of .*'left', 'right'"),
        (lambda s, a, b: a.surface("side"), "no surface 'side'"),
        (lambda s, a, b: a.point(["left"]), r"no point \['left'\]"),
        (lambda s, a, b: a.surface(["side"]), r"no surface \['side'\]"),
        (lambda s, a, b: s.body(["upper"]), r"no body \['upper'\]"),
        (lambda s, a, b: s.ground.chain(None), "places: None"),
        (lambda s, a, b: s.contact_all(exclude=a), "exclude: .*expected a list of pairs"),
        (lambda s, a, b: lf.Force(a.at(0, 0), (1.0, 0.0), follower="yes"), "follower: 'yes'"),
        (lambda s, a, b: s.ground.surface(), "make one with circle"),
        (lambda s, a, b: s.ground.circle((0, 0), -1.0), "radius: -1.0"),
        (lambda s, a, b: s.ground.half_plane((0, 0), (0, 0)), "normal"),
        (lambda s, a, b: s.ground.chain([(0, 0)]), "at least 2"),
        (lambda s, a, b: s.ground.arc((0, 0), 1.0, 0.0, 7.0), "extent: 7.0"),
        (lambda s, a, b: s.ground.circle(a.point("left"), 1.0), "expected a point of 'ground'"),
        (lambda s, a, b: s.join(lf.Revolute(a.point("left"), a.point("right"))), "same body"),
        (lambda s, a, b: s.join(lf.Revolute(s.ground.at(0, 0), s.ground.at(1, 0))), "both on the ground"),
        (lambda s, a, b: s.join(lf.Revolute(a, b)), "Revolute: P: .*expected a point"),
        (lambda s, a, b: s.join(lf.Revolute(a.at(0, 0), b.at(0, 0), name="hinge")), "name: 'hinge' was given twice"),
        (lambda s, a, b: s.join(lf.Spring(a.at(0, 0), b.at(0, 0), 1.0)), "expected a joint"),
        (lambda s, a, b: s.load(lf.Revolute(a.at(0, 0), b.at(0, 0))), "expected a Spring"),
        (lambda s, a, b: lf.Prismatic(a.at(0, 0), b.at(0, 0), axis=(0, 0)), "axis"),
        (lambda s, a, b: lf.Distance(a.at(0, 0), b.at(0, 0), length=0.0), "length"),
        (lambda s, a, b: lf.DrivenAngle(a.at(0, 0), b.at(0, 0), "fast"), "motion: 'fast'"),
        (lambda s, a, b: lf.DrivenAngle(a.at(0, 0), b.at(0, 0), math.nan), "motion: nan"),
        (lambda s, a, b: lf.Spring(a.at(0, 0), b.at(0, 0), stiffness=-1.0), "stiffness: -1.0"),
        (lambda s, a, b: lf.Force(a.at(0, 0), 3.0), r"expected a pair \(fx, fy\)"),
        (lambda s, a, b: lf.Force(a.at(0, 0), (3.0, math.nan)), r"value\[1\]: nan"),
        (lambda s, a, b: lf.Force(s.ground.at(0, 0), (1, 1)), "the ground does not move"),
        (lambda s, a, b: lf.Table([0.0, 0.0], [1.0, 2.0]), "increasing"),
        (lambda s, a, b: lf.Table([0.0, 1.0, 2.0], [1.0, 2.0]), "2 were given for 3 times"),
        (lambda s, a, b: lf.Harmonic(1.0, math.inf), "omega: inf"),
        (lambda s, a, b: lf.Scene(gravity=9.81), "gravity"),
        (lambda s, a, b: lf.Scene().compiled(), "no body"),
        (lambda s, a, b: lf.Scene().join(lf.Revolute(a.at(0, 0), b.at(0, 0))), "not of another one"),
        (lambda s, a, b: lf.Revolute(a.at(0, 0), lf.Scene().ground.at(0, 0)), "same scene"),
    ],
)  # fmt: skip
def test_bad_input(build, message):
    scene, upper, lower = rods()
    with pytest.raises(lf.ModelError, match=message):
        build(scene, upper, lower)


def test_a_distance_between_coinciding_points_is_refused():
    scene, upper, lower = rods()
    scene.join(lf.Distance(upper.point("right"), lower.point("left")))
    with pytest.raises(lf.ModelError, match="coincide"):
        scene.compiled()


def test_automatic_names_avoid_taken_ones():
    scene = lf.Scene()
    disc = lf.Disc(radius=0.1, mass=1.0)
    names = [scene.add(disc, name).name for name in ("body2", None, None, "body5", None)]
    assert names == ["body2", "body3", "body4", "body5", "body6"]
