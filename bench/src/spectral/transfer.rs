//! Tables 1.2 to 1.4: functions transferred between two shapes.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::{Mat, MatRef};
use catamaran::spectral::descriptors::{
    heat_kernel, heat_kernel_signature, heat_times, wave_kernel_signature, wave_scales,
};
use catamaran::spectral::functional_map::{MapFit, map_from_points, points_from_map, pull_back};
use catamaran::spectral::{
    Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, ProductMap, Transfer,
    TruncatedProducts, relative_errors,
};

use super::shapes::{Pair, Shapes};
use super::signals::{MANY, signals};
use super::table::{Table, average, mean};
use crate::Result;

/// A table of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// Table 1.2: nearly isometric.
    Isometric,
    /// Table 1.3: not isometric.
    People,
    /// Table 1.4: other connections.
    Remeshed,
}

const COLUMNS: [&str; 5] = ["K", "prods", "ours", "ours*", "NK"];

/// Vertices whose correspondence is given, beside descriptors.
const LANDMARKS: usize = 7;
/// Scales of the descriptors that the functional map is fitted to.
const SCALES: usize = 20;
/// The time of heat kernels around landmarks, on shapes of area 1.
const TIME: f64 = 1e-2;

/// The thesis' errors, in per cent.
const THESIS: [[[f64; 5]; 9]; 3] = [
    [
        [70.3, 64.4, 50.9, 52.0, 17.7],
        [78.4, 61.3, 52.8, 55.9, 56.4],
        [12.0, 10.4, 5.5, 5.6, 5.9],
        [29.3, 22.0, 10.6, 10.8, 17.7],
        [50.7, 54.8, 49.9, 50.0, 50.8],
        [40.6, 44.5, 32.4, 33.2, 21.3],
        [47.7, 51.2, 27.2, 24.8, 35.9],
        [74.6, 73.3, 65.4, 65.3, 67.0],
        [31.4, 35.4, 23.8, 24.2, 22.9],
    ],
    [
        [28.0, 27.4, 26.6, 27.1, 22.5],
        [66.7, 51.3, 46.4, 46.4, 56.3],
        [8.1, 12.3, 6.6, 6.7, 8.2],
        [16.7, 15.5, 11.4, 11.6, 12.3],
        [49.9, 51.0, 49.6, 50.5, 50.0],
        [21.3, 21.9, 19.5, 20.0, 19.5],
        [36.4, 33.7, 30.1, 30.2, 31.4],
        [76.6, 75.1, 73.7, 76.3, 70.7],
        [15.1, 18.3, 13.4, 13.9, 14.7],
    ],
    [
        [27.9, 29.3, 26.2, 26.4, 30.4],
        [79.9, 67.4, 62.7, 62.8, 75.8],
        [12.6, 17.5, 10.7, 10.8, 13.7],
        [25.4, 21.6, 18.5, 18.6, 22.4],
        [50.8, 52.8, 50.2, 50.4, 51.5],
        [30.5, 30.2, 29.2, 29.6, 30.8],
        [41.0, 38.2, 34.8, 35.7, 36.6],
        [66.3, 66.0, 62.8, 64.7, 64.8],
        [24.6, 28.0, 21.4, 21.6, 25.6],
    ],
];

impl Setting {
    /// The order of products, and the eigenfunctions of source and target beside the constant.
    fn parameters(self) -> (usize, [usize; 2]) {
        match self {
            Self::Isometric => (3, [12, 12]),
            Self::People | Self::Remeshed => (2, [30, 40]),
        }
    }
}

/// The table, averaged over the pairs; `None` where there are none.
///
/// # Errors
/// Those of the library.
pub fn transfer(shapes: &Shapes, setting: Setting) -> Result<Option<Table>> {
    let (order, [k, l]) = setting.parameters();
    let (number, what, pairs) = match setting {
        Setting::Isometric => ("1.2", "poses of a figure", shapes.isometric(MANY)?),
        Setting::People => ("1.3", "two people, surfaces of a brain", shapes.people(MANY)?),
        Setting::Remeshed => ("1.4", "figures of other fineness and pose", shapes.remeshed(MANY)?),
    };
    if pairs.is_empty() {
        return Ok(None);
    }
    let tables: Vec<_> =
        pairs.iter().map(|pair| errors(pair, order, [k, l])).collect::<Result<_>>()?;
    Ok(Some(Table {
        number,
        title: format!("transfer, {what}: {} pairs, N = {order}, K = {k} and {l}", pairs.len()),
        columns: &COLUMNS,
        ours: average(&tables),
        thesis: THESIS[setting as usize].iter().map(|row| row.to_vec()).collect(),
    }))
}

/// Heat and wave kernel signatures.
fn descriptors(basis: &Eigenbasis) -> Result<[Mat<f64>; 2]> {
    let times = heat_times(basis.values(), SCALES)?;
    let waves = wave_scales(basis.values(), SCALES)?;
    Ok([
        heat_kernel_signature(basis.values(), basis.functions(), &times, Par::all())?,
        wave_kernel_signature(basis.values(), basis.functions(), &waves, Par::all())?,
    ])
}

