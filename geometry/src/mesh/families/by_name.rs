use super::super::TriMesh;
use super::closed::{genus, icosphere, knot, torus};
use super::figure::figure;
use super::flat::{cylinder, disk, grid, terrain};
use catamaran::base::{Error, Result};

/// Generates the mesh of one of the families `icosphere`, `torus`, `knot`, `genus`, `figure`,
/// `grid`, `disk`, `cylinder` and `terrain`, by the name of its function, with the arguments of the
/// function: the counts (and the seed) in their order, and the sizes in theirs.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let torus = families::by_name("torus", &[12, 6], &[2.0, 0.5])?;
/// assert_eq!(torus, families::torus(12, 6, 2.0, 0.5)?);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] of "name" when no family has this name and these numbers of counts and
/// sizes, of "counts" for a count that exceeds its type; those of the family.
pub fn by_name(name: &str, counts: &[usize], sizes: &[f64]) -> Result<TriMesh> {
    match (name, counts, sizes) {
        ("icosphere", &[subdivisions], []) => icosphere(narrow(subdivisions)?),
        ("torus", &[around, tube], &[major, minor]) => torus(around, tube, major, minor),
        ("knot", &[p, q, along, tube], &[radius]) => {
            knot(narrow(p)?, narrow(q)?, along, tube, radius)
        }
        ("genus", &[holes, cells], []) => genus(holes, cells),
        ("figure", &[cells], &[pose]) => figure(cells, pose),
        ("grid", &[columns, rows], []) => grid(columns, rows),
        ("disk", &[rings, sectors], []) => disk(rings, sectors),
        ("cylinder", &[around, along], &[radius, height]) => {
            cylinder(around, along, radius, height)
        }
        ("terrain", &[columns, rows, seed], []) => terrain(columns, rows, seed as u64),
        _ => {
            let numbers = format!("{} counts and {} sizes", counts.len(), sizes.len());
            let why = format!("no generated mesh is called {name} and has {numbers}");
            Err(Error::Argument { what: "name", why })
        }
    }
}

fn narrow(count: usize) -> Result<u32> {
    let refused = |_| Error::Argument { what: "counts", why: format!("{count} is too large") };
    u32::try_from(count).map_err(refused)
}
