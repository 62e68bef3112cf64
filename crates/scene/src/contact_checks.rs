//! What the rods, wings and bodies of a scene touch, and what is wrong with its contact.

use ::contact::{BodyFilm, BodyLaw, Law, Pose, Skin, largest_stiffness};
use geometry::vector::{minus, norm};
use method::Bending;

use crate::body::Body;
use crate::contact::{Contact, Film};
use crate::fault::{Check, Faults};
use crate::fluid::Fluid;
use crate::places::three_digits;
use crate::scene::{BeamWithRod, Scene, WingOfScene};
use crate::shape::Shape;
use crate::wing::Wing;

/// Steps in the shortest contact, for the default stiffness.
const STEPS: f64 = 10.0;

/// Cells of the fluid in the default range.
const RANGE_CELLS: f64 = 2.0;

/// Cells of the gap below which a grid misses a part of the lubrication: a sphere of 8 and one of 16 cells that near a wall
/// slowly miss the impulse c ln(1.25 cells/h_min) above h_min.
const FILM_CELLS: f64 = 1.25;

/// Most ranges in an edge of a wing, whose points of contact no edge may pass.
const MOST_RANGES: f64 = 8.0;

/// A half space: a point of its plane, m, and the normal outwards.
pub type HalfSpace = ([f64; 3], [f64; 3]);

impl Contact {
    /// Return the gap at which the force begins on a rod of this scene, m.
    pub fn range(&self, scene: &Scene, own: &BeamWithRod) -> f64 {
        let thickness = own.beam.places().map(|s| own.beam.thickness.at(s)).fold(f64::INFINITY, f64::min);
        self.range.unwrap_or(scene.fluid.as_ref().map_or(thickness, Self::two_cells))
    }

    /// Return the law of the bodies of this scene, which without a fluid gives the range.
    pub fn law_of_bodies(&self, scene: &Scene) -> BodyLaw {
        let fluid = scene.fluid.as_ref();
        let cells = fluid.map_or(f64::NAN, Self::two_cells);
        let film = |(film, fluid): (Film, &Fluid)| BodyFilm {
            viscosity: fluid.density * fluid.kinematic_viscosity,
            range: Self::film_range(fluid),
            least: film.roughness,
        };
        let step = fluid.map_or(f64::INFINITY, |fluid| fluid.time_stepping.max_step);
        BodyLaw {
            range: self.range.unwrap_or(self.film.map_or(cells, |film| film.roughness)),
            stiffness: self.stiffness.unwrap_or(f64::INFINITY),
            damping: self.damping,
            friction: self.friction,
            film: self.film.zip(fluid).map(film),
            dt: step.min(scene.time.communication_step),
        }
    }

    /// Return the gap below which a film acts, m.
    fn film_range(fluid: &Fluid) -> f64 {
        FILM_CELLS / RANGE_CELLS * Self::two_cells(fluid)
    }

    /// Return the length of two cells, m: a grid does not see a film of that.
    pub fn two_cells(fluid: &Fluid) -> f64 {
        RANGE_CELLS * fluid.spacing().into_iter().fold(0.0, f64::max)
    }

    /// Return the stiffness per metre of a rod of this scene, N/m².
    pub fn stiffness(&self, scene: &Scene, own: &BeamWithRod) -> f64 {
        let (Some(rod), Some(lightest)) = (own.rod, own.line_density()) else { return 0.0 };
        let step = rod.max_step.unwrap_or(f64::INFINITY).min(scene.time.communication_step);
        self.stiffness.unwrap_or(lightest * (std::f64::consts::PI / (STEPS * step)).powi(2))
    }

    /// Return the law per area of a wing of this scene.
    pub fn law_of_wing(&self, scene: &Scene, wing: &Wing) -> Law {
        let range = self.range.unwrap_or(scene.fluid.as_ref().map_or(f64::NAN, Self::two_cells));
        let step = wing.max_step.unwrap_or(f64::INFINITY).min(scene.time.communication_step);
        let mass = wing.lightest() + scene.fluid.as_ref().map_or(0.0, |fluid| fluid.density * range);
        Law {
            range,
            stiffness: self.stiffness.unwrap_or(mass * (std::f64::consts::PI / (STEPS * step)).powi(2)),
            depth: 0.5 * range,
            damping: self.damping,
            friction: self.friction,
            film: None,
        }
    }

