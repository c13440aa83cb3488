//! `catamaran slime`, from outside.

use std::fs;
use std::io::Cursor;

use crate::common::{Folder, calls};

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
    run("--steps 12 --every 5 -o first --state some.state");
    let of = |name: &str| fs::read(folder.path(name)).unwrap();
    let after_12 = of("some.state");
    let said = run("--steps 30 -o second --state some.state --resume");
    assert!(said.contains("resumed     some.state: step 12 of 30"), "{said}");
    assert!(said.contains("state       some.state: after 30 steps"), "{said}");
    for name in ["frame-0030.png", "coverage.csv", "mesh.obj", "mesh.mtl"] {
        assert!(of(&format!("whole/{name}")) == of(&format!("second/{name}")), "{name}");
    }
    folder.write("some.state", &after_12);
    run("--steps 12 -o third --state some.state --resume");
    assert_eq!(of("first/frame-0012.png"), of("third/frame-0012.png"));
    assert_eq!(of("first/coverage.csv"), of("third/coverage.csv"));
    assert_eq!(of("some.state"), after_12);

    // What an interrupted run leaves: its frames. They are neither written again nor counted.
    for name in ["mesh.obj", "mesh.mtl", "coverage.csv"] {
        fs::remove_file(folder.path("first").join(name)).unwrap();
    }
    let early = of("first/frame-0010.png");
    let said = run("--steps 30 --every 5 -o first --state some.state --resume");
    assert!(said.contains("first: 7 files"), "{said}");
    assert_eq!(of("whole/frame-0030.png"), of("first/frame-0030.png"));
    assert_eq!(of("whole/coverage.csv"), of("first/coverage.csv"));
    assert_eq!(of("first/frame-0010.png"), early);
    let slime = "slime square.obj --config c.toml";
    let resumed = "--steps 30 -o fourth --state some.state --resume";
    let refused = folder.fail(&format!("{slime} --seed 5 {resumed}"));
    assert!(refused.contains("some.state: was saved with seed = 0, not 5"), "{refused}");
    folder.write("other.toml", CONFIG.replace("speed = 6", "speed = 1.25"));
    let refused = folder.fail(&format!("slime square.obj --config other.toml {resumed}"));
    assert!(refused.contains("was saved with movement_speed = 6, not 1.25"), "{refused}");
    let fewer = folder.fail(&format!("{slime} --steps 9 -o fourth --state some.state --resume"));
    assert!(fewer.contains("--steps 9: some.state is after 30 steps already"), "{fewer}");
    folder.write("some.state", &after_12[..after_12.len() - 1]);
    let short = folder.fail(&format!("{slime} --steps 30 -o fourth --state some.state --resume"));
    let says = "some.state: is not a state file of slime moulds, or ends early";
    assert!(short.contains(says), "{short}");
    let mut damaged = after_12.clone();
    // The last bit of a number, as a run could have written it.
    damaged[after_12.len() / 2] ^= 1;
    folder.write("some.state", &damaged);
    let said = folder.fail(&format!("{slime} --steps 30 -o fourth --state some.state --resume"));
    assert!(said.contains("some.state: is damaged: its checksum differs"), "{said}");
}

#[test]
fn a_state_is_resumed_if_it_is_there_and_not_replaced_by_accident() {
    let folder = folder();
    let slime = "slime square.obj --config c.toml --steps 6";
    let said = folder.succeed(&format!("{slime} -o first --state some.state --resume"));
    assert!(said.contains("resumed     no some.state: the run starts from the first"), "{said}");
    let refused = folder.fail(&format!("{slime} -o second --state some.state"));
    let says = "some.state: exists already (--force replaces it, --resume continues from it)";
    assert!(refused.contains(says), "{refused}");
    // Without a state to go on from, the files of another run are not those of an interrupted one.
    let refused = folder.fail(&format!("{slime} -o first --state none.state --resume"));
    assert!(refused.contains("first/frame-0006.png: exists already"), "{refused}");
    let run = folder.run(&format!("{slime} -o second --resume"));
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(run.stderr.contains("--state <FILE>"), "{}", run.stderr);
}

