"""The parts of a scene. Made from modelDescription/scene.schema.json by `make schema`: do not edit."""

from typing import Literal

from pydantic import Field

from nervure.scene.part import Flag, Integer, Part, Real


class Display(Part):
    """Names of the units of length and time in pictures of a dimensionless scene."""

    length: str
    """Unit of length, e.g. `chords`."""

    time: str
    """Unit of time, e.g. `periods`."""


class Time(Part):
    """Clock of the co-simulation."""

    end: Real
    """End of the run, s."""

    communication_step: Real
    """Communication step of the master, s. Each unit divides it into equal steps where it must."""


class FluidBox(Part):
    """The periodic box and its grid."""

    x: tuple[Real, Real]
    """Ends along x, m."""

    y: tuple[Real, Real]
    """Ends along y, m."""

    z: tuple[Real, Real] | None = None
    """Ends along z, m; absent in two dimensions."""

    cells: tuple[Integer, Integer] | tuple[Integer, Integer, Integer]
    """Number of grid points along x, y and, if present, z: at least 8 each, at most 67108864 together. Products of
    small primes are fast."""


class Channel(Part):
    """Solid walls below and above, and in three dimensions on more sides."""

    y: tuple[Real, Real]
    """Places of the lower and the upper wall, m."""

    x: tuple[Real, Real] | None = None
    """Places of two walls across x, m; only in three dimensions."""

    z: tuple[Real, Real] | None = None
    """Places of two walls across z, m; only in three dimensions."""


InflowProfile = Literal["uniform", "parabolic"]
"""Profile of an inflow, of mean 1. `uniform`: The same velocity at every y. `parabolic`: Poiseuille's parabola between
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
    """`mean + amplitude · g(t) · sin(2 π frequency t + phase)`, where g is 1 or a cosine ramp from 0 at t = 0."""

    mean: Real = 0.0
    """Mean value."""

    amplitude: Real
    """Amplitude."""

    frequency: Real
    """Frequency, Hz."""

    phase: Real = 0.0
    """Phase at t = 0, rad."""

    ramp: Real = 0.0
    """Length of the ramp of g, s; without a ramp 0."""


class TimeLawSine(Part):
    """`mean + amplitude · g(t) · sin(2 π frequency t + phase)`, where g is 1 or a cosine ramp from 0 at t = 0."""

    sine: Sine
    """`mean + amplitude · g(t) · sin(2 π frequency t + phase)`, where g is 1 or a cosine ramp from 0 at t = 0."""


class Fourier(Part):
    """`mean + g(t) Σ_k [cosines[k] cos(2 π k f t) + sines[k] sin(2 π k f t)]`, where f is the frequency, k counts from
    1, and g is 1 or a cosine ramp from 0 at t = 0."""

    mean: Real = 0.0
    """Mean value."""

    frequency: Real
    """Fundamental frequency, Hz."""

    cosines: list[Real] = Field(default_factory=list)
    """Coefficients of the cosines, from the fundamental on."""

    sines: list[Real] = Field(default_factory=list)
    """Coefficients of the sines, from the fundamental on."""

    ramp: Real = 0.0
    """Length of the ramp of g, s; without a ramp 0."""


class TimeLawFourier(Part):
    """`mean + g(t) Σ_k [cosines[k] cos(2 π k f t) + sines[k] sin(2 π k f t)]`, where f is the frequency, k counts from
    1, and g is 1 or a cosine ramp from 0 at t = 0."""

    fourier: Fourier
    """`mean + g(t) Σ_k [cosines[k] cos(2 π k f t) + sines[k] sin(2 π k f t)]`, where f is the frequency, k counts from
    1, and g is 1 or a cosine ramp from 0 at t = 0."""


class Table(Part):
    """Cubic spline of class C² through points; constant before the first point and after the last."""

    times: list[Real]
    """Times of the points, s, increasing; at least two."""

    values: list[Real]
    """Values at the points."""

    end_slopes: tuple[Real, Real] | None = None
    """Slopes at the first and the last point, per second; absent: those of the cubic through the points at the end."""

    periodic: Flag = False
    """Whether the points are one period of a law that repeats itself at all times; the last value equals the first."""


class TimeLawTable(Part):
    """Spline through points."""

    table: Table
    """Spline through points."""


class TimeLawSum(Part):
    """Sum of several laws."""

    sum: list["TimeLaw"]
    """Sum of several laws."""


TimeLaw = TimeLawConstant | TimeLawCosineRamp | TimeLawSine | TimeLawFourier | TimeLawTable | TimeLawSum
"""A quantity as a function of time, in the unit of its key."""


class Inflow(Part):
    """Zone across the box in which the velocity is imposed: `(profile(y) · law(t), 0)`."""

    x: tuple[Real, Real]
    """Ends along x, m."""

    profile: InflowProfile
    """Profile of the velocity across the zone, of mean 1."""

    mean_velocity: TimeLaw
    """Mean velocity of the profile over time, m/s."""

    c_eta: Real
    """Relaxation time of the zone, s."""


class Sponge(Part):
    """Zone across the box in which the flow relaxes to `(profile(y) · law(t), 0)` at the rate `sin²(π (x − x_0)/(x_1 −
    x_0)) / c_eta`, which damps a wake and reflects little of it."""

    x: tuple[Real, Real]
    """Ends along x, m."""

    profile: InflowProfile = "uniform"
    """Profile of the velocity across the zone, of mean 1."""

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

    z: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Along z, m/s; only in three dimensions."""


class Motion(Part):
    """Prescribed displacement of a cylinder, m."""

    x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along x, m."""

    y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along y, m."""


