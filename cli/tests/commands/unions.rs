//! `catamaran unions`, from outside.

use std::fs;

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{TriMesh, families, io};

use crate::common::Folder;

/// A very small data set.
const SIZES: &str =
    "--size small --vertices 700 --known 2 --unknown 1 --others 0 --poses 1 --pairs 8";

/// A rectangle of these numbers of cells of side 0.1.
fn rectangle(folder: &Folder, name: &str, x: usize, y: usize) {
    let grid = families::grid(x, y).unwrap();
    let [_, far] = grid.bounding_box().unwrap();
    let sides = [0.1 * x as f64 / far[0], 0.1 * y as f64 / far[1]];
    let scaled = grid.vertices().iter().map(|p| [sides[0] * p[0], sides[1] * p[1], 0.0]);
    let mesh = TriMesh::new(scaled.collect(), grid.faces().to_vec()).unwrap();
    let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
    io::write(output, &mesh.into()).unwrap();
}

/// The columns of a table that `unions predict` wrote.
fn columns(text: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    (1..rows[0].len()).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
}

#[test]
fn predictions_are_printed_written_and_below_those_of_the_parts() {
    let folder = Folder::new();
    rectangle(&folder, "a.off", 16, 10);
    rectangle(&folder, "b.off", 10, 14);
    let said = folder.succeed("unions predict a.off b.off -o out.csv --picture out.png");
    assert!(said.contains("out-of-distribution score") && said.lines().count() >= 22, "{said}");
    let columns = columns(&fs::read_to_string(folder.path("out.csv")).unwrap());
    assert_eq!((columns.len(), columns[0].len()), (3, 20));
    // That of a rectangle of 1.6 x 1.
    let first = std::f64::consts::PI.powi(2) * (1.0 / 2.56 + 1.0);
    assert!((columns[0][0] / first - 1.0).abs() < 0.03);
    for i in 0..20 {
        assert!(columns[2][i] > 0.0 && columns[2][i] <= columns[0][i].min(columns[1][i]));
    }
    assert!(folder.fail("unions predict a.off b.off -o out.csv").contains("out.csv"));
    assert!(folder.fail("unions predict a.off none.off").contains("none.off"));
    folder.write(
        "small.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\n\
                               f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n",
    );
    let refused = folder.fail("unions predict a.off small.obj");
    assert!(refused.contains("small.obj: too few vertices: the 20 eigenvalues need"), "{refused}");
    assert!(folder.fail("unions predict a.off b.off --weights a.off").contains("a.off"));
}

#[test]
fn parts_may_be_point_clouds() {
    let folder = Folder::new();
    rectangle(&folder, "a.off", 32, 20);
    rectangle(&folder, "b.off", 20, 28);
    for name in ["a", "b"] {
        let mesh = fs::read_to_string(folder.path(&format!("{name}.off"))).unwrap();
        let mut lines = mesh.lines().skip(1);
        let counts = lines.next().unwrap().split_whitespace().next().unwrap().to_owned();
        let points = lines.take(counts.parse().unwrap()).map(|line| format!("{line}\n"));
        let text = format!("OFF\n{counts} 0 0\n{}", points.collect::<String>());
        folder.write(&format!("{name}-cloud.off"), text);
    }
    folder.succeed("unions predict a.off b.off -o meshes.csv");
    let run = folder.run("unions predict a-cloud.off b-cloud.off -o clouds.csv --picture none.png");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(!run.stderr.contains("in no face"), "{}", run.stderr);
    let [meshes, clouds] =
        ["meshes.csv", "clouds.csv"].map(|name| fs::read_to_string(folder.path(name)).unwrap());
    for (mesh, cloud) in columns(&meshes).iter().zip(columns(&clouds)) {
        for (x, y) in mesh.iter().zip(cloud) {
            assert!((y / x - 1.0).abs() < 0.05, "{y} of a cloud, {x} of the mesh");
        }
    }
}

#[test]
fn the_name_of_the_output_is_checked_before_any_input_is_read() {
    let folder = Folder::new();
    for (command, why) in [
        ("predict none.off none.off -o x.npy", "x.npy: the name must end in .csv"),
        ("predict none.off none.off -o x", "x: the name must end in .csv"),
        ("interpolate none.off none.off none.off -o x.txt", "x.txt: the name must end in .csv"),
        ("shape none.off --spectrum none.csv -o x.xyz", "x.xyz: unknown kind of mesh"),
        ("shape none.off --spectrum none.csv -o x.off.xz", "x.off.xz: .xz files can only be read"),
        // Too few vertices for a model, which an error would name if it came first.
        ("template --vertices 0 -o x.xyz", "x.xyz: unknown kind of mesh"),
        ("train none.npz -o x --architecture thesis", "x: "),
    ] {
        let said = folder.fail(&format!("unions {command}"));
        assert!(said.contains(why), "{command}: {said}");
    }
}

