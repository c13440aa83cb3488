//! `catamaran slime`, from outside.

use std::fs;

use crate::common::Folder;

/// A square with its own texture coordinates.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
const CONFIG: &str = "agents = 900\nsize = 64\nvision_distance = 3\nmovement_speed = 6\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    folder.write("c.toml", CONFIG);
    folder
}

#[test]
fn every_file_is_there_and_none_is_replaced() {
    let folder = folder();
    let run = "slime square.obj --config c.toml --steps 25 --every 10 -o out --render view.png --coverage c.svg";
    let said = folder.succeed(run);
    assert!(said.contains("900 agents") && said.contains("6 files"), "{said}");
    for name in ["out/frame-0010.png", "out/frame-0020.png", "out/frame-0025.png", "view.png"] {
        assert!(fs::read(folder.path(name)).unwrap().starts_with(b"\x89PNG"), "{name}");
    }
    assert!(fs::read_to_string(folder.path("c.svg")).unwrap().contains("</svg>"));
    let table = fs::read_to_string(folder.path("out/coverage.csv")).unwrap();
    assert!(table.starts_with("seconds,coverage0,presence0\n0,0,0\n"), "{table}");
    assert_eq!(table.lines().count(), 27);
    let mesh = fs::read_to_string(folder.path("out/mesh.obj")).unwrap();
    assert!(mesh.contains("vt "));
    // Other programs show the last picture on the mesh.
    assert!(mesh.starts_with("mtllib mesh.mtl\n") && mesh.contains("\nusemtl slime\nf "), "{mesh}");
    let material = fs::read_to_string(folder.path("out/mesh.mtl")).unwrap();
    assert!(material.starts_with("newmtl slime\n"), "{material}");
    assert!(material.ends_with("\nmap_Kd frame-0025.png\n"), "{material}");
    assert!(folder.fail(run).contains("exists already"));
    // Threads change no byte.
    let before = fs::read(folder.path("out/frame-0025.png")).unwrap();
    folder.succeed(&format!("{run} --force --threads 1"));
    assert_eq!(fs::read(folder.path("out/frame-0025.png")).unwrap(), before);
}

#[test]
fn a_run_goes_on_where_it_ended() {
    let folder = folder();
    let run = |rest: &str| folder.succeed(&format!("slime square.obj --config c.toml {rest}"));
    run("--steps 30 -o whole");
    run("--steps 12 -o first --state some.state");
    run("--steps 30 -o second --resume some.state");
    let of = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_eq!(of("whole/frame-0030.png"), of("second/frame-0030.png"));
    let other = "slime square.obj --config c.toml --seed 5 --steps 30 -o third --resume some.state";
    assert!(folder.fail(other).contains("another seed"));
}

#[test]
fn species_have_channels_and_meshes_without_coordinates_an_atlas() {
    let folder = folder();
    let bare: String =
        SQUARE.lines().filter(|l| l.starts_with("v ")).map(|l| format!("{l}\n")).collect();
    folder.write("bare.obj", format!("{bare}f 1 2 3\nf 1 3 4\n"));
    folder.write("r.ini", "NumAgents=500\nMoveSpeed=0.05\nSensorRadius=1\n");
    let said =
        folder.succeed("slime bare.obj --config r.ini --size 32 --species 3 --steps 3 -o three");
    assert!(said.contains("2 charts") && said.contains("species 2"), "{said}");
    folder.succeed("slime bare.obj --config c.toml --species 4 --steps 2 -o four");
    assert!(folder.path("four/frame-0002-species3.png").exists());
}

#[test]
fn what_is_wrong_is_named() {
    let folder = folder();
    folder.write("bad.toml", "vision_angel = 3\n");
    let said = folder.fail("slime square.obj --config bad.toml -o out");
    assert!(said.contains("bad.toml") && said.contains("vision_angel"), "{said}");
    folder.write("flat.obj", SQUARE.replace("vt 1 1", "vt 0.5 0"));
    let said = folder.fail("slime flat.obj --config c.toml -o out");
    assert!(said.contains("face 0") && said.contains("--atlas"), "{said}");
    folder.write("grey.png", "no picture");
    let said = folder.fail("slime square.obj --config c.toml -o out --mask grey.png");
    assert!(said.contains("grey.png"), "{said}");
    // A header that announces 240 GB of pixels, and none of them.
    let file = fs::File::create(folder.path("large.png")).unwrap();
    let mut encoder = png::Encoder::new(file, 200_000, 200_000);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[]).unwrap();
    let said = folder.fail("slime square.obj --config c.toml -o out --mask large.png");
    assert!(said.contains("large.png: 200000 x 200000 pixels"), "{said}");
    assert!(!folder.path("out/frame-0900.png").exists());
}
