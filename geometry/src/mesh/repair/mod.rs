//! Repairs defects of exported meshes: soups, surfaces split along texture seams, repeated faces,
//! faces without area, holes, edges of many faces, faces that disagree about which side is outside.
//!
//! Sources: edges cut apart as in Gueziec, Taubin, Lazarus and Horn, Cutting and Stitching (2001);
//! holes filled as in Barequet and Sharir, Filling Gaps in the Boundary of a Polyhedron (1995).

mod degenerate;
mod holes;
mod manifold;
mod near;
mod options;
mod orient;
mod rebuild;
mod report;
mod weld;

pub use manifold::Repairs;
pub(crate) use manifold::manifold;
pub use options::{RepairOptions, Weld};
pub use report::{RepairReport, RepairStep};

use super::io::MeshFile;
use super::{Components, TriMesh};
use catamaran::base::{Error, Result, at_least};
pub(super) use near::near_points;
pub(super) use orient::inside_out;
use rebuild::Rebuild;
pub(super) use weld::Seams;
use weld::representatives;

/// A mesh after [`repair()`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Repaired {
    /// The mesh with its attributes.
    pub file: MeshFile,
    /// For each vertex of the input the lowest vertex of the result that comes from that vertex, or
    /// [`Repaired::NONE`]; `None` when the vertices are those of the input.
    pub vertices: Option<Vec<u32>>,
    /// What each step did.
    pub report: RepairReport,
}

impl Repaired {
    /// Marks a vertex that was left out.
    pub const NONE: u32 = rebuild::NONE;
}

/// Repairs a mesh by the steps that `options` select, always in this order: weld, drop repeated
/// faces, drop faces without area, drop vertices without a face, cut edges of more than two faces,
/// keep the largest components, drop specks, fill holes, orient.
///
/// Attributes follow their vertices and corners. Where vertices with different texture coordinates
/// or normals become one, the values become attributes of corners; where colours differ, the first
/// stays. Steps that only leave out faces do not renumber vertices.
///
/// ```
/// use catamaran_geometry::mesh::{RepairOptions, TriMesh, families, io::MeshFile, repair};
///
/// // A square of two triangles that share no vertex.
/// let square = families::grid(1, 1)?;
/// let corners = square.faces().as_flattened().iter();
/// let points = corners.map(|&v| square.vertices()[v as usize]).collect();
/// let soup = TriMesh::new(points, vec![[0, 1, 2], [3, 4, 5]])?;
/// let found = repair(soup.into(), &RepairOptions::everything())?;
/// assert_eq!(found.file.mesh.vertices().len(), 4);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for a tolerance that is negative or not finite, a share outside of 0 to 1,
/// no component to keep, and for attributes that do not fit the mesh ([`Error::Shape`], too); it
/// names the option whose step leaves no face, or no vertex. [`Error::Mesh`] names an edge of more
/// than two faces when holes are to be filled, and is that of [`TriMesh::check_size`] when specks
/// or faces without area are to be dropped.
pub fn repair(file: MeshFile, options: &RepairOptions) -> Result<Repaired> {
    file.check()?;
    if let Some(count) = options.keep_largest {
        at_least("keep_largest", count, 1)?;
    }
    let mut state = State { file, vertices: None, steps: Vec::new() };
    match options.weld {
        Weld::Never => {}
        Weld::Exact => state.weld(0.0)?,
        Weld::Within(tolerance) => state.weld(tolerance)?,
        Weld::Seams => state.close_seams()?,
    }
    if options.drop_duplicates {
        state.drop_duplicates()?;
    }
    if options.drop_degenerate {
        let (rebuild, step) = degenerate::without(&state.file.mesh, true)?;
        state.take(rebuild, step)?;
    }
    if options.compact {
        let part = state.file.mesh.without_unreferenced();
        let vertices = state.file.mesh.vertices().len() - part.vertices.len();
        let rebuild = (vertices > 0).then(|| Rebuild::of_part(part));
        state.take(rebuild, RepairStep::Compacted { vertices })?;
    }
    if options.cut {
        let (rebuild, step) = manifold::cut(&state.file.mesh);
        state.take(rebuild, step)?;
    }
    if let Some(count) = options.keep_largest {
        state.keep_largest(count)?;
    }
    if let Some(share) = options.drop_specks {
        state.drop_specks(share)?;
    }
    if let Some(most) = options.fill_holes {
        let (rebuild, step) = holes::filled(&state.file.mesh, most)?;
        state.take(rebuild, step)?;
        // A hole without area is a vertex on an edge: flipping this edge removes its faces.
        if options.drop_degenerate && step.changed() {
            let (rebuild, step) = degenerate::without(&state.file.mesh, false)?;
            if step.changed() {
                state.take(rebuild, step)?;
            }
        }
    }
    if options.orient {
        let (rebuild, step) = orient::outward(&state.file.mesh);
        state.take(rebuild, step)?;
    }
    let report = RepairReport { steps: state.steps };
    Ok(Repaired { file: state.file, vertices: state.vertices, report })
}

