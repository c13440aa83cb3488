//! Generated meshes are what they promise, topology and measures have exact values, and the shared
//! meshes agree with their index.

use std::f64::consts::PI;

use catamaran::{Error, Par};
use catamaran_geometry::mesh::families::{self, Bend};
use catamaran_geometry::mesh::{Components, Edges, Genus, Normalization, Problem, TriMesh, io};

use crate::triangles::intersecting;

/// A mesh, and what was promised of it.
struct Case {
    name: &'static str,
    mesh: TriMesh,
    vertices: usize,
    faces: usize,
    components: usize,
    loops: usize,
    genus: Genus,
}

fn case(
    name: &'static str,
    mesh: catamaran::Result<TriMesh>,
    [vertices, faces, components, loops]: [usize; 4],
    genus: usize,
) -> Case {
    let genus = Genus::Orientable(genus);
    Case { name, mesh: mesh.expect(name), vertices, faces, components, loops, genus }
}

/// Manifolds, oriented where they can be.
fn manifolds() -> Vec<Case> {
    let mut cases = vec![
        case("icosahedron", families::icosphere(0), [12, 20, 1, 0], 0),
        case("icosphere", families::icosphere(3), [642, 1280, 1, 0], 0),
        case("spheres", families::spheres(3, 1), [126, 240, 3, 0], 0),
        case("no spheres", families::spheres(0, 1), [0, 0, 0, 0], 0),
        case("smallest torus", families::torus(3, 3, 2.0, 1.0), [9, 18, 1, 0], 1),
        case("torus", families::torus(31, 17, 2.0, 0.5), [527, 1054, 1, 0], 1),
        case("trefoil", families::knot(2, 3, 101, 7, 0.2), [707, 1414, 1, 0], 1),
        case("unknot", families::knot(1, 1, 50, 5, 0.1), [250, 500, 1, 0], 1),
        case("slab", families::genus(0, 2), [58, 112, 1, 0], 0),
        case("genus 1", families::genus(1, 1), [32, 64, 1, 0], 1),
        case("genus 3", families::genus(3, 3), [608, 1224, 1, 0], 3),
        case("figure", families::figure(2, 0.0), [602, 1200, 1, 0], 0),
        case("posed figure", families::figure(3, 1.0), [1352, 2700, 1, 0], 0),
        case("smallest grid", families::grid(1, 1), [4, 2, 1, 1], 0),
        case("grid", families::grid(7, 5), [48, 70, 1, 1], 0),
        case("terrain", families::terrain(20, 11, 1), [252, 440, 1, 1], 0),
        case("smallest disk", families::disk(1, 3), [4, 3, 1, 1], 0),
        case("disk", families::disk(4, 9), [37, 63, 1, 1], 0),
        case("cylinder", families::cylinder(5, 3, 1.0, 2.0), [20, 30, 1, 2], 0),
        case("slivers", families::slivers(10, 10, 1e-4), [121, 200, 1, 1], 0),
        case("two pages", families::pages(2), [4, 2, 1, 1], 0),
    ];
    let moebius = [("smallest Moebius", 3, 1, [6, 6, 1, 1]), ("Moebius", 40, 3, [160, 240, 1, 1])];
    for (name, around, across, counts) in moebius {
        let mut strip = case(name, families::moebius(around, across), counts, 0);
        strip.genus = Genus::NonOrientable(1);
        cases.push(strip);
    }
    cases
}

