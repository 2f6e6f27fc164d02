"""How much too stiff meshes are: the number, the estimate, the warning, and the example of the readme."""

from __future__ import annotations

import textwrap
import warnings
from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.reduction.component_modes import craig_bampton, residual_compliance, sub_regional, unreduced
from lcpflex.bodies.reduction.eigenmodes import FreeMesh
from lcpflex.errors import ModelError, ModelWarning

ALUMINIUM = {"density": 2700.0, "youngs_modulus": 7e10}
README = Path(__file__).parents[3] / "README.md"


def continuum(mesh, ratio=0.33, plane_strain=False) -> lf.Continuum:
    return lf.Continuum(mesh, **ALUMINIUM, poissons_ratio=ratio, thickness=0.02, plane_strain=plane_strain)


def layers(count: int, triangles: bool, order: int = 1):
    return meshes.bar(0.3, 0.02, 60, across=count, triangles=triangles, order=order)


def graded(order: int):
    return meshes.graded(meshes.bar(0.3, 0.02, 60, triangles=True, order=order), (0.3, 0.01), 0.001)


STIFF = {
    "a layer of triangles": (lambda: layers(1, True), 0.33, False, 0.9),
    "three layers of triangles": (lambda: layers(3, True), 0.33, False, 0.98),
    "eight layers of triangles": (lambda: layers(8, True), 0.33, False, 0.98),
    "a layer of quadrilaterals": (lambda: layers(1, False), 0.33, False, 0.98),
    "graded triangles": (lambda: graded(1), 0.33, False, 0.8),
    "plane strain, quadrilaterals": (lambda: meshes.bar(1.0, 0.1, 40, across=4, order=1), 0.47, True, 0.97),
    "plane strain, triangles": (lambda: meshes.bar(1.0, 0.1, 80, across=8, triangles=True, order=1), 0.47, True, 0.95),
    "a ring": (lambda: meshes.ring(0.9, 1.0, 60, 1, order=1), 0.3, False, 0.98),
    "a quadratic ring of eight": (lambda: meshes.ring(0.8, 1.0, 8, 1), 0.3, False, 0.8),
}
RIGHT = {
    "quadratic quadrilaterals": lambda: layers(1, False, 2),
    "quadratic triangles": lambda: layers(1, True, 2),
    "graded quadratic triangles": lambda: graded(2),
    "three layers of quadrilaterals": lambda: layers(3, False),
    "sixteen layers of triangles": lambda: meshes.bar(0.3, 0.02, 120, across=16, triangles=True, order=1),
    "a fine half disc": lambda: meshes.half_disc(0.01, 1e-3, finest=1e-4, order=1),
}

QUICK = ("quadratic quadrilaterals", "a fine half disc")


def estimate(model) -> tuple[np.ndarray, np.ndarray]:
    """(3,) excess of stiffness of the lowest modes, estimated, and of the next finer mesh."""
    mesh = model.finite_elements()
    omega2, shapes = FreeMesh.of(mesh).modes(3)
    finer, _ = FreeMesh.of(mesh.finer()).modes(3)
    return mesh.excess(omega2, shapes), omega2 / finer - 1.0


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "eight layers of triangles")) for name in STIFF]
)
def test_a_mesh_that_is_too_stiff_is_told_when_a_body_is_made(name: str) -> None:
    mesh, ratio, plane_strain, share = STIFF[name]
    model = continuum(mesh(), ratio, plane_strain)
    found, exact = estimate(model)
    assert share * exact[0] < found[0] <= exact[0] * (1.0 + 1e-9)
    assert model.stiffness_error() == pytest.approx(exact.max())
    with pytest.warns(ModelWarning, match=rf"about {100.0 * found.max():.0f} % too high .*quadratic\(mesh\)") as said:
        model.reduce(3)
    assert said[0].filename == __file__


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in RIGHT])
def test_a_mesh_that_is_right_is_not(name: str) -> None:
    model = continuum(RIGHT[name]())
    for reduce in (model.reduce, lambda: craig_bampton(model, [0, 1], 0), lambda: residual_compliance(model, [0], 0)):
        reduce()
    assert 0.0 <= model.stiffness_error() < 0.1


