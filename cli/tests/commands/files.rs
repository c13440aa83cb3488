//! Files of commands: what readers and writers leave out is told, and outputs are whole.

use std::fs;

use crate::common::Folder;

/// A tetrahedron with a material and a texture, a statement of no format and a face of no area.
const ODD: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n$\nvt 0 0\nusemtl m\nf 1/1 3/1 2/1\n\
                   f 1/1 2/1 4/1\nf 2/1 3/1 4/1\nf 3/1 1/1 4/1\nf 1/1 1/1 2/1\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("odd.obj", ODD);
    folder
}

#[test]
fn what_readers_leave_out_is_noted_on_stderr() {
    let folder = folder();
    folder.write("odd.ply", ODD);
    let run = folder.run("mesh odd.ply");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for note in [
        "note: odd.ply: read as OBJ, the format of its content, and not as PLY",
        "note: odd.ply: skipped statements that are not of OBJ: 1, the first at line 5 (\"$\")",
        "note: odd.ply: left out triangles that have a vertex twice: 1, the first at line 12",
    ] {
        assert!(run.stderr.lines().any(|line| line == note), "{note}: {}", run.stderr);
    }
}

#[test]
fn what_formats_have_no_place_for_is_noted_on_stderr() {
    let folder = folder();
    let run = folder.run("mesh odd.obj -o odd.stl");
    let note = "note: odd.stl: this format can't store texture coordinates, materials";
    assert!(run.stderr.lines().any(|line| line == note), "{}", run.stderr);
    for kept in ["kept.obj", "kept.glb", "kept.gltf"] {
        let run = folder.run(&format!("mesh odd.obj -o {kept}"));
        assert!(!run.stderr.contains("can't store"), "{}", run.stderr);
        assert!(folder.succeed(&format!("mesh {kept}")).contains("texture coordinates"), "{kept}");
    }
}

