//! Conversion of a scene to the parameters of a wing, and of its laws to poses.

use scene::{RootLaws, SURFACE_THICKNESS_CELLS, Scene, WingSupport};
use wing::{Contact, Membrane, Parameters, RigidMotion, Root, Support, Vein};

/// Return the parameters of a wing of a scene, in its fluid if it has one.
pub fn parameters(scene: &Scene, own: &scene::Wing) -> Parameters {
    let fluid = scene.fluid.as_ref();
    let mesh = own.mesh.build();
    let chain = |name: &str| mesh.chain(name).unwrap_or_default().to_vec();
    let root = Root {
        nodes: own.root.as_deref().map(chain).unwrap_or_default(),
        support: match own.support {
            WingSupport::Clamped => Support::Clamped,
            WingSupport::Pinned => Support::Pinned,
            WingSupport::Hinge { stiffness } => Support::TorsionSpring { stiffness },
        },
        origin: own.pivot,
    };
    let veins = own.veins.iter().map(|vein| {
        let nodes = chain(&vein.chain);
        let diameter = match vein.tip_diameter {
            1.0 => Vec::new(),
            tip => (0..nodes.len()).map(|i| 1.0 + (tip - 1.0) * i as f64 / (nodes.len() - 1).max(1) as f64).collect(),
        };
        let name = &vein.chain;
        let uniform = Vein::new(name, &nodes, vein.line_density, vein.bending_stiffness, vein.axial_stiffness);
        Vein { diameter, torsional_stiffness: vein.torsional_stiffness, ..uniform }
    });
    let materials = own.membrane.iter().chain(own.regions.iter().map(|region| &region.membrane));
    let membranes = materials.map(|membrane| Membrane {
        areal_density: membrane.areal_density,
        stretching_stiffness: membrane.stretching_stiffness,
        bending_stiffness: membrane.bending_stiffness,
        poisson_ratio: membrane.poisson_ratio,
        tension: membrane.tension,
    });
    Parameters {
        veins: veins.collect(),
        membranes: membranes.collect(),
        regions: own.materials(&mesh),
        root,
        gravity: own.gravity,
        relaxation_time: own.relaxation_time,
        displaced_density: fluid.map_or(0.0, |fluid| fluid.density * SURFACE_THICKNESS_CELLS * fluid.largest_cell()),
        contact: scene.contact.as_ref().map(|contact| Contact {
            law: contact.law_of_wing(scene, own),
            with_itself: true,
            obstacles: adapter::obstacles_in_space(scene),
        }),
        scheme: own.scheme,
        max_step: own.max_step,
        mesh,
    }
}

/// Return the pose of the base at time `t`, s.
pub fn pose(laws: &RootLaws, t: f64) -> RigidMotion {
    let (displacement, velocity) = laws.displacement(t);
    let axes: [_; 3] =
        std::array::from_fn(|j| laws.direction(t, std::array::from_fn(|d| if d == j { 1.0 } else { 0.0 })));
    // With unit vectors e_j, ω = ½ Σ e_j × e_j'.
    let angular_velocity = std::array::from_fn(|d| {
        let (a, b) = ((d + 1) % 3, (d + 2) % 3);
        0.5 * axes.iter().map(|(e, rate)| e[a] * rate[b] - e[b] * rate[a]).sum::<f64>()
    });
    let rotation = std::array::from_fn(|i| std::array::from_fn(|j| axes[j].0[i]));
    RigidMotion { displacement, velocity, rotation, angular_velocity }
}
