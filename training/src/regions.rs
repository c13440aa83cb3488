//! Regions on a template, as coefficients of its eigenfunctions: the form in which the network
//! predicts where unions are (thesis, section 2.6.2).

use std::borrow::Cow;

use catamaran::base::{Pin, Progress, ThreadPool};
use catamaran::faer::Mat;
use catamaran::{Par, Result};
use catamaran_geometry::decimate::FarthestPoints;
use catamaran_geometry::unions::Localizer;
use rayon::prelude::*;

use crate::dataset::Template;

/// Number of anchors per eigenfunction.
const ANCHORS: usize = 2;

/// Typical size of a coefficient, relative to that of the complete shape. The network learns
/// coefficients divided by this unit, which are about 1.
pub const UNIT: f64 = 1.0 / 16.0;

/// The regions of a template.
#[derive(Debug, Clone, Default)]
pub struct Regions {
    modes: usize,
    /// Ids of the masks, ascending.
    ids: Vec<usize>,
    /// Coefficients of each mask in units of [`UNIT`].
    coefficients: Vec<f32>,
    /// For each mask, whether more of it is on the right, the side of negative x.
    on_the_right: Vec<bool>,
    /// The matrix, by rows, that maps coefficients to those of the mirror image.
    mirror: Vec<f32>,
}

impl Regions {
    /// Computes the coefficients of all masks of the template. The result does not depend on the
    /// number of threads.
    ///
    /// # Errors
    /// When threads can't be created.
    pub fn new(template: &Template, par: Par) -> Result<Self> {
        let functions = &template.eigenfunctions;
        let modes = functions.ncols();
        let unit = unit(template);
        let weighted = |v: usize| {
            let factor = template.mass[v] / unit;
            (0..modes).map(move |j| (factor * functions[(v, j)]) as f32)
        };
        let rows: Vec<f32> = (0..template.vertices.len()).flat_map(weighted).collect();
        let side = |v: usize| match template.vertices[v][0] {
            x if x > 0.0 => template.mass[v],
            x if x < 0.0 => -template.mass[v],
            _ => 0.0,
        };
        let one = |&id: &usize| {
            let mask = template.mask(id).unwrap_or_default();
            let mut sums = vec![0.0f32; modes];
            for &v in &mask {
                let row = &rows[v * modes..(v + 1) * modes];
                sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
            }
            (sums, mask.iter().map(|&v| side(v)).sum::<f64>() < 0.0)
        };
        let team = ThreadPool::new(par.threads(), Pin::No)?;
        let found: Vec<(Vec<f32>, bool)> =
            team.run(|| template.masks.par_iter().map(one).collect());
        let mirrored =
            Mat::from_fn(functions.nrows(), modes, |v, j| functions[(template.mirror[v], j)]);
        let weighted =
            Mat::from_fn(functions.nrows(), modes, |v, j| template.mass[v] * mirrored[(v, j)]);
        let mirror = functions.transpose() * weighted;
        let entries = (0..modes * modes).map(|at| mirror[(at / modes, at % modes)] as f32);
        Ok(Self {
            modes,
            ids: template.masks.clone(),
            on_the_right: found.iter().map(|(_, right)| *right).collect(),
            coefficients: found.into_iter().flat_map(|(sums, _)| sums).collect(),
            mirror: entries.collect(),
        })
    }

    /// Returns no regions, with `modes` coefficients per region.
    pub fn none(modes: usize) -> Self {
        Self { modes, ..Self::default() }
    }

    /// Returns the number of the region of a mask.
    pub fn number(&self, id: usize) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    /// Returns the number of coefficients per region.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Returns the coefficients of a region, in units of [`UNIT`].
    pub fn coefficients(&self, number: usize) -> &[f32] {
        &self.coefficients[number * self.modes..(number + 1) * self.modes]
    }

    /// Returns the coefficients of the region or of its mirror image, whichever has more area on
    /// the left. A spectrum alone does not distinguish the two, so the left one is chosen.
    pub fn on_the_left(&self, number: usize) -> Cow<'_, [f32]> {
        let own = self.coefficients(number);
        if !self.on_the_right[number] {
            return own.into();
        }
        let entry = |row: &[f32]| row.iter().zip(own).map(|(m, x)| m * x).sum();
        self.mirror.chunks_exact(self.modes).map(entry).collect()
    }
}

/// Returns the unit of the coefficients of a template, which grow with the square root of its area.
fn unit(template: &Template) -> f64 {
    UNIT * template.mass.iter().sum::<f64>().sqrt()
}

/// Creates the localizer of a template: its eigenfunctions, in units of the coefficients, at
/// vertices far from one another.
///
/// # Errors
/// When the template is not a surface.
pub fn localizer(template: &Template) -> Result<Localizer> {
    let modes = template.eigenfunctions.ncols();
    let mesh = template.mesh()?;
    let mut sampler = FarthestPoints::new(&mesh, None)?;
    sampler.extend_to((ANCHORS * modes).min(template.vertices.len()), Progress::none())?;
    let mut anchors: Vec<usize> = sampler.samples().iter().map(|&v| v as usize).collect();
    anchors.sort_unstable();
    let unit = unit(template);
    let at = anchors.iter().flat_map(|&v| (0..modes).map(move |j| (v, j)));
    let values = at.map(|(v, j)| (unit * template.eigenfunctions[(v, j)]) as f32).collect();
    Localizer::new(modes, anchors, values, template.vertices.len())
}