#[test]
fn options_are_judged_before_any_input_is_read() {
    let folder = Folder::new();
    for (command, why) in [
        ("predict none.off none.off --localize there.off", "there.off: no such file"),
        ("interpolate none.off none.off none.off --localize there.off", "there.off: no such file"),
        ("template --vertices 3 -o t.ply", "--vertices: must be from 500 to 1000000, is 3"),
        ("train none.npz -o x.safetensors --batch 0", "--batch: must be a multiple of 64 from 64"),
        (
            "train none.npz -o x.safetensors --batch 100",
            "a multiple of 64 from 64 to 65536, is 100",
        ),
        ("train none.npz -o x.safetensors --layers 65,1", "--layers: must be from 0 to 64, is 65"),
        ("train none.npz -o x.safetensors --rate nan", "--rate: must be finite and at least 0"),
        ("tune none.off none.off -o x.safetensors --rate=-1", "--rate: must be finite and at"),
    ] {
        let said = folder.fail(&format!("unions {command}"));
        assert!(said.contains(why), "{command}: {said}");
    }
    for option in ["--pairs", "--epochs"] {
        let run = folder.run(&format!("unions tune none.off none.off -o x.safetensors {option} 0"));
        assert_eq!(run.code, Some(2), "{option}: {}", run.stderr);
        let says = format!("for '{option} <NUMBER>': expected a whole number of at least 1");
        assert!(run.stderr.contains(&says), "{}", run.stderr);
    }
    for option in ["--epochs 0", "--minutes=-1", "--identities 0"] {
        let run = folder.run(&format!("unions train none.npz -o x.safetensors {option}"));
        assert_eq!(run.code, Some(2), "{option}: {}", run.stderr);
    }
}

#[test]
fn a_template_is_deformed_to_a_predicted_spectrum() {
    let folder = Folder::new();
    rectangle(&folder, "a.off", 16, 10);
    rectangle(&folder, "b.off", 10, 14);
    rectangle(&folder, "template.off", 15, 15);
    folder.succeed("unions predict a.off b.off -o spectra.csv");
    for tolerance in ["nan", "-1"] {
        let command = "unions shape template.off --spectrum spectra.csv -k 8 -o no.off --tolerance";
        let message = folder.fail(&format!("{command}={tolerance}"));
        assert!(message.contains("tolerance"), "{message}");
    }
    let said = folder.fail("unions shape template.off --spectrum spectra.csv -k 21 -o no.off");
    assert!(said.contains("spectra.csv: -k 21, but the table has 20 eigenvalues"), "{said}");
    let deform = "unions shape template.off --spectrum spectra.csv -k 8 --tolerance 0.01 -o";
    let said = folder.succeed(&format!("{deform} union.ply --picture union.png"));
    let error = said.lines().find_map(|line| line.strip_prefix("error")).unwrap();
    let percent: f64 = error.split_whitespace().next().unwrap().parse().unwrap();
    assert!(percent <= 1.0, "{said}");
    folder.succeed(&format!("{deform} again.ply --threads 1"));
    let [one, other] = ["union.ply", "again.ply"].map(|name| fs::read(folder.path(name)).unwrap());
    assert!(one == other);
    assert!(folder.fail(&format!("{deform} union.ply")).contains("union.ply"));
}

#[test]
fn what_is_wrong_with_a_spectrum_is_said_of_its_file() {
    let folder = Folder::new();
    rectangle(&folder, "template.off", 5, 5);
    let rows: String = (1..=50).map(|i| format!("{i}\n")).collect();
    for (table, why) in [
        ("number,value\n1,3.0\n2,1.0\n", "must ascend, but number 1 (from 0), 1e0, follows 3e0"),
        ("1,3.0\n2,nan\n", "column 2: \"nan\" where a number should be"),
        ("-3\n1\n", "eigenvalues: must be positive, but the first one is -3e0"),
        ("0\n1\n", "the first one is 0e0: leave zeros out"),
        ("1e300\n2e300\n", "eigenvalues: are out of range"),
        ("one\ntwo\n", "no column of numbers: column one has words, such as \"two\""),
        (rows.as_str(), "must be at most the 16 that the template has, are 50"),
    ] {
        folder.write("wrong.csv", table);
        let said = folder.fail("unions shape template.off --spectrum wrong.csv -o x.ply");
        assert!(said.starts_with("catamaran: wrong.csv:") && said.contains(why), "{table}: {said}");
    }
}

