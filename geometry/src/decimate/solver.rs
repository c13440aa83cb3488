//! The whole decimation, from a mesh and a number of vertices to the new mesh.

use std::borrow::Cow;
use std::collections::HashSet;

use super::batches::add_samples;
use super::cells::{Cells, Growth, Seed};
use super::closest::nearest;
use super::collapse::reduce;
use super::curvature::curvature_density;
use super::density::{Stretch, check_density};
use super::farthest::{Sampler, first_sample, without_face};
use super::gaps::Gaps;
use super::locks::{Locks, check_number};
use super::mend::mend;
use super::options::{DecimateOptions, Method};
use super::order::pack;
use super::patch::{Compact, Patch};
use super::prepare::{Prepared, prepare};
use super::quadric::Quadrics;
use super::refine::refine;
use super::relax::relax;
use super::resolve::resolve;
use super::result::Decimation;
use super::size::edge_length_for;
use super::splits::mean_of;
use super::surface::Surface;
use super::topology::{Component, components, topology};
use super::{dual, lloyd};
use crate::mesh::vector::distance;
use crate::mesh::{SurfacePoint, TriMesh, vertex_areas};
use catamaran::base::{Error, Progress, Result, check_request};

/// Decimates `mesh` to `n` vertices: a mesh of the same shape and topology, as uniform as possible.
///
/// ```
/// use catamaran_geometry::{decimate::{DecimateOptions, decimate}, mesh::families};
///
/// let sphere = families::icosphere(3)?;
/// let found = decimate(&sphere, 100, &DecimateOptions::new().relaxation(4))?;
/// assert_eq!(found.mesh.vertices().len(), 100);
/// found.mesh.require_closed()?;
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`Decimator::new`] and [`Decimator::decimate`].
pub fn decimate(mesh: &TriMesh, n: usize, options: &DecimateOptions<'_>) -> Result<Decimation> {
    options.progress.watch(|| Decimator::new(mesh, options)?.decimate(n))
}

/// Longest edge before sampling, relative to the edges of the result, so that a cell has vertices
/// on all sides.
const FINE: f64 = 0.7;

/// Bytes for a vertex of the result where the mesh is refined for it: two vertices and four faces
/// of the refined mesh with what is adjacent to them (150 each), and the vertex itself.
const BYTES_OF_A_VERTEX: f64 = 400.0;

/// Decimates one mesh to several sizes.
///
/// Samples are kept between calls: a larger mesh has the samples of a smaller one and more, and a
/// smaller mesh has the first of them, so that levels of detail start from nested samples.
///
/// ```
/// use catamaran_geometry::{decimate::{DecimateOptions, Decimator}, mesh::families};
///
/// let sphere = families::icosphere(3)?;
/// let mut decimator = Decimator::new(&sphere, &DecimateOptions::new())?;
/// for n in [40, 80] {
///     assert_eq!(decimator.decimate(n)?.mesh.vertices().len(), n);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct Decimator<'m, 'o> {
    input: &'m TriMesh,
    options: DecimateOptions<'o>,
    source: Source<'m>,
}

/// The surface from which samples are taken.
struct Source<'m> {
    prepared: Prepared<'m>,
    /// Area of the surface.
    area: f64,
    components: Vec<Component>,
    locks: Locks,
    sampler: Sampler,
}