#[test]
fn families_have_the_promised_counts_genus_and_boundary() {
    for Case { name, mesh, vertices, faces, components, loops, genus } in manifolds() {
        let report = mesh.validate();
        assert_eq!((report.vertices, report.faces), (vertices, faces), "{name}");
        assert_eq!(report.components, components, "{name}");
        assert_eq!(report.boundary_loops, Some(loops), "{name}");
        assert_eq!(report.genus, Some(genus), "{name}");
        assert_eq!(report.is_closed(), loops == 0, "{name}");
        // By the definition of the genus.
        let (handles, sides) = match genus {
            Genus::Orientable(g) => (g as i64, 2),
            Genus::NonOrientable(g) => (g as i64, 1),
        };
        let euler = 2 * components as i64 - sides * handles - loops as i64;
        assert_eq!(report.euler_characteristic, euler, "{name}");
        let expected = match genus {
            Genus::Orientable(_) if name == "two pages" || faces == 0 => 1,
            Genus::Orientable(_) => 0,
            // The seam, and the statement.
            Genus::NonOrientable(_) => report.problems.len().max(2),
        };
        assert_eq!(report.problems.len(), expected, "{name}: {report}");
        assert!(mesh.require_manifold().is_ok(), "{name}");
        assert_eq!(mesh.require_closed().is_ok(), loops == 0, "{name}");
    }
}

#[test]
fn closed_families_are_seen_counter_clockwise_from_outside() {
    for Case { name, mesh, loops, genus, vertices, .. } in manifolds() {
        if loops == 0 && vertices > 0 && matches!(genus, Genus::Orientable(_)) {
            assert!(mesh.volume().unwrap() > 0.0, "{name}: {:?}", mesh.volume());
        }
    }
    for flat in [families::grid(3, 4), families::disk(2, 7), families::terrain(9, 9, 3)] {
        assert!(flat.unwrap().face_normals().iter().all(|n| n[2] > 0.0));
    }
}

#[test]
fn arguments_out_of_range_are_refused_before_any_work() {
    let refused = [
        families::icosphere(14),
        families::icosphere(u32::MAX),
        families::spheres(usize::MAX, 0),
        families::grid(0, 5),
        families::grid(usize::MAX, usize::MAX),
        families::disk(0, 3),
        families::disk(1, 2),
        families::torus(2, 3, 2.0, 1.0),
        families::torus(3, 3, 1.0, 1.0),
        families::torus(3, 3, f64::NAN, 1.0),
        families::knot(2, 4, 10, 10, 0.1),
        families::knot(0, 1, 10, 10, 0.1),
        families::knot(2, 3, 10, 10, 0.0),
        families::genus(usize::MAX, 1),
        families::genus(1, 0),
        families::figure(0, 0.0),
        families::figure(1, 1.5),
        families::figure(1 << 40, 1.0),
        families::cylinder(3, 1, -1.0, 1.0),
        families::moebius(2, 1),
        families::slivers(1, 1, 0.0),
        families::pages(0),
        families::by_name("sphere", &[3], &[]),
        families::by_name("icosphere", &[], &[]),
        families::by_name("icosphere", &[(1 << 32) + 1], &[]),
    ];
    for (i, mesh) in refused.into_iter().enumerate() {
        assert!(matches!(mesh, Err(Error::Argument { .. })), "number {i}");
    }
}

#[test]
fn terrain_depends_on_its_seed_only() {
    let terrain = |seed| families::terrain(8, 8, seed).unwrap();
    assert_eq!(terrain(5), terrain(5));
    assert_ne!(terrain(5), terrain(6));
    assert!(terrain(5).vertices().iter().all(|p| p[2].abs() <= 0.2));
}