/// Writes a closed body, and two open parts of it that overlap: `NAME.off`, `NAME-low.off` and
/// `NAME-high.off`.
fn body_and_parts(folder: &Folder, name: &str, body: &TriMesh) {
    let [low, high] = body.bounding_box().unwrap();
    let height = |f: &[u32; 3]| {
        let z = f.iter().map(|&v| body.vertices()[v as usize][2]).sum::<f64>() / 3.0;
        (z - low[2]) / (high[2] - low[2])
    };
    let part = |inside: &dyn Fn(f64) -> bool| {
        let faces = (0..).zip(body.faces()).filter(|(_, f)| inside(height(f)));
        body.submesh(&faces.map(|(f, _)| f).collect::<Vec<u32>>()).unwrap().mesh
    };
    for (end, mesh) in
        [("", body.clone()), ("-low", part(&|z| z < 0.65)), ("-high", part(&|z| z > 0.35))]
    {
        let path = folder.path(&format!("{name}{end}.off"));
        io::write(Output::create(&path, Overwrite::Never).unwrap(), &mesh.into()).unwrap();
    }
}

#[test]
fn the_pipe_from_prediction_to_shape_works_on_closed_bodies() {
    let folder = Folder::new();
    let stretched = |mesh: TriMesh, by: f64| {
        let (points, faces) = mesh.into_parts();
        TriMesh::new(points.iter().map(|p| [p[0], p[1], by * p[2]]).collect(), faces).unwrap()
    };
    for (name, body) in [
        ("ball", families::icosphere(3).unwrap()),
        ("egg", stretched(families::icosphere(3).unwrap(), 2.0)),
        ("figure", families::figure(2, 0.2).unwrap()),
    ] {
        body_and_parts(&folder, name, &body);
        folder.succeed(&format!("unions predict {name}-low.off {name}-high.off -o {name}.csv"));
        let shape = format!("unions shape {name}.off --spectrum {name}.csv -o {name}-found.off");
        let run = folder.run(&shape);
        assert_eq!(run.code, Some(0), "{name}: {}", run.stderr);
        assert!(run.stdout.contains("mean relative difference"), "{}", run.stdout);
        assert!(run.stderr.contains(&format!("{name}.off is closed")), "{}", run.stderr);
        let found = io::read(&folder.path(&format!("{name}-found.off"))).unwrap().mesh;
        assert_eq!(found.faces(), body.faces());
        assert!(found.faces_without_area().is_empty());
    }
}

#[test]
fn the_score_is_not_sold_as_accuracy() {
    let folder = Folder::new();
    // Half a ball twice: a prediction that is wrong, for a score that may be low or high.
    body_and_parts(&folder, "ball", &families::icosphere(3).unwrap());
    rectangle(&folder, "a.off", 16, 10);
    for parts in ["ball-low.off ball-high.off", "a.off a.off", "a.off ball-low.off"] {
        let said = folder.succeed(&format!("unions predict {parts}"));
        let line = said.lines().find(|line| line.contains("out-of-distribution score")).unwrap();
        assert!(line.contains("99.5 % of the training pairs"), "{line}");
        let says = ["prediction is a guess", "error of the prediction is unknown"];
        assert!(says.iter().any(|what| line.contains(what)), "{line}");
        assert!(!line.contains("like the training"), "{line}");
    }
}

#[test]
fn unions_with_spectra_in_between_begin_and_end_with_those_of_the_parts() {
    let folder = Folder::new();
    rectangle(&folder, "a.off", 16, 10);
    rectangle(&folder, "b.off", 10, 14);
    rectangle(&folder, "c.off", 12, 12);
    folder.succeed("unions template -o template.ply");
    let said = folder.succeed(
        "unions interpolate a.off b.off c.off --steps 3 -o out.csv --localize template.ply \
         --picture out.png",
    );
    assert_eq!(said.matches("out-of-distribution score").count(), 3, "{said}");
    let unions = columns(&fs::read_to_string(folder.path("out.csv")).unwrap());
    for (part, union) in [("a", &unions[0]), ("b", &unions[2])] {
        folder.succeed(&format!("unions predict {part}.off c.off -o {part}.csv"));
        let text = fs::read_to_string(folder.path(&format!("{part}.csv"))).unwrap();
        assert_eq!(columns(&text)[2], *union);
    }
    assert_eq!(unions.len(), 3);
    let refused = folder.fail("unions interpolate a.off b.off c.off -o out.csv");
    assert!(refused.contains("out.csv"), "{refused}");
    let refused = folder.fail("unions interpolate a.off b.off c.off --picture p.png");
    assert!(refused.contains("--localize"), "{refused}");
    let sphere = Output::create(&folder.path("closed.off"), Overwrite::Never).unwrap();
    io::write(sphere, &families::icosphere(2).unwrap().into()).unwrap();
    let refused = folder.fail("unions predict a.off closed.off");
    assert!(refused.contains("closed.off: a component is closed"), "{refused}");
    // The half ball has a boundary; the ball beside it has none.
    let ball = families::icosphere(3).unwrap().into_parts().0;
    let half = ball.iter().filter(|p| p[2] > 0.0).map(|p| [p[0] + 3.0, p[1], p[2]]);
    let points: Vec<[f64; 3]> = ball.iter().copied().chain(half).collect();
    let text: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    folder.write("cloud.off", format!("OFF\n{} 0 0\n{text}", points.len()));
    let refused = folder.fail("unions predict a.off cloud.off");
    assert!(refused.contains("cloud.off: points: a component has no boundary"), "{refused}");
}

