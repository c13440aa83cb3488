//! Several curves on one mesh, each reconstructed separately.

use std::collections::HashMap;

use super::inscribe::{Inscribed, inscribe};
use super::result::{Curve, Reconstruction, Waypoint};
use super::sites::with_steiner;
use super::solver::{CurveOptions, CurveSolver};
use crate::mesh::vector::distance;
use crate::mesh::{Refined, TriMesh};
use catamaran::base::{Error, Result};

/// Layers of curves on one mesh. Each layer has its own samples and options. Curves of one layer do
/// not meet; curves of different layers may cross or run along common edges.
///
/// ```
/// use catamaran_geometry::curve::{CurveOptions, Drawing, Region, Side};
/// use catamaran_geometry::mesh::families;
///
/// let mesh = families::grid(8, 8)?;
/// let mut drawing = Drawing::new(mesh.clone())?;
/// drawing.add(&[10, 64, 16, 70], &CurveOptions::new())?; // around 6 x 6 squares
/// drawing.add(&[30, 50, 48, 32], &CurveOptions::new())?; // around 2 x 2 of them
/// let drawn = drawing.inscribe()?;
/// let [large, small] = [0, 1].map(|layer| {
///     let along = drawn.layers[layer].iter().flat_map(|curve| curve.edges()).collect::<Vec<_>>();
///     Region::enclosed(&drawn.refined.mesh, &along, &Side::Seeds(vec![40])).unwrap()
/// });
/// let ring = large.difference(&small)?;
/// assert!((ring.area(&mesh)? - 0.5).abs() < 1e-12); // 32 of 64 squares
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct Drawing {
    solver: CurveSolver<'static>,
    /// The refinement of the original mesh to the mesh of the solver.
    base: Refined,
    layers: Vec<Layer>,
    smooth: bool,
}

struct Layer {
    found: Reconstruction,
    samples: Vec<u32>,
}

/// A mesh with all curves of a drawing along its edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The mesh, with its origin on the mesh of the drawing.
    pub refined: Refined,
    /// The curves of each layer.
    pub layers: Vec<Vec<Curve>>,
}

impl Drawing {
    /// Creates an empty drawing on a mesh.
    ///
    /// # Errors
    /// As [`CurveSolver::new`].
    pub fn new(mesh: TriMesh) -> Result<Self> {
        let base = Refined::new(mesh.clone());
        Ok(Self { solver: CurveSolver::owning(mesh)?, base, layers: Vec::new(), smooth: false })
    }

    /// Returns the mesh with the Steiner points of all layers, on which the paths run.
    pub fn mesh(&self) -> &TriMesh {
        self.solver.mesh()
    }

    /// Returns the refinement of the mesh of the drawing to [`Drawing::mesh`].
    pub fn refinement(&self) -> &Refined {
        &self.base
    }

    /// Returns the reconstruction of each layer. Paths and waypoints refer to [`Drawing::mesh`].
    pub fn found(&self) -> impl Iterator<Item = &Reconstruction> {
        self.layers.iter().map(|layer| &layer.found)
    }

    /// Finds curves through samples, as [`CurveSolver::reconstruct`] does, and adds them as a
    /// layer. Steiner points are also inserted into earlier layers, whose curves do not move.
    ///
    /// # Errors
    /// As [`CurveSolver::reconstruct`]; [`Error::Argument`] after [`Drawing::smooth`].
    pub fn add(&mut self, samples: &[u32], options: &CurveOptions<'_>) -> Result<&Reconstruction> {
        if self.smooth {
            let why = "no layer can be added after `smooth`".into();
            return Err(Error::Argument { what: "samples", why });
        }
        let found = self.solver.reconstruct(samples, options)?;
        if !found.steiner.is_empty() {
            let first = self.mesh().vertices().len() as u32;
            let finer = with_steiner(self.mesh(), &found.steiner)?;
            self.base = self.base.then(finer);
            for layer in &mut self.layers {
                for curve in &mut layer.found.curves {
                    carry(curve, first, &found.steiner, &self.base.mesh);
                }
            }
            self.solver = CurveSolver::owning(self.base.mesh.clone())?;
        }
        self.layers.push(Layer { found, samples: samples.to_vec() });
        Ok(&self.layers[self.layers.len() - 1].found)
    }

    /// Shortens all curves to geodesics between their samples, as [`Reconstruction::smooth`] does,
    /// and returns whether the steps sufficed. No layer can be added after that.
    ///
    /// # Errors
    /// As [`super::smooth()`].
    pub fn smooth(&mut self) -> Result<bool> {
        self.smooth = true;
        let mut converged = true;
        for layer in &mut self.layers {
            converged &= layer.found.shorten(self.solver.mesh(), &layer.samples)?;
        }
        Ok(converged)
    }

    /// Returns a mesh with the curves of all layers along its edges.
    ///
    /// ```
    /// use catamaran_geometry::curve::{CurveOptions, Drawing};
    /// use catamaran_geometry::mesh::families;
    ///
    /// let mut drawing = Drawing::new(families::grid(8, 8)?)?;
    /// drawing.add(&[10, 64, 16, 70], &CurveOptions::new())?;
    /// assert!(drawing.smooth()?);
    /// let drawn = drawing.inscribe()?;
    /// assert!((drawn.layers[0][0].length - 3.0).abs() < 1e-9);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`inscribe()`].
    pub fn inscribe(&self) -> Result<Drawn> {
        let all: Vec<Curve> = self.found().flat_map(|found| found.curves.iter().cloned()).collect();
        let Inscribed { refined, curves } = inscribe(self.mesh(), &all)?;
        let mut curves = curves.into_iter();
        let layers = self.found().map(|found| curves.by_ref().take(found.curves.len()).collect());
        Ok(Drawn { layers: layers.collect(), refined: self.base.then(refined) })
    }
}

/// Transfers a curve along edges to the mesh on which some of these edges were cut in their middle.
fn carry(curve: &mut Curve, first: u32, steiner: &[[u32; 2]], mesh: &TriMesh) {
    let middles: HashMap<[u32; 2], u32> =
        steiner.iter().zip(first..).map(|(&[a, b], v)| ([a.min(b), a.max(b)], v)).collect();
    let mut path = Vec::new();
    let next = curve.path.iter().skip(1).chain(curve.path.first().filter(|_| curve.closed));
    for (&a, &b) in curve.path.iter().zip(next) {
        // The parts of the edge from a to b that are still to be checked, the first one on top.
        let mut waiting = vec![[a, b]];
        while let Some([a, b]) = waiting.pop() {
            match middles.get(&[a.min(b), a.max(b)]) {
                Some(&middle) => waiting.extend([[middle, b], [a, middle]]),
                None => path.push(a),
            }
        }
    }
    path.extend(curve.path.last().filter(|_| !curve.closed));
    if path.len() == curve.path.len() {
        return;
    }
    curve.points = path.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    curve.waypoints = path.iter().map(|&v| Waypoint::Vertex(v)).collect();
    curve.path = path;
    let next = curve.points.iter().skip(1).chain(curve.points.first().filter(|_| curve.closed));
    curve.length = curve.points.iter().zip(next).map(|(&p, &q)| distance(p, q)).sum();
}
