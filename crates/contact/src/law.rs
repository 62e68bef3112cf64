//! Forces of a contact as functions of its gap.

use std::f64::consts::{PI, SQRT_2};
use std::ops::AddAssign;

/// Least number of steps in a contact, for the default stiffness: BDF2 then keeps 97 to 99 % of the speed.
const STEPS: f64 = 10.0;

/// Slip in a step below which friction sticks, relative to the range of the contact: the friction then grows from 0.
const STICK: f64 = 1e-4;

/// Length of rod behind a root that is held near an obstacle, over the distance at which they touch, that does not
/// touch it.
pub const HELD: f64 = 1.5;

/// Return the stiffness (N/m) with which a mass (kg) touches for at least ten steps of `dt` (s): π² m/(10 Δt)².
pub fn largest_stiffness(mass: f64, dt: f64) -> f64 {
    mass * (PI / (STEPS * dt)).powi(2)
}

/// Forces between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Gap at which the penalty begins, m.
    pub range: f64,
    /// Stiffness k at the gap 0, N/m; it grows linearly from 0 at `range`.
    pub stiffness: f64,
    /// Depth d that no force reaches, m: k (d²/3) z³/(1 − z) at the depth z d adds to the spring; infinite for a spring
    /// alone.
    pub depth: f64,
    /// Damping c of the gap, kg/s; it grows like the stiffness.
    pub damping: f64,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Fluid between the surfaces; `None` without.
    pub film: Option<Film>,
}

/// Film of a viscous fluid, with the force −c h' (1/hᵖ − 1/rᵖ) at a gap h below the range r: what lubrication theory has
/// beyond the force that a grid finds, which keeps its value at the range (Nguyen & Ladd 2002).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// c, N s mᵖ⁻¹: in a fluid of viscosity η (Pa s) 6 π η R² of a ball of radius R at a wall.
    pub coefficient: f64,
    /// p.
    pub power: FilmPower,
    /// Gap r at which the film begins, m.
    pub range: f64,
    /// Least gap h_min, the roughness: below it the force is that at h_min, and 0 where the surfaces meet, m.
    pub least: f64,
}

/// Power p of the gap in a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmPower {
    /// 1, between balls.
    One,
    /// 3/2, between circles in the plane.
    ThreeHalves,
}

/// Gap at the beginning of a step.
#[derive(Clone, Copy, Debug)]
pub struct Before {
    /// Gap, m.
    pub gap: f64,
    /// Length of the step, s.
    pub dt: f64,
}

/// Potential of a contact with its derivatives by the gap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// Potential, J.
    pub potential: f64,
    /// Force that opens the gap: minus the first derivative, N.
    pub force: f64,
    /// Second derivative, at least 0, N/m.
    pub stiffness: f64,
}

impl AddAssign for Response {
    fn add_assign(&mut self, other: Self) {
        self.potential += other.potential;
        self.force += other.force;
        self.stiffness += other.stiffness;
    }
}

impl Law {
    /// Return the gap from which on there is no force, m.
    pub fn reach(&self) -> f64 {
        self.film.map_or(self.range, |film| film.range.max(self.range))
    }

    /// Return the response of the penalty to the gap `g` (m).
    pub fn penalty(&self, g: f64) -> Response {
        let Self { range, stiffness: k, .. } = *self;
        let overlap = range - g;
        if overlap <= 0.0 {
            Response::default()
        } else if overlap < range {
            let share = overlap / range;
            Response {
                potential: k * overlap * overlap * share / 6.0,
                force: 0.5 * k * overlap * share,
                stiffness: k * share,
            }
        } else {
            let (deep, depth) = (-g, self.depth);
            let mut sum = Response {
                potential: k * (range * range / 6.0 + 0.5 * deep * (range + deep)),
                force: k * (deep + 0.5 * range),
                stiffness: k,
            };
            if deep >= depth {
                sum = Response { potential: f64::INFINITY, force: f64::INFINITY, stiffness: f64::INFINITY };
            } else if depth.is_finite() {
                let (z, left, part) = (deep / depth, 1.0 - deep / depth, k / 3.0);
                sum += Response {
                    potential: part * depth * depth * z.powi(3) / left,
                    force: part * depth * z * z * (3.0 - 2.0 * z) / (left * left),
                    stiffness: part * z * (6.0 - 6.0 * z + 2.0 * z * z) / left.powi(3),
                };
            }
            sum
        }
    }

