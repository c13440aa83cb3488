//! `catamaran newton`, from outside.

use std::process::Command;

use crate::common::{Folder, Run, calls};

/// Width, height, and bits of a PNG.
fn size_and_bits(folder: &Folder, name: &str) -> (u32, u32, u8) {
    let bytes = std::fs::read(folder.path(name)).unwrap();
    assert!(bytes.starts_with(b"\x89PNG"), "{name}");
    let side = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (side(16), side(20), bytes[24])
}

#[test]
fn a_plane_is_drawn_and_nothing_is_replaced() {
    let folder = Folder::new();
    let command = "newton --power 5 --size 64x40 -o a.png --heights h.png --threads 2";
    let said = folder.succeed(command);
    assert!(said.contains("2560 on cpu, 32 iterations"), "{said}");
    assert_eq!(size_and_bits(&folder, "a.png"), (64, 40, 8));
    assert_eq!(size_and_bits(&folder, "h.png"), (64, 40, 16));
    let before = std::fs::read(folder.path("a.png")).unwrap();
    assert!(folder.fail(command).contains("exists already"));
    folder.succeed("newton --power 5 --size 64x40 -o a.png --threads 1 --force");
    assert_eq!(std::fs::read(folder.path("a.png")).unwrap(), before, "threads decide nothing");
}

