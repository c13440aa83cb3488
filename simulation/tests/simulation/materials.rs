//! Normal maps against slopes that are known, materials of slime moulds, and glTF files that have
//! them.

use std::fs;

use catamaran::base::{Progress, Rng};
use catamaran::io::{Output, Overwrite};
use catamaran::{Error, Par};
use catamaran_geometry::mesh::io::{
    Attribute, Material, MeshFile, Picture, read, write_with_material,
};
use catamaran_geometry::mesh::{TriMesh, families};
use catamaran_simulation::texture::slime::{
    BORDER, Mask, NO_TRIANGLE, OUTSIDE, Options, Simulation, Surface, Texels, atlas,
};
use catamaran_simulation::texture::{
    Finish, HeightField, Look, MaterialMaps, Preset, flat_normal_map, margin, normal_colors,
    normal_map,
};

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// A height and its gradient in space.
fn hills(p: Vector) -> (f64, Vector) {
    let [x, y, z] = p;
    let height = (9.0 * x).sin() * 0.5 + (7.0 * y + 4.0 * z).cos() * 0.5;
    let slope = -0.5 * (7.0 * y + 4.0 * z).sin();
    (height, [4.5 * (9.0 * x).cos(), 7.0 * slope, 4.0 * slope])
}

/// The centre of a texel in the plane of its triangle.
fn place(surface: &Surface, size: usize, triangle: usize, texel: usize) -> Vector {
    let [a, b, c] = surface.uv()[triangle];
    let at = |i: usize| (i as f64 + 0.5) / size as f64;
    let (u, v) = (at(texel % size) - a[0], at(texel / size) - a[1]);
    let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let det = p[0] * q[1] - p[1] * q[0];
    let (s, t) = ((u * q[1] - v * q[0]) / det, (p[0] * v - p[1] * u) / det);
    let corners = surface.corners()[triangle];
    let frame = surface.frames()[triangle].map(f64::from);
    let at = |i: usize| {
        corners[0][i] + s * (corners[1][i] - corners[0][i]) + t * (corners[2][i] - corners[0][i])
    };
    let (x, y) = (at(0), at(1));
    [0, 1, 2].map(|i| frame[i] + x * frame[3 + i] + y * frame[6 + i])
}

/// Tangent, bitangent and normal of a triangle, from its corners in space and in the texture.
fn tangents(surface: &Surface, triangle: usize) -> [Vector; 3] {
    let frame = surface.frames()[triangle].map(f64::from);
    let axis = |first: usize| [frame[first], frame[first + 1], frame[first + 2]];
    let (x, y, normal) = (axis(3), axis(6), axis(9));
    let [a, b, c] =
        surface.corners()[triangle].map(|[s, t]| [0, 1, 2].map(|i| s * x[i] + t * y[i]));
    let [ua, ub, uc] = surface.uv()[triangle];
    let (e, f) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    let (d, g) = ([ub[0] - ua[0], ub[1] - ua[1]], [uc[0] - ua[0], uc[1] - ua[1]]);
    let sign = (d[0] * g[1] - g[0] * d[1]).signum();
    let tangent = unit([0, 1, 2].map(|i| sign * (g[1] * e[i] - d[1] * f[i])));
    let across = [
        normal[1] * tangent[2] - normal[2] * tangent[1],
        normal[2] * tangent[0] - normal[0] * tangent[2],
        normal[0] * tangent[1] - normal[1] * tangent[0],
    ];
    [tangent, across.map(|x| sign * x), normal]
}

