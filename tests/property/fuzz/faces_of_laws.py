"""Laws of contact, meshes and advice."""

from __future__ import annotations

import inspect
from typing import Any

from lcpflex import laws, meshes
from lcpflex.checks import resolution_rules as advice
from tests.property.fuzz.face import Face, beam, body, mesh, pair, steel

__all__ = ["advice_faces", "law_faces", "mesh_faces"]


def law_faces() -> list[Face]:
    pair_laws = (
        "DubowskyFreudenstein",
        "Esdu78035",
        "Goldsmith",
        "Johnson",
        "LankaraniNikraveshCylinder",
        "Liu",
        "Pereira",
        "Persson",
        "Radzimovsky",
    )
    frictions = (
        "Ambrosio",
        "ArctangentCoulomb",
        "BengisuAkay",
        "BrownMcPhee",
        "RampCoulomb",
        "SmoothedCoulomb",
        "Threlfall",
    )
    rubbing = {"slip": 0.1, "normal": 1.0, "mu": 0.3}
    elastic = {
        "PowerLaw": lambda: laws.PowerLaw(1e9),
        "Hertz": lambda: laws.Hertz(0.01, 1e11, 0.01),
        **{name: lambda name=name: getattr(laws, name)(pair()) for name in pair_laws},
        "UserLaw": lambda: laws.UserLaw(lambda d, v, v0, p: 1e6 * d, compiled=False),
    }
    out = [
        Face("Material", laws.Material, lambda: {"youngs_modulus": 2e11, "poissons_ratio": 0.3}),
        Face("PowerLaw", laws.PowerLaw, lambda: {"stiffness": 1e9}),
        Face("Hertz", laws.Hertz, lambda: {"effective_radius": 0.01, "contact_modulus": 1e11, "smallest_radius": 0.01}),
        Face("Hertz.spheres", laws.Hertz.spheres, lambda: {"radius": 0.01, "other_radius": 0.02, "material": steel()}),
        Face("Hertz.sphere_on_plane", laws.Hertz.sphere_on_plane, lambda: {"radius": 0.01, "material": steel()}),
        Face(
            "Hertz.sphere_in_cup",
            laws.Hertz.sphere_in_cup,
            lambda: {"radius": 0.01, "cup_radius": 0.02, "material": steel()},
        ),
        Face(
            "Hertz.between",
            laws.Hertz.between,
            lambda: {"a": body().surface(), "b": body("box").circle((0, 0), 0.1), "material": steel()},
        ),
        Face(
            "CylinderPair.internal",
            laws.CylinderPair.internal,
            lambda: {"hole_radius": 0.011, "pin_radius": 0.01, "length": 0.1, "material": steel()},
        ),
        Face(
            "CylinderPair.external",
            laws.CylinderPair.external,
            lambda: {"radius": 0.011, "other_radius": 0.01, "length": 0.1, "material": steel()},
        ),
        Face(
            "CylinderPair.between",
            laws.CylinderPair.between,
            lambda: {"a": body().surface(), "b": body().hole((0, 0), 0.11), "length": 0.1, "material": steel()},
        ),
        Face("ContactLaw", laws.ContactLaw, lambda: {"elastic": laws.PowerLaw(1e9)}),
        Face("HysteresisDamping", laws.HysteresisDamping, lambda: {"restitution": 0.5}),
        Face(
            "HysteresisFactor.eta",
            laws.HysteresisFactor.eta,
            lambda: {"restitution": 0.5},
            lambda: laws.HysteresisFactor.EXACT,
        ),
        Face(
            "HysteresisFactor.rebound",
            laws.HysteresisFactor.rebound,
            lambda: {"restitution": 0.5},
            lambda: laws.HysteresisFactor.EXACT,
        ),
        *(
            Face(name, getattr(laws, name), lambda: {"restitution": 0.5})
            for name in ("Jankowski", "KelvinVoigt", "Tsuji", "PermanentIndentation")
        ),
        *(
            Face(f"{name}.rebound", getattr(laws, name).rebound, lambda: {"restitution": 0.5})
            for name in ("Jankowski", "KelvinVoigt", "Tsuji", "PermanentIndentation")
        ),
        *(
            Face(f"{name}.rebound", getattr(laws, name).rebound, lambda: {"parameter": 0.5})
            for name in ("KuwabaraKono", "Ristow")
        ),
        Face("KuwabaraKono", laws.KuwabaraKono, lambda: {"relaxation": 1e-6}),
        Face("Ristow", laws.Ristow, lambda: {"rate": 1.0}),
        *(Face(name, getattr(laws, name), lambda: {"pair": pair()}) for name in pair_laws),
        *(Face(name, getattr(laws, name), dict) for name in (*frictions, "LuGre", "Bristle")),
        *(
            Face(f"{name}.force", getattr(laws, name).force, lambda: dict(rubbing), getattr(laws, name))
            for name in frictions
        ),
        Face("LuGre.steady_force", laws.LuGre.steady_force, lambda: dict(rubbing), laws.LuGre),
        Face("Persson.force_at_angle", laws.Persson.force_at_angle, lambda: {"eps": 0.5}, elastic["Persson"]),
        Face("UserLaw", laws.UserLaw, lambda: {"function": lambda d, v, v0, p: 1e6 * d, "compiled": False}),
        Face(
            "fit_power_law",
            laws.fit_power_law,
            lambda: {"law": laws.PowerLaw(1e9), "load_range": (1.0, 100.0), "points": 10},
        ),
        Face(
            "impact_function",
            laws.impact_function,
            lambda: {"stiffness": 1e8, "exponent": 1.5, "damping": 1e3, "depth": 1e-5},
        ),
        Face("prescribed_restitution", laws.prescribed_restitution, lambda: {"law": laws.KelvinVoigt, "e_out": 0.5}),
        Face("restitution_of", laws.restitution_of, lambda: {"law": laws.Jankowski, "e": 0.5}),
    ]
    for name, make in elastic.items():
        kind = type(make())
        for method in ("force", "stiffness_at", "stiffness", "energy", "indentation"):
            if callable(getattr(kind, method, None)):
                argument = list(inspect.signature(getattr(kind, method)).parameters)[1]
                out.append(
                    Face(f"{name}.{method}", getattr(kind, method), lambda argument=argument: {argument: 1e-6}, make)
                )
    return out


