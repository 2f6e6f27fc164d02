"""Libraries that are loaded when something of theirs is first used: a scene is written, and helped with, without them.

To add one: import it below, for type checkers, and name it in ``__all__``. Use: ``libs.sparse.csc_matrix(...)``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    import clarabel
    import h5py
    import llvmlite.binding as llvm
    import matplotlib.animation as animation
    import meshio
    import meshlane
    import numba.core.event as numba_event
    import pandas
    import PIL.Image as image
    import pypardiso
    import qpsolvers
    import scipy.linalg as linalg
    import scipy.ndimage as ndimage
    import scipy.sparse as sparse
    import scipy.sparse.csgraph as csgraph
    import skfem
    import skfem.helpers as skfem_helpers
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.colors import ListedColormap, to_rgb
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle, Patch, PathPatch, Polygon
    from matplotlib.path import Path
    from matplotlib.ticker import LogFormatter, NullFormatter
    from scipy.integrate import solve_ivp
    from scipy.interpolate import CubicHermiteSpline, CubicSpline
    from scipy.optimize import brentq, linprog, nnls
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, eigsh, splu
    from scipy.spatial import ConvexHull, QhullError, cKDTree
    from scipy.spatial.transform import Rotation
    from scipy.special import lambertw
    from skfem.models.elasticity import lame_parameters, plane_stress
    from tqdm import tqdm

__getattr__, __dir__ = attach(__name__)
