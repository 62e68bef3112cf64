//! Pressures at probes and beams, made on the first request after a step.

use crate::bodies::Beam;
use crate::grid::Grid;
use crate::outlet::Outlet;
use crate::probe::Probe;
use crate::space::Space;
use contact::Stations;

/// A value that is made on request and kept until it is stale. It cannot be read while it is stale.
pub struct Cached<T> {
    value: T,
    is_current: bool,
}

impl<T> Cached<T> {
    /// A stale value with room for the one to be made.
    pub fn stale(value: T) -> Self {
        Self { value, is_current: false }
    }

    /// Make the value stale.
    pub fn invalidate(&mut self) {
        self.is_current = false;
    }

    /// Return the value; `make` writes it if it is stale.
    pub fn get(&mut self, make: impl FnOnce(&mut T)) -> &T {
        if !self.is_current {
            make(&mut self.value);
            self.is_current = true;
        }
        &self.value
    }
}

/// Pressures at the present time, Pa.
pub struct Pressures {
    /// At each probe.
    pub probes: Vec<f64>,
    /// Above less below each beam, at its stations.
    pub jump: Vec<Vec<f64>>,
    /// Around each beam at its stations, relative to the outlet; empty if not wanted.
    pub around: Vec<Vec<f64>>,
}

impl Pressures {
    /// Zeros.
    pub fn new<const D: usize>(probes: usize, stations: &[Stations<D>], around: bool) -> Self {
        let zeros = |stations: &Stations<D>| vec![0.0; stations.len()];
        Self {
            probes: vec![0.0; probes],
            jump: stations.iter().map(zeros).collect(),
            around: stations.iter().filter(|_| around).map(zeros).collect(),
        }
    }
}

/// Where pressures are read.
pub struct PressurePlaces<'a, const D: usize>
where
    [f64; D]: Space<D>,
{
    /// The grid.
    pub grid: &'a Grid<D>,
    /// Density of the fluid, kg/m³.
    pub density: f64,
    /// Probes.
    pub probes: &'a [Probe],
    /// Reference of the pressure around the beams.
    pub outlet: Option<&'a Outlet>,
    /// Beams with a mask.
    pub beams: &'a [Beam<D>],
    /// Stations of the flexible bodies.
    pub stations: &'a [Stations<D>],
    /// Pressure jumps of the thin bodies; empty for a beam with a mask.
    pub thin: &'a [Vec<f64>],
}

impl<const D: usize> PressurePlaces<'_, D>
where
    [f64; D]: Space<D>,
{
    /// Write the pressures from the static pressure over the density (m²/s²), given at a grid point.
    pub fn read(&self, at: &dyn Fn(usize) -> f64, pressures: &mut Pressures) {
        for (pressure, probe) in pressures.probes.iter_mut().zip(self.probes) {
            *pressure = self.density * probe.pressure(at);
        }
        let level = self.outlet.map_or(0.0, |outlet| outlet.mean(at));
        for (number, (stations, jumps)) in self.stations.iter().zip(&mut pressures.jump).enumerate() {
            let Some(beam) = self.beams.iter().find(|beam| beam.number == number) else {
                // A line in space has no jump.
                let known = &self.thin[number];
                jumps[..known.len()].copy_from_slice(known);
                continue;
            };
            for (k, jump) in jumps.iter_mut().enumerate() {
                let [above, below] = beam.faces(stations, k).map(|point| {
                    let around = self.grid.interpolation(point.into());
                    around.as_ref().iter().map(|&(c, weight)| weight * at(c)).sum::<f64>()
                });
                *jump = self.density * (above - below);
                if let Some(around) = pressures.around.get_mut(number) {
                    around[k] = self.density * (0.5 * (above + below) - level);
                }
            }
        }
    }
}