class Cylinder(Part):
    """A circular cylinder."""

    center: tuple[Real, Real]
    """Centre, m; the motion is added to it."""

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
    """Length of the axis along the body's x, m."""

    thickness: Real
    """Length of the axis along the body's y, m."""


class ShapeEllipse(Part):
    """An ellipse."""

    ellipse: Ellipse
    """An ellipse."""


Ends = Literal["square", "round"]
"""Ends of a rectangle. `square`: Flat. `round`: Half circles whose diameter is the thickness."""


class Rectangle(Part):
    """A rectangle."""

    length: Real
    """Length along the body's x, m, ends included."""

    thickness: Real
    """Thickness along the body's y, m."""

    ends: Ends = "square"
    """Form of the two ends along the body's x."""


class ShapeRectangle(Part):
    """A rectangle."""

    rectangle: Rectangle
    """A rectangle."""


class Polygon(Part):
    """A polygon."""

    corners: list[tuple[Real, Real]]
    """Corners in order, either way round, m: 3 to 1000. The sides must not cross."""


class ShapePolygon(Part):
    """A polygon."""

    polygon: Polygon
    """A polygon."""


class Plate(Part):
    """A flat plate of no thickness: markers drag the fluid, as at a beam with the surface `line`."""

    length: Real
    """Length along the body's x, m."""

    width: Real | None = None
    """Width along the body's z, m; only in three dimensions."""


class ShapePlate(Part):
    """A flat plate of no thickness: markers drag the fluid, as at a beam with the surface `line`."""

    plate: Plate
    """A flat plate of no thickness: markers drag the fluid, as at a beam with the surface `line`."""


class Polyline(Part):
    """An open line of no thickness, as a plate with corners."""

    points: list[tuple[Real, Real]]
    """Points in order, m: 2 to 1000. The sides must not cross."""


class ShapePolyline(Part):
    """An open line of no thickness, as a plate with corners."""

    polyline: Polyline
    """An open line of no thickness, as a plate with corners."""


class Sphere(Part):
    """A sphere."""

    radius: Real
    """Radius, m."""


class ShapeSphere(Part):
    """A sphere."""

    sphere: Sphere
    """A sphere."""


class Ellipsoid(Part):
    """An ellipsoid."""

    lengths: tuple[Real, Real, Real]
    """Lengths of the axes along the body's x, y and z, m."""


class ShapeEllipsoid(Part):
    """An ellipsoid."""

    ellipsoid: Ellipsoid
    """An ellipsoid."""


class Cuboid(Part):
    """A cuboid; a plate is a thin one."""

    lengths: tuple[Real, Real, Real]
    """Lengths along the body's x, y and z, m."""


class ShapeCuboid(Part):
    """A cuboid; a plate is a thin one."""

    cuboid: Cuboid
    """A cuboid; a plate is a thin one."""


class Disk(Part):
    """A disk of no thickness across the body's y, as a plate."""

    radius: Real
    """Radius, m."""


class ShapeDisk(Part):
    """A disk of no thickness across the body's y, as a plate."""

    disk: Disk
    """A disk of no thickness across the body's y, as a plate."""


class Triangulation(Part):
    """Triangles of no thickness, as a plate. A closed surface encloses fluid."""

    nodes: list[tuple[Real, Real, Real]] = Field(default_factory=list)
    """Positions of the nodes, m."""

    triangles: list[tuple[Integer, Integer, Integer]] = Field(default_factory=list)
    """Nodes of each triangle, counted from 0."""

    file: str | None = None
    """STL, OBJ or PLY file beside the scene's. `nervure` puts its nodes and triangles in the place of this key."""

    unit: Real | None = None
    """Length of the unit of the file, m; by default 1."""


class ShapeTriangulation(Part):
    """Triangles of no thickness, as a plate. A closed surface encloses fluid."""

    triangulation: Triangulation
    """Triangles of no thickness, as a plate. A closed surface encloses fluid."""


Axis = Literal["x", "y", "z"]
"""An axis of the coordinates or of a body. `x`: x. `y`: y. `z`: z."""


class CircularCylinder(Part):
    """A circular cylinder in space."""

    axis: Axis = "z"
    """Axis of the body along which it lies."""

    radius: Real
    """Radius, m."""

    length: Real | None = None
    """Length, m; absent for a cylinder through the whole box, whose axis must lie along the box."""


class ShapeCircularCylinder(Part):
    """A circular cylinder in space."""

    circular_cylinder: CircularCylinder
    """A circular cylinder in space."""


Shape = (
    ShapeCircle
    | ShapeEllipse
    | ShapeRectangle
    | ShapePolygon
    | ShapePlate
    | ShapePolyline
    | ShapeSphere
    | ShapeEllipsoid
    | ShapeCuboid
    | ShapeDisk
    | ShapeTriangulation
    | ShapeCircularCylinder
)
"""Outline of a body. The origin of its axes is its middle, except for a polygon or a polyline."""


class Turn(Part):
    """A turn about an axis."""

    axis: tuple[Real, Real, Real]
    """Axis, of any length above 0."""

    angle: Real
    """Angle, rad, positive by the right-hand rule."""


class BodyMotion(Part):
    """Prescribed motion of a body."""

    x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement of the pivot along x, m."""

    y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement of the pivot along y, m."""

    z: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement of the pivot along z, m; only in three dimensions."""

    angle: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Angle about the pivot, rad, counter-clockwise; in three dimensions about `axis` by the right-hand rule."""

    axis: tuple[Real, Real, Real] | None = None
    """Axis of the box about which the body turns, of any length above 0, by default z; only in three dimensions."""


ByMaster = Literal["master"]
"""Motion from outside. `master`: The master sets displacement, angle and their rates at the end of each communication
step."""


