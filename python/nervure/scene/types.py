"""The parts of a scene. Made from modelDescription/scene.schema.json by `make schema`: do not edit."""

from typing import Literal

from pydantic import Field

from nervure.scene.part import Flag, Integer, Part, Real


class Display(Part):
    """What pictures call a length and a time of 1 in a scene whose numbers are multiples of its own scales."""

    length: str
    """A length of 1, e.g. `chords`."""

    time: str
    """A time of 1, e.g. `periods`."""


class Time(Part):
    """Clock of the co-simulation."""

    end: Real
    """End of the run, s."""

    communication_step: Real
    """Communication step of the master, s. Each unit takes as many equal steps of its own inside as it needs."""


class FluidBox(Part):
    """The periodic box and its grid."""

    x: tuple[Real, Real]
    """From where to where along x, m."""

    y: tuple[Real, Real]
    """From where to where along y, m."""

    cells: tuple[Integer, Integer]
    """Number of grid points along x and y; at least 8 each, together at most 67108864, fast for products of small
    primes."""


class Channel(Part):
    """Solid walls above and below."""

    y: tuple[Real, Real]
    """Lower and upper wall, m; the fluid is between them."""


InflowProfile = Literal["uniform", "parabolic"]
"""Shape of an inflow, of mean 1. `uniform`: The same velocity at every y. `parabolic`: Poiseuille's parabola between
the walls of the channel."""


class TimeLawConstant(Part):
    """The same value at all times."""

    constant: Real
    """The same value at all times."""


class CosineRamp(Part):
    """`value · (1 − cos(π t / duration)) / 2` up to `duration`, then `value`."""

    value: Real
    """Value after the ramp."""

    duration: Real
    """Length of the ramp, s."""


class TimeLawCosineRamp(Part):
    """`value · (1 − cos(π t / duration)) / 2` up to `duration`, then `value`."""

    cosine_ramp: CosineRamp
    """`value · (1 − cos(π t / duration)) / 2` up to `duration`, then `value`."""


class Sine(Part):
    """`mean + amplitude · g(t) · sin(2 π frequency t + phase)`; g is 1, or grows like a cosine ramp from 0 at t = 0."""

    mean: Real = 0.0
    """Mean value."""

    amplitude: Real
    """Amplitude."""

    frequency: Real
    """Frequency, Hz."""

    phase: Real = 0.0
    """Phase at t = 0, rad."""

    ramp: Real = 0.0
    """Length of the growth of g, s; 0: none."""


class TimeLawSine(Part):
    """`mean + amplitude · g(t) · sin(2 π frequency t + phase)`; g is 1, or grows like a cosine ramp from 0 at t = 0."""

    sine: Sine
    """`mean + amplitude · g(t) · sin(2 π frequency t + phase)`; g is 1, or grows like a cosine ramp from 0 at t = 0."""


class Table(Part):
    """Cubic Hermite interpolation (slopes by central differences) between points; constant before and after."""

    times: list[Real]
    """Times of the points, s, increasing; at least two."""

    values: list[Real]
    """Values at the points."""


class TimeLawTable(Part):
    """Cubic Hermite interpolation (slopes by central differences) between points; constant before and after."""

    table: Table
    """Cubic Hermite interpolation (slopes by central differences) between points; constant before and after."""


TimeLaw = TimeLawConstant | TimeLawCosineRamp | TimeLawSine | TimeLawTable
"""A quantity as a function of time; its unit is that of the key it stands at."""


class Inflow(Part):
    """Zone across the box in which the velocity is imposed: `(profile(y) · law(t), 0)`."""

    x: tuple[Real, Real]
    """From where to where along x, m."""

    profile: InflowProfile
    """Shape of the velocity across the zone; the law gives its size."""

    mean_velocity: TimeLaw
    """Mean velocity of the profile over time, m/s."""

    c_eta: Real
    """Relaxation time of the zone, s."""