/// Pairs of corresponding vertices, spread over the target.
fn landmarks(pair: &Pair) -> Vec<(u32, u32)> {
    let points = pair.target.mesh.vertices();
    let square = |p: [f64; 3], q: [f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>();
    let mut far = vec![f64::INFINITY; points.len()];
    let mut found = vec![0_usize];
    while found.len() < LANDMARKS {
        let last = points[found[found.len() - 1]];
        for (distance, &p) in far.iter_mut().zip(points) {
            *distance = distance.min(square(p, last));
        }
        let next = (0..points.len()).max_by(|&x, &y| far[x].total_cmp(&far[y]).then(y.cmp(&x)));
        found.extend(next);
    }
    found.into_iter().map(|v| (pair.truth[v], v as u32)).collect()
}

/// The functional map between the first eigenfunctions, from descriptors, landmarks, and multiplications by functions around
/// landmarks (the method of reference 194 of the thesis: Nogneng and Ovsjanikov 2017).
pub fn fitted(pair: &Pair, source: &Eigenbasis, target: &Eigenbasis) -> Result<Mat<f64>> {
    let mut fit = MapFit::new(source, target, Par::all());
    let [many, others] = [&pair.source, &pair.target].map(|shape| shape.first(MANY));
    let (many, others) = (many?, others?);
    for (f, g) in descriptors(&many)?.iter().zip(&descriptors(&others)?) {
        fit.functions(f.as_ref(), g.as_ref())?;
    }
    let pairs = landmarks(pair);
    fit.landmarks(&pairs)?;
    // Signatures do not know left from right; what is around landmarks does.
    let [f, g] =
        [around(&many, pairs.iter().map(|p| p.0))?, around(&others, pairs.iter().map(|p| p.1))?];
    fit.operators(f.as_ref(), g.as_ref(), MapFit::MULTIPLICATIONS)?;
    Ok(fit.solve(MapFit::COMMUTATIVITY)?)
}

/// Heat kernels around vertices.
fn around(basis: &Eigenbasis, vertices: impl Iterator<Item = u32>) -> Result<Mat<f64>> {
    let kernel = |v: u32| heat_kernel(basis.values(), basis.functions(), v as usize, TIME);
    let kernels: Vec<_> = vertices.map(kernel).collect::<std::result::Result<_, _>>()?;
    Ok(Mat::from_fn(basis.basis().vertices(), kernels.len(), |x, j| kernels[j][x]))
}

/// Singular values of products that are left out, as a part of the largest: as the code published with the thesis does, for
/// `k` eigenfunctions beside the constant.
pub fn truncation(k: usize) -> f64 {
    2e-3 * (k as f64 - 1.0)
}

fn errors(pair: &Pair, order: usize, [k, l]: [usize; 2]) -> Result<Vec<Vec<f64>>> {
    let par = Par::all();
    let (source, target) = (pair.source.first(k)?, pair.target.first(l)?);
    let c = fitted(pair, &source, &target)?;
    let points =
        points_from_map(c.as_ref(), source.basis(), target.basis(), par, Progress::none())?;

    let bases = |orthogonalization| -> Result<[ProductBasis; 2]> {
        let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
        Ok([
            ProductBasis::new(&source, order, &options)?,
            ProductBasis::new(&target, order, &options)?,
        ])
    };
    let ours = bases(Orthogonalization::SinglePass)?;
    let ours_star = bases(Orthogonalization::Reorthogonalized)?;
    let by_points =
        |[from, to]: &[ProductBasis; 2]| map_from_points(&points, from.basis(), to.basis(), par);
    let (o, o_star) = (by_points(&ours)?, by_points(&ours_star)?);

    let prods = TruncatedProducts::new(&ours_star[0], truncation(k), par)?;
    let images = TruncatedProducts::new(&ours_star[1], truncation(l), par)?;
    let extended = ProductMap::new(c.as_ref(), &source, &target, order)?;

    let (more, more_target) = (pair.source.first(order * k)?, pair.target.first(order * l)?);
    let c_more = fitted(pair, &more, &more_target)?;

    let eigen = Transfer::new(source.basis(), target.basis(), c.clone())?;
    let eigen_more = Transfer::new(more.basis(), more_target.basis(), c_more)?;
    let orthogonal = Transfer::new(ours[0].basis(), ours[1].basis(), o)?;
    let orthogonal_star = Transfer::new(ours_star[0].basis(), ours_star[1].basis(), o_star)?;

    let mass = target.basis().mass();
    let mut rows = Vec::new();
    for f in signals(&pair.source, k)? {
        let f = f.as_ref();
        let truth = pull_back(&pair.truth, f)?;
        let error = |g: MatRef<'_, f64>| -> Result<f64> {
            Ok(mean(&relative_errors(truth.as_ref(), g, mass)?))
        };
        let coefficients = extended.apply(prods.analysis(f, par)?.as_ref(), par)?;
        rows.push(vec![
            error(eigen.apply(f, par)?.as_ref())?,
            error(images.synthesis(coefficients.as_ref(), par)?.as_ref())?,
            error(orthogonal.apply(f, par)?.as_ref())?,
            error(orthogonal_star.apply(f, par)?.as_ref())?,
            error(eigen_more.apply(f, par)?.as_ref())?,
        ]);
    }
    Ok(rows)
}
