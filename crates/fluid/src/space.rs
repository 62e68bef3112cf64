//! What differs between the plane and space. Everything else of the crate is written once, over the number D of
//! dimensions.
//!
//! The vorticity is a number in the plane, and a vector in space; [`rigid`] has the motion of rigid bodies.

use std::array::from_fn;
use std::fmt::Debug;

use line_fft::{Arithmetic, Real};
use nalgebra::{Vector2, Vector3};
use rigid::SpringDynamics;
pub use rigid::{Freedoms, Kinematics, Spin, Turn, Vector, join, split};

/// A number of dimensions; the crate implements it for two and three, of the coordinates of a point.
pub trait Space<const D: usize>: SpringDynamics<D> {
    /// Number of components of the vorticity.
    const VORTICITY: usize;
    /// Grid points around a point with their weights in a linear interpolation.
    type Corners: Copy + Debug + AsRef<[(usize, f64)]> + Send + Sync;

    /// Return the part of a rotation that moves along a surface what is off the surface: `n × (spin × n)`.
    fn along(spin: Self::Spin, normal: &Vector<D>) -> Self::Spin;

    /// Return, for each axis, the square of its part along a surface.
    fn squares_along(normal: &Vector<D>) -> Vector<D>;

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

impl Space<2> for [f64; 2] {
    const VORTICITY: usize = 1;
    type Corners = [(usize, f64); 4];

    #[inline(always)]
    fn along(spin: f64, _: &Vector2<f64>) -> f64 {
        spin
    }

    #[inline(always)]
    fn squares_along(normal: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(normal[1].powi(2), normal[0].powi(2))
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
    type Corners = [(usize, f64); 8];

    #[inline(always)]
    fn along(spin: Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
        spin - spin.dot(normal) * normal
    }

    #[inline(always)]
    fn squares_along(normal: &Vector3<f64>) -> Vector3<f64> {
        normal.map(|across| 1.0 - across * across)
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
