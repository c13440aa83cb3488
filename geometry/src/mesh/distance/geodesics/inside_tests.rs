//! Exact distances and paths whose ends are inside faces and on edges.

use super::tests::{check_parts, cube, moved, random_surface};
use super::*;
use crate::mesh::vector::distance;
use crate::mesh::{SurfacePoint, families, shapes};
use catamaran::base::Rng;

/// Returns a random point inside a random face, or, every third, on an edge of it.
fn random_point(mesh: &TriMesh, rng: &mut Rng) -> SurfacePoint {
    let face = (rng.bits() % mesh.faces().len() as u64) as u32;
    let mut weights = [0, 1, 2].map(|_| 0.02 + rng.uniform());
    let corner = (rng.bits() % 9) as usize;
    if corner < 3 {
        weights[corner] = 0.0;
    }
    let sum: f64 = weights.iter().sum();
    SurfacePoint { face, weights: weights.map(|w| w / sum) }
}

fn path(mesh: &TriMesh, from: impl Into<Site>, to: impl Into<Site>) -> GeodesicPath {
    Geodesics::new(mesh).unwrap().path(&[from.into()], to.into()).unwrap()
}

#[test]
fn distances_from_points_inside_faces_of_a_plane_are_euclidean() {
    let mut rng = Rng::new(7);
    let bent = moved(&shapes::grid(6, 6), |[x, y, _]| [x + 0.4 * y, y, 0.3 * x - 1.1 * y]);
    for mesh in [bent, families::slivers(8, 5, 1e-3).unwrap(), families::disk(4, 11).unwrap()] {
        let solver = Geodesics::new(&mesh).unwrap();
        let largest = mesh.vertices().iter().map(|&p| distance(p, mesh.vertices()[0]));
        let largest = largest.fold(0.0, f64::max);
        for _ in 0..20 {
            let [a, b] = [(); 2].map(|()| random_point(&mesh, &mut rng));
            let found = solver.distances(&[a.into()]).unwrap();
            for (d, &p) in found.iter().zip(mesh.vertices()) {
                let right = distance(p, a.position(&mesh));
                assert!((d - right).abs() <= 1e-11 * largest, "{a:?}: {d} and {right}");
            }
            let path = solver.path(&[a.into()], b.into()).unwrap();
            let right = distance(a.position(&mesh), b.position(&mesh));
            assert!((path.length - right).abs() <= 1e-11 * largest, "{a:?} {b:?}");
            let points = path.positions(&mesh);
            let ends = [(points[0], a), (points[points.len() - 1], b)];
            assert!(ends.iter().all(|(p, end)| distance(*p, end.position(&mesh)) < 1e-13));
            check_parts(&mesh, &path);
        }
    }
}

/// Returns the mesh with a point as a vertex after its own, which cuts the faces that have it.
fn with_vertex(mesh: &TriMesh, point: SurfacePoint) -> TriMesh {
    let position = point.position(mesh);
    let (mut vertices, faces) = mesh.clone().into_parts();
    let new = vertices.len() as u32;
    vertices.push(position);
    let own = faces[point.face as usize];
    let off: Vec<u32> = (0..3).filter(|&k| point.weights[k] == 0.0).map(|k| own[k]).collect();
    let on: Vec<u32> = own.into_iter().filter(|v| !off.contains(v)).collect();
    let cut = faces.iter().enumerate().flat_map(|(f, &face)| {
        let has = if off.is_empty() {
            f == point.face as usize
        } else {
            on.iter().all(|v| face.contains(v))
        };
        if !has {
            return vec![face];
        }
        // The new vertex in place of each end of the edge, or of each corner.
        let replaced = (0..3).filter(|&k| on.contains(&face[k]));
        replaced
            .map(|k| {
                let mut piece = face;
                piece[k] = new;
                piece
            })
            .collect()
    });
    let faces = cut.collect();
    TriMesh::new(vertices, faces).unwrap()
}

#[test]
fn distances_from_points_inside_faces_are_those_from_vertices_that_cut_the_faces() {
    let mut rng = Rng::new(19);
    for round in 0..90 {
        let mesh = random_surface(round, &mut rng);
        let n = mesh.vertices().len() as u32;
        let [a, b] = [(); 2].map(|()| random_point(&mesh, &mut rng));
        let solver = Geodesics::new(&mesh).unwrap();
        let found = solver.distances(&[a.into()]).unwrap();
        let cut = with_vertex(&mesh, a);
        let right = Geodesics::new(&cut).unwrap().distances(&[Site::Vertex(n)]).unwrap();
        for (v, (d, right)) in found.iter().zip(&right).enumerate() {
            let same = d == right || (d - right).abs() < 1e-10;
            assert!(same, "round {round}, from {a:?} to {v}: {d} instead of {right}");
            // And back.
            let back = path(&mesh, v as u32, a);
            let same = back.length == *right || (back.length - right).abs() < 1e-10;
            assert!(same, "round {round}, from {v} to {a:?}: {} not {right}", back.length);
            check_parts_if_there(&mesh, &back);
        }
        // Between two: the one is a vertex, and the other in a face that this did not cut.
        let is_cut = |face: u32| !cut.faces().contains(&mesh.faces()[face as usize]);
        if !is_cut(b.face) {
            let face = cut.faces().iter().position(|f| *f == mesh.faces()[b.face as usize]);
            let other = SurfacePoint { face: face.unwrap() as u32, ..b };
            let (direct, right) = (path(&mesh, a, b), path(&cut, n, other));
            let same =
                direct.length == right.length || (direct.length - right.length).abs() < 1e-10;
            assert!(same, "round {round}, {a:?} {b:?}: {} not {}", direct.length, right.length);
            check_parts_if_there(&mesh, &direct);
        }
    }
}

