use super::*;

fn refusal(bytes: &str, format: PlantFormat, part: &str) {
    let error = read_bytes(bytes.as_bytes(), format).unwrap_err().to_string();
    assert!(error.contains(part), "{error}");
}

/// Asserts that the plant is a stem of two segments along z, with a leaf on the first.
fn is_the_little_plant(plant: &Plant) {
    assert_eq!(plant.len(), 3);
    assert_eq!([0, 1, 2].map(|v| plant.parent(v)), [None, Some(0), Some(0)]);
    assert_eq!(plant.segments().iter().map(|s| s.leaf).collect::<Vec<_>>(), [false, false, true]);
    assert_eq!(plant.segments()[2].tail, [0.1, 0.0, 0.2]);
    assert!(plant.segments().iter().all(|s| s.radius == 0.002));
}

#[test]
fn the_reference_format_is_read() {
    let text = "verts 3\n0,0,0,.1,.002,0\n1,0,0,.2,.002,0,1\n2,.1,0,.2,.002,1\nedges 2\n1,0\n0,2\n";
    let plant = read_bytes(text.as_bytes(), PlantFormat::Reference).unwrap();
    is_the_little_plant(&plant);
    assert_eq!(plant.segments().iter().map(|s| s.pinned).collect::<Vec<_>>(), [false, true, false]);
    let at = PlantFormat::Reference;
    refusal("verts 2\n0,0,0,.1,.002,0\n", at, "plant.txt:3: the file ends before a line of a node");
    refusal("verts 1\n0,0,0,x,.002,0\nedges 0\n", at, "plant.txt:2: z: \"x\"");
    refusal("verts 1\n3,0,0,1,.002,0\nedges 0\n", at, "the next id must be 0, is 3");
    refusal("vertices 1\n", at, "`verts COUNT`");
    refusal(
        "verts 1\n0,0,0,1,-1,0\nedges 0\n",
        at,
        "plant.txt: node 0: radius must be positive and finite, is -1",
    );
    refusal("verts 0\nedges 0\n", at, "must have 1 to 2^32 - 2 nodes, has 0");
    refusal("verts 1\n0,0,0,1,1,0\nedges 0\n0,0\n", at, "more than the announced 0 edges");
    // A decimal comma shifts the numbers after it.
    refusal(
        "verts 1\n0,0,0,1,5,0,002,1\nedges 0\n",
        at,
        "plant.txt:2: fixed: must be 0 or 1, is 2",
    );
    refusal("verts 1\n0,0,0,1,5,0,0,02\nedges 0\n", at, "plant.txt:2: \"02\" is one too many");
    refusal("verts 1\n0,0,0,1,.1,2\nedges 0\n", at, "on_leaf: must be 0 or 1, is 2");
    refusal("verts 1\n0,0,0,1,.1,1,.7\nedges 0\n", at, "fixed: must be 0 or 1, is 0.7");
    let two = "verts 2\n0,0,0,1,.1,0\n1,0,0,2,.1,1\nedges 1\n";
    refusal(&format!("{two}0,1,2\n"), at, "plant.txt:5: \"2\" is one too many");
    // The segment of the root begins at the origin, however far it is.
    let notes = |text: &str| read_bytes(text.as_bytes(), at).unwrap().notes().join("; ");
    let away = "verts 2\n0,30,40,0,.1,0\n1,30,40,1,.1,1\nedges 1\n0,1\n";
    assert!(notes(away).contains("node 0, is 50.000 m long, and no other more than 1.000 m"));
    assert_eq!(notes(&away.replace("30,40", "3,4")), "");
}

#[test]
fn swc_is_read() {
    let text = "# a plant\n5 3 0 0 .1 .002 -1\n9 3 0 0 .2 .002 5\n7 7 .1 0 .2 .002 5\n";
    is_the_little_plant(&read_bytes(text.as_bytes(), PlantFormat::Swc).unwrap());
    refusal("1 3 0 0 0 1 2\n", PlantFormat::Swc, "node 2, a parent, does not exist");
    refusal(
        "1 3 0 0 0 1 -1\n1 3 0 0 1 1 1\n",
        PlantFormat::Swc,
        "plant.swc:2: node 1 occurs twice",
    );
    refusal("1 3 0 0 0 1 -1\n2 3 0 0 1 1 -1\n", PlantFormat::Swc, "node 1: is isolated");
    // Comments after the numbers, and columns of extensions.
    let text = "5 3 0 0 .1 .002 -1 # base\n9 3 0 0 .2 .002 5 1 0\n7 7 .1 0 .2 .002 5\n";
    is_the_little_plant(&read_bytes(text.as_bytes(), PlantFormat::Swc).unwrap());
}

