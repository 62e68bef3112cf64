//! Writes what is measured of exact solutions and invariants: `measures FILE.csv`.

#[path = "../../../../../crates/fluid/tests/common/mod.rs"]
mod common;
#[path = "../../../../../crates/fluid/tests/common/measures.rs"]
mod measures;

use measures::{made_by_advection, noise};
use nervure_fluid::internals::DragProfile;
use nervure_fluid::{Mask, WallCorrection};
use scene::{Filter, TimeScheme};

fn main() -> Result<(), csv::Error> {
    let mut file = csv::Writer::from_path(std::env::args().nth(1).expect("the file to write"))?;
    file.write_record(["measure", "setting", "quantity", "value", "unit", "expected"])?;
    let mut row = |measure: &str, setting: &str, quantity: &str, value: f64, unit: &str, expected: Option<f64>| {
        file.serialize((measure, setting, quantity, value, unit, expected))
    };
    for (name, scheme) in [("sbdf2", TimeScheme::Sbdf2), ("rk2", TimeScheme::Rk2)] {
        for steps in [80, 160] {
            let error = measures::taylor_green_error(scheme, steps, &[1.0]);
            row("Taylor-Green", &format!("{name}, {steps} steps"), "error", error, "m/s", None)?;
        }
    }
    for (half_box, cells) in [(1.0, 256), (0.7, 180)] {
        let [found, expected] = measures::added_mass(half_box, cells);
        let setting = format!("box of {} radii", 20.0 * half_box);
        row("added mass", &setting, "displaced masses", found, "1", Some(expected))?;
    }
    let filters = [("two_thirds", Filter::TwoThirds), ("none", Filter::None), ("smooth", Filter::Smooth)];
    let flows = filters.map(|(name, filter)| (name, noise(filter)));
    for (setting, fluid) in flows.into_iter().chain([("smooth, waves up to two thirds", measures::resolved_noise())]) {
        let [energy, enstrophy] = made_by_advection(fluid);
        row("made by advection", setting, "energy", energy, "1", None)?;
        row("made by advection", setting, "enstrophy", enstrophy, "1", None)?;
    }
    for (waves, which) in [([[7, 1], [6, 2]], "7 and 6"), ([[9, 1], [8, 3]], "9 and 8")] {
        for (name, filter) in [("two_thirds", Filter::TwoThirds), ("smooth", Filter::Smooth), ("none", Filter::None)] {
            // The two-thirds rule has no waves 9 and 8.
            if which == "7 and 6" || filter != Filter::TwoThirds {
                row("aliasing", &format!("{which}, {name}"), "share", measures::aliased(filter, waves), "1", None)?;
            }
        }
    }
    for decay_length_cells in [0.2, 0.25, 0.3] {
        let [least, most] = measures::walls(decay_length_cells);
        row("wall", &format!("e-fold {decay_length_cells}"), "least", least, "cells", None)?;
        row("wall", &format!("e-fold {decay_length_cells}"), "most", most, "cells", None)?;
    }
    for cells in [64, 128] {
        row("flux", &format!("{cells} cells"), "error", measures::flux_error(cells), "1", None)?;
    }
    let targets =
        [0.2, 0.25, 0.3].map(|decay_length_cells| (decay_length_cells, "curvature", WallCorrection::Curvature, None));
    let others = [
        ("core 2 cells deep", WallCorrection::Curvature, Some(2.0)),
        ("no core", WallCorrection::Curvature, None),
        ("shear", WallCorrection::Shear, None),
    ];
    let others = others.map(|(name, target, core_depth)| (0.25, name, target, core_depth));
    for (decay_length_cells, name, target, core_depth) in targets.into_iter().chain(others) {
        let mask = Mask::LogLinear { c_eta: 1e-5, decay_length_cells, core_depth, wall_correction: target };
        let profile = DragProfile::of_body(20.0, name == "no core", &mask, 1e-3, 1.0);
        let DragProfile::LogLinear { shrink, target: Some(target), .. } = profile else { unreachable!() };
        let setting = format!("e-fold {decay_length_cells}, {name}");
        row("wall target", &setting, "m", target.mirror, "1", None)?;
        if name != "shear" {
            row("wall target", &setting, "c", target.curvature, "1", None)?;
            row("wall target", &setting, "D_c", target.depth, "cells", None)?;
        }
        row("wall target", &setting, "shift", shrink, "cells", None)?;
    }
    row("memory", "320 x 120, with a beam", "arrays of the grid's size", measures::arrays(), "1", None)?;
    Ok(file.flush()?)
}
