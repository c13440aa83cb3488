//! Decimation of the kinds of meshes that people have: exactly n vertices, a manifold of the same
//! topology, no faces that an oracle finds to intersect, and textures that are not turned over.

use catamaran::Par;
use catamaran_geometry::decimate::{DecimateOptions, Decimation, decimate};
use catamaran_geometry::mesh::io::{
    Attribute, Labels, MeshFile, MeshFormat, PlyEncoding, read_bytes,
};
use catamaran_geometry::mesh::{Genus, RepairOptions, TriMesh, families, repair};

use crate::decimate::{blade, cad_cylinder, check};
use crate::triangles::{TextureFaults, intersecting, nearest_faces};

fn decimated(name: &str, mesh: &TriMesh, n: usize) -> Decimation {
    let options = DecimateOptions::new().par(Par::Seq);
    let found = decimate(mesh, n, &options).unwrap_or_else(|e| panic!("{name} to {n}: {e}"));
    check(name, mesh, n, &found);
    let faces = intersecting(&found.mesh);
    assert!(faces.is_empty(), "{name} to {n}: faces {faces:?} intersect others");
    found
}

fn welded(file: impl Into<MeshFile>) -> MeshFile {
    repair(file.into(), &RepairOptions::unambiguous()).unwrap().file
}

/// A sword: a cross-section of two sharp edges and two ridges, tapered to a tip at both ends.
fn sword() -> TriMesh {
    const STATIONS: u32 = 60;
    let mut vertices = vec![[0.0, 0.0, 0.0], [0.0, 10.0, 0.0]];
    for i in 1..STATIONS {
        let y = 10.0 * f64::from(i) / f64::from(STATIONS);
        let width = 0.5 * (y / 2.0).min(1.0) * ((10.0 - y) / 4.0).min(1.0);
        let thickness = 0.08 * width;
        vertices.extend([
            [width, y, 0.0],
            [0.0, y, thickness],
            [-width, y, 0.0],
            [0.0, y, -thickness],
        ]);
    }
    let number = |i: u32, k: u32| 2 + 4 * (i - 1) + k % 4;
    let mut faces = Vec::new();
    for k in 0..4 {
        faces.push([0, number(1, k), number(1, k + 1)]);
        faces.push([1, number(STATIONS - 1, k + 1), number(STATIONS - 1, k)]);
        for i in 1..STATIONS - 1 {
            let [a, b] = [number(i, k), number(i, k + 1)];
            let [c, d] = [number(i + 1, k), number(i + 1, k + 1)];
            faces.extend([[a, c, b], [b, c, d]]);
        }
    }
    TriMesh::new(vertices, faces).unwrap()
}

/// A block with a slot from above that is much narrower than edges of the results.
fn slotted_block() -> TriMesh {
    let across = [0.0, 1.9, 2.1, 4.0];
    let up = [0.0, 1.0, 3.0];
    let deep = [0.0, 2.0];
    // The cells between these planes; only the slot is empty.
    let solid = |i: isize, j: isize, k: isize| {
        (0..3).contains(&i) && (0..2).contains(&j) && k == 0 && (i, j) != (1, 1)
    };
    let mut vertices = Vec::new();
    for x in across {
        for y in up {
            vertices.extend(deep.map(|z| [x, y, z]));
        }
    }
    let number = |p: [isize; 3]| ((p[0] * 3 + p[1]) * 2 + p[2]) as u32;
    let mut faces = Vec::new();
    for (i, j) in (0..3).flat_map(|i| (0..2).map(move |j| (i, j))).filter(|&(i, j)| solid(i, j, 0))
    {
        for axis in 0..3 {
            let [second, third] = [(axis + 1) % 3, (axis + 2) % 3];
            for side in [0, 1] {
                let mut beyond = [i, j, 0];
                beyond[axis] += 2 * side - 1;
                if solid(beyond[0], beyond[1], beyond[2]) {
                    continue;
                }
                let corner = |s: isize, t: isize| {
                    let mut p = [i, j, 0];
                    p[axis] += side;
                    p[second] += s;
                    p[third] += t;
                    number(p)
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                let outwards =
                    if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                faces.extend(outwards);
            }
        }
    }
    TriMesh::new(vertices, faces).unwrap()
}

/// A torus as a PLY file of triangle strips, each once around the tube.
fn torus_of_strips() -> TriMesh {
    const AROUND: usize = 48;
    const TUBE: usize = 20;
    let torus = families::torus(AROUND, TUBE, 2.0, 0.6).unwrap();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty \
         double z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n",
        AROUND * TUBE
    );
    for [x, y, z] in torus.vertices() {
        text += &format!("{x} {y} {z}\n");
    }
    let mut strips = Vec::new();
    for i in 0..AROUND {
        let around = |j: usize| [i, (i + 1) % AROUND].map(|i| (i * TUBE + j % TUBE).to_string());
        strips.extend((0..=TUBE).flat_map(around));
        strips.push("-1".into());
    }
    text += &format!("{} {}\n", strips.len(), strips.join(" "));
    let file = read_bytes(text.as_bytes(), MeshFormat::Ply(PlyEncoding::Ascii)).unwrap();
    assert_eq!(file.mesh.faces().len(), 2 * AROUND * TUBE);
    file.mesh
}