    /// Return the response to the gap `g` (m) at the end of a step; without a step only the penalty.
    ///
    /// Damper and film exert the mean force of the step, −(Γ(g) − Γ(g_0))/Δt, whose impulse is exact however long the
    /// step is. With the damping c Γ' grows like the stiffness, so Γ = −(c/k) f of the penalty f.
    pub fn response(&self, g: f64, before: Option<Before>) -> Response {
        let mut sum = self.penalty(g);
        let Some(Before { gap, dt }) = before else { return sum };
        if self.damping > 0.0 {
            let (now, then, rate) = (sum, self.penalty(gap), self.damping / (self.stiffness * dt));
            sum += Response {
                potential: rate * (now.potential + then.force * g),
                force: rate * (now.force - then.force),
                stiffness: rate * now.stiffness,
            };
        }
        if let Some(film) = &self.film {
            let (now, then, rate) = (film.impulse(g), film.impulse(gap), film.coefficient / dt);
            sum += Response {
                potential: rate * (now.integral - then.value * g),
                force: rate * (then.value - now.value),
                stiffness: rate * now.slope,
            };
        }
        sum
    }

    /// Return the friction of a contact with the normal force `normal` (N) at the beginning of a step.
    pub fn friction(&self, normal: f64) -> Friction {
        Friction { limit: self.friction * normal, stick: STICK * self.range }
    }
}

/// F, ∫ F dh and F' of a film.
struct Impulse {
    value: f64,
    integral: f64,
    slope: f64,
}

impl Film {
    /// Return the film of a viscosity (Pa s) between balls, or circles in the plane, of which the sum of both curvatures
    /// is 1/`radius`, 1/m, from a gap of `range` (m) on; `least` is the roughness, m. By lubrication theory
    /// c = 6 π η R² with p = 1, in the plane 3 √2 π η R^(3/2) with p = 3/2.
    pub fn between<const D: usize>(viscosity: f64, radius: f64, range: f64, least: f64) -> Self {
        let (coefficient, power) = match D {
            2 => (3.0 * SQRT_2 * PI * viscosity * radius.powf(1.5), FilmPower::ThreeHalves),
            _ => (6.0 * PI * viscosity * radius * radius, FilmPower::One),
        };
        Self { coefficient, power, range, least }
    }

    /// Return F with F' = h^−p − r^−p, of p = 1 F = ln h + 1 − h/r; linear below h_min, constant beyond the range r and
    /// where surfaces meet.
    fn impulse(&self, h: f64) -> Impulse {
        let Self { range, least, .. } = *self;
        // F is linear from a gap on, with a slope.
        let on = |Impulse { value, integral, .. }: Impulse, begin: f64, slope: f64| {
            let way = h - begin;
            Impulse { value: value + slope * way, integral: integral + (value + 0.5 * slope * way) * way, slope }
        };
        if h >= range {
            on(self.pure(range), range, 0.0)
        } else if h >= least {
            self.pure(h)
        } else if h >= 0.0 {
            on(self.pure(least), least, self.pure(least).slope)
        } else {
            on(self.impulse(0.0), 0.0, 0.0)
        }
    }

