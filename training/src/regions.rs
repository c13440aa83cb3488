//! Regions on a template, as coefficients of its eigenfunctions: what the network says of where
//! unions are (thesis, section 2.6.2).

use std::borrow::Cow;

use catamaran::base::{Pin, Progress, ThreadPool};
use catamaran::decimate::FarthestPoints;
use catamaran::faer::Mat;
use catamaran::unions::Localizer;
use catamaran::{Par, Result};
use rayon::prelude::*;

use crate::dataset::Template;

/// Anchors for each eigenfunction.
const ANCHORS: usize = 2;

/// Typical size of a coefficient, in units of that of the complete shape: the network learns
/// numbers of about the size 1.
pub const UNIT: f64 = 1.0 / 16.0;

/// The regions of a template.
#[derive(Debug, Clone, Default)]
pub struct Regions {
    modes: usize,
    /// Ids of masks, ascending.
    ids: Vec<usize>,
    /// For each id its coefficients in units of [`UNIT`].
    coefficients: Vec<f32>,
    /// For each id whether more of it is on the right, the side of negative x.
    on_the_right: Vec<bool>,
    /// What takes coefficients to those of the mirror image, by rows.
    mirror: Vec<f32>,
}

impl Regions {
    /// Those of all masks of the template. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// When threads can't be had.
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

    /// No regions, of so many coefficients.
    pub fn none(modes: usize) -> Self {
        Self { modes, ..Self::default() }
    }

    /// The number of a mask.
    pub fn number(&self, id: usize) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    /// Coefficients of a region, each.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// The coefficients of a region, in units of [`UNIT`].
    pub fn coefficients(&self, number: usize) -> &[f32] {
        &self.coefficients[number * self.modes..(number + 1) * self.modes]
    }

    /// The same of the region or its mirror image, whichever has more on the left: which one of the
    /// two a spectrum alone means.
    pub fn on_the_left(&self, number: usize) -> Cow<'_, [f32]> {
        let own = self.coefficients(number);
        if !self.on_the_right[number] {
            return own.into();
        }
        let entry = |row: &[f32]| row.iter().zip(own).map(|(m, x)| m * x).sum();
        self.mirror.chunks_exact(self.modes).map(entry).collect()
    }
}

/// The unit of coefficients of a template: they grow with the root of the area.
fn unit(template: &Template) -> f64 {
    UNIT * template.mass.iter().sum::<f64>().sqrt()
}

/// The localizer of a template: its eigenfunctions, in units of coefficients, at vertices far from
/// one another.
///
/// # Errors
/// Of a template that is no surface.
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