impl<'m> Source<'m> {
    fn new(mesh: Cow<'m, TriMesh>, options: &DecimateOptions<'_>) -> Result<Self> {
        let given = mesh.vertices().len();
        options.check_ranges()?;
        check_density(options.density, given)?;
        let prepared = prepare(mesh, options.method == Method::Uniform, options.par)?;
        let has_face = |v: &u32| !prepared.surface.links(*v).is_empty();
        let first = match (options.first, &prepared.vertices) {
            (Some(v), Some(vertices)) => {
                // The first part of a vertex that was split.
                let mut parts = (0..).zip(vertices).filter(|&(at, &of)| of == v && has_face(&at));
                let (part, _) = parts.next().ok_or_else(|| without_face("first", v, given))?;
                Some(part)
            }
            (None, Some(vertices)) => {
                let all = (0..vertices.len() as u32).filter(has_face);
                all.min_by_key(|&v| vertices[v as usize])
            }
            (first, None) => first,
        };
        let first = first_sample(&prepared.surface, first)?;
        let mut components = components(&prepared.surface);
        // The samples of components come first, and the vertex that the caller selected is the
        // first of all.
        let at = component_of(&prepared.surface, &components, first);
        components[at].first = first;
        components.swap(0, at);
        if options.method == Method::Thesis && !options.locked.is_empty() {
            let why = "the method of the thesis locks no vertices".into();
            return Err(Error::Argument { what: "locked", why });
        }
        for (what, is_set) in
            [("density", !options.density.is_empty()), ("curvature", options.curvature != 1.0)]
        {
            if options.method == Method::Thesis && is_set {
                let why = "the method of the thesis has the same density everywhere".into();
                return Err(Error::Argument { what, why });
            }
        }
        let locks = Locks::new(&prepared, options.locked, given)?;
        let sampler = Sampler::empty(&prepared.surface, options.par)?;
        let area = prepared.surface.mesh.area();
        Ok(Self { prepared, area, components, locks, sampler })
    }

    /// Measures the surface in lengths for these densities at the vertices of the input, `None` if
    /// they are the same everywhere.
    fn stretch(&mut self, density: Option<&[f64]>) {
        let Prepared { surface, vertices, origins, .. } = &mut self.prepared;
        let Some(density) = density else { return surface.measure(Stretch::default()) };
        let given = (0..surface.len() - origins.len())
            .map(|v| vertices.as_ref().map_or(v, |vertices| vertices[v] as usize));
        let mut roots: Vec<f64> = given.map(|v| density[v].sqrt()).collect();
        for &of in origins.iter() {
            roots.push(mean_of(&roots, of));
        }
        let stretch = Stretch::new(&surface.mesh, roots);
        surface.measure(stretch);
    }

    /// Returns the samples with which all results begin: one in each component, and the locked
    /// vertices.
    fn starts(&self) -> Vec<u32> {
        let mut samples: Vec<u32> = self.components.iter().map(|part| part.first).collect();
        let known: HashSet<u32> = samples.iter().copied().collect();
        samples.extend(self.locks.vertices.iter().filter(|&v| !known.contains(v)));
        samples
    }
}

/// Returns the index of the component of vertex v.
fn component_of(surface: &Surface<'_>, components: &[Component], v: u32) -> usize {
    if components.len() == 1 {
        return 0;
    }
    let mut seen = vec![false; surface.len()];
    let mut open = vec![v];
    let mut lowest = v;
    while let Some(v) = open.pop() {
        lowest = lowest.min(v);
        for link in surface.links(v) {
            if !std::mem::replace(&mut seen[link.to as usize], true) {
                open.push(link.to);
            }
        }
    }
    components.iter().position(|component| component.first == lowest).unwrap_or(0)
}

impl<'m, 'o> Decimator<'m, 'o> {
    /// Prepares the mesh: checks it, and repairs it where it is not a manifold.
    ///
    /// # Errors
    /// [`Error::Mesh`] for a mesh without faces, with lengths out of range, or with a vertex that
    /// can't be cut to a manifold; [`Error::Argument`] when no face has vertex `options.first` or
    /// one of `options.locked`, or `options.density` or `options.curvature` is out of range;
    /// [`Error::OutOfMemory`].
    pub fn new(mesh: &'m TriMesh, options: &DecimateOptions<'o>) -> Result<Self> {
        let source = Source::new(Cow::Borrowed(mesh), options)?;
        Ok(Self { input: mesh, options: *options, source })
    }