    fn pure(&self, h: f64) -> Impulse {
        let seen = match self.power {
            FilmPower::One => 1.0 / self.range,
            FilmPower::ThreeHalves => self.range.powf(-1.5),
        };
        let Impulse { value, integral, slope } = match self.power {
            FilmPower::One => Impulse { value: h.ln() + 1.0, integral: h * h.ln(), slope: 1.0 / h },
            FilmPower::ThreeHalves => {
                let root = h.sqrt();
                Impulse { value: -2.0 / root, integral: -4.0 * root, slope: 1.0 / (h * root) }
            }
        };
        Impulse { value: value - seen * h, integral: integral - 0.5 * seen * h * h, slope: slope - seen }
    }
}

/// Friction of a step, the derivative of a convex function of the slip.
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// Largest force μ N_0, N.
    limit: f64,
    /// Slip below which it is smaller, m.
    stick: f64,
}

impl Friction {
    /// Return the potential (J) of a slip (m) in the step, its first derivative over the slip, and its second
    /// derivative (N/m).
    pub fn response(&self, slip: f64) -> [f64; 3] {
        let Self { limit, stick } = *self;
        let share = slip / stick;
        if share < 1.0 {
            let potential = slip * share * (1.0 - share / 3.0);
            [potential, (2.0 - share) / stick, 2.0 * (1.0 - share) / stick].map(|own| limit * own)
        } else {
            [slip - stick / 3.0, 1.0 / slip, 0.0].map(|own| limit * own)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Law = Law {
        range: 0.1,
        stiffness: 200.0,
        depth: 0.08,
        damping: 3.0,
        friction: 0.4,
        film: Some(Film { coefficient: 0.7, power: FilmPower::ThreeHalves, range: 0.3, least: 0.02 }),
    };

    /// Forces are minus the slopes of the potential and stiffnesses those of the force, in all branches.
    #[test]
    fn forces_are_slopes_of_convex_potentials() {
        for (g, gap) in
            [(0.4, 0.2), (0.25, 0.4), (0.07, 0.12), (0.013, 0.05), (-0.03, 0.01), (-0.03, -0.06), (-0.07, 0.0)]
        {
            let at = |g: f64| LAW.response(g, Some(Before { gap, dt: 0.01 }));
            let (step, own) = (1e-6, at(g));
            let slope = (at(g - step).potential - at(g + step).potential) / (2.0 * step);
            let stiffness = (at(g - step).force - at(g + step).force) / (2.0 * step);
            assert!((own.force - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{g}: {} against {slope}", own.force);
            assert!((own.stiffness - stiffness).abs() < 1e-5 * (1.0 + stiffness), "{g}: {stiffness} against {own:?}");
            assert!(own.stiffness >= 0.0, "{g}: {own:?}");
        }
        let friction = LAW.friction(5.0);
        for slip in [2e-6, 8e-6, 3e-5] {
            let [[_, secant, second], step] = [friction.response(slip), [1e-10; 3]];
            let slope = |i: usize| {
                let by = |y: f64| [friction.response(y)[0], friction.response(y)[1] * y][i];
                (by(slip + step[0]) - by(slip - step[0])) / (2.0 * step[0])
            };
            assert!((secant * slip - slope(0)).abs() < 1e-5, "{slip}: {} against {}", secant * slip, slope(0));
            assert!(
                (second - slope(1)).abs() < 1e-5 * LAW.friction * 5.0 / 1e-5,
                "{slip}: {second} against {}",
                slope(1)
            );
        }
        assert_eq!(friction.response(1.0)[1], 2.0, "μ N");
        assert_eq!(LAW.penalty(-LAW.depth).potential, f64::INFINITY);
    }

    #[test]
    fn damper_and_film_only_take_energy() {
        for (k, (g, gap)) in (0..400).map(|k| (k, (f64::from(k % 20) * 0.02 - 0.07, f64::from(k / 20) * 0.02 - 0.07))) {
            let both = LAW.response(g, Some(Before { gap, dt: 0.01 }));
            let power = (both.force - LAW.penalty(g).force) * (g - gap);
            assert!(power <= 1e-12, "{k}: {power} from {gap} to {g}");
        }
    }
}
