//! Stresses on a line in the plane or a surface in space, from the forces on its markers.

use std::ops::Range;

use super::parts::Parts;
use super::surface::Facets;
use crate::space::{Kinematics, Space, Vector};
use contact::Stations;

/// The patches of a surface, over which the force on a marker counts as stress.
pub struct SurfaceStress {
    /// Areas of the patches, m².
    areas: Vec<f64>,
    /// Area of the surface at each node, m².
    covered: Vec<f64>,
    /// Thickness of the layer that moves with the surface, m.
    layer: f64,
}

impl SurfaceStress {
    /// The stress on a surface of some nodes in patches of some areas (m²), with the thickness of the layer that moves with
    /// it, m.
    pub fn new(nodes: usize, parts: &Parts, areas: Vec<f64>, layer: f64) -> Self {
        let mut covered = vec![0.0; nodes];
        for ((_, shares), area) in parts.iter().zip(&areas) {
            shares.iter().for_each(|&(node, share)| covered[node] += share * area);
        }
        Self { areas, covered, layer }
    }

    /// Write the stresses; see [`LineStress::write`] for the layer.
    pub fn write<const D: usize>(
        &self,
        (parts, facets): (&Parts, &Facets),
        force: impl Fn(usize) -> Vector<D>,
        density: f64,
        dt: f64,
        [stations, before]: [&Stations<D>; 2],
        (jump, shear): (&mut Vec<f64>, &mut [Vec<f64>]),
    ) where
        [f64; D]: Space<D>,
    {
        jump.fill(0.0);
        shear.iter_mut().for_each(|along| along.fill(0.0));
        for (patch, ((k, shares), area)) in parts.iter().zip(&self.areas).enumerate() {
            let normal = facets.normal(patch, &stations.position);
            let length = normal.iter().fold(0.0_f64, |length, part| length.hypot(*part));
            let normal = normal / length.max(f64::MIN_POSITIVE);
            let gain = |node: usize, axis: usize| stations.velocity[axis][node] - before.velocity[axis][node];
            let acceleration = Vector::<D>::from_fn(|axis, _| {
                shares.iter().map(|&(node, share)| share * gain(node, axis)).sum::<f64>() / dt
            });
            let stress = force(k) * density;
            let across = stress.dot(&normal);
            let along = stress - normal * across;
            let across = across + acceleration.dot(&normal) * (self.layer * area * density);
            for &(node, share) in shares {
                let weight = share / self.covered[node];
                jump[node] -= weight * across;
                shear.iter_mut().zip(along.iter()).for_each(|(shear, part)| shear[node] += weight * part);
            }
        }
    }
}

/// A line divided into equal parts, over which the force on a marker counts as stress.
pub struct LineStress {
    parts: Parts,
    /// Fluid that moves with the line, m² a metre.
    layer: f64,
    /// Length of the line at each station, m.
    covered: Vec<f64>,
}

impl LineStress {
    /// The stress on a line of a length through `points` (m), with the `parts` of its markers and the thickness of the
    /// layer that moves with it, m.
    pub fn new<const D: usize>(points: &[[f64; D]], parts: &Parts, length: f64, layer: f64) -> Self {
        let length = length / parts.len() as f64;
        let (parts, mut covered) = (parts.equal(points), vec![0.0; points.len()]);
        for (_, shares) in parts.iter() {
            shares.iter().for_each(|&(point, share)| covered[point] += share * length);
        }
        // The layer of a marker over its length, as the mass of the body leaves it out.
        Self { parts, layer: layer * length / length, covered }
    }

    /// Write the pressure above less the pressure below the line at its stations, and the shear stress on both faces
    /// together towards the tip, Pa, in a step of `dt` seconds from the stations `before`. The layer that moves with the
    /// line takes a part of the force on the markers, which a line of no thickness would not need. Friction that jumps at
    /// an end makes it alternate from marker to marker, so the shear is of means with the weights 1, 2, 1.
    pub fn write<const D: usize>(
        &self,
        force: impl Fn(usize) -> Vector<D>,
        density: f64,
        dt: f64,
        [stations, before]: [&Stations<D>; 2],
        [jump, shear]: [&mut [f64]; 2],
    ) where
        [f64; D]: Space<D>,
    {
        let last = jump.len() - 1;
        let at = |field: &[Vec<f64>; D], k: usize| Vector::from(field.each_ref().map(|of| of[k]));
        let tangent = |k: usize| {
            let [from, to] = [k.saturating_sub(1), (k + 1).min(last)].map(|k| at(&stations.position, k));
            let along: Vector<D> = to - from;
            along / along.iter().fold(0.0_f64, |length, component| length.hypot(*component))
        };
        let across = |of: &Vector<D>, tangent: &Vector<D>| <[f64; D]>::components(<[f64; D]>::cross(of, tangent))[0];
        for k in 0..=last {
            let tangent = tangent(k);
            let acceleration: Vector<D> = (at(&stations.velocity, k) - at(&before.velocity, k)) / dt;
            let layer = density * self.layer;
            (jump[k], shear[k]) = (layer * across(&acceleration, &tangent), layer * acceleration.dot(&tangent));
        }
        let Range { start, end } = self.parts.markers();
        for (k, shares) in self.parts.iter() {
            let beside = [k.saturating_sub(1).max(start), k, k, (k + 1).min(end - 1)];
            let (own, mean) = (force(k), beside.iter().map(|k| force(*k)).sum::<Vector<D>>() * 0.25);
            for &(point, share) in shares {
                let (tangent, weight) = (tangent(point), density * share / self.covered[point]);
                jump[point] += weight * across(&own, &tangent);
                shear[point] += weight * mean.dot(&tangent);
            }
        }
    }
}
