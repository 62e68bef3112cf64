//! What differs between the plane and space. Everything else of the crate is written once, over the number D of
//! dimensions.
//!
//! In the plane an angular velocity, a moment and the vorticity are numbers, in space they are vectors.

use std::array::from_fn;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use line_fft::{Arithmetic, Real};
use nalgebra::{Matrix3, Rotation3, SVector, Unit, Vector2, Vector3};
use serde::{Serialize, de::DeserializeOwned};

/// A vector.
pub type Vector<const D: usize> = SVector<f64, D>;

/// An angle, an angular velocity or a moment: a number in the plane, positive to the left; a vector in space.
pub type Spin<const D: usize> = <[f64; D] as Space<D>>::Spin;

/// A turn about an axis in space.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Axis, of any length above 0.
    pub axis: [f64; 3],
    /// Angle, rad, positive by the right-hand rule.
    pub angle: f64,
}

impl Default for Turn {
    /// No turn.
    fn default() -> Self {
        Self { axis: [0.0, 0.0, 1.0], angle: 0.0 }
    }
}

/// Components along the freedoms of a rigid body: along each axis, then about z in the plane or each axis in space.
/// Those that a dimension lacks are 0.
pub type Freedoms = [f64; 6];

mod sealed {
    pub trait Sealed {}
    impl Sealed for [f64; 2] {}
    impl Sealed for [f64; 3] {}
}

/// A number of dimensions; the crate implements it for two and three, of the coordinates of a point.
pub trait Space<const D: usize>:
    sealed::Sealed + Copy + Debug + Default + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static
{
    /// Number of components of the vorticity.
    const VORTICITY: usize;
    /// Number of freedoms of a rigid body.
    const FREEDOMS: usize;

    /// See [`Spin`].
    type Spin: Copy
        + Debug
        + Default
        + PartialEq
        + Serialize
        + DeserializeOwned
        + Send
        + Sync
        + Add<Output = Self::Spin>
        + AddAssign
        + Sub<Output = Self::Spin>
        + Neg<Output = Self::Spin>
        + Mul<f64, Output = Self::Spin>
        + Div<f64, Output = Self::Spin>;
    /// How a body at rest is turned against the domain.
    type Turn: Clone + Debug + Default + Send + Sync;
    /// Turns the axes of a body to those of the domain.
    type Orientation: Copy + Send + Sync;
    /// Moments of inertia about the centroid, in the axes of a body, kg m² or for a density of 1.
    type Inertia: Copy + Debug + Send + Sync + Mul<f64, Output = Self::Inertia>;
    /// Grid points around a point with their weights in a linear interpolation.
    type Corners: Copy + Debug + AsRef<[(usize, f64)]> + Send + Sync;

    /// Return a × b.
    fn cross(a: &Vector<D>, b: &Vector<D>) -> Self::Spin;

    /// Return spin × arm: the velocity that a rotation gives a point.
    fn swing(spin: Self::Spin, arm: &Vector<D>) -> Vector<D>;

    /// Return the part of a rotation that moves along a surface what is off the surface: `n × (spin × n)`.
    fn along(spin: Self::Spin, normal: &Vector<D>) -> Self::Spin;

    /// Return, for each axis, the square of its part along a surface.
    fn squares_along(normal: &Vector<D>) -> Vector<D>;

    /// Return the components about the axes; in the plane the first one is about z.
    fn components(spin: Self::Spin) -> [f64; 3];

    /// Return the spin of such components.
    fn spin(components: [f64; 3]) -> Self::Spin;

    /// Return such a component, to be set.
    fn component_mut(spin: &mut Self::Spin, component: usize) -> &mut f64;

    /// Return the angle that a pose at rest begins with.
    fn angle_at_rest(turn: &Self::Turn) -> Self::Spin;

    /// Return the orientation of a body with an angle: in the plane that from the x axis, in space the rotation vector
    /// from its orientation at rest.
    fn orientation(turn: &Self::Turn, angle: Self::Spin) -> Self::Orientation;

    /// Turn a vector of a body to the axes of the domain.
    fn turn(orientation: &Self::Orientation, own: Vector<D>) -> Vector<D>;

    /// Turn a vector of the domain to the axes of a body.
    fn turn_back(orientation: &Self::Orientation, vector: Vector<D>) -> Vector<D>;

    /// Return angle and angular velocity after a further rotation by an angle that has a rate.
    fn turned(turn: (Self::Spin, Self::Spin), angle: Self::Spin, rate: Self::Spin) -> (Self::Spin, Self::Spin);

    /// Return the rate at which an angle (see [`Self::orientation`]) grows with an angular velocity.
    fn angle_rate(angle: Self::Spin, omega: Self::Spin) -> Self::Spin;

    /// Return the angular momentum about the centroid.
    fn angular_momentum(orientation: &Self::Orientation, inertia: Self::Inertia, omega: Self::Spin) -> Self::Spin;

    /// Return the moments of inertia of a mass about a point at `arm` from its centroid.
    fn shifted(inertia: Self::Inertia, mass: f64, arm: &Vector<D>) -> Self::Inertia;

    /// Return the moments of inertia about principal axes, which are those of the body; in the plane the last one is that
    /// about z.
    fn inertia(about: [f64; 3]) -> Self::Inertia;

    /// Return the moments of inertia about the axes of the body; in the plane the first one is about z.
    fn diagonal(inertia: Self::Inertia) -> [f64; 3];

    /// Return the moments of inertia about the axes of the domain, as a matrix whose first entry in the plane is that
    /// about z.
    fn inertia_matrix(orientation: &Self::Orientation, inertia: Self::Inertia) -> [[f64; 3]; 3];

    /// Return the velocity of a point with the freedoms of a body, for each axis: `one` along an axis, and that of a
    /// rotation at `arm`.
    fn jacobian(one: f64, arm: [f64; D]) -> [Freedoms; D];

    /// Return all combinations of the two points along each axis with the products of their weights, as indices of a grid
    /// with so many `cells`.
    fn corners(along: [[(usize, f64); 2]; D], cells: &[usize; D]) -> Self::Corners;

    /// Return `r − e omega × u`.
    fn subtract_advection<V: Copy>(on: impl Lanes<V>, r: [V; D], e: V, omega: [V; 3], u: [V; D]) -> [V; D];
}