#[test]
fn poses_keep_faces_and_nearly_keep_lengths() {
    let [rest, posed] = [0.0, 1.0].map(|pose| families::figure(4, pose).unwrap());
    assert_eq!(rest.faces(), posed.faces());
    let lengths = |mesh: &TriMesh| -> Vec<f64> {
        let edges = Edges::new(mesh);
        let length = |&[a, b]: &[u32; 2]| {
            let [p, q] = [a, b].map(|v| mesh.vertices()[v as usize]);
            (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
        };
        edges.ends().iter().map(length).collect()
    };
    let ratios: Vec<f64> =
        lengths(&rest).iter().zip(lengths(&posed)).map(|(a, b)| (b / a).ln().abs()).collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!(mean < 0.06, "{mean}");
    let moved = rest.vertices().iter().zip(posed.vertices());
    assert!(moved.map(|(p, q)| (p[2] - q[2]).abs()).fold(0.0, f64::max) > 2.0);
}

#[test]
fn a_bend_keeps_its_middle_plane_and_turns_what_is_behind() {
    let bend = Bend {
        at: [1.0, 0.0, 0.0],
        along: [1.0, 0.0, 0.0],
        towards: [0.0, 1.0, 0.0],
        angle: PI / 2.0,
        length: PI / 2.0,
    };
    assert_eq!(bend.apply([0.5, 3.0, 4.0]), [0.5, 3.0, 4.0]);
    let [x, y, z] = bend.apply([1.0 + PI / 2.0 + 2.0, 0.0, 7.0]);
    assert!((x - 2.0).abs() < 1e-12 && (y - 3.0).abs() < 1e-12 && z == 7.0, "{x} {y} {z}");
    let sheet = families::grid(4, 4).unwrap();
    let skew = Bend { towards: [1.0, 0.0, 0.0], ..bend };
    assert!(matches!(families::bent(&sheet, &skew), Err(Error::Argument { .. })));
    let flat = Bend { at: [0.0; 3], towards: [0.0, 0.0, 1.0], ..bend };
    let bent = families::bent(&families::grid(64, 64).unwrap(), &flat).unwrap();
    assert!((bent.area() - 1.0).abs() < 1e-3, "{}", bent.area());
}

#[test]
fn neighbors_faces_and_edges_of_two_triangles() {
    //  3---2
    //  | / |     faces 0: 0 1 2, 1: 0 2 3; vertex 4 alone
    //  0---1
    let square = families::grid(1, 1).unwrap();
    let mut vertices = square.vertices().to_vec();
    vertices.push([5.0; 3]);
    let mesh = TriMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let rows =
        |a: catamaran_geometry::mesh::Adjacency| a.rows().map(<[u32]>::to_vec).collect::<Vec<_>>();
    let neighbors = rows(mesh.vertex_neighbors());
    assert_eq!(neighbors, [vec![1, 2, 3], vec![0, 2], vec![0, 1, 3], vec![0, 2], vec![]]);
    assert_eq!(rows(mesh.vertex_faces()), [vec![0, 1], vec![0], vec![0, 1], vec![1], vec![]]);
    let edges = Edges::new(&mesh);
    assert_eq!(edges.ends(), [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]);
    assert_eq!(edges.of_corners(), [0, 3, 1, 1, 4, 2]);
    assert_eq!(edges.corners().row(1), [2, 3]);
    assert_eq!(edges.faces(1).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(edges.boundary().collect::<Vec<_>>(), [0, 2, 3, 4]);
    assert_eq!(rows(edges.face_neighbors()), [vec![1], vec![0]]);
    assert_eq!(mesh.boundary_loops(&edges).unwrap(), [[0, 1, 2, 3]]);
    assert_eq!(mesh.unreferenced_vertices(), [4]);
    assert_eq!(mesh.fans(&edges), [1, 1, 1, 1, 0]);
}

#[test]
fn edges_agree_with_a_set_of_pairs() {
    for Case { name, mesh, .. } in manifolds() {
        let mut pairs = std::collections::BTreeMap::<[u32; 2], Vec<u32>>::new();
        for (f, face) in mesh.faces().iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (face[i], face[(i + 1) % 3]);
                pairs.entry([a.min(b), a.max(b)]).or_default().push((3 * f + i) as u32);
            }
        }
        let edges = Edges::new(&mesh);
        assert!(edges.ends().iter().eq(pairs.keys()), "{name}");
        assert!(edges.corners().rows().eq(pairs.values().map(|v| v.as_slice())), "{name}");
        for (e, corners) in edges.corners().rows().enumerate() {
            assert!(corners.iter().all(|&c| edges.of_corners()[c as usize] == e as u32), "{name}");
        }
    }
}

