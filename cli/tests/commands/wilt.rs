//! `catamaran wilt`, from outside.

use crate::common::Folder;

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

#[test]
fn damage_and_nights_show() {
    let folder = Folder::new();
    let plant = "verts 4\n0,0,0,.1,.002,0\n1,0,0,.2,.002,0\n2,.05,0,.3,.001,1\n3,-.05,0,.3,.001,1\n\
                 edges 3\n0,1\n1,2\n1,3\n";
    folder.write("plant.txt", plant);
    let run = |options: &str, out: &str| {
        folder.succeed(&format!("wilt plant.txt --frames 6 --mesh none -o {out} {options}"));
        table(&folder, &format!("{out}/water.csv")).1
    };
    let whole = run("", "a");
    assert!((whole[6][4] - whole[6][5]).abs() < 1e-12);
    let cut = run("--cut 2", "b");
    assert!(cut[6][4] < 0.9 * cut[6][5]);
    let weak = run("--weaken 2,0.01", "c");
    assert!(cut[6][4] < weak[6][4] && weak[6][4] < whole[6][4]);
    let nights = run("--day-night", "d");
    assert!(nights[6][1] > whole[6][1]);
    run("--pin 1 --kappa 12 --shift 0.5 --elasticity 1e8,1e5 --conductance 1e-8 --delta 20", "e");
}

#[test]
fn refusals_say_what_is_wrong_and_write_nothing() {
    let folder = Folder::new();
    folder.write("plant.txt", "verts 2\n0,0,0,.1,.002,0\n1,0,0,.2,-1,1\nedges 1\n0,1\n");
    assert!(folder.fail("wilt plant.txt -o out").contains("plant.txt: node 1: radius -1"));
    assert!(folder.fail("wilt none.swc -o out").contains("none.swc"));
    assert!(folder.fail("wilt --grow 5 -o out --cut 9").contains("node 9 of 5"));
    assert!(folder.fail("wilt --grow 5 -o out --pin 9").contains("--pin: node 9 of 5"));
    assert!(folder.fail("wilt --grow 5 -o out --hours=-1").contains("--hours"));
    assert!(folder.fail("wilt --grow 0 -o out").contains("nodes"));
    let run = folder.run("wilt --grow 5 -o out --frames 4000000000");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("--frames") && run.stderr.contains("at most 100000"));
}
