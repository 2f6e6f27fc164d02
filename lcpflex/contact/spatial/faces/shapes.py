"""Shape functions of the faces of solid elements: of 3, 4, 6, 8 and 9 nodes.

Corners come first, counter-clockwise seen from outside, then the nodes on the sides, behind corner i that between i and
i + 1, then the one in the middle. Triangles have the corners (0, 0), (1, 0), (0, 1) in the coordinates x, y of the
reference face, the others those of the square from -1 to 1. Source: Zienkiewicz, Taylor & Zhu (2005), chapter 4.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["corners_of", "is_inside", "lay_bends", "lay_shapes", "middle"]


@kernel
def corners_of(nodes: int) -> int:
    """How many corners a face of so many nodes has."""
    return 3 if nodes == 3 or nodes == 6 else 4


@kernel
def middle(nodes: int) -> float:
    """Both coordinates of the middle of a face of so many nodes."""
    return 1.0 / 3.0 if corners_of(nodes) == 3 else 0.0


@kernel
def is_inside(nodes: int, x: float, y: float, slack: float) -> bool:
    """Whether (x, y) is in the reference face of so many nodes, or at most ``slack`` beside it."""
    if corners_of(nodes) == 3:
        return x >= -slack and y >= -slack and x + y <= 1.0 + slack
    return abs(x) <= 1.0 + slack and abs(y) <= 1.0 + slack


@kernel
def lay_shape(shape: FloatArray, i: int, value: float, by_x: float, by_y: float) -> None:
    """One shape function and its derivatives."""
    shape[i, 0], shape[i, 1], shape[i, 2] = value, by_x, by_y


@kernel
def lay_triangle(nodes: int, x: float, y: float, shape: FloatArray) -> None:
    """Of 3 or 6 nodes, in barycentric coordinates."""
    z = 1.0 - x - y
    if nodes == 3:
        lay_shape(shape, 0, z, -1.0, -1.0)
        lay_shape(shape, 1, x, 1.0, 0.0)
        lay_shape(shape, 2, y, 0.0, 1.0)
        return
    lay_shape(shape, 0, z * (2.0 * z - 1.0), 1.0 - 4.0 * z, 1.0 - 4.0 * z)
    lay_shape(shape, 1, x * (2.0 * x - 1.0), 4.0 * x - 1.0, 0.0)
    lay_shape(shape, 2, y * (2.0 * y - 1.0), 0.0, 4.0 * y - 1.0)
    lay_shape(shape, 3, 4.0 * z * x, 4.0 * (z - x), -4.0 * x)
    lay_shape(shape, 4, 4.0 * x * y, 4.0 * y, 4.0 * x)
    lay_shape(shape, 5, 4.0 * y * z, -4.0 * y, 4.0 * (z - y))


@kernel
def sides_of(i: int) -> tuple[float, float]:
    """Coordinates of node i of a square: corners, middles of sides, the middle."""
    if i < 4:
        return (1.0 if i == 1 or i == 2 else -1.0), (1.0 if i >= 2 else -1.0)
    if i == 8:
        return 0.0, 0.0
    return (0.0 if i == 4 or i == 6 else (1.0 if i == 5 else -1.0)), (0.0 if i == 5 or i == 7 else i - 5.0)


@kernel
def parabola(at: float, x: float) -> tuple[float, float]:
    """The quadratic polynomial that is 1 at ``at``, which is -1, 0 or 1, and 0 at the other two; and its derivative."""
    if at == 0.0:
        return 1.0 - x * x, -2.0 * x
    return 0.5 * x * (x + at), x + 0.5 * at


@kernel
def lay_square(nodes: int, x: float, y: float, shape: FloatArray) -> None:
    """Of 4 (bilinear), 8 (serendipity) or 9 nodes (biquadratic)."""
    for i in range(nodes):
        a, b = sides_of(i)
        if nodes == 9:
            f, df = parabola(a, x)
            g, dg = parabola(b, y)
            lay_shape(shape, i, f * g, df * g, f * dg)
        elif nodes == 4:
            lay_shape(
                shape, i, 0.25 * (1.0 + a * x) * (1.0 + b * y), 0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)
            )
        elif i < 4:
            u, v = 1.0 + a * x, 1.0 + b * y
            w = a * x + b * y - 1.0
            lay_shape(shape, i, 0.25 * u * v * w, 0.25 * a * v * (w + u), 0.25 * b * u * (w + v))
        elif a == 0.0:
            v = 1.0 + b * y
            lay_shape(shape, i, 0.5 * (1.0 - x * x) * v, -x * v, 0.5 * b * (1.0 - x * x))
        else:
            u = 1.0 + a * x
            lay_shape(shape, i, 0.5 * (1.0 - y * y) * u, 0.5 * a * (1.0 - y * y), -y * u)


@kernel
def lay_shapes(nodes: int, x: float, y: float, shape: FloatArray) -> None:
    """Rows of ``shape`` (9, 3): N_i, dN_i/dx and dN_i/dy of each of so many nodes at (x, y)."""
    if corners_of(nodes) == 3:
        lay_triangle(nodes, x, y, shape)
    else:
        lay_square(nodes, x, y, shape)


@kernel
def lay_triangle_bends(bend: FloatArray) -> None:
    """Of 6 nodes."""
    lay_shape(bend, 0, 4.0, 4.0, 4.0)
    lay_shape(bend, 1, 4.0, 0.0, 0.0)
    lay_shape(bend, 2, 0.0, 0.0, 4.0)
    lay_shape(bend, 3, -8.0, -4.0, 0.0)
    lay_shape(bend, 4, 0.0, 4.0, 0.0)
    lay_shape(bend, 5, 0.0, -4.0, -8.0)


@kernel
def lay_bends(nodes: int, x: float, y: float, bend: FloatArray) -> None:
    """Rows of ``bend`` (9, 3): second derivatives of each shape function at (x, y), along xx, xy and yy."""
    if nodes == 3:
        for i in range(3):
            lay_shape(bend, i, 0.0, 0.0, 0.0)
    elif nodes == 6:
        lay_triangle_bends(bend)
    else:
        for i in range(nodes):
            a, b = sides_of(i)
            u, v = 1.0 + a * x, 1.0 + b * y
            if nodes == 4:
                lay_shape(bend, i, 0.0, 0.25 * a * b, 0.0)
            elif nodes == 9:
                f, df = parabola(a, x)
                g, dg = parabola(b, y)
                lay_shape(bend, i, (1.0 if a != 0.0 else -2.0) * g, df * dg, (1.0 if b != 0.0 else -2.0) * f)
            elif i < 4:
                lay_shape(bend, i, 0.5 * v, 0.25 * a * b * (u + v + a * x + b * y - 1.0), 0.5 * u)
            elif a == 0.0:
                lay_shape(bend, i, -v, -x * b, 0.0)
            else:
                lay_shape(bend, i, 0.0, -y * a, -u)