class Sponge(Part):
    """Zone across the box in which the flow is drawn to `(profile(y) · law(t), 0)` at the rate `sin²(π (x − x_0)/(x_1 −
    x_0)) / c_eta`, which takes out what comes in and reflects little of it."""

    x: tuple[Real, Real]
    """From where to where along x, m."""

    profile: InflowProfile = "uniform"
    """Shape of the velocity across the zone; the law gives its size."""

    mean_velocity: TimeLaw
    """Mean velocity of the profile over time, m/s."""

    c_eta: Real
    """Relaxation time in the middle of the zone, s."""


class MeanFlow(Part):
    """Mean velocity over the whole box, solids included (thesis' U_inf), m/s."""

    x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Along x, m/s."""

    y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Along y, m/s."""


class Motion(Part):
    """Prescribed displacement of a cylinder, m."""

    x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along x, m."""

    y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along y, m."""


class Cylinder(Part):
    """A circular cylinder."""

    center: tuple[Real, Real]
    """Centre, m; where it moves, the point that its motion is added to."""

    radius: Real
    """Radius, m."""

    motion: Motion | None = None
    """Prescribed motion; absent for a still cylinder."""


class Circle(Part):
    """A circle."""

    radius: Real
    """Radius, m."""


class ShapeCircle(Part):
    """A circle."""

    circle: Circle
    """A circle."""


class Ellipse(Part):
    """An ellipse."""

    length: Real
    """Length of its axis along its own x, m."""

    thickness: Real
    """Length of its axis along its own y, m."""


class ShapeEllipse(Part):
    """An ellipse."""

    ellipse: Ellipse
    """An ellipse."""


Ends = Literal["square", "round"]
"""Ends of a rectangle. `square`: Flat. `round`: Half circles of the thickness."""


class Rectangle(Part):
    """A rectangle."""

    length: Real
    """Length along its own x, m, with the ends."""

    thickness: Real
    """Thickness along its own y, m."""

    ends: Ends = "square"
    """What its ends along its own x are."""


class ShapeRectangle(Part):
    """A rectangle."""

    rectangle: Rectangle
    """A rectangle."""


class Polygon(Part):
    """A polygon."""

    corners: list[tuple[Real, Real]]
    """Its corners in their order, either way round, m; at least 3, at most 1000. Its sides must not cross."""


class ShapePolygon(Part):
    """A polygon."""

    polygon: Polygon
    """A polygon."""


Shape = ShapeCircle | ShapeEllipse | ShapeRectangle | ShapePolygon
"""Outline of a body. The origin of its axes is the middle of it, but for a polygon."""


