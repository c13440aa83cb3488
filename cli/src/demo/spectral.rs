//! The station of spectra: eigenfunctions of a figure, and what products of them are good for.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::{Mat, MatRef};
use catamaran::sparse::{EigenOptions, eigs};
use catamaran_geometry::mesh::{LaplacianOptions, Normalization, TriMesh, families, laplacian};
use catamaran_geometry::spectral::functional_map::{map_from_points, points_from_map};
use catamaran_geometry::spectral::{
    Basis, Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, Transfer,
    relative_errors,
};
use minijinja::context;

use super::Site;
use super::page::Station;
use crate::picture::{PLAIN, Paint, Panel, Scene, Up, View, render};
use crate::progress::Bar;

/// Eigenfunctions that are multiplied, beside the constant, and the order of products.
const K: usize = 30;
const ORDER: usize = 2;
/// The same for transfer.
const TRANSFER: (usize, usize) = (12, 3);
/// Size of the figure (F = 300 cells^2), and the same when small inputs are wanted.
const CELLS: usize = 8;
const SMALL_CELLS: usize = 4;
/// Eigenfunctions that are shown.
const SHOWN: [usize; 4] = [1, 4, 9, 25];
/// The eigenfunction that is transferred: far beyond those that carry it.
const HIGH: usize = 40;

/// A pose of the figure and its eigenfunctions.
struct Pose {
    mesh: TriMesh,
    eigenbasis: Eigenbasis,
    /// The largest residual of an eigenpair.
    residual: f64,
}

impl Pose {
    fn new(cells: usize, pose: f64) -> Result<Self> {
        let mesh = families::figure(cells, pose)?.normalized(Normalization::UnitArea)?;
        let problem = laplacian(&mesh, &LaplacianOptions::default())?;
        let options = EigenOptions::new().k(ORDER * K + 1);
        let pairs = eigs(problem.stiffness.view(), &problem.mass, &options)?;
        let residual = pairs.residuals.iter().copied().fold(0.0, f64::max);
        let eigenbasis = Eigenbasis::new(pairs.values, pairs.vectors, problem.mass)?;
        Ok(Self { mesh, eigenbasis, residual })
    }

    fn products(&self, k: usize, order: usize) -> Result<ProductBasis> {
        let orthogonalization = Orthogonalization::Reorthogonalized;
        let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
        Ok(ProductBasis::new(&self.eigenbasis.truncated(k + 1)?, order, &options)?)
    }
}

/// One line of the table: a basis, and how well it holds the coordinates.
struct Outcome {
    name: String,
    functions: usize,
    error: f64,
}

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("spectra");
    let cells = if site.small { SMALL_CELLS } else { CELLS };
    let start = Instant::now();
    let source = Pose::new(cells, 0.2)?;
    let seconds = start.elapsed().as_secs_f64();
    bar.step(0.3)?;
    let target = Pose::new(cells, 0.9)?;
    bar.step(0.6)?;

    eigenfunctions(site, &source)?;
    let outcomes = approximation(site, &source)?;
    bar.step(0.8)?;
    let errors = transfer(site, &source, &target)?;
    drop(bar);
    describe(&source, seconds, &outcomes, errors)
}

const VIEW: View = View { azimuth: 20.0, elevation: 8.0, up: Up::Z, ..View::DEFAULT };

fn panel<'a>(mesh: &'a TriMesh, values: &'a [f64], title: &'a str) -> Panel<'a> {
    Panel { mesh, paint: Paint::Values(values), view: VIEW, title }
}

fn eigenfunctions(site: &Site<'_>, pose: &Pose) -> Result<()> {
    let columns: Vec<Vec<f64>> = SHOWN
        .iter()
        .map(|&i| pose.eigenbasis.functions().col(i).iter().copied().collect())
        .collect();
    let titles = SHOWN.map(|i| format!("{i}"));
    let panels =
        columns.iter().zip(&titles).map(|(values, title)| panel(&pose.mesh, values, title));
    let scene =
        Scene { panels: panels.collect(), size: (460, 520), legend: false, ..Scene::default() };
    render(&scene)?.write(site.file("eigenfunctions.png")?)
}

