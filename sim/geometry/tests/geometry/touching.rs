//! Gap, slope and profile against closed forms.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;

use feeler_geometry::{
    Feed, GeometryError, Mesh, Placement, Shape, Touching, read_height_field, read_obj, read_stl,
};

/// Rounding of positions of a few centimetres through a distance query and some Newton steps.
const ROUNDING_M: f64 = 1e-12;
/// Parry's distances between a capsule and a triangle come from an iteration. It ends at about the square
/// root of rounding, relative to sizes of a few centimetres.
const ITERATED_M: f64 = 1e-9;

/// Touching points, m, and normals are linear between knots. These are 0.6 mm apart on a ball of 53 mm, which
/// gives (0.6 / 53)^2 / 8 of a normal.
const STRAIGHT: f64 = 2e-5;

fn origin() -> Placement {
    Placement::at([0.0; 3])
}

/// A ball of triangles between circles of latitude.
fn globe(radius_m: f64, rings: u32) -> Mesh {
    let around = 2 * rings;
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        let polar = TAU / 2.0 * f64::from(i) / f64::from(rings);
        for k in 0..around {
            let azimuth = TAU * f64::from(k) / f64::from(around);
            mesh.vertices_m.push([
                radius_m * polar.cos(),
                radius_m * polar.sin() * azimuth.cos(),
                radius_m * polar.sin() * azimuth.sin(),
            ]);
        }
    }
    for i in 0..rings {
        for k in 0..around {
            let [a, b] = [i * around + k, i * around + (k + 1) % around];
            mesh.triangles.push([a, b, a + around]);
            mesh.triangles.push([b, b + around, a + around]);
        }
    }
    mesh
}

#[test]
fn truth_ball_on_cuboid_face_and_edge() {
    let (r, half) = (2e-3, 10e-3);
    let tip = Shape::Ball { radius_m: r };
    let work = Shape::Cuboid { half_extents_m: [half; 3] };
    let touching = Touching::new(&tip, &origin(), &work, &Placement::at([30e-3, 0.0, 0.0])).unwrap();
    let face = touching.at([3e-3, -4e-3]).unwrap();
    assert!((face.travel_m - (20e-3 - r)).abs() < ROUNDING_M, "{face:?}");
    assert!(
        (face.normal[0] - 1.0).abs() < ROUNDING_M && face.slope.iter().all(|s| s.abs() < ROUNDING_M),
        "{face:?}"
    );
    assert!(
        (face.point_m[0] - 20e-3).abs() < ROUNDING_M && (face.point_m[1] - 3e-3).abs() < ROUNDING_M,
        "{face:?}"
    );
    // Beyond the edge by e the ball rolls over it: travel = 20 mm - sqrt(r^2 - e^2), slope e / sqrt(r^2 -
    // e^2).
    let e = 1.2e-3;
    let reach = f64::sqrt(r * r - e * e);
    let edge = touching.at([half + e, 0.0]).unwrap();
    assert!((edge.travel_m - (20e-3 - reach)).abs() < ROUNDING_M, "{edge:?}");
    assert!((edge.slope[0] - e / reach).abs() < 1e-9, "{edge:?}");
    let missed = touching.at([half + 1.1 * r, 0.0]).unwrap_err();
    assert!(matches!(missed, GeometryError::Unreachable { .. }), "{missed}");
}

#[test]
fn truth_ball_on_mesh_ball() {
    let (r, radius, rings) = (4e-3, 30e-3, 48);
    let touching = Touching::new(
        &Shape::Ball { radius_m: r },
        &origin(),
        &Shape::Mesh(globe(radius, rings)),
        &Placement::at([0.1, 0.0, 0.0]),
    )
    .unwrap();
    // A chord of angle a lies below its arc by R (1 - cos(a/2)). A facet's middle lies below the ball by at
    // most the sum over both directions. Along x this grows by one over the normal's component.
    let sag = 2.0 * radius * (1.0 - (TAU / 2.0 / f64::from(rings) / 2.0).cos());
    for (y, z) in [(0.0, 0.0), (5e-3, 0.0), (-7e-3, 9e-3), (0.0, 15e-3)] {
        let beside: f64 = f64::hypot(y, z);
        let ahead = f64::sqrt((r + radius).powi(2) - beside * beside);
        let touch = touching.at([y, z]).unwrap();
        let late = touch.travel_m - (0.1 - ahead);
        assert!(late > -ROUNDING_M && late < sag * (r + radius) / ahead, "{y} {z}: {late} of {sag}");
        // Facets lean by at most half their angle against the ball, seen from the tip's centre.
        let slope = y / ahead;
        assert!(
            (touch.slope[0] - slope).abs() < 2.0 * TAU / 2.0 / f64::from(rings),
            "{} {slope}",
            touch.slope[0]
        );
    }
}

