"""The convex relaxation of friction: its own exact solutions, where it is Coulomb's law and where it is not."""

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Lemke, Status
from lcpflex.solvers.contact.cone import ConvexFriction
from lcpflex.solvers.contact.relaxation import ConvexContactProblem


def mass_point(mu: float, slide: float, factor: bool) -> ContactProblem:
    """A mass point of 1 kg that arrives at the floor with (slide, -1) m/s."""
    return ContactProblem(None if factor else np.eye(2), [-1.0, slide], [mu], factor=np.eye(2) if factor else None)


def pile(seed: int, form: str, mu: tuple[float, float] = (0.05, 2.0), heavy: float = 0.0) -> ContactProblem:
    """Bodies with three degrees of freedom, touching at points; some contacts are smooth, many redundant.

    The free velocity is that of a solution: forces in the cones, velocities in their duals, at right angles. It is one
    to the last digit only, as others cannot be where contacts squeeze a body: products are those of long doubles, of
    factors of few digits, and so the same by any BLAS and on any processor.
    """
    rng = np.random.default_rng(seed)
    bodies, contacts = rng.integers(1, 8), rng.integers(1, 20)
    friction = np.where(rng.random(contacts) < 0.3, 0.0, rng.uniform(*mu, contacts))
    rows = np.zeros((2 * contacts, 3 * bodies))
    for k in range(contacts):
        body, angle, arm = rng.integers(bodies), rng.uniform(0.0, np.pi), rng.uniform(-1.0, 1.0, 2)
        for row, direction in ((k, [np.cos(angle), np.sin(angle)]), (contacts + k, [-np.sin(angle), np.cos(angle)])):
            moment = arm[0] * direction[1] - arm[1] * direction[0]
            rows[row, 3 * body : 3 * body + 3] = [*direction, moment]
    J = rows[np.append(np.full(contacts, True), friction > 0.0)]
    J = np.round(J, 8) / np.round(10.0 ** rng.uniform(-0.5 * heavy, 0.5 * heavy, 3 * bodies), 6)
    mu_of = friction[friction > 0.0]
    side = rng.choice([-1.0, 0.3, 1.0], len(mu_of))
    pressed = np.where(rng.random(contacts) < 0.6, rng.uniform(0.5, 1.5, contacts), 0.0)
    slip = np.where(np.abs(side) == 1.0, -side * rng.uniform(0.0, 1.0, len(mu_of)), 0.0)
    lifted = np.where(pressed > 0.0, 0.0, rng.uniform(0.0, 2.0, contacts))
    lifted[friction > 0.0] += mu_of * np.abs(slip)
    forces = np.concatenate([pressed, side * mu_of * pressed[friction > 0.0]])
    long = J.astype(np.longdouble)
    free = (np.concatenate([lifted, slip]) - long @ (long.T @ forces)).astype(float)
    factor = {"delassus": None, "factor": J, "sparse": scipy.sparse.csr_array(J)}[form]
    return ContactProblem((long @ long.T).astype(float) if factor is None else None, free, friction, factor=factor)


@pytest.mark.parametrize("factor", [False, True])
class TestMassPoint:
    @pytest.mark.parametrize("slide", [0.2, -0.2, 0.0, 0.49])
    def test_sticks_as_coulombs_law_has_it(self, slide, factor):
        problem = mass_point(0.5, slide, factor)
        solution = ConvexFriction().solve(problem)
        assert solution.solved
        assert solution.z == pytest.approx([1.0, -slide], abs=1e-10)
        assert solution.w == pytest.approx([0.0, 0.0], abs=1e-10)
        assert ConvexContactProblem(problem).lift(solution.z) == pytest.approx(0.0, abs=1e-10)
        coulomb = Lemke().solve(problem.lcp())
        assert np.concatenate(problem.forces(coulomb.z)) == pytest.approx(solution.z, abs=1e-10)

    @pytest.mark.parametrize("mu", [0.01, 0.5, 2.0])
    @pytest.mark.parametrize("slide", [3.0, -3.0, 100.0])
    def test_is_lifted_where_it_slides(self, mu, slide, factor):
        # lambda_N - 1 = v_N = mu |v_T| and |v_T| = |slide| - mu lambda_N.
        normal = (1.0 + mu * abs(slide)) / (1.0 + mu * mu)
        slip = slide - np.sign(slide) * mu * normal
        problem = mass_point(mu, slide, factor)
        solution = ConvexFriction().solve(problem)
        assert solution.solved
        assert solution.z == pytest.approx([normal, -np.sign(slide) * mu * normal], rel=1e-9)
        assert solution.w == pytest.approx([mu * abs(slip), slip], rel=1e-9)
        assert ConvexContactProblem(problem).lift(solution.z) == pytest.approx(mu * abs(slip), rel=1e-9)
        assert f"{mu * abs(slip):.3g}" in solution.message
        assert problem.residual(problem.unknowns(solution.z[:1], solution.z[1:])) > 1e-4 * mu  # not Coulomb's law

    def test_feels_a_floor_that_it_leaves_if_it_slides_fast(self, factor):
        J = np.eye(2) if factor else None
        for slide, expected in ((0.3, [0.0, 0.0]), (1.9, [0.56, -1.12])):  # 1 + n = 2 (1.9 - 2 n): v = (1.56, 0.78)
            problem = ContactProblem(None if factor else np.eye(2), [1.0, slide], [2.0], factor=J)
            solution = ConvexFriction().solve(problem)
            assert solution.solved
            assert solution.z == pytest.approx(expected, rel=1e-9, abs=1e-10)


