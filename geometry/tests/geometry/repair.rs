//! Repairs give back the surface that was broken, keep attributes, and count what they do.

use catamaran::Error;
use catamaran::base::Rng;
use catamaran_geometry::mesh::io::{Attribute, MeshFile};
use catamaran_geometry::mesh::{
    Edges, Genus, Problem, RepairOptions, RepairStep, Repaired, TriMesh, Weld, families,
    needs_repair, repair,
};

fn closed() -> Vec<(&'static str, TriMesh)> {
    vec![
        ("sphere", families::icosphere(2).unwrap()),
        ("torus", families::torus(12, 8, 2.0, 0.5).unwrap()),
        ("genus 2", families::genus(2, 1).unwrap()),
        ("knot", families::knot(2, 3, 40, 6, 0.2).unwrap()),
        ("two spheres", families::spheres(2, 1).unwrap()),
    ]
}

fn mesh(points: &[[f64; 3]], faces: &[[u32; 3]]) -> TriMesh {
    TriMesh::new(points.to_vec(), faces.to_vec()).unwrap()
}

fn repaired(mesh: TriMesh, options: RepairOptions) -> Repaired {
    repair(mesh.into(), &options).unwrap()
}

/// Two meshes as one, the second scaled.
fn both(first: &TriMesh, second: &TriMesh, scale: f64) -> TriMesh {
    let (mut points, mut faces) = first.clone().into_parts();
    let n = points.len() as u32;
    points.extend(second.vertices().iter().map(|p| p.map(|x| scale * x)));
    faces.extend(second.faces().iter().map(|f| f.map(|v| v + n)));
    mesh(&points, &faces)
}

fn without(mesh: &TriMesh, gone: impl Fn(usize) -> bool) -> TriMesh {
    let kept = mesh.faces().iter().enumerate().filter(|(f, _)| !gone(*f)).map(|(_, face)| *face);
    TriMesh::new(mesh.vertices().to_vec(), kept.collect()).unwrap()
}

fn flipped(mesh: &TriMesh, flip: impl Fn(usize) -> bool) -> TriMesh {
    let turn = |(f, &[a, b, c]): (usize, &[u32; 3])| if flip(f) { [a, c, b] } else { [a, b, c] };
    TriMesh::new(mesh.vertices().to_vec(), mesh.faces().iter().enumerate().map(turn).collect())
        .unwrap()
}

/// UV of every vertex by its number, so that values tell where they come from.
fn numbered(mesh: &TriMesh) -> MeshFile {
    let mut file = MeshFile::from(mesh.clone());
    let values = (0..mesh.vertices().len()).map(|v| [v as f64, 0.5]).collect();
    file.uv = Some(Attribute { values, corners: None });
    file
}

#[test]
fn a_soup_becomes_the_surface_it_was_cut_from() {
    for (name, whole) in closed() {
        let found = repaired(families::soup(&whole).unwrap(), RepairOptions::everything());
        let report = found.file.mesh.validate();
        assert!(report.problems.is_empty() && report.is_closed(), "{name}: {report}");
        assert_eq!(report.vertices, whole.vertices().len(), "{name}");
        assert_eq!(report.genus, whole.validate().genus, "{name}");
        assert_eq!(found.file.mesh.area(), whole.area(), "{name}");
        let numbers = found.vertices.unwrap();
        for (v, p) in families::soup(&whole).unwrap().vertices().iter().enumerate() {
            assert_eq!(found.file.mesh.vertices()[numbers[v] as usize], *p, "{name}");
        }
    }
}

#[test]
fn a_surface_split_along_seams_becomes_closed_and_keeps_its_texture() {
    let split = families::split_sphere(12, 7).unwrap();
    let mut file = numbered(&split);
    file.normals = Some(Attribute { values: split.vertices().to_vec(), corners: None });
    let found = repair(file.clone(), &RepairOptions::unambiguous()).unwrap();
    let report = found.file.mesh.validate();
    assert!(report.is_closed() && report.problems.is_empty(), "{report}");
    assert_eq!((report.vertices, report.genus), (12 * 6 + 2, Some(Genus::Orientable(0))));
    let uv = found.file.uv.unwrap();
    assert!(uv.corners.is_some());
    for f in 0..split.faces().len() {
        let before = file.uv.as_ref().unwrap().of_face(&split, f);
        assert_eq!(uv.of_face(&found.file.mesh, f), before, "face {f}");
    }
    // Normals of one place agree, and stay those of vertices.
    let normals = found.file.normals.unwrap();
    assert_eq!(normals.of_vertices(), Some(found.file.mesh.vertices()));
}

