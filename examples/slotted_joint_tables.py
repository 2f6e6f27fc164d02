"""Stiffness and exponent of the laws of line contact: the tables of Autiero et al., and their slotted joint.

Laws of line contact give the indentation for a force, by a logarithm. The review fits F = K delta^n to each, for
clearances of 0.5 to 80 mm, and prints K, n and the greatest error: eight tables, of four laws, for two materials that
it does not name. They come out, to the digits printed, with these readings, which were found by trying:

- K is per mm of length, in N and mm. Least squares in the force, unweighted, over even loads up to 1000 N/mm; the
  error is the greatest from 1 um on. `lf.laws.fit_power_law` does the same.
- Odd tables are of steel, 207 GPa and 0.3; even ones of aluminium, 70 GPa and 0.33. The powers of ten of K are lost
  in the text that was read here, and follow from the fit.
- Its ESDU 78035 has H = 1/E* where others have 1/(pi E*), and is three times softer than all other laws.
- Its Goldsmith comes out with 1e8 mm^2 in the logarithm only: m = 3 for a contact of 10 m. No joint is that long; the
  units have slipped.

Two misprints show: the exponents of table 8 (ESDU, aluminium) are those of table 7, where the fit gives up to 0.035
more; in table 4 (Johnson, aluminium, 80 mm) 1.083 stands for 1.108.

The last table of the review, K and n for the three contacts of its scotch yoke (the pin of 7.9 mm on the inner track of
52, on the outer one of 68 and at the ends of 8 mm), is empty in that text: what its protocol gives is printed by this
example. Lankarani's n is 1.5, and no fit. At the ends, with 0.1 mm of clearance, the loads of the fit are far beyond
what the laws are valid for.

What can be checked of its text: for every law K, n and the error of the fit fall as the clearance grows. Its charts of
the yoke cannot be compared: crank, drive, restitution and duration are lost. In their place the last panel shows the
first impact on the outer track in the yoke of `scotch_yoke.py`, by K and n (lines) and by the law itself (dots). The
peaks of both are within 0.2 %: in an impact the errors of the tables, which are those of the smallest loads, do not
matter. What does is the law: 1.30 kN by Lankarani's, 1.46 by ESDU's, 1.87 by Goldsmith's, 2.60 by Radzimovsky's and
2.71 by Johnson's.
"""

import runpy
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import laws

MM = 1e-3
CLEARANCES = (0.5, 5.0, 10.0, 30.0, 60.0, 80.0)  # [mm]
MATERIALS = {"steel": laws.Material(207e9, 0.3), "aluminium": laws.Material(70e9, 0.33)}
PRINTED = {  # K [1e3 N/mm^n per mm], n and the greatest error [%], for each clearance
    ("Radzimovsky", "steel"): (
        (104.0, 62.4, 55.5, 47.2, 43.2, 41.7),
        (1.162, 1.118, 1.109, 1.097, 1.091, 1.089),
        (6.1, 4.1, 3.8, 3.2, 3.0, 2.9),
    ),
    ("Radzimovsky", "aluminium"): (
        (41.308, 22.979, 20.228, 16.993, 15.434, 14.867),
        (1.195, 1.135, 1.123, 1.108, 1.100, 1.098),
        (14.6, 9.0, 8.0, 6.7, 6.1, 5.8),
    ),
    ("Johnson", "steel"): (
        (142.0, 75.3, 65.4, 54.4, 49.1, 47.2),
        (1.192, 1.133, 1.122, 1.107, 1.100, 1.097),
        (7.4, 4.8, 4.3, 3.7, 3.4, 3.2),
    ),
    ("Johnson", "aluminium"): (
        (60.628, 28.324, 24.286, 19.782, 17.703, 16.962),
        (1.242, 1.155, 1.140, 1.121, 1.111, 1.083),
        (18.9, 10.9, 9.5, 7.8, 7.0, 6.7),
    ),
    ("Goldsmith", "steel"): (
        (28.6, 23.9, 22.7, 20.9, 19.4, 18.4),
        (1.066, 1.057, 1.055, 1.051, 1.048, 1.046),
        (2.0, 1.6, 1.5, 1.4, 1.3, 1.2),
    ),
    ("Goldsmith", "aluminium"): (
        (10.032, 8.354, 7.933, 7.273, 6.752, 6.394),
        (1.071, 1.061, 1.058, 1.054, 1.050, 1.048),
        (3.7, 2.9, 2.8, 2.5, 2.3, 2.1),
    ),
    ("ESDU 78035", "steel"): (
        (28.4, 17.7, 15.9, 13.6, 12.5, 12.1),
        (1.165, 1.119, 1.110, 1.098, 1.092, 1.090),
        (12.2, 8.0, 7.2, 6.1, 5.6, 5.4),
    ),
    ("ESDU 78035", "aluminium"): (
        (10.868, 6.395, 5.691, 4.849, 4.437, 4.286),
        (1.165, 1.119, 1.110, 1.098, 1.092, 1.090),
        (23.6, 14.4, 12.8, 10.7, 9.6, 9.3),
    ),
}
CONTACTS = {"inner track": ("external", 52.0), "outer track": ("internal", 68.0), "end": ("internal", 8.0)}
PIN = 7.9  # [mm]
UNTIL = 0.029  # the first impact on the outer track is over [s]
COLOURS = {"Lankarani": "C4", "Radzimovsky": "C0", "Johnson": "C1", "Goldsmith": "C2", "ESDU 78035": "C3"}