#[test]
fn edges_of_another_mesh_are_not_used() {
    let others = [families::icosphere(1), families::moebius(5, 2), families::bow_tie()];
    for other in others.map(Result::unwrap) {
        let other = Edges::new(&other);
        for Case { name, mesh, genus, .. } in manifolds() {
            let own = Edges::new(&mesh);
            assert_eq!(mesh.boundary_loops(&other), mesh.boundary_loops(&own), "{name}");
            assert_eq!(mesh.fans(&other), mesh.fans(&own), "{name}");
            assert_eq!(mesh.flips(&other), mesh.flips(&own), "{name}");
            assert_eq!(mesh.inconsistent_edges(&other), mesh.inconsistent_edges(&own), "{name}");
            assert_eq!(mesh.genus(&other), Ok(genus), "{name}");
        }
    }
}

#[test]
fn the_empty_mesh_and_a_lone_vertex_have_nothing() {
    for vertices in [vec![], vec![[1.0; 3]]] {
        let mesh = TriMesh::new(vertices, vec![]).unwrap();
        let report = mesh.validate();
        assert_eq!((report.edges, report.components, report.boundary_loops), (0, 0, Some(0)));
        assert_eq!((mesh.area(), mesh.volume()), (0.0, None));
        assert_eq!(mesh.bounding_box().is_some(), !mesh.vertices().is_empty());
        assert!(matches!(mesh.normalized(Normalization::UnitArea), Err(Error::Mesh { .. })));
        assert!(matches!(mesh.normalized(Normalization::UnitBox), Err(Error::Mesh { .. })));
        assert!(mesh.without_unreferenced().mesh.vertices().is_empty());
        assert_eq!(Components::new(&mesh).largest(), None);
    }
}

#[test]
fn a_book_of_three_pages_has_a_non_manifold_edge() {
    let mesh = families::pages(3).unwrap();
    let report = mesh.validate();
    let edge = Problem::NonManifoldEdge { ends: [0, 1], faces: vec![0, 1, 2] };
    assert_eq!(report.problems, [edge]);
    assert_eq!((report.boundary_loops, report.genus), (None, None));
    let refused = mesh.require_manifold().unwrap_err().to_string();
    assert_eq!(refused, "edge 0-1: has 3 faces (0, 1, 2), not one or two");
    assert_eq!(mesh.oriented().unwrap_err().to_string(), refused);
    assert!(
        report
            .to_string()
            .contains("edges with more than two faces: 1 (edge 0-1 of 3 faces (0, 1, 2))")
    );
}

#[test]
fn a_bow_tie_has_a_non_manifold_vertex() {
    let mesh = families::bow_tie().unwrap();
    let report = mesh.validate();
    assert_eq!(report.problems, [Problem::NonManifoldVertex { vertex: 0, fans: 2 }]);
    assert_eq!((report.euler_characteristic, report.genus), (3, None));
    assert_eq!((report.components, report.boundary_loops), (1, Some(0)));
    let refused = mesh.genus(&Edges::new(&mesh)).unwrap_err().to_string();
    assert_eq!(refused, "vertex 0: the surface meets itself in this vertex");
}

#[test]
fn boundary_loops_stay_with_their_fan_at_a_common_vertex() {
    // Two triangles that share vertex 0.
    let corner = |x: f64| [[x, 1.0, 0.0], [x, -1.0, 0.0]];
    let vertices = [[[0.0; 3]].as_slice(), &corner(-1.0), &corner(1.0)].concat();
    let mesh = TriMesh::new(vertices, vec![[0, 1, 2], [0, 4, 3]]).unwrap();
    let loops = mesh.boundary_loops(&Edges::new(&mesh)).unwrap();
    assert_eq!(loops, [vec![0, 1, 2], vec![3, 0, 4]]);
}