#[test]
fn meshes_that_give_no_pairs_are_counted_and_the_first_is_named() {
    let folder = Folder::new();
    for name in ["a.off", "b.off"] {
        folder.write(
            name,
            "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
        );
    }
    let said = folder.fail("unions tune a.off b.off -o x.safetensors --pairs 6 --epochs 1");
    let note = "note: a.off: no pair of parts could be cut; of 2 meshes, 2 give none\n";
    assert!(said.contains(note) && said.contains("too few pairs of parts"), "{said}");
}

#[test]
#[ignore = "trains: scripts/test --training"]
fn weights_are_fitted_to_a_few_meshes() {
    let folder = Folder::new();
    let meshes: Vec<String> = (0..4).map(|i| format!("figure{i}.off")).collect();
    for (i, name) in meshes.iter().enumerate() {
        let mesh = families::figure(3, 0.2 * i as f64).unwrap();
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        io::write(output, &mesh.into()).unwrap();
    }
    let tune = format!("unions tune {} --pairs 12 --epochs 2 --threads", meshes.join(" "));
    let said = folder.succeed(&format!("{tune} 2 -o own.safetensors"));
    let error = |line: &str| -> f64 {
        let line = said.lines().find_map(|own| own.strip_prefix(line)).unwrap();
        line.split_whitespace().nth(2).unwrap().parse().unwrap()
    };
    assert!(error("after") < error("before"), "{said}");
    folder.succeed(&format!("{tune} 1 -o again.safetensors"));
    let [one, other] =
        ["own", "again"].map(|name| fs::read(folder.path(&format!("{name}.safetensors"))).unwrap());
    assert!(one == other);
    rectangle(&folder, "a.off", 16, 10);
    folder.succeed("unions predict a.off a.off --weights own.safetensors");
    let refused = folder.fail("unions tune figure0.off none.off -o x.safetensors");
    assert!(refused.contains("none.off"), "{refused}");
}

#[test]
#[ignore = "trains: scripts/test --training"]
fn a_network_is_trained_and_used() {
    let folder = Folder::new();
    folder.succeed(&format!("unions dataset -o data.npz {SIZES}"));
    let train = "unions train data.npz -o own.safetensors --width 16 --hidden 16 --threads";
    folder.succeed(&format!("{train} 1 --epochs 3 --minutes 0"));
    for file in ["own.safetensors", "own.safetensors.state.npz", "own.safetensors.svg"] {
        assert!(folder.path(file).exists(), "{file}");
    }
    assert!(folder.fail(&format!("{train} 1 --epochs 3")).contains("--resume"));
    folder.succeed(&format!("{train} 2 --resume"));
    let resumed = fs::read(folder.path("own.safetensors")).unwrap();
    folder.succeed(&format!("{train} 2 --epochs 3 --force"));
    assert_eq!(fs::read(folder.path("own.safetensors")).unwrap(), resumed);

    #[cfg(unix)]
    ends_soon(&folder, "unions train data.npz -o other.safetensors --epochs 1000000");

    rectangle(&folder, "a.off", 16, 10);
    rectangle(&folder, "b.off", 10, 14);
    let ours = folder.succeed("unions predict a.off b.off --weights own.safetensors");
    assert_ne!(ours, folder.succeed("unions predict a.off b.off"));

    folder.succeed("unions template --vertices 700 -o template.ply");
    let predict = "unions predict a.off b.off --weights own.safetensors --localize";
    let found = folder.succeed(&format!("{predict} template.ply"));
    assert!(found.contains("vertices of the template"), "{found}");
    // The template of the weights is not the rectangle.
    let refused = folder.fail(&format!("{predict} a.off"));
    assert!(refused.contains("a.off"), "{refused}");
}

/// Sends SIGTERM to a command that has said something.
#[cfg(unix)]
fn ends_soon(folder: &Folder, arguments: &str) {
    use std::io::Read;
    use std::process::{Command, Stdio};
    let mut command = folder.program();
    command.args(arguments.split_whitespace()).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdout.as_mut().unwrap().read_exact(&mut [0]).unwrap();
    let start = std::time::Instant::now();
    assert!(Command::new("kill").arg(child.id().to_string()).status().unwrap().success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(143), "{arguments}");
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
    assert!(folder.names().iter().all(|name| !name.starts_with(".catamaran-")));
}
