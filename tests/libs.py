"""Libraries that tests load when they first use them: collecting the tests needs none of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    import h5py
    import matplotlib as mpl
    import matplotlib.animation as animation
    import matplotlib.colors as colors
    import matplotlib.pyplot as plt
    import meshio
    import PIL.Image as image
    import qpsolvers
    import skfem
    import skfem.helpers as skfem_helpers
    import skfem.models.elasticity as elasticity
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation

__getattr__, __dir__ = attach(__name__)
