//! Tables as people have them: the options of all commands that read matrices, and what they say.

use std::io::Write;
use std::process::Stdio;

use crate::common::Folder;

/// What `ata` computes of `[[1, 2], [3, 5], [4, 4]]`.
const C: [f64; 4] = [26.0, 33.0, 33.0, 45.0];

#[test]
fn options_decide_what_a_file_leaves_open_in_every_command() {
    let folder = Folder::new();
    folder.write("names.csv", "400,410\n0.10,0.20\n0.11,0.25\n0.15,0.10\n");
    folder
        .write("quoted.csv", "x,y\n\"10,000\",\"5,500\"\n\"12,500\",\"6,100\"\n\"9,750\",\"4\"\n");
    folder.write("missing.csv", "x,y\n1,2\nNA,3\n4,5\n6,9\n");
    for (file, asked, decides) in [
        ("names.csv", "--header or --no-header", "--no-header"),
        ("quoted.csv", "--decimal or --thousands", "--thousands comma"),
        ("missing.csv", "--missing drop", "--missing drop"),
    ] {
        for command in ["ata FILE", "lstsq FILE --by-column 1", "pca FILE", "svd FILE"] {
            let command = command.replace("FILE", file);
            let said = folder.fail(&command);
            assert!(said.contains(&format!("{file}:")) && said.contains(asked), "{said}");
            folder.succeed(&format!("{command} {decides}"));
        }
    }
}

#[test]
fn columns_are_names_numbers_ranges_or_lists_of_every_format() {
    let folder = Folder::new();
    folder.write("a.csv", "id,x,y,z\nu,9,1,2\nv,8,3,5\nw,7,4,4\n");
    for columns in ["y,z", "2..4", "2,z"] {
        folder.succeed(&format!("ata a.csv --columns {columns} -o c.npy --force"));
        assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), C, "{columns}");
    }
    let said = folder.fail("ata a.csv --columns id,y");
    assert!(said.contains("a.csv:2: column id has words, such as \"u\""), "{said}");
    let said = folder.fail("ata a.csv --columns q");
    assert!(said.contains("a.csv: columns: no column q; the columns are id, x, y, z"), "{said}");
    folder.write("b.csv", "5,1,2\n6,3,5\n7,4,4\n");
    folder.write_npy("b.npy", &[3, 3], &[5.0, 1.0, 2.0, 6.0, 3.0, 5.0, 7.0, 4.0, 4.0]);
    for file in ["b.csv", "b.npy"] {
        folder.succeed(&format!("ata {file} --columns 2,1 -o c.npy --force"));
        assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), [45.0, 33.0, 33.0, 26.0], "{file}");
    }
}

#[test]
fn what_was_decided_is_said_once() {
    let folder = Folder::new();
    folder.write("a.csv", "ort;x;y\nUlm;1,0;2\nBonn;3,0;5\nKiel;4,0;4\n");
    let run = folder.run("ata a.csv -o c.npy");
    let said = "note: a.csv: separator ;, decimal comma, header, 1 text column left out (ort)\n";
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), said));
    assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), C);
    let said = folder.succeed("--json ata a.csv -o c.npy --force");
    assert!(said.contains(r#""record":"table","path":"a.csv","separator":";""#), "{said}");
    folder.write("b.csv", "x,y\n1,2\n3,5\n4,4\n");
    assert_eq!(folder.run("ata b.csv").stderr, "");
    // Numbers are those of the file, also where columns are left out.
    let said = folder.succeed("lstsq a.csv --by-column 2");
    assert!(said.lines().any(|line| line.starts_with("x ")), "{said}");
}

#[test]
fn stdin_and_files_without_an_ending_are_read_by_their_content() {
    let folder = Folder::new();
    folder.write("table", "1 2\n3 5\n4 4\n");
    folder.write("a.csv", "1,2\n3,5\n4,4\n");
    folder.succeed("ata table -o c.npy");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), C);
    folder.succeed("ata a.csv --format table --separator comma -o c.npy --force");
    if cfg!(unix) {
        let mut command = folder.program();
        command.args(["ata", "-", "-o", "d.npy"]).stdin(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(b"1;2\n3;5\n4;4\n").unwrap();
        assert!(child.wait().unwrap().success());
        assert_eq!(folder.read_npy::<f64>("d.npy", &[2; 2]), C);
    }
}