#[test]
fn a_polynomial_is_drawn_as_its_roots_are() {
    let folder = Folder::new();
    folder.succeed("newton --polynomial (2+2i)(z-1)(z+1) --size 40 -o written.png");
    folder.succeed("newton --roots -1,0:1,0 --size 40 -o roots.png");
    let [written, roots] =
        ["written.png", "roots.png"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert_eq!(written, roots);
    assert!(folder.fail("newton --polynomial 3+i -o c.png").contains("must not be constant"));
    for (polynomial, why) in [("z+", "the text ends where"), ("z^65", "the power is above 64")] {
        let refused = folder.run(&format!("newton --polynomial {polynomial} -o c.png"));
        assert_eq!(refused.code, Some(2));
        assert!(refused.stderr.contains(why), "{}", refused.stderr);
    }
}

#[test]
fn polynomials_with_roots_far_from_one_are_drawn_as_their_roots_are() {
    let folder = Folder::new();
    let drawn = |options: &str, extent: &str| {
        folder.succeed(&format!("newton --size 40 --force -o a.png --extent {extent} {options}"));
        pixels(&folder.path("a.png"))
    };
    for (polynomial, roots, extent) in [
        ("(z^2-1e-10)(z^2-4e-10)", "-2e-5,0:-1e-5,0:1e-5,0:2e-5,0", "6e-5"),
        ("1e300z^2-1e300", "-1,0:1,0", "3"),
        ("(z^2-1e6)(z^2-4e6)", "-2e3,0:-1e3,0:1e3,0:2e3,0", "6e3"),
    ] {
        let written = drawn(&format!("--polynomial={polynomial}"), extent);
        let given = drawn(&format!("--roots={roots}"), extent);
        let different = written.iter().zip(&given).filter(|(a, b)| a != b).count();
        assert!(different <= 8, "{polynomial}: {different} pixels");
    }
    // Four basins of about the same size.
    for (polynomial, extent) in [("z^4-1e-20", "3e-5"), ("z^4-1e12", "3e3")] {
        let mut colors = drawn(&format!("--polynomial={polynomial}"), extent);
        colors.sort_unstable();
        let largest = colors.chunk_by(|a, b| a == b).map(<[_]>::len).max().unwrap();
        assert!(largest <= 40 * 40 / 3, "{polynomial}: {largest} pixels of one colour");
    }
    // The third roots of 1e30 and 1e15.
    for (polynomial, re) in [("z^3-1e30", -5e9), ("z^3-1e15", -5e4)] {
        let said = folder.fail(&format!("newton --polynomial {polynomial} -o b.png"));
        let (_, root) = said.split_once("--polynomial: root 0 must be within +-1e4, is [").unwrap();
        let found: f64 = root.split(',').next().unwrap().parse().unwrap();
        assert!((found / re - 1.0).abs() < 1e-9, "{said}");
    }
    let said = folder.fail("newton --polynomial z^4-1e-60 -o b.png");
    assert!(said.contains("--polynomial: the largest root must be 0 or at least 1e-12"), "{said}");
}

#[test]
fn a_mesh_gets_colours_and_a_texture() {
    let folder = Folder::new();
    folder.write(
        "square.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    folder.succeed("newton square.obj --w 0.2 -o colored.ply --heights h.csv --picture view.png");
    let file = catamaran_geometry::mesh::io::read(&folder.path("colored.ply")).unwrap();
    assert_eq!(file.colors.unwrap().len(), 4);
    assert_eq!(std::fs::read_to_string(folder.path("h.csv")).unwrap().lines().count(), 4);
    assert!(size_and_bits(&folder, "view.png").0 > 100);
    folder.succeed("newton square.obj --uv --size 32 -o texture.png");
    assert_eq!(size_and_bits(&folder, "texture.png"), (32, 32, 8));
    assert!(folder.fail("newton square.obj --uv -o texture.ply").contains(".png"));
    folder.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(folder.fail("newton bare.obj --uv -o t.png").contains("no texture coordinates"));
    // Points have colours, and no picture.
    folder.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    folder.succeed("newton points.obj -o points.ply");
    for options in ["--picture p.png", "--uv -o p.png"] {
        let said = folder.fail(&format!("newton points.obj {options}"));
        assert!(said.contains("points.obj: has no faces"), "{said}");
    }
}

#[test]
fn a_mesh_has_the_same_colours_whatever_its_unit_and_place() {
    use catamaran_geometry::mesh::{TriMesh, families};
    let folder = Folder::new();
    let sphere = families::icosphere(3).unwrap();
    let colors = |name: &str, size: f64, shift: f64, options: &str| {
        let place = |p: &[f64; 3]| p.map(|x| size * x + shift);
        let vertices = sphere.vertices().iter().map(place).collect();
        let mesh = TriMesh::new(vertices, sphere.faces().to_vec()).unwrap();
        let overwrite = catamaran::io::Overwrite::Replace;
        let output = catamaran::io::Output::create(&folder.path(name), overwrite).unwrap();
        catamaran_geometry::mesh::io::write(output, &mesh.into()).unwrap();
        folder.succeed(&format!("newton {name} --power 5 {options} -o colored.ply --force"));
        let file = catamaran_geometry::mesh::io::read(&folder.path("colored.ply")).unwrap();
        // The mesh itself stays where it is.
        assert!((file.mesh.vertices()[0][0] - place(&sphere.vertices()[0])[0]).abs() < 1e-3 * size);
        file.colors.unwrap()
    };
    let count = |colors: &[[f64; 4]]| {
        let mut all: Vec<_> = colors.iter().map(|c| c.map(|x| (20.0 * x) as u8)).collect();
        all.sort_unstable();
        all.dedup();
        all.len()
    };
    let unit = colors("unit.ply", 1.0, 0.0, "");
    assert!(count(&unit) > 20, "{}", count(&unit));
    let large = colors("large.ply", 1024.0, 65536.0, "");
    let same = unit.iter().zip(&large).filter(|(a, b)| a == b).count();
    // Positions are rounded differently, and borders of basins are fine.
    assert!(10 * same > 9 * unit.len(), "{same} of {}", unit.len());
    let raw = colors("large.ply", 1024.0, 65536.0, "--no-fit");
    assert!(count(&raw) <= 2, "{}", count(&raw));
    folder.write("point.obj", "v 1 2 3\n");
    assert!(folder.fail("newton point.obj -o x.ply").contains("point.obj"));
}

#[test]
fn a_volume_is_an_array_and_frames_are_numbered() {
    let folder = Folder::new();
    folder.succeed("newton --volume --size 9 --roots 1,0:-1,0.5 -o v.npy --heights t.npy");
    let roots = folder.read_npy::<f32>("v.npy", &[81, 9]);
    assert_eq!(roots.len(), 9 * 9 * 9);
    assert!(roots.iter().all(|&root| (0.0..4.0).contains(&root) && root.fract() == 0.0));
    assert_eq!(folder.read_npy::<f32>("t.npy", &[81, 9]).len(), roots.len());
    folder.succeed("newton --size 8 --frames 3 --w 0 --w-to 1 -o f.png");
    let names = folder.names();
    for name in ["f-000.png", "f-001.png", "f-002.png"] {
        assert!(names.iter().any(|n| n == name), "{names:?}");
    }
    // Frames of an earlier run stay, with a note; those of another output are not taken for them.
    let noted = |options: &str| {
        let run = folder.run(&format!("newton --size 8 --w-to 1 -o f.png {options}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    let older = "note: .: frames that this run does not write stay: 1, f-002.png\n";
    assert!(noted("--frames 2 --force --heights f-7.png").contains(older));
    assert!(folder.path("f-002.png").exists());
    assert!(!noted("--frames 3 --force").contains("does not write"));
}

#[test]
fn a_volume_is_drawn_the_same_by_any_number_of_threads() {
    let folder = Folder::new();
    folder.succeed("newton --volume --size 20 --picture slow.png --threads 1");
    folder.succeed("newton --volume --size 20 --picture again.png --threads 3");
    let [one, three] =
        ["slow.png", "again.png"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert_eq!(one, three);
    assert_eq!(size_and_bits(&folder, "slow.png"), (800, 800, 8));
    let pixels = |options: &str| {
        folder.succeed(&format!("newton --volume --size 20 --picture p.png --force {options}"));
        pixels(&folder.path("p.png"))
    };
    let ink = |pixels: &[[u8; 3]]| pixels.iter().filter(|p| p.iter().any(|c| *c < 245)).count();
    let [slow, solid, one] = ["", "--opacity solid", "--basins 0"].map(&pixels);
    // The whole cube is opaque; a basin is a part of it; borders let light through.
    assert!(ink(&one) < ink(&solid) && ink(&one) > 10_000, "{} {}", ink(&one), ink(&solid));
    assert!(slow != solid);
    let one = pixels("--basins 4");
    for options in ["--opacity slow", "--view 120,40", "--up z"] {
        assert!(pixels(&format!("--basins 4 {options}")) != one, "{options}");
    }
}

#[test]
fn the_surface_of_a_basin_is_closed_and_has_the_colour_of_its_root() {
    let folder = Folder::new();
    let said = folder.succeed("newton --volume --size 24 --basins 4 -o one.ply --picture one.png");
    assert!(said.contains("surface     ") && said.contains(" faces, volume "), "{said}");
    let one = catamaran_geometry::mesh::io::read(&folder.path("one.ply")).unwrap();
    one.mesh.require_closed().unwrap();
    let colors = one.colors.unwrap();
    assert!(colors.iter().all(|color| *color == colors[0]));
    assert!(size_and_bits(&folder, "one.png").0 > 100);
    folder.succeed("newton --volume --size 24 -o roots.npy");
    let roots = folder.read_npy::<f32>("roots.npy", &[24 * 24, 24]);
    let voxels = roots.iter().filter(|&&root| root == 4.0).count() as f64;
    let ratio = one.mesh.volume().unwrap() / (voxels * (3.0_f64 / 24.0).powi(3));
    // Crumbs of one voxel have half of its volume.
    assert!((0.9..1.0).contains(&ratio), "{ratio}");

    folder.succeed("newton --volume --size 24 --basins all -o all.obj --threads 1");
    let all = catamaran_geometry::mesh::io::read(&folder.path("all.obj")).unwrap();
    all.mesh.require_closed().unwrap();
    let volume = all.mesh.volume().unwrap();
    assert!(volume > 24.0 && volume < 27.0, "{volume}");
    assert_eq!(all.groups.unwrap().names.len(), 9);
    let mut colors: Vec<_> =
        all.colors.unwrap().iter().map(|c| c.map(|x| (255.0 * x) as u8)).collect();
    colors.sort_unstable();
    colors.dedup();
    assert_eq!(colors.len(), 9);
}

#[test]
fn voxels_are_written_for_viewers() {
    let folder = Folder::new();
    folder.succeed("newton --volume --size 12 -o roots.npy --heights t.npy");
    let roots = folder.read_npy::<f32>("roots.npy", &[144, 12]);
    let convergence = folder.read_npy::<f32>("t.npy", &[144, 12]);
    let after = |name: &str, end: &str| {
        let bytes = std::fs::read(folder.path(name)).unwrap();
        let at = bytes.windows(end.len()).position(|w| w == end.as_bytes()).unwrap();
        bytes[at + end.len()..].to_vec()
    };
    let u16s = |bytes: &[u8]| -> Vec<f32> {
        bytes.chunks_exact(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]]))).collect()
    };
    let f32s = |bytes: &[u8]| -> Vec<f32> {
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    };
    folder.succeed("newton --volume --size 12 -o v.nrrd --heights t.nrrd");
    assert_eq!(u16s(&after("v.nrrd", "\n\n")), roots);
    assert_eq!(f32s(&after("t.nrrd", "\n\n")), convergence);
    folder.succeed("newton --volume --size 12 -o v.vti");
    let data = after("v.vti", "encoding=\"raw\">\n_");
    let count = roots.len();
    assert_eq!(u16s(&data[8..8 + 2 * count]), roots);
    assert_eq!(f32s(&data[16 + 2 * count..16 + 6 * count]), convergence);
    folder.succeed("newton --volume --size 12 -o v.nrrd --heights p.vti --compress --force");
    let mut unpacked = Vec::new();
    let packed = after("v.nrrd", "\n\n");
    let mut decoder = flate2::read::GzDecoder::new(&packed[..]);
    std::io::Read::read_to_end(&mut decoder, &mut unpacked).unwrap();
    assert_eq!(u16s(&unpacked), roots);
    let head = String::from_utf8_lossy(&std::fs::read(folder.path("p.vti")).unwrap()).into_owned();
    assert!(head.contains("vtkZLibDataCompressor") && head.contains("Scalars=\"convergence\""));
}

/// Frames of an animated PNG, and their delay in seconds.
fn apng(folder: &Folder, name: &str) -> (Vec<Vec<u8>>, f64) {
    let file = std::io::BufReader::new(std::fs::File::open(folder.path(name)).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let count = reader.info().animation_control().unwrap().num_frames;
    let mut frames = Vec::new();
    let mut delay = 0.0;
    for _ in 0..count {
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let size = reader.next_frame(&mut bytes).unwrap().buffer_size();
        bytes.truncate(size);
        frames.push(bytes);
        let control = reader.info().frame_control().unwrap();
        delay = f64::from(control.delay_num) / f64::from(control.delay_den);
    }
    (frames, delay)
}

#[test]
fn frames_are_an_animation_if_the_file_is_called_like_one() {
    let folder = Folder::new();
    let command = "newton --power 4 --size 30x20 --frames 3 --w-to 1";
    folder.succeed(&format!("{command} -o f.png"));
    let said = folder.succeed(&format!("{command} -o a.apng --fps 4"));
    assert!(said.contains("written     a.apng"), "{said}");
    let (frames, delay) = apng(&folder, "a.apng");
    assert_eq!(delay, 0.25);
    for (i, frame) in frames.iter().enumerate() {
        let alone = pixels(&folder.path(&format!("f-{i:03}.png")));
        assert_eq!(frame, alone.as_flattened(), "frame {i}");
    }
    assert_eq!(frames.len(), 3);

    folder.succeed(&format!("{command} -o a.gif --fps 5"));
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let file = std::fs::File::open(folder.path("a.gif")).unwrap();
    let mut decoder = options.read_info(file).unwrap();
    assert_eq!((decoder.width(), decoder.height()), (30, 20));
    let mut count = 0;
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 20);
        let exact = frames[count].chunks_exact(3).zip(frame.buffer.chunks_exact(4));
        let off = exact.map(|(a, b)| (0..3).map(|c| u32::from(a[c].abs_diff(b[c]))).sum::<u32>());
        assert!(off.sum::<u32>() < 600 * 3 * 6, "frame {count}");
        count += 1;
    }
    assert_eq!(count, 3);
    assert!(!folder.names().iter().any(|name| name.ends_with(".tmp")));
}

#[test]
fn pictures_of_volumes_and_meshes_move_too() {
    let folder = Folder::new();
    let frames = "--frames 2 --w-to 0.5";
    folder.succeed(&format!("newton --volume --size 10 --basins 0 {frames} --picture v.apng"));
    let (all, delay) = apng(&folder, "v.apng");
    assert!(all.len() == 2 && all[0] != all[1]);
    assert!((delay - 1.0 / 12.0).abs() < 1e-3);
    folder.write("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.succeed(&format!("newton triangle.obj {frames} -o t.ply --picture t.png"));
    folder.succeed(&format!("newton triangle.obj {frames} --picture t.gif"));
    folder.succeed(&format!(
        "newton --volume --size 10 --basins 0 {frames} -o s.ply --picture s.apng"
    ));
    let names = folder.names();
    for name in ["t-000.ply", "t-001.ply", "t-000.png", "t-001.png", "t.gif", "s-001.ply", "s.apng"]
    {
        assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
    }
}

#[test]
fn a_material_is_in_a_file_with_its_mesh() {
    let folder = Folder::new();
    folder.write(
        "square.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    let command = "newton square.obj --uv --size 64";
    folder.succeed(&format!("{command} -o texture.png --write-material enamel.glb"));
    folder.succeed(&format!("{command} --write-material stones.glb --inlay stones"));
    let json = |name: &str| {
        let bytes = std::fs::read(folder.path(name)).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        String::from_utf8(bytes[20..20 + length].to_vec()).unwrap()
    };
    for name in ["enamel.glb", "stones.glb"] {
        let text = json(name);
        for part in ["baseColorTexture", "metallicRoughnessTexture", "normalTexture", "height"] {
            assert!(text.contains(part), "{name}: {part}");
        }
        assert_eq!(
            catamaran_geometry::mesh::io::read(&folder.path(name)).unwrap().mesh.faces().len(),
            2
        );
    }
    let [enamel, stones] =
        ["enamel.glb", "stones.glb"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert_ne!(enamel, stones);
    assert!(folder.fail(&format!("{command} --write-material a.ply")).contains(".glb or .gltf"));
    folder.write(
        "half.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\n",
    );
    let said = folder.run("newton half.obj --uv --size 16 -o half.png").stderr;
    assert!(said.contains("half.obj: 1 of 2 faces have no texture coordinates"), "{said}");
    folder.write("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 3 0\nvt 0 3\nf 1/1 2/2 3/3\n");
    let said = folder.run("newton far.obj --uv --size 16 -o far.png").stderr;
    assert!(said.contains("far.obj: parts with texture coordinates outside of 0 to 1"), "{said}");
    let bare = folder.fail("newton half.obj --uv --size 16 --write-material a.glb");
    assert!(bare.contains("half.obj: face 1: has no texture coordinates"), "{bare}");
    let oblong = folder.fail("newton square.obj --uv --size 8x4 --write-material a.glb");
    assert!(oblong.contains("are square"), "{oblong}");
    let run = folder.run("newton square.obj --write-material a.glb");
    assert!(run.code == Some(2) && run.stderr.contains("--uv"), "{}", run.stderr);
}

#[test]
fn options_of_meshes_and_of_volumes_exclude_each_other() {
    let folder = Folder::new();
    for options in [
        "--volume --write-material b.glb",
        "--volume --write-material b.glb --inlay stones",
        "--volume --picture b.png --inlay stones",
        "--volume --picture b.png --no-fit",
        "--volume --picture b.png --uv",
        "square.obj --no-fit --extent 7 -o b.ply",
        "square.obj --basins 0 -o b.ply",
        "square.obj --opacity slow -o b.ply",
        "square.obj --compress -o b.ply",
        "--uv --basins 0 -o b.png",
        "--volume --weld -o b.npy",
        "--volume --drop-specks 0.3 -o b.npy",
        "--volume --strict -o b.npy",
    ] {
        let run = folder.run(&format!("newton --size 16 {options}"));
        assert_eq!(run.code, Some(2), "{options}: {}", run.stderr);
        assert!(run.stderr.contains("cannot be used with"), "{options}: {}", run.stderr);
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn the_commands_of_the_guide_run() {
    let guide = include_str!("../../../docs/guide/newton.md");
    let folder = Folder::new();
    folder.write(
        "vase.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    for line in calls(guide) {
        // Smaller: what is tested is that they run.
        let mut words: Vec<&str> = Vec::new();
        let mut quoted = line.split('"').enumerate();
        quoted.by_ref().for_each(|(i, part)| match i % 2 {
            0 => words.extend(part.split_whitespace()),
            _ => words.push(part),
        });
        if let Some(at) = words.iter().position(|word| *word == "--size") {
            words.drain(at..at + 2);
        }
        if let Some(at) = words.iter().position(|word| *word == "--frames") {
            words[at + 1] = "2";
        }
        // A mesh without a texture has its vertices.
        if !words.contains(&"vase.obj") || words.contains(&"--uv") {
            words.extend(["--size", "16"]);
        }
        let run = folder.program().args(words).arg("--force").output().unwrap();
        assert!(run.status.success(), "{line}: {}", String::from_utf8_lossy(&run.stderr));
    }
    for name in ["basins.glb", "roots.nrrd", "time.apng", "vase.apng", "borders.png"] {
        assert!(folder.path(name).exists(), "{name}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let folder = Folder::new();
    for (command, part) in [
        ("newton --power 1 -o a.png", "--power: must have 2 to 64 roots, has 1"),
        ("newton --roots 1e5,0:1,0 -o a.png", "--roots: root 0 must be within +-1e4"),
        ("newton --polynomial 3 -o a.png", "--polynomial: must not be constant"),
        ("newton --iterations 0 -o a.png", "--iterations: must be from 1 to 1,000, is 0"),
        ("newton --iterations 1001 -o a.png", "--iterations: must be from 1 to 1,000, is 1001"),
        ("newton --scale 2e9 -o a.png", "--scale: must be from -1000000000 to 1000000000, is 2000"),
        ("newton --offset 0,nan,0 -o a.png", "--offset: must be from -1000000000 to"),
        ("newton --w 2e9 -o a.png", "--w: must be from -1000000000 to 1000000000, is 2000000000"),
        // Before the first frame.
        (
            "newton --frames 2 --w-to 2e9 -o a.png --size 8",
            "--w-to: w: must be from -1000000000 to",
        ),
        ("newton --extent 1e12 -o a.png --size 8", "--extent, --offset, --w, --scale: coordinates"),
        ("newton --size 65536 -o a.png", "--size: must be fewer than 2^31, are 4294967296"),
        (
            "newton --volume --size 1291 -o a.npy",
            "--size: 1291^3 voxels must be fewer than 2^31, are 2151685171",
        ),
        ("newton --w 1e300 -o a.png", "--w: must be from -1000000000 to 1000000000, is 1e300"),
        ("newton --extent 0 -o a.png", "--extent"),
        ("newton --scale 0 -o a.png", "--scale 0: makes one point of all"),
        (
            "newton --volume -o v.png",
            "v.png: voxels are written as .vti, .nrrd, a mesh such as .ply or a table",
        ),
        (
            "newton --volume -o v.vti --heights h.png",
            "h.png: the convergence of voxels is written as .vti, .nrrd or a table",
        ),
        ("newton --volume --size 3x4 -o a.npy", "the same number along each side"),
        ("newton --theta 99 -o a.png", "theta"),
        ("newton -o a.ply", ".png"),
        ("newton none.obj --size 64 -o a.ply", "--size is for a plane, a texture (--uv) and"),
        ("newton -o a.png --picture b.png", "--picture"),
        ("newton -o a.apng", "needs --frames"),
        ("newton --frames 2 --w-to 1 --fps 3 -o a.png", "--fps"),
        ("newton --volume -o a.gif --frames 2 --w-to 1", "only --picture writes animations"),
        ("newton --volume --size 4 --picture a.jpg", "must end in .png"),
        ("newton --volume --size 4 --basins 9 --picture a.png", "the roots are 0 to 8"),
        ("newton --volume --size 4 --basins 1 -o a.npy", "--basins chooses"),
        ("newton --volume --size 4 --opacity slow -o a.ply", "--opacity"),
        ("newton --volume --size 4 --compress -o a.npy", "--compress"),
        ("newton --volume --size 2 --extent 0.01 --offset 9,0,0 --basins 4 -o a.ply", "no voxel"),
    ] {
        let message = folder.fail(command);
        assert!(message.contains(part), "{command}: {message}");
    }
    for (command, part) in [
        ("newton --size 4", "--output"),
        ("newton --basins 0 -o a.png", "--volume"),
        ("newton --volume --basins x -o a.ply", "numbers of roots"),
        ("newton --fps 3 -o a.png", "--frames"),
        ("newton --weld -o a.png", "required arguments were not provided"),
        ("newton --drop-specks 0.3 -o a.png", "required arguments were not provided"),
        ("newton --strict -o a.png", "required arguments were not provided"),
        ("newton --frames 0 --w-to 1 -o a.gif", "from 1 to 100000"),
        ("newton --frames 0 --w-to 1 -o a.png", "from 1 to 100000"),
        ("newton --frames 2 --w-to 1 --fps 99 -o a.gif", "from 0.1 to 50"),
    ] {
        let run = folder.run(command);
        assert_eq!(run.code, Some(2), "{command}");
        assert!(run.stderr.contains(part), "{command}: {}", run.stderr);
    }
    let run = folder.run("newton --frames 2000000000 --w-to 1 -o a.png");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("--frames") && run.stderr.contains("from 1 to 100000"));
    if cfg!(not(feature = "opencl")) {
        assert!(folder.fail("newton --device 0 -o a.png").contains("not in this build"));
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[cfg(feature = "opencl")]
#[test]
fn a_device_draws_what_the_processor_draws() {
    let folder = Folder::new();
    if let Err(e) = catamaran_simulation::opencl::devices() {
        assert!(std::env::var_os("CATAMARAN_REQUIRE_OPENCL").is_none(), "{e}");
        println!("skipped: {e}");
        return;
    }
    assert!(folder.succeed("info").contains("\nopencl        0: "));
    folder.succeed("newton --size 64 -o cpu.png");
    folder.succeed("newton --size 64 -o device.png --device 0");
    let [cpu, device] = ["cpu.png", "device.png"].map(|name| pixels(&folder.path(name)));
    let different = cpu.iter().zip(&device).filter(|(a, b)| a != b).count();
    // Processors round divisions correctly. A GPU may differ at one point of 4,000, and 4,096 are
    // drawn; some more are on the borders of basins.
    let is_cpu = catamaran_simulation::opencl::find("0").unwrap().kind
        == catamaran_simulation::opencl::DeviceKind::Cpu;
    let allowed = if is_cpu { 0 } else { 8 };
    assert!(cpu.len() == 64 * 64 && different <= allowed, "{different} of {} pixels", cpu.len());
}

/// The colours of a picture.
fn pixels(path: &std::path::Path) -> Vec<[u8; 3]> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    bytes[..info.buffer_size()].chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
}

#[test]
fn points_that_reach_no_root_are_counted() {
    let folder = Folder::new();
    let notes = |arguments: &str| {
        let run = folder.run(&format!("newton --size 64 --force -o a.png {arguments}"));
        assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
        run.stderr
    };
    let count = |arguments: &str| -> usize {
        let notes = notes(arguments);
        let note = notes.lines().find(|line| line.contains("reach no root"));
        note.map_or(0, |line| line.split_whitespace().nth(1).unwrap().parse().unwrap())
    };
    // A cycle from 0 to 1 and back attracts an open set of points (Smale 1985).
    let cycle = count("--polynomial z^3-2z+2 --extent 4");
    assert!(cycle > 20 && cycle < 64 * 64, "{cycle}");
    // They are black, which no root is.
    let black = pixels(&folder.path("a.png")).iter().filter(|color| **color == [0; 3]).count();
    assert_eq!(black, cycle);
    assert_eq!(count("--polynomial z^3-2z+2 --extent 4 --threads 1"), cycle);
    // So are vertices.
    folder.write("t.obj", "v 1 0 0\nv 0 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.succeed("newton t.obj --no-fit --power 3 -o t.ply");
    let file = catamaran_geometry::mesh::io::read(&folder.path("t.ply")).unwrap();
    let colors = file.colors.unwrap();
    let black = [0.0, 0.0, 0.0, 1.0];
    assert_eq!([0, 1, 2].map(|v| colors[v] == black), [false, true, false]);
    // Two roots on both sides of a line that no pixel is on: all others converge.
    assert_eq!(count("--power 2"), 0);
    assert_eq!(count("--power 2 --iterations 1"), 64 * 64);
    assert!(count("--power 3 --iterations 4") > count("--power 3 --iterations 8"));
    assert!(notes("--power 2 --iterations 1").contains("--iterations"));
    let said = folder.succeed("--json newton --size 64 --power 2 --iterations 1 -o b.png");
    assert!(said.contains("\"unreached\":4096"), "{said}");
}

#[cfg(unix)]
#[test]
fn more_frames_are_written_than_a_process_may_have_files_open() {
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_catamaran");
    let arguments = "newton --size 4 --frames 60 --w-to 1 -o f.png --heights h.png";
    let limited = || {
        let script = format!("ulimit -n 40; exec '{program}' {arguments}");
        let mut shell = Command::new("sh");
        Run::new(shell.arg("-c").arg(script).current_dir(folder.path("")).output().unwrap())
    };
    // A later frame that exists is an error before the first one is computed.
    folder.write("h-059.png", "mine");
    let run = limited();
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("h-059.png: exists already"), "{}", run.stderr);
    assert_eq!(folder.names(), ["h-059.png"]);
    std::fs::remove_file(folder.path("h-059.png")).unwrap();
    let run = limited();
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let names = folder.names();
    assert_eq!(names.len(), 120, "{names:?}");
    assert!(names.iter().all(|name| name.ends_with(".png")), "{names:?}");
}