def test_says_everywhere_that_it_is_another_model():
    solution = ConvexFriction().solve(mass_point(0.5, 3.0, False))
    assert ConvexFriction.model == ConvexFriction().model == "convex relaxation"
    assert "not Coulomb's law" in solution.route
    assert "lifts sliding contacts by up to 1" in solution.message
    assert solution.keys == ((0, "N"), (0, "T"))


@pytest.mark.parametrize("form", ["delassus", "factor", "sparse"])
@pytest.mark.parametrize("seed", range(25))
def test_relaxed_law_holds_at_every_point(seed, form):
    problem = pile(seed, form)
    solution = ConvexFriction().solve(problem)
    assert solution.solved
    n, tangent = len(problem.friction), problem.tangent
    mu = problem.friction[tangent]
    v = problem.velocity(solution.z)
    force, speed = np.abs(solution.z).max(initial=1.0), np.abs(problem.free).max()
    assert (np.abs(solution.z[n:]) <= mu * solution.z[:n][tangent] + 1e-12 * force).all()
    assert (v[:n] >= -1e-8 * speed).all()
    assert (v[:n][tangent] >= mu * np.abs(v[n:]) - 1e-8 * speed).all()
    assert abs(solution.z @ v) <= 1e-8 * force * speed


@pytest.mark.parametrize("seed", [*range(10), 39, 80, 120, 282])
def test_masses_of_many_magnitudes(seed):
    for form in ("delassus", "factor"):
        assert ConvexFriction().solve(pile(seed, form, heavy=4.0)).solved


@pytest.mark.parametrize("seed", [4, 6, 21, 24, 45])
def test_cones_that_are_nearly_a_line(seed):
    assert ConvexFriction().solve(pile(seed, "delassus", mu=(1e-7, 1e-5))).solved


def test_all_forms_give_the_same_velocity():
    for seed in range(10):
        velocities = [ConvexFriction().solve(pile(seed, form)).w for form in ("delassus", "factor", "sparse")]
        for other in velocities[1:]:
            assert other == pytest.approx(velocities[0], abs=1e-7)


@pytest.mark.parametrize("seed", range(10))
def test_without_friction_it_is_the_complementarity_problem(seed):
    problem = pile(seed, "delassus")
    n = len(problem.friction)
    smooth = ContactProblem(problem.delassus[:n, :n], problem.free[:n] + 0.1, np.zeros(n))
    relaxed, exact = ConvexFriction().solve(smooth), Lemke().solve(smooth.lcp())
    assert relaxed.solved == exact.solved
    if exact.solved:
        assert relaxed.w == pytest.approx(exact.w, abs=1e-7)
        assert smooth.residual(relaxed.z) <= 1e-10


