//! Factors of a matrix with supernodes against its products.

use super::Symmetric;
use crate::geometry::Vector;

/// Return the pattern of `side`² nodes of three unknowns on a grid, each with the nodes up to three lines ahead.
fn places(side: u32) -> Vec<(u32, u32)> {
    let mut places = Vec::new();
    for node in 0..side * side {
        let (x, y) = (node % side, node / side);
        for (other_x, other_y) in (0..16).map(|i| (x + i % 4, y + i / 4)) {
            let other = other_y * side + other_x;
            if other_x < side && other_y < side {
                let pairs = (0..9).map(|i| (3 * node + i / 3, 3 * other + i % 3));
                places.extend(pairs.filter(|(column, row)| row >= column));
            }
        }
    }
    places
}

#[test]
fn factors_by_supernodes_solve_and_tell_of_a_matrix_that_is_not_positive_definite() {
    for side in [1, 3, 4, 8, 17, 30] {
        let order = 3 * (side * side) as usize;
        let places = places(side);
        let node = |i: usize| Vector::new((i / 3 % side as usize) as f64, (i / 3 / side as usize) as f64, 0.0);
        let ends: Vec<_> = (0..order).map(|i| [node(i); 2]).collect();
        let mut matrix = Symmetric::new(places.clone(), &ends).expect("a pattern");
        let entry = |i: u32, j: u32| if i == j { 90.0 } else { f64::from(7 * i + 3 * j).sin() };
        for &(j, i) in &places {
            let place = matrix.place(i as usize, j as usize);
            matrix.values[place] = entry(i, j);
        }
        assert!(matrix.factorise(), "a positive definite matrix");
        let x: Vec<_> = (0..order).map(|i| (i as f64).cos()).collect();
        let mut b = vec![0.0; order];
        for &(j, i) in &places {
            b[i as usize] += entry(i, j) * x[j as usize];
            if i != j {
                b[j as usize] += entry(i, j) * x[i as usize];
            }
        }
        let check = |matrix: &mut Symmetric| {
            let mut found = b.clone();
            matrix.solve(&mut found);
            let off = found.iter().zip(&x).map(|(b, x)| (b - x).abs()).fold(0.0, f64::max);
            assert!(off < 1e-14 * order as f64, "{order} rows: off by {off:.1e}");
        };
        check(&mut matrix);
        let Symmetric { plan, values, factors, .. } = &mut matrix;
        assert!(plan.factorise_without_vectors(values, factors), "a positive definite matrix");
        check(&mut matrix);
        matrix.add_to_diagonal(order / 2, -180.0);
        assert!(!matrix.factorise(), "{order} rows: not positive definite");
    }
}

#[test]
fn a_diagonal_matrix_and_one_without_rows_are_solved() {
    for order in [0, 1, 7] {
        let ends = vec![[Vector::zeros(); 2]; order];
        let mut matrix = Symmetric::new((0..order as u32).map(|i| (i, i)).collect(), &ends).expect("a pattern");
        matrix.values.fill(4.0);
        assert!(matrix.factorise());
        let mut b = vec![2.0; order];
        matrix.solve(&mut b);
        assert_eq!(b, vec![0.5; order]);
    }
}