    /// Decimates the mesh to `n` vertices.
    ///
    /// # Errors
    /// [`Error::Argument`] when n is more than indices can number, or less than the topology needs:
    /// 4 for every closed component, 3 for every other one, and more for handles, loops and locked
    /// vertices.
    /// [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn decimate(&mut self, n: usize) -> Result<Decimation> {
        let progress = self.options.progress;
        progress.watch(|| self.decimate_watched(n, progress))
    }

    fn decimate_watched(&mut self, n: usize, progress: Progress<'_>) -> Result<Decimation> {
        progress.report(0.0)?;
        self.check(n)?;
        let density = self.density(n)?;
        self.source.stretch(density.as_deref());
        if self.resamples() && self.resample_for(n, progress.part(0.0..0.2))? {
            self.source.stretch(density.as_deref());
        }
        let decimation = match self.options.method {
            Method::Uniform => self.uniform(n, progress.part(0.2..1.0))?,
            Method::Thesis => self.thesis(n, progress.part(0.2..1.0))?,
        };
        progress.report(1.0)?;
        Ok(decimation)
    }

    /// Returns the density of vertices at each vertex of the input; `None` if it is the same
    /// everywhere.
    fn density(&self, n: usize) -> Result<Option<Vec<f64>>> {
        let given = self.options.density;
        if self.options.curvature > 1.0 {
            let mut density = curvature_density(self.input, n, self.options.curvature)?;
            density.iter_mut().zip(given).for_each(|(density, given)| *density *= given);
            return Ok(Some(density));
        }
        let varies = given.iter().any(|&density| density != given[0]);
        Ok(varies.then(|| given.to_vec()))
    }

    fn resamples(&self) -> bool {
        self.options.resample && self.options.method == Method::Uniform
    }

    /// Splits edges longer than those of the result, because samples could not be spread over them.
    /// Returns whether there are such edges.
    fn resample_for(&mut self, n: usize, progress: Progress<'_>) -> Result<bool> {
        let Source { prepared, area, sampler, .. } = &mut self.source;
        let par = self.options.par;
        let Ok(length) = edge_length_for(*area, n) else { return Ok(false) };
        let splits = prepared.surface.longest_edge(par) > length;
        if splits {
            *prepared = prepared.refined(FINE * length, par, progress)?;
            sampler.move_to(&prepared.surface, par)?;
        }
        Ok(splits)
    }

    fn check(&self, n: usize) -> Result<()> {
        let refused = |why| Err(Error::Argument { what: "n", why });
        let surface = &self.source.prepared.surface;
        let there = (0..surface.len() as u32).filter(|&v| !surface.links(v).is_empty()).count();
        if n > there && !self.resamples() {
            return refused(format!(
                "{n}, but the mesh has {there} vertices, and is not resampled"
            ));
        }
        if n > there {
            check_request("n", format_args!("{n} vertices"), n as f64 * BYTES_OF_A_VERTEX)?;
        }
        check_number(&self.source.locks, n)?;
        let components = &self.source.components;
        if self.options.method == Method::Thesis && n < components.len() {
            return refused(format!("{n}, but the mesh has {} components", components.len()));
        }
        let least: usize = components.iter().map(Component::least_vertices).sum();
        if self.options.method == Method::Uniform && n < least {
            return refused(format!(
                "{n}, but {} components need {least} vertices: 4 each, 3 with boundary",
                components.len()
            ));
        }
        Ok(())
    }

    /// Decimates by algorithm 5.1 with algorithm 5.2, and every three-cycle as a face.
    fn thesis(&mut self, n: usize, progress: Progress<'_>) -> Result<Decimation> {
        let Source { prepared, sampler, components, .. } = &mut self.source;
        let surface = &prepared.surface;
        if sampler.samples().is_empty() || sampler.samples().len() > n {
            sampler.start(surface, components[0].first)?;
        }
        sampler.extend_to(surface, n, progress)?;
        let positions = sampler.samples().iter().map(|&v| surface.position(v)).collect();
        let mesh = TriMesh::new(
            positions,
            dual::three_cycles(surface, sampler.growth(), self.options.par),
        )?;
        let places = sampler.samples().iter().map(|&v| at_vertex(surface, v)).collect();
        let cells = sampler.growth().cells(surface.scale);
        self.finish(mesh, cells, places, [0; 3])
    }

    fn uniform(&mut self, n: usize, progress: Progress<'_>) -> Result<Decimation> {
        let par = self.options.par;
        let mut samples = self.source.starts();
        let Source { prepared, area, components, locks, sampler } = &mut self.source;
        let (surface, area) = (&prepared.surface, *area);
        let (growth, taken) = sampler.in_batches();
        let more = taken.iter().skip(samples.len()).take(n.saturating_sub(samples.len()));
        samples.extend(more);
        growth.clear();
        add_samples(surface, area, growth, &mut samples, n, par, progress.part(0.0..0.4))?;
        if samples.len() > taken.len() {
            taken.clone_from(&samples);
        }

        // Cells are about as large as the area that belongs to a sample.
        let radius = (area / n as f64).sqrt() / surface.scale;
        let cutoff = radius as f32;
        let mut areas =
            if self.options.lloyd > 0 { vertex_areas(&surface.mesh) } else { Vec::new() };
        // Cells are as large as a density of centroids to the power -1/2 (Du, Faber and Gunzburger,
        // Centroidal Voronoi Tessellations, 1999).
        (0..).zip(&mut areas).for_each(|(v, area)| *area *= surface.stretch.at(v).powi(4));
        for pass in 0..self.options.lloyd {
            progress.part(0.4..0.6).report(pass as f64 / self.options.lloyd as f64)?;
            let stays = |v: u32| locks.contains(v);
            lloyd::pass(surface, growth, &mut samples, &areas, stays, cutoff)?;
        }
        refine(surface, growth, &mut samples, locks, par, progress.part(0.6..0.7))?;

        let mut patch = dual_patch(surface, growth, &samples, locks, self.options);
        let reach = |patch: &mut Patch| match reduce(patch, n)? {
            left if left == n => Ok(()),
            left => {
                let topology = topology(surface, components.len());
                let locked = match locks.vertices.len() {
                    0 => String::new(),
                    count => format!(" and {count} locked vertices"),
                };
                let why = format!(
                    "{n}, but the topology ({topology}){locked} could not be kept: collapses of \
                     edges ended at {left} vertices, which is about how many are needed"
                );
                Err(Error::Argument { what: "n", why })
            }
        };
        reach(&mut patch)?;
        let narrow = match self.options.cut_narrow_handles {
            true => edge_length_for(area, n).unwrap_or(0.0),
            false => 0.0,
        };
        let passes = self.options.relaxation;
        if passes > 0 {
            patch = pack(patch)?;
            let quadrics = Quadrics::new(surface);
            let (uniform, part) = (self.options.uniform, progress.part(0.7..0.9));
            relax(surface, &quadrics, &mut patch, passes, narrow, uniform, par, part)?;
            reach(&mut patch)?;
            resolve(surface, self.input, &mut patch, par)?;
            growth.clear();
            growth.grow(surface, &anchor_seeds(&patch), cutoff)?;
            growth.grow_on(surface)?;
            let cells = (0..surface.len() as u32).map(|v| growth.cell(v));
            let gaps = Gaps::new(surface, cells, patch.positions().len());
            mend(&gaps, &quadrics, &mut patch, par, progress.part(0.9..0.98))?;
            reach(&mut patch)?;
        }
        let compact = locks.first(patch.compact());
        let locks = [locks.vertices.len(), locks.edges.len(), locks.lost_edges(&compact)];
        let Compact { positions, anchors, on_boundary: on_rim, faces, .. } = compact;
        let mesh = TriMesh::new(positions, faces)?;
        prepared.surface.measure(Stretch::default());
        let surface = &prepared.surface;
        let places: Vec<SurfacePoint> = (0..n)
            .map(|v| {
                let p = mesh.vertices()[v];
                let found = nearest(surface, anchors[v], on_rim[v], p);
                found.map_or_else(|| at_vertex(surface, anchors[v]), |found| found.place)
            })
            .collect();
        growth.clear();
        growth.grow(surface, &place_seeds(surface, &mesh, &places), cutoff)?;
        growth.grow_on(surface)?;
        let cells = growth.cells(surface.scale);
        self.finish(mesh, cells, places, locks)
    }

    /// Returns the result in terms of the input, with the numbers of locked vertices, of edges
    /// between them, and of those edges that are lost.
    fn finish(
        &self,
        mesh: TriMesh,
        cells: Cells,
        mut places: Vec<SurfacePoint>,
        [locked, locked_edges, lost_edges]: [usize; 3],
    ) -> Result<Decimation> {
        let Prepared { surface, vertices, faces, repairs, .. } = &self.source.prepared;
        for (place, &p) in places.iter_mut().zip(mesh.vertices()) {
            let mut face = place.face;
            if let Some(faces) = faces {
                face = faces[face as usize];
            }
            *place = SurfacePoint::nearest(self.input, face, p).0;
        }
        let count = self.input.vertices().len();
        let mut seen_from = vec![u32::MAX; count];
        for v in (0..surface.len() as u32).rev() {
            let old = vertices.as_ref().map_or(v, |vertices| vertices[v as usize]);
            if (old as usize) < count && !surface.links(v).is_empty() {
                seen_from[old as usize] = v;
            }
        }
        let cells = cells.seen_from(&seen_from);
        let before = topology(surface, self.source.components.len());
        let after = Surface::new(Cow::Borrowed(&mesh), self.options.par)
            .map(|surface| topology(&surface, components(&surface).len()));
        let after = match (self.options.method, after) {
            (_, Ok(after)) => Some(after),
            (Method::Thesis, Err(Error::Mesh { .. })) => None,
            (_, Err(error)) => return Err(error),
        };
        let repairs = *repairs;
        Ok(Decimation {
            mesh,
            cells,
            places,
            locked,
            locked_edges,
            lost_edges,
            repairs,
            before,
            after,
        })
    }
}