#[test]
fn every_format_is_read_in_its_units_and_notes_what_is_no_plant_in_metres() {
    let folder = tempfile::tempdir().unwrap();
    let texts = [
        ("a.txt", "verts 2\n0,0,0,10,.2,0\n1,0,0,20,.2,0\nedges 1\n1,0\n"),
        ("a.swc", "1 3 0 0 10 .2 -1\n2 3 0 0 20 .2 1\n"),
        ("a.obj", "v 0 0 10 .2\nv 0 0 20 .2\nl 1 2\n"),
        ("a.mtg", "MTG:\nTOPO\tXX\tYY\tZZ\tRadius\n/P1\n^/E1\t0\t0\t10\t.2\n^<E2\t0\t0\t20\t.2\n"),
    ];
    for (name, text) in texts {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let within = |unit: [f64; 2]| read_with(&path, &ReadOptions::new().unit(unit)).unwrap();
        let plant = within([0.01, 0.001]);
        assert_near(&[plant.segments()[1].tail[2], plant.segments()[1].radius], &[0.2, 2e-4]);
        assert_near(&plant.lengths()[1..], &[0.1]);
        let notes = |unit: f64| within([unit, 1.0]).notes().join("; ");
        assert!(!notes(1.0).contains("spans"), "{name}: {}", notes(1.0));
        assert!(notes(100.0).contains("00 metres, more than any tree"), "{name}: {}", notes(100.0));
        let wrong = read_with(&path, &ReadOptions::new().unit([1.0, 0.0])).unwrap_err();
        assert!(wrong.to_string().starts_with("unit: must be"), "{wrong}");
    }
    // The default radius of a vertex is 1 mm in every unit.
    let path = folder.path().join("a.obj");
    std::fs::write(&path, "v 0 0 10\nv 0 0 20\nl 1 2\n").unwrap();
    let plant = read_with(&path, &ReadOptions::new().unit([0.01, 0.01])).unwrap();
    assert_eq!(plant.segments()[1].radius, 1e-3);
}

#[test]
fn a_segment_that_is_added_below_the_root_is_noted() {
    let note = |plant: Plant| plant.notes().join("; ");
    let read = |text: &str, format| note(read_bytes(text.as_bytes(), format).unwrap());
    let added = "no segment leads to the root, node 0: one of 0.100 m is added below it";
    let line = "v 0 0 0\nv 0 0 0.1\nv 0 0 0.2\nl -3 -2 -1\n";
    assert_eq!(read(line, PlantFormat::Obj), added);
    let swc = "1 3 0 0 0 .001 -1\n2 3 0 0 .1 .001 1\n3 7 0 0 .2 .001 2\n";
    assert_eq!(read(swc, PlantFormat::Swc), added);
    let rows = "/E1\t0\t0\t0\t.01\n^<E2\t0\t0\t.1\t.01\n";
    let mtg = format!("MTG:\nTOPO\tXX\tYY\tZZ\tDiam\n{rows}");
    assert_eq!(read(&mtg, PlantFormat::Mtg), added);
    // With lengths it begins at the origin.
    let rows = "/E1\t.1\t.01\n^<E2\t.1\t.01\n";
    assert_eq!(read(&format!("MTG:\nTOPO\tLength\tDiam\n{rows}"), PlantFormat::Mtg), "");
    let text = "verts 2\n0,0,0,.1,.002,0\n1,0,0,.2,.002,1\nedges 1\n0,1\n";
    assert_eq!(read(text, PlantFormat::Reference), "");
}

#[test]
fn plants_that_are_too_small_or_thicker_than_large_are_noted() {
    let notes = |length: f64, radius: f64| {
        let text = format!("verts 1\n0,0,0,{length},{radius},0\nedges 0\n");
        read_bytes(text.as_bytes(), PlantFormat::Reference).unwrap().notes().join("; ")
    };
    assert_eq!(notes(0.13, 1e-3), "");
    let small = notes(0.13e-3, 1e-6);
    assert!(small.starts_with("the plant spans 1.30e-4 metres, less than any stem"), "{small}");
    let thick = notes(0.13, 1.25);
    assert!(thick.starts_with("node 0 has a radius of 1.250 metres, but the plant spans 0.130"));
}

