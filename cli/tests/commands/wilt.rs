//! `catamaran wilt`, from outside.

use crate::common::{Folder, calls};

fn table(folder: &Folder, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(folder.path(name)).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap().split(',').map(String::from).collect();
    let row = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect();
    (head, lines.map(row).collect())
}

#[test]
fn a_plant_dries_and_every_file_is_there() {
    let folder = Folder::new();
    let said =
        folder.succeed("wilt --grow 120 --hours 24 --frames 4 -o out --mesh obj --threads 2");
    assert!(said.contains("120 nodes") && said.contains("9 files"), "{said}");
    let (head, water) = table(&folder, "out/water.csv");
    assert_eq!(
        (head.len(), &head[..3]),
        (122, &["time_h", "total_kg", "node_0"].map(String::from)[..])
    );
    assert_eq!(water.iter().map(|row| row[0]).collect::<Vec<_>>(), [0.0, 6.0, 12.0, 18.0, 24.0]);
    for (row, next) in water.iter().zip(&water[1..]) {
        assert!(next[1] < row[1]);
        assert!((row[2..].iter().sum::<f64>() - row[1]).abs() < 1e-12);
    }
    let (head, stiffness) = table(&folder, "out/stiffness.csv");
    assert_eq!(head[1], "mean_pa");
    assert!(stiffness[0][2..].iter().all(|e| (e - 5e7).abs() < 1.0) && stiffness[4][1] < 5e7);
    for i in 0..5 {
        let text = std::fs::read_to_string(folder.path(&format!("out/plant-00{i}.obj"))).unwrap();
        assert_eq!(text.lines().filter(|line| line.starts_with("v ")).count(), 120 * 12);
    }
    assert!(std::fs::read(folder.path("out/wilting.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(std::fs::read_to_string(folder.path("out/water.svg")).unwrap().contains("</svg>"));
    // Nothing is replaced unless asked for, and threads change no byte.
    let before = std::fs::read(folder.path("out/water.csv")).unwrap();
    let again = "wilt --grow 120 --hours 24 --frames 4 -o out --mesh obj --threads 1";
    assert!(folder.fail(again).contains("exists already"));
    folder.succeed(&format!("{again} --force"));
    assert_eq!(std::fs::read(folder.path("out/water.csv")).unwrap(), before);
}

/// A stem of two segments that bears two leaves.
const LITTLE: &str = "verts 4\n0,0,0,.1,.002,0\n1,0,0,.2,.002,0\n2,.05,0,.3,.001,1\n\
                      3,-.05,0,.3,.001,1\nedges 3\n0,1\n1,2\n1,3\n";

#[test]
fn damage_and_nights_show() {
    let folder = Folder::new();
    folder.write("plant.txt", LITTLE);
    let run = |options: &str, out: &str| {
        folder.succeed(&format!("wilt plant.txt --frames 6 --mesh none -o {out} {options}"));
        table(&folder, &format!("{out}/water.csv")).1
    };
    let whole = run("", "a");
    assert!((whole[6][4] - whole[6][5]).abs() < 1e-12);
    let blocked = run("--block-flow 2", "b");
    assert!(blocked[6][4] < 0.9 * blocked[6][5]);
    let weak = run("--weaken 2,0.01", "c");
    assert!(blocked[6][4] < weak[6][4] && weak[6][4] < whole[6][4]);
    let nights = run("--day-night", "d");
    assert!(nights[6][1] > whole[6][1]);
    run(
        "--hold 1 --kappa 12 --steepest-at 0.5 --elasticity 1e8,1e5 --conductance 1e-8 --delta 20",
        "e",
    );
}

/// A stem of nodes 1 cm apart, of which the last five are on leaves, in the format of the thesis.
fn stem(nodes: usize, radius: f64) -> String {
    let leaf = |i: usize| usize::from(i + 5 >= nodes);
    let node = |i: usize| format!("{i},0,0,{},{radius},{}\n", 0.01 * (i + 1) as f64, leaf(i));
    let vertices: String = (0..nodes).map(node).collect();
    let edges: String = (1..nodes).map(|i| format!("{},{i}\n", i - 1)).collect();
    format!("verts {nodes}\n{vertices}edges {}\n{edges}", nodes - 1)
}

#[test]
fn an_upright_stem_buckles_as_it_dries() {
    let folder = Folder::new();
    folder.write("upright.txt", stem(20, 1e-3));
    let dry = "wilt upright.txt --delta 5000 --hours 200 --frames 4";
    let highest = |name: &str| {
        let tubes = ring_centres(&obj_vertices(&folder, name));
        tubes.iter().map(|p| p[2]).fold(f64::MIN, f64::max)
    };
    folder.succeed(&format!("{dry} --mesh obj -o rest"));
    assert!((highest("rest/plant-000.obj") - 0.2).abs() < 1e-6);
    assert!(highest("rest/plant-004.obj") < 0.05, "{}", highest("rest/plant-004.obj"));
    folder.succeed(&format!("{dry} --motion 8 --mesh obj -o film"));
    assert!(highest("film/plant-004.obj") < 0.15, "{}", highest("film/plant-004.obj"));
}

#[test]
fn moments_of_a_thick_plant_are_drawn_beside_each_other() {
    let folder = Folder::new();
    folder.write("thick.txt", stem(15, 0.3));
    folder.succeed("wilt thick.txt --frames 6 --delta 200 --mesh none -o out");
    let file = std::fs::File::open(folder.path("out/wilting.png")).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let (width, samples) = (info.width as usize, info.color_type.samples());
    let is_blank = |x: usize| {
        let rows = bytes[..info.buffer_size()].chunks(info.line_size);
        rows.map(|row| &row[samples * x..samples * x + 3]).all(|p| p.iter().all(|&c| c > 245))
    };
    // Left of the scale of the colours.
    let columns: Vec<bool> = (0..width - 130).map(is_blank).collect();
    let starts = columns.windows(2).filter(|pair| pair[0] && !pair[1]).count();
    assert_eq!(starts, 7);
}

#[test]
fn results_of_an_earlier_run_stay_and_are_noted() {
    let folder = Folder::new();
    let run = |rest: &str| {
        let run =
            folder.run(&format!("wilt --grow 9 --hours 2 --frames 2 --mesh none -o out {rest}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    assert_eq!(run("--animation --stomata 0.8,25"), "");
    let note = "note: out: files that this run does not write stay: ";
    assert_eq!(run("--force"), format!("{note}wilting.glb, balance.csv\n"));
    assert_eq!(run("--force --animation"), format!("{note}balance.csv\n"));
    assert!(folder.path("out/balance.csv").exists());
    assert_eq!(run("--force --animation --soil 1"), "");
}

#[test]
fn plants_in_wrong_units_are_noted_and_little_water_has_digits() {
    let folder = Folder::new();
    folder.write("stem.txt", stem(13, 1e-3));
    let run = |options: &str| {
        let run = folder.run(&format!(
            "wilt stem.txt --hours 1 --frames 1 --mesh none --force -o out {options}"
        ));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        (run.stdout, run.stderr)
    };
    assert_eq!(run("").1, "");
    let thick = run("--unit 1,1000").1;
    assert!(thick.contains("has a radius of 1.000 metres, but the plant spans 0.130"), "{thick}");
    let (said, small) = run("--unit 0.001");
    assert!(small.contains("stem.txt: the plant spans 1.30e-4 metres"), "{small}");
    assert!(said.contains("e-10 g at first") && !said.contains("0.0000 g at"), "{said}");
    folder.write("line.obj", "v 0 0 0\nv 0 0 0.1\nv 0 0 0.2\nl -3 -2 -1\n");
    let noted = folder.run("wilt line.obj --hours 1 --frames 1 --mesh none -o line").stderr;
    let says = "note: line.obj: no segment leads to the root, node 0: one of 0.100 m is added";
    assert!(noted.contains(says), "{noted}");
}

#[test]
fn refusals_say_what_is_wrong_and_write_nothing() {
    let folder = Folder::new();
    folder.write("plant.txt", "verts 2\n0,0,0,.1,.002,0\n1,0,0,.2,-1,1\nedges 1\n0,1\n");
    assert!(
        folder
            .fail("wilt plant.txt -o out")
            .contains("plant.txt: node 1: radius must be positive and finite, is -1")
    );
    assert!(folder.fail("wilt none.swc -o out").contains("none.swc"));
    folder.write("little.txt", LITTLE);
    for (arguments, why) in [
        ("--hold 9", "--hold 9: little.txt has 4 nodes, numbered from 0"),
        ("--block-flow 9", "--block-flow 9: little.txt has 4 nodes, numbered from 0"),
        ("--block-flow 0", "--block-flow 0: the root of little.txt has no parent"),
        ("--weaken 4,0.1", "--weaken 4: little.txt has 4 nodes, numbered from 0"),
        ("--weaken 0,0.1", "--weaken 0: the root of little.txt has no parent"),
        ("--elasticity 1,2", "--elasticity 1,2: DRY must be above 0, and FULL above DRY"),
        ("--elasticity=-1,2 --literal --kappa 1", "--elasticity -1,2: FULL must be above 0"),
        (
            "--kappa 1e9 --steepest-at 2",
            "--kappa, --steepest-at: elasticity: steepness 1000000000 and shift 2",
        ),
        (
            "--delta 1e300",
            "little.txt: --hours 48, --delta 1e300, --conductance 1e-9: seconds must be at most",
        ),
    ] {
        let refused = folder.fail(&format!("wilt little.txt -o out {arguments}"));
        assert!(refused.contains(why), "{refused}");
    }
    // Nodes so thin that they hold no water.
    folder.write("thin.swc", "1 1 0 0 0 1e-200 -1\n2 3 0 1 0 1e-200 1\n");
    assert!(folder.fail("wilt thin.swc -o out").contains("thin.swc: node 0: water (0 kg)"));
    let message = folder.fail("wilt --grow 50000000 -o out --input-limit 1");
    assert!(message.contains("a plant of 50000000 nodes would take at least"), "{message}");
    let run = folder.run("wilt --grow 5 -o out --frames 4000000000");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("--frames") && run.stderr.contains("from 1 to 100000"));
}

#[test]
fn the_units_of_a_file_are_given_and_what_it_lacks_is_noted() {
    let folder = Folder::new();
    let rows = "/E1\t15\t4\n^<L2\t5\n";
    folder.write("plant.mtg", format!("MTG:\nENTITY-CODE\tLength\tTopDia\n{rows}"));
    folder.write("same.swc", "1 1 0 0 .15 .002 -1\n2 7 0 0 .2 .002 1\n");
    let line = |plant: &str| format!("wilt {plant} --hours 4 --frames 1 --mesh none");
    let run = folder.run(&format!("{} --unit 0.01,0.001 -o out", line("plant.mtg")));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("plant.mtg: 1 of 2 segments have no diameter"), "{}", run.stderr);
    // The root of the SWC is as long as its child, a third of that of the MTG.
    folder.succeed(&format!("{} -o same", line("same.swc")));
    let last = |name: &str| table(&folder, name).1.last().unwrap().clone();
    let (mtg, swc) = (last("out/water.csv"), last("same/water.csv"));
    assert!(mtg[2] > 2.0 * swc[2] && mtg[2] < 4.0 * swc[2], "{mtg:?} {swc:?}");
    let rows = "/P1\n^/E1\t15\n/P2\n^/E1\t15\n^<L2\t5\n";
    folder.write("plants.mtg", format!("MTG:\nENTITY-CODE\tLength\n{rows}"));
    assert!(folder.fail(&format!("{} -o none", line("plants.mtg"))).contains("plants (P1, P2)"));
    folder.succeed(&format!("{} --individual P2 --unit 0.01 -o second", line("plants.mtg")));
    folder.write("large.mtg", "MTG:\nENTITY-CODE\tLength\n/E1\t900\n^<L2\t300\n");
    let spans = |unit: &str| {
        let run = folder.run(&format!("{} {unit}", line("large.mtg")));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr.contains("spans 1200 metres")
    };
    assert!(spans("-o large") && !spans("--unit 0.001 -o small"));
    let refused = folder.run("wilt --grow 5 --unit 0.01 -o none");
    assert!(refused.stderr.contains("--unit"), "{}", refused.stderr);
}

#[test]
fn a_plant_without_leaves_loses_no_water_and_says_so() {
    let folder = Folder::new();
    let stem: String = (1..20).map(|v| format!("{v} 3 0 0 {v}e-2 .002 {}\n", v - 1)).collect();
    folder.write("stem.swc", stem.replacen(" 0\n", " -1\n", 1));
    let run = folder.run("wilt stem.swc --hours 48 --frames 2 --mesh none -o out");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("stem.swc: no leaves"), "{}", run.stderr);
    let all = run.stdout + &run.stderr;
    assert!(all.contains("lost 0.0000 g") && !all.contains("-0.0000"), "{all}");
    let run = folder.run("wilt --grow 20 --hours 1 --frames 1 --mesh none -o leafy");
    assert!(!run.stderr.contains("no leaves"), "{}", run.stderr);
}

/// Values are refused before any work, by the name of the option and in its unit.
#[test]
fn values_out_of_range_are_named_as_they_were_given() {
    let folder = Folder::new();
    let above_zero = "expected a finite number above 0";
    let from_zero = "expected a finite number of at least 0";
    for (option, value, why) in [
        ("--grow <NODES>", "0", "expected a whole number of at least 1"),
        ("--unit <METRES[,METRES]>", "0.01,0", above_zero),
        ("--hours <HOURS>", "-1", above_zero),
        ("--delta <LOSS>", "-1", from_zero),
        ("--delta <LOSS>", "nan", from_zero),
        ("--kappa <K|PART=K,...>", "leaf=0", "with a steepness K above 0"),
        ("--kappa <K|PART=K,...>", "leaf=1,leaf=2", "leaf is there twice"),
        ("--kappa-by-radius <MM=K,...>", "2=3,1=4", "with radii MM that ascend"),
        ("--steepest-at <W>", "nan", "expected a finite number"),
        ("--elasticity <FULL,DRY>", "inf,1", "expected 2 finite numbers"),
        ("--conductance <CHI>", "0", above_zero),
        ("--stomata <W,STEEPNESS[,CUTICULAR]>", "0.5,-1", "a steepness of at least 0"),
        ("--soil <GRAMS[,AT_FIRST]>", "1,2", "AT_FIRST from 0 to GRAMS"),
        ("--soil <GRAMS[,AT_FIRST]>", "-1", "GRAMS above 0"),
        ("--rewater <HOURS[:GRAMS]>", "-3", "both at least 0"),
        ("--rewater <HOURS[:GRAMS]>", "3:-1", "both at least 0"),
        ("--weaken <NODE,FACTOR>", "1.5,0.1", "expected a node and a factor of at least 0"),
        ("--weaken <NODE,FACTOR>", "1,-0.1", "expected a node and a factor of at least 0"),
        ("--motion <SECONDS>", "0", above_zero),
        ("--steps-per-second <NUMBER>", "0", above_zero),
        ("--damping <RATE>", "-1", from_zero),
        ("--wind <X,Y,Z>", "nan,0,0", "expected 3 finite numbers"),
        ("--turbulence <PART>", "-1", from_zero),
    ] {
        let name = option.split(' ').next().unwrap();
        let run = folder.run(&format!("wilt none.txt -o out {name}={value}"));
        assert_eq!(run.code, Some(2), "{option} {value}: {}", run.stderr);
        let said = format!("invalid value '{value}' for '{option}': ");
        assert!(run.stderr.contains(&said) && run.stderr.contains(why), "{}", run.stderr);
    }
}

/// Where the segments of an animation end at one of its times, as a viewer poses the skin.
fn posed(bytes: &[u8], time: f32) -> Vec<[f64; 3]> {
    let file = gltf::Gltf::from_slice(bytes).unwrap();
    let numbers = |buffer: gltf::Buffer<'_>| {
        assert_eq!(buffer.index(), 0);
        file.blob.as_deref()
    };
    let mut local: Vec<([f32; 3], [f32; 4])> = Vec::new();
    for node in file.nodes() {
        let (t, q, _) = node.transform().decomposed();
        local.push((t, q));
    }
    let animation = file.animations().next().unwrap();
    for channel in animation.channels() {
        let reader = channel.reader(numbers);
        let frame = reader.read_inputs().unwrap().position(|t| (t - time).abs() < 1e-6).unwrap();
        let rotations = match reader.read_outputs().unwrap() {
            gltf::animation::util::ReadOutputs::Rotations(rotations) => rotations.into_f32(),
            _ => panic!("not a rotation"),
        };
        local[channel.target().node().index()].1 = rotations.collect::<Vec<_>>()[frame];
    }
    let turned = |[x, y, z, w]: [f32; 4], p: [f32; 3]| {
        let cross = |a: [f32; 3], b: [f32; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let once = cross([x, y, z], p);
        let twice = cross([x, y, z], once);
        [0, 1, 2].map(|i| p[i] + 2.0 * (w * once[i] + twice[i]))
    };
    let mut above = vec![None; local.len()];
    for node in file.nodes() {
        node.children().for_each(|child| above[child.index()] = Some(node.index()));
    }
    let skin = file.skins().next().unwrap();
    let reader = skin.reader(numbers);
    let inverse: Vec<_> = reader.read_inverse_bind_matrices().unwrap().collect();
    let joints: Vec<usize> = skin.joints().map(|joint| joint.index()).collect();
    let mesh = file.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    let reader = primitive.reader(numbers);
    let of = reader.read_joints(0).unwrap().into_u16();
    let weights = reader.read_weights(0).unwrap().into_f32();
    assert!(weights.into_iter().all(|w| w == [1.0, 0.0, 0.0, 0.0]));
    let vertices: Vec<[f64; 3]> = reader
        .read_positions()
        .unwrap()
        .zip(of)
        .map(|(p, [joint, ..])| {
            let m = inverse[joint as usize];
            let mut p = [0, 1, 2].map(|i| p[i] + m[3][i]);
            let mut at = Some(joints[joint as usize]);
            while let Some(node) = at {
                let (t, q) = local[node];
                p = turned(q, p);
                p = [0, 1, 2].map(|i| p[i] + t[i]);
                at = above[node];
            }
            p.map(f64::from)
        })
        .collect();
    ring_centres(&vertices)
}

/// The second ring of six vertices of every tube is around the end of its segment.
fn ring_centres(vertices: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let ends = vertices.chunks(12).map(|tube| &tube[6..]);
    ends.map(|ring| [0, 1, 2].map(|i| ring.iter().map(|p| p[i]).sum::<f64>() / 6.0)).collect()
}

fn obj_vertices(folder: &Folder, name: &str) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(folder.path(name)).unwrap();
    let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
    let numbers = |line: &str| line.split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    lines.map(|line| numbers(line)[..3].try_into().unwrap()).collect()
}

#[test]
fn a_film_moves_in_the_wind_and_its_animation_is_its_meshes() {
    let folder = Folder::new();
    let line = "wilt --grow 60 --hours 24 --motion 2 --wind 3,0,0 --damping 2 --frames 8 --animation \
                --hold 20 --mesh obj";
    let said = folder.succeed(&format!("{line} -o out"));
    assert!(said.contains("9, of 120 steps of 0.0167 s") && said.contains("% are for the water"));
    let water = table(&folder, "out/water.csv").1;
    assert_eq!(
        water.iter().map(|row| row[0]).collect::<Vec<_>>(),
        [0., 3., 6., 9., 12., 15., 18., 21., 24.]
    );
    let still = "wilt --grow 60 --hours 24 --frames 8 --hold 20 --mesh none -o still";
    folder.succeed(still);
    for (moving, still) in water.iter().zip(&table(&folder, "still/water.csv").1) {
        assert!((moving[1] / still[1] - 1.0).abs() < 1e-9);
    }
    let glb = std::fs::read(folder.path("out/wilting.glb")).unwrap();
    let first = ring_centres(&obj_vertices(&folder, "out/plant-000.obj"));
    for frame in [0, 3, 8] {
        let mesh = ring_centres(&obj_vertices(&folder, &format!("out/plant-00{frame}.obj")));
        // y is upwards in glTF.
        let found = posed(&glb, 0.25 * frame as f32);
        for (v, ([x, y, z], mesh)) in found.into_iter().zip(&mesh).enumerate() {
            for (a, b) in [x, -z, y].into_iter().zip(mesh) {
                assert!((a - b).abs() < 2e-5, "frame {frame}, segment {v}: {a} {b}");
            }
        }
        let across = |points: &[[f64; 3]]| points.iter().map(|p| p[0]).sum::<f64>() / 60.0;
        assert!(frame == 0 || across(&mesh) > across(&first) + 5e-6);
    }
    // The same gusts again.
    folder.succeed(&format!("{line} -o again"));
    assert_eq!(std::fs::read(folder.path("again/wilting.glb")).unwrap(), glb);
    // At rest, 24 frames a second.
    folder.succeed("wilt --grow 20 --hours 24 --frames 12 --animation --mesh none -o rest");
    assert_eq!(posed(&std::fs::read(folder.path("rest/wilting.glb")).unwrap(), 0.5).len(), 20);
}

#[test]
fn elasticity_is_that_of_equation_4_9_when_it_is_to_be_literal() {
    let folder = Folder::new();
    let line =
        "wilt --grow 20 --hours 24 --frames 2 --mesh none --literal --kappa 40 --steepest-at 0.01";
    folder.succeed(&format!("{line} --elasticity 2e7,1 -o out"));
    let (water, stiffness) = (table(&folder, "out/water.csv"), table(&folder, "out/stiffness.csv"));
    for (water, stiffness) in water.1.iter().zip(&stiffness.1) {
        for (kg, pascal) in water[2..].iter().zip(&stiffness[2..]) {
            let expected = 2e7 / (1.0 + (-40.0 * (1e3 * kg - 0.01)).exp());
            assert!((pascal / expected - 1.0).abs() < 1e-12);
        }
    }
    assert!(folder.run("wilt --grow 20 --literal -o other").stderr.contains("--kappa"));
}

#[test]
fn constants_are_found_from_weights_and_heights() {
    let folder = Folder::new();
    let plant = "wilt --grow 40 --seed 3 --hours 48 --frames 16 --mesh obj";
    folder.succeed(&format!("{plant} --delta 85 --conductance 4e-10 --kappa 13 -o out"));
    let water = table(&folder, "out/water.csv").1;
    let mut text = "time_h,weight_g,height_m\n".to_string();
    for (i, row) in water.iter().enumerate() {
        let tube = obj_vertices(&folder, &format!("out/plant-{i:03}.obj"));
        let height = ring_centres(&tube).iter().map(|p| p[2]).fold(f64::MIN, f64::max);
        text += &format!("{},{},{height}\n", row[0], 250.0 + 1e3 * row[1]);
    }
    folder.write("measured.csv", &text);
    let said = folder.succeed("wilt --grow 40 --seed 3 --fit measured.csv -o fit");
    assert!(said.contains("delta") && said.contains("+-") && said.contains("3 files"), "{said}");
    let text = std::fs::read_to_string(folder.path("fit/fit.csv")).unwrap();
    let value = |name: &str| -> f64 {
        let line = text.lines().find(|line| line.starts_with(name)).unwrap();
        line.split(',').nth(1).unwrap().parse().unwrap()
    };
    for (name, truth) in [("delta", 85.0), ("chi", 4e-10), ("kappa", 13.0)] {
        assert!((value(name) / truth - 1.0).abs() < 1e-4, "{text}");
    }
    let (head, rows) = table(&folder, "fit/fitted.csv");
    assert_eq!(head, ["time_h", "weight_g", "model_g", "height_m", "model_m"]);
    assert!(rows.len() == 17 && rows.iter().all(|row| (row[1] - row[2]).abs() < 1e-3));
    assert!(std::fs::read_to_string(folder.path("fit/fit.svg")).unwrap().contains("</svg>"));

    for (text, part) in [
        ("hours,weight\n", "line 1"),
        ("time_h,weight_g\n0,1\n1,x\n", "line 3"),
        ("time_h,weight_g\n0,1\n1\n", "line 3"),
        ("time_h,weight_g\n0,1\n", "must be at least 4, are 1"),
        ("time_h,weight_g\n0,nan\n", "line 2: expected 2 finite numbers, not \"0,nan\""),
        ("time_h,weight_g\n0,3\n2,2\n1,1\n", "line 4: time_h must ascend from 0, not from 2 to 1"),
        ("time_h,weight_g\n-1,3\n", "line 2: time_h must ascend from 0, not from 0 to -1"),
        ("time_h,weight_g\n0,1\n1,1\n2,1\n3,1\n", "weights: must not all be equal"),
        (
            "time_h,weight_g,node_99_m\n0,4,1\n1,3,1\n2,2,1\n3,1,1\n",
            "mark: node 99 is out of range",
        ),
    ] {
        folder.write("wrong.csv", text);
        let said = folder.fail("wilt --grow 40 --fit wrong.csv -o wrong");
        assert!(said.contains("wrong.csv: ") && said.contains(part), "{said}");
        assert!(!folder.path("wrong").exists());
    }
}

#[test]
fn each_part_has_its_own_steepness() {
    let folder = Folder::new();
    folder.write("plant.txt", LITTLE);
    let run = |options: &str, out: &str| {
        let line = format!("wilt plant.txt --hours 96 --frames 2 --mesh none -o {out} {options}");
        folder.succeed(&line);
        let [water, moduli] = ["water", "stiffness"].map(|name| {
            let row = table(&folder, &format!("{out}/{name}.csv")).1.pop().unwrap();
            row[2..].to_vec()
        });
        (water, moduli)
    };
    let full = table_of_full(&folder);
    let modulus = |w: f64, k: f64| {
        let s = |x: f64| 1.0 / (1.0 + (-k * x).exp());
        3e5 + (5e7 - 3e5) * (s(w - 0.75) - s(-0.75)) / (s(0.25) - s(-0.75))
    };
    // Nodes 0 and 1 are stem, of 2 mm; 2 and 3 leaves, of 1 mm.
    for (options, kappas) in [
        ("--kappa leaf=4,stem=20", [20.0, 20.0, 4.0, 4.0]),
        ("--kappa 6,leaf=4", [6.0, 6.0, 4.0, 4.0]),
        ("--kappa stem=20", [20.0, 20.0, 10.0, 10.0]),
        ("--kappa 5 --kappa-by-radius 1.5=9,4=1", [5.0; 4]),
        ("--kappa 5 --kappa-by-radius 1.5=9", [9.0, 9.0, 5.0, 5.0]),
    ] {
        if options.contains("4=1") {
            let said = folder.fail(&format!("wilt plant.txt -o none {options}"));
            assert!(
                said.contains("plant.txt: the plant has no segment for --kappa-by-radius 4=1"),
                "{said}"
            );
            continue;
        }
        let out = options.replace([' ', '=', ',', '-'], "_");
        let (water, moduli) = run(options, &out);
        for v in 0..4 {
            let expected = modulus(water[v] / full[v], kappas[v]);
            assert!((moduli[v] / expected - 1.0).abs() < 1e-9, "{options}: {v}");
        }
    }
    let fails = |options: &str, part: &str| {
        let run = folder.run(&format!("wilt plant.txt -o none {options}"));
        assert!(run.code != Some(0) && run.stderr.contains(part), "{options}: {}", run.stderr);
    };
    fails("--kappa petiole=3", "plant.txt: the plant has no segment for --kappa petiole=3");
    fails("--kappa root=3", "leaf=K");
    fails("--kappa-by-radius 3", "MM=K");
    fails("--kappa-by-radius 2=3,1=4", "ascend");
    fails("--kappa leaf=3 --kappa-by-radius 1=3", "--kappa must be a single number");
    fails("--kappa leaf=-3", "steepness");
}

/// The water of each node of the little plant when its cells are full.
fn table_of_full(folder: &Folder) -> Vec<f64> {
    folder.succeed("wilt plant.txt --hours 1 --frames 1 --mesh none -o full");
    table(folder, "full/water.csv").1[0][2..].to_vec()
}

#[test]
fn soil_is_emptied_and_watered_and_no_water_is_lost() {
    let folder = Folder::new();
    let plant = "wilt --grow 80 --hours 240 --delta 400 --frames 24 --mesh none";
    let said = folder.succeed(&format!(
        "{plant} --soil 0.3,0.2 --rewater 100:0.05 --rewater 150 --rewater 150:9 --stomata 0.7,20 -o pot"
    ));
    assert!(said.contains("soil ") && said.contains("5 files"), "{said}");
    let (head, rows) = table(&folder, "pot/balance.csv");
    assert_eq!(head.join(","), "time_h,plant_kg,soil_kg,transpired_kg,supplied_kg,drained_kg");
    let initial = rows[0][1] + rows[0][2];
    assert!((rows[0][2] - 2e-4).abs() < 1e-18);
    for (row, water) in rows.iter().zip(&table(&folder, "pot/water.csv").1) {
        assert!((row[1] / water[1] - 1.0).abs() < 1e-12);
        assert!(((row[1] + row[2] + row[3]) / (initial + row[4]) - 1.0).abs() < 1e-12);
    }
    // Poured at 100 and at 150 hours; what is too much then drains.
    let supplied = |hour: usize| rows[hour / 10][4];
    assert_eq!((supplied(90), supplied(100)), (0.0, 5e-5));
    assert!(supplied(150) > supplied(140) && supplied(240) == supplied(150));
    assert!((rows[24][5] - 9e-3).abs() < 1e-12 && (rows[15][2] - 3e-4).abs() < 1e-15);
    assert!(std::fs::read_to_string(folder.path("pot/water.svg")).unwrap().contains("soil"));
    // Closing leaves keep water back; in motion it is the same water.
    let left = |options: &str, out: &str| {
        folder.succeed(&format!("{plant} {options} -o {out}"));
        table(&folder, &format!("{out}/water.csv")).1[24][1]
    };
    let (open, closing) = (left("", "open"), left("--stomata 0.8,25", "closing"));
    assert!(closing > 1.05 * open, "{open} {closing}");
    let moving = left("--stomata 0.8,25 --motion 1", "moving");
    assert!((moving / closing - 1.0).abs() < 1e-6);

    let fails = |options: &str, part: &str| {
        let run = folder.run(&format!("wilt --grow 5 -o none {options}"));
        assert!(run.code != Some(0) && run.stderr.contains(part), "{options}: {}", run.stderr);
    };
    fails("--rewater 3", "--soil");
    fails("--hours 2 --soil 1 --rewater 1 --rewater 100", "--rewater 100: is after the end");
    fails("--soil 1,2", "AT_FIRST from 0 to GRAMS");
    fails("--soil x", "expected GRAMS");
    fails("--soil 1 --rewater=-3", "expected HOURS or HOURS:GRAMS");
    fails("--soil 1 --rewater 3:x", "expected HOURS or HOURS:GRAMS");
    fails("--stomata 0.5", "steepness");
    fails("--stomata 0.5,-1", "steepness");
    fails("--stomata 2.5,25", "half of stomata: must be above 0 and at most 1, is 2.5");
    fails("--soil 1 --fit weights.csv", "--fit");
}

#[test]
fn days_without_end_are_refused_and_soil_of_nothing_ends_at_once() {
    let folder = Folder::new();
    let years = "wilt --grow 30 --hours 1e9 --day-night --frames 2 --mesh none -o years";
    let refused = folder.fail(years);
    assert!(refused.contains("--day-night: 4.2e7 days and nights; at most 5e5"), "{refused}");
    let run = |options: &str, out: &str| {
        folder.succeed(&format!(
            "wilt --grow 30 --hours 24 --frames 2 --mesh none -o {out} {options}"
        ));
        table(&folder, &format!("{out}/water.csv")).1
    };
    let (none, nothing) = (run("", "none"), run("--soil 1e-12", "nothing"));
    assert!((nothing[2][1] / none[2][1] - 1.0).abs() < 1e-6, "{nothing:?} {none:?}");
    let refused = folder.fail("wilt --grow 30 --hours 24 --frames 2 -o less --soil 1e-300");
    assert!(refused.contains("capacity of the soil: must be at least 1e-15 kg"), "{refused}");
}

#[test]
fn heights_of_nodes_tell_the_steepness_of_each_part() {
    let folder = Folder::new();
    let plant = "wilt --grow 40 --seed 3";
    let options = "--hours 48 --frames 12 --delta 300 --conductance 4e-10 --mesh obj";
    folder.succeed(&format!("{plant} {options} --kappa leaf=7,stem=15 -o out"));
    let mut text = "time_h,weight_g,node_39_m,node_20_m\n".to_string();
    for (i, row) in table(&folder, "out/water.csv").1.iter().enumerate() {
        let tails = ring_centres(&obj_vertices(&folder, &format!("out/plant-{i:03}.obj")));
        text += &format!("{},{},{},{}\n", row[0], 1e3 * row[1], tails[39][2], tails[20][2]);
    }
    folder.write("measured.csv", &text);
    let said =
        folder.succeed(&format!("{plant} --kappa leaf=10,stem=10 --fit measured.csv -o fit"));
    assert!(said.contains("kappa_leaf") && said.contains("kappa_stem"), "{said}");
    let text = std::fs::read_to_string(folder.path("fit/fit.csv")).unwrap();
    for (name, truth) in [("kappa_leaf", 7.0), ("kappa_stem", 15.0)] {
        let line = text.lines().find(|line| line.starts_with(name)).unwrap();
        let value: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
        assert!((value / truth - 1.0).abs() < 1e-2, "{text}");
    }
    let head = table(&folder, "fit/fitted.csv").0.join(",");
    assert_eq!(head, "time_h,weight_g,model_g,node_39_m,model_39_m,node_20_m,model_20_m");
    for (header, part) in [("time_h,weight_g,node_x_m", "node_x_m"), ("time_h", "weight_g")] {
        folder.write("wrong.csv", format!("{header}\n"));
        let said = folder.fail(&format!("{plant} --fit wrong.csv -o wrong"));
        assert!(said.contains("line 1") && said.contains(part), "{said}");
    }
}

#[test]
fn another_minimum_that_fits_as_well_is_warned_of() {
    let folder = Folder::new();
    let plant = "wilt --grow 30 --seed 3";
    folder.succeed(&format!("{plant} --hours 48 --frames 24 --mesh none -o out"));
    let water = table(&folder, "out/water.csv").1;
    let lost = water[0][1] - water[24][1];
    let fit = |noise: f64, out: &str| {
        let mut text = "time_h,weight_g\n".to_string();
        for (i, row) in water.iter().enumerate() {
            let off = noise * lost * ((i * i) as f64).sin();
            text += &format!("{},{}\n", row[0], 1e3 * (row[1] + off));
        }
        folder.write("measured.csv", &text);
        let said = folder.succeed(&format!("{plant} --fit measured.csv -o {out}"));
        (said, std::fs::read_to_string(folder.path(&format!("{out}/fit.csv"))).unwrap())
    };
    let (said, table) = fit(0.0, "exact");
    assert!(!said.contains("warning") && !table.contains("minimum"), "{said}");
    let (said, table) = fit(1e-3, "coarse");
    assert!(said.contains("minimum 2 fits as well: delta 59.8"), "{said}");
    assert!(said.contains("standard errors are those of the first minimum alone"), "{said}");
    let other = table.lines().find(|line| line.starts_with("delta of minimum 2,59.8"));
    assert!(other.is_some_and(|line| line.ends_with(",,g/(h m^2)")), "{table}");
}

/// Writes the tables of leaves that dry for 14 hours, as the guide names them.
fn leaf_tables(folder: &Folder) {
    let mut text = "treatment,sample,dry.weight,fresh.weight.saturated,leaf.area,date.and.time,\
                    fresh.weight\n"
        .to_string();
    let leaves = [(1, 6e-4), (2, 5e-4), (9, 5.5e-4), (10, 5.2e-4), (11, 5.8e-4), (12, 5.4e-4)];
    for (sample, rate) in leaves {
        for i in 0..15 {
            // The stomata close with a time constant of an hour; the cuticle loses a tenth.
            let hours = f64::from(i);
            let lost = 3600.0 * rate * (0.3 * (1.0 - (-hours).exp()) + 0.01 * hours);
            let time = format!("2019-03-26 {:02}:00:00", 8 + i);
            text += &format!("wet,{sample},0.5,6,120,{time},{}\n", 6.0 - lost);
        }
    }
    folder.write("leaves.csv", &text);
    let air = "date.and.time,temperature,humidity\n\
               2019-03-26 00:00:00,25,45\n2019-03-27 00:00:00,25,45\n";
    folder.write("air.csv", air);
    let mut text = "treatment,sample,dry.weight,fresh.weight.saturated,fresh.weight,\
                    water.potential\n"
        .to_string();
    for (sample, point) in [(1, 0.86), (2, 0.88), (3, 0.84)] {
        for i in 0..10 {
            let w = 0.7 + 0.03 * f64::from(i);
            let potential = -1.2 * 0.8 / (w - 0.2) + 5.0 * f64::max(w - point, 0.0);
            text += &format!("wet,{sample},0.5,6,{},{potential}\n", 0.5 + 5.5 * w);
        }
    }
    folder.write("curves.csv", text);
}

#[test]
fn leaves_are_fitted_by_treatment_and_an_unseen_one_follows() {
    let folder = Folder::new();
    leaf_tables(&folder);
    let run = "wilt --fit leaves.csv --weather air.csv";
    let said =
        folder.succeed(&format!("{run} --pressure-volume curves.csv --unseen 9,10,11,12 -o fit"));
    for part in [
        "cuticle",
        "turgor lost at 0.860",
        "open",
        "half closed at",
        "unseen",
        "times the error of the scale",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let text = std::fs::read_to_string(folder.path("fit/fit.csv")).unwrap();
    assert!(text.starts_with("treatment,leaf,constant,value,standard_error,unit\n"), "{text}");
    assert_eq!(text.lines().count(), 1 + 2 + 6 * 2, "{text}");
    let text = std::fs::read_to_string(folder.path("fit/fitted.csv")).unwrap();
    assert_eq!(text.lines().filter(|line| line.starts_with("wet,9,unseen,")).count(), 15);
    assert_eq!(text.lines().filter(|line| line.contains(",fitted,")).count(), 30);
    for line in text.lines().skip(1) {
        let difference: f64 = line.rsplit(',').next().unwrap().parse().unwrap();
        assert!(difference.abs() < 100.0, "{line}");
    }
    assert!(std::fs::read_to_string(folder.path("fit/fit.svg")).unwrap().contains("</svg>"));
    let said = folder.succeed(&format!("{run} --instrument 0.1 -o coarse"));
    assert!(!said.contains("times the error of the scale"), "{said}");

    let fails = |options: &str, part: &str| {
        let run = folder.run(&format!("wilt {options} -o wrong"));
        assert!(run.code != Some(0) && run.stderr.contains(part), "{options}: {}", run.stderr);
        assert!(!folder.path("wrong").exists());
    };
    fails("--fit leaves.csv --weather air.csv --unseen D", "--unseen D: leaves.csv has no such");
    fails(
        "--fit leaves.csv --weather air.csv --unseen 1,2,9,10,11,12",
        "--unseen: leaves.csv: treatment \"wet\" has no other leaf",
    );
    fails("--fit leaves.csv --weather leaves.csv", "has no column \"temperature\"");
    fails("--fit air.csv --weather air.csv", "has no column \"sample\"");
    fails("--weather air.csv", "--fit");
    fails("plant.txt --fit leaves.csv --weather air.csv", "cannot be used with");
    fails("--fit leaves.csv --weather air.csv --kappa 3", "cannot be used with");
    fails("--fit leaves.csv --weather air.csv --instrument 0", "--instrument");
    fails("--grow 9 --fit leaves.csv --unseen A", "cannot be used with");
    let text = std::fs::read_to_string(folder.path("leaves.csv")).unwrap();
    folder.write("semicolons.csv", text.replace(',', ";"));
    fails("--fit semicolons.csv --weather air.csv", "semicolons separate the columns");
    folder.write("dry.csv", text.replace("0.5,6,120", "7,6,120"));
    fails("--fit dry.csv --weather air.csv", "1: its dry weight must be at least 0 and below");
    folder.write("area.csv", text.replace("0.5,6,120", "0.5,6,-120"));
    fails("--fit area.csv --weather air.csv", "1: its area must be positive");
}

#[test]
fn a_seed_without_a_generated_plant_or_wind_is_refused() {
    let run = Folder::new().run("wilt plant.txt --seed 3 -o out");
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(run.stderr.contains("--grow") && run.stderr.contains("--wind"), "{}", run.stderr);
}

#[test]
fn options_that_a_fit_has_no_use_for_are_refused() {
    let folder = Folder::new();
    for options in [
        "--hours 3",
        "--delta 60",
        "--conductance 1e-9",
        "--kappa 8 --literal",
        "--rewater 3",
        "--steps-per-second 60",
        "--damping 1",
        "--wind 1,2,3",
        "--turbulence 0.1",
        "--frames 3",
        "--mesh none",
    ] {
        let run = folder.run(&format!("wilt --grow 5 --fit weights.csv -o out {options}"));
        assert_eq!(run.code, Some(2), "{options}: {}", run.stderr);
        assert!(run.stderr.contains("cannot be used with"), "{options}: {}", run.stderr);
    }
}

#[test]
fn options_of_motion_are_checked() {
    let folder = Folder::new();
    let fails = |options: &str, part: &str| {
        let run = folder.run(&format!("wilt --grow 5 -o out {options}"));
        assert!(run.code != Some(0) && run.stderr.contains(part), "{options}: {}", run.stderr);
    };
    fails("--motion 0", "--motion");
    fails("--motion 1 --steps-per-second 0", "--steps-per-second");
    fails("--frames 0", "expected a whole number from 1 to 100000");
    fails("--motion 1 --wind 1,2", "expected 3 numbers");
    fails("--motion 1 --damping=-1", "damping");
    fails("--wind 1,2,3", "--motion");
    fails("--motion 1e9", "steps");
    fails("--motion 1 --fit weights.csv", "--fit");
}

#[test]
fn the_commands_of_the_guide_run() {
    let folder = Folder::new();
    folder.write("plant.txt", LITTLE);
    folder.succeed("wilt plant.txt --frames 8 --mesh obj -o before");
    let (mut weights, mut heights) =
        ("time_h,weight_g\n".to_string(), "time_h,weight_g,node_2_m\n".to_string());
    for (i, row) in table(&folder, "before/water.csv").1.iter().enumerate() {
        let tails = ring_centres(&obj_vertices(&folder, &format!("before/plant-{i:03}.obj")));
        weights += &format!("{},{}\n", row[0], 1e3 * row[1]);
        heights += &format!("{},{},{}\n", row[0], 1e3 * row[1], tails[2][2]);
    }
    folder.write("measured.csv", &weights);
    folder.write("heights.csv", &heights);
    leaf_tables(&folder);
    let guide = include_str!("../../../docs/guide/plants.md");
    for line in calls(guide) {
        folder.succeed(line);
    }
}

#[test]
fn an_animation_that_no_file_can_hold_is_refused_before_it_is_computed() {
    let folder = Folder::new();
    let line = "wilt --grow 2000 --frames 100000 --mesh none --animation -o out";
    let run = folder.run(line);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    let says = "--animation: more than 2 GiB of numbers; give fewer --frames";
    assert!(run.stderr.contains(says), "{}", run.stderr);
    assert!(!run.stdout.contains("frames"), "{}", run.stdout);
}

#[test]
fn frames_of_an_earlier_run_stay_and_are_noted() {
    let folder = Folder::new();
    let run = |rest: &str| {
        let run = folder.run(&format!("wilt --grow 9 --hours 2 -o out {rest}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        run.stderr
    };
    assert_eq!(run("--frames 4 --mesh obj"), "");
    let note = "note: out: frames that this run does not write stay: ";
    assert_eq!(
        run("--frames 2 --mesh obj --force"),
        format!("{note}2, plant-003.obj to plant-004.obj\n")
    );
    assert!(folder.path("out/plant-004.obj").exists());
    assert_eq!(
        run("--frames 3 --mesh ply --force"),
        format!("{note}5, plant-000.obj to plant-004.obj\n")
    );
    assert_eq!(
        run("--frames 4 --mesh obj --force"),
        format!("{note}4, plant-000.ply to plant-003.ply\n")
    );
}
