//! Every command, with the arguments it is tested with, and the inputs they name.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::OnceLock;

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{TriMesh, families, io};

use crate::common::{Folder, csv, subcommands, table};

/// One or more lines for each command: every kind of output, and every kind of input.
///
/// A word that is the name of a file in [`inputs`] is an input; what a run without a fault leaves
/// are the outputs.
pub const LINES: &[&str] = &[
    "ata a.npy -o c.npy --weights w.npy --accumulator sums --block-rows 16",
    "ata a.npy --picture p.png",
    "ata a.npy -o c.csv.gz --scheme exact --verify",
    "ata a.csv -o c.mtx",
    "ata a.npy --times w.npy -o c.npy --block-rows 16",
    "ata-merge a.sums b.sums -o c.npy --accumulator sums",
    "lstsq a.npy w.npy -o x.npz -o x.json --weights w.csv --intercept --block-rows 16",
    "lstsq a.csv --by-column 7,0 -o x.json",
    "predict fit.json a.csv --interval mean -o p.csv",
    "pca a.npy -k 3 -o pca.npz --scores --picture scree.svg --weights w.npy",
    "pca a.npy --correlations r.npy",
    "svd a.npy -o svd.npz --left --orthogonality",
    "mesh sphere.ply -o out.obj.gz",
    "decimate sphere.ply -n 40 -o out.ply --prolongation p.mtx",
    "decimate sphere.ply -n 40 -o out.ply --picture p.png",
    "farthest sphere.ply -n 12 -o samples.npy --cells cells.csv --distances d.csv",
    "farthest sphere.ply -n 12 -o samples.npy --picture p.png",
    "generate torus 12 6 2 0.5 -o out.ply",
    "info",
    "demo --small -o page",
    "spectrum sphere.ply -k 6 -o s.npz",
    "tune --isa portable",
    "basis sphere.ply -k 4 -o basis.npz",
    "transfer sphere.ply sphere.ply --functions f.npy --identity -k 5 --order 1 -o g.npy",
    "transfer sphere.ply sphere.ply --functions f.npy --landmarks pairs.txt -k 5 --order 1 -o g.npy",
    "filter sphere.ply --heat 1e-2 -k 10 --functions f.npy -o g.csv",
    "filter sphere.ply --heat 1e-2 -k 10 -o out.off --picture p.png",
    "filter sphere.ply --heat 1e-2 -k 10 -o out.off",
    "wilt --grow 20 --hours 3 --frames 1 -o out",
    "wilt plant.txt --hours 3 --frames 1 -o out --mesh none",
    "curve torus.obj --samples samples.txt -o curve.json",
    "curve torus.obj --samples samples.txt -o curve.obj --picture p.png",
    "distance sphere.ply --from 0,7 -o d.npy",
    "distance sphere.ply --from 0,7 --method edges -o d.csv --picture p.png",
    "distance sphere.ply --from 0 --method exact --to 7,3 -o d.npy --path-output p.csv",
    "descriptors sphere.ply --kind wks -k 10 --scales 5 -o table.npy",
    "descriptors sphere.ply --kind shot --radius 0.8 -o s.csv",
    "descriptors sphere.ply --kind rings --radius 0.8 --rings 3 --functions f.npy -o r.csv",
    "shapedna sphere.ply torus.obj -k 5 --signatures s.csv --distances d.npy",
    "newton --power 5 --size 32 -o a.png --heights h.png",
    "newton square.obj --w 0.2 -o out.ply",
    "newton square.obj --w 0.2 -o out.ply --picture p.png",
    "newton --volume --size 9 -o v.npy",
    "slime square.obj --config c.toml --mask mask.png --steps 3 -o out --state s.state \
     --coverage c.svg",
    "slime square.obj --config c.toml --steps 3 -o out --render r.png",
    "unions predict left.off right.off -o u.csv --picture p.png",
    "unions predict left.off right.off --weights own.safetensors -o u.csv",
    "unions dataset -o d.npz --size small --vertices 500 --known 1 --unknown 0 --others 0 \
     --poses 1 --pairs 4 --varied 0 --creatures 0",
    "unions train data.npz -o w.safetensors --epochs 1 --width 16 --hidden 16",
    "unions template --vertices 700 -o template.stl",
    "unions interpolate left.off right.off left.off --steps 2 -o u.csv",
    "unions tune sphere.ply torus.obj --pairs 4 --epochs 1 -o w.safetensors",
    "unions shape left.off --spectrum values.csv --tolerance 10 -o out.ply",
    "completions bash",
    "man -o man",
    "help topics",
];

