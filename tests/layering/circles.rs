//! No file imports itself by way of others, and no room does.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::modules::{Arrow, Modules};

/// The folders of the crates.
const CRATES: [&str; 4] = ["src", "geometry/src", "simulation/src", "capi/src"];

/// For each file, those that it imports, or that these import, and so on.
fn reach(arrows: &[Arrow]) -> BTreeMap<&Path, BTreeSet<&Path>> {
    let mut direct: BTreeMap<&Path, Vec<&Path>> = BTreeMap::new();
    for arrow in arrows {
        direct.entry(&arrow.from).or_default().push(&arrow.to);
    }
    let mut reach = BTreeMap::new();
    for &from in direct.keys() {
        let (mut found, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(file) = open.pop() {
            open.extend(direct.get(file).into_iter().flatten().filter(|&&to| found.insert(to)));
        }
        reach.insert(from, found);
    }
    reach
}

/// The strongly connected components of two files or more, each with the imports inside it.
fn circles(arrows: &[Arrow]) -> Vec<(BTreeSet<&Path>, Vec<&Arrow>)> {
    let reach = reach(arrows);
    let reaches = |a: &Path, b: &Path| reach.get(a).is_some_and(|r| r.contains(b));
    let mut found: BTreeMap<BTreeSet<&Path>, Vec<&Arrow>> = BTreeMap::new();
    for arrow in arrows.iter().filter(|a| reaches(&a.to, &a.from)) {
        let circle = reach[arrow.from.as_path()].iter().copied();
        let circle = circle.filter(|file| reaches(file, &arrow.from)).collect();
        found.entry(circle).or_default().push(arrow);
    }
    found.into_iter().collect()
}

/// The room of a file: the folder of `src` that it is in, or the file itself.
fn room(file: &Path) -> PathBuf {
    file.components().take(1).collect()
}

/// The imports between rooms; `lib.rs`, which hands on what they offer, is none.
fn between_rooms(arrows: &[Arrow]) -> Vec<Arrow> {
    let root = Path::new("lib.rs");
    let rooms = arrows.iter().map(|a| Arrow { from: room(&a.from), to: room(&a.to), ..a.clone() });
    rooms.filter(|a| a.from != a.to && a.from != root && a.to != root).collect()
}

fn report((files, arrows): &(BTreeSet<&Path>, Vec<&Arrow>)) -> String {
    let mut text = format!("\n{} files import in a circle:\n", files.len());
    for arrow in arrows {
        let (from, to) = (arrow.from.display(), arrow.to.display());
        text += &format!("  {from}:{} -> {to}: {}\n", arrow.line, arrow.path);
    }
    text
}

#[test]
fn no_file_and_no_room_imports_itself_by_way_of_others() {
    for folder in CRATES {
        let src = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let arrows = Modules::read(&src).arrows();
        let rooms = between_rooms(&arrows);
        let wrong: String = circles(&arrows).iter().chain(&circles(&rooms)).map(report).collect();
        assert!(wrong.is_empty(), "{folder}:{wrong}");
    }
}

#[test]
fn a_circle_of_rooms_is_found_without_one_of_files() {
    let there = [("lib.rs", "mod a; mod b;"), ("a.rs", "mod x; mod y;"), ("b.rs", "mod x; mod y;")];
    let back = |text| {
        let files = [("a/x.rs", "use crate::b::x::B; pub struct A;"), ("b/x.rs", "pub struct B;")];
        let files = files.into_iter().chain([("a/y.rs", "pub struct A;"), ("b/y.rs", text)]);
        Modules::from_texts(&there.into_iter().chain(files).collect::<Vec<_>>()).arrows()
    };
    for (text, count) in [("use crate::a::y::A;", 1), ("use crate::b::x::B;", 0)] {
        let arrows = back(text);
        assert_eq!((circles(&arrows).len(), circles(&between_rooms(&arrows)).len()), (0, count));
    }
}

/// The circles of a crate of these files.
fn planted(files: &[(&str, &str)]) -> Vec<Vec<PathBuf>> {
    let arrows = Modules::from_texts(files).arrows();
    let circles = circles(&arrows);
    circles.iter().map(|c| c.0.iter().map(|&file| file.to_owned()).collect()).collect()
}

#[test]
fn a_planted_circle_is_found_however_it_is_imported() {
    let lib = ("lib.rs", "mod room;");
    let facade = "mod a; mod b; mod c; pub use a::A; pub(crate) use b::{B as Other}; use c::C;";
    let circle = |a: &str, b: &str| {
        let facade = ("room/mod.rs", facade);
        let files =
            [lib, facade, ("room/a.rs", a), ("room/b.rs", b), ("room/c.rs", "pub struct C;")];
        planted(&files)
    };
    let back = "use crate::{base::Real, room::{a::{helper, A}}}; pub struct B(A);";
    let both: Vec<Vec<PathBuf>> = vec![vec!["room/a.rs".into(), "room/b.rs".into()]];
    for import in [
        "use super::b::B;",
        "use super::{c::C, b::{self, B}};",
        "use super::Other;",
        "use crate::room::Other as Renamed;",
        "use super::*; fn f(_: &Other) {}",
        "use super::b; fn f(_: &b::B) {}",
        "fn f() -> super::b::B { todo!() }",
        "mod inner { fn f(_: &super::super::Other) {} }",
        "fn f() -> char { '\"' } use super::Other; // '\"'",
    ] {
        assert_eq!(circle(&format!("pub struct A; {import}"), back), both, "{import}");
    }
    for harmless in [
        "use super::C;",
        "use super::b;",
        "use super::*;",
        "// use super::b::B;\n/* use super::b::B; */",
        "const A: &str = \"use super::b::B;\"; const B: &str = r#\"\" super::b::B \"#;",
        "#[cfg(test)]\nuse super::b::{self, B};",
        "#[cfg(test)] #[allow(unused)] mod tests { use super::super::b::B; fn f() {} }",
        "#[cfg(test)] mod tests { const A: [u8; 2] = [1; 2]; fn f() { super::super::Other } }",
        "fn f<'a>(x: &'a str) -> impl Sized + use<'a> { x.b::<u8>() }",
    ] {
        let found = circle(&format!("pub struct A; {harmless}"), back);
        assert!(found.is_empty(), "{harmless}: {found:?}");
    }
}

#[test]
fn a_facade_counts_only_for_what_it_does_itself() {
    let circle = |facade: &str, child: &str| {
        let files = [("lib.rs", "mod room;"), ("room/mod.rs", facade), ("room/a.rs", child)];
        planted(&files).len()
    };
    let child = "use super::Shared; pub struct A;";
    assert_eq!(circle("mod a; pub use a::A; pub struct Shared;", child), 0);
    assert_eq!(circle("mod a; pub use a::*; pub struct Shared; fn f(_: usize) {}", child), 0);
    assert_eq!(circle("mod a; pub use a::A; pub struct Shared; fn f(_: A) {}", child), 1);
    assert_eq!(circle("mod a; pub use a::*; pub struct Shared; fn f(_: A) {}", child), 1);
    assert_eq!(circle("mod a; use a::Trait; pub struct Shared;", &child.replace('A', "Trait")), 1);
    assert_eq!(circle("mod a; pub struct Shared; fn f() { a::A; }", child), 1);
    assert_eq!(circle("mod a; fn f() { a::A; }", "pub struct A;"), 0);
}