#[test]
fn mtg_is_read() {
    let text = "CODE:\tFORM-A\nFEATURES:\nMTG:\nENTITY-CODE\t\tXX\tYY\tZZ\tDiameter\n/P1\n/I1\t\t0\t0\t.1\t.004 # one\n\
                ^<I2\t\t0\t0\t.2\t.004\n";
    let branch = "/P1\n/I1\t\t0\t0\t.1\t.004\n\t+L1\t.1\t0\t.2\t.004\n^<I2\t\t0\t0\t.2\t.004\n";
    let plant = read_bytes(text.as_bytes(), PlantFormat::Mtg).unwrap();
    assert_eq!((plant.len(), plant.parent(1)), (2, Some(0)));
    let text = text.split("/P1").next().unwrap().to_owned() + branch;
    let plant = read_bytes(text.as_bytes(), PlantFormat::Mtg).unwrap();
    assert_eq!([0, 1, 2].map(|v| plant.parent(v)), [None, Some(0), Some(0)]);
    assert!(plant.segments()[1].leaf && plant.segments()[1].radius == 0.002);
    let stalk = branch.replace("+L1", "+P2");
    let text = text.split("/P1").next().unwrap().to_owned() + &stalk;
    let plant = read_bytes(text.as_bytes(), PlantFormat::Mtg).unwrap();
    assert!(plant.segments()[1].petiole && !plant.segments()[1].leaf);
    refusal("MTG:\nENTITY-CODE\tLength\n", PlantFormat::Mtg, "no component after the column");
    refusal("CODE:\n", PlantFormat::Mtg, "the file ends before `MTG:`");
}

/// Returns an MTG with three columns of code, then those of `features`.
fn mtg(features: &str, rows: &str) -> String {
    let classes: String =
        ["P\t1", "A\t2", "U \t3", "E\t4"].map(|c| format!("{c}\tFREE\n")).concat();
    format!(
        "CODE :\tFORM-A\nCLASSES:\nSYMBOL\tSCALE\tDECOMPOSITION\n$ \t0\tFREE\n{classes}DESCRIPTION \
         :\nLEFT\tRIGHT\tRELTYPE\tMAX\nE\tE\t+\t?\nFEATURES:\nNAME\tTYPE\nMTG :\nENTITY-CODE\t\t\t\
         {features}\n{rows}"
    )
}

fn plant_of(features: &str, rows: &str) -> Plant {
    read_bytes(mtg(features, rows).as_bytes(), PlantFormat::Mtg).unwrap()
}

/// Returns the plant of an MTG in other units than metres.
fn in_units(features: &str, rows: &str, unit: [f64; 2]) -> Plant {
    let bytes = mtg(features, rows);
    let path = Path::new("plant.mtg");
    let source = Source::of_bytes(path, bytes.as_bytes());
    let options = ReadOptions::new().unit(unit);
    read_source(source, PlantFormat::Mtg, path, &options).unwrap()
}

fn parents(plant: &Plant) -> Vec<Option<usize>> {
    (0..plant.len()).map(|v| plant.parent(v)).collect()
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(near, "{found:?} instead of {expected:?}");
}

const POINTS: &str = "XX\tYY\tZZ\tTopDia";

#[test]
fn branches_of_an_mtg_grow_on_the_column_to_the_left() {
    let rows = "/P1/A1/U1/E1\t\t\t0\t0\t1\t.2\n\t+E1\t\t1\t0\t1\t.2\n\t+E2\t\t-1\t0\t1\t.2\n\
                ^<E2\t\t\t0\t0\t2\t.2\n";
    assert_eq!(parents(&plant_of(POINTS, rows)), [None, Some(0), Some(0), Some(0)]);
    // The branch U2 stands between E1 and E2, which follows E1.
    let rows = "/P1/A1/U1/E1\t\t\t0\t0\t1\t.2\n^+U2\n\t/E1\t\t1\t0\t1\t.2\n^<E2\t\t\t0\t0\t2\t.2\n";
    assert_eq!(parents(&plant_of(POINTS, rows)), [None, Some(0), Some(0)]);
}