/// A mesh between two steps.
struct State {
    file: MeshFile,
    vertices: Option<Vec<u32>>,
    steps: Vec<RepairStep>,
}

impl State {
    /// Applies the change of a step; `None` leaves the mesh unchanged. A step that leaves nothing
    /// of the mesh is an error.
    fn take(&mut self, rebuild: Option<Rebuild>, step: RepairStep) -> Result<()> {
        if let Some(rebuild) = rebuild {
            let [faces, vertices] = counts(&self.file.mesh);
            if let Some(new) = rebuild.renumbering(vertices) {
                self.vertices = Some(match self.vertices.take() {
                    Some(before) => before
                        .into_iter()
                        .map(|v| new.get(v as usize).copied().unwrap_or(Repaired::NONE))
                        .collect(),
                    None => new,
                });
            }
            rebuild.apply(&mut self.file)?;
            let why = match counts(&self.file.mesh) {
                [0, _] if faces > 0 => format!("leaves none of the {faces} faces"),
                [_, 0] if vertices > 0 => format!("leaves none of the {vertices} vertices"),
                _ => String::new(),
            };
            if !why.is_empty() {
                return Err(Error::Argument { what: step.option(), why });
            }
        }
        self.steps.push(step);
        Ok(())
    }

    fn weld(&mut self, tolerance: f64) -> Result<()> {
        let joined = representatives(self.file.mesh.vertices(), tolerance)?;
        self.join(joined, |[vertices, faces, colors]| RepairStep::Welded {
            tolerance,
            vertices,
            faces,
            colors,
        })
    }

    fn close_seams(&mut self) -> Result<()> {
        let Seams { to, ambiguous } = Seams::of(&self.file.mesh);
        let ambiguous = ambiguous.len();
        self.join(to, |[vertices, _, colors]| RepairStep::ClosedSeams {
            vertices,
            colors,
            ambiguous,
        })
    }

    /// Joins each vertex with `to[v]`. `step` makes the report from the numbers of vertices and
    /// faces that are removed thereby, and of lost colours.
    fn join(&mut self, to: Vec<u32>, step: impl Fn([usize; 3]) -> RepairStep) -> Result<()> {
        let mesh = &self.file.mesh;
        let vertices = joining(&to).count();
        if vertices == 0 {
            return self.take(None, step([0; 3]));
        }
        let rebuild = Rebuild::joining(mesh, to);
        let faces = mesh.faces().len() - rebuild.faces.len();
        let step = step([vertices, faces, rebuild.lost_colors(&self.file)]);
        self.take(Some(rebuild), step)
    }

    fn drop_duplicates(&mut self) -> Result<()> {
        let mesh = &self.file.mesh;
        let repeated = mesh.repeated_faces();
        let mut kept = vec![true; mesh.faces().len()];
        repeated.iter().for_each(|[face, _]| kept[*face as usize] = false);
        let rebuild = (!repeated.is_empty()).then(|| Rebuild::of_faces(mesh, &kept));
        let first = repeated.first().copied();
        self.take(rebuild, RepairStep::DroppedDuplicates { faces: repeated.len(), first })
    }

