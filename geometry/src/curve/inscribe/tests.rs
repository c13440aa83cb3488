use super::cells::{Cells, Point};
use super::*;
use crate::curve::{CurveOptions, CurveSolver};
use crate::mesh::vector::{doubled_normal, norm};
use crate::mesh::{TriMesh, families, interpolate, shapes};
use catamaran::base::Rng;

const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Returns a triangle with points at these ascending positions on its sides.
fn triangle(sides: [&[f64]; 3]) -> Cells {
    let mut number = 0;
    Cells::new(std::array::from_fn(|i| {
        let at = |share: &f64| {
            let mut shares = [0.0; 3];
            (shares[i], shares[(i + 1) % 3]) = (1.0 - share, *share);
            number += 1;
            Point { shares, vertex: Some(number) }
        };
        [0.0].iter().chain(sides[i]).map(at).collect()
    }))
}

/// Asserts that the triangles cover the face once, have its orientation, and have the points of all
/// ways as edges.
fn check(cells: &mut Cells, chords: &[[usize; 2]]) {
    for &[a, b] in chords {
        cells.cut(a, b).unwrap();
    }
    // Once more, with the points where later chords crossed.
    let ways: Vec<Vec<usize>> = chords.iter().map(|&[a, b]| cells.cut(a, b).unwrap()).collect();
    let triangles = cells.triangles(CORNERS);
    let mut area = 0.0;
    for t in &triangles {
        let doubled = doubled_normal(t.map(|p| cells.place(p, CORNERS)))[2];
        assert!(doubled > -1e-12, "{t:?} is turned over");
        area += doubled / 2.0;
    }
    assert!((area - 0.5).abs() < 1e-12, "{area}");
    let points = cells.points.len();
    assert!((0..points).all(|p| triangles.iter().any(|t| t.contains(&p))));
    for pair in ways.iter().flat_map(|way| way.windows(2)) {
        assert!(triangles.iter().any(|t| t.contains(&pair[0]) && t.contains(&pair[1])));
    }
}

#[test]
fn points_on_sides_alone_give_triangles_none_of_which_is_flat() {
    for sides in [[1, 0, 0], [2, 0, 0], [0, 3, 1], [1, 1, 1], [5, 4, 3]] {
        let shares = sides.map(|n| (1..=n).map(move |i| f64::from(i) / f64::from(n + 1)));
        let shares = shares.map(Iterator::collect::<Vec<f64>>);
        let cells = &mut triangle(std::array::from_fn(|i| &shares[i][..]));
        check(cells, &[]);
        let flat = |t: &[usize; 3]| norm(doubled_normal(t.map(|p| cells.place(p, CORNERS)))) < 1e-9;
        assert!(!cells.triangles(CORNERS).iter().any(flat));
        assert_eq!(cells.triangles(CORNERS).len() as i32, sides.iter().sum::<i32>() + 1);
    }
}

#[test]
fn two_chords_meet_in_a_point_of_both() {
    // The points are 0 a 1 b 2 c; the chords are the medians of a and c.
    let mut cells = triangle([&[0.5], &[0.5], &[0.5]]);
    assert_eq!(cells.cut(1, 4).unwrap(), [1, 4]);
    assert_eq!(cells.cut(5, 2).unwrap(), [5, 6, 2]);
    assert_eq!(cells.cut(1, 4).unwrap(), [1, 6, 4]);
    assert_eq!(cells.cut(4, 1).unwrap(), [4, 6, 1]);
    let third = 1.0 / 3.0;
    assert!((0..3).all(|k| (cells.points[6].shares[k] - third).abs() < 1e-15));
    // The third median meets them in the same point.
    assert_eq!(cells.cut(0, 3).unwrap(), [0, 6, 3]);
    check(&mut cells, &[]);
    // Along sides.
    assert_eq!(cells.cut(0, 2).unwrap(), [0, 1, 2]);
    assert_eq!(cells.cut(0, 4).unwrap(), [0, 5, 4]);
    assert_eq!(cells.cut(3, 2).unwrap(), [3, 2]);
    assert_eq!(cells.cut(3, 3).unwrap(), [3]);
}

#[test]
fn any_chords_cut_a_face() {
    let mut rng = Rng::new(1);
    let below = |n: usize, rng: &mut Rng| (rng.bits() % n as u64) as usize;
    for _ in 0..300 {
        let shares: [Vec<f64>; 3] = std::array::from_fn(|_| {
            let mut side: Vec<f64> = (0..below(5, &mut rng)).map(|_| rng.uniform()).collect();
            // Regular points, so that three chords meet in a point.
            side.extend([0.25, 0.5, 0.75]);
            side.sort_by(f64::total_cmp);
            side
        });
        let mut cells = triangle(std::array::from_fn(|i| &shares[i][..]));
        let n = 3 + shares.iter().map(Vec::len).sum::<usize>();
        let chords: Vec<[usize; 2]> =
            (0..below(9, &mut rng)).map(|_| [below(n, &mut rng), below(n, &mut rng)]).collect();
        check(&mut cells, &chords);
    }
}

