"""Pictures of a spatial scene at its stored instants, all with one camera and one floor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.results.drawing import add_line
from lcpflex.results.drawn_forces import FRONT, draw_arrows, draw_key
from lcpflex.results.spatial.camera import Look, camera_of
from lcpflex.results.spatial.contact_arrows import ContactArrows
from lcpflex.results.spatial.floor import AXIS_COLOURS, OUTSIDE, draw_floor, floor_under, scales
from lcpflex.results.spatial.ground import GROUND_COLOUR, draw_patches, level_under, near_solids, patches
from lcpflex.results.spatial.pressed_areas import PressedAreas, draw_bar, draw_cells
from lcpflex.results.spatial.raster import (
    FINER,
    NOBODY,
    Canvas,
    blank,
    fill_shadow,
    fill_strokes,
    fill_triangles,
    resolved,
)
from lcpflex.results.spatial.scenery import Drawn, Scenery, colour_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["SpatialPicture"]

_LONGEST = 6.2  # inches of the longer side of a picture
_BAR, _BAR_SIZE = 1.2, 0.6  # inches beside a picture with a scale of colours, and how much of its height that has
_PIXELS = 200  # an inch of a single picture; films have those of the screen
_ROOM = 0.03  # around what is drawn, relative to the longer side
_LIGHT = np.array([-0.30, 0.55, 0.78])  # right, up, towards the viewer
_DIM, _BEND = 0.38, 1.4  # light of what is turned away, and how fast it grows
_INK, _STEEL = np.array([48.0, 48.0, 48.0]), np.array([96.0, 96.0, 104.0])
_EDGE, _ROD, _COIL, _STAR, _FRAME, _DOT = 0.0011, 0.0030, 0.0022, 0.0045, 0.0030, 0.009  # radii, of the longer side
_LIFT = 0.002  # of it, by which lines on a surface are nearer
_STEP = 0.03  # of it, a step in depth that has an outline
_SHADOW, _SOFT = 0.22, 0.006  # how dark it is, and how soft
_AXIS = 0.7  # length of the axes of a body, relative to its extent
_LEAST, _MOST = 0.07, 0.45  # and relative to that of all in the picture
_BEHIND = 0.4  # share with which hidden axes are seen
_FAINT = 0.35  # likewise of marks of joints
_RECORDS = 60  # instants of a film that its frame is made for


class SpatialPicture:
    """A scene with its camera, which keeps in view what moves in the given records."""

    def __init__(self, result: Result, compiled: CompiledScene, records: IntArray, look: Look) -> None:
        self._result, self._look = result, look
        self._scenery = Scenery(compiled)
        self._camera = camera_of(look.view, compiled.model.loads.gravity)
        self._pixels: tuple[int, int] | None = None
        extents = {one.body: one.extent for one in self._scenery.drawn}
        self._arrows = ContactArrows(result, compiled, extents, look.pressure)
        self._pressed = PressedAreas(result, records) if look.pressure else None
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        sights = np.array([[np.inf] * 2, [-np.inf] * 2])
        records = records[:: max(1, len(records) // _RECORDS)]
        self._arms = max(self._broad(result.q[record]) for record in records) if look.frames else 0.0
        swept = [self._swept(result.q[record]) for record in records]
        moving, up = np.concatenate(swept), self._camera.floor[2]
        level = level_under(compiled.model, moving, up)
        self._patches = patches(compiled.model, moving, up, level)
        none = np.zeros(0, np.int64)
        self._ground = [
            Drawn(-1, facets, np.zeros(3), none, None, 0.0) for facets in near_solids(self._scenery.solids, moving)
        ]
        solids = [one.facets.vertices for one in self._ground if one.facets is not None]
        for places in (*swept, *self._patches, *solids):
            along = places @ self._camera.floor.T
            low, high = np.minimum(low, along.min(axis=0)), np.maximum(high, along.max(axis=0))
            seen = self._camera.seen(places)[:, :2]
            sights = np.array([np.minimum(sights[0], seen.min(axis=0)), np.maximum(sights[1], seen.max(axis=0))])
        if level is not None:
            low[2] = min(low[2], level)
            high[2] = max(high[2], level)
        self._extent = max(float((high - low).max()), 1e-9)
        self.floor = floor_under(low, high, level)
        borders = scales(self.floor, self._camera)
        corners = self._camera.seen(self.floor.corners() @ self._camera.floor)[:, :2]
        seen = np.concatenate([corners, sights, *(scale.line for scale in borders)])
        side = float(np.ptp(seen, axis=0).max())
        a_point = side * (1.0 + 2.0 * _ROOM) / (72.0 * _LONGEST)
        outside = [scale.line.mean(axis=0) + OUTSIDE * a_point * scale.out for scale in borders]
        self._arrows.measure(side)
        seen = np.concatenate([seen, self._tips(records), *(place[None] for place in outside)])
        first, last = seen.min(axis=0) - _ROOM * side, seen.max(axis=0) + _ROOM * side
        self.view = float(first[0]), float(last[0]), float(first[1]), float(last[1])
        self._side = side  # [m] of the longer side, without room

    def _tips(self, records: IntArray) -> FloatArray:
        """(k, 2) where arrows of forces end in the picture."""
        tips = [arrow.tip for record in records.tolist() for arrow in self._arrows.at(record)]
        return np.asarray(self._camera.seen(np.array(tips).reshape(-1, 3))[:, :2])

    def _swept(self, q: FloatArray) -> FloatArray:
        """(k, 3) places that the picture has to hold at a configuration."""
        places = self._scenery.reach(q, self._look.scale)
        if not self._look.frames:
            return places
        return np.concatenate([places, *(ends.reshape(-1, 3) for ends, *_ in self._axes_of_bodies(q))])

    def _broad(self, q: FloatArray) -> float:
        """Extent of the bodies in the picture [m]."""
        return float(np.ptp(self._camera.seen(self._scenery.reach(q, self._look.scale))[:, :2], axis=0).max())

    def size(self) -> tuple[float, float]:
        """Inches."""
        width, height = self.view[1] - self.view[0], self.view[3] - self.view[2]
        scale = _LONGEST / max(width, height)
        beside = 0.2 if self._pressed is None else _BAR
        return max(scale * width, 3.0) + beside, max(scale * height, 2.0) + 0.4

    def words(self) -> str:
        """What has to be said about it, behind the time."""
        return "" if self._look.scale == 1.0 else f", deformation drawn {self._look.scale:g} times as large"

    def set_out(self, ax: Axes) -> None:
        """Floor, axes and limits: what is the same at all instants."""
        ax.set_aspect("equal")
        ax.set_xlim(self.view[0], self.view[1])
        ax.set_ylim(self.view[2], self.view[3])
        ax.set_axis_off()
        box = ax.get_window_extent()
        a_pixel = max((self.view[1] - self.view[0]) / box.width, (self.view[3] - self.view[2]) / box.height)
        draw_floor(ax, self.floor, self._camera, a_pixel * ax.figure.dpi / 72.0)
        draw_patches(ax, self._patches, self._camera)
        if self._pressed is not None:
            draw_bar(ax, self._pressed.colours, _BAR_SIZE)
        draw_key(ax, self.view, self._arrows.length, self._arrows.usual)

    def fit(self, ax: Axes) -> None:
        """From now on, draw with as many pixels as the axes have, for films."""
        box = ax.get_window_extent()
        self._pixels = max(round(box.height), 8), max(round(box.width), 8)

    def paint(self, ax: Axes, record: int) -> None:
        """One instant."""
        q = self._result.q[record]
        rows, columns = self._pixels or self._fine()
        canvas, shadow = self.canvas(q, rows, columns)
        picture = np.zeros((rows, columns, 4), np.uint8)
        step = _STEP * self._scale(columns) * self._side
        width = max(1, round(0.0012 * max(rows, columns) * FINER))
        resolved(*canvas, step, width, shadow, picture)
        style = "nearest" if self._pixels else "antialiased"
        ax.imshow(picture, extent=self.view, origin="lower", interpolation=style, zorder=1, aspect="equal")
        self._draw_marks(ax, q, canvas)
        self._draw_forces(ax, record)

    def _draw_forces(self, ax: Axes, record: int) -> None:
        """In front of all: a contact is between bodies, where nothing of it is seen."""
        if self._pressed is not None:
            cells, pressures = self._pressed.at(record)
            draw_cells(ax, [self._camera.seen(cell)[:, :2] for cell in cells], pressures, self._pressed.colours, FRONT)
        if self._arrows.usual <= 0.0:
            return
        found = [
            (*self._camera.seen(np.array([arrow.foot, arrow.tip]))[:, :2], arrow.force, arrow.cut)
            for arrow in self._arrows.at(record)
        ]
        draw_arrows(ax, found)

    def canvas(self, q: FloatArray, rows: int, columns: int) -> tuple[Canvas, Any]:
        """What is nearest at each pixel, and the shadow on the floor, at a configuration."""
        canvas, shadow = blank(rows, columns), np.zeros((rows, columns), np.float32)
        corners, light, tints, owners = [], [], [], []
        lines: list[tuple[FloatArray, float, FloatArray, int]] = []
        fine = FINER * self._scale(columns)
        for one in (*self._scenery.drawn, *self._scenery.parts, *self._ground):
            places = self._vertices(q, one)
            colour = colour_of(one.body) if one.body >= 0 else GROUND_COLOUR
            owner = one.body if one.body >= 0 else self._ground_owner()
            if one.facets is not None:
                shown, bright = self._lit(one, places)
                corners.append(self._pixel(places[one.facets.triangles[shown]], fine))
                light.append(bright)
                tints.append(np.broadcast_to(colour, (len(bright), 3)))
                owners.append(np.full(len(bright), owner))
                lines += [(places[one.facets.edges], _EDGE, 0.35 * colour, owner)]
            if one.dots is not None:
                lines += [(np.stack([places, places], axis=1), _STAR, 0.8 * colour, one.body)]
        for one in self._scenery.drawn:
            lines += self._star(q, one, 0.85 * colour_of(one.body))
        if corners:
            triangles = np.concatenate(corners)
            fill_triangles(triangles, np.concatenate(light), np.concatenate(tints), np.concatenate(owners), *canvas)
            shadow = self._shadow(q, shadow, columns)
        lines += self._links(q)
        self._stroke(canvas, lines, fine, _LIFT, 0.0)
        if self._look.frames:
            self._stroke(canvas, self._axes_of_bodies(q), fine, _LIFT, _BEHIND)
        return canvas, shadow

    def _vertices(self, q: FloatArray, one: Drawn) -> FloatArray:
        """(N, 3) world places of a surface."""
        if one.body >= 0:
            return self._scenery.vertices(q, one, self._look.scale)
        assert one.facets is not None
        return one.facets.vertices

    def _ground_owner(self) -> int:
        """Of pixels with surfaces of the ground; the number before it is that of rods and springs."""
        return len(self._scenery.drawn) + 1

    def _lit(self, one: Drawn, places: FloatArray) -> tuple[IntArray, FloatArray]:
        """Which triangles are seen, and the light at the corners (T, 3) of these."""
        assert one.facets is not None
        normals = self._camera.seen(one.facets.normals(places))
        a, b, c = np.moveaxis(self._camera.seen(places)[one.facets.triangles], 1, 0)
        facing = np.cross(b - a, c - a)[:, 2]
        shown = np.flatnonzero(facing > 0.0 if one.facets.closed else facing != 0.0)
        normals = normals[shown] * np.where(facing[shown] > 0.0, 1.0, -1.0)[:, None, None]
        towards = normals @ (_LIGHT / np.linalg.norm(_LIGHT))
        return shown, _DIM + (1.0 - _DIM) * np.clip(0.5 + 0.5 * towards, 0.0, 1.0) ** _BEND

    def _star(self, q: FloatArray, one: Drawn, colour: FloatArray) -> list[tuple[FloatArray, float, FloatArray, int]]:
        """Lines of a body without a shape, and a dot for one that would not be seen."""
        centre = self._scenery.centre(q, one)
        found = []
        if len(one.ends):
            ends = self._scenery.at(q, one.ends, self._look.scale)
            found.append((np.stack([np.broadcast_to(centre, ends.shape), ends], axis=1), _STAR, colour, one.body))
        size = one.extent if one.facets is None else float(np.ptp(one.facets.vertices, axis=0).max())
        if size < 2.0 * _DOT * self._side:
            found.append((np.stack([centre, centre])[None], _DOT, colour, one.body))
        return found

    def _links(self, q: FloatArray) -> list[tuple[FloatArray, float, FloatArray, int]]:
        """Massless rods, springs and bushings."""
        scenery, scale, lines = self._scenery, self._look.scale, []
        nobody = len(scenery.drawn)
        for pair in scenery.rods:
            lines.append((scenery.at(q, pair, scale)[None], _ROD, _INK, nobody))
        for pair in scenery.bushings:
            lines.append((scenery.at(q, pair, scale)[None], _COIL, _STEEL, nobody))
        for pair in scenery.springs:
            wire = scenery.spring(q, pair, scale)
            lines.append((np.stack([wire[:-1], wire[1:]], axis=1), _COIL, _STEEL, nobody))
        return lines

    def _axes_of_bodies(self, q: FloatArray) -> list[tuple[FloatArray, float, FloatArray, int]]:
        lines = []
        for one in self._scenery.drawn:
            origin, axes, _ = self._scenery.frame(q, one.body)
            length = np.clip(_AXIS * one.extent, _LEAST * self._arms, _MOST * self._arms)
            for axis, colour in enumerate(AXIS_COLOURS):
                tint = 255.0 * np.array(libs.to_rgb(colour))
                ends = np.stack([origin, origin + length * axes[:, axis]])
                lines.append((ends[None], _FRAME, tint, len(self._scenery.drawn)))
        return lines

    def _stroke(
        self,
        canvas: Canvas,
        lines: list[tuple[FloatArray, float, FloatArray, int]],
        fine: float,
        lift: float,
        behind: float,
    ) -> None:
        counts = [len(ends) for ends, *_ in lines]
        if not sum(counts):
            return
        ends = np.concatenate([self._pixel(ends, fine) for ends, *_ in lines])
        radius = np.repeat([max(share * fine * self._side, 0.55 * FINER) for _, share, *_ in lines], counts)
        tints = np.repeat([tint for _, _, tint, _ in lines], counts, axis=0)
        owners = np.repeat([owner for *_, owner in lines], counts)
        fill_strokes(ends, radius, tints, owners, lift * fine * self._side, behind, *canvas)

    def _shadow(self, q: FloatArray, shadow: Any, columns: int) -> Any:
        """On the floor, straight below the bodies, soft; none from underneath."""
        if self._camera.towards @ self._camera.floor[2] <= 0.0:
            return shadow
        for one in (*self._scenery.drawn, *self._scenery.parts, *self._ground):
            if one.facets is not None:
                along = self._vertices(q, one) @ self._camera.floor.T
                along[:, 2] = self.floor.low[2]
                places = self._pixel(along @ self._camera.floor, self._scale(columns))
                fill_shadow(np.ascontiguousarray(places[one.facets.triangles][:, :, :2]), shadow)
        return np.asarray(_SHADOW * libs.ndimage.gaussian_filter(shadow, _SOFT * max(shadow.shape)), dtype=np.float32)

    def _draw_marks(self, ax: Axes, q: FloatArray, canvas: Canvas) -> None:
        """Joints as circles, sliding ones as squares, a triangle under those of the ground; fainter where hidden."""
        body = self._scenery.model.points.body
        marks = [(p, (p, other), "s" if slides else "o") for p, other, slides in self._scenery.joints]
        marks += [(p, pair, "o") for pair in (*self._scenery.rods, *self._scenery.springs) for p in pair]
        for p, pair, mark in sorted(dict.fromkeys(marks), key=lambda one: one[2] == "o"):
            place = self._scenery.at(q, (p,), self._look.scale)[0]
            x, y, _ = self._camera.seen(place)
            holders = {int(body[k]) for k in pair}
            alpha = _FAINT if self._hidden(canvas, place, holders) else 1.0
            grounded = body[p] < 0 or (-1 in holders and mark != "o") or (-1 in holders and pair in self._held())
            if grounded:
                add_line(ax, [x], [y], marker=6, markersize=9, color="#808080", alpha=alpha, zorder=2)
            size = 5.5 if mark == "o" else 7.5  # seen around a circle at its place
            add_line(
                ax,
                [x],
                [y],
                marker=mark,
                markersize=size,
                color="#202020",
                markerfacecolor="white",
                mew=1.0,
                alpha=alpha,
                zorder=3,
            )

    def _held(self) -> set[tuple[int, int]]:
        return {(p, other) for p, other, _ in self._scenery.joints}

    def _hidden(self, canvas: Canvas, place: FloatArray, holders: set[int]) -> bool:
        """Whether another body is in front of a place."""
        rows, columns = canvas.depth.shape
        x, y, z = self._pixel(place, FINER * self._scale(columns // FINER))
        i, j = int(np.clip(y, 0, rows - 1)), int(np.clip(x, 0, columns - 1))
        seen = {*holders, NOBODY, len(self._scenery.drawn)} | ({self._ground_owner()} if -1 in holders else set())
        return int(canvas.owner[i, j]) not in seen and canvas.depth[i, j] > z

    def _pixel(self, places: FloatArray, scale: float) -> FloatArray:
        """(..., 3) column, row and depth of places (..., 3), a metre being ``scale`` pixels."""
        seen = self._camera.seen(places) - np.array([self.view[0], self.view[2], 0.0])
        return np.ascontiguousarray(scale * seen)

    def _scale(self, columns: int) -> float:
        """Pixels a metre."""
        return float(columns / (self.view[1] - self.view[0]))

    def _fine(self) -> tuple[int, int]:
        """Rows and columns of a single picture."""
        width, height = self.view[1] - self.view[0], self.view[3] - self.view[2]
        a_metre = _LONGEST * _PIXELS / max(width, height)
        return max(round(a_metre * height), 8), max(round(a_metre * width), 8)
