//! `docs/faces.md`: the operations of the library in each face, from `faces.txt`, whose names are
//! looked up in the sources and whose omissions are errors.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::declarations::Header;
use crate::generated::Generated;
use crate::header::HEADER;

/// `docs/faces.md`.
pub const FACES: Generated = Generated {
    name: "docs/faces.md",
    source: "scripts/xtask/src/faces.txt or the sources",
    command: "cargo xtask faces",
    generate,
};

const TABLE: &str = include_str!("faces.txt");

const INTRODUCTION: &str = "\
# Operations and faces

The operations on matrices, meshes and spectra, and their names in Rust, C, C++, Python and on the
command line. `cargo xtask faces` writes this page, and fails if a name does not exist or if a
function or command is in no row. A word in italics says why a cell is empty; the
[reasons](#reasons) are at the end. Simulations have pages of their own: [plants](guide/plants.md),
[slime moulds](guide/slime.md), [Newton fractals](guide/newton.md).

Paths of Rust begin in `catamaran` or `catamaran_geometry`, names of C++ in the namespace
`catamaran`, names of Python in the package `catamaran`. The last column names the operations of
Rust and C whose data several ranks of MPI share; in C++ they have the names of the other columns
and a `world` as first argument; in Python `ata`, `lstsq`, `pca` and `eigsh` take `comm`, the
communicator of mpi4py. Under `mpirun` the ranks share the work of the commands `ata`, `lstsq`,
`pca`, `svd` and `spectrum`.
";

const HEAD: &str = "
| Operation | Rust | C | C++ | Python | Command line | Ranks |
|---|---|---|---|---|---|---|
";

/// The columns behind the operation.
const COLUMNS: [&str; 6] = ["rust", "c", "c++", "python", "command", "ranks"];

/// A file and its text.
type Text = (PathBuf, String);

/// What the faces declare.
struct Sources {
    root: PathBuf,
    /// Functions of the C header.
    c: BTreeSet<String>,
    cpp: Vec<Text>,
    python: Vec<Text>,
    /// The content of `__all__` in Python.
    all: BTreeSet<String>,
    commands: BTreeSet<String>,
}

impl Sources {
    fn read(root: &Path) -> Result<Self, String> {
        let package = root.join("python/python/catamaran");
        let init = super::read(&package.join("__init__.py"))?;
        let all = init.split_once("__all__ = [").map_or("", |(_, list)| list);
        let all = all.split(']').next().unwrap_or_default();
        let names = all.split('"').skip(1).step_by(2).map(str::to_owned).collect();
        let header = Header::parse(&super::read(&root.join(HEADER.name))?);
        Ok(Self {
            root: root.to_owned(),
            c: header.functions.into_iter().map(|function| function.name).collect(),
            cpp: texts(&root.join("include"), &["hpp"])?,
            python: texts(&package, &["py", "pyi"])?,
            all: names,
            commands: commands(&super::read(&root.join("cli/src/main.rs"))?),
        })
    }

    /// Returns whether a face has the name.
    fn has(&self, face: &str, name: &str) -> Result<bool, String> {
        let (first, last) = name.split_once('.').map_or((name, None), |(a, b)| (a, Some(b)));
        Ok(match face {
            "ranks" if name.starts_with("cata_") => self.c.contains(name),
            "rust" | "ranks" => self.has_rust(name)?,
            "c" => self.c.contains(name),
            "c++" => name.split("::").all(|word| is_in(&self.cpp, word, in_cpp)),
            "python" => {
                let is_module = self.python.iter().any(|(path, _)| path.ends_with(file_of(first)));
                let is_public = self.all.contains(first) || is_module;
                let is_known = |word: &str| is_in(&self.python, word, in_python);
                is_public && (is_module || is_known(first)) && last.is_none_or(is_known)
            }
            _ => self.commands.contains(name.split(' ').next().unwrap_or_default()),
        })
    }

    /// Returns whether a module of Rust exports the item, which is declared below it.
    fn has_rust(&self, path: &str) -> Result<bool, String> {
        let (module, items) = module_of(path);
        let Some(folder) = self.folder(&module) else { return Ok(false) };
        let is_exported = exports(&folder)?.contains(items[0]);
        let below = texts(&folder, &["rs"])?;
        Ok(is_exported && items.iter().all(|item| is_in(&below, item, in_rust)))
    }

    /// Returns the folder of a module of the centre or of geometry.
    fn folder(&self, module: &str) -> Option<PathBuf> {
        let path = module.replace("::", "/");
        ["src", "geometry/src"]
            .map(|sources| self.root.join(sources).join(&path))
            .into_iter()
            .find(|folder| folder.is_dir())
    }

    /// Returns what a face offers and a line of the table, or of helpers, must name.
    fn offered(&self, face: &str, modules: &BTreeSet<String>) -> Result<Vec<String>, String> {
        // Classes of Python and types of Rust are arguments and results of functions.
        let is_function = |name: &String| name.starts_with(|c: char| c.is_ascii_lowercase());
        Ok(match face {
            "c" => self.c.iter().cloned().collect(),
            "python" => self.all.iter().filter(|name| is_function(name)).cloned().collect(),
            "command" => self.commands.iter().cloned().collect(),
            _ => {
                let mut found = vec![];
                for module in modules {
                    let folder =
                        self.folder(module).ok_or_else(|| format!("{module}: no such module"))?;
                    let names = exports(&folder)?.into_iter().filter(is_function);
                    found.extend(names.map(|name| format!("{module}::{name}")));
                }
                found
            }
        })
    }
}

/// Returns the file of a module of Python.
fn file_of(module: &str) -> String {
    format!("{module}.py")
}

/// Splits `mesh::io::read` and `mesh::TriMesh::genus` behind their modules.
fn module_of(path: &str) -> (String, Vec<&str>) {
    let parts: Vec<&str> = path.split("::").collect();
    let is_module = |part: &&&str| part.starts_with(|c: char| c.is_ascii_lowercase());
    let modules = parts[..parts.len() - 1].iter().take_while(is_module).count();
    (parts[..modules].join("::"), parts[modules..].to_vec())
}

/// Reads the files below a folder that have one of the extensions.
fn texts(folder: &Path, extensions: &[&str]) -> Result<Vec<Text>, String> {
    let fail = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut found = vec![];
    for entry in std::fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if path.is_dir() {
            found.extend(texts(&path, extensions)?);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|known| e == *known)) {
            let text = super::read(&path)?;
            found.push((path, text));
        }
    }
    Ok(found)
}