#[test]
fn flipped_faces_are_found_and_turned_back() {
    let sphere = families::icosphere(2).unwrap();
    let (vertices, mut faces) = sphere.clone().into_parts();
    faces[17].swap(0, 1);
    faces[100].swap(1, 2);
    let flipped = TriMesh::new(vertices, faces).unwrap();
    let edges = Edges::new(&flipped);
    assert_eq!(flipped.inconsistent_edges(&edges).len(), 6);
    assert_eq!(flipped.genus(&edges), Ok(Genus::Orientable(0)));
    let oriented = flipped.oriented().unwrap();
    assert!(oriented.validate().problems.is_empty());
    let [found, volume] = [&oriented, &sphere].map(|m| m.volume().unwrap());
    assert!((found - volume).abs() < 1e-12);
}

#[test]
fn only_closed_and_oriented_surfaces_have_a_volume() {
    let sphere = families::icosphere(2).unwrap();
    let (vertices, faces) = sphere.clone().into_parts();
    let with = |change: fn(&mut Vec<[u32; 3]>)| {
        let mut changed = faces.clone();
        change(&mut changed);
        TriMesh::new(vertices.clone(), changed).unwrap().volume()
    };
    assert_eq!(with(|faces| faces.truncate(faces.len() - 1)), None, "a hole");
    assert_eq!(with(|faces| faces[17].swap(0, 1)), None, "a face the other way");
    assert_eq!(with(|faces| faces.push(faces[5])), None, "edges with three faces");
    let inside_out = with(|faces| faces.iter_mut().for_each(|face| face.swap(0, 1)));
    let sum = inside_out.unwrap() + sphere.volume().unwrap();
    assert!(sum.abs() < 1e-12, "{sum}");
    assert_eq!(families::grid(3, 3).unwrap().volume(), None);
    assert_eq!(families::moebius(10, 2).unwrap().volume(), None);
}

#[test]
fn a_moebius_strip_can_not_be_oriented() {
    let strip = families::moebius(10, 2).unwrap();
    let refused = strip.oriented().unwrap_err();
    assert!(matches!(&refused, Error::Mesh { element, .. } if element.starts_with("edge ")));
    assert!(refused.to_string().contains("not orientable"), "{refused}");
    assert!(matches!(strip.validate().problems.last(), Some(Problem::NotOrientable { .. })));
}

#[test]
fn vertices_beside_a_seam_that_is_not_welded_are_found_beside_much_larger_triangles() {
    const SIZE: f64 = 4e-3;
    // Two squares with edges of 0.001 side by side, far below a square with edges of 8.
    let squares = |gap: f64| {
        let (mut vertices, mut faces) = (Vec::<[f64; 3]>::new(), Vec::<[u32; 3]>::new());
        for (cells, size, corner) in
            [(1, 8.0, [0.0, 0.0, 1.0]), (4, SIZE, [0.0; 3]), (4, SIZE, [SIZE + gap, 0.0, 0.0])]
        {
            let square = families::grid(cells, cells).unwrap();
            let first = vertices.len() as u32;
            let place = |p: &[f64; 3]| std::array::from_fn(|k| corner[k] + size * p[k]);
            vertices.extend(square.vertices().iter().map(place));
            faces.extend(square.faces().iter().map(|face| face.map(|v| v + first)));
        }
        TriMesh::new(vertices, faces).unwrap()
    };
    let mesh = squares(1e-7);
    let is_at = |v: &u32, x: f64| (mesh.vertices()[*v as usize][0] - x).abs() < 1e-12;
    let side = |vertices: std::ops::Range<u32>, x: f64| vertices.filter(move |v| is_at(v, x));
    // 4 vertices of the large square, then 25 of each small one.
    let expected: Vec<Problem> = side(29..54, SIZE + 1e-7)
        .zip(side(4..29, SIZE))
        .map(|(vertex, first)| Problem::CoincidentVertex { vertex, first })
        .collect();
    assert_eq!(expected.len(), 5);
    assert_eq!(mesh.validate().problems, expected);
    // At more than a thousandth of an edge, squares are apart.
    assert!(squares(2e-6).validate().problems.is_empty());
}