/// Returns the dual triangulation, with a vertex at each sample, or on the boundary if its cell
/// touches the boundary.
fn dual_patch(
    surface: &Surface<'_>,
    growth: &Growth,
    samples: &[u32],
    locks: &Locks,
    options: DecimateOptions<'_>,
) -> Patch {
    let faces = dual::faces(surface, growth, options.par);
    let positions = samples.iter().map(|&v| surface.position(v)).collect();
    let mut patch = Patch::new(positions, samples.to_vec(), faces);
    let locked = samples.iter().map(|&v| locks.contains(v)).collect();
    patch.lock(locked, locks.edges.clone());
    patch.stretch = surface.stretch.clone();
    let mut nearest = vec![f32::INFINITY; samples.len()];
    for v in (0..surface.len() as u32).filter(|&v| surface.on_boundary[v as usize]) {
        let (cell, distance) = (growth.cell(v) as usize, growth.distance(v));
        let Some(nearest) = nearest.get_mut(cell) else { continue };
        if distance < *nearest && patch.on_boundary[cell] && !patch.locked[cell] {
            *nearest = distance;
            patch.anchors[cell] = v;
            patch.place(cell as u32, surface.position(v));
        }
    }
    patch
}

/// Returns seeds of cells at the vertices near those of the patch.
fn anchor_seeds(patch: &Patch) -> Vec<Seed> {
    let there = (0..).zip(&patch.anchors).filter(|&(v, _)| !patch.around(v).is_empty());
    there.map(|(cell, &vertex)| Seed { vertex, distance: 0.0, cell }).collect()
}