#[test]
fn a_closed_pipe_ends_quietly_with_the_output_whole() {
    let folder = folder();
    for arguments in ["mesh odd.obj -o a.obj", "decimate odd.obj -n 4 -o a.obj --report"] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = folder.program();
        let run = command.args(arguments.split_whitespace()).stdout(writer).output().unwrap();
        let said = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(0), "{arguments}: {said}");
        assert!(!said.contains("catamaran:"), "{arguments}: {said}");
        let whole = fs::read_to_string(folder.path("a.obj")).expect(arguments);
        assert_eq!(whole.lines().filter(|line| line.starts_with("f ")).count(), 4, "{arguments}");
        fs::remove_file(folder.path("a.obj")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn force_writes_what_a_symbolic_link_leads_to() {
    let folder = folder();
    fs::create_dir(folder.path("there")).unwrap();
    folder.write("there/old.off", "old");
    for (link, target) in [("a.off", "there/old.off"), ("b.off", "there/new.off")] {
        std::os::unix::fs::symlink(target, folder.path(link)).unwrap();
        assert!(folder.fail(&format!("mesh odd.obj -o {link}")).contains("exists already"));
        folder.succeed(&format!("mesh odd.obj -o {link} --force"));
        assert!(folder.path(link).symlink_metadata().unwrap().is_symlink(), "{link}");
        assert!(fs::read_to_string(folder.path(target)).unwrap().starts_with("OFF\n4 4"));
    }
}

/// Each of these commands names an input that is not there: a command that had begun its work would
/// complain of that.
#[test]
fn places_that_can_not_be_written_are_refused_before_the_work() {
    let folder = folder();
    folder.write("file", "");
    for name in ["dir.npz", "out/water.csv", "out/plant-000.ply", "out/frame-0003.png"] {
        fs::create_dir_all(folder.path(name)).unwrap();
    }
    for (command, says) in [
        ("wilt none.txt -o file", "file: is not a folder"),
        ("wilt none.txt -o file/in/it", "file: is not a folder"),
        ("wilt none.txt --fit none.csv -o file", "file: is not a folder"),
        ("wilt none.txt -o out --force", "out/water.csv: is a directory"),
        ("wilt none.txt -o out", "out/water.csv: is a directory"),
        ("slime none.obj -o file/in", "file: is not a folder"),
        ("slime none.obj -o out --steps 3 --force", "out/frame-0003.png: is a directory"),
        ("slime none.obj -o new --coverage none/c.svg", "none/c.svg: can't be written"),
        ("curve none.obj --samples none.txt --cut file/", "file: is not a folder"),
        ("demo -o file --force", "file: is not a folder"),
        ("man -o file/man", "file: is not a folder"),
        ("unions dataset -o dir.npz --force", "dir.npz: is a directory"),
        ("unions train none.npz -o none/w.safetensors", "none/w.safetensors: can't be written"),
    ] {
        let message = folder.fail(command);
        assert!(message.contains(says), "{command}: {message}");
    }
    // A folder that was made for a command that fails goes away again.
    for command in ["wilt none.txt -o a/b", "slime none.obj -o a/b"] {
        assert!(folder.fail(command).contains("none."), "{command}");
    }
}

#[test]
fn no_file_has_two_purposes_of_which_one_destroys_the_other() {
    let folder = folder();
    folder.write("a.csv", "1,2\n3,4\n5,6\n");
    folder.write_npy("a.npy", &[3, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let checkpoint = "--checkpoint names a file that is also an input or a result";
    let results = "two results have this name";
    for (command, says) in [
        ("ata a.npy --checkpoint a.npy -o c.npy --force", checkpoint),
        ("ata a.csv --checkpoint ./a.csv -o c.npy --force", checkpoint),
        ("ata a.npy --checkpoint c.npy -o c.npy", checkpoint),
        ("ata a.npy --checkpoint c.png -o c.npy --picture c.png", checkpoint),
        ("ata a.npy --checkpoint c.sums --accumulator c.sums", checkpoint),
        ("lstsq a.npy --by-column 0 --checkpoint a.npy -o c.npz --force", checkpoint),
        ("pca a.npy --checkpoint c.npz -o c.npz", checkpoint),
        ("svd a.npy --checkpoint c.npz -o c.npz", checkpoint),
        ("shapedna odd.obj odd.obj -k 3 --distances c.csv --signatures c.csv --force", results),
        ("newton --size 32 -o c.png --heights c.png --force", results),
    ] {
        let message = folder.fail(command);
        assert!(message.contains(says), "{command}: {message}");
        for input in ["a.csv", "a.npy", "odd.obj"] {
            assert!(folder.path(input).exists(), "{command}: {input}");
        }
        for result in ["c.npy", "c.npz", "c.csv", "c.png", "c.sums"] {
            assert!(!folder.path(result).exists(), "{command}: {result}");
        }
    }
}

#[test]
fn no_output_replaces_an_input_even_with_force() {
    let folder = folder();
    folder.write("f.csv", "1\n2\n3\n4\n");
    folder.write("w.csv", "1\n1\n1\n1\n");
    folder.write("samples.txt", "0\n1\n2\n");
    folder.write("s.toml", "");
    folder.write("mask.png", "mask");
    folder.write("p.txt", "plant");
    folder.write("m.svg", "weights");
    let files = folder.names();
    let contents = |folder: &Folder| -> Vec<Vec<u8>> {
        files.iter().map(|name| fs::read(folder.path(name)).unwrap()).collect()
    };
    let before = contents(&folder);
    fs::create_dir(folder.path("out")).unwrap();
    folder.write("out/water.csv", "plant");
    let here = folder.path("").canonicalize().unwrap();
    let here = here.file_name().unwrap().to_str().unwrap();
    for (command, input) in [
        ("slime odd.obj -o new --state odd.obj", "odd.obj"),
        ("slime odd.obj --config s.toml -o new --state ./s.toml", "s.toml"),
        ("slime odd.obj --mask mask.png -o new --render mask.png", "mask.png"),
        ("slime odd.obj -o new --coverage m.svg --mask m.svg", "m.svg"),
        ("mesh odd.obj -o odd.obj", "odd.obj"),
        ("mesh f.csv --compare odd.obj -o ../HERE/odd.obj", "odd.obj"),
        ("decimate odd.obj -n 4 -o odd.obj", "odd.obj"),
        ("farthest f.csv -n 2 -o f.npy --cells f.csv", "f.csv"),
        ("ata f.csv -o f.csv", "f.csv"),
        ("ata f.csv --weights w.csv -o w.csv", "w.csv"),
        ("ata f.csv --accumulator f.csv", "f.csv"),
        ("ata-merge f.csv w.csv --accumulator w.csv", "w.csv"),
        ("lstsq f.csv w.csv -o w.npz --weights w.npz", "w.npz"),
        ("pca f.csv --weights m.svg --picture m.svg", "m.svg"),
        ("filter odd.obj --low-pass 1 --functions f.csv -o f.csv", "f.csv"),
        ("transfer odd.obj odd.obj --identity --functions f.csv -o f.csv", "f.csv"),
        ("curve odd.obj --samples samples.txt --cut odd.obj", "odd.obj"),
        ("curve odd.obj --samples s.obj -o s.obj", "s.obj"),
        ("distance f.csv --from 0 -o f.csv", "f.csv"),
        ("shapedna odd.obj f.csv --signatures f.csv", "f.csv"),
        ("newton odd.obj -o odd.obj", "odd.obj"),
        ("unions train f.csv -o f.csv", "f.csv"),
        ("unions train m.svg -o m", "m.svg"),
        ("wilt out/water.csv -o out", "out/water.csv"),
    ] {
        let message = folder.fail(&format!("{} --force", command.replace("HERE", here)));
        let says = format!("{input}: is an input of this command, and can't also be an output");
        assert!(message.contains(&says), "{command}: {message}");
        assert_eq!(contents(&folder), before, "{command}");
    }
    // Without --force, too: the advice to give it would destroy the input.
    let message = folder.fail("mesh odd.obj -o odd.obj");
    assert!(message.contains("odd.obj: is an input") && !message.contains("--force"), "{message}");
}

#[cfg(unix)]
#[test]
fn no_output_replaces_an_input_by_a_link() {
    let folder = folder();
    fs::hard_link(folder.path("odd.obj"), folder.path("hard.obj")).unwrap();
    std::os::unix::fs::symlink("odd.obj", folder.path("soft.obj")).unwrap();
    for link in ["hard.obj", "soft.obj"] {
        for command in [format!("odd.obj -o {link}"), format!("{link} -o odd.obj")] {
            let message = folder.fail(&format!("mesh {command} --force"));
            assert!(message.contains("is an input of this command"), "{command}: {message}");
        }
        assert_eq!(fs::read_to_string(folder.path(link)).unwrap(), ODD, "{link}");
    }
}