class Support(Part):
    """Spring and damper in parallel, per metre of depth."""

    stiffness: Real = 0.0
    """Stiffness, N/m, about the pivot N m/rad."""

    damping: Real = 0.0
    """Damping, N s/m, about the pivot N m s/rad."""

    rest: Real = 0.0
    """Displacement, m, or angle, rad, at which the spring has no force. The body starts at 0."""


class Mount(Part):
    """Mass of a body, whose centre is the pivot, and its supports. It is held in the directions that are absent."""

    mass: Real
    """Mass, kg per metre of depth."""

    inertia: Real | None = None
    """Moment of inertia about the pivot, kg m² per metre of depth; needed with `angle`, and absent without it."""

    x: Support | None = None
    """Support along x; absent where the body is held."""

    y: Support | None = None
    """Support along y; absent where the body is held."""

    angle: Support | None = None
    """Support about the pivot; absent where the body is held."""


class Body(Part):
    """A rigid body."""

    shape: Shape
    """Outline in the body's own axes."""

    position: tuple[Real, Real] | tuple[Real, Real, Real]
    """Place of the pivot, m; motion and mount displace it from there."""

    pivot: tuple[Real, Real] | tuple[Real, Real, Real] = (0.0, 0.0)
    """Pivot in the body's own axes, m, about which the body turns and its moment is taken; by default their origin."""

    angle: Real = 0.0
    """Angle from the x axis of the box to the body's own, rad, counter-clockwise; motion and mount turn it from there.
    Only in two dimensions."""

    turn: Turn | None = None
    """Turn from the axes of the box to those of the body, before the motion; only in three dimensions."""

    motion: BodyMotion | ByMaster | None = None
    """Prescribed motion; absent for a body that is still or has a mount."""

    mount: Mount | None = None
    """Springs and dampers on which the fluid moves the body; absent for one that is still or has a motion."""


class Sharp(Part):
    """chi = 1 inside and 0 outside (thesis ch. 3). The wall is shifted by √(ν C_eta), so that no-slip holds at the
    surface."""

    c_eta: Real
    """Relaxation time C_eta, s."""

    displacement_corrected: Flag = True
    """Whether the wall is shifted; otherwise the mask is the one of the thesis."""


class MaskSharp(Part):
    """chi = 1 inside and 0 outside (thesis ch. 3). The wall is shifted by √(ν C_eta), so that no-slip holds at the
    surface."""

    sharp: Sharp
    """chi = 1 inside and 0 outside (thesis ch. 3). The wall is shifted by √(ν C_eta), so that no-slip holds at the
    surface."""


class Cosine(Part):
    """Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds at the surface (Hester, Vasil &
    Burns 2021)."""

    c_eta: Real
    """Relaxation time C_eta, s."""

    half_width: Real
    """Half the width of the layer, grid cells."""

    displacement_corrected: Flag = True
    """Whether the layer is shifted; otherwise the mask is the one of the thesis."""


class MaskCosine(Part):
    """Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds at the surface (Hester, Vasil &
    Burns 2021)."""

    cosine: Cosine
    """Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds at the surface (Hester, Vasil &
    Burns 2021)."""


WallCorrection = Literal["none", "shear", "curvature"]
"""Velocity to which a body draws the fluid at its surface. It decides which flows along a wall are right to the order
of a cell. `none`: Velocity of the body. No-slip holds at the surface in linear shear, but the smooth drag lets a flux
through. `shear`: Inside the body, weakly, the mirror image of the flow outside. The flux is that of linear shear.
`curvature`: As `shear`, with a correction at the surface by the second difference of the flow outside. No-slip also
holds where a pressure gradient bends the velocity profile."""


class LogLinear(Part):
    """Drag rate that grows exponentially with depth. No-slip then holds at the surface wherever the grid lies."""

    c_eta: Real
    """Smallest relaxation time, s, reached inside the solid."""

    decay_length_cells: Real = 0.25
    """Depth over which the drag rate grows by a factor e, grid cells. A quarter is the shortest that the grid resolves:
    the wall keeps its place to 0.03 cells wherever the grid lies."""

    core_depth: Real | None = None
    """Depth at which the core of a still body begins, grid cells. In the core the drag rate grows three times as fast,
    up to 1/C_eta; above a deep core it stays at the value that the grid resolves. Absent: one and a half decay lengths,
    three without a wall correction. With 2 the forces depend much less on C_eta, but a body of fewer than 25 cells
    across is porous. The depth is at most a fifth of a body's thickness. A beam or a moving body has a core only where
    it is thinner than about four cells."""

    wall_correction: WallCorrection = "curvature"
    """Velocity to which the bodies draw the fluid at their surface."""


class MaskLogLinear(Part):
    """Drag rate that grows exponentially with depth. No-slip then holds at the surface wherever the grid lies."""

    log_linear: LogLinear
    """Drag rate that grows exponentially with depth. No-slip then holds at the surface wherever the grid lies."""


Mask = MaskSharp | MaskCosine | MaskLogLinear
"""Drag rate of a solid as a function of the signed distance to its surface."""


Filter = Literal["smooth", "two_thirds", "none"]
"""Filter of aliasing errors. `smooth`: exp(−36 (k/k_max)³⁶) (Hou & Li 2007). `two_thirds`: Truncation outside the
ellipse of two thirds (thesis eq. 3.14). `none`: No filter."""


TimeScheme = Literal["sbdf2", "rk2"]
"""Time scheme of the fluid. `sbdf2`: Two-step backward differences with implicit drag and viscosity: only advection
limits the step. `rk2`: Heun's method with explicit drag and exact viscosity (thesis eq. 3.15 – 3.18): a step above
C_eta is divided."""


