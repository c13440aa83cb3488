//! `catamaran demo` and `catamaran info`, from outside.

use std::fs;
use std::process::Command;

use catamaran::kernel::{int8, packed};

use crate::common::{Folder, Run, with_input};

#[test]
fn info_names_version_cpu_libraries_back_ends_and_instances() {
    let text = Folder::new().succeed("info");
    assert!(text.contains(env!("CARGO_PKG_VERSION")), "{text}");
    for part in ["cpu", "affinity mask", "native", "openblas", "\nMPI  ", "\nHDF5  "] {
        assert!(text.contains(part), "{part:?} in {text}");
    }
    let state = |refusal: Option<&'static str>, best| {
        refusal.unwrap_or(if best { "used" } else { "available" })
    };
    let best = packed::FloatIsa::best();
    let native =
        packed::FloatIsa::ALL.map(|i| format!("{}: {}", i.name(), state(i.refusal(), i == best)));
    assert_eq!(block(&text, "native path"), native);
    let best = int8::IntegerIsa::best();
    let exact =
        int8::IntegerIsa::ALL.map(|i| format!("{}: {}", i.name(), state(i.refusal(), i == best)));
    assert_eq!(block(&text, "exact path"), exact);
    for line in block(&text, "rates") {
        assert!(line.ends_with("built in (`catamaran tune` measures them)"), "{line}");
    }
}

#[test]
fn the_long_version_says_how_the_program_is_built_as_info_does() {
    let folder = Folder::new();
    let version = concat!("catamaran ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(folder.succeed("-V"), version);
    let long = folder.succeed("--version");
    let lines = long.strip_prefix(version).unwrap();
    let labels: Vec<_> = lines.lines().map(|line| line[..14].trim_end()).collect();
    assert_eq!(labels, ["commit", "features", "MPI", "HDF5"]);
    let info = folder.succeed("info");
    assert!(info.contains(&format!("\n{lines}")), "{info}");
    let has = |feature: &str| block(&long, "features")[0].split(' ').any(|name| name == feature);
    assert_eq!(has("mpi"), cfg!(feature = "mpi"), "{long}");
    assert_eq!(has("columnar"), cfg!(feature = "columnar"), "{long}");
}

#[test]
fn the_commit_is_that_of_the_repository() {
    let mut git = Command::new("git");
    git.args(["rev-parse", "--show-prefix", "HEAD"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let text = git.output().map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    let version = Folder::new().succeed("--version");
    let commit = block(&version, "commit")[0];
    match text.unwrap_or_default().split_once('\n') {
        Some(("cli/", head)) => {
            assert_eq!(commit.len(), 12, "{version}");
            assert!(head.starts_with(commit), "{version}");
        }
        _ => assert_eq!(commit, "unknown"),
    }
}

#[test]
fn the_limit_on_instruction_sets_is_shown_and_kept_and_a_wrong_one_is_an_error() {
    let folder = Folder::new();
    let run = |isa: &str, arguments: &[&str]| {
        let output = folder.program().env("CATAMARAN_ISA", isa).args(arguments).output().unwrap();
        Run::new(output)
    };
    let text = run("portable", &["info"]).stdout;
    assert_eq!(block(&text, "limit"), ["portable (CATAMARAN_ISA)"]);
    for label in ["native path", "exact path"] {
        assert_eq!(block(&text, label).last(), Some(&"portable: used"), "{text}");
        assert!(block(&text, label)[0].contains("CATAMARAN_ISA"), "{text}");
    }
    assert_eq!(block(&run("", &["info"]).stdout, "limit"), ["none (CATAMARAN_ISA)"]);
    folder.write("a.csv", "1,2\n3,4\n");
    for arguments in [&["info"][..], &["ata", "a.csv", "-o", "c.npy"]] {
        let refused = run("avx3", arguments);
        assert_eq!(refused.code, Some(1), "{}", refused.stderr);
        let what = "CATAMARAN_ISA: must be portable, neon, dotprod, i8mm, avx2, avxvnni, avx512, \
            vnni or amx, not \"avx3\"";
        assert!(refused.stderr.contains(what), "{}", refused.stderr);
    }
    assert!(!folder.path("c.npy").exists());
}

#[test]
fn reproducible_products_have_the_same_bytes_at_every_level() {
    let (folder, _) = with_input(400, 150);
    let bytes = ["portable", "avx2", "avxvnni", "avx512", "vnni", "amx"].map(|isa| {
        let c = format!("{isa}.npy");
        let arguments = ["ata", "a.npy", "-o", &c, "--reproducible"];
        let output = folder.program().env("CATAMARAN_ISA", isa).args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read(folder.path(&c)).unwrap()
    });
    assert!(bytes.iter().all(|b| *b == bytes[0]));
}

/// The line with this label and those without one after it, less the labels.
fn block<'a>(text: &'a str, label: &str) -> Vec<&'a str> {
    let mut lines = text.lines().skip_while(|line| !line.starts_with(label));
    let first = lines.next().expect("a block");
    let rest = lines.take_while(|line| line.starts_with(' '));
    std::iter::once(first).chain(rest).map(|line| line[14..].trim()).collect()
}

/// One run serves all checks, because this is the slowest of the commands.
#[test]
fn demo_writes_a_page_whose_files_exist_and_replaces_only_its_own() {
    let folder = Folder::new();
    folder.succeed("demo --small -o page");
    let html = fs::read_to_string(folder.path("page/index.html")).unwrap();
    let mut files = 0;
    for attribute in ["src=\"", "href=\""] {
        for part in html.split(attribute).skip(1) {
            let name = part.split('"').next().unwrap();
            assert!(!name.contains("//"), "{name} is elsewhere");
            match name.strip_prefix('#') {
                Some(id) => assert!(html.contains(&format!("id=\"{id}\"")), "{name}"),
                None => {
                    assert!(folder.path("page").join(name).is_file(), "{name}");
                    files += 1;
                }
            }
        }
    }
    assert!(files > 0 && html.contains("<svg"));
    for scheme in ["auto", "classical", "ata2", "winograd", "rxtx", "kgp", "kgp3", "exact"] {
        assert!(html.contains(&format!("<code>{scheme}</code>")), "{scheme}");
    }
    assert!(!html.contains("failed"), "a scheme failed its check");
    let left = html.split("water left after 48 hours</dt><dd>").nth(1).expect("a number");
    let left = left.split(' ').next().unwrap_or_default();
    assert!(left.parse::<f64>().unwrap() < 80.0, "the plant does not wilt: {left} %");
    // No other order of the work changes a byte of the exact product; one does of the classical
    // one.
    let shuffled = html.split("rows of A shuffled</td>").nth(1).expect("a row of the table");
    let mut cells = shuffled.split("<td>").skip(1).map(|cell| cell.split("</td>").next().unwrap());
    assert_ne!(cells.next(), Some("0"));
    assert_eq!(cells.next(), Some("0"));
    // Nothing but the page and what it shows.
    assert_eq!(fs::read_dir(folder.path("page")).unwrap().count(), files + 1);

    fs::write(folder.path("page/index.html"), "<p>mine</p>").unwrap();
    let message = folder.fail("demo -o page");
    assert!(message.contains("page: holds files that are not of a demo"), "{message}");
    assert_eq!(fs::read_to_string(folder.path("page/index.html")).unwrap(), "<p>mine</p>");
}
