"""A planar scene: bodies, ground, joints, loads and contacts, and the flat arrays it is compiled to."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import absent, flag, told_by
from lcpflex.basics.renamed import renamed_keyword
from lcpflex.bodies.body import Body, Reducible, array_of
from lcpflex.errors import ModelError, ModelWarning, in_range, shown
from lcpflex.force_laws.law import Law
from lcpflex.scene import clearances, compiling
from lcpflex.scene.contact_rules import contact_between, rule_of
from lcpflex.scene.declared import ContactRule, DeclaredContact, Parts
from lcpflex.scene.handles import Place, Placed
from lcpflex.scene.joints.joint import Joint
from lcpflex.scene.loads.load import Load
from lcpflex.scene.naming import free_name
from lcpflex.scene.orders import is_reducible, refuse_options
from lcpflex.scene.placed_surface import PlacedSurface, check_own
from lcpflex.scene.register import Register, Start
from lcpflex.scene.sensors.sensor import Sensor, check_placed_sensor
from lcpflex.scene.substitution import exchanged
from lcpflex.scene.user_functions import check_names, functions_of

if TYPE_CHECKING:
    from lcpflex.bodies.reduction.damping import Damping
    from lcpflex.bodies.reduction.stiffening import Stiffening
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.compiling import CompiledScene, ReductionOrder

__all__ = ["Scene"]


_KNOWN_AS = {
    "slot": "slots are made on bodies, body.straight_slot(...) and curved_slot(...), for scene.contact_slot(...)",
}


class Scene(Register):
    """A planar scene under construction.

    Parameters
    ----------
    gravity
        (2,) [m/s^2], world axes.

    Raises
    ------
    ModelError
        Here and in every method, for arguments that cannot be.
    """

    spatial: ClassVar[bool] = False
    _known_as: ClassVar[Mapping[str, str]] = _KNOWN_AS
    _axes: ClassVar[int] = 2
    _kind: ClassVar[type] = Body

    def __init__(self, gravity: npt.ArrayLike = (0.0, -9.81)) -> None:
        self.gravity = gravity
        vars(self)["ground"] = Placed("ground", -1, None, (np.zeros(0), np.zeros(0)), self)
        self._placed: dict[str, Placed] = {}
        self._surfaces: list[PlacedSurface] = []
        self._joints: dict[str, Joint] = {}
        self._loads: list[Load] = []
        self._contacts: dict[str, DeclaredContact] = {}
        self._rules: list[ContactRule] = []
        self._sensors: dict[str, Sensor] = {}
        # looked up with each declaration: a scene of n parts is declared in n steps, not in n squared
        self._between: dict[frozenset[str], str] = {}  # name of the contact between two surfaces, by their labels
        self._by_index: list[Placed] = []
        self._made: Counter[str] = Counter()  # surfaces made of each kind, by their labels without the number

    @property
    def ground(self) -> Placed:
        """The ground, on which points and surfaces are made as on bodies."""
        found: Placed = vars(self)["ground"]
        return found

    def __getstate__(self) -> dict[str, Any]:
        """All of it; functions of the user by their names, ModelError for one that cannot be found by it."""
        check_names(functions_of(self.parts()))
        return vars(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        """Handles that are copied with it are of the copy; functions of the user are the same ones."""
        copied = memo[id(self)] = Scene.__new__(Scene)
        vars(copied).update(deepcopy(vars(self), memo))
        return copied

    def add(
        self,
        body: Body | Reducible,
        name: str | None = None,
        position: npt.ArrayLike = (0.0, 0.0),
        angle: float = 0.0,
        velocity: npt.ArrayLike = (0.0, 0.0),
        angular_velocity: float = 0.0,
        modal: npt.ArrayLike | None = None,
        modal_velocity: npt.ArrayLike | None = None,
        *,
        point: Place | None = None,
        modes: int | None = None,
        damping: Damping | None = None,
        stiffening: Stiffening | None = None,
        residual_damping: float | None = None,
        contact_nodes: int | None = None,
    ) -> Placed:
        """Put a body into the scene. The same body may be put in several times, and into several scenes.

        ``scene.add(Beam(...), modes=8)`` reduces a flexible body for this scene, when it is compiled: to its 8 lowest
        free modes, and to residual (static) modes for every joint, load, spring and contact that is declared on it, so
        that its static compliance there is that of its mesh. Until then the handle answers for points and surfaces of
        the mesh. What came out is in :meth:`lcpflex.results.result.Result.modes_of`.

        Parameters
        ----------
        body
            From ``Disc``, ``Box``, ``Polygon``, ``RigidBody``; a flexible one with ``modes``: ``Beam``, ``Bar``,
            ``Continuum``, ``SolidOfRevolution``, ``Matrices``; or one that was reduced by hand: ``Beam(...).reduce()``.
        name
            Unique in the scene; body1, body2, ... if omitted.
        position, angle
            Place (2,) [m] and angle [rad] of the frame of the body.
        velocity, angular_velocity
            Velocity (2,) of the origin of that frame [m/s], world axes, and angular velocity [rad/s].
        point
            Which point of the body ``position`` and ``velocity`` are of: a name, as "center" or "left" of a
            :class:`Beam`, or a place (2,) in its frame [m]; the origin of the frame if omitted, which is the left end
            of ``Beam`` and ``Bar``.
        modal, modal_velocity
            (n,) initial modal coordinates [kg^1/2 m] and their rates, 0 if omitted (see ``body.project``); with
            ``modes``, of the free modes.
        modes
            Number of free modes, of a body that is reduced here; 0 for a rigid one.
        damping, stiffening, residual_damping
            As for ``body.reduce``.
        contact_nodes
            How many nodes of a surface get residual modes at most, evenly spread. If omitted, as few as will do: none
            where the free modes give way as the mesh does, to a hundredth, or else 3, 5 or 9; and 3 where 9 do not do.
        """
        called = free_name("body", name, self._placed)
        order = None
        if is_reducible(body, (Body,)):
            others = (placed.order for placed in self._placed.values() if placed.order is not None)
            asked = (damping, stiffening, residual_damping, contact_nodes, modal, modal_velocity)
            order, source = compiling.order_of(called, body, modes, *asked, others, Body)
            modal = modal_velocity = None
        elif not isinstance(body, Body):
            raise ModelError(f"body: {shown(body)} was given, expected a Body, or a flexible body and modes=8")
        else:
            options = {
                "modes": modes, "damping": damping, "stiffening": stiffening, "residual_damping": residual_damping,
                "contact_nodes": contact_nodes,
            }  # fmt: skip
            refuse_options(options, "Body", "Beam(...)")
            source = body
        start = _state(source.modes, position=position, angle=angle, modal=modal)
        rates = {"velocity": velocity, "angular_velocity": angular_velocity, "modal_velocity": modal_velocity}
        rate = _state(source.modes, **rates)
        placed = Placed(called, len(self._placed), source, (start, rate), self, order)
        if point is not None:
            place, turning = placed._arm(point)
            start[:2] -= place
            rate[:2] -= turning
        return self._place(placed)

    def _put(self, name: str, body: Body, start: Start, order: ReductionOrder | None) -> None:
        """Take a body of another scene by its name, at a configuration with a velocity; some are reduced later."""
        self._place(Placed(name, len(self._placed), body, start, self, order))

    def _place(self, placed: Placed) -> Placed:
        self._placed[placed.name] = placed
        self._by_index.append(placed)
        return placed

    def body(self, name: str) -> Placed:
        """The body of that name."""
        if not isinstance(name, str) or name not in self._placed:
            raise ModelError(f"name: no body {absent(name, self._placed)}")
        return self._placed[name]

    def join(self, joint: Joint) -> str:
        """Add a joint or a drive of :mod:`lcpflex.scene.joints`; returns its name (joint1, joint2, ... if omitted)."""
        if isinstance(joint, type) or not isinstance(joint, Joint):
            raise ModelError(f"joint: {shown(joint)} was given, expected a joint such as Revolute(P, Q)")
        check_own(self, "joint", joint.P)
        name = free_name("joint", joint.name or None, self._joints)
        self._joints[name] = joint
        return name

    def load(self, load: Load) -> None:
        """Add a spring, force or torque of :mod:`lcpflex.scene.loads`.

        load: ``Spring``, ``TorsionSpring``, ``Force`` or ``Torque``.
        """
        if isinstance(load, type) or not isinstance(load, Load):
            raise ModelError(f"load: {shown(load)} was given, expected a Spring, TorsionSpring, Force or Torque")
        check_own(self, "load", load.P)
        self._loads.append(load)

    def sensor(self, sensor: Sensor) -> str:
        """Add a sensor of :mod:`lcpflex.scene.sensors`; returns its name (sensor1, sensor2, ... if omitted).

        It measures where it is asked to by ``every`` [s] of its own, whatever is recorded beside: None with the record,
        0 at the end of each step, else as ``record=every`` would store instants; both sides of each event that is
        located. ``result.sensor(name)`` tells its values. The motion and the rest of the result stay as they are, to
        the bit.

        sensor: ``lf.sensors.Point``, ``Body``, ``Coordinates``, ``Energy``, ``Reaction``, ``Contact``, ``Section``,
        ``Stress`` or ``Function``.
        """
        check_placed_sensor(self, sensor)
        name = free_name("sensor", sensor.name or None, self._sensors)
        self._sensors[name] = sensor
        return name

    @renamed_keyword(slave="node_side")
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
    ) -> str:
        """Declare that two surfaces may touch; returns the name of the contact (contact1, contact2, ... if omitted).

        friction: Coulomb's mu >= 0; restitution: Newton's e_N in [0, 1]; tangential_restitution: e_T in [0, 1].

        ``node_side``, one of a and b, makes its points touch the segments and arcs of the other, and no more: one pass.
        By default a disc, node or solid arc is the node side; of two chains each is the node side of the other: two
        passes. They carry a uniform pressure exactly through any two meshes and let no node of either into the other,
        with about twice the unknowns; where nodes meet nodes, each force is shared by two pairs in a way that nothing
        determines. One pass lets nodes of the surface side in between those of the node side; the pressure is uneven
        where the meshes do not match: let the finer one be the node side (measured with 8 and 5 elements pressed
        together: the blocks are 0.04 % too short, with the coarser one as node side 1.3 %).

        A disc that strikes a mesh finer than the patch where they touch: let the mesh be the node side. Else the
        disc passes from segment to segment of the bent mesh, each time with a small jump of energy that no shorter step
        removes (measured with elements of a third of the patch's half width and massless boundary: 1 % of the energy is
        unexplained for a while, 0.002 % with the mesh as node side). On a mesh coarser than the patch, the disc would
        sink in between nodes: let it be the node side, as it is by default.

        ``law``: a continuous contact force, ``ContactLaw(...)`` or ``Penalty(...)``, beside the rigid contact of the
        others; it knows no restitution: a rebound follows from its damping. Steppers: ``EventDriven``, ``MoreauJean``,
        and ``Smooth``, whose own ``laws`` go before it.
        """
        declared = contact_between(
            self, self._between, a, b, friction, restitution, tangential_restitution, node_side, law
        )
        name = free_name("contact", name, self._contacts)
        self._contacts[name] = declared
        self._between[frozenset((a.label, b.label))] = name
        return name

    contact_slot = clearances.contact_slot
    revolute_with_clearance = clearances.revolute_with_clearance

    def contact_all(
        self,
        friction: float = 0.0,
        restitution: float = 0.0,
        tangential_restitution: float = 0.0,
        exclude: Sequence[tuple[Placed | PlacedSurface, Placed | PlacedSurface]] = (),
        *,
        law: Law | None = None,
    ) -> None:
        """Everything against everything: the outline of each body and all surfaces made on bodies and on the ground.

        Left out are pairs of bodies with a joint between them, pairs declared with :meth:`contact`, and the pairs in
        ``exclude``, of bodies (with all their surfaces), surfaces, or ``scene.ground``; and pairs of kinds between
        which there is no contact, such as two holes. Of these, those that may meet are told in ``warnings`` of the
        result, and a body that would fall through all that it meets is refused. Contacts are named after their
        surfaces, such as "box1.outline/ground.half_plane1". It holds for what is added later, too. Node sides follow
        from the kinds, two chains are node sides of each other: where a choice is wanted, declare the pair with
        :meth:`contact`.

        friction, restitution, tangential_restitution, law: as in :meth:`contact`, of all these contacts.
        """
        self._rules.append(rule_of(self, friction, restitution, tangential_restitution, exclude, law))

    def with_bodies(self, bodies: Mapping[str, Body]) -> Scene:
        """A new scene like this one with other bodies under the names of ``bodies``; this one is not changed.

        Points, surfaces, joints, loads, contacts and rules are made again on the new bodies: named ones by their names,
        all others at the same undeformed places. An initial deformation is carried over by projection, the part of it
        that the new body can only follow as rigid motion included. Functions of the user that hold points of this
        scene still mean points of this one.

        Raises
        ------
        ModelError
            For an unknown name, anything but a body, and what the new body does not have: a name, a place, the
            distribution of mass to project an initial deformation with.
        """
        return exchanged(self, bodies)

    def compile(self, project: bool = False, indents: Callable[[str], bool] | None = None) -> CompiledScene:
        """Check the scene as a whole and compile it; the scene is not changed.

        With ``project``, an initial state that violates joints is moved onto them, and bodies that penetrate each other
        are pushed apart, by the least motion in the mass metric (see :func:`lcpflex.simulate`); else both are errors.
        Contacts by a force law, and those that ``indents`` names, may penetrate.

        Warns
        -----
        ModelWarning
            Where a body with modes gives way too little at a joint, load or contact, and of what :meth:`contact_all`
            leaves out: see ``CompiledScene.warnings``.
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

        ``gives_way``: bodies that are reduced here give way by modes of their own at every contact.

        project, indents: as in :meth:`compile`; push: whether contacts that penetrate are pushed out, too;
        None: they may, as the scene begins elsewhere.
        """
        return compiling.compiled_scene(self, project, indents, gives_way, push=push)

    def reduced(self) -> Scene:
        """This scene with the bodies reduced that are reduced when it is compiled; itself where there are none."""
        return compiling.reduced_scene(self)[0]

    def parts(self) -> Parts:
        """What has been declared, in the order in which it was."""
        return Parts(
            tuple(self._placed.values()),
            dict(self._joints),
            tuple(self._loads),
            dict(self._contacts),
            tuple(self._rules),
            tuple(self._surfaces),
            dict(self._sensors),
        )

    def _holder(self, body: int) -> Placed:
        """The body with that index, the ground for -1."""
        return self.ground if body < 0 else self._by_index[body]


def _state(modes: int, **parts: Any) -> FloatArray:
    """(3 + n,) of a place, an angle and n modal coordinates, by the names of the arguments, or of their rates."""
    (at, place), (turned, angle), (bent, modal) = parts.items()
    frame = [*array_of(at, place, (2,)), in_range(turned, angle, -math.inf, math.inf)]
    return np.concatenate([frame, np.zeros(modes) if modal is None else array_of(bent, modal, (modes,))])
