//! Tables 1.2 to 1.6: functions transferred between two shapes.

use std::rc::Rc;

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::{Mat, MatRef};
use catamaran_geometry::spectral::functional_map::{
    MapFit, icp, map_from_points, points_from_map, pull_back,
};
use catamaran_geometry::spectral::{
    Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, ProductMap, Transfer,
    TruncatedProducts, relative_errors,
};

use super::prods::{published, tolerances};
use super::shapes::{Pair, Shape, Shapes};
use super::signals::{MANY, Signals, signals};
use super::table::{Table, average, mean};
use crate::Result;

/// The setting of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// Table 1.2: nearly isometric.
    Isometric,
    /// Table 1.3: not isometric, two people.
    People,
    /// Table 1.3 again: not isometric, surfaces of a brain.
    Brains,
    /// Table 1.4: different connectivity.
    Remeshed,
    /// Table 1.5: different connectivity, from nearly isometric to a missing part; errors at
    /// landmarks.
    Graded,
    /// Table 1.6: far from isometric; errors at landmarks.
    Distant,
}

/// All settings, in the order of the tables.
pub const SETTINGS: [Setting; 6] = [
    Setting::Isometric,
    Setting::People,
    Setting::Brains,
    Setting::Remeshed,
    Setting::Graded,
    Setting::Distant,
];

const COLUMNS: [&str; 5] = ["K", "prods", "ours", "ours*", "NK"];

/// Number of vertices whose correspondence is given, in addition to descriptors.
pub(super) const LANDMARKS: usize = 7;
/// Number of landmarks at which errors are measured, in table 1.5.
pub(super) const EVALUATED: usize = 50;
/// Number of iterations of ICP.
const ICP: usize = 5;

/// The thesis' errors, in per cent.
static THESIS: [[[f64; 5]; 9]; 5] = [
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
    [
        [12.2, 15.8, 15.2, 13.0, 14.8],
        [4.4, 5.9, 5.3, 3.2, 4.8],
        [26.6, 30.9, 23.6, 23.6, 26.7],
        [19.2, 25.1, 17.7, 17.7, 19.9],
        [26.8, 40.4, 27.2, 25.2, 26.9],
        [18.1, 51.5, 11.9, 7.4, 20.4],
        [21.0, 26.1, 20.4, 18.6, 22.1],
        [10.4, 15.8, 12.6, 11.3, 10.7],
        [18.8, 30.8, 20.4, 18.3, 19.6],
    ],
    [
        [11.0, 10.6, 12.0, 9.2, 8.7],
        [3.1, 3.7, 2.9, 2.1, 3.2],
        [5.8, 6.2, 5.4, 5.4, 9.6],
        [11.0, 8.2, 7.3, 7.3, 9.3],
        [25.4, 28.6, 25.2, 25.4, 25.9],
        [20.1, 21.1, 19.5, 19.2, 18.1],
        [10.9, 10.1, 8.0, 6.9, 11.3],
        [0.2, 0.2, 0.2, 0.2, 0.2],
        [5.9, 7.8, 6.5, 6.3, 5.6],
    ],
];

impl Setting {
    /// Returns the order of products, and the numbers of eigenfunctions of source and target
    /// besides the constant.
    pub(super) fn parameters(self) -> (usize, [usize; 2]) {
        match self {
            Self::Isometric | Self::Graded | Self::Distant => (3, [12, 12]),
            Self::People | Self::Brains | Self::Remeshed => (2, [30, 40]),
        }
    }

    /// Returns the errors of the thesis in per cent, a row for each function, a column for each of
    /// K, prods, ours, ours* and NK.
    pub(super) fn thesis(self) -> &'static [[f64; 5]; 9] {
        &THESIS[self.table().1]
    }

    /// Returns the table of the thesis: its number, and its index from table 1.2 on.
    pub(super) fn table(self) -> (&'static str, usize) {
        match self {
            Self::Isometric => ("1.2", 0),
            Self::People => ("1.3", 1),
            Self::Brains => ("1.3 brains", 1),
            Self::Remeshed => ("1.4", 2),
            Self::Graded => ("1.5", 3),
            Self::Distant => ("1.6", 4),
        }
    }

    fn pairs(self, shapes: &Shapes) -> Result<(&'static str, Vec<Pair>)> {
        Ok(match self {
            Self::Isometric => ("poses of a figure", shapes.isometric(MANY)?),
            Self::People => ("two people", shapes.people(MANY)?),
            Self::Brains => ("surfaces of a brain", shapes.brains(MANY)?),
            Self::Remeshed => (
                "figures of other fineness and pose, people and brains decimated",
                shapes.remeshed(MANY)?,
            ),
            Self::Graded => (
                "figures, people, brains twice and a part of a man, in place of SHREC'20, at 50 landmarks",
                shapes.graded(MANY)?,
            ),
            Self::Distant => (
                "people and brains far from isometric, in place of MISC, at a tenth of the vertices",
                shapes.distant(MANY)?,
            ),
        })
    }

    /// Returns the landmarks at which errors are measured; `None` if they are measured over the
    /// whole surface.
    fn landmarks(self, pair: &Pair) -> Option<Vec<u32>> {
        match self {
            Self::Graded => Some(pair.samples(EVALUATED)),
            Self::Distant => Some(pair.samples(pair.truth.len() / 10)),
            _ => None,
        }
    }
}