    /// Return the law per metre of a rod of this scene.
    pub fn law(&self, scene: &Scene, own: &BeamWithRod) -> Law {
        Law {
            range: self.range(scene, own),
            stiffness: self.stiffness(scene, own),
            depth: own.beam.places().step_by(2).map(|s| 0.5 * own.beam.thickness.at(s)).fold(f64::INFINITY, f64::min),
            damping: self.damping,
            friction: self.friction,
            film: None,
        }
    }
}

impl Contact {
    /// Return the gap at which the force begins between rods and wings of this scene, m.
    pub fn range_between(&self, scene: &Scene) -> f64 {
        if scene.fluid.is_some() {
            return self.law_of_bodies(scene).range;
        }
        scene.beams_with_rods().map(|own| self.range(scene, &own)).fold(self.range.unwrap_or(f64::INFINITY), f64::min)
    }

    /// Return the skins by which the rods and wings of this scene touch each other in so many dimensions; none of a rigid
    /// beam and of a wing without a membrane.
    pub fn skins(&self, scene: &Scene, dimensions: usize) -> Vec<Option<Skin>> {
        let (range, step) = (self.range_between(scene), scene.time.communication_step);
        let density = scene.fluid.as_ref().map_or(0.0, |fluid| fluid.density);
        // The fluid beside a light line or surface is as slow.
        let skin = |radius, mass: f64, beside: f64| Skin {
            radius,
            largest_stiffness: largest_stiffness(mass + density * beside, step),
            mass,
        };
        let of_rod = |own: BeamWithRod| {
            let radius = own.beam.places().step_by(2).map(|s| 0.5 * own.beam.thickness.at(s)).collect();
            Some(skin(radius, own.line_density()?, range.powi(dimensions as i32 - 1)))
        };
        let of_wing = |own: WingOfScene| {
            let (mass, nodes) = (own.wing.lightest(), own.wing.mesh.build().nodes.len());
            mass.is_finite().then(|| skin(vec![Skin::of_surface(range); nodes], mass, range))
        };
        scene.beams_with_rods().map(of_rod).chain(scene.wings().map(of_wing)).collect()
    }
}

impl BeamWithRod<'_> {
    /// Return the least mass per metre of the rod, kg/m; none of a rigid beam.
    pub fn line_density(&self) -> Option<f64> {
        let rod = self.rod?;
        let density = |s: f64| rod.material.section(&self.beam.thickness, s).line_density;
        Some(self.beam.places().map(density).fold(f64::INFINITY, f64::min))
    }
}

impl Body {
    /// Return its place at time `t` (s) as that of an obstacle.
    pub fn place_at<const D: usize>(&self, t: f64) -> Pose<D> {
        let (axes, origin) = self.pose_at(t);
        let vector = |own: [f64; 3]| std::array::from_fn::<f64, D, _>(|d| own[d]).into();
        Pose { axes: std::array::from_fn(|d| vector(axes[d])), origin: vector(origin) }
    }
}

impl Wing {
    /// Return the least mass per area of the membrane, kg/m²; infinite without one.
    pub fn lightest(&self) -> f64 {
        let all = self.membrane.iter().chain(self.regions.iter().map(|region| &region.membrane));
        all.map(|membrane| membrane.areal_density).fold(f64::INFINITY, f64::min)
    }
}

impl Scene {
    /// Return the solid of the flyer that touches, with its key; none without a contact.
    pub fn flyer_solid(&self) -> Option<(String, &Body)> {
        let flyer = self.flyer.as_ref().filter(|_| self.contact.is_some())?;
        let of_fluid = |k: usize| Some((format!("fluid.bodies[{k}]"), self.fluid.as_ref()?.bodies.get(k)?));
        let own = || Some(("flyer.solid".into(), flyer.solid.as_ref()?));
        flyer.shape.map_or_else(own, of_fluid)
    }