#[test]
fn truth_capsule_on_a_sloping_height_field() {
    let (r, half, rise_y, rise_z) = (3e-3, 8e-3, 0.2, -0.35);
    let extent = 0.2;
    let heights: Vec<Vec<f64>> = (0..21)
        .map(|i| {
            (0..31)
                .map(|k| {
                    rise_y * extent * (f64::from(k) / 30.0 - 0.5)
                        + rise_z * extent * (f64::from(i) / 20.0 - 0.5)
                })
                .collect()
        })
        .collect();
    let text: String = heights
        .iter()
        .map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n")
        .collect();
    let work = read_height_field(&text, [extent; 2]).unwrap();
    for rotation in [[0.0; 3], [FRAC_PI_2, 0.0, 0.0]] {
        let tip_place = Placement { position_m: [0.0; 3], rotation_rad: rotation };
        let touching = Touching::new(
            &Shape::Capsule { half_length_m: half, radius_m: r },
            &tip_place,
            &work,
            &Placement::at([0.05, 0.0, 0.0]),
        )
        .unwrap();
        for (y, z) in [(0.0, 0.0), (11e-3, -7e-3), (-23e-3, 31e-3)] {
            // The surface is x = 0.05 - a y - b z; the end of the line on the rising side touches first, at
            // distance r.
            let norm = (1.0 + rise_y * rise_y + rise_z * rise_z).sqrt();
            let end = if rotation[0] == 0.0 { rise_y * half } else { rise_z.abs() * half };
            let expected = 0.05 - rise_y * y - rise_z * z - end - r * norm;
            let touch = touching.at([y, z]).unwrap();
            assert!((touch.travel_m - expected).abs() < ITERATED_M, "{} {expected}", touch.travel_m);
            assert!(
                (touch.slope[0] + rise_y).abs() < 1e-6 && (touch.slope[1] + rise_z).abs() < 1e-6,
                "{:?}",
                touch.slope
            );
        }
    }
}

#[test]
fn truth_rates_along_a_feed_over_a_cylinder() {
    let (r, radius, speed) = (5e-3, 40e-3, 10e-3);
    let work = Shape::Cylinder { half_length_m: 0.1, radius_m: radius };
    // The axis of the workpiece is along z.
    let place = Placement { position_m: [0.1, 0.0, 0.0], rotation_rad: [FRAC_PI_2, 0.0, 0.0] };
    let touching = Touching::new(&Shape::Ball { radius_m: r }, &origin(), &work, &place).unwrap();
    let asked_m = 1e-8;
    let found = touching.profile(&Feed::line([-10e-3, 0.0], [speed, 0.0]), 2.0, asked_m).unwrap();
    assert!(found.error_m <= asked_m);
    for i in 0..=200 {
        let t = 0.01 * f64::from(i);
        let y = -10e-3 + speed * t;
        let ahead = f64::sqrt((r + radius).powi(2) - y * y);
        let (offset, rate) = found.profile.at(t);
        // Parry's distance from a ball to a convex body is iterative. The error of the rate is the error of
        // the offset over the length of a piece, 31 ms, times 3.08 for the slope of a cubic.
        assert!((offset - (0.1 - ahead)).abs() < 2.0 * asked_m, "{t}: {offset}");
        assert!(t >= 2.0 || (rate - speed * y / ahead).abs() < 1e-5, "{t}: {rate} {}", speed * y / ahead);
    }
}

#[test]
fn order_profiles_keep_the_error_asked_for() {
    let tip = Shape::Ball { radius_m: 2e-3 };
    let work = Shape::Cuboid { half_extents_m: [10e-3; 3] };
    let touching = Touching::new(&tip, &origin(), &work, &Placement::at([30e-3, 0.0, 0.0])).unwrap();
    // From the face and 1.5 mm over the edge: smooth except for the jump of curvature at the edge.
    let feed = Feed::line([5e-3, 0.0], [6.5e-3, 0.0]);
    let mut knots = Vec::new();
    for asked_m in [1e-6, 1e-8, 1e-10] {
        let found = touching.profile(&feed, 1.0, asked_m).unwrap();
        let worst = (0..=5000).map(|i| {
            let t = 2e-4 * f64::from(i);
            let e = (5e-3 + 6.5e-3 * t - 10e-3).max(0.0);
            (found.profile.at(t).0 - (20e-3 - f64::sqrt(4e-6 - e * e))).abs()
        });
        // The bound comes from three probes of each piece; between them a cubic may err by half as much
        // again.
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 1.5 * asked_m, "{worst} {asked_m}");
        knots.push(found.profile.knots().len());
    }
    assert!(knots[0] < knots[1] && knots[1] < knots[2] && knots[2] < 2000, "{knots:?}");
}

