//! The modules of the library, and the file in which an item that a path names is defined.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::source::Source;

/// The names from the root of the crate to a module.
type Name = Vec<String>;

/// An import of one file in another one, or of one room in another.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    pub from: PathBuf,
    pub to: PathBuf,
    pub line: usize,
    /// What is named there.
    pub path: String,
}

/// All modules that have a file; those for tests are left out.
#[derive(Debug, Default)]
pub struct Modules {
    modules: BTreeMap<Name, (PathBuf, Source)>,
}

impl Modules {
    /// Those below `src`.
    pub fn read(src: &Path) -> Self {
        let mut modules = Self::default();
        let root = fs::read_to_string(src.join("lib.rs")).unwrap();
        modules.add(Vec::new(), PathBuf::from("lib.rs"), &root, &|path| {
            fs::read_to_string(src.join(path)).ok()
        });
        modules
    }

    /// Those of a crate whose files are (name, text); the first one is the root.
    pub fn from_texts(files: &[(&str, &str)]) -> Self {
        let mut modules = Self::default();
        modules.add(Vec::new(), PathBuf::from(files[0].0), files[0].1, &|path| {
            files.iter().find(|f| Path::new(f.0) == path).map(|f| f.1.to_owned())
        });
        modules
    }

    /// Adds the module `name` and those below it.
    fn add(
        &mut self,
        name: Name,
        file: PathBuf,
        text: &str,
        read: &dyn Fn(&Path) -> Option<String>,
    ) {
        let source = Source::parse(text);
        let folder: PathBuf = name.iter().collect();
        for child in source.children.clone() {
            let own = folder.join(format!("{child}.rs"));
            let facade = folder.join(&child).join("mod.rs");
            let found = [own, facade].into_iter().find_map(|path| Some((read(&path)?, path)));
            let (text, path) = found.unwrap_or_else(|| panic!("no file of {child} in {folder:?}"));
            let name = name.iter().cloned().chain([child]).collect();
            self.add(name, path, &text, read);
        }
        self.modules.insert(name, (file, source));
    }

    /// Every import of a file. A module that only hands a name on is passed by.
    pub fn arrows(&self) -> Vec<Arrow> {
        let mut arrows = Vec::new();
        for (name, (from, source)) in &self.modules {
            let mut add = |path: &[String], to: Option<Name>, line| {
                let Some(to) = to.filter(|to| to != name) else { return };
                let to = self.modules[&to].0.clone();
                arrows.push(Arrow { from: from.clone(), to, line, path: path.join("::") });
            };
            for import in &source.imports {
                // The names of a glob count where they stand, below; so do those that are handed
                // on, for the file may hand them on only, and those of a module.
                let is_used_here = import.name != "*"
                    && (!import.public
                        || source.words.iter().any(|word| word.path[0] == import.name));
                if is_used_here {
                    add(&import.path, self.item(name, &import.path, 0), import.line);
                }
            }
            for path in &source.references {
                add(&path.path, self.item(name, &path.path, 0), path.line);
            }
            for glob in source.imports.iter().filter(|i| i.name == "*") {
                let Some(target) = self.module(name, &glob.path, 0) else { continue };
                for word in &source.words {
                    if !source.defined.contains(&word.path[0]) {
                        add(&word.path, self.holder(&target, &word.path[0], 0), word.line);
                    }
                }
            }
        }
        arrows.sort();
        arrows.dedup();
        arrows
    }

    /// The module that `path`, as module `from` says it, names; none when it names no module.
    fn module(&self, from: &[String], path: &[String], depth: usize) -> Option<Name> {
        match self.follow(from, path, depth)? {
            (module, []) => Some(module),
            _ => None,
        }
    }

    /// The module that defines the item that `path`, as module `from` says it, names; none when it
    /// is not of this crate, or a module.
    fn item(&self, from: &[String], path: &[String], depth: usize) -> Option<Name> {
        match self.follow(from, path, depth)? {
            (_, []) => None,
            // What is not found, such as the constants of a macro, is taken to be there.
            (module, [name, ..]) => Some(self.holder(&module, name, depth).unwrap_or(module)),
        }
    }

    /// Walks along `path` while it names modules: the last one, and the rest of the path.
    fn follow<'a>(
        &self,
        from: &[String],
        path: &'a [String],
        depth: usize,
    ) -> Option<(Name, &'a [String])> {
        let (first, rest) = path.split_first()?;
        let (mut module, mut rest) = match first.as_str() {
            "crate" => (Vec::new(), rest),
            "self" => (from.to_vec(), rest),
            "super" => (from[..from.len().checked_sub(1)?].to_vec(), rest),
            _ => {
                let child = self.child(from, first);
                let imported = || self.imported_module(from, first, depth);
                (child.or_else(imported)?, rest)
            }
        };
        while let Some((next, after)) = rest.split_first() {
            let next = match next.as_str() {
                "super" => module[..module.len().checked_sub(1)?].to_vec(),
                _ => {
                    let child = self.child(&module, next);
                    match child.or_else(|| self.imported_module(&module, next, depth)) {
                        Some(next) => next,
                        None => break,
                    }
                }
            };
            (module, rest) = (next, after);
        }
        Some((module, rest))
    }

    fn child(&self, module: &[String], name: &str) -> Option<Name> {
        let child: Name = module.iter().cloned().chain([name.to_owned()]).collect();
        self.modules.contains_key(&child).then_some(child)
    }

    /// The module that goes by `name` in `module` because of a `use`.
    fn imported_module(&self, module: &[String], name: &str, depth: usize) -> Option<Name> {
        let source = &self.modules.get(module)?.1;
        let import = source.imports.iter().find(|i| i.name == name)?;
        // A name may come from a crate of the same name.
        let is_itself = import.path.len() == 1 && import.path[0] == name;
        if depth > MOST || is_itself { None } else { self.module(module, &import.path, depth + 1) }
    }

    /// The module that defines what `module` offers as `name`.
    fn holder(&self, module: &[String], name: &str, depth: usize) -> Option<Name> {
        if depth > MOST {
            return None;
        }
        let source = &self.modules.get(module)?.1;
        if source.defined.iter().any(|d| d == name) {
            return Some(module.to_vec());
        }
        if let Some(import) = source.imports.iter().find(|i| i.name == name) {
            return self.item(module, &import.path, depth + 1);
        }
        source.imports.iter().filter(|i| i.name == "*").find_map(|glob| {
            let target = self.module(module, &glob.path, depth + 1)?;
            self.holder(&target, name, depth + 1)
        })
    }
}

/// Imports of imports that are followed.
const MOST: usize = 8;
