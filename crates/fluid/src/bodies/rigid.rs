//! Rigid bodies, still or moving.
//!
//! A point at `r` from the pivot, whose velocity is v, moves with `v + omega × r`.

use ::contact::MountPush;
use ::rigid::{Mass, Pose, SpringMotion};
use geometry::Region;
use method::Mask;

use super::cells::Cells;
use super::measure::{Measure, Measured, Surface};
use super::pose::{displaced, displacement_at, pose_at};
use crate::force::{Displaced, Force};
use crate::grid::Grid;
use crate::kernel::layer_thickness;
use crate::parameters::{Body, Motion, Mount};
use crate::shapes::{Moments, nearest};
use crate::space::{Freedoms, Kinematics, Space, Vector, join};
use crate::wall::DragProfile;

/// A body and the cells in which it drags the fluid.
pub struct Rigid<const D: usize>
where
    [f64; D]: Space<D>,
{
    body: Body<D>,
    moments: Moments<D>,
    /// Drag in its cells; absent for a thin body, whose markers drag.
    profile: Option<DragProfile>,
    /// Present place and motion.
    pub pose: Pose<D>,
    /// Present orientation.
    pub orientation: <[f64; D] as Kinematics<D>>::Orientation,
    /// Cells at the present place.
    pub cells: Cells<D>,
    /// What the present step found, of a body that it put to a predicted place.
    pub spring_motion: Option<SpringMotion<D>>,
    /// Force of the fluid that its motion on springs in the present step knows.
    pub known: Force<D>,
    /// Whether its cells may be those of another body on springs or with announced loads, in the present step.
    pub shares: bool,
    /// What contact does to it in the coming step.
    pub push: MountPush<D>,
    /// Whether its mount, if it has one, lets it move in the present step.
    is_free: bool,
}

/// Part of a step by which a release may come before its end through rounding.
const ROUNDING: f64 = 1e-6;

impl<const D: usize> Body<D>
where
    [f64; D]: Space<D>,
{
    /// Return the layer of fluid of a density (kg/m³) that moves with a thin body, limited to the inertia of a body on
    /// springs.
    fn limited(&self, layer: Moments<D>, density: f64) -> Moments<D> {
        let Some(mount) = self.mount() else { return layer };
        let (mass, inertia) = layer.about(self.pivot, density);
        let (inertia, own) = (<[f64; D]>::diagonal(inertia), mount.own_inertia());
        let moves = mount.supports[..D].iter().any(Option::is_some);
        let turns = |i: usize| mount.supports[D + i].is_some();
        let arm = layer.centroid - Vector::from(self.pivot);
        let arm = arm.iter().fold(0.0_f64, |length, component| length.hypot(*component));
        let mut share = if moves { (own[0] / mass).min(1.0) } else { 1.0 };
        for i in (0..<[f64; D]>::FREEDOMS - D).filter(|i| turns(*i)) {
            // Largest eigenvalue of the inertia of the layer over its diagonal.
            let largest = if moves { 1.0 + arm * (mass / inertia[i]).sqrt() } else { 1.0 };
            share = share.min(own[D + i] / (inertia[i] * largest));
            if moves {
                share = share.min(own[0] / (mass * largest));
            }
        }
        Moments { volume: share * layer.volume, inertia: layer.inertia * share, ..layer }
    }
}

