//! Shear of the section, in the plane: a shear spring GA_s/l0 in every segment, in series with the springs of bending.
//!
//! With M_v the bending moment at the vertex v and Q = (M_v − M_{v−1})/l0 the shear force in a segment, the turning angle between two
//! segments is that of the section and the difference of what the two segments shear,
//!
//! ```text
//! κ_v − κ0_v = M_v/k_v + (M_v − M_{v−1}) c_{v−1} + (M_v − M_{v+1}) c_v,   c = 1/(GA_s l0)      (A M = κ − κ0),
//! ```
//!
//! with M = 0 at the tip and no segment before the root, and the energy is ½ M·A M: Timoshenko's beam (1921) with a section that has no inertia against turning. A is tridiagonal and
//! positive, so M and the energy follow from the shape by one sweep. In Newton's matrix, where ∂²U/∂x∂x = Bᵀ A⁻¹ B + Σ M_v ∂²κ_v
//! would be full, the moments stay unknowns: −A in their rows, B = ∂κ/∂x beside it.

/// A = L D Lᵀ.
pub(crate) struct Shear {
    /// Diagonal of A: `[n]`.
    diagonal: Vec<f64>,
    /// Entries beside the diagonal, with the vertex after each: `[n]`.
    beside: Vec<f64>,
    /// 1/D: `[n]`.
    inverse_pivots: Vec<f64>,
    /// Stiffest spring of bending, N m: no entry of A⁻¹ is above it.
    pub(crate) stiffest: f64,
}

impl Shear {
    /// For segments of the length `l0` (m) with the springs `bending` (N m) at their beginnings, `[n]`, and the shear
    /// stiffness GA_s (N) of each. A first spring of 0 is none: its moment stays 0 and couples to nothing.
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

    /// Put another spring in place of the first one.
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

    /// Entries of A in the column of vertex `v`, on the diagonal and below.
    pub(crate) fn column(&self, v: usize) -> [f64; 2] {
        [self.diagonal[v], self.beside[v]]
    }

    /// Energy of the vertex `v` in ½ y·D⁻¹ y, L y = κ − κ0, from `turn`, its κ − κ0, and y of the vertex before, which
    /// becomes that of this one.
    pub(crate) fn energy(&self, v: usize, turn: f64, y: &mut f64) -> f64 {
        *y = self.forward(v, turn, *y);
        0.5 * *y * *y * self.inverse_pivots[v]
    }

    /// Turn κ − κ0, `[n]`, into the moments, N m.
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