class BodyMotion(Part):
    """Prescribed motion of a body."""

    x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement of its pivot along x, m."""

    y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement of its pivot along y, m."""

    angle: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Angle about its pivot, rad, positive to the left."""


class Body(Part):
    """A rigid body."""

    shape: Shape
    """Its outline, in axes of its own."""

    position: tuple[Real, Real]
    """Where its pivot is, m; where it moves, the point that its motion is added to."""

    pivot: tuple[Real, Real] = (0.0, 0.0)
    """The point in its own axes, m, about which it turns and its moment is taken; by default their origin."""

    angle: Real = 0.0
    """Angle from the x axis of the box to its own, rad, positive to the left; its motion is added."""

    motion: BodyMotion | None = None
    """Prescribed motion; absent for a still body."""


class Sharp(Part):
    """chi = 1 inside, 0 outside (thesis ch. 3); the wall is moved by √(ν C_eta) so that no-slip holds where it
    should."""

    c_eta: Real
    """Relaxation time C_eta, s."""

    displacement_corrected: Flag = True
    """Whether the wall is moved; if not, the mask is that of the thesis."""


class MaskSharp(Part):
    """chi = 1 inside, 0 outside (thesis ch. 3); the wall is moved by √(ν C_eta) so that no-slip holds where it
    should."""

    sharp: Sharp
    """chi = 1 inside, 0 outside (thesis ch. 3); the wall is moved by √(ν C_eta) so that no-slip holds where it
    should."""


class Cosine(Part):
    """Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds where it should (Hester, Vasil &
    Burns 2021)."""

    c_eta: Real
    """Relaxation time C_eta, s."""

    half_width: Real
    """Half the width of the layer in grid cells."""

    displacement_corrected: Flag = True
    """Whether the layer is shifted; if not, the mask is that of the thesis."""


class MaskCosine(Part):
    """Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds where it should (Hester, Vasil &
    Burns 2021)."""

    cosine: Cosine
    """Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds where it should (Hester, Vasil &
    Burns 2021)."""


WallCorrection = Literal["none", "shear", "curvature"]
"""What a body draws the fluid at its surface to, and thereby which flows along a wall are right to the order of a cell.
`none`: The body's own velocity: no-slip is where it should be in linear shear, but the smooth profile lets a flux
through. `shear`: Inside, weakly, the mirror image of the flow outside: no flux beyond that of linear shear either.
`curvature`: Besides, at the surface, what the second difference of the flow outside asks for: no slip where a pressure
gradient bends the velocity profile either."""


class LogLinear(Part):
    """Drag rate that grows exponentially with depth, so that no-slip holds at the surface whatever the grid's
    position."""

    c_eta: Real
    """Smallest relaxation time, s, reached inside the solid."""

    decay_length_cells: Real = 0.25
    """Length of e-fold growth in grid cells. A quarter is the shortest that the grid resolves: the wall keeps its place
    to 0.03 cells wherever the grid lies."""

    core_depth: Real | None = None
    """Depth at which the core of a cylinder or another still body begins, in grid cells: from there on the drag grows
    three times as fast, up to 1/C_eta. Above a deep core it stays where the grid resolves it. Absent: one and a half
    e-folds, three without a wall target. With 2 the forces depend much less on C_eta, but a body of less than 25 cells
    across is porous. A depth beyond a fifth of a body's thickness counts as that; in a thinner body the core begins
    earlier still. A beam or a body that moves has no core but where it is thinner than some four cells."""

    wall_correction: WallCorrection = "curvature"
    """What the cylinders and the beam draw the fluid at their surface to."""


class MaskLogLinear(Part):
    """Drag rate that grows exponentially with depth, so that no-slip holds at the surface whatever the grid's
    position."""

    log_linear: LogLinear
    """Drag rate that grows exponentially with depth, so that no-slip holds at the surface whatever the grid's
    position."""


Mask = MaskSharp | MaskCosine | MaskLogLinear
"""How a solid holds the fluid: the drag rate as a function of the signed distance to its surface."""


Filter = Literal["smooth", "two_thirds", "none"]
"""What removes aliasing errors. `smooth`: exp(−36 (k/k_max)³⁶) (Hou & Li 2007). `two_thirds`: Truncation outside the
ellipse of two thirds (thesis eq. 3.14). `none`: None."""


TimeScheme = Literal["sbdf2", "rk2"]
"""How the fluid makes a step. `sbdf2`: Two-step backward differences, drag and viscosity implicit: the step is limited
by advection alone. `rk2`: Heun's method, drag explicit, viscosity exact (thesis eq. 3.15 – 3.18): steps above C_eta are
divided."""


class TimeStepping(Part):
    """The fluid's own step inside a communication step."""

    max_step: Real
    """Largest step, s."""

    max_cfl: Real
    """Largest CFL number max(|u|/dx + |v|/dy) dt; smaller steps are taken where it would be exceeded. At most 0.4 with
    sbdf2 and 0.6 with rk2: above, advection is unstable."""

    scheme: TimeScheme = "sbdf2"
    """How a step is made."""


class Probe(Part):
    """A point whose velocity and pressure are outputs."""

    name: str
    """Its name: a letter, then letters, digits and `_`."""

    position: tuple[Real, Real]
    """Where it is, m."""


Precision = Literal["double", "single"]
"""Precision of the fields and transforms. Bodies, forces and loads are in double precision in both. `double`: 16
digits. `single`: 7 digits, at half of the memory. Not where small differences matter: a lift of 1e-5 of the drag, or
orders of convergence."""


