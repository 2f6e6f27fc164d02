"""A spatial scene: bodies, ground, joints, loads and sensors, and the flat arrays it is compiled to."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import absent, array_of, flag, told_by
from lcpflex.bodies.body import Body, Reducible
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.errors import ModelError, ModelWarning, shown
from lcpflex.force_laws.law import Law
from lcpflex.scene import compiling
from lcpflex.scene.contact_rules import contact_between, rule_of
from lcpflex.scene.declared import ContactRule, DeclaredContact
from lcpflex.scene.naming import free_name
from lcpflex.scene.orders import is_reducible, refuse_options
from lcpflex.scene.placed_surface import PlacedSurface, check_own
from lcpflex.scene.register import Register, Start
from lcpflex.scene.sensors.sensor import Sensor, check_placed_sensor
from lcpflex.scene.spatial import clearances
from lcpflex.scene.spatial.handles import Place, SpatialPlaced
from lcpflex.scene.spatial.orientation import matrix_of, quaternion_of
from lcpflex.scene.spatial.relative import SpatialJoint, SpatialLoad
from lcpflex.scene.substitution import exchanged
from lcpflex.scene.user_functions import check_names, functions_of

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from lcpflex.bodies.reduction.damping import Damping
    from lcpflex.bodies.reduction.stiffening import Stiffening
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.compiling import CompiledScene, ReductionOrder

__all__ = ["SpatialParts", "SpatialScene"]


class SpatialParts(NamedTuple):
    """All that has been declared of a spatial scene."""

    placed: tuple[SpatialPlaced, ...]
    joints: dict[str, SpatialJoint]
    loads: tuple[SpatialLoad, ...]
    sensors: dict[str, Sensor]
    contacts: dict[str, DeclaredContact]
    surfaces: tuple[PlacedSurface, ...]  # made by hand on bodies and the ground
    rules: tuple[ContactRule, ...]

    @property
    def bodies(self) -> tuple[SpatialBody, ...]:
        """What was placed, in the same order."""
        return tuple(one.source for one in self.placed if one.source is not None)

    def rotation(self, body: int) -> FloatArray:
        """(3, 3) axes of a body at the start, those of the world for the ground."""
        if body < 0:
            return np.eye(3)
        w, x, y, z = self.placed[body].start[0][3:7]
        return np.asarray(libs.Rotation.from_quat([x, y, z, w]).as_matrix())


_SLOTS = "slots are planar; in space let a sphere or capsule run between surfaces of ground.box(...) or of bodies"
_KNOWN_AS = {
    **dict.fromkeys(("slot", "contact_slot"), _SLOTS),
}


class SpatialScene(Register):
    """A spatial scene under construction.

    Bodies move in three dimensions: q has 7 + n numbers a body, u has 6 + n (:mod:`lcpflex.model.spatial`). The verbs
    are those of the planar :class:`lcpflex.Scene`.

    Parameters
    ----------
    gravity
        (3,) [m/s^2], world axes.

    Raises
    ------
    ModelError
        Here and in every method, for arguments that cannot be.
    """

    spatial: ClassVar[bool] = True
    _known_as: ClassVar[Mapping[str, str]] = _KNOWN_AS
    _axes: ClassVar[int] = 3
    _kind: ClassVar[type] = SpatialBody

    def __init__(self, gravity: npt.ArrayLike = (0.0, 0.0, -9.81)) -> None:
        self.gravity = gravity
        vars(self)["ground"] = SpatialPlaced("ground", -1, None, (np.zeros(0), np.zeros(0)), self)
        self._placed: dict[str, SpatialPlaced] = {}
        self._joints: dict[str, SpatialJoint] = {}
        self._loads: list[SpatialLoad] = []
        self._sensors: dict[str, Sensor] = {}
        self._surfaces: list[PlacedSurface] = []
        self._contacts: dict[str, DeclaredContact] = {}
        self._rules: list[ContactRule] = []
        self._between: dict[frozenset[str], str] = {}  # name of the contact between two surfaces, by their labels
        self._made: Counter[str] = Counter()  # surfaces made of each kind, by their labels without the number

    @property
    def ground(self) -> SpatialPlaced:
        """The ground, on which points and surfaces are made as on bodies."""
        found: SpatialPlaced = vars(self)["ground"]
        return found

    def __getstate__(self) -> dict[str, Any]:
        """All of it; functions of the user by their names, ModelError for one that cannot be found by it."""
        check_names(functions_of(self.parts()))
        return vars(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> SpatialScene:
        """Handles that are copied with it are of the copy; functions of the user are the same ones."""
        copied = memo[id(self)] = SpatialScene.__new__(SpatialScene)
        vars(copied).update(deepcopy(vars(self), memo))
        return copied

    def add(
        self,
        body: SpatialBody | Reducible,
        name: str | None = None,
        position: npt.ArrayLike = (0.0, 0.0, 0.0),
        orientation: Rotation | npt.ArrayLike | None = None,
        velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
        modal: npt.ArrayLike | None = None,
        modal_velocity: npt.ArrayLike | None = None,
        *,
        point: Place | None = None,
        modes: int | None = None,
        damping: Damping | None = None,
        stiffening: Stiffening | None = None,
        residual_damping: float | None = None,
        contact_nodes: int | None = None,
        **planar: Any,
    ) -> SpatialPlaced:
        """Put a body into the scene. The same body may be put in several times, and into several scenes.

        ``scene.add(Solid(...), modes=8)`` reduces a flexible body for this scene, when it is compiled, as
        :meth:`lcpflex.Scene.add` does: to its 8 lowest free modes, and to residual (static) modes for every joint,
        load, spring and contact that is declared on it, so that its static compliance there is that of its mesh.

        Parameters
        ----------
        body
            From ``Sphere``, ``Cuboid``, ``Cylinder``, ``Capsule``, ``ConvexHull``, ``SpatialBody``; a flexible one with
            ``modes``: ``Solid``, ``SpatialMatrices``, ``SpatialBeam``; or one that was reduced by hand:
            ``Solid(...).reduce(modes=8)``.
        name
            Unique in the scene; body1, body2, ... if omitted.
        position, orientation
            Place (3,) [m] of the frame of the body, and how it is turned: a scipy Rotation, a 3 x 3 matrix whose
            columns are the axes of the body in those of the world, or None for axes along those of the world.
        velocity, angular_velocity
            Velocity (3,) of the origin of that frame [m/s] and angular velocity (3,) [rad/s], both in **world axes**.
            (In ``u``, the angular velocity is in body axes.)
        point
            Which point of the body ``position`` and ``velocity`` are of: a name, as "left" or "center" of a
            :class:`SpatialBeam`, or a place (3,) in its frame [m]; the origin of the frame if omitted, which is the
            middle of ``SpatialBeam`` (and the left end of the planar ``Beam``).
        modal, modal_velocity
            (n,) initial modal coordinates [kg^1/2 m] and their rates, 0 if omitted; with ``modes``, of the free modes.
        modes
            Number of free modes, of a body that is reduced here; 0 for a rigid one.
        damping, stiffening, residual_damping
            As for ``body.reduce``; ``stiffening`` of what takes it there.
        contact_nodes
            At how many nodes of its mesh a surface that touches gets residual modes at most, evenly spread: for normal
            forces, where there is friction for all. If omitted, as few as will do: none where the free modes give way
            as the mesh does, to a hundredth, or else 3, 5 or 9; and none, with a warning, where 9 do not do. A named
            face, :meth:`SpatialPlaced.face`, gets them at all its nodes, or at so many patches of it.
        **planar
            What only the planar ``add`` has (``angle``): refused, with what is to be done in space.
        """
        _refuse_planar(planar)
        called = free_name("body", name, self._placed)
        order = None
        options = {
            "modes": modes, "damping": damping, "stiffening": stiffening, "residual_damping": residual_damping,
            "contact_nodes": contact_nodes,
        }  # fmt: skip
        if is_reducible(body, (SpatialBody, Body)):
            others = (placed.order for placed in self._placed.values() if placed.order is not None)
            asked = (damping, stiffening, residual_damping, contact_nodes, modal, modal_velocity)
            order, source = compiling.order_of(called, body, modes, *asked, others, SpatialBody)
            modal = modal_velocity = None
        else:
            source = _checked(body)
            refuse_options(options, "SpatialBody", "Solid(...)")
        n = source.modes
        A = matrix_of("orientation", orientation)
        eta = np.zeros(n) if modal is None else array_of("modal", modal, (n,))
        rate = np.zeros(n) if modal_velocity is None else array_of("modal_velocity", modal_velocity, (n,))
        omega = A.T @ array_of("angular_velocity", angular_velocity, (3,))
        start = np.concatenate([array_of("position", position, (3,)), quaternion_of(A), eta])
        velocities = np.concatenate([array_of("velocity", velocity, (3,)), omega, rate])
        placed = SpatialPlaced(called, len(self._placed), source, (start, velocities), self, order)
        if point is not None:
            place, turning = placed._arm(point, A)
            start[:3] -= place
            velocities[:3] -= turning
        self._placed[called] = placed
        return placed

    def _put(self, name: str, body: SpatialBody, start: Start, order: ReductionOrder | None) -> None:
        """Take a body of another scene by its name, at a configuration with a velocity; some are reduced later."""
        self._placed[name] = SpatialPlaced(name, len(self._placed), body, start, self, order)

    def body(self, name: str) -> SpatialPlaced:
        """The body of that name."""
        if not isinstance(name, str) or name not in self._placed:
            raise ModelError(f"name: no body {absent(name, self._placed)}")
        return self._placed[name]

    def join(self, joint: SpatialJoint) -> str:
        """Add a joint or a drive; returns its name (joint1, joint2, ... if omitted)."""
        if isinstance(joint, type) or not isinstance(joint, SpatialJoint):
            raise ModelError(f"joint: {shown(joint)} was given, expected a joint such as Ball(P, Q)")
        check_own(self, "joint", joint.P)
        name = free_name("joint", joint.name or None, self._joints)
        self._joints[name] = joint
        return name

    def load(self, load: SpatialLoad) -> None:
        """Add a spring, bushing, force or torque.

        load: ``Spring``, ``TorsionSpring``, ``Bushing``, ``Force`` or ``Torque``.
        """
        if isinstance(load, type) or not isinstance(load, SpatialLoad):
            raise ModelError(f"load: {shown(load)} was given, expected a load such as Force(P, value) or Spring(P, Q)")
        check_own(self, "load", load.P)
        self._loads.append(load)

    def sensor(self, sensor: Sensor) -> str:
        """Add a sensor of :mod:`lcpflex.scene.sensors`; returns its name (sensor1, sensor2, ... if omitted).

        See :meth:`lcpflex.Scene.sensor`.
        """
        check_placed_sensor(self, sensor)
        name = free_name("sensor", sensor.name or None, self._sensors)
        self._sensors[name] = sensor
        return name

    def contact(
        self,
        a: PlacedSurface,
        b: PlacedSurface,
        friction: float = 0.0,
        restitution: float = 0.0,
        tangential_restitution: float = 0.0,
        name: str | None = None,
        *,
        node_side: PlacedSurface | None = None,
        law: Law | None = None,
        points: str | None = None,
    ) -> str:
        """Declare that two surfaces may touch; returns the name of the contact (contact1, contact2, ... if omitted).

        Friction is Coulomb's, isotropic: the exact cone |friction force| <= mu normal force, without torsional or
        rolling friction.

        friction: mu >= 0; restitution: Newton's e_N in [0, 1]; tangential_restitution: e_T in [0, 1]. ``node_side``,
        one of a and b: its points touch the features of the other, and no more; of two faces the finer one, if omitted.
        ``law``: a continuous contact force, as in :meth:`lcpflex.Scene.contact`.

        ``points`` of a face, ``body.face(name)``: "nodes" for forces at its nodes; or "areas" for one force about each
        corner of its sub-faces (quadratic facets have four), with the hat function phi_a there as its weight: the gap
        is the mean over the area, force over area is the pressure, and patches of unlike meshes carry a uniform one. If
        omitted, nodes of linear facets on planes, spheres, holes, cylinders and capsules, and areas of all others.
        """
        declared = contact_between(
            self, self._between, a, b, friction, restitution, tangential_restitution, node_side, law, points
        )
        name = free_name("contact", name, self._contacts)
        self._contacts[name] = declared
        self._between[frozenset((a.label, b.label))] = name
        return name

    revolute_with_clearance = clearances.revolute_with_clearance

    def contact_all(
        self,
        friction: float = 0.0,
        restitution: float = 0.0,
        tangential_restitution: float = 0.0,
        exclude: Sequence[tuple[SpatialPlaced | PlacedSurface, SpatialPlaced | PlacedSurface]] = (),
        *,
        law: Law | None = None,
    ) -> None:
        """Everything against everything: the surface of each body and all surfaces made on bodies and on the ground.

        What is left out, told and refused, and how contacts are named, is as in :meth:`lcpflex.Scene.contact_all`.

        A face takes part where the whole surface of its body does not: with ``exclude=[(body.surface(), other)]``.

        friction, restitution, tangential_restitution, law: as in :meth:`contact`, of all these contacts. exclude: pairs
        of bodies or surfaces.
        """
        self._rules.append(rule_of(self, friction, restitution, tangential_restitution, exclude, law))

    def compile(self, project: bool = False, indents: Callable[[str], bool] | None = None) -> CompiledScene:
        """Check the scene as a whole and compile it; the scene is not changed.

        With ``project``, an initial state that violates joints is moved onto them, and bodies that penetrate each other
        are pushed apart, by the least motion in the mass metric (see :func:`lcpflex.simulate`); else both are errors.
        Contacts by a force law, and those that ``indents`` names, may penetrate.
        """
        if indents is not None and (isinstance(indents, type) or not callable(indents)):
            raise ModelError(f"indents: {shown(indents)} was given, expected a function of the name of a contact")
        project = flag("project", project)
        compiled = self.compiled(project, None if indents is None else told_by("indents", indents), push=project)
        for warning in compiled.warnings:
            warnings.warn(warning, ModelWarning, stacklevel=2)
        return compiled

    def compiled(
        self,
        project: bool = False,
        indents: Callable[[str], bool] | None = None,
        gives_way: bool = False,
        push: bool | None = False,
    ) -> CompiledScene:
        """:meth:`compile` without a word: its warnings are those of the result.

        project, indents: as in :meth:`compile`. push: whether contacts that penetrate are pushed out, too;
        None: they may, as the scene begins elsewhere. gives_way:
        bodies that are reduced here give way by modes of their own at every contact.
        """
        return compiling.compiled_spatial_scene(self, project, indents, gives_way, push)

    def with_bodies(self, bodies: Mapping[str, SpatialBody]) -> SpatialScene:
        """A new scene like this one with other bodies under the names of ``bodies``; this one is not changed.

        As :meth:`lcpflex.Scene.with_bodies`; an initial deformation is carried over to modes of the same mesh alone,
        as far as they can follow it.

        Raises
        ------
        ModelError
            For an unknown name, anything but a body of space, what the new body does not have, and a deformed body in
            the place of which one of another mesh is put.
        """
        return exchanged(self, bodies)

    def reduced(self) -> SpatialScene:
        """This scene with the bodies reduced that are reduced when it is compiled; itself where there are none."""
        return compiling.reduced_scene(self)[0]

    def parts(self) -> SpatialParts:
        """What has been declared, in the order in which it was."""
        return SpatialParts(
            tuple(self._placed.values()),
            dict(self._joints),
            tuple(self._loads),
            dict(self._sensors),
            dict(self._contacts),
            tuple(self._surfaces),
            tuple(self._rules),
        )

    def _holder(self, body: int) -> SpatialPlaced:
        """The body with that index, the ground for -1."""
        return self.ground if body < 0 else tuple(self._placed.values())[body]


def _refuse_planar(given: Mapping[str, Any]) -> None:
    """Raise ModelError for arguments that bodies of the plane have, TypeError for those that none has."""
    for name, value in given.items():
        if name != "angle":
            raise TypeError(f"SpatialScene.add() got an unexpected keyword argument {name!r}")
        words = f"expected orientation=Rotation.from_rotvec([0, 0, {shown(value)}])"
        raise ModelError(f"{name}: {shown(value)} was given, which is for planar scenes, {words}")


def _checked(body: object) -> SpatialBody:
    if isinstance(body, SpatialBody):
        return body
    if isinstance(body, Body):
        raise ModelError(
            "body: a planar Body was given, expected a spatial one such as Cuboid(...), Sphere(...) or Solid(...) and "
            "modes=8"
        )
    raise ModelError(
        f"body: {shown(body)} was given, expected a SpatialBody such as Cuboid(...) or Sphere(...), or a flexible body "
        "and modes=8"
    )