class TimeStepping(Part):
    """Steps of the fluid inside a communication step."""

    max_step: Real
    """Largest step, s."""

    max_cfl: Real
    """Largest CFL number max(|u|/dx + |v|/dy) dt, at most 0.4 with `sbdf2` and 0.6 with `rk2`: above, advection is
    unstable. A step that would exceed it is divided."""

    scheme: TimeScheme = "sbdf2"
    """Time scheme."""


class Probe(Part):
    """A point whose velocity and pressure are outputs."""

    name: str
    """Name: a letter, then letters, digits and `_`."""

    position: tuple[Real, Real] | tuple[Real, Real, Real]
    """Place, m."""


Precision = Literal["double", "single"]
"""Precision of the fields and transforms. Bodies, forces and loads are always in double precision. `double`: 16 digits.
`single`: 7 digits at half the memory. Unfit for small differences, such as a lift of 1e-5 of the drag, or orders of
convergence."""


class Fluid(Part):
    """An incompressible fluid in a periodic box of two or three dimensions."""

    density: Real
    """Density, kg/m³."""

    kinematic_viscosity: Real
    """Kinematic viscosity, m²/s."""

    box: FluidBox
    """The periodic box and its grid."""

    initial_velocity: tuple[Real, Real] | tuple[Real, Real, Real] = (0.0, 0.0)
    """Uniform velocity at t = 0, m/s; a component that is left out is 0."""

    disturbance: Real | None = None
    """Amplitude a of a smooth disturbance of the initial velocity, m/s: the waves `a sin(2π (y − y_0)/L_y)` along x and
    `a sin(2π (x − x_0)/L_x)` along y, in a box from x_0 and y_0 of the lengths L_x and L_y. Absent: none. A symmetric
    flow needs one to shed vortices; a hundredth of the stream is enough."""

    channel: Channel | None = None
    """Solid walls below and above; absent in a periodic scene."""

    inflow: Inflow | None = None
    """Zone across the box in which the velocity is imposed; absent where no inflow drives the flow."""

    sponge: Sponge | None = None
    """Zone across the box in which the flow relaxes softly to a velocity; absent where nothing must be damped."""

    mean_flow: MeanFlow | None = None
    """Mean velocity over the whole box; absent where it is free. Not together with an inflow."""

    cylinders: list[Cylinder] = Field(default_factory=list)
    """Circular cylinders, still or in prescribed motion."""

    bodies: list[Body] = Field(default_factory=list)
    """Rigid bodies of any shape: still, in prescribed motion, or on springs."""

    mask: Mask
    """Drag rate of solids on the grid."""

    filter: Filter = "smooth"
    """Filter of aliasing errors."""

    time_stepping: TimeStepping
    """Steps of the fluid inside a communication step."""

    probes: list[Probe] = Field(default_factory=list)
    """Points whose velocity and pressure are outputs."""

    precision: Precision = "double"
    """Precision of the fields and transforms."""

    threads: Integer = 1
    """Largest number of threads in a step. A small grid uses fewer, and results do not depend on the number."""


class OnCylinder(Part):
    """On the surface of a cylinder, pointing outwards."""

    cylinder: Integer
    """Index of the cylinder in `fluid.cylinders`, from 0."""

    angle: Real = 0.0
    """Angle of the outward direction from the x axis, rad."""


class RootOnCylinder(Part):
    """On the surface of a cylinder, pointing outwards."""

    on_cylinder: OnCylinder
    """On the surface of a cylinder, pointing outwards."""


class At(Part):
    """At a point, in two or three dimensions."""

    position: tuple[Real, Real] | tuple[Real, Real, Real]
    """Position, m: 2 or 3 components."""

    direction: tuple[Real, Real] | tuple[Real, Real, Real]
    """Direction of the beam at the root; any length but 0."""


class RootAt(Part):
    """At a point, in two or three dimensions."""

    at: At
    """At a point, in two or three dimensions."""


Root = RootOnCylinder | RootAt
"""Place and direction of a beam's root at rest."""


class Taper(Part):
    """`((1 − s) root^(1/power) + s tip^(1/power))^power`: linear, or a power of a linear function. The bending
    stiffness of a plate of linear thickness has the power 3."""

    root: Real
    """Value at the root."""

    tip: Real
    """Value at the tip."""

    power: Real = 1.0
    """Power of the linear function."""


class SpanwiseProfileTaper(Part):
    """`((1 − s) root^(1/power) + s tip^(1/power))^power`: linear, or a power of a linear function. The bending
    stiffness of a plate of linear thickness has the power 3."""

    taper: Taper
    """`((1 − s) root^(1/power) + s tip^(1/power))^power`: linear, or a power of a linear function. The bending
    stiffness of a plate of linear thickness has the power 3."""


class Points(Part):
    """Straight lines between points."""

    s: list[Real]
    """Places of the points, increasing from 0 at the root to 1 at the tip."""

    values: list[Real]
    """Values at the points, > 0."""


class SpanwiseProfilePoints(Part):
    """Straight lines between points."""

    points: Points
    """Straight lines between points."""


SpanwiseProfile = SpanwiseProfileTaper | SpanwiseProfilePoints
"""A quantity as a function of the place s along the span, 0 at the root and 1 at the tip, in the unit of its key."""


Surface = Literal["line", "mask"]
"""How a beam meets the fluid. `line`: Markers along the beam drag the fluid. Whatever the beam's thickness, the line
stands for a plate of 1.5 cells, in space for a rod with a radius of 0.87 (slow flow) to 1.18 cells (added mass), and
the rod may have any mass, with one exchange per step. `mask`: The mask of the band around the beam, which wants four
cells of thickness or more."""