class TestResidual:
    relaxed = ConvexContactProblem(mass_point(0.5, 3.0, False))

    def test_is_zero_at_the_solution_only(self):
        assert self.relaxed.residual([2.0, -1.0]) == 0.0
        for wrong in ([1.0, -0.5], [2.0, 1.0], [0.0, 0.0], [2.0, -1.1], [-2.0, -1.0], [2.1, -1.0]):
            assert self.relaxed.residual(wrong) > 1e-2
        assert self.relaxed.residual([1.0, -0.5], scaled=False) == pytest.approx(1.0)  # half of the cone is passed by 1

    @pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e308])
    def test_is_large_for_what_is_no_number(self, wrong):
        assert self.relaxed.residual([wrong, 0.0]) > 1e-2
        assert self.relaxed.residual([2.0, wrong]) > 1e-2

    @pytest.mark.parametrize("form", ["delassus", "factor", "sparse"])
    def test_knows_the_projection_on_the_cone(self, form):
        # A step of a projection must not come nearer by any other point of the cone.
        problem, rng = pile(3, form), np.random.default_rng(5)
        relaxed = ConvexContactProblem(problem)
        n, tangent = len(problem.friction), problem.tangent
        for _ in range(20):
            point = rng.standard_normal(relaxed.size)
            nearest = relaxed._projected(point)
            normal = np.abs(rng.standard_normal(n))
            other = np.concatenate([normal, (problem.friction * normal)[tangent] * rng.uniform(-1, 1, len(tangent))])
            assert (point - nearest) @ (other - nearest) <= 1e-12
            assert (np.abs(nearest[n:]) <= (problem.friction * nearest[:n])[tangent] + 1e-15).all()

    def test_refuses_other_shapes(self):
        with pytest.raises(ModelError, match=r"z has shape \(3,\): expected \(2,\)"):
            self.relaxed.residual([1.0, 2.0, 3.0])
        with pytest.raises(ModelError, match="contact is a Lcp"):
            ConvexContactProblem(Lcp([[1.0]], [1.0]))

    def test_lift_is_that_of_pressed_contacts(self):
        # Two mass points: one lies, one flies off with 5 m/s; then the first slides, and is lifted by 1 m/s.
        still = ContactProblem(np.eye(4), [-1.0, 5.0, 0.0, 0.0], [0.5, 0.5])
        assert ConvexContactProblem(still).lift([1.0, 0.0, 0.0, 0.0]) == 0.0
        slides = ContactProblem(np.eye(4), [-1.0, 5.0, 3.0, 0.0], [0.5, 0.5])
        assert ConvexContactProblem(slides).lift([2.0, 0.0, -1.0, 0.0]) == 1.0


class TestHonesty:
    @pytest.mark.parametrize("mu", [0.0, 0.3])
    @pytest.mark.parametrize("factor", [False, True])
    def test_closing_jaws_have_no_solution(self, mu, factor):
        rows = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])[: 4 if mu else 2]
        free = [-1.0, -1.0, 0.2, 0.2][: len(rows)]
        problem = ContactProblem(None if factor else rows @ rows.T, free, [mu, mu], factor=rows if factor else None)
        solution = ConvexFriction().solve(problem)
        assert solution.status is Status.NUMERICAL_FAILURE
        assert "no solution" in solution.message

    @pytest.mark.parametrize("size", [1e-320, 1e-200, 1e200, 1e308])
    @pytest.mark.parametrize("speed", [1e-300, 1.0, 1e300])
    @pytest.mark.parametrize("factor", [False, True])
    def test_numbers_that_overflow_raise_nothing_and_pass_for_nothing(self, size, speed, factor):
        free = [-speed, 0.1 * speed]
        if factor:
            problem = ContactProblem(None, free, [0.5], factor=size * np.eye(2))
        else:
            problem = ContactProblem(size * np.eye(2), free, [0.5])
        solution = ConvexFriction().solve(problem)
        assert solution.solved == (ConvexContactProblem(problem).residual(solution.z) <= 1e-10)
        assert solution.solved or solution.message

    def test_indefinite_matrix(self):
        solution = ConvexFriction().solve(ContactProblem([[1.0, 2.0], [2.0, 1.0]], [-1.0, -1.1], [0.0, 0.0]))
        assert solution.solved == (solution.residual <= 1e-10)

    def test_refuses_what_has_no_contacts(self):
        reason = ConvexFriction().refuses(Lcp([[1.0]], [-1.0]))
        assert "pose a ContactProblem" in reason
        with pytest.raises(ModelError, match="pose a ContactProblem"):
            ConvexFriction().solve(Lcp([[1.0]], [-1.0]))
        assert ConvexFriction().refuses(mass_point(0.5, 1.0, True)) == ""

    def test_nothing_to_do(self):
        for problem in (ContactProblem(np.zeros((0, 0)), [], []), ContactProblem(np.eye(2), [0.0, 0.0], [0.3])):
            solution = ConvexFriction().solve(problem)
            assert solution.solved
            assert (solution.z == 0.0).all()

    def test_large_problems_are_left_as_clarabel_solved_them(self, monkeypatch):
        monkeypatch.setattr("lcpflex.solvers.contact.cone.LARGEST", 1)
        solution = ConvexFriction(1e-6).solve(pile(4, "sparse"))
        assert solution.solved
        assert "active set" not in solution.route
