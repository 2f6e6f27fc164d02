"""Contact in space by convex programs, by their relaxation, and with a faceted cone."""

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import (
    ConicFixedPoint,
    ContactProblem,
    ConvexFriction,
    FacetedCone,
    Lcp,
    SpatialContactProblem,
    Status,
)
from lcpflex.solvers.contact.cones.conic import RelaxedSpatialProblem
from lcpflex.solvers.contact.cones.facets import FacetedContactProblem, nearest_in_polygon
from tests.cone_problems import planted, puck

FIXED = ConicFixedPoint(1e-11, 300)


def stored(problem, way):
    """The same problem with its operator kept otherwise."""
    given = {
        "dense": (problem.delassus, None),
        "sparse": (scipy.sparse.csr_array(problem.delassus), None),
        "factor": (None, problem.factor),
        "sparse factor": (None, scipy.sparse.csr_array(problem.factor)),
    }[way]
    return SpatialContactProblem(given[0], problem.free, problem.friction, factor=given[1])


WAYS = ["dense", "sparse", "factor", "sparse factor"]


class TestFixedPoint:
    @pytest.mark.parametrize("n", [1, 2, 6, 15])
    def test_finds_planted_solutions(self, n):
        """With friction up to 0.7 solutions of well conditioned problems are unique: it is the planted one."""
        rng = np.random.default_rng(n)
        for _ in range(4):
            problem, r = planted(rng, n, columns=6 * n, largest=0.7)
            found = FIXED.solve(problem)
            assert found.solved, found.message
            assert found.z == pytest.approx(r, abs=1e-8)
            assert found.w == pytest.approx(problem.slack(r), abs=1e-8)
            assert found.keys == problem.unknown_keys

    @pytest.mark.parametrize("way", WAYS)
    def test_however_the_operator_is_kept(self, way):
        problem, _ = planted(np.random.default_rng(3), 6, columns=30, largest=0.7)
        assert FIXED.solve(stored(problem, way)).z == pytest.approx(FIXED.solve(problem).z, abs=1e-9)

    def test_unsymmetric_operators(self):
        problem, r = planted(np.random.default_rng(4), 5, columns=30, largest=0.5)
        W = problem.delassus + 0.01 * np.random.default_rng(5).standard_normal((15, 15))
        free = problem.slack(r) - W @ r
        other = SpatialContactProblem(W, free, problem.friction)
        found = FIXED.solve(other)
        assert found.solved
        assert found.z == pytest.approx(r, abs=1e-8)

    def test_redundant_supports(self):
        """Four feet on a floor: forces are not unique, the motion is; all slide against their common velocity."""
        problem = puck([0.3, 0.4, -1.0, 0.0, 0.0, 0.0], mu=0.2)
        found = FIXED.solve(problem)
        assert found.solved
        total = problem.forces(found.z).sum(axis=0)
        assert total == pytest.approx([2.0, -0.2 * 2.0 * 0.6, -0.2 * 2.0 * 0.8], abs=1e-9)

    def test_a_guess_saves_programs(self):
        problem, _ = planted(np.random.default_rng(8), 10, columns=35)
        first = ConicFixedPoint().solve(problem)
        moved = SpatialContactProblem(problem.delassus, problem.free * 1.001, problem.friction)
        assert first.solved
        assert ConicFixedPoint().solve(moved, first).iterations < ConicFixedPoint().solve(moved).iterations

    def test_units_do_not_matter(self):
        problem, _ = planted(np.random.default_rng(9), 5, columns=20)
        d = np.repeat(4.0 ** np.array([-3, 4, 0, 2, -1]), 3)
        other = SpatialContactProblem(problem.delassus * np.outer(d, d), problem.free * d, problem.friction)
        assert FIXED.solve(other).z * d == pytest.approx(FIXED.solve(stored(problem, "dense")).z, abs=1e-8)

    def test_what_has_no_solution_is_not_solved(self):
        """A body between jaws that close: no force opens them."""
        row = np.array([[1.0], [0.0], [0.0], [-1.0], [0.0], [0.0]])
        jaws = SpatialContactProblem(None, [-1.0, 0.0, 0.0, -1.0, 0.0, 0.0], [0.3, 0.3], factor=row)
        assert not ConicFixedPoint().solve(jaws).solved
        assert not ConvexFriction().solve(jaws).solved
        assert not FacetedCone().solve(jaws).solved

    def test_planar_problems_are_refused(self):
        for problem in (Lcp(np.eye(2), [-1.0, 1.0]), ContactProblem(np.eye(2), [-1.0, 0.1], [0.3])):
            for solver in (ConicFixedPoint(), FacetedCone()):
                with pytest.raises(
                    ModelError,
                    match=f"problem: .* was given to {type(solver).__name__}, expected a SpatialContactProblem",
                ):
                    solver.solve(problem)
                assert "expected a SpatialContactProblem" in solver.refuses(problem)

    @pytest.mark.parametrize("bad", [0, -1, 1.5, None])
    def test_limits(self, bad):
        with pytest.raises(ModelError, match="pass_limit is"):
            ConicFixedPoint(pass_limit=bad)