#[test]
fn every_kind_of_mesh_is_decimated_without_intersections() {
    let split = welded(families::split_sphere(48, 24).unwrap());
    assert!(split.mesh.validate().is_closed());
    let soup = welded(families::soup(&families::figure(4, 0.5).unwrap()).unwrap());
    let cases = [
        ("flat sphere", blade(), vec![200, 800]),
        ("sword", sword(), vec![150, 500]),
        ("cylinder of CAD", cad_cylinder(64), vec![100, 400, 1000]),
        ("slot", slotted_block(), vec![200, 600]),
        ("split sphere", split.mesh, vec![50, 300, 700]),
        ("soup", soup.mesh, vec![300, 900]),
        ("strips", torus_of_strips(), vec![60, 400]),
    ];
    for (name, mesh, sizes) in cases {
        for n in sizes {
            let found = decimated(name, &mesh, n);
            assert_eq!(found.before.components, 1, "{name}");
        }
    }
    let strips = decimated("strips", &torus_of_strips(), 200);
    assert_eq!(strips.after.unwrap().genus, Genus::Orientable(1));
}

/// A texture in which each face has a chart and its corners lie where `place` says: they are joined
/// within a chart.
fn textured(
    mesh: TriMesh,
    chart: impl Fn(usize) -> usize,
    place: impl Fn(usize, usize, [f64; 3]) -> [f64; 2],
) -> MeshFile {
    let mut values: Vec<[f64; 2]> = Vec::new();
    let mut known = std::collections::HashMap::new();
    let mut corners = Vec::new();
    for (f, face) in mesh.faces().iter().enumerate() {
        let chart = chart(f);
        corners.push(face.map(|v| {
            let value = place(f, chart, mesh.vertices()[v as usize]);
            *known.entry((chart, v, value.map(f64::to_bits))).or_insert_with(|| {
                values.push(value);
                values.len() as u32 - 1
            })
        }));
    }
    let mut file = MeshFile::from(mesh);
    file.uv = Some(Attribute { values, corners: Some(corners) });
    file
}

fn middle(mesh: &TriMesh, f: usize) -> [f64; 3] {
    let corners = mesh.faces()[f].map(|v| mesh.vertices()[v as usize]);
    std::array::from_fn(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0)
}

/// The side of the cube that a point of the sphere is on: 0 to 5.
fn cube_side(p: [f64; 3]) -> usize {
    let axis = (0..3).max_by(|&i, &j| p[i].abs().total_cmp(&p[j].abs())).unwrap();
    2 * axis + usize::from(p[axis] > 0.0)
}