impl<const D: usize> Rigid<D>
where
    [f64; D]: Space<D>,
{
    /// A body at t = 0.
    pub fn new(body: &Body<D>, grid: &Grid<D>, mask: &Mask, nu: f64, density: f64) -> Self {
        let (body, cell) = (body.clone(), grid.cell_size());
        let moments = body.shape.moments(&grid.size);
        let (moments, profile) = match body.shape.region() {
            Some(region) => {
                (moments, Some(DragProfile::of_body(region.thickness(), body.motion.is_some(), mask, nu, cell)))
            }
            None => {
                let layer = body.shape.layer(layer_thickness(D) * cell).unwrap_or(moments);
                (body.limited(layer, density), None)
            }
        };
        let pose = pose_at(&body, 0.0);
        let orientation = <[f64; D]>::orientation(&body.turn, pose.angle);
        let (cells, push) = (Cells::default(), MountPush::default());
        let is_free = !matches!(body.motion, Some(Motion::Released { .. }));
        let known = Force::default();
        let mut rigid = Self {
            body,
            moments,
            profile,
            pose,
            orientation,
            cells,
            spring_motion: None,
            known,
            shares: false,
            push,
            is_free,
        };
        rigid.place(pose, grid);
        rigid
    }

    /// Take the fluid of a density (kg/m³) around the markers of a thin body, given by their places in its axes (m) with
    /// the volume of each, as the layer that moves with it.
    pub fn set_layer(&mut self, parts: impl Iterator<Item = (Vector<D>, f64)> + Clone, density: f64) {
        let volume: f64 = parts.clone().map(|(_, volume)| volume).sum();
        let centroid = parts.clone().fold(Vector::zeros(), |sum, (place, part)| sum + place * part) / volume;
        let inertia =
            parts.fold(self.moments.inertia, |sum, (place, part)| <[f64; D]>::shifted(sum, part, &(place - centroid)));
        self.moments = self.body.limited(Moments { volume, centroid, inertia }, density);
    }

    /// Return whether the layer that moves with it is that of its markers.
    pub fn has_layer_of_markers(&self) -> bool {
        self.is_thin() && self.body.shape.layer(1.0).is_none()
    }

    /// Return whether it is thin, without cells.
    pub fn is_thin(&self) -> bool {
        self.profile.is_none()
    }

    /// Return whether the master or the fluid moves it, perhaps from a release on, rather than a law at all times.
    pub fn is_carried(&self) -> bool {
        self.is_driven() || self.body.mount().is_some()
    }

    /// Return whether the master moves it.
    pub fn is_driven(&self) -> bool {
        matches!(self.body.motion, Some(Motion::Master))
    }

    /// Return the displacement by the laws of a body that is released, at a time (s), after the release that at it; none
    /// of another body.
    pub fn before_release(&self, time: f64) -> Option<Pose<D>> {
        let Some(Motion::Released { laws, release, .. }) = &self.body.motion else { return None };
        Some(displacement_at(laws, time.min(*release)))
    }

    /// Release it in a step of `dt` seconds to a time (s) if that is after its release, and hold it otherwise.
    pub fn release(&mut self, time: f64, dt: f64) {
        let Some(Motion::Released { release, .. }) = &self.body.motion else { return };
        self.is_free = time > release + ROUNDING * dt;
    }

    /// Return whether its load of the next step is announced.
    pub fn announces(&self) -> bool {
        self.body.announces
    }

    /// Return whether a step puts it to a predicted place, and then changes its velocities.
    pub fn is_predicted(&self) -> bool {
        self.announces() || self.mount().is_some()
    }

    /// Return its springs and dampers, if it is on such in the present step.
    pub fn mount(&self) -> Option<&Mount<D>> {
        self.body.mount().filter(|_| self.is_free)
    }

    /// Let its motion on springs, which was found in a step with the first coefficient `c_0` of the differences, answer a
    /// `force` of the fluid of a density (kg/m³) that differs from the known one, and return the change of its velocities;
    /// none where that is at most the part `rounding` of the velocities.
    pub fn answer(&mut self, force: &Force<D>, c_0: f64, density: f64, rounding: f64) -> Option<Freedoms> {
        let (supports, fluid) = (self.mount()?.supports, self.displaced_mass(density));
        let missed = force.less(&self.known);
        self.spring_motion.as_mut()?.yield_to(&missed, &supports, &self.pose.rates(), c_0, &fluid, rounding)
    }

    /// Return the middle and half the length of its cells along an axis, m.
    fn extent(&self, axis: usize) -> [f64; 2] {
        let arms = self.cells.iter().map(|cell| cell.arm[axis]);
        let [low, high] = arms.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], arm| [arm.min(l), arm.max(h)]);
        [self.pose.position[axis] + 0.5 * (low + high), 0.5 * (high - low)]
    }

    /// Return whether a box around its cells meets that of another body.
    pub fn may_share_cells(&self, other: &Self, grid: &Grid<D>) -> bool {
        (0..D).all(|axis| {
            let [[own, half], [middle, other]] = [self, other].map(|body| body.extent(axis));
            grid.periodic(axis, own - middle).abs() < half + other + 0.5 * grid.spacing[axis]
        })
    }

    /// Return its parameters.
    pub fn body(&self) -> &Body<D> {
        &self.body
    }

    /// Return its name in errors.
    pub fn name(&self) -> &str {
        &self.body.name
    }

    /// Return its place and motion for those relative to its place at rest.
    pub fn pose_of(&self, displacement: &Pose<D>) -> Pose<D> {
        displaced(&self.body, displacement)
    }

    /// Return its angle about the axis of the first rotation of its laws, rad; 0 without a law.
    pub fn angle_of_law(&self) -> f64 {
        let Some(laws) = self.body.laws() else { return 0.0 };
        let [angle, axis] = [self.pose.angle, laws.rotations[0].0].map(<[f64; D]>::components);
        angle.iter().zip(axis).map(|(angle, axis)| angle * axis).sum()
    }

    /// Return whether it moves.
    pub fn moves(&self) -> bool {
        self.body.motion.is_some()
    }

    /// Return whether its drag on the fluid changes: it moves, or has a wall target.
    pub fn changes(&self) -> bool {
        self.moves() || self.cells.have_targets()
    }

    /// Return the displaced fluid of a density (kg/m³); moments are about the pivot.
    pub fn displaced(&self, density: f64) -> Displaced<D> {
        let Pose { velocity, omega, .. } = self.pose;
        let mass = density * self.moments.volume;
        let arm = self.centroid();
        // Velocity of the centroid relative to the pivot.
        let swing = <[f64; D]>::swing(omega, &arm);
        let momentum = mass * (velocity + swing);
        let own = <[f64; D]>::angular_momentum(&self.orientation, self.moments.inertia * density, omega);
        let transport = <[f64; D]>::cross(&velocity, &swing) * mass;
        Displaced { momentum, angular: <[f64; D]>::cross(&arm, &momentum) + own, transport }
    }

    /// Return the mass of the displaced fluid of a density (kg/m³).
    pub fn displaced_mass(&self, density: f64) -> Mass<D> {
        let (mass, inertia) = self.moments.about(self.body.pivot, density);
        Mass { mass, inertia: <[f64; D]>::inertia_matrix(&self.orientation, inertia), arm: self.centroid() }
    }

    /// Return moments of inertia in the axes of the body as a matrix in those of the domain at rest.
    pub fn inertia_at_rest(&self, inertia: <[f64; D] as Kinematics<D>>::Inertia) -> [[f64; 3]; 3] {
        let turn = &self.body.turn;
        <[f64; D]>::inertia_matrix(&<[f64; D]>::orientation(turn, <[f64; D]>::angle_at_rest(turn)), inertia)
    }

    /// Return the position of the centroid from the pivot.
    pub fn centroid(&self) -> Vector<D> {
        <[f64; D]>::turn(&self.orientation, self.moments.centroid - Vector::from(self.body.pivot))
    }

    /// Return the power (W) of a force.
    pub fn power(&self, force: &Force<D>) -> f64 {
        let (force, rates) = (join(&force.force, force.moment), self.pose.rates());
        force.iter().zip(rates).map(|(force, rate)| force * rate).sum()
    }

    /// Move to the place that the laws give at time `t` (s), and list the cells.
    pub fn follow(&mut self, t: f64, grid: &Grid<D>) {
        self.place(pose_at(&self.body, t), grid);
    }

    /// Move to a place, and list the cells.
    pub fn place(&mut self, pose: Pose<D>, grid: &Grid<D>) {
        (self.pose, self.spring_motion) = (pose, None);
        self.orientation = <[f64; D]>::orientation(&self.body.turn, pose.angle);
        let Self { body, profile: Some(profile), orientation, cells, .. } = self else { return };
        let Some(region) = body.shape.region() else { return };
        let (pivot, reach) = (Vector::from(body.pivot), profile.reach());
        let around = std::array::from_fn(|axis| {
            // The axis of the domain in the axes of the body.
            let direction = <[f64; D]>::turn_back(orientation, Vector::from_fn(|i, _| f64::from(u8::from(i == axis))));
            let from_pivot = direction.dot(&pivot);
            // A body without ends fills a period.
            let cut = |extent: f64| if extent.is_finite() { extent } else { 0.5 * grid.size[axis] };
            let ahead = cut(region.extent(direction.into())) - from_pivot + reach;
            let behind = cut(region.extent((-direction).into())) + from_pivot + reach;
            [pose.position[axis] - behind, pose.position[axis] + ahead]
        });
        let farthest = if body.shape.fills_box() { f64::INFINITY } else { reach };
        let placed = Placed { region, pivot, orientation: *orientation, pose };
        cells.clear();
        grid.for_each_in(around, |index, point| {
            let measure = placed.measure(&point);
            if measure.distance() <= farthest {
                cells.add(index, Vector::from(point) - pose.position, &measure, profile, grid);
            }
        });
    }
}

