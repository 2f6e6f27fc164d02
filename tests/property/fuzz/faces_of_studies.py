"""Scenes of the gallery, and studies."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import lcpflex as lf
from lcpflex import gallery, studies
from tests import libs
from tests.property.fuzz.face import Face, case, result, small_scene

__all__ = ["gallery_faces", "study_faces"]


@cache
def _map() -> studies.StabilityMap:
    return studies.stability(case(), {"a": lf.MoreauJean(step=1e-2)}, {"height": [0.1, 0.2]}, 0.02, progress=False)


@cache
def _work() -> studies.WorkPrecision:
    series = (lf.MoreauJean(step=4e-3), lf.MoreauJean(step=2e-3), lf.MoreauJean(step=1e-3))
    return studies.work_precision(case(), {"a": series}, duration=0.05, repeats=0, progress=False)


def _work_arguments() -> dict[str, Any]:
    series = (lf.MoreauJean(step=4e-3), lf.MoreauJean(step=2e-3))
    return {
        "scenes": case(),
        "methods": {"a": series},
        "duration": 0.02,
        "limit": 0.02,
        "repeats": 0,
        "progress": False,
    }


def _bar() -> lf.Scene:
    return gallery.elastic_bar(elements=4, gap=0.01)


def _sized() -> dict[str, Any]:
    step = lf.MoreauJean(step=2e-3)
    return {"scene": _bar, "duration": 0.02, "stepper": step, "limit": 0.5, "verify": False, "progress": False}


@cache
def _right() -> studies.RightSize:
    return studies.right_size(**_sized())


def _output() -> studies.Output:
    return studies.Output("height", lambda result: result.q[:, 1])


def _drawn() -> dict[str, Any]:
    return {"axes": libs.plt.figure().add_subplot(), "method": "a"}


def gallery_faces() -> list[Face]:
    small: dict[str, dict[str, Any]] = {
        "meshed_ball": {"finest": 2e-3, "modes": 2},
        "meshed_rod": {"finest": 2e-3, "modes": 2},
        "painleve_friction": {"degrees": 60.0},
    }

    def face(name: str) -> Face:
        return Face(f"gallery.{name}", getattr(gallery, name), lambda: dict(small.get(name, {})))

    return [face(name) for name in gallery.__all__ if name not in ("Case", "scenes", "warmup_cases")]


def study_faces() -> list[Face]:
    t = np.array([0.0, 1.0, 2.0])
    stability = {
        "methods": {"a": lf.MoreauJean(step=1e-2)},
        "axes": {"height": [0.1]},
        "duration": 0.02,
        "progress": False,
    }
    return [
        Face("Criteria", studies.Criteria, dict),
        Face("Output", studies.Output, lambda: {"name": "x", "function": lambda result: 1.0}),
        Face(
            "graph_distance",
            studies.graph_distance,
            lambda: {"times": t, "values": t, "other_times": t, "other_values": t + 1},
        ),
        Face(
            "small_vibrations", studies.small_vibrations, lambda: {"scene": gallery.scenes()["double_pendulum"].build()}
        ),
        Face("acceleration_level", studies.acceleration_level, lambda: {"scene": small_scene()}),
        Face("standard_methods", studies.standard_methods, lambda: {"duration": 1.0}),
        Face("stability", studies.stability, lambda: {"scene": case(), **stability}),
        Face("work_precision", studies.work_precision, _work_arguments),
        Face("right_size", studies.right_size, _sized),
        Face("StabilityMap.of", studies.StabilityMap.of, lambda: {"method": "a"}, _map),
        Face("StabilityMap.largest_sound", studies.StabilityMap.largest_sound, lambda: {"method": "a"}, _map),
        Face("StabilityMap.largest_untroubled", studies.StabilityMap.largest_untroubled, lambda: {"method": "a"}, _map),
        Face("StabilityMap.draw", studies.StabilityMap.draw, _drawn, _map),
        Face("outcome_legend", studies.outcome_legend, dict),
        Face("RightSize.csv", studies.RightSize.csv, lambda: {"path": "runs.csv"}, _right),
        Face("Output.of", studies.Output.of, lambda: {"result": result()}, _output),
        Face("StabilityMap.csv", studies.StabilityMap.csv, lambda: {"path": "map.csv"}, _map),
        Face("StabilityMap.plot", studies.StabilityMap.plot, dict, _map),
        Face("WorkPrecision.of", studies.WorkPrecision.of, dict, _work),
        Face("WorkPrecision.cheapest", studies.WorkPrecision.cheapest, lambda: {"tolerance": 0.1}, _work),
        Face("WorkPrecision.advice", studies.WorkPrecision.advice, dict, _work),
        Face("WorkPrecision.csv", studies.WorkPrecision.csv, lambda: {"path": "work.csv"}, _work),
        Face("WorkPrecision.plot", studies.WorkPrecision.plot, dict, _work),
    ]