def implicit(name: str, pair: laws.CylinderPair) -> Any:
    """The law that is fitted, in the reading of the review."""
    if name == "Goldsmith":  # of a contact of 10 m, whatever the pair
        make = laws.CylinderPair.internal if pair.is_internal else laws.CylinderPair.external
        return laws.Goldsmith(make(pair.first_radius, pair.second_radius, 1e4 * MM, pair.material), m=3, lenient=True)
    if name == "ESDU 78035":
        return laws.Esdu78035(pair, reading="review", lenient=True)
    return {"Radzimovsky": laws.Radzimovsky, "Johnson": laws.Johnson}[name](pair, lenient=True)


def fitted(name: str, pair: laws.CylinderPair) -> tuple[float, float, float]:
    """K [N/mm^n per mm], n and the greatest error of the power law for a pair, as the review fits it.

    Lankarani & Nikravesh's law does not depend on the length: K is that of the whole contact.
    """
    if name == "Lankarani":
        stiffness, exponent = laws.LankaraniNikraveshCylinder(pair, lenient=True).parameters
        return stiffness * MM**exponent, exponent, 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)  # of ranges of validity
        law = implicit(name, pair)
        length = law.pair.length / MM
        fit = laws.fit_power_law(law, (0.0, 1000.0 * length))
    return fit.stiffness * MM**fit.exponent / length, fit.exponent, fit.max_relative_error


def tables() -> dict[tuple[str, str], np.ndarray]:
    """The eight tables computed: rows of K [1e3 N/mm^n per mm], n and error [%], a column for each clearance."""
    made = {}
    for name, material in PRINTED:
        pairs = [laws.CylinderPair.internal(0.1, (100.0 - c) * MM, MM, MATERIALS[material]) for c in CLEARANCES]
        made[name, material] = np.transpose([fitted(name, pair) for pair in pairs]) * [[1e-3], [1.0], [100.0]]
    return made


def joint(name: str) -> dict[str, tuple[float, float]]:
    """K [N/mm^n per mm, Lankarani: N/mm^n] and n for the three contacts of the yoke: the table that is lost."""
    found = {}
    for place, (kind, radius) in CONTACTS.items():
        make = laws.CylinderPair.external if kind == "external" else laws.CylinderPair.internal
        found[place] = fitted(name, make(radius * MM, PIN * MM, MM, MATERIALS["steel"]))[:2]
    return found


def by_table(name: str, pair: laws.CylinderPair) -> laws.PowerLaw:
    """The force law of one part of the slot, by K and n."""
    stiffness, exponent, _ = fitted(name, pair)
    return laws.PowerLaw(stiffness * MM**-exponent * (1.0 if name == "Lankarani" else pair.length / MM), exponent)


def impact(yoke: dict[str, Any], law: Any) -> tuple[lf.Result, np.ndarray, np.ndarray]:
    """The first impact on the outer track: the run, time since touch [ms] and force [kN]."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)
        scene = yoke["scene"](law)
    result = lf.simulate(scene, UNTIL, lf.Smooth(laws.ContactLaw(laws.PowerLaw(1e8))), record=5e-6)
    return result, *yoke["first_impact"](result)


def draw_tables(panels: np.ndarray, computed: dict[tuple[str, str], np.ndarray]) -> None:
    """K, n and error over the clearance: printed (marks) and computed (lines)."""
    for (name, material), values in computed.items():
        line, mark = ("-", "o") if material == "steel" else ("--", "s")
        for axes, mine, printed in zip(panels, values, PRINTED[name, material], strict=True):
            axes.plot(CLEARANCES, mine, COLOURS[name] + line, linewidth=1, label=f"{name}, {material}")
            axes.plot(CLEARANCES, printed, COLOURS[name] + mark, markersize=4, fillstyle="none")
    for axes, label in zip(panels, ("K [1e3 N/mm^n per mm]", "n", "greatest error of the fit [%]"), strict=True):
        axes.set(xscale="log", xlabel="clearance [mm]", ylabel=label)
        axes.grid(True, alpha=0.4)
    panels[0].set(yscale="log", title="marks: as printed; lines: computed")
    panels[2].legend(fontsize=8)


def draw_impacts(axes: Axes, yoke: dict[str, Any]) -> lf.Result:
    """By K and n, and by the law itself."""
    for name, colour in COLOURS.items():
        result, time, force = impact(yoke, lambda pair, name=name: by_table(name, pair))
        axes.plot(time, force, colour, label=f"{name}: {force[time < 0.6].max():.2f} kN")
        if name in ("Radzimovsky", "Johnson", "ESDU 78035"):
            _, time, force = impact(yoke, lambda pair, name=name: implicit(name, pair))
            axes.plot(time[::4], force[::4], colour + ".", markersize=4)
    axes.set(xlim=(-0.02, 0.45), xlabel="time since touch [ms]", ylabel="pin force [kN]")
    axes.set_title("first impact on the outer track; lines: by K and n, dots: by the law")
    axes.legend(fontsize=8)
    return result


def run(folder: Path = Path()) -> lf.Result:
    print("K [N/mm^n per mm; Lankarani: N/mm^n] and n of the scotch yoke's contacts")
    for name in COLOURS:
        row = "; ".join(f"{place} {K:.3e}, {n:.3f}" for place, (K, n) in joint(name).items())
        print(f"{name:12} {row}")
    figure = Figure(figsize=(13, 9), layout="constrained")
    panels = figure.subplots(2, 2)
    draw_tables(panels.ravel()[:3], tables())
    result = draw_impacts(panels[1, 1], runpy.run_path(str(Path(__file__).with_name("scotch_yoke.py"))))
    figure.savefig(folder / "slotted_joint_tables.png", dpi=110)
    return result


if __name__ == "__main__":
    print(run().summary())