fn inscribed(mesh: &TriMesh, samples: &[u32]) -> (Curve, Inscribed) {
    let mut found =
        CurveSolver::new(mesh).unwrap().reconstruct(samples, &CurveOptions::new()).unwrap();
    found.smooth(mesh, samples).unwrap();
    (found.curves[0].clone(), inscribe(mesh, &found.curves).unwrap())
}

#[test]
fn a_smooth_curve_becomes_edges_of_the_same_surface() {
    let sphere = families::icosphere(3).unwrap();
    let torus = families::torus(40, 20, 2.0, 0.8).unwrap();
    let square = shapes::grid(9, 9);
    for (mesh, samples) in
        [(&sphere, [3, 200, 400, 500]), (&torus, [0, 405, 210, 600]), (&square, [11, 87, 28, 62])]
    {
        let (curve, drawn) = inscribed(mesh, &samples);
        let finer = &drawn.refined.mesh;
        assert!(finer.vertices().len() > mesh.vertices().len());
        assert!((finer.area() / mesh.area() - 1.0).abs() < 1e-12);
        let (old, new) = (Edges::new(mesh), Edges::new(finer));
        assert_eq!(finer.euler_characteristic(&new), mesh.euler_characteristic(&old));
        assert_eq!(finer.genus(&new), mesh.genus(&old));
        assert!(finer.inconsistent_edges(&new).is_empty());
        let along = drawn.curves[0].edges();
        assert!(along.iter().all(|ends| new.ends().binary_search(ends).is_ok()));
        assert_eq!(along.len(), drawn.curves[0].path.len());
        assert!((drawn.curves[0].length / curve.length - 1.0).abs() < 1e-5);
        assert!(samples.iter().all(|v| drawn.curves[0].path.contains(v)));
        // Vertices are at their origins.
        for (p, origin) in finer.vertices().iter().zip(&drawn.refined.vertices) {
            let corners = origin.vertices.map(|v| mesh.vertices()[v as usize]);
            assert!(distance(interpolate(origin.weights, corners), *p) < 1e-12);
        }
        // Faces are on the faces that contain them.
        let areas = drawn.refined.shares(&vec![true; finer.faces().len()]).unwrap();
        assert!(areas.iter().all(|&share| share == 1.0));
        // Drawing the same curves again, now along edges, changes nothing.
        let again = inscribe(finer, &drawn.curves).unwrap();
        assert_eq!(again.refined, Refined::new(finer.clone()));
        assert_eq!(again.curves, drawn.curves);
    }
}

#[test]
fn curves_that_cross_or_touch_share_vertices() {
    // The diagonals of a square of 4 x 4, as waypoints on vertices and edges, and a line along one.
    let mesh = shapes::grid(4, 4);
    let line = |waypoints: Vec<Waypoint>| Curve {
        order: vec![],
        path: vec![],
        points: vec![],
        waypoints,
        closed: false,
        length: 0.0,
    };
    let vertices = |all: &[u32]| line(all.iter().map(|&v| Waypoint::Vertex(v)).collect());
    // Whether the diagonals of the grid go up to the right or to the left, one of these crosses
    // them.
    let up = vertices(&[0, 6, 12, 18, 24]);
    let half = |a, b| Waypoint::Edge { ends: [a, b], share: 0.5 };
    let other = |a, b, c, d| [Waypoint::Vertex(a), half(b, c), Waypoint::Vertex(d)];
    let crossing = line(other(5, 0, 6, 1).to_vec());
    let drawn = inscribe(&mesh, &[up, crossing]);
    let Ok(drawn) = drawn else {
        panic!("the diagonals of the grid are others: {}", drawn.unwrap_err())
    };
    assert_eq!(drawn.curves[0].path, [0, 25, 6, 12, 18, 24]);
    assert_eq!(drawn.curves[1].path, [5, 25, 1]);
    assert_eq!(drawn.refined.mesh.faces().len(), 34);
}

#[test]
fn what_is_not_on_the_mesh_is_refused() {
    let mesh = shapes::grid(2, 1);
    let told = |waypoints: Vec<Waypoint>| {
        let curve = Curve {
            order: vec![],
            path: vec![],
            points: vec![],
            waypoints,
            closed: false,
            length: 0.0,
        };
        inscribe(&mesh, &[curve]).unwrap_err().to_string()
    };
    let edge = |ends, share| Waypoint::Edge { ends, share };
    assert!(told(vec![Waypoint::Vertex(6)]).contains("no vertex 6"));
    assert!(told(vec![edge([0, 2], 0.5)]).contains("no edge 0-2"));
    assert!(told(vec![edge([0, 1], 1.5)]).contains("1.5 of 0-1"));
    assert!(told(vec![edge([1, 0], f64::NAN)]).contains("NaN"));
    assert!(told(vec![Waypoint::Vertex(0), Waypoint::Vertex(2)]).contains("no face has both"));
    let none = inscribe(&mesh, &[]).unwrap();
    assert_eq!((none.refined.mesh, none.curves.len()), (mesh.clone(), 0));
}
