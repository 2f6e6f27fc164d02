"""What a scene looks like: places of surfaces in the world, and the part of the plane to show."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lcpflex.basics import libs
from lcpflex.contact.narrow_phase.feature import ARC, SEGMENT
from lcpflex.kinematics.places import world_places
from lcpflex.model.coordinates import ALONG, ANGULAR, COMPONENT, DISTANCE

if TYPE_CHECKING:
    from collections.abc import Collection

    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = [
    "WHOLE",
    "Star",
    "View",
    "add_area",
    "add_line",
    "added_surfaces",
    "circle_points",
    "draw_bodies",
    "draw_ground",
    "draw_joints",
    "draw_surfaces",
    "features_of",
    "stars",
    "surfaces_of_bodies",
    "view_of",
]

View = tuple[float, float, float, float]  # x from, x to, y from, y to [m]
Star: TypeAlias = "tuple[list[IntArray], bool]"  # groups of material points, whether it is drawn thin

_BODY, _GROUND, _JOINT = "#0072B2", "#6E6E6E", "#202020"
_SOLID = "#D9D9D9"
WHOLE = 2.0 * np.pi - 1e-12  # extent of a whole circle
_STILL = np.zeros(0)  # the configuration of the ground, which has no coordinates
_MARGIN = 0.12  # of the picture, around what moves
_NEAR = 1.0  # an endless ground surface is shown if it is nearer to what moves than that is large


def view_of(result: Result, compiled: CompiledScene, records: IntArray) -> View:
    """The part of the plane that the bodies sweep in the given records, with the finite ground surfaces near it."""
    points = compiled.model.points
    drawn = [ids for body, ids, _ in compiled.layout.outlines if body >= 0]
    round_ones = [(p, radius) for p, radius in compiled.layout.circles if points.body[p] >= 0]
    centers = np.array([p for p, _ in round_ones], dtype=np.int64)
    moving = np.unique(np.concatenate([*drawn, *(ids for ends, _ in stars(compiled) for ids in ends), centers]))
    rim = max([radius for _, radius in round_ones] + _added_discs(compiled), default=0.0)
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for record in records[:: max(1, len(records) // 60)]:
        places = world_places(compiled.model, result.q[record], moving)
        low, high = np.minimum(low, places.min(axis=0) - rim), np.maximum(high, places.max(axis=0) + rim)
    reach = max(float((high - low).max()), 1e-9)
    for corner_low, corner_high in _ground_boxes(compiled):
        if np.all(corner_high > low - reach) and np.all(corner_low < high + reach):
            # Of a long floor only the part near the bodies is shown.
            low = np.minimum(low, np.maximum(corner_low, low - 0.3 * reach))
            high = np.maximum(high, np.minimum(corner_high, high + 0.3 * reach))
    for foot in _feet_on_half_planes(compiled, 0.5 * (low + high)):
        if np.all(foot > low - _NEAR * reach) and np.all(foot < high + _NEAR * reach):
            low, high = np.minimum(low, foot), np.maximum(high, foot)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = np.maximum(half, 0.3 * half.max()) + _MARGIN * 2.0 * half.max()  # no thinner than 1 : 3
    return (
        float(middle[0] - half[0]),
        float(middle[0] + half[0]),
        float(middle[1] - half[1]),
        float(middle[1] + half[1]),
    )


def add_line(ax: Axes, xs: ArrayLike, ys: ArrayLike, **style: Any) -> None:
    """``ax.plot`` where the limits are known: without what finds them, three times as fast."""
    ax.add_artist(libs.Line2D(xs, ys, **style))


def add_area(ax: Axes, corners: FloatArray, **style: Any) -> None:
    """``ax.fill`` likewise, six times as fast: corners (k, 2)."""
    ax.add_artist(libs.Polygon(corners, **style))


def draw_bodies(ax: Axes, compiled: CompiledScene, q: FloatArray, drawn: list[Star]) -> None:
    """Stars, deformed outlines with their holes left open, and discs of all bodies at the configuration q (ndof,)."""
    model = compiled.model
    for ids, thin in drawn:
        _draw_star(ax, compiled, q, ids, thin)
    loops: dict[int, list[libs.Path]] = {}
    for body, points, closed in compiled.layout.outlines:
        if body >= 0:
            xy = world_places(model, q, points)
            if closed:
                xy = np.vstack([xy, xy[:1]])
                loops.setdefault(body, []).append(libs.Path(xy, closed=True))
            add_line(ax, xy[:, 0], xy[:, 1], color=_BODY, linewidth=1.2, solid_joinstyle="round")
    for paths in loops.values():  # a hole runs around the other way: it is left open
        whole = libs.Path.make_compound_path(*paths)
        ax.add_artist(libs.PathPatch(whole, facecolor=_BODY, alpha=0.2, edgecolor="none"))
    for point, radius in compiled.layout.circles:
        body = int(model.points.body[point])
        if body >= 0:
            x, y = world_places(model, q, np.array([point]))[0]
            ax.add_artist(
                libs.Circle((x, y), radius, facecolor=(0.0, 0.447, 0.698, 0.2), edgecolor=_BODY, linewidth=1.2)
            )
            angle = q[model.bodies.dof[body] + 2]
            spoke = (x + radius * np.cos(angle), y + radius * np.sin(angle))
            add_line(ax, [x, spoke[0]], [y, spoke[1]], color=_BODY, linewidth=0.8)


def _draw_star(ax: Axes, compiled: CompiledScene, q: FloatArray, ends: list[IntArray], thin: bool) -> None:
    """Lines to the means of groups of material points of a body: from its origin, or from their middle where thick."""
    model = compiled.model
    places = np.array([world_places(model, q, ids).mean(axis=0) for ids in ends])
    start = int(model.bodies.dof[model.points.body[ends[0][0]]])
    middle = q[start : start + 2] if thin else places.mean(axis=0)
    for end in places:
        add_line(ax, *np.array([middle, end]).T, color=_BODY, linewidth=0.8 if thin else 2.0)


def stars(compiled: CompiledScene) -> list[Star]:
    """What bodies without an outline are drawn as: groups of points that lines end at, and whether those are thin.

    A body of points alone is a star to them, which is a rod where there are two. One of discs and surfaces shows these,
    and thin lines tell what belongs together: to each of them and to its joints and springs.
    """
    model, owners = compiled.model, compiled.model.points.body
    held = np.unique(np.concatenate([model.joints.point.ravel(), model.loads.spring_point.ravel()]))
    surfaces = surfaces_of_bodies(compiled)
    outlined = {body for body, _, _ in compiled.layout.outlines}
    circles: dict[int, list[IntArray]] = {}
    for point, _ in compiled.layout.circles:
        circles.setdefault(int(owners[point]), []).append(np.array([point]))
    order = np.argsort(owners, kind="stable")
    found = []
    for body in (int(b) for b in np.unique(owners) if b >= 0 and int(b) not in outlined):
        shapes = circles.get(body, [])
        shapes += [np.unique(features_of(compiled, surface)) for surface in surfaces.get(body, [])]
        points = order[np.searchsorted(owners, body, "left", order) : np.searchsorted(owners, body, "right", order)]
        ends = points if not shapes else np.intersect1d(held, points)
        found.append(([*([point] for point in ends), *shapes], bool(shapes)))
    return [([np.asarray(ids) for ids in ends], thin) for ends, thin in found if len(ends) > 1 or not thin]


def features_of(compiled: CompiledScene, surface: int) -> IntArray:
    """Material points of the features of a surface, (k, 2)."""
    contacts = compiled.model.contacts
    return np.asarray(contacts.feature_point[contacts.feature_start[surface] : contacts.feature_start[surface + 1]])


def surfaces_of_bodies(compiled: CompiledScene) -> dict[int, list[int]]:
    """Surfaces of each body that are not part of its outline or one of its discs."""
    contacts, points = compiled.model.contacts, compiled.model.points
    shapes: dict[int, list[FloatArray]] = {}
    for body, ids, _ in compiled.layout.outlines:
        shapes.setdefault(body, []).append(points.place[ids])
    for point, _ in compiled.layout.circles:
        shapes.setdefault(int(points.body[point]), []).append(points.place[[point]])
    known = {body: {tuple(place) for place in np.vstack(places).round(12)} for body, places in shapes.items()}
    found: dict[int, list[int]] = {}
    for surface, body in enumerate(contacts.surface_body):
        places = points.place[features_of(compiled, surface).ravel()].round(12)
        if body >= 0 and not {tuple(place) for place in places} <= known.get(int(body), set()):
            found.setdefault(int(body), []).append(surface)
    return found


def added_surfaces(compiled: CompiledScene) -> set[int]:
    """Those that were put on bodies and are no part of their shapes."""
    return {surface for surfaces in surfaces_of_bodies(compiled).values() for surface in surfaces}


def _added_discs(compiled: CompiledScene) -> list[float]:
    """Radii of whole discs that were put on bodies without a shape of their own [m]."""
    contacts = compiled.model.contacts
    features = [
        f for s in added_surfaces(compiled) for f in range(contacts.feature_start[s], contacts.feature_start[s + 1])
    ]
    whole = [f for f in features if contacts.feature_kind[f] == ARC and contacts.feature_span[f, 1] >= WHOLE]
    return [float(abs(contacts.feature_radius[f])) for f in whole if contacts.feature_sense[f] > 0]


def draw_ground(ax: Axes, compiled: CompiledScene, view: View) -> None:
    """Ground surfaces; half-planes are filled up to the edge."""
    for surface in np.flatnonzero(compiled.model.contacts.surface_body < 0):
        _draw_surface(ax, compiled, _STILL, int(surface), view, added=False)


def draw_surfaces(ax: Axes, compiled: CompiledScene, q: FloatArray, view: View, added: Collection[int]) -> None:
    """Surfaces on bodies that are no outlines: those that were put on them (``added``), holes and half-planes."""
    for surface in np.flatnonzero(compiled.model.contacts.surface_body >= 0):
        _draw_surface(ax, compiled, q, int(surface), view, int(surface) in added)


def _draw_surface(ax: Axes, compiled: CompiledScene, q: FloatArray, surface: int, view: View, added: bool) -> None:
    contacts, model = compiled.model.contacts, compiled.model
    body = int(contacts.surface_body[surface])
    first, last = contacts.feature_start[surface], contacts.feature_start[surface + 1]
    straight = contacts.feature_kind[first:last] == SEGMENT
    for f in np.arange(first, last)[~straight]:
        _draw_arc(ax, compiled, q, int(f), body, added)
    endless = not np.isfinite(contacts.surface_extent[surface])
    if not (endless or body < 0 or added):
        return
    ends = world_places(model, q, features_of(compiled, surface)[straight].ravel()).reshape(-1, 2, 2)
    if not endless:
        _draw_sides(ax, ends, view, body < 0)
        return
    for a, b in ends:
        _draw_half_plane(ax, a, b, view, _GROUND if body < 0 else _BODY)


def _draw_arc(ax: Axes, compiled: CompiledScene, q: FloatArray, f: int, body: int, added: bool) -> None:
    """A piece of a circle; whole discs of bodies are drawn as their outlines."""
    contacts = compiled.model.contacts
    radius, hole = abs(contacts.feature_radius[f]), contacts.feature_sense[f] < 0
    whole = contacts.feature_span[f, 1] >= WHOLE
    if radius <= 0.0 or not (body < 0 or added or hole or not whole):
        return
    centre = world_places(compiled.model, q, contacts.feature_point[f])[0]
    xy = centre + radius * circle_points(contacts.feature_span[f], _angle_of(compiled, q, body))
    if not hole and (body < 0 or (added and whole)):
        shade = _SOLID if body < 0 else (0.0, 0.447, 0.698, 0.2)
        add_area(ax, xy, facecolor=shade, edgecolor="none")
    add_line(ax, xy[:, 0], xy[:, 1], color=_GROUND if body < 0 else _BODY, linewidth=1.2)


def _draw_sides(ax: Axes, ends: FloatArray, view: View, on_ground: bool) -> None:
    """Straight sides (k, 2, 2) of a chain, hatched on the solid side if it is the ground's, filled if a closed body."""
    if not len(ends):
        return
    ax.add_collection(
        libs.LineCollection(list(ends), colors=_GROUND if on_ground else _BODY, linewidths=1.2, capstyle="round")
    )
    if on_ground:
        for a, b in ends:
            _hatch(ax, a, b, view)
    elif len(ends) > 2 and np.array_equal(ends[1:, 0], ends[:-1, 1]) and np.array_equal(ends[0, 0], ends[-1, 1]):
        add_area(ax, ends[:, 0], facecolor=_BODY, alpha=0.2, edgecolor="none")


