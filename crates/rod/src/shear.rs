//! Shear of the section in the plane: a shear spring GA_s/l0 in each segment, in series with the springs of bending.
//!
//! With the bending moment M_v at the vertex v, the shear force in a segment is Q = (M_v − M_{v−1})/l0. The angle
//! between two segments is the turning angle of the section plus the difference of the shear angles of both segments:
//!
//! ```text
//! κ_v − κ0_v = M_v/k_v + (M_v − M_{v−1}) c_{v−1} + (M_v − M_{v+1}) c_v,   c = 1/(GA_s l0)      (A M = κ − κ0).
//! ```
//!
//! M is 0 at the tip, no segment precedes the root, and the energy is ½ M·A M: the beam of Timoshenko (1921) without
//! rotational inertia of the section. A is tridiagonal and positive definite, so one sweep gives M and the energy. The
//! matrix ∂²U/∂x∂x = Bᵀ A⁻¹ B + Σ M_v ∂²κ_v, B = ∂κ/∂x, would be full. Newton's matrix therefore keeps the moments as
//! unknowns, with the rows (B, −A).

/// Factors A = L D Lᵀ.
pub(crate) struct Shear {
    /// Diagonal of A: `[n]`.
    diagonal: Vec<f64>,
    /// Couplings with the next vertex: `[n]`.
    beside: Vec<f64>,
    /// 1/D: `[n]`.
    inverse_pivots: Vec<f64>,
    /// Stiffest spring of bending, N m: an upper bound of the entries of A⁻¹.
    pub(crate) stiffest: f64,
}

impl Shear {
    /// Return A for segments of the length `l0` (m) with the springs `bending` (N m) at their beginnings, `[n]`, and
    /// the shear stiffness GA_s (N) of each segment.
    ///
    /// The moment of a first spring of 0 is always 0 and couples to nothing.
    pub(crate) fn new(l0: f64, bending: &[f64], shear_stiffness: impl Fn(usize) -> f64) -> Self {
        let mut beside: Vec<_> = (0..bending.len()).map(|j| -1.0 / (shear_stiffness(j) * l0)).collect();
        let mut diagonal: Vec<_> = bending
            .iter()
            .enumerate()
            .map(|(v, bending)| 1.0 / bending - if v == 0 { beside[0] } else { beside[v - 1] + beside[v] })
            .collect();
        if bending[0] == 0.0 {
            (diagonal[0], beside[0]) = (1.0 / bending[1], 0.0);
        }
        let stiffest = bending.iter().fold(0.0, |stiffest: f64, spring| stiffest.max(*spring));
        let mut shear = Self { inverse_pivots: diagonal.clone(), diagonal, beside, stiffest };
        shear.factorise();
        shear
    }

    /// Replace the first spring.
    pub(crate) fn set_root(&mut self, spring: f64) {
        self.diagonal[0] = 1.0 / spring - self.beside[0];
        self.factorise();
    }

    fn factorise(&mut self) {
        let (mut before, mut coupling) = (0.0, 0.0);
        for ((inverse, entry), beside) in self.inverse_pivots.iter_mut().zip(&self.diagonal).zip(&self.beside) {
            before = 1.0 / (entry - coupling * coupling * before);
            coupling = *beside;
            *inverse = before;
        }
    }

    /// Return the entries of A in the column of vertex `v`, on the diagonal and below.
    pub(crate) fn column(&self, v: usize) -> [f64; 2] {
        [self.diagonal[v], self.beside[v]]
    }

    /// Return the energy of the vertex `v` in ½ y·D⁻¹ y, L y = κ − κ0, for its `turn` κ − κ0.
    ///
    /// `y` is the entry of the vertex before and becomes the entry of `v`.
    pub(crate) fn energy(&self, v: usize, turn: f64, y: &mut f64) -> f64 {
        *y = self.forward(v, turn, *y);
        0.5 * *y * *y * self.inverse_pivots[v]
    }

    /// Replace κ − κ0, `[n]`, by the moments, N m.
    pub(crate) fn solve(&self, turns: &mut [f64]) {
        let mut y = 0.0;
        for (v, turn) in turns.iter_mut().enumerate() {
            y = self.forward(v, *turn, y);
            *turn = y;
        }
        let mut moment = 0.0;
        for ((y, inverse), beside) in turns.iter_mut().zip(&self.inverse_pivots).zip(&self.beside).rev() {
            moment = (*y - beside * moment) * inverse;
            *y = moment;
        }
    }

    fn forward(&self, v: usize, turn: f64, y: f64) -> f64 {
        if v == 0 { turn } else { turn - self.beside[v - 1] * self.inverse_pivots[v - 1] * y }
    }
}