class Fluid(Part):
    """A two-dimensional incompressible fluid in a periodic box."""

    density: Real
    """Density, kg/m³."""

    kinematic_viscosity: Real
    """Kinematic viscosity, m²/s."""

    box: FluidBox
    """The periodic box and its grid."""

    initial_velocity: tuple[Real, Real] = (0.0, 0.0)
    """Velocity of the fluid at rest everywhere at t = 0, m/s."""

    channel: Channel | None = None
    """Solid walls above and below; absent in an open (periodic) scene."""

    inflow: Inflow | None = None
    """Zone across the box in which the velocity is imposed; absent where nothing drives the flow."""

    sponge: Sponge | None = None
    """Zone across the box in which the flow is drawn softly to a velocity; absent where nothing has to be damped."""

    mean_flow: MeanFlow | None = None
    """Mean velocity that is held over the whole box; absent where it is free. Not together with an inflow."""

    cylinders: list[Cylinder] = Field(default_factory=list)
    """Circular cylinders, still or in prescribed motion."""

    bodies: list[Body] = Field(default_factory=list)
    """Rigid bodies of any shape, still or in prescribed motion."""

    mask: Mask
    """How solids are smeared over the grid and how hard they hold the fluid."""

    filter: Filter = "smooth"
    """What removes aliasing errors."""

    time_stepping: TimeStepping
    """The fluid's own step inside a communication step."""

    probes: list[Probe] = Field(default_factory=list)
    """Points whose velocity and pressure are outputs."""

    precision: Precision = "double"
    """Precision of the fields and transforms."""

    threads: Integer = 1
    """Threads that share the work of a step, as far as the grid is large enough for so many to gain time; results do
    not depend on it."""


class OnCylinder(Part):
    """On the surface of a cylinder, pointing outwards."""

    cylinder: Integer
    """Which of the fluid's cylinders, from 0."""

    angle: Real = 0.0
    """Angle of the outward direction from the x axis, rad."""


class RootOnCylinder(Part):
    """On the surface of a cylinder, pointing outwards."""

    on_cylinder: OnCylinder
    """On the surface of a cylinder, pointing outwards."""


class At(Part):
    """At a point, in two or three dimensions."""

    position: list[Real]
    """Position, m: 2 or 3 components."""

    direction: list[Real]
    """Direction of the beam at the root; any length but 0."""


class RootAt(Part):
    """At a point, in two or three dimensions."""

    at: At
    """At a point, in two or three dimensions."""


Root = RootOnCylinder | RootAt
"""Where a beam is clamped."""


class Taper(Part):
    """`((1 − s) root^(1/power) + s tip^(1/power))^power`: linear, or a power of something linear, as the bending
    stiffness of a plate of linear thickness with 3."""

    root: Real
    """Value at the root."""

    tip: Real
    """Value at the tip."""

    power: Real = 1.0
    """The power."""


class SpanwiseProfileTaper(Part):
    """`((1 − s) root^(1/power) + s tip^(1/power))^power`: linear, or a power of something linear, as the bending
    stiffness of a plate of linear thickness with 3."""

    taper: Taper
    """`((1 − s) root^(1/power) + s tip^(1/power))^power`: linear, or a power of something linear, as the bending
    stiffness of a plate of linear thickness with 3."""


class Points(Part):
    """Straight lines between points."""

    s: list[Real]
    """Places of the points, increasing from 0, the root, to 1, the tip."""

    values: list[Real]
    """Values there, above 0."""


class SpanwiseProfilePoints(Part):
    """Straight lines between points."""

    points: Points
    """Straight lines between points."""


SpanwiseProfile = SpanwiseProfileTaper | SpanwiseProfilePoints
"""A quantity as a function of the place s along the beam, 0 at the root and 1 at the tip; its unit is that of the key
it stands at."""


class Beam(Part):
    """A beam with a flat tip; its stations are the rod's nodes."""

    root: Root
    """Where the beam is clamped."""

    length: Real
    """Length from root to tip, m."""

    thickness: Real | SpanwiseProfile
    """Thickness, m: a number, or a law of the place along the beam."""

    segments: Integer
    """Number of segments, 2 to 65536; there are `segments + 1` stations, the first at the root."""

    rest_angles: list[Real] = Field(default_factory=list)
    """Direction of each segment at rest against that at the root, rad, positive to the left: `[segments]`; absent for a
    straight beam. In two dimensions only: a curved rod in space needs a material frame and its twist."""