#[test]
fn truth_a_smooth_path_passes_its_points() {
    let feed = Feed::read_path("t_s,y_m,z_m\n0,0,0\n1,0.01,0\n3,0.01,0.02\n").unwrap();
    let plane = Shape::HeightField { heights_m: vec![vec![0.05, -0.05]; 2], extents_m: [0.1; 2] };
    let touching =
        Touching::new(&Shape::Ball { radius_m: 1e-3 }, &origin(), &plane, &Placement::at([0.2, 0.0, 0.0]))
            .unwrap();
    let found = touching.profile(&feed, 4.0, 1e-9).unwrap();
    // The surface x = 0.2 + y: the gap follows y.
    let start = found.profile.at(0.0).0;
    for (t, y) in [(1.0, 0.01), (3.0, 0.01), (3.7, 0.01)] {
        assert!((found.profile.at(t).0 - start - y).abs() < 1e-9, "{t}");
    }
    assert!(found.profile.at(3.7).1.abs() < 1e-9);
}

#[test]
fn truth_a_flat_tip_against_a_step_is_a_jump() {
    let step = Shape::Mesh(Mesh {
        vertices_m: vec![
            [0.0, -1.0, -1.0],
            [0.0, 0.0, -1.0],
            [0.0, 0.0, 1.0],
            [0.0, -1.0, 1.0],
            [-0.01, 0.0, -1.0],
            [-0.01, 1.0, -1.0],
            [-0.01, 1.0, 1.0],
            [-0.01, 0.0, 1.0],
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [1, 4, 7], [1, 7, 2]],
    });
    let tip = Shape::Cuboid { half_extents_m: [1e-3; 3] };
    let touching = Touching::new(&tip, &origin(), &step, &Placement::at([0.1, 0.0, 0.0])).unwrap();
    let error = touching.profile(&Feed::line([-0.01, 0.0], [0.02, 0.0]), 1.0, 1e-8).unwrap_err();
    let GeometryError::Jump { t_s, jump_m } = error else { panic!("{error}") };
    // The tip's side meets the wall at y = 0 when its middle is 1 mm before it, at 0.45 s.
    assert!((t_s - 0.45).abs() < 1e-3 && (jump_m - 0.01).abs() < 1e-4, "{t_s} {jump_m}");
}

#[test]
fn truth_stl_and_obj_give_the_same_mesh() {
    let obj = "# a triangle and a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 2\nf 1 2 5\nf 1/1/1 \
               2/2/2 3/3/3 -2\n";
    let mesh = read_obj(obj, 1e-3).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 4], [0, 1, 2], [0, 2, 3]]);
    let mut text = String::from("solid part\n");
    let mut bytes = vec![0_u8; 80];
    bytes.extend(3_u32.to_le_bytes());
    for triangle in &mesh.triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        bytes.extend([0_u8; 12]);
        for corner in triangle.map(|i| mesh.vertices_m[i as usize].map(|x| 1e3 * x)) {
            writeln!(text, "  vertex {} {} {}", corner[0], corner[1], corner[2]).unwrap();
            bytes.extend(corner.iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
        text += "endloop\nendfacet\n";
        bytes.extend([0_u8; 2]);
    }
    let corners = |mesh: &Mesh| {
        mesh.triangles.iter().flatten().map(|&i| mesh.vertices_m[i as usize]).collect::<Vec<_>>()
    };
    for stl in [text.as_bytes(), bytes.as_slice()] {
        assert_eq!(corners(&read_stl(stl, 1e-3).unwrap()), corners(&mesh));
    }
    let cut = read_stl(&bytes[..bytes.len() - 7], 1.0).unwrap_err().to_string();
    assert!(cut.contains("cut short"), "{cut}");
}