class TestRelaxation:
    @pytest.mark.parametrize("way", WAYS)
    def test_obeys_its_own_law(self, way):
        """Forces in the cones, velocities in the dual cones, no power between them."""
        problem, _ = planted(np.random.default_rng(11), 8, columns=30)
        found = ConvexFriction().solve(stored(problem, way))
        assert found.solved
        r, u, mu = problem.forces(found.z), found.w.reshape(-1, 3), problem.friction
        slip, rubbed = np.hypot(u[:, 1], u[:, 2]), np.hypot(r[:, 1], r[:, 2])
        assert (rubbed <= mu * r[:, 0] + 1e-10).all()
        assert (u[:, 0] >= mu * slip - 1e-9).all()
        assert np.einsum("ij,ij->i", r, u) == pytest.approx(np.zeros(8), abs=1e-9)

    def test_is_another_model_and_says_so(self):
        problem = puck([0.3, 0.4, -1.0, 0.0, 0.0, 0.0], mu=0.2)
        found = ConvexFriction().solve(problem)
        lift = RelaxedSpatialProblem(problem).lift(found.z)
        assert lift == pytest.approx(0.2 * np.hypot(*found.w[1:3]), rel=1e-9)
        assert f"lifts sliding contacts by up to {lift:.3g}" in found.message
        assert "not Coulomb's law" in found.route
        assert problem.residual(found.z) > 1e-3

    def test_sticking_is_coulombs_law(self):
        problem = puck([0.01, 0.0, -1.0, 0.0, 0.0, 0.0], mu=0.5)
        found = ConvexFriction().solve(problem)
        assert problem.residual(found.z) < 1e-12

    def test_unsymmetric_operators_are_refused(self):
        problem = SpatialContactProblem([[1.0, 0.2, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [-1.0, 0.0, 1.0], [0.3])
        with pytest.raises(ModelError, match="delassus is unsymmetric"):
            ConvexFriction().solve(problem)


def single(angle, speed=1.0):
    """One contact of a mass point that slides that way."""
    return SpatialContactProblem(np.eye(3), [-1.0, speed * np.cos(angle), speed * np.sin(angle)], [0.3])


class TestFacets:
    @pytest.mark.parametrize("m", [4, 8, 16, 32])
    def test_dissipation_and_direction_are_off_as_stated(self, m):
        """Short by 1 - cos(pi / m) and off by pi / m where slip points to the middle of an edge, nowhere more."""
        short, off = [], []
        for angle in np.pi / m + np.linspace(0.0, 2.0 * np.pi / m, 41)[:-1] + 1e-5:
            found = FacetedCone(m).solve(single(angle, 1e6))
            assert found.solved
            r, u = found.z, found.w
            short.append(1.0 + r[1:] @ u[1:] / (0.3 * r[0] * np.linalg.norm(u[1:])))
            turned = np.arctan2(-r[2], -r[1]) - np.arctan2(u[2], u[1])
            off.append(abs((turned + np.pi) % (2.0 * np.pi) - np.pi))
        assert max(short) == pytest.approx(1.0 - np.cos(np.pi / m), rel=1e-3)
        assert max(off) == pytest.approx(np.pi / m, rel=1e-3)
        assert min(short) == pytest.approx(0.0, abs=1e-3 / m**2)

    def test_the_cone_itself_has_no_directions(self):
        """The friction of a puck against its direction: the same to 1e-8 with the cone, not with facets."""
        size, faceted = [], []
        for angle in np.linspace(0.0, np.pi, 25):
            problem = puck([np.cos(angle), np.sin(angle), -1.0, 0.0, 0.0, 0.0], mu=0.2)
            for solver, found in ((FIXED, size), (FacetedCone(), faceted)):
                found.append(np.hypot(*problem.forces(solver.solve(problem).z)[:, 1:].sum(axis=0)))
        assert np.ptp(size) < 1e-8 * max(size)
        assert np.ptp(faceted) > 0.05 * max(faceted)

    @pytest.mark.parametrize("n", [1, 3, 8])
    def test_its_law_holds(self, n):
        rng = np.random.default_rng(20 + n)
        problem, _ = planted(rng, n)
        for m in (4, 6, 8):
            found = FacetedCone(m).solve(problem)
            assert found.solved
            assert FacetedContactProblem(problem, m).residual(found.z) < 1e-12
            assert FacetedContactProblem(problem, m).residual(found.z + 1e-3) > 1e-5
            assert f"a cone of {m} facets, whose direction is off by up to {180 / m:.3g} degrees" in found.message

    def test_many_facets_come_near_the_cone(self):
        problem, r = planted(np.random.default_rng(31), 4, columns=24, largest=0.5)
        off = [np.abs(FacetedCone(m).solve(problem).z - r).max() for m in (8, 32, 128)]
        assert off[0] > off[1] > off[2]
        assert off[2] < 2e-2 * np.abs(r).max()

    def test_projection_on_polygons(self):
        """Against the nearest point of each edge."""
        rng = np.random.default_rng(2)
        for m in (4, 6, 8, 12):
            points, radius = rng.standard_normal((60, 2)), rng.uniform(0.0, 1.5, 60)
            found = nearest_in_polygon(points, radius, m)
            angle = 2.0 * np.pi * np.arange(m + 1) / m
            corners = np.column_stack([np.cos(angle), np.sin(angle)])
            along = np.diff(corners, axis=0)
            normal = np.column_stack([np.cos(angle[:-1] + np.pi / m), np.sin(angle[:-1] + np.pi / m)])
            for point, size, near in zip(points, radius, found, strict=True):
                if (normal @ point).max() <= size * np.cos(np.pi / m):
                    assert near == pytest.approx(point, abs=1e-15)
                    continue
                start, edge = size * corners[:-1], size * along
                share = np.clip(np.einsum("ij,ij->i", point - start, edge) / (edge**2).sum(axis=1), 0.0, 1.0)
                least = np.linalg.norm(start + share[:, None] * edge - point, axis=1).min()
                assert np.linalg.norm(near - point) == pytest.approx(least, rel=1e-12)
                assert (normal @ near).max() <= size * np.cos(np.pi / m) + 1e-12

    @pytest.mark.parametrize("bad", [3, 5, 2, 0, 8.5, None, 1002])
    def test_directions(self, bad):
        with pytest.raises(ModelError, match=r"directions.*expected"):
            FacetedCone(bad)

    def test_too_many_unknowns_are_refused(self):
        problem = SpatialContactProblem(scipy.sparse.eye_array(1500, format="csr"), np.ones(1500), np.full(500, 0.3))
        with pytest.raises(ModelError, match="the LCP of faceted cones has 5000 rows"):
            FacetedCone().solve(problem)


def test_nothing_moves():
    still = SpatialContactProblem(np.eye(6), np.zeros(6), [0.3, 0.0])
    empty = SpatialContactProblem([], [], [])
    for solver in (ConicFixedPoint(), FacetedCone(), ConvexFriction()):
        for problem in (still, empty):
            found = solver.solve(problem)
            assert found.status is Status.SOLVED
            assert not found.z.any()