class PlaneStrain(Part):
    """A plate of the beam's thickness in plane strain, one metre deep: at every place EI = E h³ / (12 (1 − ν²)), EA = E
    h / (1 − ν²)."""

    density: Real
    """Density, kg/m³."""

    youngs_modulus: Real
    """Young's modulus E, Pa."""

    poisson_ratio: Real
    """Poisson's ratio ν."""

    shear_factor: Real | None = None
    """Shear correction factor k of GA_s = k E h / (2 (1 + ν)), above 0 and at most 1; 10/(12 − ν) for a plate (Cowper
    1966). Absent: the section stays at right angles to the rod."""


class MaterialPlaneStrain(Part):
    """A plate of the beam's thickness in plane strain, one metre deep: at every place EI = E h³ / (12 (1 − ν²)), EA = E
    h / (1 − ν²)."""

    plane_strain: PlaneStrain
    """A plate of the beam's thickness in plane strain, one metre deep: at every place EI = E h³ / (12 (1 − ν²)), EA = E
    h / (1 − ν²)."""


class Section(Part):
    """Mass and stiffness of the section (per metre of depth in a two-dimensional scene), each a number or a law of the
    place along the beam."""

    line_density: Real | SpanwiseProfile
    """Mass per length, kg/m."""

    bending_stiffness: Real | SpanwiseProfile
    """Bending stiffness EI, N m²."""

    axial_stiffness: Real | SpanwiseProfile
    """Axial stiffness EA, N."""

    shear_stiffness: Real | SpanwiseProfile | None = None
    """Shear stiffness GA_s, N, of a rod in the plane with invariant bending; absent: the section stays at right angles
    to the rod."""


class MaterialSection(Part):
    """The section's own numbers (per metre of depth in a two-dimensional scene)."""

    section: Section
    """The section's own numbers (per metre of depth in a two-dimensional scene)."""


Material = MaterialPlaneStrain | MaterialSection
"""What the rod is made of."""


Bending = Literal["invariant", "projected"]
"""What bending energy depends on. `invariant`: The true turning angle ψ between neighbouring segments, by 2 tan(ψ/2)
(Bergou et al. 2008): the same in every frame. `projected`: Angles of the segments' projections into the planes xy and
xz (thesis eqs. 2.1 and 2.4): depends on the frame and is singular where a projection vanishes, which is an error."""


class Thesis(Part):
    """That of the thesis, section 2.4.1: the same k_e for every segment whatever its length, clamp spring EI/l0, a
    whole segment's mass at every node. Of first order."""

    k_e: Real
    """Axial stiffness of a segment, N/m; takes the place of EA."""


class CalibrationThesis(Part):
    """That of the thesis, section 2.4.1: the same k_e for every segment whatever its length, clamp spring EI/l0, a
    whole segment's mass at every node. Of first order."""

    thesis: Thesis
    """That of the thesis, section 2.4.1: the same k_e for every segment whatever its length, clamp spring EI/l0, a
    whole segment's mass at every node. Of first order."""


Calibration = Literal["second_order"] | CalibrationThesis
"""How the section's numbers become springs and masses. `second_order`: k_e = EA/l0, clamp spring EI/(l0/2), half a
segment's mass at the tip: of second order in the segments' length l0."""


class TorsionSpring(Part):
    """It does not move by itself, and turns against a torsion spring with the moment `stiffness (angle − rest_angle) +
    damping rate`, the angle being that from the direction of the beam, between −π and π."""

    stiffness: Real
    """Stiffness of the spring, N m/rad."""

    damping: Real = 0.0
    """Damping, N m s/rad; in the plane only."""

    rest_angle: Real = 0.0
    """Angle at which the spring is at rest, rad, positive to the left; in the plane only. The rod begins along the
    beam's direction all the same."""


