"""What a simulation returns: the motion, the contacts, and the proof of its own accuracy."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from lcpflex.basics.attributes import NamesNearest
from lcpflex.basics.lazy import attach
from lcpflex.basics.renamed import GONE, renamed_property
from lcpflex.compile.coordinates import coordinate_names, velocity_names
from lcpflex.compile.material import body_index
from lcpflex.errors import ModelError
from lcpflex.force_laws.friction.creep import CREEP
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import OPEN, SLIP, STICK
from lcpflex.results import later
from lcpflex.results.contact_history import ContactHistory, ContactPoints, Event, StateArray
from lcpflex.results.contact_windows import INSTANTS, ContactWindow
from lcpflex.results.contacts_by_name import history_of
from lcpflex.results.energy_balance import Energies
from lcpflex.results.instant import Instant
from lcpflex.results.sensor import SensorHistory, named_sensor

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from scipy.spatial.transform import Rotation

    from lcpflex.basics.alarm import Alarm as Alarm
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.results.joint_reaction import JointReaction as JointReaction
    from lcpflex.results.measured_error import MeasuredError as MeasuredError
    from lcpflex.results.modal_coordinates import ModalCoordinates as ModalCoordinates
    from lcpflex.results.momentum import Momentum as Momentum
    from lcpflex.results.run_choice import RunChoice as RunChoice
    from lcpflex.results.section_forces import SectionForces as SectionForces
    from lcpflex.results.spatial.section_forces import SpatialSectionForces
    from lcpflex.results.spatial.solid_sections import SolidSectionForces
    from lcpflex.results.state_at import StateAt as StateAt
    from lcpflex.results.stress_history import Stress as Stress, StressHistory as StressHistory
    from lcpflex.results.verdict import Verdict as Verdict

__all__ = [
    "Alarm", "CREEP", "OPEN", "SLIP", "STICK", "ContactHistory", "ContactPoints", "ContactWindow", "Event",
    "Instant", "JointReaction", "MeasuredError", "ModalCoordinates", "Momentum", "Result", "RunChoice",
    "SectionForces", "SensorHistory", "StateAt", "Stress", "StressHistory", "Verdict",
]  # fmt: skip

__getattr__, __dir__ = attach(__name__)  # classes of what the methods return


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Result(NamesNearest):
    """A simulation at m stored instants, with nc declared contacts and ndof coordinates.

    ``q`` and ``u`` are laid out as in :mod:`lcpflex.model.arrays`: per body x, y, angle and its modal coordinates.

    Where contacts share a load in more than one way, the forces of an instant are the least that give the motion, of an
    event-driven run of as many redundant supports as carry it. Impulses are those that the solver found. In space both
    are (m, nc, 4): normal, and the vector of friction on the body of the first surface declared, world axes.

    ``gap`` is NaN where a contact was farther than the distance up to which gaps are measured, and so is any sum or
    minimum over it: take ``np.nanmin``, or ``result.contact(name).least_gap``. A NaN says "far", never "lost".

    A contact whose friction is a law without states of its own (all but LuGre and Bristle) never sticks: below the slip
    speed of its law it is in the state CREEP, and ``crept`` says how far it went in it.
    """

    _known_as: ClassVar = GONE

    times: FloatArray  # (m,) [s]
    q: FloatArray  # (m, ndof) [m], [rad], [kg^1/2 m]
    u: FloatArray  # (m, ndof) their rates
    force: FloatArray  # (m, nc, 2) normal and tangential force of each contact at that instant [N]; in space see below
    impulse: FloatArray  # (m, nc, 2) accumulated since the start, impacts included [N s]
    state: StateArray  # (m, nc) OPEN, STICK, SLIP or CREEP
    gap: FloatArray  # (m, nc) smallest gap [m]; NaN where farther than the detection margin, see below
    contact_points: ContactPoints  # every touching point at every stored instant
    energies: Energies  # (m,) each [J]
    residual: FloatArray  # (m,) largest natural-map residual of the contact problems since the previous instant
    penetration: FloatArray  # (m,) largest penetration since the previous instant [m], see ``all_compliant``
    joint_drift: FloatArray  # (m,) largest violation of a joint since the previous instant [m] or [rad]
    size: IntArray  # (m,) unknowns of the largest contact problem since the previous instant
    events: tuple[Event, ...]  # in order of time; none of steppers that locate none
    warnings: tuple[str, ...]  # reasons to doubt, a sentence each
    complete: bool  # whether it ran to its end
    message: str  # why it ended where it ended
    steps: int  # made in all
    wall_time: float  # [s], without compile_time
    compile_time: float  # [s] spent on compiling kernels or loading them from the cache
    stepper: str  # its ``repr``
    duration: float  # [s] asked for
    compiled: CompiledScene | None = None  # what the scene was compiled to; None for a system of the user's own
    contact_names: tuple[str, ...] = ()  # taken from ``compiled`` where there is one
    compliant: tuple[str, ...] = ()  # those of them whose force is a continuous law of the indentation
    coarse: tuple[str, ...] = ()  # those of them whose touches take too few steps for their law
    notes: tuple[str, ...] = ()  # how the stepper fared, where that is no reason to doubt
    python_calls: int = 0  # of Python functions of time, which keep the loop from being compiled
    python_time: float = 0.0  # [s] of wall_time spent in them
    crept: tuple[float, ...] = ()  # path of slip of each contact while creeping [m]; empty if none of them can
    impact_step: float = 0.0  # [s] of steps that place impacts at their ends, the shortest; 0: none do
    strict: FloatArray | None = None  # (m,) the residual relative to the free velocity alone; None: not known
    # of each joint, see ``reaction``; None in results of older versions
    joint_force: FloatArray | None = None  # (m, nj, 3) F_x, F_y [N], M [N m]; in space 6: F, M
    joint_peak: FloatArray | None = None  # (m, nj, 2) largest |F| [N] and |M| [N m] since the previous instant
    joint_impulse: FloatArray | None = None  # (m, nj, 3) of impacts since the start [N s], [N m s]; in space 6
    joint_unique: IntArray | None = None  # (m, nj) 1 where the motion determines the reaction
    stored: str = INSTANTS  # "steps" where record=0 asked for all of them, "dense": with the middle of each
    outside: FloatArray | None = None  # (m, slots, 3) what functions of the user gave; of a file, see ``save``
    found_wrong: tuple[str, ...] = ()  # alarms: what the run itself saw go wrong, so that it is not to be trusted
    sensors: tuple[SensorHistory, ...] = ()  # what the sensors of the scene have measured, see ``sensor``
    step_tolerance: float = 0.0  # [m] by which error control lets a step of time stepping misplace a body; 0: no such
    error: MeasuredError | None = None  # measured by reruns, see ``verify``; None: not measured
    choice: RunChoice | None = None  # of a run to a tolerance: what was tried, and why it is this run; None else
    origin: Any = field(default=None, repr=False)  # what it can be run again by; None: of a file

    def __post_init__(self) -> None:
        if self.compiled is not None and not self.contact_names:
            object.__setattr__(self, "contact_names", tuple(self.compiled.layout.contacts))
        m, nc = len(self.times), len(self.contact_names)
        expected = {
            "q": (m, *self.q.shape[1:2]),
            "u": (m, *self.u.shape[1:2]),
            **dict.fromkeys(("force", "impulse"), (m, nc, 4 if self.force.shape[-1] == 4 else 2)),  # space: vectors
            **dict.fromkeys(("state", "gap"), (m, nc)),
            **dict.fromkeys(("residual", "penetration", "joint_drift", "size"), (m,)),
        }
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise ModelError(f"{name}: shape {getattr(self, name).shape}; expected {shape}")
        if self.energies.kinetic.shape != (m,):
            raise ModelError(f"energies: shape {self.energies.kinetic.shape}; expected {(m,)}")

    spots = renamed_property("spots", "contact_points")
    by_law = renamed_property("by_law", "compliant")
    all_by_law = renamed_property("all_by_law", "all_compliant")

    @property
    def all_compliant(self) -> bool:
        """Whether every contact is a continuous force: ``penetration`` is then the indentation that its law asks for.

        Else it is that of the rigid contacts alone, which should have none.
        """
        return bool(self.contact_names) and set(self.contact_names) <= set(self.compliant)

    def contact(self, name: str) -> ContactHistory:
        """Forces, impulses, states and gap of one declared contact. Raises ModelError for an unknown name.

        A pair that a rule is for and that never touched has a name as well, and histories of no force.
        """
        return history_of(self, name)

    def reaction(self, joint: str, axes: str = "world") -> JointReaction:
        """Force and moment of a joint or drive over the stored instants: see :class:`JointReaction`.

        joint: its name. axes: "world", "body" (the frame of the body that the reaction acts on, that of the first point
        of the joint) or the name of any body, in whose frame it is given. Raises ModelError for names that are not
        there, and where reactions were not recorded.
        """
        return later.joint_reaction(self, joint, axes)

    def sensor(self, name: str) -> SensorHistory:
        """What a sensor of the scene has measured, at its own rate. Raises ModelError for an unknown name."""
        return named_sensor(self.sensors, name)

    def angle(self, body: str, relative_to: str | None = None) -> FloatArray:
        """Angle of the frame of a body, counter-clockwise, (m,) [rad]; without jumps: whole turns count.

        body: its name. relative_to: that of another body, the angle of which is subtracted; of the ground if omitted.
        Raises ModelError for a body that is not there, and for a system of the user's own.
        """
        return later.body_angle(self, body, relative_to)

    def orientation(self, body: str) -> Rotation:
        """How the frame of a body of a spatial scene is turned, m rotations from body axes to world axes.

        body: its name. Raises ModelError for a body that is not there, and for planar results, which have ``angle``.
        """
        return later.body_orientation(self, body)

    def angular_velocity(self, body: str, axes: str = "world") -> FloatArray:
        """Angular velocity of the frame of a body of a spatial scene, (m, 3) [rad/s].

        body: its name. axes: "world" or "body". Raises ModelError as :meth:`orientation` does.
        """
        return later.body_spin(self, body, axes)

    def momentum(self, body: str | None = None) -> Momentum:
        """Linear momentum, angular momentum about the origin of the world, and mass centre: see :class:`Momentum`.

        body: its name; None for all bodies together. Raises ModelError for a body that is not there, and for a system
        of the user's own.
        """
        return later.momentum_of(self, body)

    def section(
        self, body: str, x: npt.ArrayLike | None = None, *, normal: npt.ArrayLike | None = None
    ) -> SectionForces | SpatialSectionForces | SolidSectionForces:
        """Section forces of a beam, bar or solid over the stored instants: see :class:`SectionForces`.

        Of a spatial beam :class:`lcpflex.results.spatial.section_forces.SpatialSectionForces`, of a reduced solid force
        and moment over a plane, :class:`lcpflex.results.spatial.solid_sections.SolidSectionForces`.

        body: its name. x: place of the section along the undeformed axis [m], or several, of a spatial beam from
        -length / 2 to length / 2; None for all nodes. Of a solid the plane is normal . r = x, in the frame of the body:
        through a point P with x = normal . P. normal: of a solid, its direction, from the part before to the part
        beyond; (1, 0, 0) if omitted. Raises ModelError for another body, a place off the axis, a plane beside the
        solid, and a loaded result of a scene with Python functions of time.
        """
        return later.sections(self, body, x, normal)

    def at(self, t: float, before: bool = False) -> StateAt:
        """State q, u, contact and joint forces at any time t [s] of the run: see :class:`StateAt`.

        t: from the first to the last of ``times``. before: at an instant that is stored twice, as ``EventDriven`` does
        with those of impacts, the state before it instead of that behind it.

        A motion without a jump is interpolated by places and velocities; a jump in a step of a time-stepping scheme is
        moved by its parts (:mod:`.state_at`). ``record="dense"`` keeps all that this needs. Raises ModelError for other
        times, and where what was stored does not tell the state.
        """
        return later.state_at(self, t, before)

    def stress(self, body: str, *, static: bool = True) -> StressHistory:
        """Stresses of a flexible body over the stored instants, computed when asked for: see :class:`StressHistory`.

        body: its name; a meshed one with modes, in the plane or in space, or a planar beam or bar. static: with the
        static part of what its modes leave out; False for its modes alone. Raises ModelError for a body without
        elements or modes, and as :meth:`section` does.
        """
        return later.stress_history(self, body, static)

    def point(self, body: str, point: str | tuple[float, ...]) -> FloatArray:
        """Trajectory r_P = R + A (x + Phi q) of a material point, (m, 2) or, in space, (m, 3) [m], world axes.

        ``point`` is the name of a point or its undeformed place (x, y) or (x, y, z) [m] in the frame of the body:
        anywhere on a rigid body and in a beam or bar, on the outline or at a named point of another flexible one.
        On an outline it is on the straight lines that touch. Raises ModelError where there is none.
        """
        return later.place_of(self.compiled, self.q, body, point)

    def velocity(self, body: str, point: str | tuple[float, ...]) -> FloatArray:
        """Velocity Rdot + A (Phi qdot + omega J s) of a point, (m, 2) [m/s]; in space v + A (Phi etadot + omega x s).

        body: its name. point: as in :meth:`point`. (m, 3) in space, world axes.
        """
        return later.velocity_of(self.compiled, self.q, self.u, body, point)

    def deflection(self, body: str, point: str | tuple[float, ...]) -> FloatArray:
        """Displacement Phi q, (m, 2) or (m, 3) [m], body axes. body: its name. point: as in :meth:`point`."""
        return later.deflection_of(self.compiled, self.q, body, point)

    def verify(
        self, scene: Any = None, stepper: Any = None, *, other: bool = True, progress: bool | None = None
    ) -> MeasuredError:
        """Measure the error of this run by running it again, finer and by another method; kept as ``error``.

        With fixed steps of length h, E(t) = 2 max(|x_h - x_h/4|, |x_h - x_other|): nested steps take an impact at the
        same late instant, another method does not. That is an event-driven run where it ends within the work of the
        steps checked, else the other time stepping with h/4, or the same with h/2. Time steps with error control are
        compared with a sixteenth of their tolerance and likewise another method, or a quarter; event-driven runs, and
        ``Smooth`` ones with a tolerance, with a hundredth of it, 1.25 times. Where bodies are reduced, one more run has
        twice as many modes. All that takes about six times the work of the run, and calls functions of the user again.

        scene, stepper: of a loaded result, whose file keeps no functions and no stepper: those that it was run with.
        other: False takes h/2 in the place of another method, which may need kernels that are not compiled yet: such an
        error is below the truth in one run of ten with long steps, else in one of twenty-five. progress: as of
        :func:`lcpflex.simulate`. Raises ModelError for a scene or a stepper that is missing or another one, and where a
        function of the user answers otherwise than in the run.
        """
        return later.verify(self, scene, stepper, progress, other)

    def summary(self) -> str:
        """The simulation in words: what ran, what touched, where the energy went, how far to trust it."""
        return later.summary(self)

    @property
    def verdict(self) -> Verdict:
        """How far to trust it: a word, a level, reasons and numbers for programs, and a sentence; see `Verdict`."""
        return later.verdict_of(self)

    def plot(self) -> Figure:
        """Chart of contact forces, gaps and energies over time."""
        return later.plot(self)

    def draw(
        self,
        t: float,
        axes: Axes | None = None,
        *,
        view: Any = None,
        frames: bool = False,
        scale: float = 1.0,
        pressure: bool = False,
    ) -> Figure:
        """Picture of the scene at the stored instant nearest to ``t`` [s]: deformed shapes and contact forces.

        axes: of matplotlib, to draw into; a new figure if omitted. Of spatial scenes: view: (elevation, azimuth) of the
        camera [deg]; frames: with axes of bodies; scale: of deformations; pressure: in colours, in the place of the
        forces on areas. See :func:`lcpflex.results.plot.draw`.
        """
        return later.draw(self, t, axes, view, frames, scale, pressure)

    def animate(
        self,
        path: str | os.PathLike[str],
        fps: float = 25.0,
        slowdown: float | None = None,
        *,
        view: Any = None,
        frames: bool = False,
        scale: float = 1.0,
        pressure: bool = False,
    ) -> Path:
        """Film of the scene as GIF or, where ffmpeg is installed, MP4. See :func:`lcpflex.results.film.animate`.

        path: ends in .gif or .mp4. fps: frames a second of the film. slowdown: seconds of the film a second of
        the motion; chosen for a film of six seconds if omitted. view, frames, scale, pressure: as of :meth:`draw`.
        """
        return later.animate(self, path, fps, slowdown, view, frames, scale, pressure)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write everything to one file (format: :mod:`lcpflex.results.archive`), all of it or nothing.

        path: ends in .h5 or .hdf5 for HDF5, which needs h5py; any other file is an npz. Python callbacks and force
        laws of the scene are left out: a loaded result can be drawn and measured, not continued. Functions of time are
        asked once more at the stored instants, for stresses. Raises ModelError with the path and the reason.
        """
        return later.write(later.without_functions(self), path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Result:
        """Read a saved result, npz or HDF5 by its content. Raises ModelError with the path and the reason."""
        loaded = later.read(path)
        if not isinstance(loaded, cls):
            raise ModelError(f"path: {os.fspath(path)!r} holds a {type(loaded).__name__}; expected a Result")
        return loaded

    def to_dataframe(self) -> Any:
        """A pandas DataFrame, one row per stored instant, indexed by time [s].

        Columns: ``body.x``, ``body.y``, ``body.angle``, ``body.mode 1`` and so on, their rates with a trailing ``'``;
        ``contact.normal force``, ``contact.tangential force``, the same for ``impulse``, ``contact.state``,
        ``contact.gap``; ``joint.force x``, ``joint.force y``, ``joint.moment``; ``energy.kinetic`` and so on. In space
        those of :meth:`coordinate_names` and :meth:`velocity_names`, moments x, y, z and ``contact.friction x force``.
        Units are in ``attrs["units"]`` by column, with facts of the run beside them. Instants of events stand in it
        twice, before and after. Raises ModelError where pandas is not installed.
        """
        return later.to_dataframe(self)

    def to_xarray(self) -> Any:
        """An xarray.Dataset with the dimensions time, coordinate, contact, joint, touch, event, component and axis.

        ``q`` and ``u`` (time, coordinate), in space ``u`` (time, velocity); ``force`` and ``impulse`` (time, contact,
        component), ``state``, ``gap`` (time, contact); ``joint_force`` (time, joint, axis), ``joint_moment`` (time,
        joint), in space (time, joint, axis), and more of joints; ``energy_kinetic`` and so on (time); ``touch_place``
        (touch, axis) and more of all touching points, of the instant ``touch_time_index`` and the contact
        ``touch_contact_index``; ``event_time`` and more (event); ``sensor_NAME`` (sensor_NAME_time,
        sensor_NAME_column) of each sensor, with / in its name as _.

        Units are in the attributes of each variable, those of q and u in ``q_units`` and ``u_units``; the
        stepper, warnings and other facts of the run are attributes of the whole. Instants of events stand twice in
        time, before and after. Of contacts, joints, touches and events there are variables where there are any.
        ``to_netcdf`` writes all of it (engines h5netcdf, scipy). Raises ModelError where xarray is not installed.
        """
        return later.to_xarray(self)

    def to_vtkhdf(self, path: str | os.PathLike[str], *, stress: bool = True, every: int = 1) -> Path:
        """Write the motion for ParaView: a VTKHDF file, see :mod:`lcpflex.results.paraview`. Needs h5py.

        path: ends in .vtkhdf. stress: with that of meshes, beams and bars, computed as :meth:`stress` does. every: each
        so many-th stored instant. The second of two equal times, as of an event, is the next larger number. Raises
        ModelError for a system of the user's own, for more than 4 GiB, and with the path and the reason.
        """
        return later.to_vtkhdf(self, path, stress, every)

    def coordinate_names(self) -> tuple[str, ...]:
        """Name of each entry of q: ``body.x``, ``body.y``, ``body.angle``, ``body.mode 1``, ..., or ``q 1``, ..."""
        if self.compiled is None:
            return tuple(f"q {k + 1}" for k in range(self.q.shape[1]))
        return coordinate_names(self.compiled.model.bodies, self.compiled.layout)

    def velocity_names(self) -> tuple[str, ...]:
        """Name of each entry of u: in the plane those of q; in space ``body.v_x``, ..., ``body.omega_z``, modes."""
        if self.compiled is None:
            return tuple(f"q {k + 1}" for k in range(self.u.shape[1]))
        return velocity_names(self.compiled.model.bodies, self.compiled.layout)

    def modes_of(self, body: str) -> ModalCoordinates:
        """What the modal coordinates of a body are: their columns in ``q``, free or residual, and their frequencies.

        Raises ModelError for a body that is not there, and for a system of the user's own.
        """
        if self.compiled is None:
            raise ModelError("modes_of: a system of the user's own has no modes; expected the result of a Scene")
        return later.modal_coordinates(self.compiled, body_index(self.compiled, body))
