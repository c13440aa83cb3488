//! `catamaran demo` and `catamaran info`, from outside.

mod common;

use std::fs;

use catamaran::kernel::int8::Instance;
use common::Folder;

#[test]
fn info_names_version_cpu_back_ends_and_instances_of_the_exact_path() {
    let text = Folder::new().succeed("info");
    for part in [env!("CARGO_PKG_VERSION"), "cpu", "affinity mask", "gemm", "openblas"] {
        assert!(text.contains(part), "{part:?} in {text}");
    }
    let start = text.find("exact path").expect("a block");
    let block: Vec<&str> = text[start..].lines().map(|line| line[14..].trim()).collect();
    for (line, instance) in block.iter().zip(Instance::ALL) {
        let state = line.strip_prefix(&format!("{}: ", instance.name())).expect("its line");
        match instance.refusal() {
            Some(why) => assert_eq!(state, why),
            None if instance == Instance::best() => assert_eq!(state, "used"),
            None => assert_eq!(state, "available"),
        }
    }
    assert_eq!(block.len(), Instance::ALL.len(), "{text}");
}

/// One run serves all questions: it is the slowest of the commands.
#[test]
fn demo_writes_a_page_whose_files_exist_and_replaces_only_its_own() {
    let folder = Folder::new();
    folder.succeed("demo --small --out page");
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
    // No other order of the work changes a byte of the exact product; one does of the classical one.
    let shuffled = html.split("rows of A shuffled</td>").nth(1).expect("a row of the table");
    let mut cells = shuffled.split("<td>").skip(1).map(|cell| cell.split("</td>").next().unwrap());
    assert_ne!(cells.next(), Some("0"));
    assert_eq!(cells.next(), Some("0"));
    // Nothing but the page and what it shows.
    assert_eq!(fs::read_dir(folder.path("page")).unwrap().count(), files + 1);

    fs::write(folder.path("page/index.html"), "<p>mine</p>").unwrap();
    let message = folder.fail("demo --out page");
    assert!(message.contains("page: holds files that are not of a demo"), "{message}");
    assert_eq!(fs::read_to_string(folder.path("page/index.html")).unwrap(), "<p>mine</p>");
}