/// Returns the table, averaged over the pairs; `None` without pairs.
///
/// # Errors
/// The errors of the library.
pub fn transfer(shapes: &Shapes, setting: Setting) -> Result<Option<Table>> {
    let (order, [k, l]) = setting.parameters();
    let (number, place) = setting.table();
    let (what, pairs) = setting.pairs(shapes)?;
    if pairs.is_empty() {
        return Ok(None);
    }
    let mut tables = Vec::new();
    let mut known: Option<(&Rc<Shape>, Signals)> = None;
    for pair in &pairs {
        if known.as_ref().is_none_or(|(shape, _)| !Rc::ptr_eq(shape, &pair.source)) {
            known = Some((&pair.source, signals(&pair.source, k)?));
        }
        let Some((_, signals)) = &known else { continue };
        tables.push(errors(pair, signals, setting)?);
    }
    let title = format!(
        "transfer, {what}: {} pairs, N = {order}, K = {k} and {l}; prods from {:.3} of the largest singular value, as \
         published",
        pairs.len(),
        published(k)
    );
    let thesis = THESIS[place].iter().map(|row| row.to_vec());
    Ok(Some(Table::new((number, title), &COLUMNS, average(&tables), thesis, published(k))))
}

/// Returns pairs of corresponding vertices, spread over the target.
pub(super) fn landmarks(pair: &Pair) -> Vec<(u32, u32)> {
    let samples = pair.samples(LANDMARKS).into_iter();
    samples.map(|v| (pair.truth[v as usize], v)).collect()
}

/// Returns the functional map of [`fit`] with multiplications, made orthogonal by ICP, as in the
/// code published with the thesis.
pub fn fitted(pair: &Pair, source: &Eigenbasis, target: &Eigenbasis) -> Result<Mat<f64>> {
    let c = fit(pair, source, target, true)?;
    Ok(icp(c.as_ref(), source.basis(), target.basis(), ICP, Par::all(), Progress::none())?.map)
}

/// Returns the functional map between the first eigenfunctions, from descriptors, landmarks, and on
/// request multiplications by functions around landmarks (the method of reference 194 of the
/// thesis: Nogneng and Ovsjanikov 2017).
pub fn fit(
    pair: &Pair,
    source: &Eigenbasis,
    target: &Eigenbasis,
    has_operators: bool,
) -> Result<Mat<f64>> {
    let mut fit = MapFit::new(source, target, Par::all());
    let [many, others] = [&pair.source, &pair.target].map(|shape| shape.first(MANY));
    let (many, others) = (many?, others?);
    fit.signatures(&many, &others)?;
    let pairs = landmarks(pair);
    fit.landmarks(&pairs)?;
    if has_operators {
        // Signatures do not distinguish left and right; functions around landmarks do.
        fit.kernels(&pairs, &many, &others)?;
    }
    Ok(fit.solve(MapFit::COMMUTATIVITY)?)
}

/// Two shapes with the bases through which functions are transferred.
pub struct Bases {
    order: usize,
    source: Eigenbasis,
    target: Eigenbasis,
    ours: [ProductBasis; 2],
    ours_star: [ProductBasis; 2],
}

impl Bases {
    /// Creates the bases of products of at most `order` of `k` eigenfunctions of the source, `l` of
    /// the target.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn new(pair: &Pair, order: usize, [k, l]: [usize; 2]) -> Result<Self> {
        let (source, target) = (pair.source.first(k)?, pair.target.first(l)?);
        let bases = |orthogonalization| -> Result<[ProductBasis; 2]> {
            let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
            Ok([
                ProductBasis::new(&source, order, &options)?,
                ProductBasis::new(&target, order, &options)?,
            ])
        };
        let ours = bases(Orthogonalization::SinglePass)?;
        let ours_star = bases(Orthogonalization::Reorthogonalized)?;
        Ok(Self { order, source, target, ours, ours_star })
    }

    /// Returns the eigenfunctions of source and target.
    pub fn eigenbases(&self) -> (&Eigenbasis, &Eigenbasis) {
        (&self.source, &self.target)
    }

    /// Returns the products of "ours" and "ours*", of source and target.
    pub fn products(&self) -> [&[ProductBasis; 2]; 2] {
        [&self.ours, &self.ours_star]
    }

    /// Returns the transfers that the functional map `c` determines.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn by(&self, c: MatRef<'_, f64>) -> Result<Ways<'_>> {
        let (source, target) = (self.source.basis(), self.target.basis());
        let points = points_from_map(c, source, target, Par::all(), Progress::none())?;
        self.ways(c, &points)
    }

    /// Returns the transfers along points, a vertex of the source for each of the target.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn along(&self, points: &[u32]) -> Result<Ways<'_>> {
        let c = map_from_points(points, self.source.basis(), self.target.basis(), Par::all())?;
        self.ways(c.as_ref(), points)
    }

    fn ways(&self, c: MatRef<'_, f64>, points: &[u32]) -> Result<Ways<'_>> {
        let par = Par::all();
        let (source, target) = (self.source.basis(), self.target.basis());
        let along = |[from, to]: &'_ [ProductBasis; 2]| {
            map_from_points(points, from.basis(), to.basis(), par)
        };
        let [ours, star] = [&self.ours, &self.ours_star];
        Ok(Ways {
            eigen: Transfer::new(source, target, c.to_owned())?,
            ours: Transfer::new(ours[0].basis(), ours[1].basis(), along(ours)?)?,
            ours_star: Transfer::new(star[0].basis(), star[1].basis(), along(star)?)?,
            prods: TruncatedProducts::new(&star[0], published(source.len() - 1))?,
            extended: ProductMap::new(c, &self.source, &self.target, self.order)?,
            images: &star[1],
        })
    }
}

