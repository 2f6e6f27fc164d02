"""What a scene looks like: places of surfaces in the world, and the part of the plane to show."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.joints import DISTANCE, DRIVEN_ANGLE, REVOLUTE
from lcpflex.result import world_places
from lcpflex.summary import with_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lcpflex.compiled import FloatArray, IntArray
    from lcpflex.result import Result
    from lcpflex.scene import Compiled

__all__ = ["View", "draw_bodies", "draw_forces", "draw_joints", "draw_surfaces", "view_of"]

View = tuple[float, float, float, float]  # x from, x to, y from, y to [m]

_BODY, _GROUND, _FORCE, _JOINT = "#0072B2", "#6E6E6E", "#D55E00", "#202020"
_SOLID = "#D9D9D9"
_SEGMENT, _ARC = 0, 1  # kinds of features
_MARGIN = 0.12  # of the picture, around what moves
_ARROW = 0.2  # length of an arrow of the force that sets the scale, relative to the picture
_CORNER = 1e-6  # sides whose distances differ by less meet at the place [m]
_LONGEST = 1.5  # forces beyond that are cut to this many times its length


def view_of(result: Result, compiled: Compiled, records: IntArray) -> View:
    """The part of the plane that the bodies sweep in the given records, with the finite ground surfaces near it."""
    points = compiled.model.points
    drawn = [ids for body, ids, _ in compiled.layout.outlines if body >= 0]
    round_ones = [(p, radius) for p, radius in compiled.layout.circles if points.body[p] >= 0]
    centers = np.array([p for p, _ in round_ones], dtype=np.int64)
    moving = np.unique(np.concatenate([*drawn, *_shapeless(compiled), centers]))
    rim = max((radius for _, radius in round_ones), default=0.0)
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
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = np.maximum(half, 0.3 * half.max()) + _MARGIN * 2.0 * half.max()  # no thinner than 1 : 3
    return (
        float(middle[0] - half[0]),
        float(middle[0] + half[0]),
        float(middle[1] - half[1]),
        float(middle[1] + half[1]),
    )


def draw_bodies(ax: Axes, compiled: Compiled, q: FloatArray) -> None:
    """Deformed outlines, with their holes left open, and discs of all bodies at the configuration q (ndof,)."""
    from matplotlib.patches import Circle, PathPatch
    from matplotlib.path import Path

    model = compiled.model
    for points in _shapeless(compiled):  # a star to its points; of a rod, a line
        xy = world_places(model, q, points)
        for end in xy:
            ax.plot(*np.array([xy.mean(axis=0), end]).T, color=_BODY, linewidth=2.0)
    loops: dict[int, list[Path]] = {}
    for body, points, closed in compiled.layout.outlines:
        if body >= 0:
            xy = world_places(model, q, points)
            if closed:
                xy = np.vstack([xy, xy[:1]])
                loops.setdefault(body, []).append(Path(xy, closed=True))
            ax.plot(xy[:, 0], xy[:, 1], color=_BODY, linewidth=1.2, solid_joinstyle="round")
    for paths in loops.values():  # a hole runs around the other way: it is left open
        ax.add_patch(PathPatch(Path.make_compound_path(*paths), facecolor=_BODY, alpha=0.2, edgecolor="none"))
    for point, radius in compiled.layout.circles:
        body = int(model.points.body[point])
        if body >= 0:
            x, y = world_places(model, q, np.array([point]))[0]
            ax.add_patch(Circle((x, y), radius, facecolor=(0.0, 0.447, 0.698, 0.2), edgecolor=_BODY, linewidth=1.2))
            angle = q[model.bodies.dof[body] + 2]
            spoke = (x + radius * np.cos(angle), y + radius * np.sin(angle))
            ax.plot([x, spoke[0]], [y, spoke[1]], color=_BODY, linewidth=0.8)


def _shapeless(compiled: Compiled) -> list[IntArray]:
    """Material points of each body that has neither outline nor circle."""
    owners = compiled.model.points.body
    shaped = {body for body, _, _ in compiled.layout.outlines} | {int(owners[p]) for p, _ in compiled.layout.circles}
    bodies = [body for body in np.unique(owners) if body >= 0 and int(body) not in shaped]
    return [np.flatnonzero(owners == body) for body in bodies]


def draw_surfaces(ax: Axes, compiled: Compiled, q: FloatArray, view: View) -> None:
    """Ground surfaces (half-planes filled up to the edge of the view) and arcs, holes and half-planes on bodies."""
    contacts, model = compiled.model.contacts, compiled.model
    for surface in range(len(contacts.surface_body)):
        on_ground = contacts.surface_body[surface] < 0
        colour = _GROUND if on_ground else _BODY
        first, last = contacts.feature_start[surface], contacts.feature_start[surface + 1]
        endless = not np.isfinite(contacts.surface_extent[surface])
        for f in range(first, last):
            a, b = world_places(model, q, contacts.feature_point[f])
            if contacts.feature_kind[f] == _ARC:
                radius, hole = abs(contacts.feature_radius[f]), contacts.feature_sense[f] < 0
                if radius > 0.0 and (on_ground or hole or contacts.feature_span[f, 1] < 2.0 * np.pi - 1e-12):
                    turn = _angle_of(compiled, q, int(contacts.surface_body[surface]))
                    xy = a + radius * _circle_points(contacts.feature_span[f], turn)
                    if not hole and on_ground:
                        ax.fill(xy[:, 0], xy[:, 1], facecolor=_SOLID, edgecolor="none")
                    ax.plot(xy[:, 0], xy[:, 1], color=colour, linewidth=1.2)
            elif endless:
                _draw_half_plane(ax, a, b, view, colour)
            elif on_ground:
                ax.plot([a[0], b[0]], [a[1], b[1]], color=colour, linewidth=1.2, solid_capstyle="round")
                _hatch(ax, a, b, view)


def draw_joints(ax: Axes, compiled: Compiled, q: FloatArray) -> None:
    """Hinges as circles, other joints as squares, rods as lines, linear springs as dotted lines."""
    model = compiled.model
    for kind, points in zip(model.joints.kind, model.joints.point, strict=True):
        xy = world_places(model, q, points)
        if kind == DISTANCE:
            ax.plot(xy[:, 0], xy[:, 1], color=_JOINT, linewidth=1.2, zorder=3)
        mark = "o" if kind in (REVOLUTE, DRIVEN_ANGLE, DISTANCE) else "s"
        ends = xy if kind == DISTANCE else xy[:1]
        ax.plot(ends[:, 0], ends[:, 1], mark, markersize=6, color=_JOINT, markerfacecolor="white", zorder=4)
    for kind, points in zip(model.loads.spring_kind, model.loads.spring_point, strict=True):
        if kind == 0:
            xy = world_places(model, q, points)
            ax.plot(xy[:, 0], xy[:, 1], color=_JOINT, linewidth=1.6, linestyle=":", zorder=3)


def draw_forces(ax: Axes, result: Result, compiled: Compiled, record: int, view: View, scale: float) -> None:
    """An arrow for each contact force of the record; a force of ``scale`` [N] has the full length.

    It is the force on the body where that touches the ground; where two bodies touch, on the one added later.
    """
    if scale <= 0.0:
        return
    spots = result.spots
    length = _ARROW * max(view[1] - view[0], view[3] - view[2])
    _force_key(ax, view, length / scale, scale)
    for k in np.flatnonzero(spots.record == record):
        normal = spots.normal[k] * _towards_later(result, compiled, int(k))
        tangent = np.array([normal[1], -normal[0]])  # it turns with the normal: the numbers hold for either body
        force = spots.force[k, 0] * normal + spots.force[k, 1] * tangent
        size = float(np.hypot(*force))
        if size > 1e-3 * scale:
            tip = spots.place[k] + force / size * length * min(size / scale, _LONGEST)
            _arrow(ax, spots.place[k], tip)
            ax.plot(*spots.place[k], marker="o", markersize=3, color=_FORCE, zorder=5)


def _arrow(ax: Axes, start: FloatArray, tip: FloatArray) -> None:
    style = {"arrowstyle": "-|>", "color": _FORCE, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=tuple(tip), xytext=tuple(start), arrowprops=style, zorder=5)


def _force_key(ax: Axes, view: View, stretch: float, scale: float) -> None:
    """An arrow of a round force in the upper right corner; ``stretch`` [m/N] is the length of a newton."""
    power = 10.0 ** np.floor(np.log10(scale))
    force = float(max(c * power for c in (1.0, 2.0, 5.0) if c * power <= scale * (1.0 + 1e-9)))
    y = view[3] - 0.04 * (view[3] - view[2])
    tip = np.array([view[1] - 0.03 * (view[1] - view[0]), y])
    start = tip - (force * stretch, 0.0)
    _arrow(ax, start, tip)
    label = f"{with_unit(force, 'N')}  "
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
    ax.text(start[0], y, label, ha="right", va="center", fontsize="small", color=_FORCE, bbox=ground, zorder=6)


def _towards_later(result: Result, compiled: Compiled, spot: int) -> float:
    """1 where the normal of a spot points to the later of the two bodies, -1 where to the earlier or the ground.

    Chains test their nodes against each other both ways, so that now the one body has the feature, now the other; there
    the solid side of the earlier one decides.
    """
    contacts = compiled.model.contacts
    passes = np.flatnonzero(contacts.pass_law == result.spots.contact[spot])
    slaves = contacts.surface_body[contacts.pass_slave[passes]]
    features = contacts.surface_body[contacts.pass_feature[passes]]
    later = slaves > features
    if later.all() or not later.any():
        return 1.0 if later.all() else -1.0
    earlier = int(contacts.pass_feature[passes[np.argmax(later)]])
    q, normal = result.q[result.spots.record[spot]], result.spots.normal[spot]
    return 1.0 if float(normal @ _outward(compiled, q, earlier, result.spots.place[spot], normal)) >= 0.0 else -1.0


def _outward(compiled: Compiled, q: FloatArray, surface: int, place: FloatArray, normal: FloatArray) -> FloatArray:
    """Outward normal of a surface at a place; at a corner that of the side which is rather across ``normal``."""
    contacts = compiled.model.contacts
    distances, directions = [], []
    for f in range(contacts.feature_start[surface], contacts.feature_start[surface + 1]):
        a, b = world_places(compiled.model, q, contacts.feature_point[f])
        radius = abs(contacts.feature_radius[f])
        if contacts.feature_kind[f] == _ARC:
            away = place - a
            size = float(np.hypot(*away))
            corner = radius == 0.0 or size == 0.0  # its segments are as near and have a normal
            distances.append(np.inf if corner else abs(size - radius))
            directions.append(contacts.feature_sense[f] * away / max(size, 1e-300))
        else:
            edge = b - a
            s = float(np.clip((place - a) @ edge / (edge @ edge), *contacts.feature_span[f]))
            distances.append(float(np.hypot(*(place - a - s * edge))))
            directions.append(np.array([edge[1], -edge[0]]) / np.hypot(*edge))
    near = np.array(distances) <= min(distances) + _CORNER
    candidates = np.array(directions)[near]
    return np.asarray(candidates[np.argmax(np.abs(candidates @ normal))])


def _ground_boxes(compiled: Compiled) -> list[tuple[FloatArray, FloatArray]]:
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


def _angle_of(compiled: Compiled, q: FloatArray, body: int) -> float:
    return 0.0 if body < 0 else float(q[compiled.model.bodies.dof[body] + 2])


def _circle_points(span: FloatArray, turn: float) -> FloatArray:
    """Points of a unit arc from its start angle over its extent, turned by ``turn``: (k, 2)."""
    extent = min(float(span[1]), 2.0 * np.pi)
    angles = turn + float(span[0]) + np.linspace(0.0, extent, max(8, round(extent * 30)))
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
        ax.fill(*np.array(inside).T, facecolor=_SOLID, edgecolor="none", zorder=0)
    if len(border) == 2:
        ax.plot(*np.array(border).T, color=colour, linewidth=1.2)


def _hatch(ax: Axes, a: FloatArray, b: FloatArray, view: View) -> None:
    """Short strokes on the solid side of a segment, its left."""
    from matplotlib.collections import LineCollection

    picture = max(view[1] - view[0], view[3] - view[2])
    length = float(np.hypot(*(b - a)))
    if length == 0.0:
        return
    along = (b - a) / length
    stroke = 0.015 * picture * (np.array([-along[1], along[0]]) - along)
    feet = [a + along * s for s in np.arange(0.5, min(length / (0.025 * picture), 400.0)) * 0.025 * picture]
    ax.add_collection(LineCollection([(foot, foot + stroke) for foot in feet], colors=_GROUND, linewidths=0.6))