/// Degrees between the normals of the map, in space, and those of the hills; at seams and
/// elsewhere.
fn errors(surface: &Surface, texels: &Texels, map: &[[f32; 3]], depth: f64) -> [Vec<f64>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for (t, &owner) in texels.owners().iter().enumerate() {
        if owner == NO_TRIANGLE {
            continue;
        }
        let [tangent, bitangent, normal] = tangents(surface, owner as usize);
        let [x, y, z] = map[t].map(f64::from);
        let seen = [0, 1, 2].map(|i| x * tangent[i] + y * bitangent[i] + z * normal[i]);
        let (_, slope) = hills(place(surface, texels.size(), owner as usize, t));
        let steep = dot(slope, normal);
        let expected = unit([0, 1, 2].map(|i| normal[i] - depth * (slope[i] - steep * normal[i])));
        let angle = dot(seen, expected).clamp(-1.0, 1.0).acos().to_degrees();
        found[usize::from(texels.kinds()[t] != BORDER)].push(angle);
    }
    found
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn normal_maps_have_the_slopes_of_the_surface_over_seams_too() {
    let size = 512;
    let depth = 0.1;
    let mirrored = |mesh: &TriMesh| {
        let uv = atlas(mesh, size).unwrap();
        uv.into_iter().map(|face| face.map(|[u, v]| [1.0 - u, v])).collect()
    };
    let sphere = families::icosphere(3).unwrap();
    let torus = families::torus(32, 16, 2.0, 0.7).unwrap();
    for surface in [
        Surface::of_faces(&sphere, atlas(&sphere, size).unwrap()).unwrap(),
        Surface::of_faces(&torus, mirrored(&torus)).unwrap(),
    ] {
        let texels = Texels::new(&surface, size).unwrap();
        let heights: Vec<f32> = (0..size * size)
            .map(|t| match texels.owners()[t] {
                NO_TRIANGLE => 0.0,
                owner => hills(place(&surface, size, owner as usize, t)).0 as f32,
            })
            .collect();
        let map = normal_map(&surface, &texels, &heights, depth, Par::all()).unwrap();
        assert_eq!(map, normal_map(&surface, &texels, &heights, depth, Par::Seq).unwrap());
        let [seams, inside] = errors(&surface, &texels, &map, depth);
        println!("{} {} {} {}", seams.len(), mean(&seams), inside.len(), mean(&inside));
        assert!(mean(&inside) < 0.2, "{}", mean(&inside));
        assert!(mean(&seams) < 1.5, "{}", mean(&seams));
        // Without a look over seams, half of a difference there is to what lies beside the chart.
        let field = HeightField {
            heights: &heights,
            width: size,
            texel: 1.0 / size as f64,
            depth,
            repeats: false,
        };
        let [careless, _] = errors(&surface, &texels, &flat_normal_map(field).unwrap(), depth);
        assert!(mean(&careless) > 10.0 * mean(&seams), "{}", mean(&careless));
    }
}

#[test]
fn planes_lean_as_their_heights_say_and_tiles_repeat() {
    let (width, height) = (48, 24);
    let turn = std::f64::consts::TAU;
    let wave = |i: f64, j: f64| (turn * i / 48.0).sin() + (turn * j / 24.0).cos();
    let heights: Vec<f32> =
        (0..width * height).map(|t| wave((t % width) as f64, (t / width) as f64) as f32).collect();
    let field = HeightField { heights: &heights, width, texel: 0.5, depth: 2.0, repeats: true };
    let map = flat_normal_map(field).unwrap();
    // Central differences of a sine are its slope times sin(h) / h.
    let damped = |count: f64| (turn / count).sin() / (turn / count);
    for (t, n) in map.iter().enumerate() {
        let (i, j) = ((t % width) as f64, (t / width) as f64);
        let x = 2.0 / 0.5 * turn / 48.0 * damped(48.0) * (turn * i / 48.0).cos();
        let y = -2.0 / 0.5 * turn / 24.0 * damped(24.0) * (turn * j / 24.0).sin();
        let length = (1.0 + x * x + y * y).sqrt();
        for (found, expected) in n.iter().zip([-x / length, -y / length, 1.0 / length]) {
            assert!((f64::from(*found) - expected).abs() < 1e-5, "{t}: {n:?}");
        }
    }
    let refused = |field| flat_normal_map(field).unwrap_err();
    assert!(matches!(refused(HeightField { width: 47, ..field }), Error::Shape { .. }));
    assert!(matches!(refused(HeightField { texel: 0.0, ..field }), Error::Argument { .. }));
    assert!(matches!(refused(HeightField { depth: f64::NAN, ..field }), Error::Argument { .. }));
    assert_eq!(
        flat_normal_map(HeightField { width: 1, heights: &[3.0], ..field }),
        Ok(vec![[0.0, 0.0, 1.0]])
    );
    assert_eq!(
        normal_colors(&[[0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]]),
        [[128, 128, 255], [0, 255, 128]]
    );
}

#[test]
fn outside_of_charts_is_what_is_nearest() {
    let mesh = families::grid(1, 1).unwrap();
    let uv = mesh
        .faces()
        .iter()
        .map(|face| face.map(|v| [0, 1].map(|k| 0.25 + 0.25 * mesh.vertices()[v as usize][k])));
    let surface = Surface::of_faces(&mesh, uv.collect()).unwrap();
    let texels = Texels::new(&surface, 128).unwrap();
    let shown = margin(&texels).unwrap();
    for (t, &from) in shown.iter().enumerate() {
        let (i, j) = (t % 128, t / 128);
        let beyond = |x: usize| (32_usize.saturating_sub(x)).max(x.saturating_sub(64));
        let distance = beyond(i).max(beyond(j));
        if texels.kinds()[t] != OUTSIDE || distance > 17 {
            assert_eq!(from as usize, t);
        } else if distance < 16 {
            assert_ne!(texels.kinds()[from as usize], OUTSIDE, "{i} {j}");
            assert!((from % 128).abs_diff(i as u32).max((from / 128).abs_diff(j as u32)) <= 17);
        }
    }
}

fn overgrown(species: usize) -> Simulation {
    let torus = families::torus(24, 12, 2.0, 0.7).unwrap();
    let surface = Surface::of_faces(&torus, atlas(&torus, 256).unwrap()).unwrap();
    let options = Options::new().agents(4000).size(256).species(species).vision_distance(2.0);
    let mut all = Simulation::new(surface, &options, &Mask::default()).unwrap();
    all.run(40, Par::all(), Progress::none()).unwrap();
    all
}

#[test]
fn a_material_has_the_finish_of_what_is_there() {
    let all = overgrown(2);
    let bare = Finish::new().color([10, 20, 30]).roughness(0.8).height(-0.5);
    let species = [
        Finish::new().color([250, 200, 90]).roughness(0.2).metalness(1.0).height(1.0),
        Finish::new().color([90, 200, 250]).roughness(0.4).height(0.5).glow(0.5),
    ];
    let look = Look::default().bare(bare).species(species).mask([0.1, 0.3]).depth(2.0).smoothing(0);
    let maps = MaterialMaps::new(&all, &look, Par::all()).unwrap();
    assert_eq!(maps, MaterialMaps::new(&all, &look, Par::Seq).unwrap());
    assert_eq!(maps.depth, 1.5 * 0.02);
    let glow = maps.glow.as_ref().unwrap();
    let (mut nothing, mut first, mut second) = (0, 0, 0);
    for t in (0..256 * 256).filter(|&t| all.texels().kinds()[t] != OUTSIDE) {
        let [a, b] = [0, 1].map(|s| all.texture(s)[t]);
        if a <= 0.1 && b <= 0.1 {
            let found =
                (maps.albedo[t], maps.roughness[t], maps.metalness[t], maps.height[t], glow[t]);
            assert_eq!(found, ([10, 20, 30], 204, 0, 0, [0; 3]));
            nothing += 1;
        } else if a >= 0.3 && b <= 0.1 {
            let found =
                (maps.albedo[t], maps.roughness[t], maps.metalness[t], maps.height[t], glow[t]);
            assert_eq!(found, ([250, 200, 90], 51, 255, 65535, [0; 3]));
            first += 1;
        } else if b >= 0.3 && a <= 0.1 {
            assert_eq!((maps.albedo[t], maps.height[t]), ([90, 200, 250], 43690));
            assert!(glow[t][2] > 100);
            second += 1;
        }
    }
    assert!(nothing > 1000 && first > 500 && second > 500, "{nothing} {first} {second}");
    // All that filters can mix in is what is on the surface.
    assert!(!maps.albedo.iter().take(256).any(|c| *c == [0; 3]));
    for (name, preset) in Preset::ALL {
        let maps = MaterialMaps::new(&all, &Look::of(preset), Par::all()).unwrap();
        assert_eq!(maps.glow.is_some(), name == "lava");
        let leaning = maps.normal.iter().filter(|n| n[0].abs_diff(128) > 1).count();
        assert!(leaning > 200, "{name}: {leaning}");
    }
}

#[test]
fn looks_out_of_range_are_named() {
    let look = Look::default;
    for (name, wrong) in [
        ("roughness", look().bare(Finish::new().roughness(1.5))),
        ("metalness", look().species([Finish::new().metalness(-0.1)])),
        ("height", look().bare(Finish::new().height(f64::NAN))),
        ("glow", look().bare(Finish::new().glow(2.0))),
        ("species", look().species([])),
        ("mask", look().mask([0.5, 0.5])),
        ("depth", look().depth(-1.0)),
        ("smoothing", look().smoothing(65)),
    ] {
        let found = wrong.check();
        assert!(matches!(&found, Err(Error::Argument { what, .. }) if *what == name), "{found:?}");
    }
}

fn create(folder: &tempfile::TempDir, name: &str) -> Output {
    Output::create(&folder.path().join(name), Overwrite::Never).unwrap()
}

/// A sphere with texture coordinates, normals, and a material with a picture in every slot.
fn painted() -> (MeshFile, Material, Vec<Picture>) {
    let mesh = families::icosphere(1).unwrap();
    let uv = atlas(&mesh, 128).unwrap();
    let corners = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let mut file = MeshFile::from(mesh);
    file.uv =
        Some(Attribute { values: uv.into_iter().flatten().collect(), corners: Some(corners) });
    file.normals = Some(Attribute { values: file.mesh.vertex_normals(), corners: None });
    let mut rng = Rng::new(3);
    let mut byte = || (256.0 * rng.uniform()) as u8;
    let pixels: Vec<[u8; 3]> = (0..35).map(|_| [byte(), byte(), byte()]).collect();
    let grays: Vec<u8> = (0..35).map(|_| byte()).collect();
    let deep: Vec<u16> = (0..35).map(|i| 1800 * i).collect();
    let pictures = vec![
        Picture::rgb(7, &pixels).unwrap(),
        Material::finish(7, &grays, &grays).unwrap(),
        Picture::rgb(5, &pixels).unwrap().flipped(),
        Picture::gray(7, &grays).unwrap(),
        Picture::rgb(35, &pixels).unwrap(),
        Picture::gray16(7, &deep).unwrap(),
    ];
    let [base, finish, normal, occlusion, emission, height] =
        [0, 1, 2, 3, 4, 5].map(|i: usize| pictures[i].clone());
    let material = Material::new()
        .name("painted")
        .base_color(base)
        .roughness_metalness(finish)
        .normal(normal)
        .occlusion(occlusion)
        .emission(emission)
        .extra([("height".to_owned(), height)]);
    (file, material, pictures)
}

#[test]
fn other_readers_find_mesh_material_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let (file, material, pictures) = painted();
    write_with_material(create(&folder, "a.glb"), &file, &material).unwrap();
    let bytes = fs::read(folder.path().join("a.glb")).unwrap();
    // This reader checks the document.
    let found = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = found.blob.as_deref().unwrap();
    let primitive = found.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(blob));
    let positions: Vec<_> = reader.read_positions().unwrap().collect();
    let uv: Vec<_> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    let normals: Vec<_> = reader.read_normals().unwrap().collect();
    let indices: Vec<_> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices.len(), 3 * file.mesh.faces().len());
    assert!(uv.len() == positions.len() && normals.len() == positions.len());
    for (f, face) in file.mesh.faces().iter().enumerate() {
        for k in 0..3 {
            let i = indices[3 * f + k] as usize;
            let [u, v] = file.uv.as_ref().unwrap().of_face(&file.mesh, f).unwrap()[k];
            assert_eq!(positions[i], file.mesh.vertices()[face[k] as usize].map(|x| x as f32));
            assert_eq!(uv[i], [u as f32, (1.0 - v) as f32]);
        }
    }
    let read_material = primitive.material();
    assert_eq!((read_material.name(), read_material.double_sided()), (Some("painted"), true));
    assert_eq!(read_material.emissive_factor(), [1.0; 3]);
    let pbr = read_material.pbr_metallic_roughness();
    assert_eq!((pbr.metallic_factor(), pbr.roughness_factor()), (1.0, 1.0));
    let images = [
        pbr.base_color_texture().unwrap().texture(),
        pbr.metallic_roughness_texture().unwrap().texture(),
        read_material.normal_texture().unwrap().texture(),
        read_material.occlusion_texture().unwrap().texture(),
        read_material.emissive_texture().unwrap().texture(),
        found.textures().nth(5).unwrap(),
    ];
    for (texture, picture) in images.iter().zip(&pictures) {
        let gltf::image::Source::View { view, mime_type } = texture.source().source() else {
            panic!("not in the file")
        };
        assert_eq!((mime_type, view.offset() % 4, view.target()), ("image/png", 0, None));
        let png = &blob[view.offset()..view.offset() + view.length()];
        assert_eq!(png, picture.to_png().unwrap());
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let info = decoder.info();
        assert_eq!((info.width, info.height), (picture.width() as u32, picture.height() as u32));
        let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
        decoder.next_frame(&mut pixels).unwrap();
        assert!(pixels.iter().any(|&x| x > 100));
    }
    // What has no slot is named beside them.
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let document: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    assert_eq!(document["materials"][0]["extras"]["height"]["texture"], 5);
    assert_eq!(document["images"][5]["name"], "height");
    // And our own, from both encodings.
    write_with_material(create(&folder, "a.gltf"), &file, &material).unwrap();
    for name in ["a.glb", "a.gltf"] {
        let back = read(&folder.path().join(name)).unwrap();
        assert_eq!(back.mesh.faces().len(), file.mesh.faces().len());
        assert_eq!(back.materials.unwrap().names, ["painted"]);
        assert!(
            back.notes.iter().any(|note| note.contains("left out textures")),
            "{:?}",
            back.notes
        );
    }
}