/// Transfers of functions by one functional map of few eigenfunctions.
pub struct Ways<'a> {
    /// By the map itself: "K".
    pub eigen: Transfer<'a>,
    /// "ours".
    pub ours: Transfer<'a>,
    /// "ours*".
    pub ours_star: Transfer<'a>,
    prods: TruncatedProducts<'a>,
    extended: ProductMap,
    images: &'a ProductBasis,
}

impl Ways<'_> {
    /// Transfers by "prods", without singular values up to this share of the largest.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn prods(&mut self, f: MatRef<'_, f64>, tolerance: f64) -> Result<Mat<f64>> {
        let par = Par::all();
        self.prods.set_threshold(tolerance)?;
        let coefficients = self.prods.analysis(f, par)?;
        let images = self.extended.apply(coefficients.as_ref(), par)?;
        // The products of the target are Q R.
        let images = self.images.r() * images;
        Ok(self.images.basis().synthesis(images.as_ref(), par)?)
    }

    /// Transfers by eigenfunctions, "prods" with the published tolerance, "ours" and "ours*".
    ///
    /// # Errors
    /// The errors of the library.
    pub fn all(&mut self, f: MatRef<'_, f64>) -> Result<[Mat<f64>; 4]> {
        let par = Par::all();
        let k = self.extended.source().k();
        Ok([
            self.eigen.apply(f, par)?,
            self.prods(f, published(k))?,
            self.ours.apply(f, par)?,
            self.ours_star.apply(f, par)?,
        ])
    }
}

fn errors(pair: &Pair, signals: &Signals, setting: Setting) -> Result<Vec<Vec<f64>>> {
    let (order, [k, l]) = setting.parameters();
    let par = Par::all();
    let bases = Bases::new(pair, order, [k, l])?;
    let (source, target) = bases.eigenbases();
    let mut ways = bases.by(fitted(pair, source, target)?.as_ref())?;
    let (more, more_target) = (pair.source.first(order * k)?, pair.target.first(order * l)?);
    let c_more = fitted(pair, &more, &more_target)?;
    let eigen_more = Transfer::new(more.basis(), more_target.basis(), c_more)?;

    let mass = target.basis().mass();
    let landmarks = setting.landmarks(pair);
    let mut rows = Vec::new();
    for f in signals {
        let f = match landmarks {
            Some(_) => of_size_1(f.as_ref()),
            None => f.clone(),
        };
        let f = f.as_ref();
        let truth = pull_back(&pair.truth, f)?;
        let error = |g: Mat<f64>| -> Result<f64> {
            Ok(match &landmarks {
                Some(landmarks) => mean_distance(truth.as_ref(), g.as_ref(), landmarks),
                None => mean(&relative_errors(truth.as_ref(), g.as_ref(), mass)?),
            })
        };
        let mut row = vec![
            error(ways.eigen.apply(f, par)?)?,
            error(ways.ours.apply(f, par)?)?,
            error(ways.ours_star.apply(f, par)?)?,
            error(eigen_more.apply(f, par)?)?,
        ];
        for tolerance in tolerances(published(k)) {
            row.push(error(ways.prods(f, tolerance)?)?);
        }
        rows.push(row);
    }
    Ok(rows)
}

/// Returns functions divided by their largest values.
pub fn of_size_1(f: MatRef<'_, f64>) -> Mat<f64> {
    let sizes: Vec<f64> = f.col_iter().map(|f| f.norm_max()).collect();
    Mat::from_fn(
        f.nrows(),
        f.ncols(),
        |i, j| if sizes[j] > 0.0 { f[(i, j)] / sizes[j] } else { 0.0 },
    )
}

/// Returns the mean of `|f - g|` over vertices and functions.
pub fn mean_distance(f: MatRef<'_, f64>, g: MatRef<'_, f64>, vertices: &[u32]) -> f64 {
    let at =
        |j: usize| vertices.iter().map(move |&v| (f[(v as usize, j)] - g[(v as usize, j)]).abs());
    let sum: f64 = (0..f.ncols()).flat_map(at).sum();
    sum / (vertices.len() * f.ncols()).max(1) as f64
}