@pytest.mark.slow
def test_every_reduction_tells_it() -> None:
    model = continuum(layers(3, True))
    ways = [
        lambda reduce=reduce, n=n: reduce(model, "right", n)
        for n in (0, 1, 20)
        for reduce in (craig_bampton, residual_compliance)
    ]
    ways += [lambda: sub_regional(model, "right", 5), lambda: unreduced(model), lambda: model.reduce(2, interfaces=[0])]
    ways.append(lambda: model.reduce(2, stiffening=lf.Stiffening(held="left", axial_force=1e5)))
    for way in ways:
        with pytest.warns(ModelWarning, match="about 3[23] % too high"):
            way()
    model.reduce(0)  # rigid


@pytest.mark.slow
def test_linear_solids_of_revolution_are_judged_along_their_axis() -> None:
    coarse, fine = (lf.SolidOfRevolution(meshes.half_section_of_sphere(1.0, h, order=1), 2700.0, 7e10, 0.3)
                    for h in (0.4, 0.1))  # fmt: skip
    found, exact = estimate(coarse)
    assert (0.7 * exact < found).all()
    assert (found <= exact).all()
    with pytest.warns(ModelWarning, match="its stiffness"):
        coarse.reduce(3)
    fine.reduce(3)
    assert fine.stiffness_error() < 0.02


@pytest.mark.parametrize("triangles", [True, False])
def test_the_next_finer_mesh_is_the_same_body(triangles: bool) -> None:
    for order in (1, 2):
        mesh = meshes.rectangle(2.0, 1.0, 4, 3, triangles=triangles, order=order).translated((0.1, 0.2))
        model = continuum(mesh)
        coarse, fine = model.finite_elements(), model.finite_elements().finer()
        nx, ny = (8, 6) if order == 1 else (16, 12)
        assert len(fine.places) == (nx + 1) * (ny + 1)
        for one in (coarse, fine):
            assert float(one.mass.sum()) == pytest.approx(2.0 * 2700.0 * 2.0 * 0.02)  # along x and along y
        stretched = (fine.places * [3e-4, -2e-4]).ravel()
        other = (coarse.places * [3e-4, -2e-4]).ravel()
        assert stretched @ fine.stiffness @ stretched == pytest.approx(other @ coarse.stiffness @ other, rel=1e-11)


def test_curved_edges_stay_curved_on_the_finer_mesh() -> None:
    mesh = continuum(meshes.ring(0.8, 1.0, 12, 1)).finite_elements()
    fine = mesh.finer()
    assert float(fine.mass.sum()) == pytest.approx(float(mesh.mass.sum()), rel=1e-12)
    assert np.hypot(*fine.places.T).max() == pytest.approx(1.0, rel=2e-3)


def test_matrices_have_no_elements_to_judge() -> None:
    parts = continuum(layers(1, True)).finite_elements()
    model = lf.Matrices(parts.mass, parts.stiffness, parts.places)
    model.reduce(3)
    assert model.finite_elements().excess is None


@pytest.mark.slow
def test_the_mesh_of_the_readme_bends_as_a_converged_one_does(capsys: pytest.CaptureFixture[str]) -> None:
    """Its code as it stands there; against one that is split twice, within 3 %."""
    text = README.read_text(encoding="utf-8")
    start = text.index("    mesh = lf.meshes.graded(")
    code = textwrap.dedent(text[start : text.index("\n\n", start)])
    given: dict[str, object] = {"lf": lf}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(code, given)
    shown = capsys.readouterr().out
    plate = given["plate"]
    assert shown == f"too stiff by {100 * plate.stiffness_error():.1f} %\n"
    assert f"# {100 * plate.stiffness_error():.1f} %" in code
    converged = continuum(meshes.bar(0.3, 0.02, 120, across=8)).reduce(1).frequencies()[0]
    assert 0.0 <= (plate.reduce(1).frequencies()[0] / converged) ** 2 - 1.0 < 0.03
    linear = continuum(graded(1)).stiffness_error()
    assert f"by {100 * linear:.0f} %" in text


def test_a_model_without_elements_is_refused() -> None:
    from lcpflex.bodies.fem.stiffness_error import stiffness_error

    parts = continuum(layers(1, True)).finite_elements()
    with pytest.raises(ModelError, match="a mesh without elements was given"):
        stiffness_error(lf.Matrices(parts.mass, parts.stiffness, parts.places).finite_elements())