def mesh_faces() -> list[Face]:
    def face(name: str, **arguments: Any) -> Face:
        return Face(f"meshes.{name}", getattr(meshes, name), lambda: dict(arguments))

    return [
        face("rectangle", length=1.0, height=1.0, nx=2, ny=2),
        face("bar", length=1.0, height=0.1, elements=2),
        face("grid", x=[0.0, 1.0], y=[0.0, 1.0]),
        face("ring", inner=1.0, outer=2.0, around=8, through=1),
        face("half_disc", radius=1.0, size=0.5),
        face("half_section_of_sphere", radius=1.0, size=0.5),
        face("half_section_of_rod", length=1.0, radius=0.5, size=0.5),
        Face("meshes.quadratic", meshes.quadratic, lambda: {"mesh": mesh()}),
        Face(
            "meshes.graded",
            meshes.graded,
            lambda: {"mesh": meshes.rectangle(1.0, 1.0, 2, 2, triangles=True), "towards": (0.0, 0.0), "finest": 0.2},
        ),
    ]


def advice_faces() -> list[Face]:
    def face(name: str, **arguments: Any) -> Face:
        return Face(f"advice.{name}", getattr(advice, name), lambda: dict(arguments))

    def advised(
        mass: Any,
        radius: Any,
        modulus: Any,
        speed: Any,
        wave_speed: Any,
        half_section: Any = False,
        fraction: Any = 0.1,
    ) -> Any:
        return advice.contact_advice(
            mass, radius, modulus, speed, wave_speed, half_section=half_section, fraction=fraction
        )

    return [
        face("wave_speed", youngs_modulus=2e11, density=7800.0),
        face("element_size", frequency=1e4, wave_speed=5e3),
        face("effective", first=1.0, second=2.0),
        face("effective_modulus", first=(2e11, 0.3)),
        face("contact_time", mass=1.0, radius=0.01, modulus=1e11, speed=1.0),
        face("excited_frequency", contact_time=1e-4),
        face("contact_radius", force=10.0, radius=0.01, modulus=1e11),
        face("contact_pairs", contact_radius=1e-3, element_size=1e-4),
        Face(
            "advice.contact_advice",
            advised,
            lambda: {"mass": 1.0, "radius": 0.01, "modulus": 1e11, "speed": 1.0, "wave_speed": 5e3},
        ),
        Face("advice.modes_needed", advice.modes_needed, lambda: {"body": beam(), "frequency": 1e3}),
    ]
