"""What cannot be reduced is refused: node choices, pieces, mechanisms, loose rests, sizes, in words."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.matrices import Matrices
from lcpflex.bodies.reduction.component_modes import (
    craig_bampton,
    free_interface,
    residual_compliance,
    sub_regional,
    unreduced,
)
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
from lcpflex.errors import ModelError

pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")  # coarse on purpose

STEEL = (7800.0, 2e11, 0.3)
ALL = list(range(21))


@cache
def plate():
    return Continuum(meshes.rectangle(1.0, 0.2, 6, 2, order=1), *STEEL, sets={"tip": lambda x, y: x > 0.6})


def pair(shared: int) -> Matrices:
    """Two plates that share so many nodes of the side between them."""
    mesh = plate().finite_elements()
    count = len(mesh.places)
    right = mesh.sets["right"][:shared]
    number = np.arange(2 * count)
    opposite = np.array([np.hypot(*(mesh.places - p + [1.0, 0.0]).T).argmin() for p in mesh.places[right]], dtype=int)
    number[count + opposite] = right
    used, number = np.unique(number, return_inverse=True)
    places = np.vstack([mesh.places, mesh.places + np.array([1.0, 0.0])])[used]
    spread = np.zeros((4 * count, 2 * len(used)))
    for d in (0, 1):
        spread[2 * np.arange(2 * count) + d, 2 * number + d] = 1.0
    both = [np.kron(np.eye(2), matrix.toarray()) for matrix in (mesh.mass, mesh.stiffness)]
    return Matrices(*(spread.T @ matrix @ spread for matrix in both), places)


@pytest.mark.parametrize("dense_limit", [0, 1200])
@pytest.mark.parametrize(
    "reduce",
    [
        lambda model: free_interface(model, 3),
        lambda model: craig_bampton(model, [0, 1, 2, 30, 31], 3),
        lambda model: sub_regional(model, [0, 1, 2, 3, 4], 3),
        lambda model: residual_compliance(model, [0, 1], 3),
        unreduced,
    ],
)
def test_pieces_and_mechanisms(reduce, dense_limit: int, monkeypatch) -> None:
    monkeypatch.setattr("lcpflex.bodies.reduction.eigenmodes.DENSE_LIMIT", dense_limit)
    with pytest.raises(ModelError, match="2 pieces of 21, 21 nodes"):
        reduce(pair(0))
    with pytest.raises(ModelError, match="more zero modes than the 3 rigid motions"):
        reduce(pair(1))  # a hinge
    assert reduce(pair(2)).modes > 0


@pytest.mark.parametrize(
    ("reduce", "argument"), [(craig_bampton, "boundary"), (sub_regional, "region"), (residual_compliance, "contact")]
)
@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ("nose", "'nose' was given, expected one of .*'tip', .* node sets of the mesh"),
        (["tip", "nose"], "'nose' was given"),
        (["tip", 3], "expected the name of a node set, several, or node numbers"),
        ([], "expected the name of a node set"),
        (b"tip", "expected the name of a node set"),
        ([1.0, 2.0], "expected the name of a node set"),
        ([True], "expected the name of a node set"),
        ([-1], "node -1 was given, expected nodes from 0 to 20"),
        ([3, 21], "node 21"),
        ([3, 4, 3], "node 3 was given 2 times"),
    ],
)
def test_node_choices(reduce, argument: str, choice, message: str) -> None:
    with pytest.raises(ModelError, match=f"^{argument}: .*{message}"):
        reduce(plate(), choice, 3)


def test_names_sequences_and_numbers_choose_the_same() -> None:
    mesh = plate().finite_elements()
    nodes = mesh.sets["tip"]
    for choice in ("tip", ["tip"], ["tip", "right"], nodes, nodes.tolist(), nodes[::-1]):
        assert craig_bampton(plate(), choice, 3).stiffness == pytest.approx(craig_bampton(plate(), "tip", 3).stiffness)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: craig_bampton(plate(), [3]), "1 node.*can still move"),
        (lambda: craig_bampton(pair(2), [14], 2), "1 node.*can still move"),
        (lambda: craig_bampton(pair(2), int(plate().finite_elements().sets["right"][0]), 2), "can still move"),
        (lambda: craig_bampton(plate(), ALL), "modes: 20 .*0 modes with its boundary held"),
        (lambda: craig_bampton(plate(), [0, 1], 39), "modes: 39 .*to 38"),
        (lambda: craig_bampton(plate(), [0, 1], -1), "modes: -1"),
        (lambda: sub_regional(plate(), ALL), "all 21 nodes"),
        (lambda: sub_regional(plate(), "left", interface_modes=False), "border on the rest"),
        (lambda: sub_regional(plate(), "tip", interface_modes=1), "interface_modes: 1"),
        (lambda: sub_regional(plate(), "tip", 40), "modes: 40"),
        (lambda: residual_compliance(plate(), "tip", 40), "modes: 40 .*39"),
        (lambda: free_interface(plate(), 40), "modes: 40 .*39"),
        (lambda: free_interface(plate(), 2, damping=[0.1]), "damping"),
        (lambda: craig_bampton(plate(), "tip", 2, damping=-0.1), "damping"),
        (lambda: residual_compliance(plate(), "tip", 2, damping=[0.1]), "damping"),
        (lambda: unreduced(plate(), damping=float("nan")), "damping: nan"),
        (lambda: craig_bampton(plate(), "tip", 2, stiffening=3), "stiffening: 3"),
        (lambda: free_interface(lf.Box(1.0, 1.0, mass=1.0)), "model: Body"),
        (lambda: free_interface(Continuum), "model: <class"),
        (lambda: free_interface(None), "model: NoneType"),
    ],
)
def test_bad_input(make, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


def test_one_node_holds_an_axisymmetric_mesh() -> None:
    rod = SolidOfRevolution(meshes.rectangle(1.0, 0.2, 6, 2, order=1), *STEEL)
    middle = int(np.hypot(*(rod.finite_elements().places - [0.5, 0.1]).T).argmin())
    assert craig_bampton(rod, middle, 3).modes == 3 + 2 - 1


def test_what_does_not_fit_is_refused(monkeypatch) -> None:
    large = Continuum(meshes.rectangle(1.0, 0.5, 80, 40, order=1), *STEEL)  # 6642 degrees of freedom
    with pytest.raises(ModelError, match=r"model: .*6642 degrees of freedom.* GiB.*6000"):
        unreduced(large)
    with pytest.raises(ModelError, match=r"6639 .*needs the full eigenproblem"):
        free_interface(large, None)
    monkeypatch.setattr("lcpflex.bodies.reduction.eigenmodes.MEMORY", 2**22)
    for reduce in (craig_bampton, residual_compliance, sub_regional):
        with pytest.raises(ModelError, match=r"full columns of 6642 degrees.* GiB.*fewer nodes"):
            reduce(large, [0, 1, 2, 3])


class Given:
    """A mesh of someone else's, unchecked."""

    def __init__(self, **changes) -> None:
        self.mesh = replace(plate().finite_elements(), **changes)

    def finite_elements(self):
        return self.mesh