/// Returns whether one of the texts declares the name.
fn is_in(texts: &[Text], name: &str, forms: fn(&str) -> Vec<String>) -> bool {
    let forms = forms(name);
    texts.iter().any(|(_, text)| forms.iter().any(|form| text.contains(form)))
}

fn in_rust(name: &str) -> Vec<String> {
    let types = ["struct", "enum", "trait"].into_iter();
    let types =
        types.flat_map(|kind| [" ", "<", "(", ";"].map(|end| format!("pub {kind} {name}{end}")));
    types.chain(["(", "<"].map(|end| format!("pub fn {name}{end}"))).collect()
}

fn in_cpp(name: &str) -> Vec<String> {
    vec![format!(" {name}("), format!("class {name} "), format!("struct {name} ")]
}

fn in_python(name: &str) -> Vec<String> {
    let ends = ["(", ":"].into_iter();
    ends.flat_map(|end| [format!("class {name}{end}"), format!("def {name}{end}")]).collect()
}

/// Returns the commands of `enum Command` in cli/src/main.rs.
fn commands(main: &str) -> BTreeSet<String> {
    let list = main.split_once("enum Command {").map_or("", |(_, rest)| rest);
    let (mut found, mut renamed) = (BTreeSet::new(), None);
    for line in list.lines().map(str::trim).take_while(|line| *line != "}") {
        if let Some((_, name)) = line.split_once("name = \"") {
            renamed = name.split('"').next().map(str::to_owned);
        } else if let Some((variant, _)) =
            line.split_once('(').filter(|_| !line.starts_with(['#', '/']))
        {
            found.insert(renamed.take().unwrap_or_else(|| hyphened(variant)));
        }
    }
    found
}

/// Returns `AtaMerge` as `ata-merge`.
fn hyphened(variant: &str) -> String {
    let mut found = String::new();
    for c in variant.chars() {
        if c.is_uppercase() && !found.is_empty() {
            found.push('-');
        }
        found.extend(c.to_lowercase());
    }
    found
}

/// Returns the names that the `mod.rs` of a module of Rust exports, apart from hidden ones.
fn exports(folder: &Path) -> Result<BTreeSet<String>, String> {
    let text = super::read(&folder.join("mod.rs"))?;
    let (mut found, mut is_hidden) = (BTreeSet::new(), false);
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("#[doc(hidden)]") {
            is_hidden = true;
        } else if let Some(function) = line.strip_prefix("pub fn ") {
            found.extend(
                function.split(['(', '<']).next().map(str::to_owned).filter(|_| !is_hidden),
            );
            is_hidden = false;
        } else if let Some(first) = line.strip_prefix("pub use ") {
            let mut statement = first.to_owned();
            while !statement.ends_with(';') {
                statement +=
                    lines.next().ok_or_else(|| format!("{}: `pub use`", folder.display()))?;
            }
            if let Some(module) = statement.strip_suffix("::*;") {
                found.extend(exports(&folder.join(module.trim_start_matches("self::")))?);
            } else if !is_hidden {
                found.extend(names_of(&statement));
            }
            is_hidden = false;
        }
    }
    Ok(found)
}