#[test]
fn frames_of_an_earlier_run_stay_and_are_noted() {
    let folder = folder();
    let run = |rest: &str| {
        let run = folder.run(&format!("slime square.obj --config c.toml {rest}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    let note = "note: out: frames that this run does not write stay: ";
    assert_eq!(run("--steps 25 --every 10 -o out --state some.state"), "");
    let said = run("--steps 15 --every 10 -o out --force");
    assert_eq!(said, format!("{note}2, frame-0020.png to frame-0025.png\n"));
    assert!(folder.path("out/frame-0025.png").exists());
    let said = run("--steps 10 --every 10 --species 4 -o out --force");
    assert_eq!(said, format!("{note}4, frame-0010.png to frame-0025.png\n"));
    // The frames of the run that is resumed belong to this one, except that of its last step.
    assert_eq!(run("--steps 25 --every 10 -o other"), "");
    let said = run("--steps 40 --every 10 -o other --state some.state --resume --force");
    assert_eq!(said, format!("{}1, frame-0025.png\n", note.replace("out", "other")));
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
    let said = folder.succeed("slime bare.obj --config c.toml --species 4 --steps 20 -o four");
    assert!(folder.path("four/frame-0020-species3.png").exists() && said.contains("8 files"));
    // The material of the mesh shows all of them, each in its colour.
    let material = fs::read_to_string(folder.path("four/mesh.mtl")).unwrap();
    assert!(material.ends_with("\nmap_Kd mesh.png\n"), "{material}");
    let (size, bytes, picture) = pixels(&folder, "four/mesh.png");
    assert_eq!((size, bytes), (64, 3));
    for s in 0..4 {
        let own = pixels(&folder, &format!("four/frame-0020-species{s}.png")).2;
        let most = (0..own.len()).max_by_key(|&t| own[t]).unwrap();
        assert!(picture[3 * most..3 * most + 3] != [40, 44, 52], "species {s}");
    }
    assert!(
        folder
            .fail("slime bare.obj --config c.toml --species 4 --steps 9 -o four")
            .contains("exists already")
    );
    folder.succeed("slime bare.obj --config c.toml --species 4 --steps 2 -o rich --material");
    assert!(!folder.path("rich/mesh.png").exists());
}

#[test]
fn species_without_agents_are_noted() {
    let folder = folder();
    for (options, says) in [
        ("--agents 0", "note: 1 of 1 species have no agents (--agents 0)"),
        ("--agents 2 --species 3", "note: 1 of 3 species have no agents (--agents 2)"),
        ("--agents 3 --species 3", ""),
    ] {
        let run = "slime square.obj --config c.toml --steps 1 --force -o out";
        let run = folder.run(&format!("{run} {options}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stderr.contains(says), "{options}: {}", run.stderr);
        assert!(!says.is_empty() || !run.stderr.contains("no agents"), "{}", run.stderr);
    }
}

#[test]
fn what_is_wrong_is_named() {
    let folder = folder();
    folder.write("bad.toml", "vision_angel = 3\n");
    let said = folder.fail("slime square.obj --config bad.toml -o out");
    assert!(said.contains("bad.toml") && said.contains("vision_angel"), "{said}");
    folder.write("far.toml", "movement_speed = 1e7\n");
    folder.write("far.ini", "NumAgents=5\nMoveSpeed=-1\n");
    for (arguments, why) in [
        ("--config far.toml", "far.toml: movement_speed: must be from 0 to 1000000, is 10000000"),
        (
            "--config far.ini",
            "far.ini: line 2: MoveSpeed=-1: movement_speed: must be from 0 to 1000000, is -100",
        ),
        ("--config none.toml", "none.toml: no such file"),
        ("--config c.toml --mask none.png", "none.png: no such file"),
        ("--species 16", "--species: must be from 1 to 15, is 16"),
        ("--size 20000", "--size: must be a multiple of 32 from 32 to 16384, is 20000"),
        ("--agents 5000000000", "--agents: must be from 0 to 2^32 - 1, is 5000000000"),
    ] {
        let said = folder.fail(&format!("slime square.obj {arguments} -o out"));
        assert!(said.contains(why), "{said}");
    }
    // Before the steps.
    for (option, name) in [
        ("--render out/frame-0002.png", "out/frame-0002.png: two results have this name"),
        ("--coverage out/./frame-0003.png", "out/./frame-0003.png: two results have this name"),
        ("--state out/frame-0002.png", "out/frame-0002.png: two results have this name"),
        ("--material --state out/normal.png", "out/normal.png: two results have this name"),
    ] {
        let run = "slime square.obj --config c.toml --size 32 --steps 3 --every 2 -o out";
        let said = folder.fail(&format!("{run} {option}"));
        assert!(said.contains(&name.replace("/./", "/")), "{said}");
        assert!(!folder.path("out").exists());
    }
    folder.write("flat.obj", SQUARE.replace("vt 1 1", "vt 0.5 0"));
    let said = folder.fail("slime flat.obj --config c.toml -o out");
    assert!(said.contains("face 0") && said.contains("--atlas"), "{said}");
    folder.write("grey.png", "no picture");
    let said = folder.fail("slime square.obj --config c.toml -o out --mask grey.png");
    assert!(said.contains("grey.png"), "{said}");
    // A mask of obstacles alone.
    let file = fs::File::create(folder.path("walls.png")).unwrap();
    let mut encoder = png::Encoder::new(file, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[0, 255, 0]).unwrap();
    let said = folder.fail("slime square.obj --config c.toml -o out --mask walls.png");
    assert!(said.contains("--mask walls.png: has no texel on the surface where"), "{said}");
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

/// The pixels of a picture, rows from the top, and the bytes of one.
fn pixels(folder: &Folder, name: &str) -> (usize, usize, Vec<u8>) {
    let bytes = fs::read(folder.path(name)).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width as usize, info.line_size / info.width as usize, pixels)
}

/// Returns the texels that are black in the frame, and those that are almost white.
fn marked(folder: &Folder, frame: &str) -> [Vec<usize>; 2] {
    let (_, _, frame) = pixels(folder, frame);
    let of = |low: u8, high: u8| {
        (0..frame.len()).filter(|&t| (low..=high).contains(&frame[t])).collect::<Vec<_>>()
    };
    [of(0, 0), of(240, 255)]
}

#[test]
fn a_material_is_written_as_its_look_says() {
    let folder = folder();
    folder.write(
        "m.toml",
        format!(
            "{CONFIG}[material]\nlook = \"gold\"\nsmoothing = 0\nbare = {{ color = \"#102030\" }}\n\
             species = [{{ color = \"#f0c060\", roughness = 0.2, height = 1.0 }}]\n"
        ),
    );
    let run = "slime square.obj --config m.toml --steps 20 -o out --material";
    let said = folder.succeed(run);
    assert!(said.contains("10 files"), "{said}");
    let [bare, covered] = marked(&folder, "out/frame-0020.png");
    assert!(bare.len() > 100 && covered.len() > 100, "{} {}", bare.len(), covered.len());
    let (size, _, albedo) = pixels(&folder, "out/albedo.png");
    let of = |t: usize| &albedo[3 * t..3 * t + 3];
    assert!(size == 64 && bare.iter().all(|&t| of(t) == [0x10, 0x20, 0x30]));
    assert!(covered.iter().all(|&t| of(t) == [0xf0, 0xc0, 0x60]));
    for (name, none, most) in [("roughness", 20, 51), ("metalness", 0, 255)] {
        let (_, bytes, values) = pixels(&folder, &format!("out/{name}.png"));
        assert_eq!(bytes, 1);
        assert!(bare.iter().all(|&t| values[t] == none), "{name}");
        assert!(covered.iter().all(|&t| values[t] == most), "{name}");
    }
    let (_, bytes, heights) = pixels(&folder, "out/height.png");
    assert_eq!(bytes, 2);
    assert!(covered.iter().all(|&t| heights[2 * t..2 * t + 2] == [255, 255]));
    // Normals lean away from what is high.
    let (_, _, normals) = pixels(&folder, "out/normal.png");
    let height = |t: usize| f64::from(heights[2 * t]) * 256.0 + f64::from(heights[2 * t + 1]);
    let (mut along, mut against) = (0, 0);
    for (row, column) in (1..63).flat_map(|row| (1..63).map(move |column| (row, column))) {
        let t = 64 * row + column;
        // Right, and up in the picture.
        for (slope, lean) in [
            (height(t + 1) - height(t - 1), i32::from(normals[3 * t]) - 128),
            (height(t - 64) - height(t + 64), i32::from(normals[3 * t + 1]) - 128),
        ] {
            if slope.abs() > 3000.0 {
                *(if slope * f64::from(lean) < 0.0 { &mut along } else { &mut against }) += 1;
            }
        }
    }
    assert!(along > 500 && against == 0, "{along} {against}");
    let model = fs::read(folder.path("out/material.glb")).unwrap();
    let found = gltf::Gltf::from_slice(&model).unwrap();
    let material = found.materials().next().unwrap();
    assert!(material.normal_texture().is_some() && material.emissive_texture().is_none());
    assert_eq!((found.images().len(), material.name()), (4, Some("slime")));
    // The colours in it are those beside it.
    let image = material.pbr_metallic_roughness().base_color_texture().unwrap().texture();
    let gltf::image::Source::View { view, .. } = image.source().source() else { panic!() };
    let own = &found.blob.as_ref().unwrap()[view.offset()..view.offset() + view.length()];
    assert_eq!(own, fs::read(folder.path("out/albedo.png")).unwrap());
    let material = fs::read_to_string(folder.path("out/mesh.mtl")).unwrap();
    assert!(material.contains("\nmap_Kd albedo.png\n") && material.contains("norm normal.png"));
    assert!(folder.fail(run).contains("exists already"));
    let again = folder.run(&format!("{run} --force --threads 1"));
    // Nothing is left out of either mesh.
    assert!(again.code == Some(0) && !again.stderr.contains("note:"), "{}", again.stderr);
    assert_eq!(fs::read(folder.path("out/material.glb")).unwrap(), model);
    // A name on the command line precedes that of the file; without the option nothing is
    // written.
    let said = folder.succeed("slime square.obj --config m.toml --steps 3 -o lava --material=lava");
    assert!(said.contains("11 files") && folder.path("lava/glow.png").exists(), "{said}");
    folder.succeed("slime square.obj --config m.toml --steps 3 -o none");
    assert!(!folder.path("none/albedo.png").exists());
}

#[test]
fn a_picture_shows_the_relief_of_a_material() {
    let folder = folder();
    let flat = "[material]\ndepth = 0\n";
    folder.write("flat.toml", format!("{CONFIG}{flat}"));
    folder.write("deep.toml", format!("{CONFIG}{}", flat.replace('0', "4")));
    let run = |name: &str| {
        let options =
            format!("--config {name}.toml --steps 20 -o {name} --material --render {name}.png");
        folder.succeed(&format!("slime square.obj {options} --view 0,0,flat"));
        pixels(&folder, &format!("{name}.png")).2
    };
    let (flat, deep) = (run("flat"), run("deep"));
    let differ = flat.iter().zip(&deep).filter(|(a, b)| a.abs_diff(**b) > 20).count();
    assert!(differ > flat.len() / 20, "{differ} of {}", flat.len());
}

#[test]
fn a_tile_repeats_without_a_seam() {
    let folder = folder();
    folder.write("t.toml", "agents = 3000\nsize = 128\nvision_distance = 3\nmovement_speed = 4\n");
    let said = folder
        .succeed("slime --tile --config t.toml --steps 120 -o out --material --render view.png");
    assert!(said.contains("1 charts"), "{said}");
    for name in ["frame-0120", "albedo", "roughness", "height", "normal"] {
        let (size, bytes, values) = pixels(&folder, &format!("out/{name}.png"));
        // Of 16 bits, the larger byte is first.
        let step = if name == "height" { 2 } else { 1 };
        let row = size * bytes;
        // The mean difference between the columns (rows) i - 1 and i.
        let difference = |i: usize, rows: bool| {
            let before = (i + size - 1) % size;
            let at = |i: usize, j: usize, b: usize| {
                let t = if rows { i * row + j * bytes } else { j * row + i * bytes };
                f64::from(values[t + b])
            };
            let all = (0..size).flat_map(|j| (0..bytes).step_by(step).map(move |b| (j, b)));
            all.map(|(j, b)| (at(i, j, b) - at(before, j, b)).abs()).sum::<f64>()
        };
        for rows in [false, true] {
            let most = (1..size).map(|i| difference(i, rows)).fold(0.0, f64::max);
            assert!(difference(0, rows) <= most, "{name}, {rows}");
        }
    }
    // The picture shows four tiles: its left half is its right half. The square is 792 pixels wide
    // in a picture of 900.
    let (size, bytes, picture) = pixels(&folder, "view.png");
    assert!(size == 900 && bytes == 3);
    let at = |x: usize, y: usize| i32::from(picture[3 * (900 * y + x)]);
    let [mut same, mut other] = [0, 0];
    for (x, y) in (60..440).flat_map(|x| (60..840).map(move |y| (x, y))) {
        same += (at(x, y) - at(x + 396, y)).abs();
        other += (at(x, y) - at(x + 380, y)).abs();
    }
    assert!(same * 4 < other, "{same} {other}");
    let refused = |arguments: &str| {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        run.stderr
    };
    assert!(refused("slime square.obj --tile -o other").contains("--tile"));
    for option in ["--atlas", "--weld", "--drop-specks=0.3", "--strict"] {
        let said = refused(&format!("slime --tile {option} -o other"));
        assert!(said.contains("cannot be used with"), "{option}: {said}");
    }
    assert!(refused("slime -o other").contains("<MESH>"));
    folder.write("p.toml", "size = 64\ntangent_step = \"project\"\n");
    assert!(folder.fail("slime --tile --config p.toml -o other").contains("tangent_step"));
}

#[test]
fn looks_that_are_wrong_are_named() {
    let folder = folder();
    let run = folder.run("slime square.obj --config c.toml -o out --material=silver");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("silver") && run.stderr.contains("marble"), "{}", run.stderr);
    folder.write("bad.toml", "[material]\nspecies = [{ color = \"gold\" }]\n");
    let said = folder.fail("slime square.obj --config bad.toml -o out --material");
    assert!(said.contains("bad.toml") && said.contains("\"gold\""), "{said}");
    folder.write("c2.toml", format!("{CONFIG}[material]\ndepth = 1\n"));
    let run = folder.run("slime square.obj --config c2.toml --steps 1 -o out");
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains("[material] needs --material"), "{}", run.stderr);
}

#[test]
fn commands_of_the_guide_run() {
    let folder = folder();
    folder.write("torus.obj", SQUARE);
    let guide = include_str!("../../../docs/guide/slime.md");
    for line in calls(guide) {
        // As they are, they take seconds each.
        let small = line.replace("60000", "600").replace(" 512", " 64");
        folder.succeed(&small.replace(" 300", " 30").replace(" 100", " 10"));
    }
    // The tables of settings and of looks are configurations.
    let blocks: Vec<&str> = guide.split("```").filter_map(|b| b.strip_prefix("toml\n")).collect();
    assert_eq!(blocks.len(), 2);
    let settings = blocks[0].replace("60000", "600").replace("512", "64");
    folder.write("g.toml", format!("{settings}{}", blocks[1]));
    folder.succeed("slime torus.obj --config g.toml --steps 2 -o guided --material");
}

/// A cube whose six sides have the texture coordinates `side(0)` to `side(5)`, each a rectangle
/// from one corner to another.
fn cube(side: impl Fn(usize) -> [[f64; 2]; 2]) -> String {
    let points = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2));
    let mut text: String = points.collect();
    for s in 0..6 {
        let [[a, b], [c, d]] = side(s);
        text += &format!("vt {a} {b}\nvt {c} {b}\nvt {c} {d}\nvt {a} {d}\n");
    }
    let sides =
        [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
    for (s, side) in sides.iter().enumerate() {
        let corners = side.iter().zip(4 * s + 1..).map(|(v, vt)| format!(" {v}/{vt}"));
        text += &format!("f{}\n", corners.collect::<String>());
    }
    text
}

#[test]
fn faces_that_share_texture_are_said_with_their_number() {
    let folder = Folder::new();
    folder.write("all.obj", cube(|_| [[0.0, 0.0], [1.0, 1.0]]));
    // The first two sides overlap in a quarter of each.
    folder.write(
        "two.obj",
        cube(|s| match s {
            0 => [[0.0, 0.0], [0.4, 0.4]],
            1 => [[0.2, 0.2], [0.6, 0.6]],
            s => [[0.25 * (s - 2) as f64, 0.7], [0.25 * (s - 1) as f64, 1.0]],
        }),
    );
    // Neighbours in the texture share edges, and nothing else.
    let third = |s: usize| (s % 3) as f64 / 3.0;
    let row = |s: usize| (s / 3) as f64 / 2.0;
    folder.write("none.obj", cube(|s| [[third(s), row(s)], [third(s) + 1.0 / 3.0, row(s) + 0.5]]));
    let small = "--steps 1 --agents 10 --size 64 -o";
    for (name, count) in [("all", 12), ("two", 4), ("none", 0)] {
        let run = folder.run(&format!("slime {name}.obj {small} {name}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let said = format!("faces share texture: {count} of 12 triangles");
        assert_eq!(run.stderr.contains(&said), count > 0, "{name}: {}", run.stderr);
        assert_eq!(run.stderr.contains("--atlas"), count > 0, "{name}: {}", run.stderr);
        let atlas = folder.run(&format!("slime {name}.obj --atlas {small} {name}-atlas"));
        assert!(!atlas.stderr.contains("share"), "{}", atlas.stderr);
        // A fractal on the texture of the mesh likewise.
        let run = folder.run(&format!("newton {name}.obj --uv --size 64 -o {name}.png"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert_eq!(run.stderr.contains("faces overlap in the texture"), count > 0, "{name}");
    }
}
