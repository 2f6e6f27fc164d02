"""Contact forces in a picture: an arrow each, one scale for a whole run, and a key."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.kinematics.places import world_places
from lcpflex.results.drawing import add_line
from lcpflex.results.words import with_unit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.contact_history import ContactPoints
    from lcpflex.results.drawing import View
    from lcpflex.results.result import Result

__all__ = [
    "CUT",
    "FRONT",
    "INK",
    "SEEN",
    "Placed",
    "arrow_length",
    "arrow_tips",
    "draw_arrows",
    "draw_forces",
    "draw_key",
    "usual_force",
    "usual_length",
]

Placed: TypeAlias = "tuple[FloatArray, FloatArray, float, bool]"  # foot, tip, force [N], whether the arrow is cut

FRONT = 5.0  # zorder of arrows; words are in front of them
INK = "#D55E00"  # of arrows and their words
_GROUND = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
_WORDS: dict[str, Any] = {"va": "center", "color": INK, "bbox": _GROUND, "zorder": FRONT + 1.0}
_ARROW = 0.2  # largest length of an arrow of the usual force, relative to the picture
_SHORTEST = 0.07  # likewise, where the bodies that touch are small
_BODY_SHARE = 0.7  # length of that arrow, relative to the bodies that touch: arrows of a stack do not overlap
_LETTER, _HIGH = 4.5, 10.0  # width and height of letters of these numbers, points
CUT = 1.5  # a force beyond so many usual ones has a cut arrow, and its number beside
_NUMBERED = 8  # of them, the largest ones: numbers of a pile would hide each other
SEEN = 1e-3  # forces below this share of the usual one are not drawn
_CORNER = 1e-6  # sides whose distances differ by less meet at the place [m]


def usual_force(points: ContactPoints) -> float:
    """Median of contact forces of a run [N], which sets the scale of its pictures; 0 if there is none.

    Impacts are as large as steps are short: a scale that shows them hides all others.
    """
    forces = np.linalg.norm(points.force, axis=1)
    forces = forces[forces > 0.0]
    return float(np.median(forces)) if forces.size else 0.0


def arrow_tips(result: Result, compiled: CompiledScene, record: int, length: float, scale: float) -> FloatArray:
    """Where the arrows of a record end, (k, 2) [m]."""
    if scale <= 0.0:
        return np.zeros((0, 2))
    arrows = _arrows(result, compiled, record, length, scale)
    return np.array([tip for _, tip, _, _ in arrows]).reshape(-1, 2)


def draw_forces(ax: Axes, result: Result, compiled: CompiledScene, record: int, length: float, scale: float) -> None:
    """An arrow for each contact force of the record; ``scale`` [N] is the force whose arrow has that ``length`` [m].

    It is the force on the body where that touches the ground; where two bodies touch, on the one added later.
    """
    if scale > 0.0:
        draw_arrows(ax, _arrows(result, compiled, record, length, scale))


def draw_arrows(ax: Axes, arrows: Sequence[Placed]) -> None:
    """Arrows whose places are those of the picture."""
    if not arrows:
        return
    numbered = _least_numbered([size for _, _, size, cut in arrows if cut])
    feet = np.array([place for place, *_ in arrows])
    add_line(ax, feet[:, 0], feet[:, 1], linestyle="", marker="o", markersize=3, color=INK, zorder=FRONT)
    for place, tip, *_ in arrows:
        _arrow(ax, place, tip)
    taken: list[FloatArray] = []
    for place, tip, size, cut in sorted(arrows, key=lambda arrow: -arrow[2]):
        if cut and size >= numbered:
            _number(ax, place, tip, with_unit(float(f"{size:.2g}"), "N"), taken)


def _number(ax: Axes, place: FloatArray, tip: FloatArray, text: str, taken: list[FloatArray]) -> None:
    """The number of an arrow beside its tip, where it hides none of those in ``taken``, if there is such a place.

    taken: (4,) left, right, lower, upper [pixels].
    """
    a_point = ax.figure.dpi / 72.0
    x, y = ax.transData.transform(tip)
    width, height = a_point * _LETTER * (len(text) + 2), a_point * _HIGH
    first, other = ("left", "right") if tip[0] >= place[0] else ("right", "left")
    for side, level in ((first, 0), (other, 0), (first, 1), (other, 1), (first, -1), (other, -1)):
        left, low = (x if side == "left" else x - width), y + (level - 0.5) * height
        box = np.array([left, left + width, low, low + height])
        if any(box[0] < b[1] and b[0] < box[1] and box[2] < b[3] and b[2] < box[3] for b in taken):
            continue
        taken.append(box)
        at = ax.transData.inverted().transform((x, y + level * height)) if level else tip
        style: dict[str, Any] = {"fontsize": "x-small", "color": INK, "bbox": _GROUND, "zorder": FRONT + 1}
        ax.text(at[0], at[1], f" {text} ", ha=side, va="center", **style)
        return


def _least_numbered(sizes: list[float]) -> float:
    """The smallest force that has its number beside it [N]."""
    return sorted(sizes)[-_NUMBERED] if len(sizes) >= _NUMBERED else 0.0


def _arrows(result: Result, compiled: CompiledScene, record: int, length: float, scale: float) -> list[Placed]:
    """Foot, tip, force [N] of each arrow, and whether it is shorter than the force asks for."""
    touching, found = result.contact_points, []
    for k in np.flatnonzero(touching.record == record):
        normal = touching.normal[k] * _towards_later(result, compiled, int(k))
        tangent = np.array([normal[1], -normal[0]])  # it turns with the normal: the numbers hold for either body
        force = touching.force[k, 0] * normal + touching.force[k, 1] * tangent
        size = float(np.hypot(*force))
        if size > SEEN * scale:
            tip = touching.place[k] + force / size * length * min(size / scale, CUT)
            found.append((touching.place[k], tip, size, size > CUT * scale))
    return found


def usual_length(result: Result, compiled: CompiledScene, view: View) -> float:
    """Length of the arrow of the usual force [m]: that of the bodies that touch, where this can be seen."""
    picture = max(view[1] - view[0], view[3] - view[2])
    extents = _extents(compiled)
    contacts = compiled.model.contacts
    touching = np.isin(contacts.pass_law, result.contact_points.contact)
    sides = contacts.surface_body[[*contacts.pass_node[touching], *contacts.pass_feature[touching]]]
    sizes = [extents[body] for body in np.unique(sides) if body in extents]
    return arrow_length(picture, sizes)


def arrow_length(picture: float, sizes: Sequence[float]) -> float:
    """Likewise, of bodies of these ``sizes`` in a picture whose longer side is ``picture`` [m]."""
    wanted = _BODY_SHARE * min(sizes, default=picture)
    return float(np.clip(wanted, _SHORTEST * picture, _ARROW * picture))


def _extents(compiled: CompiledScene) -> dict[int, float]:
    """Mean extent [m], the root of width times height, of each body that has a shape."""
    points = compiled.model.points
    found: dict[int, float] = {}
    for body, ids, _ in compiled.layout.outlines:
        found[body] = max(found.get(body, 0.0), float(np.sqrt(np.prod(np.ptp(points.place[ids], axis=0)))))
    for point, radius in compiled.layout.circles:
        body = int(points.body[point])
        found[body] = max(found.get(body, 0.0), 2.0 * radius)
    return found


def _arrow(ax: Axes, start: FloatArray, tip: FloatArray) -> None:
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=tuple(tip), xytext=tuple(start), arrowprops=style, zorder=FRONT)


def draw_key(ax: Axes, view: View, length: float, scale: float) -> None:
    """An arrow of a round force in the upper right corner, where there are forces."""
    if scale <= 0.0:
        return
    power = 10.0 ** np.floor(np.log10(scale))
    force = float(max(c * power for c in (1.0, 2.0, 5.0) if c * power <= scale * (1.0 + 1e-9)))
    y = view[3] - 0.04 * (view[3] - view[2])
    tip = np.array([view[1] - 0.03 * (view[1] - view[0]), y])
    start = tip - (force * length / scale, 0.0)
    _arrow(ax, start, tip)
    label = f"{with_unit(force, 'N')}  "
    ax.text(start[0], y, label, ha="right", fontsize="small", **_WORDS)


def _towards_later(result: Result, compiled: CompiledScene, point: int) -> float:
    """1 where the normal of a contact point goes to the later of the two bodies, -1 where to the earlier or the ground.

    Chains test their nodes against each other both ways, so that now the one body has the feature, now the other; there
    the solid side of the earlier one decides.
    """
    contacts = compiled.model.contacts
    passes = np.flatnonzero(contacts.pass_law == result.contact_points.contact[point])
    nodes = contacts.surface_body[contacts.pass_node[passes]]
    features = contacts.surface_body[contacts.pass_feature[passes]]
    later = nodes > features
    if later.all() or not later.any():
        return 1.0 if later.all() else -1.0
    earlier = int(contacts.pass_feature[passes[np.argmax(later)]])
    q, normal = result.q[result.contact_points.record[point]], result.contact_points.normal[point]
    return (
        1.0
        if float(normal @ _outward(compiled, q, earlier, result.contact_points.place[point], normal)) >= 0.0
        else -1.0
    )


def _outward(compiled: CompiledScene, q: FloatArray, surface: int, place: FloatArray, normal: FloatArray) -> FloatArray:
    """Outward normal of a surface at a place; at a corner that of the side which is rather across ``normal``."""
    contacts = compiled.model.contacts
    distances, directions = [], []
    for f in range(contacts.feature_start[surface], contacts.feature_start[surface + 1]):
        a, b = world_places(compiled.model, q, contacts.feature_point[f])
        radius = abs(contacts.feature_radius[f])
        if contacts.feature_kind[f] != SEGMENT:
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