#[test]
fn zero_of_either_sign_is_one_position() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
    let other = [[-0.0, 0.0, -0.0], [1.0, 1.0, -0.0], [0.0, 1.0, 0.0]];
    let split = mesh(&[square, other].concat(), &[[0, 1, 2], [3, 4, 5]]);
    for weld in [Weld::Exact, Weld::Seams, Weld::Within(1e-9)] {
        let found = repaired(split.clone(), RepairOptions::new().weld(weld));
        assert_eq!(found.file.mesh.faces(), [[0, 1, 2], [0, 2, 3]], "{weld:?}");
        assert_eq!(found.vertices.unwrap(), [0, 1, 2, 0, 2, 3], "{weld:?}");
    }
}

#[test]
fn vertices_are_welded_within_a_tolerance_and_never_farther() {
    for (name, whole) in closed() {
        let mut rng = Rng::new(7);
        let (mut points, faces) = families::soup(&whole).unwrap().into_parts();
        for x in points.as_flattened_mut() {
            *x += 1e-7 * (rng.uniform() - 0.5);
        }
        let shaken = mesh(&points, &faces);
        let found = repaired(shaken.clone(), RepairOptions::new().weld(Weld::Within(1e-6)));
        let after = found.file.mesh.validate();
        assert!(after.is_closed() && after.vertices == whole.vertices().len(), "{name}: {after}");
        let none = repaired(shaken, RepairOptions::new().weld(Weld::Exact));
        assert_eq!(none.file.mesh.vertices(), points, "{name}");
    }
    // A chain: each point is near the next one, but not near all.
    let chain: Vec<[f64; 3]> = (0..30).map(|i| [0.6 * f64::from(i), 0.0, 0.0]).collect();
    let found = repaired(mesh(&chain, &[]), RepairOptions::new().weld(Weld::Within(1.0)));
    let numbers = found.vertices.unwrap();
    for (p, v) in chain.iter().zip(&numbers) {
        assert!((p[0] - found.file.mesh.vertices()[*v as usize][0]).abs() <= 1.0);
    }
    assert_eq!(found.file.mesh.vertices().len(), 15);
    // All in one, and coordinates beyond the grid.
    let far = mesh(&[[1e300, 0.0, 0.0], [1e300, 0.0, 0.0], [-1e300, 1.0, 0.0]], &[]);
    let found = repaired(far, RepairOptions::new().weld(Weld::Within(1e-3)));
    assert_eq!(found.vertices.unwrap(), [0, 0, 1]);
}

#[test]
fn a_tolerance_that_is_no_length_is_refused() {
    for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
        let options = RepairOptions::new().weld(Weld::Within(tolerance));
        let refused = repair(families::icosphere(0).unwrap().into(), &options);
        assert!(matches!(refused, Err(Error::Argument { what: "tolerance", .. })), "{tolerance}");
    }
}