#[test]
fn repeated_and_flat_faces_are_named() {
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.0, 0.0]];
    let mesh = TriMesh::new(vertices, vec![[0, 1, 2], [0, 1, 3], [2, 1, 0], [1, 2, 0]]).unwrap();
    assert_eq!(mesh.repeated_faces(), [[2, 0], [3, 0]]);
    assert_eq!(mesh.faces_without_area(), [1]);
    let problems = mesh.validate().problems;
    assert!(problems.contains(&Problem::RepeatedFace { face: 3, first: 0 }));
    assert!(problems.contains(&Problem::ZeroArea(1)));
    // What rounding leaves of a degenerate triangle.
    let line = [0.1, 0.7, 1.3].map(|t| [1.0 + t, 2.0 + 3.0 * t, 5.0 - t]);
    let mesh = TriMesh::new(line.to_vec(), vec![[0, 1, 2]]).unwrap();
    assert_eq!(mesh.faces_without_area(), [0]);
    // A needle of a millionth is none.
    assert!(families::slivers(1, 1, 1e-6).unwrap().faces_without_area().is_empty());
}

#[test]
fn measures_of_simple_shapes_are_exact() {
    let square = families::grid(4, 4).unwrap();
    assert_eq!(square.area(), 1.0);
    assert_eq!(square.bounding_box(), Some([[0.0; 3], [1.0, 1.0, 0.0]]));
    assert!(square.vertex_normals().iter().all(|&n| n == [0.0, 0.0, 1.0]));
    // Right triangles with equal legs: A = 1/2, S = 1 + sqrt(1/2), l = sqrt(2).
    let quality = 3f64.sqrt() / ((1.0 + 0.5f64.sqrt()) * 2f64.sqrt());
    assert!(square.qualities().iter().all(|q| (q - quality).abs() < 1e-14));
    let icosahedron = families::icosphere(0).unwrap();
    assert!(icosahedron.qualities().iter().all(|q| (q - 1.0).abs() < 1e-14));
    // Of circumradius 1: edges 4 / sqrt(10 + 2 sqrt 5).
    let edge = 4.0 / (10.0 + 2.0 * 5f64.sqrt()).sqrt();
    assert!((icosahedron.area() - 5.0 * 3f64.sqrt() * edge.powi(2)).abs() < 1e-13);
    let volume = 5.0 / 12.0 * (3.0 + 5f64.sqrt()) * edge.powi(3);
    assert!((icosahedron.volume().unwrap() - volume).abs() < 1e-13);
    let sphere = families::icosphere(5).unwrap();
    assert!((sphere.volume().unwrap() / (4.0 * PI / 3.0) - 1.0).abs() < 2e-3);
    let normals = sphere.vertex_normals();
    let dot = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|k| p[k] * q[k]).sum::<f64>();
    assert!(sphere.vertices().iter().zip(&normals).all(|(p, n)| dot(p, n) > 0.9999));
}

#[test]
fn normalized_meshes_have_unit_size_about_the_origin() {
    let shape = families::terrain(9, 7, 2).unwrap();
    let vertices = shape.vertices().iter().map(|p| p.map(|x| 100.0 + 7.0 * x)).collect();
    let mesh = TriMesh::new(vertices, shape.faces().to_vec()).unwrap();
    let unit = mesh.normalized(Normalization::UnitArea).unwrap();
    assert!((unit.area() - 1.0).abs() < 1e-12);
    let boxed = mesh.normalized(Normalization::UnitBox).unwrap();
    let [low, high] = boxed.bounding_box().unwrap();
    assert!((high[0] - low[0] - 1.0).abs() < 1e-12);
    assert!((0..3).all(|k| (low[k] + high[k]).abs() < 1e-12));
    // A vertex in no face is not of the surface, but for a mesh without faces.
    let (mut vertices, faces) = mesh.into_parts();
    vertices.push([1e4, 0.0, 0.0]);
    let stray = TriMesh::new(vertices.clone(), faces).unwrap();
    let parts = |mesh: &TriMesh| mesh.vertices()[..boxed.vertices().len()].to_vec();
    assert_eq!(parts(&stray.normalized(Normalization::UnitBox).unwrap()), parts(&boxed));
    let points = TriMesh::new(vertices, Vec::new()).unwrap();
    assert_eq!(points.bounding_box().unwrap()[1][0], 1e4);
}