#[test]
fn materials_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (mut file, material, _) = painted();
    let refused = |file: &MeshFile, material: &Material, name: &str| {
        let error = write_with_material(create(&folder, name), file, material).unwrap_err();
        assert!(fs::read_dir(folder.path()).unwrap().next().is_none(), "a file is left behind");
        error.to_string()
    };
    assert!(refused(&file, &material, "a.obj").contains(".glb"));
    let wrong = material.clone().roughness(1.2);
    assert!(refused(&file, &wrong, "a.glb") == "roughness: must be from 0 to 1, is 1.2");
    if let Some(corners) = file.uv.as_mut().and_then(|uv| uv.corners.as_mut()) {
        corners[3] = [Attribute::<2>::ABSENT; 3];
    }
    assert!(refused(&file, &material, "a.glb").starts_with("uv: face 3"));
    file.uv = None;
    assert!(refused(&file, &material, "a.glb").starts_with("uv: face 0"));
    // Without pictures nothing has to be laid over it.
    let plain = Material::new().name("plain").roughness(0.25).metalness(1.0);
    write_with_material(create(&folder, "plain.glb"), &file, &plain).unwrap();
    let found =
        gltf::Gltf::from_slice(&fs::read(folder.path().join("plain.glb")).unwrap()).unwrap();
    let pbr = found.materials().next().unwrap().pbr_metallic_roughness();
    assert_eq!((pbr.metallic_factor(), pbr.roughness_factor()), (1.0, 0.25));
    // An empty mesh has no material.
    let nothing = MeshFile::from(TriMesh::new(vec![], vec![]).unwrap());
    write_with_material(create(&folder, "empty.glb"), &nothing, &material).unwrap();
    assert!(read(&folder.path().join("empty.glb")).unwrap().materials.is_none());
    assert!(matches!(Material::finish(2, &[1, 2], &[1]), Err(Error::Shape { .. })));
    assert!(matches!(Picture::gray(0, &[]), Err(Error::Shape { .. })));
    assert!(matches!(Picture::gray16(3, &[1; 4]), Err(Error::Shape { .. })));
}