/// Returns seeds of cells at the corners of the faces in which the vertices lie.
fn place_seeds(surface: &Surface<'_>, mesh: &TriMesh, places: &[SurfacePoint]) -> Vec<Seed> {
    let starts = (0..).zip(places).zip(mesh.vertices());
    let corners = starts.flat_map(|((cell, place), &p)| {
        surface.mesh.faces()[place.face as usize].map(|vertex| {
            let length = distance(p, surface.position(vertex)) / surface.scale;
            Seed { vertex, distance: length as f32, cell }
        })
    });
    corners.collect()
}

fn at_vertex(surface: &Surface<'_>, v: u32) -> SurfacePoint {
    let face = surface.faces_of.row(v as usize).first().copied().unwrap_or(0);
    let corners = surface.mesh.faces()[face as usize];
    SurfacePoint { face, weights: corners.map(|w| if w == v { 1.0 } else { 0.0 }) }
}

#[cfg(all(test, debug_assertions))]
mod tests {
    use super::*;
    use crate::mesh::families;
    use catamaran::base::{Par, measure};

    #[test]
    fn work_on_a_pipe_is_in_proportion_to_its_length_and_to_its_sides() {
        let work = |sides: usize, length: usize| {
            let mesh = families::cylinder(sides, 1, 1.0, length as f64).unwrap();
            // Edges of the result have the same length for all.
            let options = DecimateOptions::new().par(Par::Seq);
            let (_, total) = measure::operations(|| {
                decimate(&mesh, length / 3, &options).unwrap();
            });
            println!("{sides} sides, {length} long: {total:.1e} operations");
            total
        };
        let one = work(64, 150);
        // Three faces instead of two for each half made it more than 8 times for 4.
        assert!(work(64, 600) < 6.0 * one);
        assert!(work(256, 150) < 6.0 * one);
    }
}