class Beam(Part):
    """A beam with a flat tip. Its stations are the nodes of the rod."""

    root: Root
    """Place and direction of the root at rest."""

    length: Real
    """Length from root to tip, m."""

    thickness: Real | SpanwiseProfile
    """Thickness, m: a number, or a profile along the span."""

    segments: Integer
    """Number of segments, 2 to 65536; there are `segments + 1` stations, the first at the root."""

    surface: Surface = "mask"
    """How the beam meets the fluid; no effect without one."""

    rest_angles: list[Real] = Field(default_factory=list)
    """Angle of each segment at rest from the direction at the root, rad, counter-clockwise: `[segments]`; absent for a
    straight beam. In two dimensions only: a curved rod in space needs a material frame and its twist."""


class PlaneStrain(Part):
    """A plate of the beam's thickness h in plane strain, one metre deep: EI = E h³ / (12 (1 − ν²)), EA = E h / (1 −
    ν²)."""

    density: Real
    """Density, kg/m³."""

    youngs_modulus: Real
    """Young's modulus E, Pa."""

    poisson_ratio: Real
    """Poisson's ratio ν."""

    shear_factor: Real | None = None
    """Shear correction factor k of GA_s = k E h / (2 (1 + ν)), > 0 and <= 1; 10/(12 − ν) for a plate (Cowper 1966).
    Absent: the section stays normal to the rod."""


class MaterialPlaneStrain(Part):
    """A plate of the beam's thickness h in plane strain, one metre deep: EI = E h³ / (12 (1 − ν²)), EA = E h / (1 −
    ν²)."""

    plane_strain: PlaneStrain
    """A plate of the beam's thickness h in plane strain, one metre deep: EI = E h³ / (12 (1 − ν²)), EA = E h / (1 −
    ν²)."""


class Section(Part):
    """Mass and stiffness of the section (per metre of depth in a two-dimensional scene), each a number or a profile
    along the span."""

    line_density: Real | SpanwiseProfile
    """Mass per length, kg/m."""

    bending_stiffness: Real | SpanwiseProfile
    """Bending stiffness EI, N m²."""

    axial_stiffness: Real | SpanwiseProfile
    """Axial stiffness EA, N."""

    shear_stiffness: Real | SpanwiseProfile | None = None
    """Shear stiffness GA_s, N, of a rod in the plane with invariant bending; absent: the section stays normal to the
    rod."""


class MaterialSection(Part):
    """Mass and stiffness of the section (per metre of depth in a two-dimensional scene)."""

    section: Section
    """Mass and stiffness of the section (per metre of depth in a two-dimensional scene)."""


Material = MaterialPlaneStrain | MaterialSection
"""Material of a rod, or mass and stiffness of its section."""


Bending = Literal["invariant", "projected"]
"""Angle on which the bending energy depends. `invariant`: Turning angle ψ between neighbouring segments, by 2 tan(ψ/2)
(Bergou et al. 2008): the same in every frame. `projected`: Angles of the segments' projections into the planes xy and
xz (thesis eqs. 2.1 and 2.4): depends on the frame and is singular where a projection vanishes, which is an error."""


class Thesis(Part):
    """Thesis, section 2.4.1: one k_e for segments of any length, clamp spring EI/l0, a whole segment's mass at every
    node. Of first order."""

    k_e: Real
    """Axial stiffness of a segment, N/m, in place of EA."""


class CalibrationThesis(Part):
    """Thesis, section 2.4.1: one k_e for segments of any length, clamp spring EI/l0, a whole segment's mass at every
    node. Of first order."""

    thesis: Thesis
    """Thesis, section 2.4.1: one k_e for segments of any length, clamp spring EI/l0, a whole segment's mass at every
    node. Of first order."""


Calibration = Literal["second_order"] | CalibrationThesis
"""Calibration of the springs and masses of a discrete rod by the section. `second_order`: k_e = EA/l0, clamp spring
EI/(l0/2), half a segment's mass at the tip: of second order in the length l0 of a segment."""


class TorsionSpring(Part):
    """The root does not move freely, and turns against a torsion spring with the moment `stiffness (angle − rest_angle)
    + damping rate`. The angle is counted from the direction of the beam, between −π and π."""

    stiffness: Real
    """Stiffness of the spring, N m/rad."""

    damping: Real = 0.0
    """Damping, N m s/rad; in the plane only."""

    rest_angle: Real = 0.0
    """Angle at which the spring is at rest, rad, counter-clockwise; in the plane only. The rod still starts along the
    direction of the beam."""


class RootSupportTorsionSpring(Part):
    """The root does not move freely, and turns against a torsion spring with the moment `stiffness (angle − rest_angle)
    + damping rate`. The angle is counted from the direction of the beam, between −π and π."""

    torsion_spring: TorsionSpring
    """The root does not move freely, and turns against a torsion spring with the moment `stiffness (angle − rest_angle)
    + damping rate`. The angle is counted from the direction of the beam, between −π and π."""


