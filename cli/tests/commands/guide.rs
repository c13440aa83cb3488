//! The commands of README.md and of the pages of docs/guide that have no chapter of their own; and
//! the output that pages print below commands.

use std::fs;
use std::io::Read as _;
use std::path::Path;

use catamaran::io::{Output, Overwrite};
use catamaran_geometry::mesh::{TriMesh, families, io};

use crate::common::{Folder, calls, table};

/// A folder with everything that the pages read.
fn folder() -> Folder {
    let folder = Folder::new();
    for (name, m) in [("A.npy", 300), ("B.npy", 200)] {
        folder.write_npy(name, &[m as u64, 7], &table(m, 7));
    }
    let rows = table(40, 3);
    let lines: Vec<String> =
        rows.chunks(3).map(|row| format!("{},{},{}\n", row[0], row[1], row[2])).collect();
    folder.write("A.csv", lines.concat());
    folder.write("table.csv", format!("x,z,y\n{}", lines.concat()));
    let put = |name: &str, mesh: TriMesh| {
        let output = Output::create(&folder.path(name), Overwrite::Never).unwrap();
        io::write(output, &mesh.into()).unwrap();
    };
    put("scan.ply", families::torus(80, 40, 1.0, 0.4).unwrap());
    for (name, level) in [("a.ply", 2), ("b.ply", 3)] {
        put(name, families::icosphere(level).unwrap());
    }
    put("c.ply", families::torus(20, 12, 1.0, 0.5).unwrap());
    for (name, radius, factor) in
        [("ann1", 0.5, 0.8), ("ann2", 0.5, 1.2), ("bob1", 0.6, 0.8), ("bob2", 0.6, 1.2)]
    {
        let mesh = families::torus(20, 12, 2.0, radius).unwrap();
        let vertices = mesh.vertices().iter().map(|&[x, y, z]| [x, y, factor * z]).collect();
        put(&format!("{name}.ply"), TriMesh::new(vertices, mesh.faces().to_vec()).unwrap());
    }
    folder.write("labels.txt", "ann\nann\nbob\nbob\n");
    folder.write("rim.txt", "0\n40\n80\n");
    folder.write("face.txt", format!("{}{}", "1\n".repeat(1600), "9\n".repeat(1600)));
    put("top.ply", families::grid(16, 10).unwrap());
    put("bottom.ply", families::grid(10, 14).unwrap());
    folder
}

/// Runs the commands of a document, but those that need a device or take minutes.
fn run(document: &str) {
    let folder = folder();
    let is_left_out = |call: &str| {
        let first = ["unions dataset", "unions train", "unions tune"];
        call.contains("--device") || first.iter().any(|words| call.starts_with(words))
    };
    for call in calls(document).into_iter().filter(|call| !is_left_out(call)) {
        folder.succeed(call);
    }
}

#[test]
fn the_commands_of_the_readme_run() {
    run(include_str!("../../../README.md"));
}

#[test]
fn the_commands_of_the_pages_on_matrices_run() {
    run(include_str!("../../../docs/guide/ata.md"));
    run(include_str!("../../../docs/guide/tables.md"));
    run(include_str!("../../../docs/guide/larger-than-memory.md"));
    run(include_str!("../../../docs/guide/reproducibility.md"));
    run(include_str!("../../../docs/guide/performance.md"));
}

#[test]
fn the_commands_of_the_page_on_the_command_line_run() {
    run(include_str!("../../../docs/guide/command-line.md"));
}

#[test]
fn the_commands_of_the_page_on_decimation_run() {
    run(include_str!("../../../docs/guide/decimation.md"));
}

#[test]
fn the_commands_of_the_page_on_unions_run() {
    run(include_str!("../../../docs/guide/unions.md"));
}

/// The commands of the `console` blocks of a page, and the lines that it prints below each.
fn shown(page: &str) -> Vec<(&str, Vec<&str>)> {
    let blocks = page.split("```").skip(1).step_by(2);
    let lines = blocks.filter_map(|block| block.strip_prefix("console\n")).flat_map(str::lines);
    let mut found: Vec<(&str, Vec<&str>)> = vec![];
    for line in lines {
        match line.strip_prefix("$ catamaran ") {
            Some(call) => found.push((call, vec![])),
            None => found.last_mut().expect("a command comes first").1.push(line),
        }
    }
    found
}

