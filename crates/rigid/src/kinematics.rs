//! Motion of rigid bodies in the plane and in space.
//!
//! In the plane an angle, an angular velocity and a moment are numbers, in space they are vectors.

use std::array::from_fn;
use std::f64::consts::TAU;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use nalgebra::{Matrix3, Rotation3, SVector, Unit, Vector2, Vector3};
use serde::{Serialize, de::DeserializeOwned};

/// A vector.
pub type Vector<const D: usize> = SVector<f64, D>;

/// An angle, an angular velocity or a moment: a number in the plane, positive to the left; a vector in space.
pub type Spin<const D: usize> = <[f64; D] as Kinematics<D>>::Spin;

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

/// Kinematics of a rigid body in a number of dimensions; the crate implements them for two and three, of the coordinates
/// of a point.
pub trait Kinematics<const D: usize>:
    sealed::Sealed + Copy + Debug + Default + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static
{
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

    /// Return a × b.
    fn cross(a: &Vector<D>, b: &Vector<D>) -> Self::Spin;

    /// Return spin × arm: the velocity that a rotation gives a point.
    fn swing(spin: Self::Spin, arm: &Vector<D>) -> Vector<D>;

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
}

/// Return the components along the freedoms of a vector and a spin.
pub fn join<const D: usize>(vector: &Vector<D>, spin: Spin<D>) -> Freedoms
where
    [f64; D]: Kinematics<D>,
{
    let about = <[f64; D]>::components(spin);
    from_fn(|i| if i < D { vector[i] } else { about.get(i - D).copied().unwrap_or(0.0) })
}

/// Return the vector and the spin of components along the freedoms.
pub fn split<const D: usize>(freedoms: &Freedoms) -> (Vector<D>, Spin<D>)
where
    [f64; D]: Kinematics<D>,
{
    let about = from_fn(|i| freedoms.get(D + i).copied().unwrap_or(0.0));
    (Vector::from_fn(|axis, _| freedoms[axis]), <[f64; D]>::spin(about))
}

/// Return the rotation vector of the same turn as `angle` that is nearest to the one `before`.
pub fn nearest(angle: Vector3<f64>, before: &Vector3<f64>) -> Vector3<f64> {
    let size = angle.norm();
    if size == 0.0 {
        return angle;
    }
    let axis = angle / size;
    let turns = ((before.dot(&axis) - size) / TAU).round();
    axis * (size + turns * TAU)
}

impl Kinematics<2> for [f64; 2] {
    const FREEDOMS: usize = 3;
    type Spin = f64;
    type Turn = f64;
    /// Sine and cosine of the angle.
    type Orientation = (f64, f64);
    type Inertia = f64;

    #[inline(always)]
    fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
        a[0] * b[1] - a[1] * b[0]
    }

    #[inline(always)]
    fn swing(spin: f64, arm: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(-spin * arm[1], spin * arm[0])
    }

    #[inline(always)]
    fn components(spin: f64) -> [f64; 3] {
        [spin, 0.0, 0.0]
    }

    #[inline(always)]
    fn spin([about_z, ..]: [f64; 3]) -> f64 {
        about_z
    }

    #[inline]
    fn component_mut(spin: &mut f64, _: usize) -> &mut f64 {
        spin
    }

    #[inline]
    fn angle_at_rest(turn: &f64) -> f64 {
        *turn
    }

    #[inline]
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

    #[inline]
    fn turned((before, omega): (f64, f64), angle: f64, rate: f64) -> (f64, f64) {
        (before + angle, omega + rate)
    }

    #[inline]
    fn angle_rate(_: f64, omega: f64) -> f64 {
        omega
    }

    #[inline]
    fn angular_momentum(_: &(f64, f64), inertia: f64, omega: f64) -> f64 {
        inertia * omega
    }

    #[inline]
    fn shifted(inertia: f64, mass: f64, arm: &Vector2<f64>) -> f64 {
        inertia + mass * (arm[0] * arm[0] + arm[1] * arm[1])
    }

    #[inline]
    fn inertia([_, _, about_z]: [f64; 3]) -> f64 {
        about_z
    }

    #[inline]
    fn diagonal(inertia: f64) -> [f64; 3] {
        [inertia, 0.0, 0.0]
    }

    #[inline]
    fn inertia_matrix(_: &(f64, f64), inertia: f64) -> [[f64; 3]; 3] {
        [[inertia, 0.0, 0.0], [0.0; 3], [0.0; 3]]
    }

    #[inline(always)]
    fn jacobian(one: f64, [x, y]: [f64; 2]) -> [Freedoms; 2] {
        [[one, 0.0, -y, 0.0, 0.0, 0.0], [0.0, one, x, 0.0, 0.0, 0.0]]
    }
}

impl Kinematics<3> for [f64; 3] {
    const FREEDOMS: usize = 6;
    type Spin = Vector3<f64>;
    type Turn = Turn;
    type Orientation = Matrix3<f64>;
    type Inertia = Matrix3<f64>;

    #[inline(always)]
    fn cross(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        a.cross(b)
    }

    #[inline(always)]
    fn swing(spin: Vector3<f64>, arm: &Vector3<f64>) -> Vector3<f64> {
        spin.cross(arm)
    }

    #[inline(always)]
    fn components(spin: Vector3<f64>) -> [f64; 3] {
        spin.into()
    }

    #[inline(always)]
    fn spin(components: [f64; 3]) -> Vector3<f64> {
        components.into()
    }

    #[inline]
    fn component_mut(spin: &mut Vector3<f64>, component: usize) -> &mut f64 {
        &mut spin[component]
    }

    #[inline]
    fn angle_at_rest(_: &Turn) -> Vector3<f64> {
        Vector3::zeros()
    }

    #[inline]
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

    #[inline]
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
    #[inline]
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

    #[inline]
    fn angular_momentum(orientation: &Matrix3<f64>, inertia: Matrix3<f64>, omega: Vector3<f64>) -> Vector3<f64> {
        orientation * (inertia * orientation.tr_mul(&omega))
    }

    #[inline]
    fn shifted(inertia: Matrix3<f64>, mass: f64, arm: &Vector3<f64>) -> Matrix3<f64> {
        inertia + mass * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose())
    }

    #[inline]
    fn inertia(about: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&about.into())
    }

    #[inline]
    fn diagonal(inertia: Matrix3<f64>) -> [f64; 3] {
        inertia.diagonal().into()
    }

    #[inline]
    fn inertia_matrix(orientation: &Matrix3<f64>, inertia: Matrix3<f64>) -> [[f64; 3]; 3] {
        (orientation * inertia * orientation.transpose()).transpose().into()
    }

    #[inline(always)]
    fn jacobian(one: f64, [x, y, z]: [f64; 3]) -> [Freedoms; 3] {
        [[one, 0.0, 0.0, 0.0, z, -y], [0.0, one, 0.0, -z, 0.0, x], [0.0, 0.0, one, y, -x, 0.0]]
    }
}
