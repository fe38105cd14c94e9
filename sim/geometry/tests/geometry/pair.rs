//! Distances in space against closed forms.

use std::f64::consts::PI;

use feeler_geometry::{Mesh, Pair, Placement, Shape, overlap_m};

/// A projection and a norm of lengths below 1 m, each rounded a few times.
const ROUNDING: f64 = 1e-13;
/// Parry's iteration for shapes other than balls stops within this, m.
const ITERATED: f64 = 1e-6;
const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

#[test]
fn truth_a_ball_over_a_box_has_the_distance_of_its_centre_less_its_radius() {
    let work = Shape::Cuboid { half_extents_m: [0.1, 0.1, 0.05] };
    let pair = Pair::new(
        &Shape::Ball { radius_m: 0.01 },
        &Placement::at([0.02, 0.0, 0.0]),
        &work,
        &Placement::default(),
    )
    .unwrap();
    let over = pair.nearest([0.0, 0.03, 0.08], UPRIGHT).unwrap().unwrap();
    assert!((over.distance_m - 0.02).abs() < ROUNDING && (over.normal[2] + 1.0).abs() < ROUNDING, "{over:?}");
    assert!((over.point_m[0] - 0.02).abs() < ROUNDING && (over.point_m[2] - 0.05).abs() < ROUNDING);
    // Off an edge, 30 mm in x and 40 mm in z.
    let edge = pair.nearest([0.11, 0.0, 0.09], UPRIGHT).unwrap().unwrap();
    assert!((edge.distance_m - 0.04).abs() < ROUNDING && (edge.normal[0] + 0.6).abs() < ROUNDING, "{edge:?}");
    // After half a turn about z the ball is on the other side of the tool.
    let turned = pair.nearest([0.11, 0.0, 0.09], [0.0, 0.0, 1.0, 0.0]).unwrap().unwrap();
    assert!((turned.distance_m - 0.03).abs() < ROUNDING, "{turned:?}");
    let deep = pair.nearest([0.0, 0.0, 0.055], UPRIGHT).unwrap().unwrap();
    assert!(
        (deep.distance_m + 0.005).abs() < ROUNDING && (deep.normal[2] + 1.0).abs() < ROUNDING,
        "{deep:?}"
    );
    let inside = pair.nearest([0.0, 0.0, 0.045], UPRIGHT).unwrap().unwrap();
    assert!(
        (inside.distance_m + 0.015).abs() < ROUNDING && (inside.normal[2] + 1.0).abs() < ROUNDING,
        "{inside:?}"
    );
}