/// Returns what a command prints to a terminal, with notes and errors in their places, and whether
/// it succeeds.
fn printed(folder: &Folder, call: &str) -> (String, bool) {
    let (mut reader, writer) = std::io::pipe().unwrap();
    let mut command = folder.program();
    command.args(call.split_whitespace());
    command.stdout(writer.try_clone().unwrap()).stderr(writer);
    let mut child = command.spawn().expect("the program starts");
    // It holds the ends of the pipe that are written to.
    drop(command);
    let mut text = String::new();
    reader.read_to_string(&mut text).unwrap();
    (text, child.wait().unwrap().success())
}

/// The words of a line that are the same on every machine: no times, speeds and threads, and not
/// the kernel of a plan.
fn words(line: &str) -> Vec<&str> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_unit = |word: &&str| {
        let word = word.trim_end_matches([',', ';']);
        ["us", "ms", "s", "effective", "thread", "threads"].contains(&word)
    };
    let is_kept = |at: &usize| {
        let is_measured = words[*at..].iter().take(2).any(is_unit);
        !is_measured && at.checked_sub(1).is_none_or(|before| words[before] != "by")
    };
    (0..words.len()).filter(is_kept).map(|at| words[at]).collect()
}

/// Returns whether two words are the same, or numbers that differ by rounding.
fn agree(a: &str, b: &str) -> bool {
    let marks = ['(', ')', '[', ']', ',', ';', ':', '%'];
    let number = |word: &str| word.trim_matches(marks).parse::<f64>();
    match (number(a), number(b)) {
        // A residual is nothing but rounding.
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-9 + 1e-6 * a.abs().max(b.abs()),
        _ => a == b,
    }
}

fn lines_agree(a: &str, b: &str) -> bool {
    let (a, b) = (words(a), words(b));
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| agree(a, b))
}

#[test]
fn commands_print_what_the_guide_shows() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/guide");
    let (mut count, mut wrong) = (0, String::new());
    for entry in fs::read_dir(guide).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "md") {
            continue;
        }
        let page = fs::read_to_string(&path).unwrap();
        let folder = Folder::new();
        folder.write("ata.csv", include_str!("../../../docs/guide/ata.csv"));
        folder.write("people.csv", include_str!("../../../docs/guide/people.csv"));
        for (call, shown) in shown(&page) {
            let (text, is_success) = printed(&folder, call);
            let lines: Vec<&str> = text.lines().collect();
            let agrees = lines.len() == shown.len()
                && lines.iter().zip(&shown).all(|(line, shown)| lines_agree(line, shown));
            if !agrees {
                wrong += &format!("{}: catamaran {call} prints\n{text}\n", path.display());
            }
            // An error is there to be seen.
            let is_error = shown.iter().any(|line| line.starts_with("catamaran: "));
            assert_eq!(is_success, !is_error, "{}: catamaran {call}", path.display());
            count += 1;
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    assert!(count > 10, "{count} commands");
}

#[test]
fn lines_that_differ_in_more_than_the_machine_do_not_agree() {
    let plan = "plan        direct, by avx512, 1 thread; --explain prints all of it";
    assert!(lines_agree(plan, &plan.replace("avx512, 1 thread", "portable, 2 threads")));
    assert!(!lines_agree(plan, &plan.replace("direct", "exact")));
    let read = "A           ata.csv: 5 x 3, f64, read in 873.9 us";
    assert!(lines_agree(read, &read.replace("873.9 us", "1.2 ms")));
    assert!(!lines_agree(read, &read.replace("5 x 3", "5 x 4")));
    assert!(lines_agree("1  1.999991887029939e0  9.1e-14", "1  1.999991887029944e0  6.5e-14"));
    assert!(!lines_agree("1  1.999991887029939e0", "1  1.999981887029939e0"));
}
