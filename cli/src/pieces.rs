//! Components of a mesh, each of which has an eigenvalue zero: notes, and an error where a command
//! needs other eigenfunctions, too.

use std::path::Path;

use anyhow::{Result, bail};
use catamaran_geometry::mesh::{
    Boundary, Components, RepairOptions, TriMesh, Weld, free_components, repair,
};

use crate::input::MeshArgs;
use crate::report::note;

/// Steps of `catamaran mesh` that drop vertices in no face, also those whose faces have no area,
/// which repairs drop.
pub const COMPACT: &str = "--drop-degenerate --compact";

/// The components of a mesh that a spectrum is taken of.
pub struct Pieces<'a> {
    mesh: &'a TriMesh,
    path: &'a Path,
    /// How the mesh was repaired.
    repair: &'a MeshArgs,
    boundary: Boundary,
    /// Number of components.
    count: usize,
    /// Number of components that are not held at zero anywhere.
    free: usize,
}

/// The eigenfunctions that an option asks for.
#[derive(Debug, Clone, Copy)]
pub struct Need {
    /// The option that sets the number. [`Pieces::check`] names its number without the constant
    /// function.
    pub option: &'static str,
    /// Number of eigenfunctions, the constant one included.
    pub len: usize,
    /// Number of different positive eigenvalues that must be among them.
    pub positive: usize,
}

impl<'a> Pieces<'a> {
    /// Counts the components of a mesh that was read from `path` and repaired by `repair`.
    ///
    /// # Errors
    /// A vertex of the boundary does not exist.
    pub fn new(
        mesh: &'a TriMesh,
        path: &'a Path,
        repair: &'a MeshArgs,
        boundary: &Boundary,
    ) -> Result<Self> {
        let free = free_components(mesh, boundary)?;
        let (count, boundary) = (Components::new(mesh).len(), boundary.clone());
        Ok(Self { mesh, path, repair, boundary, count, free })
    }

    /// Returns the number of components.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the number of components that are not held at zero anywhere, each with an eigenvalue
    /// zero.
    pub fn free(&self) -> usize {
        self.free
    }

    /// Prints a note where the spectrum is not that of one surface with its boundary condition, and
    /// where vertices are in no face.
    pub fn note(&self) {
        let Self { path, count, free, boundary, .. } = self;
        let (path, zeros) = (path.display(), eigenvalues(*free));
        let what = match (*count > 1, *free) {
            (false, 1..) if *boundary != Boundary::Neumann => "the mesh has no boundary".into(),
            (false, _) => String::new(),
            (true, 0) => format!("{count} components, whose eigenvalues are in one list"),
            (true, _) if free == count => {
                format!("{count} components: {zeros} zero, one for each")
            }
            (true, _) => format!("{count} components: {zeros} zero, one for each without boundary"),
        };
        if !what.is_empty() {
            note(format_args!("{path}: {what}{}", self.hint()));
        }
        let alone = self.mesh.unreferenced_vertices().len();
        if alone > 0 {
            let command = self.repair.mesh_command(self.path, COMPACT);
            note(format_args!(
                "{path}: vertices in no face: {alone}; eigenfunctions are zero there ({command} \
                 drops these vertices)"
            ));
        }
    }

    /// Refuses fewer eigenfunctions than components, which have a constant function each, and than
    /// `need` says.
    ///
    /// A component without its constant function would move to the origin.
    pub fn check(&self, need: Need) -> Result<()> {
        let Need { option, len, positive } = need;
        let (path, count) = (self.path.display(), self.count);
        if len >= count + positive {
            return Ok(());
        }
        let (k, least) = (len - 1, count + positive - 1);
        let enough = if positive > 1 { "at least is needed" } else { "or more is enough" };
        let constants = match count {
            1 => String::new(),
            _ => format!("{count} components, each with a constant function of its own: "),
        };
        bail!("{path}: {constants}{option} {k} is too few, {least} {enough}{}", self.hint())
    }

    /// Refuses a signature of k eigenvalues that are all zero: all such meshes have it in common.
    pub fn check_signature(&self, k: usize) -> Result<()> {
        let Self { path, count, free, .. } = self;
        if k > *free {
            return Ok(());
        }
        let (path, zeros, least) = (path.display(), eigenvalues(*free), free + 1);
        let which = if free == count { "" } else { " without boundary" };
        bail!(
            "{path}: {zeros} zero, one for each component{which}: -k {k} compares zeros only, \
             {least} or more is enough{}",
            self.hint()
        )
    }

    /// Returns what joins or extracts components, in parentheses.
    fn hint(&self) -> String {
        if self.count < 2 {
            return String::new();
        }
        let command = self.repair.mesh_command(self.path, "--component largest");
        let one = format!("{command} extracts one");
        let options = RepairOptions::new().weld(Weld::Exact);
        let welded = repair(self.mesh.clone().into(), &options).ok();
        match welded.map(|found| Components::new(&found.file.mesh).len()) {
            Some(left) if left < self.count => {
                let instead = if self.repair.is_strict() { " instead of --strict" } else { "" };
                format!(" (--weld{instead} joins them into {left}; {one})")
            }
            _ => format!(" ({one})"),
        }
    }
}

/// Returns "1 eigenvalue is", "2 eigenvalues are".
fn eigenvalues(count: usize) -> String {
    match count {
        0 => "no eigenvalue is".into(),
        1 => "1 eigenvalue is".into(),
        _ => format!("{count} eigenvalues are"),
    }
}