#[test]
fn meshes_of_any_size_are_normalized() {
    let shape = families::icosphere(2).unwrap();
    let scaled = |by: f64| {
        let vertices = shape.vertices().iter().map(|p| p.map(|x| x * by)).collect();
        TriMesh::new(vertices, shape.faces().to_vec()).unwrap()
    };
    for to in [Normalization::UnitArea, Normalization::UnitBox] {
        let expected = shape.normalized(to).unwrap();
        // By powers of two, which change no digit, and by others.
        for power in [-900, -300, 300, 900] {
            assert_eq!(scaled(2f64.powi(power)).normalized(to).unwrap(), expected, "2^{power}");
        }
        for by in [1e-300, 1e-160, 1e160, 1e308] {
            let found = scaled(by).normalized(to).unwrap();
            found.check_size().unwrap();
            let pairs = found.vertices().iter().zip(expected.vertices());
            let error = pairs.flat_map(|(p, q)| (0..3).map(|k| (p[k] - q[k]).abs()));
            assert!(error.fold(0.0, f64::max) < 1e-12, "{by}");
        }
    }
}

#[test]
fn components_come_out_as_they_went_in() {
    let mesh = families::spheres(3, 1).unwrap();
    let components = Components::new(&mesh);
    assert_eq!(
        (components.face_counts(), components.vertex_counts()),
        (&[80; 3][..], &[42; 3][..])
    );
    let part = mesh.component(&components, 2).unwrap();
    assert_eq!(part.vertices, (84..126).collect::<Vec<_>>());
    assert_eq!(part.faces, (160..240).collect::<Vec<_>>());
    assert_eq!(part.mesh.faces(), families::icosphere(1).unwrap().faces());
    assert!(matches!(mesh.component(&components, 3), Err(Error::Argument { .. })));
    let two = mesh.submesh(&[239, 0]).unwrap();
    assert_eq!((two.mesh.vertices().len(), &two.faces[..]), (6, &[0, 239][..]));
    for wrong in [&[240][..], &[1, 1]] {
        assert!(matches!(mesh.submesh(wrong), Err(Error::Argument { .. })));
    }
}

/// Lines of the index: file, vertices, faces, closed, loops, genus, components, non-manifold edges,
/// mean quality, slivers, variation of areas, UV.
fn index(folder: &std::path::Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("INDEX.tsv")).expect("the index");
    text.lines().skip(1).map(|line| line.split('\t').map(String::from).collect()).collect()
}

#[test]
fn shared_meshes_agree_with_their_index() {
    let Some(list) = crate::common::data("meshes/INDEX.tsv") else { return };
    let folder = list.parent().unwrap();
    let lines = index(folder);
    // Of some files the index has no numbers.
    let known: Vec<_> = lines.iter().filter(|line| !line[1].is_empty()).collect();
    assert!(known.len() >= 27, "{}", known.len());
    for line in known {
        let name = line[0].rsplit('/').next().unwrap();
        let file = io::read(&folder.join(name)).unwrap_or_else(|e| panic!("{e}"));
        let report = file.mesh.validate();
        let manifold = line[7] == "0";
        let of = |kind: fn(&Problem) -> bool| report.problems.iter().filter(|p| kind(p)).count();
        let non_manifold = of(|p| matches!(p, Problem::NonManifoldEdge { .. }));
        assert_eq!(report.vertices.to_string(), line[1], "{name}");
        assert_eq!(report.faces.to_string(), line[2], "{name}");
        assert_eq!(if report.is_closed() { "yes" } else { "no" }, line[3], "{name}");
        assert_eq!(report.boundary_loops.map(|n| n.to_string()), Some(line[4].clone()), "{name}");
        assert_eq!(report.components.to_string(), line[6], "{name}");
        assert_eq!(non_manifold.to_string(), line[7], "{name}");
        let bow_ties = of(|p| matches!(p, Problem::NonManifoldVertex { .. }));
        println!("{name}: {bow_ties} bow ties, genus {:?}", report.genus);
        if manifold && bow_ties == 0 {
            let genus = match report.genus.expect("a manifold") {
                Genus::Orientable(genus) => genus.to_string(),
                Genus::NonOrientable(genus) => format!("non-orientable (k={genus})"),
            };
            assert_eq!(genus, line[5], "{name}");
        }
        let qualities = file.mesh.qualities();
        let mean = qualities.iter().sum::<f64>() / qualities.len() as f64;
        // The index has fans of all polygons, also of the concave ones of spot_control_quad.
        assert!((mean - line[8].parse::<f64>().unwrap()).abs() <= 2e-3, "{name}: {mean}");
        assert_eq!(file.uv.is_some(), line[11] == "yes", "{name}");
    }
}

