//! `catamaran demo` and `catamaran info`, from outside.

mod common;

use std::fs;

use common::Folder;

#[test]
fn info_names_version_cpu_and_back_ends() {
    let text = Folder::new().succeed("info");
    for part in [env!("CARGO_PKG_VERSION"), "cpu", "affinity mask", "gemm", "openblas"] {
        assert!(text.contains(part), "{part:?} in {text}");
    }
}

/// One run serves all questions: it is the slowest of the commands.
#[test]
fn demo_writes_a_page_whose_files_exist_and_replaces_only_its_own() {
    let folder = Folder::new();
    folder.succeed("demo --small --out page");
    let html = fs::read_to_string(folder.path("page/index.html")).unwrap();
    let mut references = 0;
    for attribute in ["src=\"", "href=\""] {
        for part in html.split(attribute).skip(1) {
            let name = part.split('"').next().unwrap();
            assert!(!name.contains("//"), "{name} is elsewhere");
            assert!(name.starts_with('#') || folder.path("page").join(name).is_file(), "{name}");
            references += 1;
        }
    }
    assert!(references > 0 && html.contains("<svg"));
    for scheme in ["auto", "classical", "ata2", "winograd", "rxtx", "kgp", "kgp3"] {
        assert!(html.contains(&format!("<code>{scheme}</code>")), "{scheme}");
    }
    assert!(!html.contains("failed"), "a scheme failed its check");
    // Nothing but the page and what it shows.
    assert_eq!(fs::read_dir(folder.path("page")).unwrap().count(), references + 1);

    fs::write(folder.path("page/index.html"), "<p>mine</p>").unwrap();
    let message = folder.fail("demo --out page");
    assert!(message.contains("page: holds files that are not of a demo"), "{message}");
    assert_eq!(fs::read_to_string(folder.path("page/index.html")).unwrap(), "<p>mine</p>");
}