class RootSupportTorsionSpring(Part):
    """It does not move by itself, and turns against a torsion spring with the moment `stiffness (angle − rest_angle) +
    damping rate`, the angle being that from the direction of the beam, between −π and π."""

    torsion_spring: TorsionSpring
    """It does not move by itself, and turns against a torsion spring with the moment `stiffness (angle − rest_angle) +
    damping rate`, the angle being that from the direction of the beam, between −π and π."""


class Free(Part):
    """It moves and turns as the loads, gravity and a force that tows it will."""

    force_x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Towing force along x, N."""

    force_y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Towing force along y, N."""

    force_z: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Towing force along z, N; in three dimensions only."""


class RootSupportFree(Part):
    """It moves and turns as the loads, gravity and a force that tows it will."""

    free: Free
    """It moves and turns as the loads, gravity and a force that tows it will."""


RootSupport = Literal["clamped", "pinned"] | RootSupportTorsionSpring | RootSupportFree
"""How the root of a rod is held. `clamped`: It neither moves nor turns by itself. `pinned`: It does not move by itself,
and turns without resistance."""


class Rotation(Part):
    """Rotation about a fixed axis."""

    angle: TimeLaw
    """Angle, rad."""

    axis: tuple[Real, Real, Real] = (0.0, 0.0, 1.0)
    """Axis, of any length but 0; in two dimensions there is only z."""


class RootLaws(Part):
    """Motion of the root from its place at rest."""

    x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along x, m."""

    y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along y, m."""

    z: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along z, m; in three dimensions only."""

    rotations: list[Rotation] = Field(default_factory=list)
    """Rotations of the beam's direction, the first one applied first."""


class RootMotionLaws(Part):
    """Laws of time."""

    laws: RootLaws
    """Laws of time."""


RootMotion = Literal["master"] | RootMotionLaws
"""Prescribed motion of the root. `master`: The master sets the root's position, direction and their rates at the end of
each of its steps."""


class GeneralisedAlpha(Part):
    """Generalised-α (Chung & Hulbert 1993)."""

    rho_inf: Real
    """Spectral radius at infinite frequency, 0 … 1."""


class RodSchemeGeneralisedAlpha(Part):
    """Generalised-α (Chung & Hulbert 1993)."""

    generalised_alpha: GeneralisedAlpha
    """Generalised-α (Chung & Hulbert 1993)."""


RodScheme = Literal["trapezoid", "tr_bdf2", "bdf2"] | RodSchemeGeneralisedAlpha
"""Time scheme of the rod; all are of second order. `trapezoid`: The trapezoidal rule of the thesis (eq. 2.7); no
numerical dissipation, not safe for stiff axial modes. `tr_bdf2`: Trapezoid to 2 − √2 of the step, then two-step
backward differences over the rest (Bank et al. 1985; Hosea & Shampine 1996): as dissipative where it must be, least
where it need not, two solves a step. `bdf2`: Two-step backward differences: dissipative, and the same formula as the
fluid's, so that a coupled step is consistent."""


class Rod(Part):
    """Elastic model of the beam."""

    material: Material
    """Material, or the section's own numbers."""

    gravity: list[Real] = Field(default_factory=list)
    """Gravity, m/s²: as many components as the beam's root; absent where there is none."""

    damping: Real = 0.0
    """Damping force per length and velocity, kg/(m s) per metre of depth."""

    bending: Bending = "invariant"
    """Bending model."""

    calibration: Calibration = "second_order"
    """How the section's numbers become springs and masses."""

    clamp_compliance_length: Real = 0.0
    """Length by which the clamp lies behind the root, m: the elastic part of the foundation. It only softens the
    clamp."""

    root: RootSupport = "clamped"
    """How the root is held."""

    root_motion: RootMotion | None = None
    """Prescribed motion of the root; absent where it is still, and where the root is free."""

    scheme: RodScheme = "tr_bdf2"
    """Time scheme."""

    max_step: Real | None = None
    """Largest step of the rod's own inside a communication step, s; absent: the communication step."""


