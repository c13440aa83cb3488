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
use catamaran::base::{Error, Result, options, positive};
use catamaran::io::{Packing, Source, SourceOptions};

/// The format of a plant file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlantFormat {
    /// `verts N`, N lines `id,x,y,z,radius,on_leaf[,fixed]`, `edges M`, M lines `id,id`: the format
    /// of the reference implementation of the thesis, in metres. The root is the node nearest to
    /// the origin, where its segment begins. `on_leaf` and `fixed` are 0 or 1.
    Reference,
    /// Neuron and tree skeletons (Cannon et al. 1998): lines `id type x y z radius parent`, parent
    /// -1 for the root, in metres. Type 7 ("custom") marks veins of leaves. A segment is added
    /// below the root, as by [`Plant::new`].
    Swc,
    /// Multiscale tree graphs (Godin and Caraglio 1998) of one plant (of several:
    /// [`ReadOptions::individual`]), with coordinates (columns `XX`, `YY`, `ZZ`) or else lengths
    /// (`Length`, `Longueur`, `Long`, `Len`) and angles of branches in degrees (`Insertion` or
    /// `Alpha`, `Azimuth`).
    /// Radii are those of `Radius`, or half of `Diameter`, `Diam`, `TopDia` or `diasom` and, at the
    /// base, of `BottomDia` or `diabase`. All in metres; [`ReadOptions::unit`] says other units.
    /// [`Plant::notes`] says what was not in the file. Class `L...` (leaf) marks veins of leaves,
    /// `P...` (petiole) their stalks.
    Mtg,
    /// Wavefront OBJ with `v x y z [radius]` and polylines `l`: in metres; the default radius is 1
    /// mm. The root is the first vertex of the first line; a segment is added below it, as by
    /// [`Plant::new`]. End points at which no line continues are on leaves.
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
    read_with(path, &ReadOptions::new())
}

options! {
    /// Options of [`read_with`].
    #[derive(Debug, Clone, Copy)]
    pub struct ReadOptions<'a> {
        /// Metres in a unit of the lengths and coordinates of the file, and in a unit of its radii
        /// and diameters: `[1e-2, 1e-3]` for centimetres and millimetres.
        unit: [f64; 2] = [1.0, 1.0], unit "m", range "positive and finite";
        /// The name of one of several plants in an MTG file, such as `P3`.
        individual: Option<&'a str> = None, setter into;
        /// The limit of memory, and a callback that receives the fraction of the file read and may
        /// cancel.
        source: SourceOptions<'a> = SourceOptions::new();
    }
}

/// Reads as [`read()`] does, with options.
///
/// ```
/// use catamaran::io::SourceOptions;
/// use catamaran_simulation::plant::{ReadOptions, read_with};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = &folder.path().join("plants.mtg");
/// std::fs::write(path, "MTG:\nTOPO\tLength\n/P1\n^/E1\t1\n/P2\n^/E1\t200\n").unwrap();
/// let options = ReadOptions::new().individual("P2").unit([1e-2, 1e-3]);
/// assert_eq!(read_with(path, &options)?.lengths(), [2.0]);
/// let small = options.source(SourceOptions::new().max_memory(64));
/// assert!(read_with(path, &small).is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`read()`], [`Error::Argument`] for a unit out of its range, and [`Error::Cancelled`];
/// [`Error::Io`] for a name of a plant that the file does not have, which lists those of the file,
/// and for one in a file of another format.
pub fn read_with(path: &Path, options: &ReadOptions<'_>) -> Result<Plant> {
    for unit in options.unit {
        positive("unit", unit)?;
    }
    let (format, packing) = PlantFormat::of(path)?;
    if let (Some(name), true) = (options.individual, format != PlantFormat::Mtg) {
        let what = format!("has no plant {name:?}: only .mtg files have names");
        return Err(Error::file(path, what));
    }
    read_source(Source::open(path, packing, &options.source)?, format, path, options)
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
    read_source(Source::of_bytes(path, bytes), format, path, &ReadOptions::new())
}

fn read_source(
    source: Source<'_>,
    format: PlantFormat,
    path: &Path,
    options: &ReadOptions<'_>,
) -> Result<Plant> {
    let mut lines = Lines::new(source);
    let plant = match format {
        PlantFormat::Reference => reference::read(&mut lines, options.unit),
        PlantFormat::Swc => swc::read(&mut lines, options.unit),
        PlantFormat::Mtg => mtg::read(&mut lines, options.unit, options.individual),
        PlantFormat::Obj => obj::read(&mut lines, options.unit),
    };
    plant.map(Plant::noting_span).map_err(|error| match error {
        Error::Mesh { what, element } => {
            Error::Mesh { what, element: format!("{}: {element}", path.display()) }
        }
        Error::Argument { what, why } => Error::file(path, format!("{what}: {why}")),
        other => other,
    })
}

#[cfg(test)]
mod tests;