/// Arithmetic of numbers or of vectors of numbers.
pub trait Lanes<V>: Copy {
    /// Return a + b.
    fn add(self, a: V, b: V) -> V;
    /// Return a − b.
    fn sub(self, a: V, b: V) -> V;
    /// Return a b.
    fn mul(self, a: V, b: V) -> V;
}

/// Arithmetic of one number.
#[derive(Clone, Copy)]
pub struct Scalar;

impl Lanes<f64> for Scalar {
    #[inline(always)]
    fn add(self, a: f64, b: f64) -> f64 {
        a + b
    }

    #[inline(always)]
    fn sub(self, a: f64, b: f64) -> f64 {
        a - b
    }

    #[inline(always)]
    fn mul(self, a: f64, b: f64) -> f64 {
        a * b
    }
}

/// Arithmetic of vectors of `f64`.
#[derive(Clone, Copy)]
pub struct Wide<A>(pub A);

impl<A: Arithmetic<f64>> Lanes<<f64 as Real>::Vector> for Wide<A> {
    #[inline(always)]
    fn add(self, a: <f64 as Real>::Vector, b: <f64 as Real>::Vector) -> <f64 as Real>::Vector {
        self.0.add(a, b)
    }

    #[inline(always)]
    fn sub(self, a: <f64 as Real>::Vector, b: <f64 as Real>::Vector) -> <f64 as Real>::Vector {
        self.0.sub(a, b)
    }

    #[inline(always)]
    fn mul(self, a: <f64 as Real>::Vector, b: <f64 as Real>::Vector) -> <f64 as Real>::Vector {
        self.0.mul(a, b)
    }
}

/// Return the components along the freedoms of a vector and a spin.
pub fn join<const D: usize>(vector: &Vector<D>, spin: Spin<D>) -> Freedoms
where
    [f64; D]: Space<D>,
{
    let about = <[f64; D]>::components(spin);
    from_fn(|i| if i < D { vector[i] } else { about.get(i - D).copied().unwrap_or(0.0) })
}

/// Return the vector and the spin of components along the freedoms.
pub fn split<const D: usize>(freedoms: &Freedoms) -> (Vector<D>, Spin<D>)
where
    [f64; D]: Space<D>,
{
    let about = from_fn(|i| freedoms.get(D + i).copied().unwrap_or(0.0));
    (Vector::from_fn(|axis, _| freedoms[axis]), <[f64; D]>::spin(about))
}

impl Space<2> for [f64; 2] {
    const VORTICITY: usize = 1;
    const FREEDOMS: usize = 3;

