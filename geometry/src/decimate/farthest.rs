//! Voronoi farthest point sampling, one sample after the other (thesis, algorithm 5.2).

use std::borrow::Cow;
use std::collections::BinaryHeap;

use super::batches::seeds;
use super::cells::{Cells, Growth};
use super::surface::Surface;
use crate::mesh::TriMesh;
use catamaran::base::{Error, Par, Progress, Result};

/// Farthest points of a mesh with their Voronoi cells, one after the other: each new sample is the
/// vertex farthest along edges from the previous ones, the lowest of several; a component without a
/// sample is infinitely far (thesis, algorithm 5.2, with the order of its inner queue corrected).
/// Any mesh is allowed.
///
/// Samples can be added at any time, and the first samples do not depend on how many follow:
/// prefixes are nested levels of detail. O(V log V log n) for n samples of V vertices.
///
/// ```
/// use catamaran::base::Progress;
/// use catamaran_geometry::{decimate::FarthestPoints, mesh::families};
///
/// let line = families::grid(10, 1)?;
/// let mut points = FarthestPoints::new(&line, Some(0))?;
/// points.extend_to(3, Progress::none())?;
/// assert_eq!((points.samples().len(), points.samples()[0]), (3, 0));
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct FarthestPoints<'m> {
    surface: Surface<'m>,
    sampler: Sampler,
}

impl<'m> FarthestPoints<'m> {
    /// Takes the first sample: vertex `first`, or by default the lowest vertex with a face.
    ///
    /// # Errors
    /// [`Error::Argument`] when no face has vertex `first`, [`Error::Mesh`] when there is no face,
    /// or lengths are out of range; [`Error::OutOfMemory`].
    pub fn new(mesh: &'m TriMesh, first: Option<u32>) -> Result<Self> {
        let surface = Surface::of_edges(Cow::Borrowed(mesh), Par::Seq)?;
        let mut sampler = Sampler::empty(&surface, Par::Seq)?;
        sampler.start(&surface, first_sample(&surface, first)?)?;
        Ok(Self { surface, sampler })
    }

    /// Adds samples until there are n; does nothing when there already are. The callback may
    /// cancel; the samples so far stay.
    ///
    /// # Errors
    /// [`Error::Argument`] when fewer vertices have faces, [`Error::Cancelled`].
    pub fn extend_to(&mut self, n: usize, progress: Progress<'_>) -> Result<()> {
        self.sampler.extend_to(&self.surface, n, progress)
    }

    /// Returns the samples, in the order in which they were taken.
    pub fn samples(&self) -> &[u32] {
        &self.sampler.samples
    }

    /// Returns the cells of the samples, numbered like [`FarthestPoints::samples`].
    ///
    /// ```
    /// use catamaran::base::Progress;
    /// use catamaran_geometry::{decimate::FarthestPoints, mesh::families};
    ///
    /// let line = families::grid(10, 1)?;
    /// let mut points = FarthestPoints::new(&line, Some(0))?;
    /// points.extend_to(2, Progress::none())?;
    /// let cells = points.cells();
    /// let far = points.samples()[1] as usize;
    /// assert_eq!((cells.of_vertices()[0], cells.of_vertices()[far]), (0, 1));
    /// assert!((cells.radius() - 1.0).abs() < 1e-5);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn cells(&self) -> Cells {
        self.sampler.growth.cells(self.surface.scale)
    }
}

/// Samples of a surface with their cells.
pub(super) struct Sampler {
    growth: Growth,
    samples: Vec<u32>,
    /// Distance from the samples from which on vertices are in the heap.
    threshold: f32,
    /// Vertices by their distance when they were inserted, the farthest first, in order of index
    /// for equal distances. Their current distance may be smaller.
    waiting: BinaryHeap<u64>,
}

/// Share of the largest distance from which on vertices are in the heap: a heap of all would be
/// slow.
const WAITING: f32 = 0.9;

impl Sampler {
    /// Creates a sampler without samples.
    pub fn empty(surface: &Surface<'_>, par: Par) -> Result<Self> {
        Ok(Self {
            growth: Growth::new(surface, par)?,
            samples: Vec::new(),
            threshold: f32::INFINITY,
            waiting: BinaryHeap::new(),
        })
    }