class Free(Part):
    """The root moves and turns under the loads, gravity and a towing force."""

    force_x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Towing force along x, N."""

    force_y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Towing force along y, N."""

    force_z: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Towing force along z, N; in three dimensions only."""


class RootSupportFree(Part):
    """The root moves and turns under the loads, gravity and a towing force."""

    free: Free
    """The root moves and turns under the loads, gravity and a towing force."""


RootSupport = Literal["clamped", "pinned"] | RootSupportTorsionSpring | RootSupportFree
"""Support of the root of a rod. `clamped`: The root neither moves nor turns freely. `pinned`: The root does not move
freely, and turns without resistance."""


class Slide(Part):
    """Guide of the root: along one axis the root moves under the loads, in all else as `root` and `root_motion` say."""

    along: Axis
    """Axis of the guide; z in three dimensions only."""

    mass: Real = 0.0
    """Mass that moves with the root besides the rod, kg (per metre of depth in two dimensions)."""


class Rotation(Part):
    """Rotation about a fixed axis."""

    angle: TimeLaw
    """Angle, rad."""

    axis: tuple[Real, Real, Real] = (0.0, 0.0, 1.0)
    """Axis, of any length but 0; in two dimensions only z."""


class RootLaws(Part):
    """Motion of the root from its place at rest."""

    x: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along x, m."""

    y: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along y, m."""

    z: TimeLaw = Field(default_factory=lambda: TimeLawConstant(constant=0.0))
    """Displacement along z, m; in three dimensions only."""

    rotations: list[Rotation] = Field(default_factory=list)
    """Rotations of the beam's direction, applied in order."""


class RootMotionLaws(Part):
    """Laws of time."""

    laws: RootLaws
    """Laws of time."""


RootMotion = Literal["master"] | RootMotionLaws
"""Prescribed motion of the root. `master`: The master sets position, direction and rates of the root at the end of each
communication step."""


class GeneralisedAlpha(Part):
    """Generalised-α (Chung & Hulbert 1993)."""

    rho_inf: Real
    """Spectral radius at infinite frequency, 0 … 1."""


class RodSchemeGeneralisedAlpha(Part):
    """Generalised-α (Chung & Hulbert 1993)."""

    generalised_alpha: GeneralisedAlpha
    """Generalised-α (Chung & Hulbert 1993)."""


RodScheme = Literal["trapezoid", "tr_bdf2", "bdf2"] | RodSchemeGeneralisedAlpha
"""Time scheme of the rod; all are of second order. `trapezoid`: Trapezoidal rule (thesis eq. 2.7), without numerical
dissipation; unsafe for stiff axial modes. `tr_bdf2`: Trapezoidal rule to 2 − √2 of the step, then two-step backward
differences (Bank et al. 1985; Hosea & Shampine 1996): damps stiff modes fully and resolved ones least, with two solves
per step. `bdf2`: Two-step backward differences: dissipative, and consistent with the same scheme of the fluid."""


class Rod(Part):
    """Elastic model of the beam."""

    material: Material
    """Material, or mass and stiffness of the section."""

    gravity: list[Real] = Field(default_factory=list)
    """Gravity, m/s², with as many components as the beam's root; absent without gravity."""

    damping: Real = 0.0
    """Damping force per length and velocity, kg/(m s) per metre of depth."""

    bending: Bending = "invariant"
    """Bending model."""

    calibration: Calibration = "second_order"
    """Calibration of springs and masses."""

    clamp_compliance_length: Real = 0.0
    """Length of beam, m, whose bending compliance is added to that of the clamp, for an elastic foundation."""

    root: RootSupport = "clamped"
    """Support of the root."""

    slide: Slide | None = None
    """Guide along which the root moves freely, as a swimmer does; absent: `root` holds it in all directions."""

    root_motion: RootMotion | None = None
    """Prescribed motion of the root; absent for a still or a free root."""

    scheme: RodScheme = "tr_bdf2"
    """Time scheme."""

    max_step: Real | None = None
    """Largest step of the rod inside a communication step, s; absent: the communication step."""


class NamedRod(Part):
    """One of several rods in a fluid."""

    name: str
    """Name of the unit, at most 40 characters: a letter, then letters, digits and `_`; not `rod` or `fluid`."""

    beam: Beam
    """Geometry of the beam."""

    rod: Rod
    """Elastic model of the beam."""


class Rectangular(Part):
    """A rectangle with its root on the y axis; chains `root`, `tip`, `left` and `right`."""

    length: Real
    """Length along x, m."""

    width: Real
    """Width along y, m."""

    along: Integer
    """Triangles along x."""


class WingMeshRectangular(Part):
    """A rectangle with its root on the y axis; chains `root`, `tip`, `left` and `right`."""

    rectangular: Rectangular
    """A rectangle with its root on the y axis; chains `root`, `tip`, `left` and `right`."""


class Elliptical(Part):
    """An ellipse that begins on the y axis; chains `root` and `tip`, quarters of the outline."""

    length: Real
    """Length along x, m."""

    width: Real
    """Width along y, m."""

    along: Integer
    """Triangles along x."""


class WingMeshElliptical(Part):
    """An ellipse that begins on the y axis; chains `root` and `tip`, quarters of the outline."""

    elliptical: Elliptical
    """An ellipse that begins on the y axis; chains `root` and `tip`, quarters of the outline."""


class Insect(Part):
    """A simplified insect wing along x; chains `root`, `margin`, `costa`, `radius`, `media`, `cubitus` and `anal`."""

    span: Real
    """Span, m."""

    chord: Real
    """Largest chord, m."""

    along: Integer
    """Triangles along a vein."""


class WingMeshInsect(Part):
    """A simplified insect wing along x; chains `root`, `margin`, `costa`, `radius`, `media`, `cubitus` and `anal`."""

    insect: Insect
    """A simplified insect wing along x; chains `root`, `margin`, `costa`, `radius`, `media`, `cubitus` and `anal`."""


class WingChain(Part):
    """Named line of nodes."""

    name: str
    """Name."""

    nodes: list[Integer]
    """Nodes in order, counted from 0."""


class WingGroup(Part):
    """Named group of triangles."""

    name: str
    """Name."""

    triangles: list[Integer]
    """Triangles, counted from 0."""