    fn keep_largest(&mut self, count: usize) -> Result<()> {
        let mesh = &self.file.mesh;
        let found = Components::new(mesh);
        let mut by_size: Vec<usize> = (0..found.len()).collect();
        // The sort is stable: among components of the same size, the lower index comes first.
        by_size.sort_by_key(|&c| std::cmp::Reverse(found.face_counts()[c]));
        let mut kept = vec![false; found.len()];
        by_size.iter().take(count).for_each(|&c| kept[c] = true);
        self.keep(&found, &kept, |components, faces| RepairStep::KeptLargest { components, faces })
    }

    fn drop_specks(&mut self, share: f64) -> Result<()> {
        if !(0.0..=1.0).contains(&share) {
            let why = format!("must be a share of the area, from 0 to 1, is {share}");
            return Err(Error::Argument { what: "drop_specks", why });
        }
        self.file.mesh.check_size()?;
        let found = Components::new(&self.file.mesh);
        let mut areas = vec![0.0; found.len()];
        for (component, area) in found.of_faces().iter().zip(self.file.mesh.face_areas()) {
            areas[*component as usize] += area;
        }
        let least = share * areas.iter().sum::<f64>();
        let kept: Vec<bool> = areas.iter().map(|area| *area >= least).collect();
        self.keep(&found, &kept, |components, faces| RepairStep::DroppedSpecks {
            share,
            components,
            faces,
        })
    }

    /// Leaves out the components that are not kept. `step` makes the report from the numbers of
    /// removed components and faces.
    fn keep(
        &mut self,
        found: &Components,
        kept: &[bool],
        step: impl Fn(usize, usize) -> RepairStep,
    ) -> Result<()> {
        let mesh = &self.file.mesh;
        let own = found.of_faces().iter().zip(0..).filter(|(c, _)| kept[**c as usize]);
        let own: Vec<u32> = own.map(|(_, f)| f).collect();
        let components = kept.iter().filter(|kept| !**kept).count();
        let step = step(components, mesh.faces().len() - own.len());
        let rebuild = match components {
            0 => None,
            _ => Some(Rebuild::of_part(mesh.submesh(&own)?)),
        };
        self.take(rebuild, step)
    }
}

/// Returns a description of the first defect that [`RepairOptions::unambiguous`] would repair;
/// `None` when there is none.
///
/// ```
/// use catamaran_geometry::mesh::{TriMesh, families, needs_repair};
///
/// let (points, mut faces) = families::icosphere(1)?.into_parts();
/// assert_eq!(needs_repair(&TriMesh::new(points.clone(), faces.clone())?), None);
/// faces.push(faces[3]);
/// let why = needs_repair(&TriMesh::new(points, faces)?);
/// assert_eq!(why.as_deref(), Some("1 repeated faces: face 80 has the vertices of face 3"));
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn needs_repair(mesh: &TriMesh) -> Option<String> {
    let Seams { to, .. } = Seams::of(mesh);
    if let Some(v) = joining(&to).next() {
        return Some(format!(
            "{} vertices coincide with others along seams: vertex {v} with vertex {}",
            joining(&to).count(),
            to[v as usize]
        ));
    }
    let repeated = mesh.repeated_faces();
    if let Some([face, first]) = repeated.first() {
        let count = repeated.len();
        return Some(format!(
            "{count} repeated faces: face {face} has the vertices of face {first}"
        ));
    }
    let flat = mesh.faces_without_area();
    flat.first().map(|face| format!("{} faces without area: face {face}", flat.len()))
}

/// Returns the numbers of faces and of vertices.
fn counts(mesh: &TriMesh) -> [usize; 2] {
    [mesh.faces().len(), mesh.vertices().len()]
}

/// Returns the vertices that join another vertex.
fn joining(to: &[u32]) -> impl Iterator<Item = u32> + '_ {
    (0..).zip(to).filter(|(v, to)| v != *to).map(|(v, _)| v)
}
