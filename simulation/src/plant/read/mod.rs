//! Reads files of plants: the reference text format, SWC, MTG and polylines in OBJ.

mod leaves;
mod lines;
mod mtg;
mod obj;
mod reference;
mod swc;

use std::path::Path;

pub use self::leaves::{LeafGroup, LeafTable, read_leaves};
use self::lines::Lines;
use super::Plant;
use catamaran::base::{Error, Result};
use catamaran::io::{Packing, Source, SourceOptions};

/// The format of a plant file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlantFormat {
    /// `verts N`, N lines `id,x,y,z,radius,on_leaf[,fixed]`, `edges M`, M lines `id,id`: the format
    /// of the reference implementation of the thesis, in metres. The root is the node nearest to
    /// the origin, where its segment begins.
    Reference,
    /// Neuron and tree skeletons (Cannon et al. 1998): lines `id type x y z radius parent`, parent
    /// -1 for the root, in metres. Type 7 ("custom") marks veins of leaves.
    Swc,
    /// Multiscale tree graphs (Godin and Caraglio 1998) of one plant (of several:
    /// [`read_individual`]), with coordinates (columns `XX`, `YY`, `ZZ`) or else lengths (`Length`,
    /// `Longueur`, `Long`) and angles of branches in degrees (`Insertion` or `Alpha`, `Azimuth`).
    /// Radii are those of `Radius`, or half of `Diameter`, `Diam`, `TopDia` or `diasom` and, at the
    /// base, of `BottomDia` or `diabase`. All in metres; [`Plant::scaled`] converts other units.
    /// [`Plant::notes`] says what was not in the file. Class `L...` (leaf) marks veins of leaves,
    /// `P...` (petiole) their stalks.
    Mtg,
    /// Wavefront OBJ with `v x y z [radius]` and polylines `l`: in metres; the default radius is 1
    /// mm. The root is the first vertex of the first line. End points at which no line continues
    /// are on leaves.
    Obj,
}

impl PlantFormat {
    /// Returns the format that the name of a file implies: `.txt`, `.swc`, `.mtg`, `.obj`.
    fn of(path: &Path) -> Result<(Self, Packing)> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let (stem, packing) = Packing::of(&name);
        let format = match stem.rsplit_once('.').map(|(_, extension)| extension) {
            Some("txt") => Self::Reference,
            Some("swc") => Self::Swc,
            Some("mtg") => Self::Mtg,
            Some("obj") => Self::Obj,
            _ => {
                let what = "unknown kind of plant: the name must end in .txt, .swc, .mtg or .obj, \
                            and may have .gz, .xz, .bz2, .zst or .zip after it";
                return Err(Error::file(path, what));
            }
        };
        Ok((format, packing))
    }
}

/// Reads the plant in the file at `path`, in the format that its name implies; the file may be
/// packed (`.gz`, `.xz`, `.bz2`, `.zip`, or `.zst` with feature `columnar` of catamaran).
///
/// ```
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("plant.swc");
/// std::fs::write(path, "1 1 0 0 0 0.2 -1\n2 3 0 1 0 0.1 1\n").unwrap();
/// assert_eq!(catamaran_simulation::plant::read(path)?.len(), 2);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] with the file and the line; [`Error::Mesh`], with the file, for nodes that make no
/// plant ([`Plant::new`]).
pub fn read(path: &Path) -> Result<Plant> {
    read_with(path, &SourceOptions::new())
}

/// Reads as [`read()`] does, within a limit of memory, and with a callback that receives the
/// fraction of the file read and may cancel.
///
/// ```
/// use catamaran::io::SourceOptions;
/// use catamaran_simulation::plant;
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("plant.swc");
/// std::fs::write(path, "1 1 0 0 0 0.2 -1\n2 3 0 1 0 0.1 1\n").unwrap();
/// assert!(plant::read_with(path, &SourceOptions::new().max_memory(64)).is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`read()`], and [`Error::Cancelled`].
pub fn read_with(path: &Path, options: &SourceOptions<'_>) -> Result<Plant> {
    let (format, packing) = PlantFormat::of(path)?;
    read_source(Source::open(path, packing, options)?, format, path, None)
}

/// Reads one of several plants in an MTG file, by its name.
///
/// ```
/// use catamaran::io::SourceOptions;
/// use catamaran_simulation::plant::read_individual;
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("plants.mtg");
/// std::fs::write(path, "MTG:\nTOPO\tLength\n/P1\n^/E1\t1\n/P2\n^/E1\t2\n").unwrap();
/// let plant = read_individual(path, "P2", &SourceOptions::new())?;
/// assert_eq!(plant.lengths(), [2.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`read_with`], and [`Error::Io`] for a file of another format and for a name that the file
/// does not have; it lists those of the file.
pub fn read_individual(path: &Path, name: &str, options: &SourceOptions<'_>) -> Result<Plant> {
    let (format, packing) = PlantFormat::of(path)?;
    if format != PlantFormat::Mtg {
        return Err(Error::file(
            path,
            format!("has no plant {name:?}: only .mtg files have names"),
        ));
    }
    read_source(Source::open(path, packing, options)?, format, path, Some(name))
}

/// Reads the plant in `bytes`, which are not packed, like a file.
///
/// ```
/// use catamaran_simulation::plant::{PlantFormat, read_bytes};
///
/// let swc = b"1 1 0 0 0 0.2 -1\n2 3 0 1 0 0.1 1\n3 3 0 2 0 0.1 2\n";
/// assert_eq!(read_bytes(swc, PlantFormat::Swc)?.len(), 3);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`read()`]; the path in errors is the usual name of the format.
pub fn read_bytes(bytes: &[u8], format: PlantFormat) -> Result<Plant> {
    let path = Path::new(match format {
        PlantFormat::Reference => "plant.txt",
        PlantFormat::Swc => "plant.swc",
        PlantFormat::Mtg => "plant.mtg",
        PlantFormat::Obj => "plant.obj",
    });
    read_source(Source::of_bytes(path, bytes), format, path, None)
}

fn read_source(
    source: Source<'_>,
    format: PlantFormat,
    path: &Path,
    name: Option<&str>,
) -> Result<Plant> {
    let mut lines = Lines::new(source);
    let plant = match format {
        PlantFormat::Reference => reference::read(&mut lines),
        PlantFormat::Swc => swc::read(&mut lines),
        PlantFormat::Mtg => mtg::read(&mut lines, name),
        PlantFormat::Obj => obj::read(&mut lines),
    };
    plant.map_err(|error| match error {
        Error::Mesh { what, element } => {
            Error::Mesh { what, element: format!("{}: {element}", path.display()) }
        }
        Error::Argument { what, why } => Error::file(path, format!("{what}: {why}")),
        other => other,
    })
}

#[cfg(test)]
mod tests;
