//! Inside a room, too, files import in one direction: no file imports itself by way of others.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::modules::{Arrow, Modules};
use super::src;

/// Rooms that still have circles: a temporary list.
const NOT_YET: [&str; 0] = [];

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

/// The room of a file, relative to `src`.
fn room(file: &Path) -> String {
    file.components().next().unwrap().as_os_str().to_string_lossy().into_owned()
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
fn no_file_of_a_room_imports_itself_by_way_of_others() {
    let arrows = Modules::read(&src()).arrows();
    let circles = circles(&arrows);
    let rooms: BTreeSet<_> = circles.iter().map(|c| room(c.0.first().unwrap())).collect();
    let wrong: String = circles
        .iter()
        .filter(|c| !NOT_YET.contains(&room(c.0.first().unwrap()).as_str()))
        .map(report)
        .collect();
    assert!(wrong.is_empty(), "{wrong}");
    for room in NOT_YET {
        assert!(rooms.contains(room), "{room} has no circles any more: take it off the list");
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