def draw_joints(ax: Axes, compiled: CompiledScene, q: FloatArray) -> None:
    """Hinges as circles, other joints as squares, rods as lines, linear springs as dotted lines."""
    model = compiled.model
    for first, last, points in zip(model.joints.row, model.joints.row[1:], model.joints.point, strict=False):
        xy, kinds = world_places(model, q, points), model.joints.kind[first:last].tolist()
        if DISTANCE in kinds:
            add_line(ax, xy[:, 0], xy[:, 1], color=_JOINT, linewidth=1.2, zorder=3)
        mark = "s" if ALONG in kinds or (COMPONENT in kinds and ANGULAR[kinds].any()) else "o"
        ends = xy if DISTANCE in kinds else xy[:1]
        style = {"linestyle": "", "marker": mark, "markersize": 6, "markerfacecolor": "white"}
        add_line(ax, ends[:, 0], ends[:, 1], color=_JOINT, zorder=4, **style)
    for kind, points in zip(model.loads.spring_kind, model.loads.spring_point, strict=True):
        if not ANGULAR[kind]:
            xy = world_places(model, q, points)
            add_line(ax, xy[:, 0], xy[:, 1], color=_JOINT, linewidth=1.6, linestyle=":", zorder=3)


def _ground_boxes(compiled: CompiledScene) -> list[tuple[FloatArray, FloatArray]]:
    """Bounding boxes (low, high) of the finite ground surfaces."""
    contacts = compiled.model.contacts
    boxes = []
    for surface in np.flatnonzero((contacts.surface_body < 0) & np.isfinite(contacts.surface_extent)):
        features = slice(contacts.feature_start[surface], contacts.feature_start[surface + 1])
        if contacts.feature_start[surface] < contacts.feature_start[surface + 1]:
            places = compiled.model.points.place[contacts.feature_point[features].ravel()]
            radius = np.abs(contacts.feature_radius[features]).max()
            boxes.append((places.min(axis=0) - radius, places.max(axis=0) + radius))
    return boxes