#[test]
fn intersecting_faces_are_those_of_brute_force() {
    let mut rng = catamaran::base::Rng::new(17);
    for triangles in [0, 1, 2, 7, 150] {
        let mut vertices: Vec<[f64; 3]> = Vec::new();
        for _ in 0..triangles {
            let near: [f64; 3] = std::array::from_fn(|_| rng.uniform());
            let mut corner = || std::array::from_fn(|k| near[k] + 0.2 * rng.uniform());
            vertices.extend([corner(), corner(), corner()]);
        }
        let faces: Vec<[u32; 3]> =
            (0..triangles as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let mesh = TriMesh::new(vertices, faces).unwrap();
        let wanted = intersecting(&mesh);
        assert!(triangles < 100 || (20..140).contains(&wanted.len()), "{}", wanted.len());
        for par in [Par::Seq, Par::Threads(3)] {
            assert_eq!(mesh.intersecting_faces(par), wanted, "{triangles} triangles");
        }
    }
}

#[test]
fn faces_that_only_share_corners_and_edges_do_not_intersect_and_those_on_each_other_do() {
    let count = |vertices: &[[f64; 3]], faces: &[[u32; 3]]| {
        let mesh = TriMesh::new(vertices.to_vec(), faces.to_vec()).unwrap();
        mesh.intersecting_faces(Par::Seq).len()
    };
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(count(&square, &[[0, 1, 2], [0, 2, 3]]), 0);
    // The same with corners of its own for each face.
    let torn = [square[0], square[1], square[2], square[0], square[2], square[3]];
    assert_eq!(count(&torn, &[[0, 1, 2], [3, 4, 5]]), 0);
    // Folded onto each other along an edge; twice the same face; overlap at a corner; inside.
    assert_eq!(count(&square, &[[0, 1, 2], [1, 0, 3]]), 2);
    assert_eq!(count(&square, &[[0, 1, 2], [2, 1, 0]]), 2);
    let fan = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 0.5, 0.0], [0.5, 1.0, 0.0]];
    assert_eq!(count(&fan, &[[0, 1, 2], [0, 3, 4]]), 2);
    let inside = [fan[0], fan[1], fan[2], [1.0, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0, 1.5, 0.0]];
    assert_eq!(count(&inside, &[[0, 1, 2], [3, 4, 5]]), 2);
    // An edge on a face, and one that ends a rounding error above it.
    let touching =
        |z: f64| [fan[0], fan[1], fan[2], [1.0, 1.0, z], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]];
    assert_eq!(count(&touching(0.0), &[[0, 1, 2], [3, 4, 5]]), 2);
    assert_eq!(count(&touching(1e-100), &[[0, 1, 2], [3, 4, 5]]), 0);
    assert!(families::spheres(3, 2).unwrap().intersecting_faces(Par::Seq).is_empty());
}
