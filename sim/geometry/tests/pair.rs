//! Distances in space against closed forms.

use feeler_geometry::{Mesh, Pair, Place, Shape, overlap_m};

/// A projection and a norm of lengths below 1 m, each rounded a few times.
const ROUNDING: f64 = 1e-13;
/// Parry's iteration for shapes other than balls stops within this, m.
const ITERATED: f64 = 1e-6;
const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

#[test]
fn truth_a_ball_over_a_box_has_the_distance_of_its_centre_less_its_radius() {
    let work = Shape::Cuboid { half_extents_m: [0.1, 0.1, 0.05] };
    let pair = Pair::new(&Shape::Ball { radius_m: 0.01 }, &Place::at([0.02, 0.0, 0.0]), &work, &Place::default()).unwrap();
    let over = pair.nearest([0.0, 0.03, 0.08], UPRIGHT).unwrap().unwrap();
    assert!((over.distance_m - 0.02).abs() < ROUNDING && (over.normal[2] + 1.0).abs() < ROUNDING, "{over:?}");
    assert!((over.point_m[0] - 0.02).abs() < ROUNDING && (over.point_m[2] - 0.05).abs() < ROUNDING);
    // Off an edge, 30 mm in x and 40 mm in z.
    let edge = pair.nearest([0.11, 0.0, 0.09], UPRIGHT).unwrap().unwrap();
    assert!((edge.distance_m - 0.04).abs() < ROUNDING && (edge.normal[0] + 0.6).abs() < ROUNDING, "{edge:?}");
    // Turned by half a turn about z the ball is on the other side of the tool.
    let turned = pair.nearest([0.11, 0.0, 0.09], [0.0, 0.0, 1.0, 0.0]).unwrap().unwrap();
    assert!((turned.distance_m - 0.03).abs() < ROUNDING, "{turned:?}");
    let deep = pair.nearest([0.0, 0.0, 0.055], UPRIGHT).unwrap().unwrap();
    assert!((deep.distance_m + 0.005).abs() < ROUNDING && (deep.normal[2] + 1.0).abs() < ROUNDING, "{deep:?}");
    let inside = pair.nearest([0.0, 0.0, 0.045], UPRIGHT).unwrap().unwrap();
    assert!((inside.distance_m + 0.015).abs() < ROUNDING && (inside.normal[2] + 1.0).abs() < ROUNDING, "{inside:?}");
}

#[test]
fn truth_travel_ends_at_the_surface_or_nowhere() {
    let work = Shape::Cuboid { half_extents_m: [0.1, 0.1, 0.05] };
    for tip in [Shape::Ball { radius_m: 0.01 }, Shape::Cylinder { half_length_m: 0.01, radius_m: 0.01 }] {
        let pair = Pair::new(&tip, &Place::default(), &work, &Place::default()).unwrap();
        let travel = pair.travel_m([0.0, 0.0, 0.2], UPRIGHT, [0.0, 0.0, -1.0], 1.0).unwrap().unwrap();
        assert!((travel - 0.14).abs() < ITERATED, "{travel}");
        assert_eq!(pair.travel_m([0.5, 0.0, 0.2], UPRIGHT, [0.0, 0.0, -1.0], 1.0).unwrap(), None);
        let over = pair.nearest([0.0, 0.0, 0.061], UPRIGHT).unwrap().unwrap();
        assert!((over.distance_m - 0.001).abs() < ITERATED, "{over:?}");
    }
}

#[test]
fn truth_two_capsules_overlap_by_what_their_lines_are_too_near() {
    let capsule = Shape::Capsule { half_length_m: 0.2, radius_m: 0.05 };
    let depth = overlap_m((&capsule, [0.0; 3], UPRIGHT), (&capsule, [0.08, 0.1, 0.0], UPRIGHT)).unwrap();
    assert!((depth - 0.02).abs() < ITERATED, "{depth}");
    assert!(overlap_m((&capsule, [0.0; 3], UPRIGHT), (&capsule, [0.2, 0.0, 0.0], UPRIGHT)).unwrap() <= 0.0);
}

#[test]
fn truth_the_inside_of_a_closed_mesh_is_known_and_a_sheet_has_none() {
    // A cube of 0.2 m; corner i has bit k of i for its side along axis k.
    let vertices_m = (0..8).map(|i| std::array::from_fn(|k| if i >> k & 1 == 1 { 0.1 } else { -0.1 })).collect::<Vec<_>>();
    let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles = |count: usize| sides[..count].iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect::<Vec<[u32; 3]>>();
    let pair = |count| {
        let mesh = Shape::Mesh(Mesh { vertices_m: vertices_m.clone(), triangles: triangles(count) });
        Pair::new(&Shape::Ball { radius_m: 0.01 }, &Place::default(), &mesh, &Place::at([1.0, 0.0, 0.0])).unwrap()
    };
    let depth = pair(6).buried_m([1.0, 0.0, 0.07], UPRIGHT).unwrap();
    assert!((depth - 0.03).abs() < ROUNDING, "{depth}");
    assert_eq!(pair(6).buried_m([1.0, 0.0, 0.2], UPRIGHT), None);
    assert_eq!(pair(1).buried_m([1.0, 0.0, 0.0], UPRIGHT), None);
}