#[test]
fn branches_of_one_column_of_an_mtg_grow_on_the_same_component() {
    // The parts of U2 are in the column to the right; U3 and E2 relate to E1, not to them.
    let rows = "/P1/A1/U1/E1\t\t\t0\t0\t1\t.2\n^+U2\n\t/E1\t\t1\t0\t1\t.2\n\t^<E2\t\t2\t0\t1\t.2\n\
                ^+U3\n\t/E1\t\t-1\t0\t1\t.2\n^<E2\t\t\t0\t0\t2\t.2\n";
    let expected = [None, Some(0), Some(1), Some(0), Some(0)];
    assert_eq!(parents(&plant_of(POINTS, rows)), expected);
}

#[test]
fn parts_of_an_mtg_share_the_length_and_the_taper_of_their_unit() {
    let rows = "/P1/A1/U1\t\t\t.04\t.02\t.8\n^/E1<<E4\n\t+U1\t\t.02\t.02\t.4\n\t^/E1<E2\n";
    let plant = plant_of("diabase\tdiasom\tlongueur", rows);
    assert_eq!(parents(&plant), [None, Some(0), Some(1), Some(2), Some(3), Some(4)]);
    assert_near(plant.lengths(), &[0.2; 6]);
    let radii: Vec<f64> = plant.segments().iter().map(|s| s.radius).collect();
    assert_near(&radii, &[0.0175, 0.015, 0.0125, 0.01, 0.01, 0.01]);
    assert_near(&plant.segments()[3].tail, &[0.0, 0.0, 0.8]);
    assert_near(&[plant.segments()[5].tail[2]], &[0.8 + 0.4 * 0.5_f64.sqrt()]);
    let notes = plant.notes().join("; ");
    assert!(notes.contains("4 of 10 components are no segments"), "{notes}");
    assert!(notes.contains("1 of the branches"), "{notes}");
}

#[test]
fn angles_of_an_mtg_turn_branches() {
    let rows = "/P1/A1/U1/E1\t\t\t1\t.1\n\t+E1\t\t2\t.1\t90\t0\n\t+E1\t\t2\t.1\t90\t90\n";
    let plant = plant_of("Length\tDiam\tInsertion\tAzimuth", rows);
    assert_near(&plant.segments()[1].tail, &[2.0, 0.0, 1.0]);
    assert_near(&plant.segments()[2].tail, &[0.0, 2.0, 1.0]);
    // Without an azimuth, each branch is turned by the golden angle from the one before, whether
    // or not it has an insertion angle.
    let rows = "/P1/A1/U1/E1\t\t\t1\t.1\n\t+E1\t\t2\t.1\t90\n\t+E1\t\t2\t.1\t90\n\
                \t+E1\t\t2\t.1\n";
    let plant = plant_of("Length\tDiam\tInsertion", rows);
    for (v, insertion) in [(1, 90.0_f64), (2, 90.0), (3, 45.0)] {
        let (sine, cosine) = (137.507_764 * v as f64).to_radians().sin_cos();
        let (out, up) = insertion.to_radians().sin_cos();
        let tail = [2.0 * out * cosine, 2.0 * out * sine, 1.0 + 2.0 * up];
        assert_near(&plant.segments()[v].tail, &tail);
    }
}

#[test]
fn a_later_observation_of_an_mtg_replaces_the_earlier() {
    let rows = "/P1/A1/U1/E1\t\t\t1\t.1\n*\t\t\t2\n^<E2\t\t\t1\t.1\n";
    assert_near(plant_of("Length\tDiam", rows).lengths(), &[2.0, 1.0]);
}

#[test]
fn components_of_an_mtg_without_coordinates_are_merged() {
    let rows = "/P1/A1/U1/E1<<E9\t\t\t0\t0\t1\t.2\n^<E10\n\t+E1\t\t1\t0\t1\t.2\n";
    let plant = plant_of(POINTS, rows);
    assert_eq!(parents(&plant), [None, Some(0)]);
    let notes = plant.notes();
    assert!(notes.iter().any(|note| note.contains("12 of 14 components")), "{notes:?}");
}