/// Their results differ from run to run: they measure time.
pub const VARYING: &[&str] = &["demo", "tune"];

/// Whether a line takes half a second or more: the quick part leaves it out, and the full one
/// injects less into it.
pub fn is_slow(line: &str) -> bool {
    is_one_of(line, &["demo", "tune", "unions dataset", "unions tune"])
        || ["--picture", "--render"].iter().any(|option| line.contains(option))
}

/// Further readers: formats that no line above reads.
pub const READERS: &[&str] = &[
    "ata a.tsv -o c.npy",
    "ata a.txt -o c.npy",
    "ata a.mtx -o c.npy",
    "ata a.npy.gz -o c.npy",
    "ata a.csv.gz -o c.npy",
    "ata a.npy -o c.npy --weights w.csv",
    "ata a.npy -o c.npy --checkpoint a.part --resume",
    "mesh sphere.obj -o out.ply",
    "mesh sphere.off -o out.ply",
    "mesh sphere.stl -o out.ply",
    "mesh sphere.ply.gz -o out.ply",
    "mesh sphere.ply.xz -o out.ply",
    "transfer sphere.ply sphere.ply --functions f.npy --points points.txt -k 5 --order 1 -o g.npy",
    "wilt plant.swc --hours 3 --frames 1 -o out",
    "slime square.obj --config c.ini --size 32 --steps 3 -o out",
    "slime square.obj --config c.toml --steps 8 -o out --state slime.state --resume",
    "unions train data.npz -o w.safetensors --resume",
];

/// The sizes of the smallest data set that can be trained with.
const DATASET: &str = "--size small --vertices 500 --known 1 --unknown 0 --others 0 --poses 1 \
                       --pairs 4 --varied 0 --creatures 0";

/// The command of a line, as `--help` lists it.
pub fn command_of(line: &str) -> String {
    let mut words = line.split_whitespace();
    let first = words.next().unwrap();
    match first {
        "unions" => format!("{first} {}", words.next().unwrap()),
        _ => first.into(),
    }
}

pub fn is_one_of(line: &str, commands: &[&str]) -> bool {
    commands.contains(&&*command_of(line))
}

/// The words of a line that name an input, each once.
pub fn inputs_of(line: &str) -> BTreeSet<&str> {
    line.split_whitespace().filter(|word| inputs().path(word).is_file()).collect()
}

/// A new folder with the inputs of a line: links, for sums know the path of their input.
pub fn folder_for(line: &str) -> Folder {
    let folder = Folder::new();
    for name in inputs_of(line) {
        symlink(inputs().path(name), folder.path(name)).unwrap();
    }
    // What `unions train --resume` goes on from is beside its output.
    if line.contains("unions train") && line.contains("--resume") {
        let name = "w.safetensors.state.npz";
        symlink(inputs().path(name), folder.path(name)).unwrap();
    }
    folder
}

/// All inputs, made once.
pub fn inputs() -> &'static Folder {
    static INPUTS: OnceLock<Folder> = OnceLock::new();
    INPUTS.get_or_init(|| {
        let folder = Folder::new();
        matrices(&folder);
        meshes(&folder);
        folder
            .write("c.toml", "agents = 300\nsize = 32\nvision_distance = 3\nmovement_speed = 6\n");
        folder.write("c.ini", "NumAgents=300\nMoveSpeed=0.05\nTurnSpeed=50\n");
        mask(&folder.path("mask.png"));
        folder.write(
            "plant.txt",
            "verts 4\n0,0,0,.1,.002,0\n1,0,0,.2,.002,0\n2,.05,0,.3,.001,1\n3,-.05,0,.3,.001,1\n\
             edges 3\n0,1\n1,2\n1,3\n",
        );
        folder.write("plant.swc", "1 1 0 0 0 .01 -1\n2 3 0 0 .1 .01 1\n3 3 0 0 .2 .01 2\n");
        folder.succeed("slime square.obj --config c.toml --steps 4 -o begun --state slime.state");
        folder.succeed(&format!("unions dataset -o data.npz {DATASET}"));
        folder.succeed(
            "unions train data.npz -o own.safetensors --epochs 2 --minutes 0 --width 16 \
             --hidden 16",
        );
        let state = ".safetensors.state.npz";
        fs::copy(folder.path(&format!("own{state}")), folder.path(&format!("w{state}"))).unwrap();
        folder
    })
}