#[test]
fn faces_that_collapse_and_colours_that_are_lost_are_counted() {
    let points = [[0.0; 3], [1e-9, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut file = MeshFile::from(mesh(&points, &[[0, 1, 2], [0, 2, 3]]));
    file.colors = Some(vec![[1.0; 4], [0.5; 4], [0.25; 4], [0.0; 4]]);
    let found = repair(file, &RepairOptions::new().weld(Weld::Within(1e-6))).unwrap();
    let welded = RepairStep::Welded { tolerance: 1e-6, vertices: 1, faces: 1, colors: 1 };
    assert_eq!(found.report.steps, [welded]);
    assert_eq!(found.file.colors.unwrap(), [[1.0; 4], [0.25; 4], [0.0; 4]]);
    assert_eq!(
        found.report.to_string(),
        "weld        1 vertices joined (at most 0.000001 apart), 1 faces collapsed, 1 colours lost \
         (the first of each place stays)"
    );
}

#[test]
fn surfaces_that_only_touch_stay_apart_unless_asked() {
    // Three sheets on one edge: joined, it would have three faces.
    let pages = families::soup(&families::pages(3).unwrap()).unwrap();
    let found = repaired(pages.clone(), RepairOptions::unambiguous());
    assert_eq!(found.file.mesh, pages);
    let step = RepairStep::ClosedSeams { vertices: 0, colors: 0, ambiguous: 3 };
    assert_eq!((found.report.steps[0], found.report.changed()), (step, false));
    let found = repaired(pages, RepairOptions::new().weld(Weld::Exact));
    assert_eq!(found.file.mesh.vertices().len(), 5);
    // Closed surfaces that touch in a vertex have nothing to close.
    let touching = repaired(families::bow_tie().unwrap(), RepairOptions::new().cut(true));
    let found = repaired(touching.file.mesh.clone(), RepairOptions::everything());
    assert_eq!(found.file.mesh, touching.file.mesh);
    // Nor are they joined there when they have seams elsewhere.
    let found =
        repaired(families::soup(&touching.file.mesh).unwrap(), RepairOptions::unambiguous());
    assert_eq!(found.file.mesh.validate().components, 2);
    assert!(found.file.mesh.validate().is_closed());
}

#[test]
fn repeated_faces_are_dropped_and_no_vertex_is_renumbered() {
    let (points, faces) = families::icosphere(1).unwrap().into_parts();
    let turned = faces[..20].iter().map(|&[a, b, c]| [b, a, c]);
    let doubled: Vec<_> = faces.iter().copied().chain(turned).chain([faces[7]]).collect();
    let broken = mesh(&points, &doubled);
    let why = needs_repair(&broken);
    assert_eq!(why.as_deref(), Some("21 repeated faces: face 80 has the vertices of face 0"));
    let found = repaired(broken, RepairOptions::unambiguous());
    assert_eq!((found.file.mesh.faces(), found.vertices), (&*faces, None));
    let step = RepairStep::DroppedDuplicates { faces: 21, first: Some([80, 0]) };
    assert!(found.report.steps.contains(&step));
}

/// A closed surface in which some faces have a vertex on an edge, beyond which a face without area
/// is.
fn with_caps(whole: &TriMesh, count: usize) -> TriMesh {
    let (mut points, mut faces) = whole.clone().into_parts();
    for f in 0..count {
        let [a, b, c] = faces[f];
        let [p, q] = [a, b].map(|v| points[v as usize]);
        let m = points.len() as u32;
        points.push(std::array::from_fn(|k| 0.5 * p[k] + 0.5 * q[k]));
        faces[f] = [a, m, c];
        faces.extend([[m, b, c], [a, b, m]]);
    }
    mesh(&points, &faces)
}

/// A closed surface in which an edge became two faces without area, between a vertex and its copy.
fn with_needles(whole: &TriMesh, count: usize) -> TriMesh {
    let (mut points, mut faces) = whole.clone().into_parts();
    for f in (0..count).map(|i| 5 * i) {
        // The edge a-b of two faces opens to a-b, a-copy-b.
        let [a, b, _] = faces[f];
        let copy = points.len() as u32;
        points.push(points[a as usize]);
        faces[f] = faces[f].map(|v| if v == a { copy } else { v });
        let [_, _, c] = faces[f];
        faces.extend([[a, b, copy], [a, copy, c]]);
    }
    mesh(&points, &faces)
}

#[test]
fn faces_without_area_go_and_the_surface_stays_closed() {
    for (name, whole) in closed() {
        for (kind, broken) in
            [("caps", with_caps(&whole, 15)), ("needles", with_needles(&whole, 9))]
        {
            let before = broken.validate();
            assert!(before.is_closed() && before.genus == whole.validate().genus, "{name} {kind}");
            assert!(!broken.faces_without_area().is_empty(), "{name} {kind}");
            let found = repaired(broken.clone(), RepairOptions::unambiguous());
            let after = found.file.mesh.validate();
            assert!(after.problems.is_empty(), "{name} {kind}: {after}");
            assert!(after.is_closed() && after.genus == before.genus, "{name} {kind}: {after}");
            assert_eq!(after.components, before.components, "{name} {kind}");
            let change = (found.file.mesh.area() - whole.area()).abs() / whole.area();
            assert!(change < 1e-12, "{name} {kind}: {change}");
            if kind == "caps" {
                assert_eq!((found.file.mesh.vertices(), found.vertices), (broken.vertices(), None));
            }
        }
    }
}

#[test]
fn slivers_with_area_stay() {
    for thinness in [1e-3, 1e-12] {
        let needles = families::slivers(6, 6, thinness).unwrap();
        let found = repaired(needles.clone(), RepairOptions::unambiguous());
        assert_eq!(found.file.mesh, needles, "{thinness}");
    }
}

#[test]
fn sizes_near_the_limits_of_numbers_are_no_reason_to_drop_faces() {
    for scale in [1e-200, 1e200] {
        let (mut points, faces) = families::icosphere(1).unwrap().into_parts();
        points.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
        let scaled = mesh(&points, &faces);
        assert_eq!(scaled.faces_without_area(), [0; 0], "{scale}");
        assert_eq!(repaired(scaled.clone(), RepairOptions::everything()).file.mesh, scaled);
    }
}

#[test]
fn a_vertex_far_out_is_named_where_its_faces_have_no_area() {
    let (points, faces) = families::icosphere(1).unwrap().into_parts();
    for far in [1e71, 1e160, -1e308] {
        let mut points = points.clone();
        points[7][1] = far;
        let mesh = mesh(&points, &faces);
        let specks = RepairOptions::new().drop_specks(Some(0.5));
        for options in [RepairOptions::unambiguous(), specks] {
            let refused = repair(mesh.clone().into(), &options).unwrap_err().to_string();
            assert!(refused.starts_with("vertex 7: position ["), "{far}: {refused}");
        }
    }
    // Two tiny faces, one of them without area.
    let points = [[0.0; 3], [1e-160, 0.0, 0.0], [0.0, 1e-160, 0.0], [2e-160, 0.0, 0.0]];
    let tiny = mesh(&points, &[[0, 1, 2], [0, 1, 3]]);
    let refused = repair(tiny.into(), &RepairOptions::unambiguous()).unwrap_err().to_string();
    assert!(refused.contains("the longest side of its bounding box, 2e-160, is out of range"));
}

#[test]
fn texture_follows_a_flipped_edge_on_both_sides_of_a_seam() {
    // A square of two triangles and, between them, one without area whose corner is on the
    // diagonal.
    let points = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
    let faces = [[0, 1, 4], [1, 2, 4], [0, 4, 2], [0, 2, 3]];
    let mut file = MeshFile::from(mesh(&points, &faces));
    let corners = |last: [u32; 3]| Some(vec![[0, 1, 4], [1, 2, 4], [0, 4, 2], last]);
    let mut values: Vec<[f64; 2]> = points.iter().map(|p| [p[0], p[1]]).collect();
    values.extend([[10.0, 10.0], [14.0, 10.0], [14.0, 14.0]]);
    for (last, middle) in [([0, 2, 3], [1.0, 1.0]), ([5, 6, 7], [12.0, 10.0])] {
        file.uv = Some(Attribute { values: values.clone(), corners: corners(last) });
        let found = repair(file.clone(), &RepairOptions::unambiguous()).unwrap();
        assert_eq!(found.file.mesh.faces().len(), 4);
        assert!(found.file.mesh.faces_without_area().is_empty());
        let uv = found.file.uv.unwrap();
        for (f, face) in found.file.mesh.faces().iter().enumerate().filter(|(_, f)| f.contains(&3))
        {
            let at = face.iter().position(|&v| v == 4).unwrap();
            assert_eq!(uv.of_face(&found.file.mesh, f).unwrap()[at], middle, "{last:?}");
        }
    }
}

/// Any triangles between points of a small lattice.
fn rubble(points: u32, faces: usize, seed: u64) -> TriMesh {
    let mut rng = Rng::new(seed);
    let mut below = |n: u32| (rng.uniform() * f64::from(n)) as u32;
    let vertices: Vec<_> =
        (0..points).map(|_| std::array::from_fn(|_| f64::from(below(3)))).collect();
    let faces: Vec<_> = (0..faces)
        .map(|_| {
            let a = below(points);
            let b = (a + 1 + below(points - 1)) % points;
            let c = (0..points).map(|i| (b + 1 + i) % points).find(|&c| c != a && c != b).unwrap();
            [a, b, c]
        })
        .collect();
    mesh(&vertices, &faces)
}

#[test]
fn whatever_the_input_the_result_has_no_fault_that_was_to_be_repaired() {
    for seed in 0..400 {
        let broken = rubble(4 + (seed % 20) as u32, 1 + (seed % 37) as usize, seed);
        let mut file = numbered(&broken);
        file.colors = Some(vec![[0.5; 4]; broken.vertices().len()]);
        let options = RepairOptions::everything().weld(Weld::Exact);
        let found = match repair(file.clone(), &options) {
            Ok(found) => found,
            Err(Error::Argument { why, .. }) => {
                assert!(why.starts_with("leaves none of the "), "{seed}: {why}");
                continue;
            }
            Err(error) => panic!("{seed}: {error}"),
        };
        let result = &found.file.mesh;
        assert!(result.faces_without_area().is_empty(), "{seed}");
        assert!(result.repeated_faces().is_empty(), "{seed}");
        assert!(result.require_manifold().is_ok(), "{seed}");
        assert!(result.unreferenced_vertices().is_empty(), "{seed}");
        let uv = found.file.uv.as_ref().unwrap();
        assert!((0..result.faces().len()).all(|f| uv.of_face(result, f).is_some()), "{seed}");
        for (v, &new) in found.vertices.unwrap_or_default().iter().enumerate() {
            if new != Repaired::NONE {
                assert_eq!(result.vertices()[new as usize], broken.vertices()[v], "{seed}");
            }
        }
        // Faces are dropped only where nothing else is possible.
        let safe = repair(file, &RepairOptions::unambiguous()).unwrap();
        assert!(safe.file.mesh.faces_without_area().is_empty(), "{seed}");
    }
}

#[test]
fn a_second_repair_finds_nothing() {
    let surfaces = closed().into_iter().flat_map(|(_, whole)| {
        [families::soup(&whole).unwrap(), with_caps(&whole, 9), with_needles(&whole, 5)]
    });
    for broken in surfaces {
        let first = repaired(broken, RepairOptions::everything()).file;
        let second = repair(first.clone(), &RepairOptions::everything()).unwrap();
        assert!(!second.report.changed() && second.file == first, "{}", second.report);
    }
}

#[test]
fn holes_are_filled_up_to_a_number_of_edges() {
    for (name, whole) in closed() {
        let edges = Edges::new(&whole);
        let around = edges.face_neighbors();
        let middle = whole.faces().len() / 2;
        // A hole of one face and one of four.
        let gone = |f| [0, middle].contains(&f) || around.row(middle).contains(&(f as u32));
        let open = without(&whole, gone);
        let loops = open.boundary_loops(&Edges::new(&open)).unwrap().len();
        assert_eq!(loops, 2, "{name}");
        let found = repaired(open.clone(), RepairOptions::new().fill_holes(3));
        let step = RepairStep::FilledHoles { holes: 1, faces: 1, left: 1 };
        assert_eq!(found.report.steps, [step], "{name}");
        let found = repair(numbered(&open), &RepairOptions::new().fill_holes(6)).unwrap();
        let report = found.file.mesh.validate();
        assert!(report.is_closed() && report.problems.is_empty(), "{name}: {report}");
        assert_eq!(report.genus, whole.validate().genus, "{name}");
        assert_eq!(found.file.mesh.faces().len(), whole.faces().len(), "{name}");
        assert!(found.file.uv.unwrap().of_vertices().is_some(), "{name}");
    }
}

#[test]
fn a_flat_hole_is_filled_flat_and_a_long_one_too() {
    let grid = families::grid(20, 20).unwrap();
    // An L: not convex.
    let inside = |f: usize| {
        let (i, j) = (f / 2 / 20, f / 2 % 20);
        (5..15).contains(&i) && (5..15).contains(&j) && (i < 8 || j < 8)
    };
    let found = repaired(without(&grid, inside), RepairOptions::new().fill_holes(45));
    assert!((found.file.mesh.area() - 1.0).abs() < 1e-12, "{}", found.file.mesh.area());
    assert!(found.file.mesh.face_normals().iter().all(|n| n[2] > 0.99));
    let tube = families::cylinder(700, 1, 1.0, 1.0).unwrap();
    let found = repaired(tube.clone(), RepairOptions::new().fill_holes(700).compact(true));
    let report = found.file.mesh.validate();
    assert!(report.is_closed() && report.problems.is_empty(), "{report}");
    let caps = report.faces - tube.faces().len();
    assert_eq!(caps, 2 * 698);
    let caps = found.file.mesh.area() - tube.area();
    assert!((caps - 2.0 * std::f64::consts::PI).abs() < 1e-3, "{caps}");
    // The boundary of a face alone is none of a hole.
    let alone = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
    let found = repaired(alone.clone(), RepairOptions::new().fill_holes(9));
    assert_eq!(found.file.mesh, alone);
    let three = families::pages(3).unwrap();
    let refused = repair(three.into(), &RepairOptions::new().fill_holes(9)).unwrap_err();
    assert!(refused.to_string().contains("edge 0-1"), "{refused}");
}

#[test]
fn a_vertex_on_an_edge_of_a_larger_face_is_joined_to_it() {
    // A hole without area: beside the edge is a face with a vertex on it.
    for (name, whole) in closed() {
        let caps = with_caps(&whole, 1);
        let flat = caps.faces_without_area();
        let open = without(&caps, |f| flat.contains(&(f as u32)));
        assert!(!open.validate().is_closed() && open.faces_without_area().is_empty(), "{name}");
        let found = repaired(open, RepairOptions::everything().fill_holes(40));
        let report = found.file.mesh.validate();
        assert!(report.is_closed() && report.problems.is_empty(), "{name}: {report}");
        let change = (found.file.mesh.area() - whole.area()).abs() / whole.area();
        assert!(change < 1e-12, "{name}: {change}");
    }
}

#[test]
fn faces_are_oriented_outward_and_cavities_inward() {
    for (name, whole) in closed() {
        for inside_out in [false, true] {
            let mut rng = Rng::new(3);
            let coins: Vec<bool> =
                whole.faces().iter().map(|_| inside_out || rng.uniform() < 0.5).collect();
            let broken = flipped(&whole, |f| coins[f]);
            let found = repaired(broken, RepairOptions::new().orient(true));
            // Corners may start elsewhere, volumes tell.
            assert!(found.file.mesh.inconsistent_edges(&Edges::new(&found.file.mesh)).is_empty());
            let [volume, expected] = [&found.file.mesh, &whole].map(|m| m.volume().unwrap());
            assert!((volume - expected).abs() < 1e-12, "{name}");
        }
    }
    let sphere = families::icosphere(2).unwrap();
    let inner = both(&sphere, &both(&sphere, &sphere, 0.5), 0.5);
    // Four: 1, 1/2, 1/4 within one another.
    let nested = flipped(&inner, |f| f % 3 == 0);
    let found = repaired(nested, RepairOptions::new().orient(true));
    let expected = sphere.volume().unwrap() * (1.0 - 0.125 + 0.125 * 0.125);
    assert!((found.file.mesh.volume().unwrap() - expected).abs() < 1e-12);
}

#[test]
fn a_component_is_inside_out_where_all_its_faces_are_to_be_flipped() {
    let sphere = families::icosphere(1).unwrap();
    let count = sphere.faces().len();
    // Four shells within one another, each turned or not.
    let nested = both(&sphere, &both(&sphere, &both(&sphere, &sphere, 0.5), 0.5), 0.5);
    for turned in 0..16 {
        let is_turned = |shell: usize| turned >> shell & 1 == 1;
        let mesh = flipped(&nested, |f| is_turned(f / count));
        let expected: Vec<Problem> = (0..4)
            .filter(|&shell| is_turned(shell) != (shell % 2 == 1))
            .map(|shell| Problem::InsideOut((shell * count) as u32))
            .collect();
        assert_eq!(mesh.validate().problems, expected, "{turned:b}");
        let found = repaired(mesh, RepairOptions::new().orient(true));
        let [RepairStep::Oriented { faces, .. }] = found.report.steps[..] else { panic!() };
        assert_eq!(faces, count * expected.len(), "{turned:b}");
        assert!(found.file.mesh.validate().problems.is_empty(), "{turned:b}");
    }
    // One inside of a ring of the torus, and one in the hole.
    let torus = families::torus(24, 12, 2.0, 0.5).unwrap();
    for (x, expected) in [(2.0, vec![Problem::InsideOut(576)]), (0.0, vec![])] {
        let (mut points, mut faces) = torus.clone().into_parts();
        let first = points.len() as u32;
        points.extend(sphere.vertices().iter().map(|p| [x + 0.1 * p[0], 0.1 * p[1], 0.1 * p[2]]));
        faces.extend(sphere.faces().iter().map(|face| face.map(|v| first + v)));
        assert_eq!(mesh(&points, &faces).validate().problems, expected, "{x}");
    }
}

#[test]
fn open_surfaces_and_sheets_without_a_volume_are_not_inside_out() {
    let disk = families::disk(4, 9).unwrap();
    assert!(flipped(&disk, |_| true).validate().problems.is_empty());
    // Two copies of a disk, joined at their boundary, in a plane that rounds the coordinates.
    let place = |p: &[f64; 3]| [0.3 * p[0] + 0.7 * p[1], 0.1 * p[0] - p[1], 0.9 * p[0] + 1e3];
    let mut points: Vec<[f64; 3]> = disk.vertices().iter().map(place).collect();
    let mut faces = disk.faces().to_vec();
    let edges = Edges::new(&disk);
    let on_boundary: Vec<u32> = edges.boundary().flat_map(|e| edges.ends()[e as usize]).collect();
    let mut below: Vec<u32> = (0..points.len() as u32).collect();
    for v in 0..disk.vertices().len() {
        if !on_boundary.contains(&(v as u32)) {
            below[v] = points.len() as u32;
            points.push(points[v]);
        }
    }
    faces.extend(disk.faces().iter().map(|&[a, b, c]| [b, a, c].map(|v| below[v as usize])));
    let lens = mesh(&points, &faces);
    assert!(lens.validate().is_closed());
    for mesh in [flipped(&lens, |_| true), lens] {
        assert!(mesh.validate().problems.is_empty(), "{}", mesh.validate());
        let found = repaired(mesh.clone(), RepairOptions::new().orient(true));
        assert_eq!(found.file.mesh, mesh);
    }
}

#[test]
fn open_surfaces_are_oriented_by_the_majority_and_moebius_strips_reported() {
    let sheet = families::terrain(9, 9, 2).unwrap();
    let found = repaired(flipped(&sheet, |f| f < 40), RepairOptions::new().orient(true));
    assert!(found.file.mesh.face_normals().iter().all(|n| n[2] > 0.0));
    let strip = families::moebius(9, 1).unwrap();
    let found = repaired(strip.clone(), RepairOptions::new().orient(true));
    let [RepairStep::Oriented { faces: 0, not_orientable: 1, edge: Some(_) }] =
        found.report.steps[..]
    else {
        panic!("{}", found.report)
    };
    assert_eq!(found.file.mesh, strip);
}

#[test]
fn edges_of_many_faces_are_cut_and_nothing_else_is() {
    let found = repaired(families::pages(4).unwrap(), RepairOptions::new().cut(true));
    let report = found.file.mesh.validate();
    assert_eq!((report.components, report.problems.len()), (4, 0));
    assert_eq!(found.report.steps, [RepairStep::Cut { edges: 1, vertices: 2 }]);
    let (mut points, faces) = families::bow_tie().unwrap().into_parts();
    points.push([9.0; 3]);
    let found = repair(numbered(&mesh(&points, &faces)), &RepairOptions::new().cut(true)).unwrap();
    // The vertex without a face is still there, and keeps its texture.
    assert_eq!(found.file.mesh.vertices().last(), Some(&[9.0; 3]));
    assert_eq!(found.file.uv.unwrap().of_vertices().unwrap().last(), Some(&[7.0, 0.5]));
    assert_eq!(found.vertices.unwrap(), [0, 2, 3, 4, 5, 6, 7, 8]);
    for (_, whole) in closed() {
        assert_eq!(repaired(whole.clone(), RepairOptions::new().cut(true)).file.mesh, whole);
    }
}

#[test]
fn the_largest_components_stay() {
    let small = families::icosphere(0).unwrap();
    let large = families::icosphere(2).unwrap();
    let all = both(&small, &both(&large, &small, 0.25), 0.5);
    for (count, faces) in [(1, 320), (2, 340), (3, 360), (9, 360)] {
        let found = repaired(all.clone(), RepairOptions::new().keep_largest(count));
        assert_eq!(found.file.mesh.faces().len(), faces, "{count}");
        let [RepairStep::KeptLargest { components, .. }] = found.report.steps[..] else { panic!() };
        assert_eq!(components, 3usize.saturating_sub(count));
    }
    // Of equal ones the first.
    let found = repaired(both(&small, &small, 0.5), RepairOptions::new().keep_largest(1));
    assert_eq!(found.file.mesh, small);
}

#[test]
fn specks_are_components_below_a_share_of_the_area() {
    // Radii 1, 1/4 and 1/8 give shares of about .93, .05 and .015, whatever their numbers of faces.
    let sphere = |level| families::icosphere(level).unwrap();
    let all = both(&sphere(2), &both(&sphere(1), &sphere(3), 0.5), 0.25);
    for (share, left) in [(0.0, 3), (0.01, 3), (0.03, 2), (0.5, 1)] {
        let found = repaired(all.clone(), RepairOptions::new().drop_specks(share));
        assert_eq!(found.file.mesh.validate().components, left, "{share}");
        let [RepairStep::DroppedSpecks { components, faces, .. }] = found.report.steps[..] else {
            panic!()
        };
        assert_eq!(components, 3 - left);
        assert_eq!(all.faces().len() - faces, found.file.mesh.faces().len());
    }
    let flat = TriMesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    let found = repaired(flat.clone(), RepairOptions::new().drop_specks(0.5));
    assert_eq!(found.file.mesh, flat, "no area, no specks");
    for share in [-0.1, 1.1, f64::NAN] {
        let refused = repair(all.clone().into(), &RepairOptions::new().drop_specks(share));
        assert!(refused.unwrap_err().to_string().contains("drop_specks"));
    }
}

#[test]
fn a_step_that_leaves_nothing_is_refused_by_the_name_of_its_option() {
    let sphere = families::icosphere(1).unwrap();
    let flat = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2]]);
    let cloud = mesh(&[[0.0; 3], [1.0, 0.0, 0.0]], &[]);
    let new = RepairOptions::new;
    for (mesh, options, why) in [
        (&sphere, new().weld(Weld::Within(1e300)), "weld: leaves none of the 80 faces"),
        (&sphere, new().keep_largest(0), "keep_largest: must be at least 1, is 0"),
        (&both(&sphere, &sphere, 1.0), new().drop_specks(0.75), "drop_specks: leaves none of the"),
        (&flat, new().drop_degenerate(true), "drop_degenerate: leaves none of the 1 faces"),
        (&cloud, new().compact(true), "compact: leaves none of the 2 vertices"),
    ] {
        let refused = repair(mesh.clone().into(), &options).unwrap_err();
        assert!(matches!(refused, Error::Argument { .. }), "{refused:?}");
        assert!(refused.to_string().starts_with(why), "{refused}");
    }
    // What is empty before is left empty.
    let empty = mesh(&[], &[]);
    let options = RepairOptions::everything().drop_specks(1.0).keep_largest(1);
    assert_eq!(repaired(empty.clone(), options).file.mesh, empty);
}

#[test]
fn what_needs_repair_is_named() {
    let sphere = families::icosphere(1).unwrap();
    assert_eq!(needs_repair(&sphere), None);
    for (broken, why) in [
        (
            families::soup(&sphere).unwrap(),
            "198 vertices coincide with others along seams: vertex 4 with vertex 2",
        ),
        (with_caps(&sphere, 1), "1 faces without area: face 81"),
    ] {
        let named = needs_repair(&broken).unwrap();
        assert!(named.starts_with(&why[..20]), "{named}");
    }
    // A deliberate coincidence that closes nothing is no fault.
    assert_eq!(needs_repair(&both(&sphere, &sphere, 1.0)), None);
}