#[test]
fn truth_bad_shapes_are_refused() {
    let ball = |radius_m| {
        Touching::new(&Shape::Ball { radius_m }, &origin(), &Shape::Ball { radius_m: 1.0 }, &origin())
            .unwrap_err()
    };
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(ball(radius).to_string().contains("radius of a ball"), "{}", ball(radius));
    }
    let flat = Shape::Hull {
        points_m: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.3, 0.4, 0.0]],
    };
    let error = Touching::new(&flat, &origin(), &flat, &origin()).unwrap_err();
    assert_eq!(error, GeometryError::Hull { points: 5 });
    assert!(matches!(read_obj("v 0 0\n", 1.0), Err(GeometryError::Line { line: 1, .. })));
    assert!(matches!(read_obj("v 0 0 0\nf 1 2 3\n", 1.0), Err(GeometryError::Line { line: 2, .. })));
    assert!(matches!(read_obj("", 1.0), Err(GeometryError::Mesh { .. })));
    assert!(matches!(read_stl(b"solid nothing", 1.0), Err(GeometryError::Mesh { .. })));
    assert!(matches!(read_height_field("0,1\n0\n", [1.0; 2]), Err(GeometryError::Line { line: 2, .. })));
    assert!(matches!(read_height_field("0,x\n", [1.0; 2]), Err(GeometryError::Line { line: 1, .. })));
    assert!(matches!(Feed::read_path("t,y,z\n0,0,0\n"), Err(GeometryError::Line { line: 1, .. })));
    assert!(matches!(
        Feed::read_path("t_s,y_m,z_m\n0,0,0\n0,1,1\n"),
        Err(GeometryError::Path { index: 1, .. })
    ));
    assert!(matches!(Feed::path(&[]), Err(GeometryError::EmptyPath)));
}

#[test]
fn truth_a_hull_touches_where_its_corner_is() {
    // A pyramid that points at the workpiece.
    let tip = Shape::Hull {
        points_m: vec![
            [6e-3, 1e-3, 0.0],
            [0.0, 3e-3, 3e-3],
            [0.0, 3e-3, -3e-3],
            [0.0, -3e-3, 3e-3],
            [0.0, -3e-3, -3e-3],
        ],
    };
    let work = Shape::Cuboid { half_extents_m: [10e-3; 3] };
    let touching = Touching::new(&tip, &origin(), &work, &Placement::at([30e-3, 0.0, 0.0])).unwrap();
    let touch = touching.at([0.0, 0.0]).unwrap();
    assert!((touch.travel_m - 14e-3).abs() < ITERATED_M, "{touch:?}");
    let found = touching.profile(&Feed::line([0.0; 2], [0.0; 2]), 1.0, 1e-9).unwrap();
    assert!(found.check_start(13e-3).is_ok());
    let inside = found.check_start(15e-3).unwrap_err();
    assert!(
        matches!(inside, GeometryError::Overlap { depth_m } if (depth_m - 1e-3).abs() < 1e-8),
        "{inside}"
    );
}

/// Points of a ball in rings about x, or about y.
fn rings(count: u32, radius_m: f64, about_x: bool) -> Vec<[f64; 3]> {
    let point = |i: u32, k: u32| {
        let (tilt, turn) = (PI * f64::from(i) / f64::from(count), TAU * f64::from(k) / f64::from(count));
        let p = [tilt.cos(), tilt.sin() * turn.cos(), tilt.sin() * turn.sin()].map(|x| radius_m * x);
        if about_x { p } else { [p[1], p[2], p[0]] }
    };
    (0..=count).flat_map(|i| (0..count).map(move |k| point(i, k))).collect()
}

#[test]
fn regress_a_hull_of_many_points_is_travelled_over() {
    let (r, radius_m, ahead_m, asked_m) = (3e-3, 50e-3, 60e-3, 1e-8);
    for (count, about_x) in [(24, true), (64, true), (64, false), (96, true)] {
        let work = Shape::Hull { points_m: rings(count, radius_m, about_x) };
        for z in [0.0, 1e-3, 2.7e-3] {
            let touching = Touching::new(
                &Shape::Ball { radius_m: r },
                &origin(),
                &work,
                &Placement::at([ahead_m, 0.0, z]),
            )
            .unwrap();
            let found = touching.profile(&Feed::line([-20e-3, 0.0], [40e-3, 0.0]), 1.0, asked_m).unwrap();
            assert!(found.error_m <= asked_m, "{count} {about_x} {z}: {}", found.error_m);
            // The facets lie within the ball by no more than the sag of their edges, in both directions.
            let sag_m = 2.0 * radius_m * (1.0 - (PI / f64::from(count)).cos());
            for i in 0..=200 {
                let t = f64::from(i) / 200.0;
                let y = -20e-3 + 40e-3 * t;
                let own = ahead_m - f64::sqrt((r + radius_m).powi(2) - y * y - z * z);
                let beyond = found.profile.at(t).0 - own;
                assert!((-2.0 * asked_m..sag_m).contains(&beyond), "{count} {about_x} {z} at {y}: {beyond}");
            }
        }
    }
}