    type Spin = f64;
    type Turn = f64;
    /// Sine and cosine of the angle.
    type Orientation = (f64, f64);
    type Inertia = f64;
    type Corners = [(usize, f64); 4];

    #[inline(always)]
    fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
        a[0] * b[1] - a[1] * b[0]
    }

    #[inline(always)]
    fn swing(spin: f64, arm: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(-spin * arm[1], spin * arm[0])
    }

    #[inline(always)]
    fn along(spin: f64, _: &Vector2<f64>) -> f64 {
        spin
    }

    #[inline(always)]
    fn squares_along(normal: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(normal[1].powi(2), normal[0].powi(2))
    }

    #[inline(always)]
    fn components(spin: f64) -> [f64; 3] {
        [spin, 0.0, 0.0]
    }

    #[inline(always)]
    fn spin([about_z, ..]: [f64; 3]) -> f64 {
        about_z
    }

    fn component_mut(spin: &mut f64, _: usize) -> &mut f64 {
        spin
    }

    fn angle_at_rest(turn: &f64) -> f64 {
        *turn
    }

    fn orientation(_: &f64, angle: f64) -> (f64, f64) {
        angle.sin_cos()
    }

    #[inline(always)]
    fn turn(&(sin, cos): &(f64, f64), own: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(cos * own[0] - sin * own[1], cos * own[1] + sin * own[0])
    }

    #[inline(always)]
    fn turn_back(&(sin, cos): &(f64, f64), vector: Vector2<f64>) -> Vector2<f64> {
        Vector2::new(cos * vector[0] + sin * vector[1], cos * vector[1] - sin * vector[0])
    }

    fn turned((before, omega): (f64, f64), angle: f64, rate: f64) -> (f64, f64) {
        (before + angle, omega + rate)
    }

    fn angle_rate(_: f64, omega: f64) -> f64 {
        omega
    }

    fn angular_momentum(_: &(f64, f64), inertia: f64, omega: f64) -> f64 {
        inertia * omega
    }

    fn shifted(inertia: f64, mass: f64, arm: &Vector2<f64>) -> f64 {
        inertia + mass * (arm[0] * arm[0] + arm[1] * arm[1])
    }

    fn inertia([_, _, about_z]: [f64; 3]) -> f64 {
        about_z
    }

    fn diagonal(inertia: f64) -> [f64; 3] {
        [inertia, 0.0, 0.0]
    }

    fn inertia_matrix(_: &(f64, f64), inertia: f64) -> [[f64; 3]; 3] {
        [[inertia, 0.0, 0.0], [0.0; 3], [0.0; 3]]
    }

    #[inline(always)]
    fn jacobian(one: f64, [x, y]: [f64; 2]) -> [Freedoms; 2] {
        [[one, 0.0, -y, 0.0, 0.0, 0.0], [0.0, one, x, 0.0, 0.0, 0.0]]
    }

    #[inline(always)]
    fn corners(
        [[(i0, a0), (i1, a1)], [(j0, b0), (j1, b1)]]: [[(usize, f64); 2]; 2],
        &[_, ny]: &[usize; 2],
    ) -> Self::Corners {
        [(i0 * ny + j0, a0 * b0), (i0 * ny + j1, a0 * b1), (i1 * ny + j0, a1 * b0), (i1 * ny + j1, a1 * b1)]
    }

    #[inline(always)]
    fn subtract_advection<V: Copy>(
        on: impl Lanes<V>,
        [x, y]: [V; 2],
        e: V,
        [omega, ..]: [V; 3],
        [u, v]: [V; 2],
    ) -> [V; 2] {
        [on.add(x, on.mul(e, on.mul(omega, v))), on.sub(y, on.mul(e, on.mul(omega, u)))]
    }
}

impl Space<3> for [f64; 3] {
    const VORTICITY: usize = 3;
    const FREEDOMS: usize = 6;

    type Spin = Vector3<f64>;
    type Turn = Turn;
    type Orientation = Matrix3<f64>;
    type Inertia = Matrix3<f64>;
    type Corners = [(usize, f64); 8];

    #[inline(always)]
    fn cross(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        a.cross(b)
    }

    #[inline(always)]
    fn swing(spin: Vector3<f64>, arm: &Vector3<f64>) -> Vector3<f64> {
        spin.cross(arm)
    }

    #[inline(always)]
    fn along(spin: Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
        spin - spin.dot(normal) * normal
    }

