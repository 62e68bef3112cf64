//! The rates of a load by hand.

use super::Layer;

/// A roof of two triangles, of areas 2 and 1, and a node beside them.
#[test]
fn a_layer_slides_at_the_rate_of_its_mass_where_that_is_less() {
    let nodes = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [5.0, 5.0, 5.0]];
    let mut layer = Layer::new(5, [([0, 1, 2], 6.0), ([0, 1, 3], 3.0)].into_iter());
    layer.find_normals(|node| nodes[node]);
    assert_eq!(
        [0, 2, 3, 4].map(|node| layer.rate(node, 9.0, 0.5).0),
        [[0.0, -2.0, 4.0], [0.0, 0.0, 4.0], [0.0, -2.0, 0.0], [0.0; 3]]
    );
    assert_eq!([0, 1, 2, 3, 4].map(|node| layer.rate(node, 9.0, 0.5).1), [6.0, 6.0, 4.0, 2.0, 9.0]);
    assert_eq!([0, 4].map(|node| layer.rate(node, 5.0, 0.5).1), [5.0, 5.0]);
    layer.find_normals(|node| nodes[node].map(|x| -x));
    assert_eq!(layer.rate(0, 9.0, 0.5).0, [0.0, -2.0, 4.0], "found anew");
}
