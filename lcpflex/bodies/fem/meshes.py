"""Meshes of simple shapes, as scikit-fem meshes with named boundaries.

Elements are quadratic, which bend as the body does: one layer of them is enough. ``order=1`` makes linear ones, which
are much too stiff in bending unless there are many layers (a bar of square elements: one layer of quadrilaterals by
50 %, eight by 0.8 %; of two triangles each by 340 % and 5 %). They are for contact regions that are finely meshed
anyway: on linear elements alone, forces of contact are smooth from node to node.

Places are in metres. Besides these, everything of scikit-fem works: ``mesh.translated((dx, dy))``, ``mesh.refined()``,
``mesh.scaled(0.001)``, ``mesh.save(path)``. Local refinement towards a contact is :func:`graded`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import flag, numbers, positive
from lcpflex.bodies.body import array_of, whole_number
from lcpflex.bodies.fem.grading import ELEMENTS, Zone, named_again, refined_to
from lcpflex.bodies.fem.mesh import check_nodes
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["bar", "graded", "grid", "half_disc", "half_section_of_rod", "half_section_of_sphere", "quadratic"]


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ += ["rectangle", "ring"]

RAISED = {"MeshTri1": "MeshTri2", "MeshQuad1": "MeshQuad2"}  # classes of scikit-fem: linear to quadratic


def rectangle(length: float, height: float, nx: int, ny: int, *, triangles: bool = False, order: int = 2) -> Any:
    """Equal elements on 0 <= x <= length, 0 <= y <= height; boundaries "left", "right", "bottom", "top".

    Parameters
    ----------
    length, height : [m]
    nx, ny : numbers of elements along x and y
    triangles : two triangles in the place of each quadrilateral
    order : 2 for quadratic elements, 1 for linear ones

    Raises
    ------
    ModelError
        For sizes that are not positive, numbers below 1, or another order.
    """
    across, up = positive("length", length), positive("height", height)
    n = _counts(1, nx=nx, ny=ny)
    return grid(np.linspace(0.0, across, n[0] + 1), np.linspace(0.0, up, n[1] + 1), triangles=triangles, order=order)


def grid(x: npt.ArrayLike, y: npt.ArrayLike, *, triangles: bool = False, order: int = 2) -> Any:
    """Elements between grid lines; boundaries "left", "right", "bottom", "top".

    Parameters
    ----------
    x, y : (nx + 1,), (ny + 1,) ascending coordinates of the lines [m]
    triangles : two triangles in the place of each quadrilateral
    order : 2 for quadratic elements, 1 for linear ones

    Raises
    ------
    ModelError
        For fewer than two lines, lines that do not ascend, or another order.
    """
    raised = _is_quadratic(order)
    lines = [array_of(name, value, (-1,)) for name, value in (("x", x), ("y", y))]
    for name, line in zip(("x", "y"), lines, strict=True):
        if len(line) < 2 or not np.diff(line).min() > 0.0:
            raise ModelError(f"{name}: {shown(line)} was given, expected two ascending coordinates or more")
    mesh = (libs.skfem.MeshTri1 if flag("triangles", triangles) else libs.skfem.MeshQuad1).init_tensor(*lines)
    (x0, x1), (y0, y1) = (line[[0, -1]] for line in lines)
    mesh = mesh.with_boundaries(
        {
            "left": lambda at: at[0] == x0,
            "right": lambda at: at[0] == x1,
            "bottom": lambda at: at[1] == y0,
            "top": lambda at: at[1] == y1,
        }
    )
    return _raised(mesh, None) if raised else mesh


def bar(
    length: float, height: float, elements: int, *, across: int = 1, triangles: bool = False, order: int = 2
) -> Any:
    """A slender rectangle 0 <= x <= length about the x axis, |y| <= height / 2: ``elements`` by ``across`` elements.

    Boundaries "left", "right", "bottom", "top". The other parameters and errors are those of :func:`rectangle`.
    """
    _counts(1, elements=elements, across=across)
    mesh = rectangle(length, height, elements, across, triangles=triangles, order=order)
    return mesh.translated((0.0, -0.5 * height))


def ring(inner: float, outer: float, around: int, through: int, *, order: int = 2) -> Any:
    """A circular ring about the origin, of quadrilaterals; boundaries "inner" and "outer".

    Parameters
    ----------
    inner, outer : radii [m]
    around, through : numbers of elements
    order : 2 for quadratic elements, curved along the circles, 1 for linear ones

    Raises
    ------
    ModelError
        For radii that are not 0 < inner < outer, fewer than 3 elements around or 1 through, or another order.
    """
    raised = _is_quadratic(order)
    inside = positive("inner", inner)
    outside = in_range("outer", outer, inside, math.inf, open_ends=True)
    whole_number("around", around, 3)
    n, layers = _counts(1, around=around, through=through)
    angle = 2.0 * math.pi * np.arange(n) / n
    radius = np.linspace(inside, outside, layers + 1)
    places = np.stack([np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle))]).reshape(2, -1)
    number = np.arange(n * (layers + 1)).reshape(layers + 1, n)
    after = np.roll(number, -1, axis=1)
    cells = np.stack([number[:-1], number[1:], after[1:], after[:-1]]).reshape(4, -1)
    mesh = libs.skfem.MeshQuad1(places, cells)
    middle = 0.5 * (inside + outside)
    mesh = mesh.with_boundaries(
        {
            "inner": lambda at: np.hypot(*at) < middle,
            "outer": lambda at: np.hypot(*at) > middle,
        }
    )
    return _raised(mesh, _bent_around) if raised else mesh


def half_disc(radius: float, size: float, *, finest: float | None = None, within: float = 0.0, order: int = 2) -> Any:
    """Triangles on the half disc x^2 + y^2 <= radius^2, y <= 0, refined towards its pole (0, -radius).

    Boundaries "round" and "flat" (y = 0).

    Parameters
    ----------
    radius : [m]
    size : longest edge anywhere [m]
    finest : longest edge at the pole [m]; None for no refinement
    within : distance from the pole up to which edges are as short as that [m]; beyond, they grow by a fifth of theirs
    order : 2 for quadratic elements, curved along the circle, 1 for linear ones

    Raises
    ------
    ModelError
        For sizes that are not positive, finest > size, another order, or a mesh of more than a million elements.
    """
    R, raised = positive("radius", radius), _is_quadratic(order)
    mesh = _half_round(R, size, finest, within, np.array([0.0, -R]), -1.0)
    return _raised(mesh, _onto_circle(R)) if raised else mesh


def half_section_of_sphere(
    radius: float, size: float, *, finest: float | None = None, within: float = 0.0, order: int = 2
) -> Any:
    """Triangles on the half section x^2 + y^2 <= radius^2, y >= 0 of a sphere, refined towards its pole (radius, 0).

    For :class:`SolidOfRevolution`. Boundaries "round" and "axis" (y = 0). Parameters and errors are those of
    :func:`half_disc`.
    """
    R, raised = positive("radius", radius), _is_quadratic(order)
    mesh = _half_round(R, size, finest, within, np.array([R, 0.0]), 1.0)
    return _raised(mesh, _onto_circle(R)) if raised else mesh


def half_section_of_rod(
    length: float, radius: float, size: float, *, finest: float | None = None, within: float = 0.0, order: int = 2
) -> Any:
    """Triangles on the half section 0 <= x <= length, 0 <= y <= radius of a rod, refined towards (0, 0).

    For :class:`SolidOfRevolution`. Boundaries "left", "right", "bottom" (the axis), "top". The other parameters and
    errors are those of :func:`half_disc`.
    """
    whole, up, largest = positive("length", length), positive("radius", radius), positive("size", size)
    if not whole / largest * (up / largest) <= ELEMENTS:
        words = f"{whole:g} and {up:g} m were given with a size of {largest:g} m"
        raise ModelError(f"length, radius: {words}, expected a mesh of less than {ELEMENTS} elements")
    leg = largest / math.sqrt(2.0)
    counts = math.ceil(whole / leg * (1.0 - 1e-12)), math.ceil(up / leg * (1.0 - 1e-12))
    in_range("within", within, 0.0, math.inf)
    mesh = rectangle(whole, up, *counts, triangles=True, order=order)
    return mesh if finest is None else graded(mesh, (0.0, 0.0), finest, within=within)


def graded(mesh: Any, towards: npt.ArrayLike, finest: float, *, within: float = 0.0, growth: float = 0.2) -> Any:
    """The mesh of straight-sided triangles, split where edges are longer than ``finest + growth (distance - within)``.

    Parameters
    ----------
    mesh : MeshTri1 or MeshTri2 of scikit-fem; its boundaries keep their names, subdomains do not
    towards : (2,) a place, or (2, 2) both ends of a straight line, where contact is expected [m]
    finest : longest edge there [m]
    within : distance up to which edges are as short as that [m]
    growth : of the longest edge with the distance, in (0, 1]

    Raises
    ------
    ModelError
        For another kind of mesh, curved edges, numbers out of range, or more than a million elements.
    """
    name = type(mesh).__name__
    if name not in ("MeshTri1", "MeshTri2"):
        raise ModelError(f"mesh: {name} was given, expected a MeshTri1 or MeshTri2 of scikit-fem")
    coarse = mesh if name == "MeshTri1" else _lowered(mesh)
    ends = numbers(towards)
    if ends is None or ends.shape not in ((2,), (1, 2), (2, 2)):
        raise ModelError(f"towards: {shown(towards)} was given, expected a place or the two ends of a line")
    line = np.array(array_of("towards", np.atleast_2d(ends), (-1, 2)))
    slope = in_range("growth", growth, 1e-3, 1.0)
    zone = Zone(line, positive("finest", finest), math.inf, in_range("within", within, 0.0, math.inf), slope)
    fine = named_again(refined_to(coarse, zone, None), coarse)
    return fine if coarse is mesh else _raised(fine, None)


def quadratic(mesh: Any) -> Any:
    """The mesh with quadratic elements: nodes amid straight edges, and amid quadrilaterals; names are kept.

    One that has them comes back as it is. Raises :class:`ModelError` for anything but triangles and quadrilaterals of
    scikit-fem.
    """
    if type(mesh).__name__ not in RAISED.values():
        return _raised(mesh, None)
    check_nodes("mesh", mesh)
    return mesh


def _counts(least: int, **given: Any) -> list[int]:
    """Two numbers of elements that a mesh can have."""
    counts = [whole_number(name, value, least) for name, value in given.items()]
    if math.prod(counts) > ELEMENTS:
        told = " and ".join(str(count)[:30] for count in counts)
        raise ModelError(f"{', '.join(given)}: {told} were given, expected a mesh of less than {ELEMENTS} elements")
    return counts


def _few(name: str, length: float, size: float) -> None:
    """Refuse a length that no mesh of that size can cover, before elements are made."""
    if not length / size <= ELEMENTS**0.5:
        words = f"{length:g} m was given with a size of {size:g} m"
        raise ModelError(f"{name}: {words}, expected a mesh of less than {ELEMENTS} elements")


def _is_quadratic(order: Any) -> bool:
    return whole_number("order", order, 1, 2, " (linear or quadratic elements)") == 2


def _half_round(R: float, size: float, finest: float | None, within: float, pole: FloatArray, up: float) -> Any:
    """Three equal triangles, split until they are small enough, new boundary nodes put onto the circle."""
    largest = positive("size", size)
    _few("radius", R, largest)
    least = largest if finest is None else in_range("finest", finest, 0.0, largest * (1.0 + 1e-12))
    zone = Zone(pole[None], positive("finest", least), largest, in_range("within", within, 0.0, math.inf), 0.2)
    high = up * math.sqrt(0.75)
    places = R * np.array([[1.0, 0.5, -0.5, -1.0, 0.0], [0.0, high, high, 0.0, 0.0]])
    start = libs.skfem.MeshTri1(places, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4]]).T)
    if up < 0.0:  # the pole must be a node
        start = start.refined(np.array([1]))
        start = _moved(start, _onto_circle(R)(start.p, start.facets, start))
    mesh = refined_to(start, zone, lambda m: _moved(m, _onto_circle(R)(m.p, m.facets, m)))
    flat = "flat" if up < 0.0 else "axis"
    tall = 1e-9 * R
    return mesh.with_boundaries({"round": lambda at: np.abs(at[1]) > tall, flat: lambda at: np.abs(at[1]) <= tall})


def _moved(mesh: Any, places: FloatArray) -> Any:
    return libs.skfem.MeshTri1(places[:, : mesh.p.shape[1]], mesh.t)


Bend = Callable[[FloatArray, IntArray, Any], FloatArray]


def _onto_circle(R: float) -> Bend:
    """Puts nodes of the round boundary onto the circle."""

    def bend(places: FloatArray, facets: IntArray, mesh: Any) -> FloatArray:
        places = places.copy()
        edges = mesh.boundary_facets()
        middle = 0.5 * (mesh.p[:, facets[0, edges]] + mesh.p[:, facets[1, edges]])
        on_arc = edges[np.abs(middle[1]) > 1e-9 * R]
        nodes = np.unique(facets[:, on_arc])
        if places.shape[1] > mesh.p.shape[1]:
            nodes = np.concatenate([nodes, mesh.p.shape[1] + on_arc])  # of quadratic meshes: after the corners
        on_axis = np.abs(places[1, nodes]) <= 1e-9 * R
        nodes = nodes[~on_axis]
        places[:, nodes] *= R / np.hypot(*places[:, nodes])
        return places

    return bend


def _bent_around(places: FloatArray, facets: IntArray, mesh: Any) -> FloatArray:
    """Gives nodes amid edges and elements the mean radius of their corners."""
    radius = np.hypot(*mesh.p)
    wanted = np.concatenate([radius, radius[facets].mean(axis=0), radius[mesh.t].mean(axis=0)])[: places.shape[1]]
    return np.asarray(places * (wanted / np.hypot(*places)))


def _raised(mesh: Any, bend: Bend | None) -> Any:
    """The mesh with quadratic elements, its new nodes moved by ``bend``."""
    name = type(mesh).__name__
    if name not in RAISED:
        raise ModelError(f"mesh: {name} was given, expected triangles or quadrilaterals of scikit-fem")
    kind = getattr(libs.skfem, RAISED[name])
    raised = kind.from_mesh(mesh)
    if bend is not None:
        raised = kind(bend(np.asarray(raised.doflocs), mesh.facets, mesh), raised.t)
    if mesh.boundaries:
        raised = raised.with_boundaries({key: np.asarray(facets) for key, facets in mesh.boundaries.items()})
    return raised.with_subdomains(dict(mesh.subdomains)) if mesh.subdomains else raised


def _lowered(mesh: Any) -> Any:
    """The linear triangles on the corners of straight-sided quadratic ones, with the names of their boundaries."""
    check_nodes("mesh", mesh)
    places = np.asarray(mesh.doflocs)
    aside = places[:, mesh.dofs.facet_dofs[0]] - places[:, mesh.facets].mean(axis=1)
    if np.abs(aside).max() > 1e-9 * np.ptp(places, axis=1).max():
        worst = int(np.abs(aside).max(axis=0).argmax())
        x, y = places[:, mesh.dofs.facet_dofs[0, worst]]
        raise ModelError(f"mesh: an edge is curved at ({x:.6g}, {y:.6g}), expected straight ones, as of order=1")
    flat = libs.skfem.MeshTri1(places[:, : mesh.nvertices], mesh.t)
    return flat.with_boundaries({key: np.asarray(facets) for key, facets in (mesh.boundaries or {}).items()})