/// A body at a place.
struct Placed<'a, const D: usize>
where
    [f64; D]: Space<D>,
{
    region: &'a dyn Region<D>,
    /// Pivot in the axes of the body, m.
    pivot: Vector<D>,
    orientation: <[f64; D] as Kinematics<D>>::Orientation,
    pose: Pose<D>,
}

/// A place is a point, m.
impl<const D: usize> Measured<D, 1> for Placed<'_, D>
where
    [f64; D]: Space<D>,
{
    type Place = [f64; D];

    #[inline(always)]
    fn measure(&self, point: &[f64; D]) -> Measure<D, 1> {
        let (Pose { position, velocity, omega, .. }, pivot) = (self.pose, self.pivot);
        let arm = Vector::from(*point) - position;
        let own = <[f64; D]>::turn_back(&self.orientation, arm) + pivot;
        let (distance, surface, normal) = nearest(self.region, own);
        let foot = position + <[f64; D]>::turn(&self.orientation, surface - pivot);
        let surfaces = [Surface { distance, foot, normal: <[f64; D]>::turn(&self.orientation, normal) }];
        let velocity = velocity + <[f64; D]>::swing(omega, &arm);
        Measure { surfaces, velocity, velocity_before: velocity, spin: Some(omega) }
    }
}

#[cfg(test)]
mod tests {
    use geometry::plane::Outline;
    use geometry::space::Solid;