class Triangles(Part):
    """Nodes and triangles of any other program."""

    nodes: list[tuple[Real, Real, Real]]
    """Positions of the nodes, m."""

    triangles: list[tuple[Integer, Integer, Integer]]
    """Nodes of the triangles, counted from 0, all in the same sense of rotation."""

    chains: list[WingChain] = Field(default_factory=list)
    """Chains."""

    groups: list[WingGroup] = Field(default_factory=list)
    """Groups of triangles, for regions."""


class WingMeshTriangles(Part):
    """Nodes and triangles of any other program."""

    triangles: Triangles
    """Nodes and triangles of any other program."""


class WingMeshFile(Part):
    """File of another program beside the scene's: Gmsh, VTK, OBJ, STL. `nervure` puts `triangles` in the place of this
    key; lines of a physical group make a chain of its name, and triangles a group."""

    file: str
    """File of another program beside the scene's: Gmsh, VTK, OBJ, STL. `nervure` puts `triangles` in the place of this
    key; lines of a physical group make a chain of its name, and triangles a group."""


WingMesh = WingMeshRectangular | WingMeshElliptical | WingMeshInsect | WingMeshTriangles | WingMeshFile
"""Mesh of a wing. Chains are named lines of nodes."""


class Membrane(Part):
    """Material of a membrane."""

    areal_density: Real
    """Mass per area, kg/m²."""

    stretching_stiffness: Real
    """Stiffness E h in its plane, N/m."""

    bending_stiffness: Real = 0.0
    """Bending stiffness E h³/(12 (1 − ν²)), N m."""

    poisson_ratio: Real = 0.0
    """Poisson's ratio ν."""

    tension: Real = 0.0
    """Tension at rest, N/m."""


class Region(Part):
    """Part of the membrane of a material of its own."""

    name: str
    """Name; without a polygon the name of a group of the mesh."""

    polygon: list[tuple[Real, Real]] | None = None
    """Corners of a polygon in x and y, m: the region has the triangles whose middle at rest lies inside."""

    membrane: Membrane
    """Material."""


class Vein(Part):
    """Vein along a chain of the mesh, straight at rest."""

    chain: str
    """Name of the chain, from base to tip."""

    line_density: Real
    """Mass per length at the base, kg/m."""

    bending_stiffness: Real
    """Bending stiffness EI at the base, N m²."""

    axial_stiffness: Real
    """Axial stiffness EA at the base, N."""

    tip_diameter: Real = 1.0
    """Diameter at the tip by the diameter at the base; mass and EA follow its square, EI its fourth power."""


class Hinge(Part):
    """The membrane turns about the line of the root against a spring along it."""

    stiffness: Real
    """Stiffness of the whole line, N m/rad."""


class WingSupportHinge(Part):
    """The membrane turns about the line of the root against a spring along it."""

    hinge: Hinge
    """The membrane turns about the line of the root against a spring along it."""


WingSupport = Literal["clamped", "pinned"] | WingSupportHinge
"""Support of the root of a wing. `clamped`: Membrane and veins keep their direction at the root. `pinned`: The wing
turns freely about the nodes of the root."""


class Wing(Part):
    """An elastic wing in space."""

    mesh: WingMesh
    """Nodes and triangles at rest."""

    membrane: Membrane | None = None
    """Material of the membrane outside regions; absent for veins alone."""

    regions: list[Region] = Field(default_factory=list)
    """Parts of the membrane of other materials; the last one counts where several hold a triangle."""

    veins: list[Vein] = Field(default_factory=list)
    """Veins."""

    root: str | None = None
    """Chain of the mesh that the base holds; absent for a free wing. Generated meshes have `root`."""

    support: WingSupport = "clamped"
    """Support of the root."""

    root_motion: RootLaws | None = None
    """Motion of the base from its place at rest; rotations are about `pivot`. Absent: at rest."""

    pivot: tuple[Real, Real, Real] = (0.0, 0.0, 0.0)
    """Centre of the rotations of the base, m."""

    gravity: tuple[Real, Real, Real] = (0.0, 0.0, 0.0)
    """Gravity, m/s²."""

    relaxation_time: Real = 0.0
    """Relaxation time of the strain, s: a mode of circular frequency ω has the damping ratio ω/2 times it."""

    scheme: RodScheme = "tr_bdf2"
    """Time scheme."""

    max_step: Real | None = None
    """Largest step of the wing inside a communication step, s; absent: the communication step."""


Load = Literal["momentum", "pressure_jump"]
"""Load of the fluid on the rod. `momentum`: Momentum that the penalization takes from the fluid, with its impedance.
The rod's mass is then reduced by the mass of the fluid it displaces. `pressure_jump`: Jump of the static pressure
across the beam (thesis eq. 4.2). The rod has its whole mass."""


Acceleration = Literal["aitken", "iqn_ils"]
"""Acceleration of the iteration, which makes the next guess from the residuals. `aitken`: Relaxation by Aitken's
formula (Küttler & Wall 2008). `iqn_ils`: Interface quasi-Newton with the inverse Jacobian from least squares (Degroote
et al. 2009)."""


class Iterated(Part):
    """Steps with rollback of both units until the interface agrees. Not with the load `momentum`."""

    tolerance: Real = 0.0001
    """Residual of the interface displacement at which the step is accepted, relative to its change over the step."""

    max_iterations: Integer = 50
    """Largest number of iterations in a step; a step that needs more is an error."""

    acceleration: Acceleration = "iqn_ils"
    """Acceleration of the iteration."""


class CouplingSchemeIterated(Part):
    """Steps with rollback of both units until the interface agrees. Not with the load `momentum`."""

    iterated: Iterated
    """Steps with rollback of both units until the interface agrees. Not with the load `momentum`."""


