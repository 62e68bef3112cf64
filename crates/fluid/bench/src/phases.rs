//! Where the time of a step goes: its phases one by one, from the same parts that the step is made of.

use std::cell::RefCell;
use std::fmt::Write;

use fluid::Grid;
use fluid::fft::Fft2;
use fluid::kernel::{Component, Differences, advection_rate, solve};
use fluid::projection::Projection;

use crate::{Flow, Times, noise, scene, us};

/// The table for FSI3 on 650 x 144 points.
pub fn table(text: &mut String) -> std::fmt::Result {
    let with_bar = scene("fsi3-650x144", [650, 144]);
    let mut without = with_bar.clone();
    (without.beam, without.rod, without.coupling) = (None, None, None);
    let fluid = with_bar.fluid.as_ref().expect("the scene has a fluid");
    let grid = Grid::new(&fluid.domain);
    let (nx, ny) = (grid.nx, grid.ny);
    let mut projection = Projection::new(&grid, fluid.filter);
    let fft = Fft2::new(nx, ny, projection.modes());
    let buffers = RefCell::new(([fft.scratch()], [fft.spectrum(), fft.spectrum(), fft.spectrum()]));
    let fields: Vec<Vec<f64>> = (0..8).map(|shift| (shift..shift + grid.len()).map(noise).collect()).collect();
    let [mut wx, mut wy, mut vorticity] = [(); 3].map(|()| fields[0].clone());
    projection.set_viscosity(1e-8);

    let scheme = Differences::new(1e-4, 1e-4);
    let component = |axis: usize| Component {
        u: &fields[axis],
        u_before: &fields[2 + axis],
        w: &fields[4 + axis],
        per_tau: scheme.c[0],
        omega: &fields[6],
        omega_before: &fields[7],
        other: &fields[1 - axis],
        other_before: &fields[3 - axis],
        sign: 1.0,
    };
    let rate = vec![0.0; grid.len()];
    let (mut a, mut b) = (wx.clone(), wy.clone());
    let mut local = || {
        for start in (0..grid.len()).step_by(256) {
            let points = start..(start + 256).min(grid.len());
            solve(&component(0).points(points.clone()), &scheme, &rate[points.clone()], &mut a[points.clone()]);
            solve(&component(1).points(points.clone()), &scheme, &rate[points.clone()], &mut b[points]);
        }
    };
    let mut forward = || {
        let (scratch, [u_hat, v_hat, _]) = &mut *buffers.borrow_mut();
        fft.forward_along_y([&fields[0], &fields[1]], [u_hat, v_hat], scratch);
    };
    let mut waves = || {
        let ([scratch], spectra) = &mut *buffers.borrow_mut();
        let ([u, v, omega], line) = (&mut scratch.rows, &mut scratch.line);
        let [u_rows, v_rows, omega_rows] = spectra.each_mut().map(|spectrum| spectrum.chunks_exact_mut(nx));
        for (row, ((u_hat, v_hat), omega_hat)) in u_rows.zip(v_rows).zip(omega_rows).enumerate() {
            fft.forward_along_x(u_hat, u, line);
            fft.forward_along_x(v_hat, v, line);
            projection.project(row, u, v, omega);
            fft.inverse_along_x(u, u_hat, line);
            fft.inverse_along_x(v, v_hat, line);
            fft.inverse_along_x(omega, omega_hat, line);
        }
    };
    let mut largest = 0.0_f64;
    let mut inverse = || {
        let ([scratch], [u_hat, v_hat, omega_hat]) = &mut *buffers.borrow_mut();
        for columns in fft.blocks(0..nx) {
            let points = columns.start * ny..columns.end * ny;
            let [u, v, omega] = [&mut wx, &mut wy, &mut vorticity].map(|field| &mut field[points.clone()]);
            fft.inverse_along_y(u_hat, columns.clone(), u, scratch);
            fft.inverse_along_y(v_hat, columns.clone(), v, scratch);
            fft.inverse_along_y(omega_hat, columns, omega, scratch);
            largest = largest.max(advection_rate(1.0, 1.0, u, v));
        }
    };
    let (mut bar, mut bare) = (Flow::new(&with_bar, 1e-4), Flow::new(&without, 1e-4));
    let phases = Times::take([&mut local, &mut forward, &mut waves, &mut inverse]);
    let [local, forward, waves, inverse] = [0, 1, 2, 3].map(|phase| phases.shortest(phase));
    let steps = Times::take([&mut || bar.step(), &mut || bare.step()]);
    let (step, bare) = (steps.shortest(0), steps.shortest(1));
    std::hint::black_box((&a, &b, &vorticity, largest));

    writeln!(text, "\nWhere the time of a step goes: FSI3 on 650 x 144 points, the bar swinging:\n")?;
    writeln!(text, "| phase | µs | share |\n|---|---|---|")?;
    let rows = [
        ("local solve", local),
        ("forward along y, two", forward),
        ("along x, two forward and three back, with the projection", waves),
        ("back along y, three, with the CFL number", inverse),
        ("the bar: painting, drag, loads (step with it less step without)", step - bare),
        ("still bodies, inflow (what is left)", bare - local - forward - waves - inverse),
        ("the step", step),
    ];
    for (name, seconds) in rows {
        writeln!(text, "| {name} | {} | {:.0} % |", us(seconds), 100.0 * seconds / step)?;
    }
    Ok(())
}