#[test]
fn an_mtg_without_diameters_has_slender_segments_and_a_note() {
    let rows = "/P1/A1/U1\t\t\t0\t0\t0\n^/E1\t\t\t0\t0\t2\n^<E2\t\t\t0\t0\t4\n";
    let plant = plant_of("XX\tYY\tZZ", rows);
    assert_eq!((plant.len(), plant.base()), (2, [0.0; 3]));
    assert!(plant.segments().iter().all(|s| s.radius == 0.1));
    assert!(plant.notes().iter().any(|note| note.contains("no diameters")));
    // The unit of lengths is theirs, too.
    let plant = in_units("XX\tYY\tZZ", rows, [0.01, 0.001]);
    assert!(plant.segments().iter().all(|s| (s.radius - 0.001).abs() < 1e-15));
    let rows = "/P1/A1/U1/E1\t\t\t0\t0\t1\t.2\n^<E2\t\t\t0\t0\t200\n";
    let plant = plant_of(POINTS, rows);
    assert_eq!(plant.segments()[1].radius, 0.1);
    let notes = plant.notes().join("; ");
    assert!(notes.contains("1 of 2 segments have no diameter"), "{notes}");
    // The base is as far below E1 as E2 is above it.
    assert!(notes.contains("spans 398 metres"), "{notes}");
    let notes = |unit: f64| in_units(POINTS, rows, [unit; 2]).notes().join("; ");
    assert!(!notes(0.1).contains("spans"), "{}", notes(0.1));
    assert!(notes(2.0).contains("spans 796 metres"), "{}", notes(2.0));
}

#[test]
fn notes_on_radii_of_an_mtg_say_which_they_are() {
    let notes = |rows: &str| plant_of("Length\tDiam", rows).notes().join("; ");
    let first = notes("/P1/A1/U1/E1\t\t\t1\t0\n^<E2\t\t\t1\t.2\n^<E3\t\t\t1\n");
    let says = "2 of 3 segments have no diameter: they take that of their bearers, and the first \
                one the largest";
    assert!(first.contains(says), "{first}");
    let lost = notes("/P1/A1/U1/E1\t\t\t1\n^<E2\t\t\t\t.2\n");
    assert!(lost.contains("diameters only of components that are no segments: the radius is"));
}

#[test]
fn what_an_mtg_has_beyond_its_header_is_noted() {
    let one = "/P1/A1/U1/E1\t\t\t1\t.2\n";
    let notes = |rows: &str| plant_of("Length\tDiam", rows).notes().join("; ");
    assert!(!notes(one).contains("CLASSES") && !notes(one).contains("columns"), "{}", notes(one));
    let unlisted = notes(&format!("{one}^<l2\t\t\t1\t.2\n"));
    assert!(unlisted.contains("CLASSES does not list l: components of the finest"), "{unlisted}");
    let beyond = notes(&format!("{one}^<E2\t\t\t1\t.2\t7\n^<E3\t\t\t1\t.2\t\n"));
    let says = "cells beyond the 5 columns are not read: those of 1 line, such as \"7\"";
    assert!(beyond.contains(says), "{beyond}");
}

#[test]
fn one_of_several_plants_of_an_mtg_is_read_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plants.mtg");
    let rows = "/P1/A1/U1/E1\t\t\t1\n^<E2\t\t\t2\n/P7/A1/U1/E1\t\t\t3\n/P8/A1/U1/E1\t\t\t4\n";
    std::fs::write(&path, mtg("Length", rows)).unwrap();
    let named = |name| read_with(&path, &ReadOptions::new().individual(name));
    assert_near(named("P1").unwrap().lengths(), &[1.0, 2.0]);
    assert_near(named("P7").unwrap().lengths(), &[3.0]);
    assert_near(named("P8").unwrap().lengths(), &[4.0]);
    let error = named("P2").unwrap_err().to_string();
    assert!(error.contains("3 plants (P1, P7, P8): \"P2\" is not one"), "{error}");
    std::fs::write(&path, mtg("Length", "/P1/A1/U1/E1\t\t\t1\n")).unwrap();
    let error = named("P2").unwrap_err().to_string();
    assert!(error.contains("has 1 plant (P1): \"P2\" is not one"), "{error}");
    let other = read_with(Path::new("plant.swc"), &ReadOptions::new().individual("P1"));
    assert!(other.unwrap_err().to_string().contains("only .mtg files have names"));
}

#[test]
fn latin_1_in_an_mtg_is_read() {
    let rows = "/P1/A1/U1/E1\t\t\t0\t0\t1\t.2\n";
    let bytes = [b"# Unit\xe9 de croissance\n", mtg(POINTS, rows).as_bytes()].concat();
    assert_eq!(read_bytes(&bytes, PlantFormat::Mtg).unwrap().len(), 1);
}