def _feet_on_half_planes(compiled: CompiledScene, place: FloatArray) -> list[FloatArray]:
    """The place of each endless ground surface that is nearest to ``place``."""
    contacts = compiled.model.contacts
    feet = []
    for surface in np.flatnonzero((contacts.surface_body < 0) & ~np.isfinite(contacts.surface_extent)):
        for f in range(contacts.feature_start[surface], contacts.feature_start[surface + 1]):
            a, b = compiled.model.points.place[contacts.feature_point[f]]
            along = (b - a) / np.hypot(*(b - a))
            feet.append(a + along * ((place - a) @ along))
    return feet


def _angle_of(compiled: CompiledScene, q: FloatArray, body: int) -> float:
    return 0.0 if body < 0 else float(q[compiled.model.bodies.dof[body] + 2])


def circle_points(span: FloatArray, turn: float, a_radian: float = 30.0) -> FloatArray:
    """Points of a unit arc from its start angle over its extent, turned by ``turn``: (k, 2), so many a radian."""
    extent = min(float(span[1]), 2.0 * np.pi)
    angles = turn + float(span[0]) + np.linspace(0.0, extent, max(8, round(extent * a_radian)))
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _draw_half_plane(ax: Axes, a: FloatArray, b: FloatArray, view: View, colour: str) -> None:
    """The line through a and b, and the part of the view on its left filled."""
    x0, x1, y0, y1 = view
    along = (b - a) / np.hypot(*(b - a))
    inward = np.array([-along[1], along[0]])
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    depth = (corners - a) @ inward
    inside, border = [], []
    for k in range(4):
        this, following = depth[k], depth[(k + 1) % 4]
        if this >= 0.0:
            inside.append(corners[k])
        if (this >= 0.0) != (following >= 0.0):
            crossing = corners[k] + this / (this - following) * (corners[(k + 1) % 4] - corners[k])
            inside.append(crossing)
            border.append(crossing)
    if inside:
        add_area(ax, np.array(inside), facecolor=_SOLID, edgecolor="none", zorder=0)
    if len(border) == 2:
        add_line(ax, *np.array(border).T, color=colour, linewidth=1.2)


def _hatch(ax: Axes, a: FloatArray, b: FloatArray, view: View) -> None:
    """Short strokes on the solid side of a segment, its left."""
    picture = max(view[1] - view[0], view[3] - view[2])
    length = float(np.hypot(*(b - a)))
    if length == 0.0:
        return
    along = (b - a) / length
    stroke = 0.015 * picture * (np.array([-along[1], along[0]]) - along)
    feet = [a + along * s for s in np.arange(0.5, min(length / (0.025 * picture), 400.0)) * 0.025 * picture]
    ax.add_collection(libs.LineCollection([(foot, foot + stroke) for foot in feet], colors=_GROUND, linewidths=0.6))