#[test]
fn regress_steps_below_the_error_asked_for_are_no_walls() {
    // Two terraces, the second 5 um higher.
    let terrace = |y: f64, x: f64| [[x, y, -1.0], [x, y + 1.0, -1.0], [x, y + 1.0, 1.0], [x, y, 1.0]];
    let vertices_m = [terrace(-1.0, 0.0), terrace(0.0, -5e-6)].concat();
    let step = Shape::Mesh(Mesh { vertices_m, triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]] });
    let tip = Shape::Ball { radius_m: 1e-3 };
    let touching = Touching::new(&tip, &origin(), &step, &Placement::at([0.1, 0.0, 0.0])).unwrap();
    let feed = Feed::line([-0.01, 0.0], [0.02, 0.0]);
    for asked_m in [1e-4, 1e-5, 1e-8] {
        let found = touching.profile(&feed, 1.0, asked_m).unwrap();
        assert!(
            found.error_m <= asked_m && (found.profile.at(0.9).0 - (0.1 - 1e-3 - 5e-6)).abs() < 2.0 * asked_m,
            "{asked_m}"
        );
    }
    let flat = Shape::Cuboid { half_extents_m: [1e-3; 3] };
    let touching = Touching::new(&flat, &origin(), &step, &Placement::at([0.1, 0.0, 0.0])).unwrap();
    let found = touching.profile(&feed, 1.0, 1e-5).unwrap();
    assert!(
        (found.profile.at(0.9).0 - found.profile.at(0.1).0 + 5e-6).abs() < 1e-9,
        "{:?}",
        found.profile.at(0.9)
    );
}

#[test]
fn truth_a_profile_knows_where_the_shapes_touch() {
    let (r, radius_m, ahead_m) = (3e-3, 50e-3, 60e-3);
    let touching = Touching::new(
        &Shape::Ball { radius_m: r },
        &origin(),
        &Shape::Ball { radius_m },
        &Placement::at([ahead_m, 0.0, 0.0]),
    )
    .unwrap();
    let found = touching.profile(&Feed::line([-20e-3, 0.0], [40e-3, 0.0]), 1.0, 1e-8).unwrap();
    for i in 0..=100 {
        let t = f64::from(i) / 100.0;
        let y = -20e-3 + 40e-3 * t;
        let [px, py, pz, nx, ny, nz] = found.profile.touch_at(t).unwrap();
        let sine = y / (r + radius_m);
        let cosine = f64::sqrt(1.0 - sine * sine);
        let expected = [ahead_m - radius_m * cosine, radius_m * sine, 0.0, cosine, -sine, 0.0];
        for (found, expected) in [px, py, pz, nx, ny, nz].into_iter().zip(expected) {
            assert!((found - expected).abs() < STRAIGHT, "{t}: {found} {expected}");
        }
    }
}

/// At the bottom of a valley the ball changes sides within the shortest piece. It is not a wall, and the
/// error message gives the achievable error.
#[test]
fn regress_an_error_beyond_what_pieces_keep_is_told_as_such() {
    let valley = Shape::Mesh(Mesh {
        vertices_m: vec![
            [0.0, -1.0, -1.0],
            [0.0, -1.0, 1.0],
            [0.5, 0.0, -1.0],
            [0.5, 0.0, 1.0],
            [0.0, 1.0, -1.0],
            [0.0, 1.0, 1.0],
        ],
        triangles: vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
    });
    let touching =
        Touching::new(&Shape::Ball { radius_m: 1e-3 }, &origin(), &valley, &Placement::at([0.1, 0.0, 0.0]))
            .unwrap();
    let feed = Feed::line([-0.013, 0.0], [0.04, 0.0]);
    let Err(GeometryError::Unresolved { apart_m, .. }) = touching.profile(&feed, 1.0, 1e-13) else {
        panic!("an error of 1e-13 m is kept")
    };
    assert!(apart_m < 1e-8, "{apart_m}");
    assert!(touching.profile(&feed, 1.0, 2.0 * apart_m).is_ok(), "the error that it says can be had");
}