/// A sphere of six charts, half of them mirrored.
fn sphere_of_six_charts() -> MeshFile {
    let mesh = families::icosphere(4).unwrap();
    let sphere = mesh.clone();
    textured(
        mesh,
        |f| cube_side(middle(&sphere, f)),
        |_, side, p| {
            let [u, v] = [p[(side / 2 + 1) % 3], p[(side / 2 + 2) % 3]];
            [u + 3.0 * (side / 2) as f64, v + 3.0 * (side % 2) as f64]
        },
    )
}

/// A torus in one chart that two cuts make a rectangle.
fn cut_torus() -> MeshFile {
    const SIZE: [usize; 2] = [72, 30];
    let mesh = families::torus(SIZE[0], SIZE[1], 2.0, 0.7).unwrap();
    let torus = mesh.clone();
    let turns = |[x, y, z]: [f64; 3]| {
        let out = x.hypot(y);
        [y.atan2(x), z.atan2(out - 2.0)].map(|angle| angle.rem_euclid(std::f64::consts::TAU))
    };
    textured(
        mesh,
        |_| 0,
        |f, _, p| {
            let [here, there] = [turns(middle(&torus, f)), turns(p)];
            std::array::from_fn(|k| {
                let around = ((here[k] - there[k]) / std::f64::consts::TAU).round();
                let turn = there[k] / std::f64::consts::TAU + around;
                // Equal on all faces of one side, to the last bit.
                (turn * SIZE[k] as f64).round() / SIZE[k] as f64
            })
        },
    )
}

/// A terrain whose texture is cut into strips that are turned, or mirrored, or lie on each other.
fn sheet_of_strips() -> MeshFile {
    let mesh = families::terrain(50, 50, 4).unwrap();
    let sheet = mesh.clone();
    textured(
        mesh,
        |f| {
            let [x, y, _] = middle(&sheet, f);
            (5.0 * x + 0.6 * (9.0 * y).sin()).clamp(0.0, 4.9) as usize
        },
        |_, strip, [x, y, _]| match strip % 3 {
            0 => [x, y],
            1 => [y, x],
            _ => [2.0 - x, 1.0 - y],
        },
    )
}

/// A sphere that was split along the seam of its texture, with a value for each vertex, and welded.
fn welded_sphere() -> MeshFile {
    let split = families::split_sphere(60, 30).unwrap();
    let values = (0..split.vertices().len()).map(|v| {
        let z: f64 = split.vertices()[v][2];
        let between = 29 * 61;
        // The vertices at a pole are in the middle below their face.
        let column = if v < between { (v % 61) as f64 } else { ((v - between) % 60) as f64 + 0.5 };
        [column / 60.0, z.asin() / std::f64::consts::PI + 0.5]
    });
    let uv = Attribute { values: values.collect(), corners: None };
    let mut file = MeshFile::from(split);
    file.uv = Some(uv);
    welded(file)
}

#[test]
fn textures_with_seams_are_not_turned_over() {
    let cases = [
        ("six charts", sphere_of_six_charts()),
        ("cut torus", cut_torus()),
        ("strips", sheet_of_strips()),
        ("welded sphere", welded_sphere()),
    ];
    for (name, input) in cases {
        let uv = input.uv.as_ref().unwrap();
        assert!(uv.corners.is_some(), "{name} has a seam");
        for n in [200, 600] {
            let found = decimated(name, &input.mesh, n);
            let carried = found.carry(&input).unwrap();
            let new = carried.uv.as_ref().unwrap();
            let faults = TextureFaults::between((&carried.mesh, new), (&input.mesh, uv));
            assert!(faults.turned <= 0.005, "{name} to {n}: {faults:?}");
            assert!(faults.stretched <= 0.02, "{name} to {n}: {faults:?}");
        }
    }
}