CouplingScheme = Literal["explicit", "parallel_explicit"] | CouplingSchemeIterated
"""Order of the steps of both units within a communication step. `explicit`: One step each: first the rod, then the
fluid with the rod's new state (serial, Gauss–Seidel). `parallel_explicit`: One step each, both from the state at the
beginning (parallel, Jacobi)."""


class Guards(Part):
    """Limits that stop an unstable run with the scheme `explicit` or `parallel_explicit`, by the powers across the
    interface: an unstable run may stay finite. A limit of `null` is off. With this key the limits hold for foreign
    units too, which then need the outputs `load.power` of the rod and, with the load `momentum`, `beam.power` of the
    fluid."""

    window_steps: Integer = 500
    """Number of steps over which means of magnitudes fade, and before which no run is stopped; at least 1."""

    largest_imbalance: Real | None = 0.5
    """Largest difference between the power on the rod and the power from the fluid with the load `momentum`, relative
    to the latter, in means of magnitudes: 0.04 in FSI3, 1 in a run that diverges. `null`: off."""

    largest_noise: Real | None = 1.5
    """Largest second difference over steps of the power on the rod with the load `pressure_jump`, relative to the
    power, in means of magnitudes: 4 for a sawtooth, 2.4 for noise, below 0.8 in stable runs. `null`: off."""

    min_power: Real = 1e-09
    """Mean power below which noise stops no run, W per metre of depth: the power on a rod at rest is rounding."""


class Coupling(Part):
    """Coupling of fluid and rods. Load and scheme follow rules where they are absent (`docs/theory/coupling.md`)."""

    load: Load | None = None
    """Load of the fluid on the rod. Absent: `momentum` where the rod is heavy enough and the fluid makes one step
    between two exchanges, otherwise `pressure_jump`."""

    scheme: CouplingScheme | None = None
    """Order of the steps of both units within a communication step. Absent: `explicit` with the load `momentum`,
    `iterated` with `pressure_jump`."""

    axial_pressure_strain: Flag = False
    """Whether the pressure around the rod also strains it along its axis. The load `momentum` knows only differences of
    the pressure; here its zero is the mean over the outlet, the upstream end of the inflow zone. Needs that load, an
    inflow and a material in plane strain, and costs the fluid three transforms per step."""

    guards: Guards | None = None
    """Limits that stop an unstable explicit run. Absent: the defaults where both units are nervure's, none with a
    foreign unit."""


class PublishedQuantity(Part):
    """Published values of one series over whole periods of its final state."""

    unit: str
    """Unit of `mean` and `amplitude`, the same as of the series: `m`, of a force `N/m`."""

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
    """Difference of largest and smallest lift coefficient."""

    st: Real | None = None
    """Strouhal number."""

    dp_mean: Real | None = None
    """Pressure difference between front and back of the cylinder, Pa."""


class PublishedRange(Part):
    """Smallest and largest published value of one series."""

    unit: str
    """Unit of `mean` and `amplitude`, the same as of the series."""

    mean: tuple[Real, Real] | None = None
    """Range of the mean, in `unit`."""

    amplitude: tuple[Real, Real] | None = None
    """Range of the amplitude, in `unit`."""

    frequency_hz: tuple[Real, Real] | None = None
    """Range of the frequency, Hz."""


class PublishedSpread(Part):
    """Range of several sources."""

    source: str
    """Sources of the values."""

    quantities: dict[str, PublishedRange]
    """Ranges by the name of the recorded series, as in `reference.quantities`."""


class Reference(Part):
    """Published values for comparison with a run; the units do not read them."""

    source: str
    """Source of the values: author, year, and table or page."""

    quantities: dict[str, PublishedQuantity] = Field(default_factory=dict)
    """Values by the name of the recorded series: `tip_ux`, `tip_uy`, `tip_uz`, `drag`, `lift`; of a body on springs
    `body_1_y`."""

    coefficients: PublishedCoefficients | None = None
    """Published coefficients of one still cylinder in an inflow; absent for other scenes."""

    spread: PublishedSpread | None = None
    """Range of several sources; absent where there is one."""


class Scene(Part):
    """A whole scene: at least a fluid, a rod or a wing."""

    json_schema: str | None = Field(None, alias="$schema")
    """Place of the JSON Schema of this file, for editors."""

    format: Integer = 2
    """Number of the format that the file follows; absent, it is the present one, 2."""

    name: str
    """Name of the units and the result folder: at most 100 letters, digits, `.`, `_` and `-`, the first one a letter, a
    digit or `_`."""

    description: str = ""
    """One sentence for people."""

    display: Display | None = None
    """Names of the units of length and time in pictures; absent where they are metres and seconds."""

    time: Time
    """Clock of the co-simulation."""

    fluid: Fluid | None = None
    """The fluid; absent in a rod-only scene."""

    beam: Beam | None = None
    """Geometry of the only beam; absent without one."""

    rod: Rod | None = None
    """Elastic model of the only beam; absent for a rigid beam."""

    rods: list[NamedRod] = Field(default_factory=list)
    """Several beams in the fluid, each with a rod that is a unit of its own: at least two, in place of `beam` and
    `rod`."""

    this_rod: str | None = None
    """Name of one of `rods`, in the scene that the unit of this rod carries; absent elsewhere."""

    wing: Wing | None = None
    """An elastic wing in space, alone or in a fluid of three dimensions."""

    coupling: Coupling | None = None
    """Coupling of fluid and rods; absent where the rules choose it, and without both."""

    reference: Reference | None = None
    """Published values for comparison with a run; absent where there are none."""