/// Returns the names of `a::{b, C};`.
fn names_of(statement: &str) -> Vec<String> {
    let list = statement.split_once('{').map_or(statement, |(_, list)| list);
    let names = list.split(',').map(|name| name.trim().trim_end_matches(['}', ';', ' ']));
    let names = names.filter_map(|path| path.rsplit("::").next());
    names.filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

/// Returns whether a name fits a pattern, in which `*` stands for any letters.
fn fits(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, rest)) => name
            .strip_prefix(head)
            .is_some_and(|tail| (0..=tail.len()).any(|at| fits(rest, &tail[at..]))),
    }
}

/// The table, as it is read.
#[derive(Default)]
struct Table<'a> {
    /// Words and their meanings.
    reasons: Vec<(&'a str, &'a str)>,
    /// Faces and patterns.
    helpers: Vec<(&'a str, &'a str)>,
    /// A heading, or an operation and its cells.
    lines: Vec<(&'a str, Vec<&'a str>)>,
}

impl<'a> Table<'a> {
    fn parse(text: &'a str) -> Result<Self, String> {
        let mut table = Self::default();
        let content = |line: &&str| !line.is_empty() && !line.starts_with("# ") && *line != "#";
        for line in text.lines().filter(content) {
            let fail = || format!("faces.txt: {line}");
            if let Some(heading) = line.strip_prefix("## ") {
                table.lines.push((heading, vec![]));
            } else if let Some(reason) = line.strip_prefix("> ") {
                table.reasons.push(reason.split_once(": ").ok_or_else(fail)?);
            } else if let Some(rest) = line.strip_prefix("helpers ") {
                let (face, patterns) = rest.split_once(": ").ok_or_else(fail)?;
                table.helpers.extend(patterns.split(' ').map(|pattern| (face, pattern)));
            } else {
                let mut cells = line.split('|').map(str::trim);
                let operation = cells.next().unwrap_or_default();
                let cells: Vec<&str> = cells.collect();
                if cells.len() != COLUMNS.len() || cells.contains(&"") {
                    return Err(fail());
                }
                table.lines.push((operation, cells));
            }
        }
        Ok(table)
    }

    fn is_helper(&self, face: &str, name: &str) -> bool {
        self.helpers.iter().any(|(of, pattern)| *of == face && fits(pattern, name))
    }

    /// Returns the names of a cell; those of C that fit a pattern.
    fn names(&self, face: &str, cell: &str, sources: &Sources) -> Vec<String> {
        if face == "command" {
            return cell.split(", ").map(str::to_owned).collect();
        }
        let words = cell.split(' ');
        let names = words.flat_map(|word| {
            if !word.contains('*') {
                return vec![word.to_owned()];
            }
            let of_c = sources.c.iter().filter(|name| fits(word, name));
            of_c.filter(|name| !self.is_helper("c", name)).cloned().collect()
        });
        names.collect()
    }
}

fn generate(root: &Path) -> Result<String, String> {
    page(&Table::parse(TABLE)?, &Sources::read(root)?)
}