#[test]
fn an_mtg_that_is_not_one_plant_with_a_shape_is_refused() {
    let refused = |features: &str, rows: &str, part: &str| {
        refusal(&mtg(features, rows), PlantFormat::Mtg, part);
    };
    let one = "/P1/A1/U1/E1\t\t\t0\t0\t1\t.2\n";
    refused(POINTS, &one.repeat(2).replacen("P1", "P3", 1), "has 2 plants (P3, P1)");
    refused("diam", "/P1/A1/U1/E1\t\t\t4\n", "how 4 components are connected, not where they are");
    refused("L1\tL2\tL3", "/P1/A1/U1/E1\t\t\t4\t5\t6\n", "distances to three points");
    let two = "/P1\n\t/A1/U1/E1\t\t0\t0\t1\t.2\n\t/A2/U1/E3\t\t1\t0\t1\t.2\n";
    refused(POINTS, two, "E3 begins a second stem");
    refused(POINTS, "/P1/A1/U1/E1<<E99999999\n", "components by ranges");
    refused(POINTS, "P1\n", "\"P1\" is not a chain of /, < or +");
    refused(POINTS, "/P1/A1/U1/E1\t\t\t0\tx\t1\n", "coordinate YY: \"x\" is not a finite number");
    refused(POINTS, "/P1/A1/U1/E1\t\t\t0\t\t1\n", "E1 has no coordinate YY");
    refused("Length\tDiam", "/P1/A1/U1/E1\t\t\t-2\t1\n", "length: must be at least 0, is -2");
    // With the line, and in the unit of the file.
    for (column, what) in
        [("Radius", "radius"), ("Diam", "diameter"), ("BottomDia", "diameter at the base")]
    {
        let why = format!("plant.mtg:16: {what}: must be at least 0, is -0.8");
        refused(&format!("Length\t{column}"), "/P1/A1/U1/E1\t\t\t1\t-0.8\n", &why);
    }
    let two = "/P1/A1/U1/E1\t\t\t1\t.1\t.5\n";
    refused("Length\tRadius\tDiam", two, "E1 has a radius of 0.1 m, but half of its diameter is");
    refused("Length\tDiam\tTopDia", two, "two columns of one diameter, \"diam\" and \"topdia\"");
    refusal("MTG:\nTOPO Length\n/P1 1\n", PlantFormat::Mtg, "separated by spaces: tabs must");
    let form = mtg("Length", "/P1/A1/U1/E1\t\t\t1\n").replace("FORM-A", "FORM-B");
    refusal(&form, PlantFormat::Mtg, "FORM-B: only FORM-A");
}

#[test]
fn polylines_of_obj_are_read() {
    let text = "v 0 0 .1 .002\nv 0 0 .2 .002\nv .1 0 .2 .002\nl 1 2\nl 1 -1\n";
    let plant = read_bytes(text.as_bytes(), PlantFormat::Obj).unwrap();
    assert_eq!([0, 1, 2].map(|v| plant.parent(v)), [None, Some(0), Some(0)]);
    assert_eq!(plant.segments().iter().map(|s| s.leaf).collect::<Vec<_>>(), [false, true, true]);
    refusal("v 0 0 0\nv 0 0 1\nl 1 3\n", PlantFormat::Obj, "plant.obj:3: \"3\" is none of the 2");
    refusal("v 0 0 0\n", PlantFormat::Obj, "no line (`l`)");
    refusal("v 0 0 0\nf 1 1 1\n", PlantFormat::Obj, "a face");
    // Colours are no radii.
    let colored = "v 0 0 0 1 0 0\nv 0 0 1 1 0 0\nl 1 2\n";
    refusal(colored, PlantFormat::Obj, "plant.obj:1: \"0\" is one too many");
    refusal("v 0 0 0\nv 0 0 1\nl 1\n", PlantFormat::Obj, "fewer than two vertices");
}

#[test]
fn unknown_names_and_missing_files_are_errors() {
    assert!(
        read(Path::new("plant.xyz")).unwrap_err().to_string().contains("unknown kind of plant")
    );
    assert!(
        read(Path::new("/nowhere/plant.txt")).unwrap_err().to_string().contains("no such file")
    );
}