    use super::*;
    use crate::law::Law;
    use crate::parameters::Laws;
    use crate::space::Turn;

    fn law(amplitude: f64, frequency: f64) -> Law {
        Law::new(move |t| {
            let (sin, cos) = (frequency * t + 0.4).sin_cos();
            (amplitude * sin, amplitude * frequency * cos)
        })
    }

    /// Check force and moment about the moving pivot under which a rigid body as heavy as the fluid would move: the
    /// sum over its parts of the mass times the acceleration, found by differences of the places.
    fn check<const D: usize>(body: &Body<D>, size: [f64; D], parts: usize)
    where
        [f64; D]: Space<D>,
    {
        let grid = Grid::new(size.map(|size| [-0.5 * size, 0.5 * size]), [16; D]);
        let (t, dt, density) = (0.7, 1e-4, 2.0);
        let mask = Mask::Sharp { c_eta: 1.0, displacement_corrected: false };
        let mut rigid = Rigid::new(body, &grid, &mask, 1e-3, density);
        let [before, after] = [t - 0.5 * dt, t + 0.5 * dt].map(|t| {
            rigid.follow(t, &grid);
            rigid.displaced(density)
        });
        let found = after.rate_of_change(&before, dt);
        let poses = [t - 2e-3, t, t + 2e-3].map(|t| pose_at(body, t));
        let place = |pose: &Pose<D>, own: Vector<D>| {
            pose.position + <[f64; D]>::turn(&<[f64; D]>::orientation(&body.turn, pose.angle), own)
        };
        let (mut sum, part) = (Force::<D>::default(), size[0] / parts as f64);
        for k in 0..parts.pow(D as u32) {
            let index = |axis: usize| k / parts.pow(axis as u32) % parts;
            let own = Vector::from_fn(|axis, _| (index(axis) as f64 + 0.5) * part - 0.5 * size[0]);
            let region = body.shape.region().expect("it is closed");
            if nearest(region, own).0 < 0.0 {
                let [a, b, c] = poses.each_ref().map(|pose| place(pose, own - Vector::from(body.pivot)));
                let force = density * part.powi(D as i32) * (a - 2.0 * b + c) / (2e-3_f64).powi(2);
                sum.add(&force, &(b - poses[1].position));
            }
        }
        let ([found, expected], scale) = ([found, sum].map(|of| join(&of.force, of.moment)), sum.force.norm());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 3e-3 * scale, "{found} against {expected}");
        }
    }

    #[test]
    fn the_unsteady_term_is_the_inertia_of_the_displaced_fluid() {
        let outline = Body {
            pivot: [-0.2, 0.05],
            turn: 0.3,
            motion: Some(Motion::Laws(Laws {
                displacement: [law(0.3, 2.0), law(0.2, 3.0)],
                rotations: vec![(1.0, law(0.8, 2.5))],
            })),
            ..Body::still("", Outline::Ellipse([0.3, 0.1]), [0.0; 2])
        };
        check(&outline, [0.7; 2], 800);
        let solid = Body {
            pivot: [-0.2, 0.05, 0.1],
            turn: Turn { axis: [1.0, 2.0, -1.0], angle: 0.7 },
            motion: Some(Motion::Laws(Laws {
                displacement: [law(0.3, 2.0), law(0.2, 3.0), law(0.1, 1.0)],
                rotations: vec![
                    (Vector::from([2.0, -1.0, 2.0]) / 3.0, law(0.8, 2.5)),
                    (Vector::from([0.0, 0.6, 0.8]), law(0.5, 2.0)),
                ],
            })),
            ..Body::still("", Solid::Ellipsoid([0.3, 0.1, 0.2]), [0.0; 3])
        };
        check(&solid, [0.7; 3], 90);
    }
}