fn matrices(folder: &Folder) {
    let (m, n) = (60, 8);
    let a = table(m, n);
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    folder.write("a.csv", csv(&a, n));
    folder.write("a.tsv", csv(&a, n).replace(',', "\t"));
    folder.write("a.txt", csv(&a, n).replace(',', " "));
    for name in ["a.npy", "a.csv"] {
        let bytes = fs::read(folder.path(name)).unwrap();
        let file = fs::File::create(folder.path(&format!("{name}.gz"))).unwrap();
        let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
        packed.write_all(&bytes).unwrap();
        packed.finish().unwrap();
    }
    // Numbers that every order of additions rounds differently.
    let rough: Vec<f64> =
        (0..60_000_u64 * 30).map(|k| ((k * 7919 + 13) % 10007) as f64 * 0.37 - 1000.0).collect();
    folder.write_npy("large.npy", &[60_000, 30], &rough);
    let weights: Vec<f64> = (0..m).map(|i| i as f64).collect();
    folder.write_npy("w.npy", &[m as u64], &weights);
    folder.write("w.csv", csv(&weights, 1));
    folder.succeed("ata a.csv -o a.mtx");
    folder.succeed("ata a.npy --accumulator a.sums");
    folder.succeed("ata a.csv --accumulator b.sums");
    folder.succeed("lstsq a.csv --by-column 7,0 --intercept --covariance -o fit.json");
    // What a run that failed at its last row leaves.
    let (m, n) = (800, 300);
    let mut broken = table(m, n);
    broken[m * n - 1] = f64::INFINITY;
    folder.write_npy("broken.npy", &[m as u64, n as u64], &broken);
    let run = folder.run(
        "ata broken.npy --require-finite -o c.npy --block-rows 100 --checkpoint a.part \
         --checkpoint-every 0",
    );
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(folder.path("a.part").exists());
}

fn meshes(folder: &Folder) {
    let write = |name: &str, mesh: TriMesh| {
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        io::write(output, &mesh.into()).unwrap();
    };
    for name in ["sphere.ply", "sphere.obj", "sphere.off", "sphere.stl", "sphere.ply.gz"] {
        write(name, families::icosphere(2).unwrap());
    }
    // Only its failing reads are tested.
    folder.write("sphere.ply.xz", "");
    write("torus.obj", families::torus(40, 20, 2.0, 0.8).unwrap());
    for (name, x, y) in [("left.off", 12, 8), ("right.off", 8, 10)] {
        let grid = families::grid(x, y).unwrap();
        let [_, far] = grid.bounding_box().unwrap();
        let sides = [0.1 * x as f64 / far[0], 0.1 * y as f64 / far[1]];
        let scaled = grid.vertices().iter().map(|p| [sides[0] * p[0], sides[1] * p[1], 0.0]);
        write(name, TriMesh::new(scaled.collect(), grid.faces().to_vec()).unwrap());
    }
    folder.write(
        "square.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
         f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    folder.write("samples.txt", "0\n400\n200\n600\n100\n700\n");
    folder.write("values.csv", "60\n120\n150\n");
    folder.write("pairs.txt", "0 0\n17 17\n60 60\n121 121\n");
    let vertices = families::icosphere(2).unwrap().vertices().len();
    folder.write("points.txt", (0..vertices).map(|i| format!("{i}\n")).collect::<String>());
    let f: Vec<f64> = (0..vertices).map(|i| (i as f64).sin()).collect();
    folder.write_npy("f.npy", &[vertices as u64, 1], &f);
}

/// Agents start everywhere.
fn mask(path: &Path) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), 32, 32);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = [255, 0, 0].repeat(32 * 32);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
}

#[test]
fn every_command_has_a_line() {
    let folder = Folder::new();
    let tested: BTreeSet<String> = LINES.iter().map(|line| command_of(line)).collect();
    let mut found = BTreeSet::new();
    for name in subcommands(&folder.succeed("--help")) {
        let parts = subcommands(&folder.succeed(&format!("{name} --help")));
        match parts.as_slice() {
            [] => drop(found.insert(name)),
            parts => found.extend(parts.iter().map(|part| format!("{name} {part}"))),
        }
    }
    assert!(found.len() > 15, "{found:?}");
    assert_eq!(found, tested, "commands of --help, and those of LINES");
}