@pytest.mark.parametrize("reduce", [craig_bampton, sub_regional, residual_compliance])
def test_meshes_that_nobody_checked(reduce) -> None:
    mesh = plate().finite_elements()
    for name in ("mass", "stiffness"):
        matrix = getattr(mesh, name).copy()
        matrix.data[7] = np.nan
        with pytest.raises(ModelError, match=f"{name} has entries that are not finite"):
            reduce(Given(**{name: matrix}), "tip", 3)
    indefinite = mesh.mass.tolil()
    for a, b in ((0, 8), (1, 9)):
        indefinite[a, b] = indefinite[b, a] = -10.0 * mesh.mass.max()
    with pytest.raises(ModelError, match=r"mass: .*indefinite|mass: its rigid-body part"):
        reduce(Given(mass=indefinite.tocsc()), "tip", 3)
    with pytest.raises(ModelError, match=r"stiffness: .*indefinite|boundary: .*can still move"):
        reduce(Given(stiffness=-mesh.stiffness), "tip", 3)
    with pytest.raises(ModelError, match="the node set 'none' is empty"):
        reduce(Given(sets={"none": np.zeros(0, dtype=np.int64)}), "none", 3)


@pytest.mark.filterwarnings("ignore:stiffness, mass, coordinates")
def test_units_do_not_matter() -> None:
    mesh = plate().finite_elements()
    given = mesh.mass, mesh.stiffness, mesh.places
    for factors in ((1e-12, 1, 1), (1, 1e12, 1), (1, 1, 1e-9), (1, 1, 1e9)):
        scaled = Matrices(*(part * factor for part, factor in zip(given, factors, strict=True)))
        for reduce in (craig_bampton, sub_regional, residual_compliance):
            here, there = reduce(Matrices(*given), [0, 1, 2, 3], 3), reduce(scaled, [0, 1, 2, 3], 3)
            assert there.stiffness == pytest.approx(here.stiffness * factors[1] / factors[0], rel=1e-9)


def test_a_mesh_too_slender_for_double_precision_is_told_of_beams() -> None:
    bar = meshes.bar(1.0, 1e-4, 200)
    with pytest.raises(ModelError, match=r"so slender .* \(a Beam then\)"):
        Continuum(bar, *STEEL).reduce(3)
    slender = Continuum(meshes.bar(1.0, 1e-3, 200), 7800.0, 2e11, 0.0, thickness=0.01).reduce(3)
    assert slender.frequencies() == pytest.approx(lf.Beam(1.0, 0.01, 1e-3, 7800.0, 2e11).reduce(3).frequencies(), 1e-4)
