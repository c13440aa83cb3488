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
    refusal("MTG:\nENTITY-CODE\tLength\n", PlantFormat::Mtg, "no columns XX");
    refusal("CODE:\n", PlantFormat::Mtg, "the file ends before `MTG:`");
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