    /// Continues on a surface with additional vertices, which come after the existing ones. Samples
    /// stay; cells grow again.
    pub fn move_to(&mut self, surface: &Surface<'_>, par: Par) -> Result<()> {
        self.growth = Growth::new(surface, par)?;
        Ok(())
    }

    /// Takes the first sample, and its cell, which is the whole component.
    pub fn start(&mut self, surface: &Surface<'_>, first: u32) -> Result<()> {
        self.growth.clear();
        self.samples = vec![first];
        self.threshold = f32::INFINITY;
        self.waiting.clear();
        self.growth.grow(surface, &seeds(&self.samples, 0), f32::INFINITY)
    }

    /// Returns the samples.
    pub fn samples(&self) -> &[u32] {
        &self.samples
    }

    /// Returns the growth of the cells.
    pub fn growth(&self) -> &Growth {
        &self.growth
    }

    /// Returns the growth and the samples, for samples in batches.
    pub fn in_batches(&mut self) -> (&mut Growth, &mut Vec<u32>) {
        (&mut self.growth, &mut self.samples)
    }

    /// Adds farthest points until there are n.
    pub fn extend_to(
        &mut self,
        surface: &Surface<'_>,
        n: usize,
        progress: Progress<'_>,
    ) -> Result<()> {
        let start = self.samples.len();
        while self.samples.len() < n {
            let done = self.samples.len() - start;
            if done.is_multiple_of(64) {
                progress.report(done as f64 / (n - start) as f64)?;
            }
            let Some(farthest) = self.farthest(surface) else {
                let why = format!("{n}, but only {} vertices have faces", self.samples.len());
                return Err(Error::Argument { what: "n", why });
            };
            self.samples.push(farthest);
            let seed = seeds(&self.samples, self.samples.len() - 1);
            self.growth.grow(surface, &seed, f32::INFINITY)?;
        }
        Ok(())
    }

    fn farthest(&mut self, surface: &Surface<'_>) -> Option<u32> {
        loop {
            while let Some(key) = self.waiting.pop() {
                let (was, v) = (f32::from_bits((key >> 32) as u32), !key as u32);
                let is = self.growth.distance(v);
                if is == was {
                    return Some(v);
                }
                if is >= self.threshold {
                    self.waiting.push(waiting_key(is, v));
                }
            }
            let growth = &self.growth;
            let vertices = || (0..surface.len() as u32).filter(|&v| !surface.links(v).is_empty());
            let largest = vertices().map(|v| growth.distance(v)).fold(0.0, f32::max);
            if largest == 0.0 {
                return None;
            }
            self.threshold = WAITING * largest;
            let keys = vertices().map(|v| (growth.distance(v), v));
            let far = keys.filter(|&(distance, _)| distance >= self.threshold);
            self.waiting.extend(far.map(|(distance, v)| waiting_key(distance, v)));
        }
    }
}

/// Returns a key in the order of distance; for equal distances, the lowest vertex comes first.
fn waiting_key(distance: f32, v: u32) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(!v)
}

/// Returns vertex `first`, or the lowest vertex with a face.
pub(super) fn first_sample(surface: &Surface<'_>, first: Option<u32>) -> Result<u32> {
    let has_face = |v: u32| (v as usize) < surface.len() && !surface.links(v).is_empty();
    match first {
        Some(v) if has_face(v) => Ok(v),
        Some(v) => Err(without_face("first", v, surface.len())),
        None => (0..surface.len() as u32)
            .find(|&v| has_face(v))
            .ok_or_else(|| Error::Mesh { what: "has no face".into(), element: "mesh".into() }),
    }
}

/// Returns the error of a sample that no face has; `vertices` are those of the mesh, and `what` is
/// the option that names the sample.
pub(super) fn without_face(what: &'static str, v: u32, vertices: usize) -> Error {
    let why = format!("must be a vertex with a face, is {v} of {vertices}");
    Error::Argument { what, why }
}
