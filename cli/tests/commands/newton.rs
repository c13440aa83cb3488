//! `catamaran newton`, from outside.

use crate::common::Folder;

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
    assert!(folder.fail("newton --polynomial 3+i -o c.png").contains("polynomial: it is constant"));
    for (polynomial, why) in [("z+", "it ends where"), ("z^65", "a power above 64")] {
        let refused = folder.run(&format!("newton --polynomial {polynomial} -o c.png"));
        assert_eq!(refused.code, Some(2));
        assert!(refused.stderr.contains(why), "{}", refused.stderr);
    }
}

#[test]
fn a_mesh_gets_colours_and_a_texture() {
    let folder = Folder::new();
    folder.write(
        "square.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    folder.succeed("newton square.obj --w 0.2 -o colored.ply --heights h.csv --picture view.png");
    let file = catamaran::mesh::io::read(&folder.path("colored.ply")).unwrap();
    assert_eq!(file.colors.unwrap().len(), 4);
    assert_eq!(std::fs::read_to_string(folder.path("h.csv")).unwrap().lines().count(), 4);
    assert!(size_and_bits(&folder, "view.png").0 > 100);
    folder.succeed("newton square.obj --uv --size 32 -o texture.png");
    assert_eq!(size_and_bits(&folder, "texture.png"), (32, 32, 8));
    assert!(folder.fail("newton square.obj --uv -o texture.ply").contains(".png"));
    folder.write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(folder.fail("newton bare.obj --uv -o t.png").contains("no texture coordinates"));
}

#[test]
fn a_mesh_has_the_same_colours_whatever_its_unit_and_place() {
    use catamaran::mesh::{TriMesh, families};
    let folder = Folder::new();
    let sphere = families::icosphere(3).unwrap();
    let colors = |name: &str, size: f64, shift: f64, options: &str| {
        let place = |p: &[f64; 3]| p.map(|x| size * x + shift);
        let vertices = sphere.vertices().iter().map(place).collect();
        let mesh = TriMesh::new(vertices, sphere.faces().to_vec()).unwrap();
        let overwrite = catamaran::io::Overwrite::Replace;
        let output = catamaran::io::Output::create(&folder.path(name), overwrite).unwrap();
        catamaran::mesh::io::write(output, &mesh.into()).unwrap();
        folder.succeed(&format!("newton {name} --power 5 {options} -o colored.ply --force"));
        let file = catamaran::mesh::io::read(&folder.path("colored.ply")).unwrap();
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
    let roots = folder.read_npy::<f32>("v.npy");
    assert_eq!(roots.len(), 9 * 9 * 9);
    assert!(roots.iter().all(|&root| (0.0..4.0).contains(&root) && root.fract() == 0.0));
    assert_eq!(folder.read_npy::<f32>("t.npy").len(), roots.len());
    folder.succeed("newton --size 8 --frames 3 --w 0 --w-to 1 -o f.png");
    let names = folder.names();
    for name in ["f-000.png", "f-001.png", "f-002.png"] {
        assert!(names.iter().any(|n| n == name), "{names:?}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let folder = Folder::new();
    for (command, part) in [
        ("newton --power 1 -o a.png", "1 roots"),
        ("newton --extent 0 -o a.png", "--extent"),
        ("newton --volume --size 3x4 -o a.npy", "as many voxels"),
        ("newton --theta 99 -o a.png", "theta"),
        ("newton -o a.ply", ".png"),
        ("newton -o a.png --picture b.png", "--picture"),
    ] {
        let message = folder.fail(command);
        assert!(message.contains(part), "{command}: {message}");
    }
    let run = folder.run("newton --frames 2000000000 --w-to 1 -o a.png");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("--frames") && run.stderr.contains("at most 100000"));
    if cfg!(not(feature = "opencl")) {
        assert!(folder.fail("newton --device 0 -o a.png").contains("not in this build"));
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[cfg(feature = "opencl")]
#[test]
fn a_device_draws_what_the_processor_draws() {
    let folder = Folder::new();
    if let Err(e) = catamaran::opencl::devices() {
        assert!(std::env::var_os("CATAMARAN_REQUIRE_OPENCL").is_none(), "{e}");
        println!("skipped: {e}");
        return;
    }
    assert!(folder.succeed("info").contains("\nopencl        0: "));
    folder.succeed("newton --size 64 -o cpu.png");
    folder.succeed("newton --size 64 -o device.png --device 0");
    let [cpu, device] = ["cpu.png", "device.png"].map(|name| pixels(&folder.path(name)));
    let different = cpu.iter().zip(&device).filter(|(a, b)| a != b).count();
    // Processors round divisions correctly. A GPU may differ at one point of 4,000, and 4,096 are drawn;
    // some more are on the borders of basins.
    let is_cpu = catamaran::opencl::find("0").unwrap().kind == catamaran::opencl::DeviceKind::Cpu;
    let allowed = if is_cpu { 0 } else { 8 };
    assert!(cpu.len() == 64 * 64 && different <= allowed, "{different} of {} pixels", cpu.len());
}

/// The colors of a picture.
#[cfg(feature = "opencl")]
fn pixels(path: &std::path::Path) -> Vec<[u8; 3]> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    bytes[..info.buffer_size()].chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
}