/// Draws the figure as its coordinates are in three bases, and returns the error in each.
fn approximation(site: &Site<'_>, pose: &Pose) -> Result<Vec<Outcome>> {
    let points = pose.mesh.vertices();
    let coordinates = Mat::from_fn(points.len(), 3, |i, j| points[i][j]);
    let products = pose.products(K, ORDER)?;
    let few = pose.eigenbasis.truncated(K + 1)?;
    let bases: [(String, &Basis); 3] = [
        (format!("{K} eigenfunctions"), few.basis()),
        (format!("{} eigenfunctions", ORDER * K), pose.eigenbasis.basis()),
        (format!("products of {K}"), products.basis()),
    ];
    let mut outcomes = Vec::new();
    let mut meshes = vec![("the figure".to_owned(), pose.mesh.clone())];
    for (name, basis) in bases {
        let rebuilt = basis.approximation(coordinates.as_ref(), Par::all())?;
        let errors = relative_errors(coordinates.as_ref(), rebuilt.as_ref(), basis.mass())?;
        let vertices = (0..points.len()).map(|i| [0, 1, 2].map(|j| rebuilt[(i, j)])).collect();
        meshes.push((name.clone(), TriMesh::new(vertices, pose.mesh.faces().to_vec())?));
        let error = errors.iter().sum::<f64>() / errors.len() as f64;
        outcomes.push(Outcome { name, functions: basis.len(), error });
    }
    let panels = meshes.iter().map(|(title, mesh)| Panel { mesh, paint: PLAIN, view: VIEW, title });
    let scene = Scene { panels: panels.collect(), size: (460, 520), ..Scene::default() };
    render(&scene)?.write(site.file("rebuilt.png")?)?;
    Ok(outcomes)
}

/// Draws a high eigenfunction that is transferred by few eigenfunctions and by products of them;
/// returns the errors of both.
fn transfer(site: &Site<'_>, source: &Pose, target: &Pose) -> Result<[f64; 2]> {
    let par = Par::all();
    let (k, order) = TRANSFER;
    let f = source.eigenbasis.functions().subcols(HIGH, 1);
    // All poses have the same vertices; what is known of that is a small functional map.
    let truth: Vec<u32> = (0..source.mesh.vertices().len() as u32).collect();
    let (few, others) = (source.eigenbasis.truncated(k + 1)?, target.eigenbasis.truncated(k + 1)?);
    let c = map_from_points(&truth, few.basis(), others.basis(), par)?;
    let points = points_from_map(c.as_ref(), few.basis(), others.basis(), par, Progress::none())?;
    let (from, to) = (source.products(k, order)?, target.products(k, order)?);
    let o = map_from_points(&points, from.basis(), to.basis(), par)?;
    let by_few = Transfer::new(few.basis(), others.basis(), c)?.apply(f, par)?;
    let by_products = Transfer::new(from.basis(), to.basis(), o)?.apply(f, par)?;

    let column = |g: MatRef<'_, f64>| g.col(0).iter().copied().collect::<Vec<f64>>();
    let [original, few_image, image] = [f, by_few.as_ref(), by_products.as_ref()].map(column);
    let titles =
        [format!("eigenfunction {HIGH}"), format!("by {k}"), format!("by products of {k}")];
    let panels = vec![
        panel(&source.mesh, &original, &titles[0]),
        panel(&target.mesh, &few_image, &titles[1]),
        panel(&target.mesh, &image, &titles[2]),
    ];
    let scene = Scene { panels, size: (520, 560), legend: false, ..Scene::default() };
    render(&scene)?.write(site.file("transfer.png")?)?;
    let error = |g: MatRef<'_, f64>| relative_errors(f, g, others.basis().mass());
    Ok([error(by_few.as_ref())?[0], error(by_products.as_ref())?[0]])
}

fn describe(
    pose: &Pose,
    seconds: f64,
    outcomes: &[Outcome],
    [by_few, by_products]: [f64; 2],
) -> Result<Station> {
    let (k, order) = TRANSFER;
    let per_cent = |error: f64| format!("{:.1} %", 100.0 * error);
    let row = |o: &Outcome| {
        context! { name => &o.name, functions => o.functions, error => per_cent(o.error) }
    };
    let values = context! {
        multiplied => K,
        vertices => pose.mesh.vertices().len(),
        milliseconds => format!("{:.0}", seconds * 1e3),
        residual => format!("{:.0e}", pose.residual),
        products => outcomes.last().map_or(0, |o| o.functions),
        shown => SHOWN,
        transfer => context! {
            high => HIGH,
            k,
            order,
            by_few => per_cent(by_few),
            by_products => per_cent(by_products),
        },
        outcomes => outcomes.iter().map(row).collect::<Vec<_>>(),
    };
    let template = include_str!("stations/spectral.html");
    Station::new("spectral", "Spectra and products", template, values)
}