    /// Return the solids that rods and wings touch: those of `contact`, and those of the fluid that are still or moved by laws.
    pub fn contact_bodies(&self) -> Vec<Body> {
        self.contact_bodies_with_keys().map(|(_, body)| body).collect()
    }

    /// Return the same with their keys.
    pub fn contact_bodies_with_keys(&self) -> impl Iterator<Item = (String, Body)> {
        let own = self.contact.iter().flat_map(|contact| contact.obstacles.iter().cloned().enumerate());
        let own = own.map(|(i, body)| (format!("contact.obstacles[{i}]"), body));
        let of_fluid = self.fluid.iter().filter(|_| self.contact.is_some()).flat_map(|fluid| fluid.obstacles());
        let of_fluid = of_fluid.filter(|own| own.body.mount.is_none() && !own.body.is_driven());
        own.chain(of_fluid.map(|own| (own.key, own.body)))
    }

    /// Return the walls that rods and wings touch.
    pub fn contact_walls(&self) -> Vec<HalfSpace> {
        let channel = self.fluid.as_ref().filter(|_| self.contact.is_some()).and_then(|fluid| fluid.channel.as_ref());
        let walls = channel.map_or([None; 3], |channel| [channel.x, channel.y, channel.z]);
        let along = |axis: usize, size: f64| std::array::from_fn(|d| if d == axis { size } else { 0.0 });
        let pair = |(axis, ends): (usize, Option<[f64; 2]>)| {
            ends.map(|[low, high]| [(along(axis, low), along(axis, 1.0)), (along(axis, high), along(axis, -1.0))])
        };
        walls.into_iter().enumerate().filter_map(pair).flatten().collect()
    }
}