/// Returns the page, or every fault of the table.
fn page(table: &Table<'_>, sources: &Sources) -> Result<String, String> {
    let (mut page, mut faults) = (String::from(INTRODUCTION), vec![]);
    let (mut named, mut given) = (BTreeSet::new(), BTreeSet::new());
    let mut modules = BTreeSet::new();
    for (operation, cells) in &table.lines {
        if cells.is_empty() {
            page += &format!("\n## {operation}\n{HEAD}");
            continue;
        }
        page += &format!("| {operation} |");
        for (face, cell) in COLUMNS.into_iter().zip(cells) {
            if let Some(reason) = cell.strip_prefix('-') {
                if !table.reasons.iter().any(|(word, _)| *word == reason) {
                    faults.push(format!("{operation}: {face}: no reason `{reason}`"));
                }
                given.insert(reason);
                page += &format!(" *{reason}* |");
                continue;
            }
            let names = table.names(face, cell, sources);
            if names.is_empty() {
                faults.push(format!("{operation}: {face}: nothing fits `{cell}`"));
            }
            for name in &names {
                if !sources.has(face, name)? {
                    faults.push(format!("{operation}: {face} has no `{name}`"));
                }
                if name.contains("::") && face != "c++" {
                    modules.insert(module_of(name).0);
                }
            }
            named.extend(names.iter().map(|name| match face {
                "python" => (face, name.split('.').next().unwrap_or_default().to_owned()),
                "command" => (face, name.split(' ').next().unwrap_or_default().to_owned()),
                "ranks" if name.starts_with("cata_") => ("c", name.clone()),
                "ranks" => ("rust", name.clone()),
                _ => (face, name.clone()),
            }));
            let program = if face == "command" { "catamaran " } else { "" };
            let shown: Vec<_> = names.iter().map(|name| format!("`{program}{name}`")).collect();
            page += &format!(" {} |", shown.join(", "));
        }
        page += "\n";
    }
    for face in ["rust", "c", "python", "command"] {
        let offered = sources.offered(face, &modules)?;
        let lost = offered.iter().filter(|name| !named.contains(&(face, (*name).clone())));
        let lost = lost.filter(|name| !table.is_helper(face, name));
        faults.extend(lost.map(|name| format!("{face}: `{name}` is in no line of faces.txt")));
        let idle = table.helpers.iter().filter(|(of, _)| *of == face);
        let idle = idle.filter(|(_, pattern)| !offered.iter().any(|name| fits(pattern, name)));
        faults.extend(idle.map(|(_, pattern)| format!("helpers {face}: nothing is `{pattern}`")));
    }
    page += "\n## Reasons\n\n| Word | Why the cell is empty |\n|---|---|\n";
    for (word, meaning) in &table.reasons {
        page += &format!("| *{word}* | {meaning} |\n");
        if !given.contains(word) {
            faults.push(format!("the reason `{word}` is given nowhere"));
        }
    }
    if faults.is_empty() { Ok(page) } else { Err(faults.join("\n")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faults of the table after a change of it.
    fn faults(from: &str, to: &str) -> String {
        assert!(TABLE.contains(from), "{from}");
        let text = TABLE.replacen(from, to, 1);
        let sources = Sources::read(&crate::root()).unwrap();
        page(&Table::parse(&text).unwrap(), &sources).unwrap_err()
    }

    #[test]
    fn names_that_a_face_does_not_have_are_faults() {
        assert_eq!(faults("mesh::repair |", "mesh::mend |").lines().count(), 2);
        assert!(faults("cata_lstsq ", "cata_least ").contains("c has no `cata_least`"));
        assert!(faults("| cata_aat_*", "| cata_aaat_*").contains("nothing fits `cata_aaat_*`"));
        assert!(faults("| accumulator::merge", "| accumulator::join").contains("c++ has no"));
        assert!(faults("Accumulator.merge", "Accumulator.join").contains("python has no"));
        assert!(faults("| ata-merge", "| merge").contains("command has no `merge`"));
        assert!(faults("ranks::verify", "ranks::prove").contains("ranks has no `ranks::prove`"));
    }

    #[test]
    fn operations_that_stand_nowhere_are_faults() {
        for (from, to, fault) in [
            ("mesh::cloud_laplacian", "mesh::laplacian", "rust: `mesh::cloud_laplacian`"),
            ("cata_shape_from_spectrum", "-own", "c: `cata_shape_from_spectrum`"),
            ("| corrcoef", "| -own", "python: `corrcoef`"),
            ("| basis |", "| -own |", "command: `basis`"),
        ] {
            let found = faults(from, to);
            assert_eq!(found, format!("{fault} is in no line of faces.txt"));
        }
    }

    #[test]
    fn reasons_are_declared_and_helpers_exist() {
        assert!(faults("> own:", "> owned:").contains("no reason `own`"));
        assert!(faults("python: grow_plant", "python: grow").contains("nothing is `grow`"));
    }

    #[test]
    fn exports_of_rust_are_read() {
        assert_eq!(names_of("a::{b, C, d::e};"), ["b", "C", "e"]);
        assert_eq!(names_of("self::hdf5::version;"), ["version"]);
        assert_eq!(module_of("mesh::io::read"), ("mesh::io".to_owned(), vec!["read"]));
        assert_eq!(module_of("mesh::Edges::faces"), ("mesh".to_owned(), vec!["Edges", "faces"]));
    }

    #[test]
    fn patterns_stand_for_any_letters() {
        assert!(fits("cata_*_free", "cata_heat_free") && fits("cata_ata_f*", "cata_ata_f32_f64"));
        assert!(!fits("cata_*_free", "cata_heat_freed") && !fits("cata_a", "cata_ab"));
    }
}