class NamedRod(Part):
    """One of several rods in a fluid."""

    name: str
    """Name of its unit, of at most 40 characters: a letter, then letters, digits and `_`; not `rod` or `fluid`."""

    beam: Beam
    """Geometry of the beam that the fluid sees and the rod moves."""

    rod: Rod
    """Elastic model of the beam."""


Load = Literal["momentum", "pressure_jump"]
"""What the fluid does to the rod. `momentum`: Momentum that the penalization takes from the fluid, with its impedance;
the rod then carries only the difference between its own mass and that of the fluid it displaces. `pressure_jump`: Jump
of the static pressure across the beam (thesis eq. 4.2); the rod carries its whole mass."""


Acceleration = Literal["aitken", "iqn_ils"]
"""What brings the next guess of an iteration from the residuals. `aitken`: Relaxation by Aitken's formula (Küttler &
Wall 2008). `iqn_ils`: Interface quasi-Newton with the inverse Jacobian from least squares (Degroote et al. 2009)."""


class Iterated(Part):
    """Until the interface agrees, with rollback of both units. In no case with the load `momentum`."""

    tolerance: Real = 0.0001
    """Residual of the interface displacement at which the step is accepted, relative to its change over the step."""

    max_iterations: Integer = 50
    """Largest number of iterations in a step; more is an error."""

    acceleration: Acceleration = "iqn_ils"
    """What brings the next guess from the residuals."""


class CouplingSchemeIterated(Part):
    """Until the interface agrees, with rollback of both units. In no case with the load `momentum`."""

    iterated: Iterated
    """Until the interface agrees, with rollback of both units. In no case with the load `momentum`."""


CouplingScheme = Literal["explicit", "parallel_explicit"] | CouplingSchemeIterated
"""How often the two sides are asked within one communication step. `explicit`: Once, one after the other: first the
rod, then the fluid with the rod's new state (serial, Gauss–Seidel). `parallel_explicit`: Once, side by side: both step
from what was known at the beginning (parallel, Jacobi)."""


class Guards(Part):
    """When a run with the scheme `explicit` or `parallel_explicit` is stopped as unstable, by the powers that cross the
    interface: what is unstable may well stay finite. A guard of `null` is off. Where the scene has this key the guards
    are for the units of others too; they need the outputs `load.power` of the rod and, under the load `momentum`,
    `beam.power` of the fluid."""

    window_steps: Integer = 500
    """Steps over which means of the magnitudes fade, and before which nothing is stopped; at least 1."""

    largest_imbalance: Real | None = 0.5
    """Largest difference of the powers that the rod takes and that the fluid gives under the load `momentum`, relative
    to the latter, means of the magnitudes: 0.04 in FSI3, 1 where it blows up. `null`: off."""

    largest_noise: Real | None = 1.5
    """Largest second difference, from step to step, of the power that the rod takes under the load `pressure_jump`,
    relative to the power, means of the magnitudes: 4 for a sawtooth, 2.4 for noise, below 0.8 in runs that hold.
    `null`: off."""

    min_power: Real = 1e-09
    """Mean power below which noise stops nothing, W per metre of depth: a rod at rest takes nothing but rounding."""


class Coupling(Part):
    """How fluid and rod exchange; what is left out is chosen by the rules of `docs/theory/coupling.md`."""

    load: Load | None = None
    """What the fluid does to the rod; absent: `momentum` where the rod is heavy enough for it and the fluid makes one
    step between two exchanges, else `pressure_jump`."""

    scheme: CouplingScheme | None = None
    """How often the two sides are asked within one communication step; absent: `explicit` under the load `momentum`,
    `iterated` under `pressure_jump`."""

    axial_pressure_strain: Flag = False
    """Whether the pressure around the rod strains it along itself, too, beside the load `momentum`, which knows only
    differences of the pressure. Its zero is the mean over the outlet, the upstream end of the inflow zone. Needs that
    load, an inflow and a material in plane strain; costs the fluid three transforms in each step."""

    guards: Guards | None = None
    """When an explicit run is stopped as unstable; absent: as with `{}` where both units are those of this project, not
    at all where one is another's."""


