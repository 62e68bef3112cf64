//! Transforms of lines, planes and volumes: the sums that define them, and waves with one mode.

use std::f64::consts::TAU;

use nervure_line_fft::{Complex, Fft2, Fft3, Lines, Pack, Real, ThreadTeam};

fn noise<R: Real>(n: usize) -> Vec<Pack<R>> {
    let number = |c: usize| R::rounded((c as f64 * 0.618_033_988_749_894_9).fract() - 0.5);
    let pack = |k: usize| {
        let mut pack = Pack::<R>::default();
        for lane in 0..R::LANES {
            pack.re[lane] = number(2 * R::LANES * k + lane);
            pack.im[lane] = number(2 * R::LANES * k + R::LANES + lane);
        }
        pack
    };
    (0..n).map(pack).collect()
}

fn value<R: Real>(pack: &Pack<R>, lane: usize) -> Complex<f64> {
    Complex::new(pack.re[lane].to_f64(), pack.im[lane].to_f64())
}

fn root(numerator: usize, n: usize) -> Complex<f64> {
    Complex::from_polar(1.0, -TAU * (numerator % n) as f64 / n as f64)
}

fn is_the_sum<R: Real>(rounding: f64) {
    // Each factor as the first one and in a pass, a long line in parts, and a large prime.
    for n in [2, 3, 4, 5, 7, 11, 13, 8, 9, 25, 49, 121, 169, 60, 450, 650, 17, 74] {
        let (lines, from) = (Lines::<R>::new(n), noise(n));
        let mut to = [vec![Pack::default(); n], vec![Pack::default(); n]];
        let mut scratch = vec![Complex::default(); lines.scratch_len()];
        lines.forward::<false>(&from, &mut to[0], &mut scratch);
        lines.forward::<true>(&from, &mut to[1], &mut scratch);
        for (k, lane) in (0..n).flat_map(|k| (0..R::LANES).map(move |lane| (k, lane))) {
            let mut sums = [Complex::<f64>::default(); 2];
            for (j, pack) in from.iter().enumerate() {
                let value = value(pack, lane);
                sums[0] += value * root(j * k, n);
                sums[1] += Complex::<f64>::new(value.im, value.re) * root(j * k, n);
            }
            for (sum, to) in sums.iter().zip(&to) {
                let error = (value(&to[k], lane) - sum).norm();
                assert!(error < rounding * n as f64, "length {n}, {k} of lane {lane}: off by {error}");
            }
        }
    }
}

#[test]
fn a_transform_is_the_sum_that_defines_it() {
    is_the_sum::<f64>(1e-15);
    is_the_sum::<f32>(3e-7);
}

fn a_plane_wave_comes_back<R: Real>(rounding: f64) {
    let block = 2 * R::LANES;
    // Each factor with a pass, odd and even lengths, and lengths with a large prime.
    for (nx, ny) in [(2 * block, 12), (21, 9), (33, 16), (block, 13), (28, 22), (400, 14), (650, 37), (74, 8), (18, 10)]
    {
        let (p, q) = (3, 2);
        let wave =
            |i: usize, j: usize| (TAU * (p * i) as f64 / nx as f64 + TAU * (q * j) as f64 / ny as f64 + 0.3).cos();
        let field: Vec<_> = (0..nx * ny).map(|c| R::rounded(wave(c / ny, c % ny))).collect();
        let fft = Fft2::<R>::new(nx, ny, ny / 2 + 1);
        let (mut spectrum, mut scratch, mut block) = (fft.spectrum(), fft.scratch(), fft.y.block());
        fft.forward(&field, &mut spectrum, &mut scratch, &mut block);
        for (i, j) in (0..nx).flat_map(|i| (0..=ny / 2).map(move |j| (i, j))) {
            let pack = &spectrum[j / R::LANES * nx + i];
            let value = Complex::new(pack.re[j % R::LANES].to_f64(), pack.im[j % R::LANES].to_f64());
            let expected =
                if (i, j) == (p, q) { Complex::from_polar(0.5 * (nx * ny) as f64, 0.3) } else { Complex::default() };
            let error = (value - expected).norm() / (nx * ny) as f64;
            assert!(error < rounding, "{nx}x{ny}, mode {i}, {j}: {value} against {expected}");
        }
        let mut back = vec![R::zero(); nx * ny];
        fft.inverse(&mut spectrum, &mut back, &mut scratch, &mut block);
        for (a, b) in back.iter().zip(&field) {
            let (a, b) = (a.to_f64() / (nx * ny) as f64, b.to_f64());
            assert!((a - b).abs() < 10.0 * rounding, "{nx}x{ny}: {a} against {b}");
        }
    }
}

#[test]
fn a_wave_in_the_plane_has_one_mode_and_comes_back() {
    a_plane_wave_comes_back::<f64>(1e-15);
    a_plane_wave_comes_back::<f32>(3e-7);
}

/// A wave has one mode, in the place that `solve` sees, and comes back; cut ones vanish.
fn a_wave_in_space_comes_back<R: Real>(rounding: f64, threads: usize) {
    for shape in [[12, 2 * R::LANES, 18], [15, 21, 13], [8, 26, 8]] {
        let [nx, ny, nz] = shape;
        let points = (nx * ny * nz) as f64;
        let wave = |c: usize, [p, q, s]: [usize; 3]| {
            let (i, j, k) = (c / (ny * nz), c / nz % ny, c % nz);
            let phase = (p * i) as f64 / nx as f64 + (q * j) as f64 / ny as f64 + (s * k) as f64 / nz as f64;
            (TAU * phase + 0.3).cos()
        };
        let field: Vec<R> =
            (0..nx * ny * nz).map(|c| R::rounded(wave(c, [3, ny - 2, 2]) + wave(c, [1, 4, 1]))).collect();
        let kept = vec![3; (nz / 2 + 1).div_ceil(R::LANES)];
        let fft = Fft3::<R>::new(shape, kept);
        let mut spectra = [fft.spectrum()];
        let mut scratch: Vec<_> = (0..threads).map(|_| fft.scratch::<1>()).collect();
        let mut back = vec![R::zero(); field.len()];
        ThreadTeam::with(threads, |team| {
            fft.forward(team, [&field], &mut spectra, &mut scratch);
            fft.along_x(team, &mut spectra, [0..1, 0..1], &mut scratch, |row, j, [line]| {
                for (i, l) in (0..nx).flat_map(|i| (0..R::LANES).map(move |l| (i, l))) {
                    let k = row * R::LANES + l;
                    if k > nz / 2 {
                        continue;
                    }
                    let value = Complex::new(line[i].re[l].to_f64(), line[i].im[l].to_f64());
                    let is_there = [i, j, k] == [3, ny - 2, 2];
                    let expected = if is_there { Complex::from_polar(0.5 * points, 0.3) } else { Complex::default() };
                    let error = (value - expected).norm() / points;
                    assert!(error < rounding, "{shape:?}, mode {i}, {j}, {k}: {value} against {expected}");
                }
            });
            fft.inverse(team, [&spectra[0]], [&mut back], &mut scratch, |_| ());
        });
        for (c, value) in back.iter().enumerate() {
            let (found, expected) = (value.to_f64() / points, wave(c, [3, ny - 2, 2]));
            assert!((found - expected).abs() < 10.0 * rounding, "{shape:?}, {c}: {found} against {expected}");
        }
    }
}

#[test]
fn a_wave_in_space_has_one_mode_comes_back_and_is_cut() {
    for threads in [1, 2] {
        a_wave_in_space_comes_back::<f64>(4e-15, threads);
        a_wave_in_space_comes_back::<f32>(3e-7, threads);
    }
}