    #[inline(always)]
    fn squares_along(normal: &Vector3<f64>) -> Vector3<f64> {
        normal.map(|across| 1.0 - across * across)
    }

    #[inline(always)]
    fn components(spin: Vector3<f64>) -> [f64; 3] {
        spin.into()
    }

    #[inline(always)]
    fn spin(components: [f64; 3]) -> Vector3<f64> {
        components.into()
    }

    fn component_mut(spin: &mut Vector3<f64>, component: usize) -> &mut f64 {
        &mut spin[component]
    }

    fn angle_at_rest(_: &Turn) -> Vector3<f64> {
        Vector3::zeros()
    }

    fn orientation(turn: &Turn, angle: Vector3<f64>) -> Matrix3<f64> {
        let at_rest = Rotation3::from_axis_angle(&Unit::new_normalize(turn.axis.into()), turn.angle);
        (Rotation3::new(angle) * at_rest).into_inner()
    }

    #[inline(always)]
    fn turn(orientation: &Matrix3<f64>, own: Vector3<f64>) -> Vector3<f64> {
        orientation * own
    }

    #[inline(always)]
    fn turn_back(orientation: &Matrix3<f64>, vector: Vector3<f64>) -> Vector3<f64> {
        orientation.tr_mul(&vector)
    }

    fn turned(
        (before, omega): (Vector3<f64>, Vector3<f64>),
        angle: Vector3<f64>,
        rate: Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let by = Rotation3::new(angle);
        let angle = if before == Vector3::zeros() { angle } else { (by * Rotation3::new(before)).scaled_axis() };
        (angle, by * omega + rate)
    }

    /// The inverse of the left Jacobian of rotations: `omega − ½ θ × omega + c θ × (θ × omega)`.
    fn angle_rate(angle: Vector3<f64>, omega: Vector3<f64>) -> Vector3<f64> {
        let size = angle.norm();
        // 1/θ² − (1 + cos θ)/(2 θ sin θ), by its series near 0.
        let c = if size < 1e-3 {
            1.0 / 12.0 + size * size / 720.0
        } else {
            1.0 / (size * size) - (1.0 + size.cos()) / (2.0 * size * size.sin())
        };
        let turned = angle.cross(&omega);
        omega - 0.5 * turned + c * angle.cross(&turned)
    }

    fn angular_momentum(orientation: &Matrix3<f64>, inertia: Matrix3<f64>, omega: Vector3<f64>) -> Vector3<f64> {
        orientation * (inertia * orientation.tr_mul(&omega))
    }

    fn shifted(inertia: Matrix3<f64>, mass: f64, arm: &Vector3<f64>) -> Matrix3<f64> {
        inertia + mass * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose())
    }

    fn inertia(about: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&about.into())
    }

    fn diagonal(inertia: Matrix3<f64>) -> [f64; 3] {
        inertia.diagonal().into()
    }

    fn inertia_matrix(orientation: &Matrix3<f64>, inertia: Matrix3<f64>) -> [[f64; 3]; 3] {
        (orientation * inertia * orientation.transpose()).transpose().into()
    }

    #[inline(always)]
    fn jacobian(one: f64, [x, y, z]: [f64; 3]) -> [Freedoms; 3] {
        [[one, 0.0, 0.0, 0.0, z, -y], [0.0, one, 0.0, -z, 0.0, x], [0.0, 0.0, one, y, -x, 0.0]]
    }

    #[inline(always)]
    fn corners(along: [[(usize, f64); 2]; 3], &[_, ny, nz]: &[usize; 3]) -> Self::Corners {
        from_fn(|n| {
            let [(i, a), (j, b), (k, c)] = [along[0][n / 4], along[1][n / 2 % 2], along[2][n % 2]];
            ((i * ny + j) * nz + k, a * b * c)
        })
    }

    #[inline(always)]
    fn subtract_advection<V: Copy>(on: impl Lanes<V>, r: [V; 3], e: V, omega: [V; 3], u: [V; 3]) -> [V; 3] {
        let n = [
            on.sub(on.mul(omega[1], u[2]), on.mul(omega[2], u[1])),
            on.sub(on.mul(omega[2], u[0]), on.mul(omega[0], u[2])),
            on.sub(on.mul(omega[0], u[1]), on.mul(omega[1], u[0])),
        ];
        [on.sub(r[0], on.mul(e, n[0])), on.sub(r[1], on.mul(e, n[1])), on.sub(r[2], on.mul(e, n[2]))]
    }
}