#[test]
fn textures_have_no_cracks_but_seams() {
    // Between faces of one chart, in a texture whose cuts are where charts meet.
    let input = sphere_of_six_charts();
    let found = decimated("six charts", &input.mesh, 400);
    let carried = found.carry(&input).unwrap();
    let uv = carried.uv.as_ref().unwrap();
    let chart = |f: usize| {
        let [u, v] = uv.of_face(&carried.mesh, f).unwrap()[0].map(|x| (x / 3.0).round());
        2.0 * u + v
    };
    let mut values = std::collections::HashMap::new();
    let (mut joined, mut cracks) = (0, 0);
    for (f, face) in carried.mesh.faces().iter().enumerate() {
        for (v, value) in face.iter().zip(uv.of_face(&carried.mesh, f).unwrap()) {
            let first = *values.entry((*v, chart(f).to_bits())).or_insert(value);
            *(if first == value { &mut joined } else { &mut cracks }) += 1;
        }
    }
    assert!(50 * cracks <= joined, "{cracks} of {joined}");
}

#[test]
fn textures_without_area_are_carried_too() {
    // One half of a sphere is in one point of the texture, and single faces of the other half are
    // without area there.
    let mesh = families::icosphere(3).unwrap();
    let sphere = mesh.clone();
    let input = textured(
        mesh,
        |f| if middle(&sphere, f)[2] < 0.0 { 0 } else { 1 + usize::from(f % 7 == 0) * f },
        |_, chart, [x, y, _]| match chart {
            0 => [5.0, 5.0],
            1 => [x, y],
            _ => [x, x],
        },
    );
    let found = decimated("flat texture", &input.mesh, 200);
    let uv = found.carry(&input).unwrap().uv.unwrap();
    assert!(uv.values.as_flattened().iter().all(|x| x.is_finite()));
    let mut points = 0;
    for f in 0..found.mesh.faces().len() {
        let corners = uv.of_face(&found.mesh, f).unwrap();
        let there = corners.as_flattened().iter().all(|x| (x - 5.0).abs() < 1e-12);
        points += usize::from(there);
    }
    assert!((150..250).contains(&points), "{points}");

    // Faces without texture stay without.
    let mut half = input;
    for (f, corners) in half.uv.as_mut().unwrap().corners.iter_mut().flatten().enumerate() {
        if middle(&half.mesh, f)[0] < 0.0 {
            *corners = [Attribute::<2>::ABSENT; 3];
        }
    }
    let uv = found.carry(&half).unwrap().uv.unwrap();
    let faces = 0..found.mesh.faces().len();
    let bare = faces.filter(|&f| uv.of_face(&found.mesh, f).is_none()).count();
    assert!((150..250).contains(&bare), "{bare}");
}

#[test]
fn faces_have_the_materials_groups_and_objects_of_the_input_there() {
    let mut input = sphere_of_six_charts();
    let labels = |of: fn(usize) -> u32| Labels {
        names: vec!["a".into(), "b".into(), "c".into()],
        of_faces: (0..input.mesh.faces().len())
            .map(|f| of(cube_side(middle(&input.mesh, f))))
            .collect(),
    };
    let given = [labels(|side| side as u32 / 2), labels(|side| side as u32 % 2)];
    let some = labels(|side| if side == 5 { Labels::ABSENT } else { 2 });
    [input.materials, input.groups] = given.map(Some);
    input.objects = Some(some);
    input.material_files = vec!["sphere.mtl".into()];
    input.uv = None;
    let values = input.mesh.vertices().to_vec();
    input.normals = Some(Attribute { values, corners: None });
    let found = decimated("labels", &input.mesh, 300);
    let carried = found.carry(&input).unwrap();
    let nearest = nearest_faces(&carried.mesh, &input.mesh);
    for (new, old) in [
        (&carried.materials, &input.materials),
        (&carried.groups, &input.groups),
        (&carried.objects, &input.objects),
    ] {
        let (new, old) = (new.as_ref().unwrap(), old.as_ref().unwrap());
        assert_eq!(new.names, old.names);
        let same = |(f, &g): (usize, &usize)| new.of_face(f) == old.of_face(g);
        let same = nearest.iter().enumerate().filter(|&x| same(x)).count();
        // Where two faces are as near, either may be taken.
        assert!(same + 3 >= nearest.len(), "{same} of {}", nearest.len());
    }
    assert_eq!(carried.material_files, ["sphere.mtl"]);
    assert_eq!((carried.normals, Decimation::left_out(&input)), (None, vec!["normals"]));
}