#[test]
fn truth_travel_ends_at_the_surface_or_nowhere() {
    let work = Shape::Cuboid { half_extents_m: [0.1, 0.1, 0.05] };
    for tip in [Shape::Ball { radius_m: 0.01 }, Shape::Cylinder { half_length_m: 0.01, radius_m: 0.01 }] {
        let pair = Pair::new(&tip, &Placement::default(), &work, &Placement::default()).unwrap();
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
    let vertices_m =
        (0..8).map(|i| std::array::from_fn(|k| if i >> k & 1 == 1 { 0.1 } else { -0.1 })).collect::<Vec<_>>();
    let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles = |count: usize| {
        sides[..count].iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect::<Vec<[u32; 3]>>()
    };
    let pair = |count| {
        let mesh = Shape::Mesh(Mesh { vertices_m: vertices_m.clone(), triangles: triangles(count) });
        Pair::new(
            &Shape::Ball { radius_m: 0.01 },
            &Placement::default(),
            &mesh,
            &Placement::at([1.0, 0.0, 0.0]),
        )
        .unwrap()
    };
    let depth = pair(6).buried_m([1.0, 0.0, 0.07], UPRIGHT).unwrap();
    assert!((depth - 0.03).abs() < ROUNDING, "{depth}");
    assert_eq!(pair(6).buried_m([1.0, 0.0, 0.2], UPRIGHT), None);
    assert_eq!(pair(1).buried_m([1.0, 0.0, 0.0], UPRIGHT), None);
}

/// A sphere of triangles, and the largest depth of its faces below the true sphere, m.
fn globe(radius_m: f64, count: u32) -> (Mesh, f64) {
    let mut mesh = Mesh::default();
    let around = 2 * count;
    for i in 0..=count {
        for k in 0..around {
            let (tilt, turn) = (PI * f64::from(i) / f64::from(count), PI * f64::from(k) / f64::from(count));
            mesh.vertices_m
                .push([tilt.cos(), tilt.sin() * turn.cos(), tilt.sin() * turn.sin()].map(|x| radius_m * x));
        }
    }
    for i in 0..count {
        for k in 0..around {
            let corner = |i: u32, k: u32| i * around + k % around;
            mesh.triangles.extend([
                [corner(i, k), corner(i + 1, k), corner(i + 1, k + 1)],
                [corner(i, k), corner(i + 1, k + 1), corner(i, k + 1)],
            ]);
        }
    }
    mesh.triangles.retain(|t| {
        let [a, b, c] = t.map(|i| mesh.vertices_m[i as usize]);
        let far = |p: [f64; 3], q: [f64; 3]| (0..3).map(|j| (p[j] - q[j]).powi(2)).sum::<f64>() > 1e-20;
        far(a, b) && far(b, c) && far(c, a)
    });
    (mesh, 2.0 * radius_m * (1.0 - (0.5 * PI / f64::from(count)).cos()))
}

#[test]
fn truth_a_capsule_over_triangles_has_the_distance_of_its_axis_less_its_radius() {
    let (radius, half, r) = (50e-3, 10e-3, 3e-3);
    let capsule = Shape::Capsule { half_length_m: half, radius_m: r };
    // Flat: every point of the axis is equally near; if it is tilted, the lowest end is nearest.
    let flat = Shape::HeightField { heights_m: vec![vec![0.0; 9]; 9], extents_m: [0.2; 2] };
    let pair = Pair::new(&capsule, &Placement::default(), &flat, &Placement::at([20e-3, 0.0, 0.0])).unwrap();
    let tilt = 0.3_f64;
    let turned = [0.0, 0.0, (0.5 * tilt).sin(), (0.5 * tilt).cos()];
    let over = pair.nearest([0.0162, 0.01, 0.02], UPRIGHT).unwrap().unwrap();
    assert!(
        (over.distance_m - 0.8e-3).abs() < ROUNDING && (over.normal[0] - 1.0).abs() < ROUNDING,
        "{over:?}"
    );
    let leaning = pair.nearest([0.0132, 0.01, 0.02], turned).unwrap().unwrap();
    assert!((leaning.distance_m - (6.8e-3 - half * tilt.sin() - r)).abs() < ROUNDING, "{leaning:?}");
    // An axis through the surface still has a result.
    assert!(pair.nearest([0.02, 0.0, 0.0], turned).unwrap().unwrap().distance_m < 0.0);
    let (mesh, sag) = globe(radius, 64);
    let pair = Pair::new(&capsule, &Placement::default(), &Shape::Mesh(mesh), &Placement::default()).unwrap();
    for [x, y, z] in [[53.5e-3, 0.0, 0.0], [0.0, 5e-3, 53.2e-3], [31e-3, 20e-3, 43.3e-3]] {
        let below = (f64::abs(y) - half).max(0.0);
        let own = f64::sqrt(x * x + z * z + below * below) - radius - r;
        let found = pair.nearest([x, y, z], UPRIGHT).unwrap().unwrap();
        assert!((-ROUNDING..sag).contains(&(found.distance_m - own)), "{found:?} {own}");
    }
    assert_eq!(pair.nearest([0.1, 0.0, 0.0], UPRIGHT).unwrap(), None);
}