class PublishedQuantity(Part):
    """Published values of one series over whole periods of its final state."""

    unit: str
    """Unit of `mean` and `amplitude`: that of the series, e.g. `m` or `N/m`."""

    mean: Real | None = None
    """Half the sum of the largest and the smallest value, in `unit`."""

    amplitude: Real | None = None
    """Half the difference of the largest and the smallest value, in `unit`; 0 for a steady state."""

    frequency_hz: Real | None = None
    """Frequency, Hz."""


class PublishedCoefficients(Part):
    """Published coefficients of one still cylinder in an inflow (Schäfer & Turek 1996): cD and cL are 2 F/(ρ Ū² D), St
    is f D/Ū."""

    cd_max: Real | None = None
    """Largest drag coefficient."""

    cd_min: Real | None = None
    """Smallest drag coefficient."""

    cd_mean: Real | None = None
    """Half the sum of largest and smallest drag coefficient."""

    cl_max: Real | None = None
    """Largest lift coefficient."""

    cl_min: Real | None = None
    """Smallest lift coefficient."""

    cl_mean: Real | None = None
    """Half the sum of largest and smallest lift coefficient."""

    cl_peak_to_peak: Real | None = None
    """Largest less smallest lift coefficient."""

    st: Real | None = None
    """Strouhal number."""

    dp_mean: Real | None = None
    """Pressure at the front of the cylinder less that at its back, Pa."""


class PublishedRange(Part):
    """Smallest and largest published value of one series."""

    unit: str
    """Unit of `mean` and `amplitude`: that of the series."""

    mean: tuple[Real, Real] | None = None
    """Range of the mean, in `unit`."""

    amplitude: tuple[Real, Real] | None = None
    """Range of the amplitude, in `unit`."""

    frequency_hz: tuple[Real, Real] | None = None
    """Range of the frequency, Hz."""


class PublishedSpread(Part):
    """What several sources span."""

    source: str
    """Where the values come from."""

    quantities: dict[str, PublishedRange]
    """Ranges by the name of the recorded series, as in `reference.quantities`."""


class Reference(Part):
    """Published values that a run of the scene is compared with; the units do not read them."""

    source: str
    """Where the values come from: author, year, and table or page."""

    quantities: dict[str, PublishedQuantity] = Field(default_factory=dict)
    """Values by the name of the recorded series: `tip_ux`, `tip_uy`, `tip_uz`, `drag`, `lift`."""

    coefficients: PublishedCoefficients | None = None
    """PublishedCoefficients of one still cylinder in an inflow; absent for other scenes."""

    spread: PublishedSpread | None = None
    """What several sources span; absent where there is one."""


class Scene(Part):
    """A whole scene: at least a fluid or a rod."""

    json_schema: str | None = Field(None, alias="$schema")
    """Where the JSON Schema of this file is; read by editors only."""

    format: Integer = 2
    """Number of the format that the file follows; absent, it is the present one, 2."""

    name: str
    """Short name of at most 100 characters: letters, digits, `.`, `_` and `-`, the first one a letter, a digit or `_`;
    names the units and the result folder."""

    description: str = ""
    """One sentence for people."""

    display: Display | None = None
    """What pictures call a length and a time of 1; absent where they are metres and seconds."""

    time: Time
    """Clock of the co-simulation."""

    fluid: Fluid | None = None
    """The fluid; absent in a rod-only scene."""

    beam: Beam | None = None
    """Geometry of the beam that the fluid sees and the rod moves; absent in a scene without one."""

    rod: Rod | None = None
    """Elastic model of the beam; absent where the beam is rigid."""

    rods: list[NamedRod] = Field(default_factory=list)
    """Several beams in the fluid, each with a rod that is a unit of its own: at least two, in the place of `beam` and
    `rod`."""

    this_rod: str | None = None
    """Name of the one of `rods` that a rod's unit is, in the scene that it carries; absent elsewhere."""

    coupling: Coupling | None = None
    """How fluid and rod exchange; absent where it is left to the rules, refused where there are not both."""

    reference: Reference | None = None
    """Published values that a run is compared with; absent where there are none."""