fn check_parts_if_there(mesh: &TriMesh, path: &GeodesicPath) {
    if path.length.is_finite() {
        check_parts(mesh, path);
    } else {
        assert!(path.points.is_empty());
    }
}

#[test]
fn the_exact_distance_of_the_middles_of_opposite_sides_of_a_cube_is_2() {
    let mesh = cube();
    let at = |face, weights| SurfacePoint { face, weights };
    // The middles of the sides z = 0 and z = 1 are those of the diagonals 1 2 and 5 6.
    let (below, above) = (at(0, [0.0, 0.5, 0.5]), at(3, [0.5, 0.0, 0.5]));
    assert_eq!(below.position(&mesh), [0.5, 0.5, 0.0]);
    assert_eq!(above.position(&mesh), [0.5, 0.5, 1.0]);
    assert!((path(&mesh, below, above).length - 2.0).abs() < 1e-14);
    // The same point, named in the other face of the edge, and in the same face.
    assert!(path(&mesh, below, at(1, [0.5, 0.5, 0.0])).length < 1e-15);
    let near = at(0, [0.1, 0.4, 0.5]);
    let right = distance(below.position(&mesh), near.position(&mesh));
    assert!((path(&mesh, below, near).length - right).abs() < 1e-14);
}

#[test]
fn a_point_of_a_face_that_is_a_vertex_is_the_vertex() {
    let mesh = cube();
    let solver = Geodesics::new(&mesh).unwrap();
    for face in 0..12 {
        let point = SurfacePoint { face, weights: [0.0, 1.0, 0.0] };
        let vertex = Site::Vertex(mesh.faces()[face as usize][1]);
        let near = Site::Near(point.position(&mesh).map(|x| 1.1 * x - 0.05));
        let found = [point.into(), vertex, near].map(|site| solver.distances(&[site]).unwrap());
        assert!(found[0] == found[1] && found[1] == found[2]);
    }
}

#[test]
fn distances_from_points_of_faces_without_area_are_straight() {
    // A square, whose diagonal 0 2 has the flat face 0 2 4 between its two halves.
    let vertices =
        vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 0.0]];
    let faces = vec![[0, 1, 2], [0, 2, 4], [0, 4, 3], [4, 2, 3]];
    let mesh = TriMesh::new(vertices, faces).unwrap();
    let solver = Geodesics::new(&mesh).unwrap();
    let at = |weights| Site::Face(SurfacePoint { face: 1, weights });
    for (site, place) in [
        (Site::Vertex(4), 0.5),
        (at([0.5, 0.2, 0.3]), 0.35),
        (at([0.3, 0.7, 0.0]), 0.7),
        (at([0.4, 0.0, 0.6]), 0.3),
    ] {
        let found = solver.distances(&[site]).unwrap();
        for (v, &p) in mesh.vertices().iter().enumerate() {
            let right = distance(p, [place, place, 0.0]);
            assert!((found[v] - right).abs() < 1e-14, "{site:?} to {v}: {} {right}", found[v]);
            let back = path(&mesh, v as u32, site);
            assert!((back.length - right).abs() < 1e-14, "{v} to {site:?}: {}", back.length);
        }
    }
}

#[test]
fn positions_that_a_mesh_does_not_have_are_refused_by_the_name_of_the_argument() {
    let mesh = cube();
    let solver = Geodesics::new(&mesh).unwrap();
    let (there, at) = (Site::Vertex(0), |face, weights| SurfacePoint { face, weights }.into());
    for (wrong, why) in [
        (at(12, [1.0, 0.0, 0.0]), "face 12 is out of range: 12 faces, numbered from 0"),
        (at(3, [0.5, 0.6, 0.0]), "face 3: wrong barycentric coordinates [0.5, 0.6, 0.0]"),
        (at(3, [f64::NAN, 0.6, 0.0]), "face 3: wrong"),
        (Site::Vertex(8), "vertex 8 is out of range: 8 vertices, numbered from 0"),
        (Site::Near([0.0, f64::INFINITY, 0.0]), "finite"),
    ] {
        let said = [
            ("sources", solver.distances(&[there, wrong]).map(drop)),
            ("sources", solver.path(&[wrong], there).map(drop)),
            ("end", solver.path(&[there], wrong).map(drop)),
            ("through", solver.path_through(&[wrong, there]).map(drop)),
            ("through", solver.path_through(&[there, wrong]).map(drop)),
            ("start", solver.trace(wrong, [1.0, 0.0, 0.0], 1.0).map(drop)),
        ];
        for (what, result) in said {
            let said = result.unwrap_err().to_string();
            assert!(said.starts_with(&format!("{what}: ")) && said.contains(why), "{said}");
        }
    }
}