/// Check the contact of a scene.
pub(crate) fn check(scene: &Scene, faults: &mut Faults) {
    let Some(contact) = &scene.contact else { return };
    let rods: Vec<_> = scene.beams_with_rods().filter_map(|own| own.rod.map(|_| scene.dimension(own.beam))).collect();
    let of_fluid: Vec<_> = scene.fluid.iter().flat_map(|fluid| fluid.obstacles()).collect();
    let of_flyer = scene.flyer_solid();
    let mounted = of_fluid.iter().filter(|own| own.body.mount.is_some()).map(|own| (own.key.clone(), &own.body));
    let moving: Vec<_> = mounted.chain(of_flyer.clone()).collect();
    let is_space = rods.first() == Some(&3)
        || scene.wings().next().is_some()
        || scene.flyer.is_some()
        || scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space());
    let has_wing = scene.wings().any(|own| own.wing.lightest().is_finite());
    faults.forbid(rods.is_empty() && !has_wing && moving.is_empty(), "contact", || {
        "the scene has neither a rod, a wing with a membrane, a body on a `mount` nor a flyer with a shape, and only \
         these touch"
            .into()
    });
    let without_fluid = scene.fluid.is_none();
    let is_absent = (has_wing || of_flyer.is_some()) && without_fluid && contact.range.is_none();
    faults.require(!is_absent, "contact.range", "absent", || {
        format!("a {} without a fluid needs it", if has_wing { "wing" } else { "flyer" })
    });
    faults.forbid(contact.film.is_some() && (moving.is_empty() || without_fluid), "contact.film", || {
        "only a body on a `mount` and a flyer have a film, in a fluid".into()
    });
    if let (Some(range), Some(fluid)) = (contact.range, &scene.fluid) {
        let longest = longest_range(fluid);
        faults.require(range <= longest, "contact.range", range, || {
            format!("it must be at most half the shortest side of the box, {longest}")
        });
    }
    let is_built = faults.len() == 0;
    for own in scene.wings().filter(|_| is_built) {
        let (range, least) = (contact.law_of_wing(scene, own.wing).range, longest_edge(own.wing) / MOST_RANGES);
        let value = contact.range.map_or(format!("absent, two cells or {range}"), |range| range.to_string());
        faults.require(range.is_nan() || range >= least, "contact.range", value, || {
            let least = three_digits(1.005 * least);
            format!("it must be at least {least}, an eighth of the longest edge of `{}.mesh`", own.key)
        });
    }
    if let (Some(film), Some(fluid)) = (contact.film, &scene.fluid) {
        let range = Contact::film_range(fluid);
        faults.require(film.roughness < range, "contact.film.roughness", film.roughness, || {
            format!("it must be below the gap at which a film begins, {FILM_CELLS} cells or {range} m")
        });
    }
    let projected = scene.beams_with_rods().any(|own| own.rod.is_some_and(|rod| rod.bending == Bending::Projected));
    faults.forbid(projected, "contact", || "a rod with projected bending cannot turn as contact may want".into());
    for (i, body) in contact.obstacles.iter().enumerate() {
        let key = format!("contact.obstacles[{i}]");
        body.check_at(&key, faults);
        body.check_dimension(&key, is_space, faults);
        let count = if is_space { 3 } else { 2 };
        let place = format!("{:?}", body.position);
        faults.require(body.position.len() == count, &format!("{key}.position"), place, || {
            let like = if !rods.is_empty() {
                "the beam"
            } else if has_wing {
                "the wing"
            } else {
                "the box"
            };
            format!("it must have {count} components like {like}")
        });
        let free = body.mount.is_some() || body.is_driven();
        faults.forbid(free, &format!("{key}.{}", if body.mount.is_some() { "mount" } else { "motion" }), || {
            "an obstacle is still or moved by laws".into()
        });
        faults
            .forbid(body.reference.is_some(), &format!("{key}.reference"), || "an obstacle has no coefficients".into());
    }
    let own = contact.obstacles.iter().enumerate().map(|(i, body)| (format!("contact.obstacles[{i}]"), body));
    let of_fluid = of_fluid.iter().map(|own| (own.key.clone(), &own.body));
    let solid = of_flyer.into_iter().filter(|(key, _)| key == "flyer.solid");
    let all: Vec<_> = own.chain(of_fluid).chain(solid).collect();
    for (key, body) in all.iter().filter(|(_, body)| !has_contact(&body.shape)) {
        let (_, name) = body.shape.dimension(is_space);
        faults.require(false, &format!("{key}.shape"), name, || {
            "what touches is a circle, rectangle, sphere, cuboid, circular_cylinder or capsule".into()
        });
    }
    if !is_space {
        return;
    }
    for (own, body) in &moving {
        let (shape, key) = (&body.shape, format!("{own}.shape"));
        let name = shape.dimension(true).1;
        faults.require(scene.contact_walls().is_empty() || !shape.is_endless(), &key, name, || {
            "contact of a `circular_cylinder` without ends with a wall is not known: give it a `length`".into()
        });
        for (other, _) in all.iter().filter(|(other, body)| other != own && body.shape.is_endless()) {
            faults.require(!shape.is_endless(), &key, name, || {
                format!("contact is not known with `{other}`, as both have no ends: give one a `length`")
            });
        }
    }
}

/// Return half the shortest side of the box, m.
fn longest_range(fluid: &Fluid) -> f64 {
    0.5 * fluid.r#box.ends().map(|[low, high]| high - low).fold(f64::INFINITY, f64::min)
}

/// Return the longest edge of the triangles of a wing, m.
fn longest_edge(wing: &Wing) -> f64 {
    let mesh = wing.mesh.build();
    let edges = mesh.triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.map(|[a, b]| norm(minus(mesh.nodes[*a], mesh.nodes[*b]))).fold(0.0, f64::max)
}

/// Return whether the key `contact` is not refused in a scene without it.
pub(crate) fn is_possible(scene: &Scene) -> bool {
    // The longest range suits all meshes.
    let range = Some(scene.fluid.as_ref().map_or(f64::MAX, longest_range));
    let contact = Contact { range, stiffness: None, damping: 0.0, friction: 0.0, film: None, obstacles: Vec::new() };
    let mut faults = Faults::default();
    check(&Scene { contact: Some(contact), ..scene.clone() }, &mut faults);
    faults.len() == 0
}

/// Return whether a shape can touch.
fn has_contact(shape: &Shape) -> bool {
    matches!(
        shape,
        Shape::Circle { .. }
            | Shape::Rectangle { .. }
            | Shape::Sphere { .. }
            | Shape::Cuboid { .. }
            | Shape::CircularCylinder { .. }
            | Shape::Capsule { .. }
    )
}
