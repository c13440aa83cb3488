//! Plants that lose water and bend.

use std::path::PathBuf;

use catamaran::Par;
use catamaran::base::{Error, Progress};
use catamaran::faer::Mat;
use catamaran_simulation::plant::families::{GrowthOptions, grow as grow_plant};
use catamaran_simulation::plant::{
    Conductivity, Elasticity, Interval, Plant as Graph, Pose, ReadOptions, Rewatering, RodOptions,
    Rods, Segment, Soil, Stomata, WaterModel, WaterOptions, WiltOptions, Wilting, grams_per_hour,
    read_with, tubes as tubes_of, wilt as wilt_plant,
};
use pyo3::prelude::*;

use crate::array::{Array, from_matrix, from_rows, from_vec};
use crate::error::{exception, refused};
use crate::mesh::{Mesh, arrays, positions};
use crate::options::{Threads, arguments, par};
use crate::task::{Length, run};

/// Grams in a kilogram.
const GRAMS: f64 = 1e3;

/// A plant as arrays: the tails of its segments, their radii, parents (-1 at the root), whether
/// they are on leaves, and the base.
type Parts<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Of a segment: whether it is the stalk of a leaf, the area of leaf that it supplies if it is not
/// that of the thesis, whether it is fixed in space.
type More = (bool, Option<f64>, bool);

/// A plant of the library, which Python's side holds.
#[pyclass(frozen, module = "catamaran._catamaran")]
pub struct PlantHandle {
    graph: Graph,
}

#[pymethods]
impl PlantHandle {
    /// Returns a plant of the arrays that `arrays` returns.
    #[new]
    #[pyo3(signature = (tails, radii, parents, leaves, base, more))]
    fn new(
        tails: &Bound<'_, PyAny>,
        radii: &Bound<'_, PyAny>,
        parents: &Bound<'_, PyAny>,
        leaves: Vec<bool>,
        base: [f64; 3],
        more: Vec<More>,
    ) -> PyResult<Self> {
        let tails = positions("tails", tails)?;
        let radii = Array::<f64>::new("radii", radii, &[1])?;
        let parents = Array::<i64>::new("parents", parents, &[1])?;
        let counts = [radii.shape().0, parents.shape().0, leaves.len(), more.len()];
        if let Some(count) = counts.into_iter().find(|&count| count != tails.len()) {
            return Err(refused("tails", format_args!("{} of them, but {count}", tails.len())));
        }
        let radii = radii.entries();
        let segment = |v: usize| {
            let (petiole, leaf_area, pinned) = more[v];
            Segment {
                leaf: leaves[v],
                petiole,
                leaf_area,
                pinned,
                ..Segment::stem(tails[v], radii[v])
            }
        };
        let parents: Vec<Option<u32>> =
            parents.entries().iter().map(|&parent| u32::try_from(parent).ok()).collect();
        let segments = (0..tails.len()).map(segment).collect();
        let graph = Graph::new(segments, &parents, Some(base)).map_err(exception)?;
        Ok(Self { graph })
    }

    /// Returns what arrays do not say of each segment: petiole, area of leaf, pinned.
    fn more(&self) -> Vec<More> {
        let segments = self.graph.segments().iter();
        segments.map(|segment| (segment.petiole, segment.leaf_area, segment.pinned)).collect()
    }

    /// Returns what the reader had to assume.
    fn notes(&self) -> Vec<String> {
        self.graph.notes().to_vec()
    }

    fn __len__(&self) -> usize {
        self.graph.len()
    }

    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Parts<'py>> {
        let segments = self.graph.segments();
        let tails = segments.iter().map(|segment| segment.tail).collect();
        let radii: Vec<f64> = segments.iter().map(|segment| segment.radius).collect();
        let parent = |v| self.graph.parent(v).map_or(-1, |p| p as i64);
        let parents: Vec<i64> = (0..segments.len()).map(parent).collect();
        let leaves: Vec<bool> = segments.iter().map(|segment| segment.leaf).collect();
        Ok((
            from_rows(py, tails)?.into_any(),
            from_vec(py, radii).into_any(),
            from_vec(py, parents).into_any(),
            from_vec(py, leaves).into_any(),
            from_vec(py, self.graph.base().to_vec()).into_any(),
        ))
    }
}

/// Implements `catamaran.read_plant`.
#[pyfunction]
#[pyo3(signature = (path, individual, unit))]
pub fn read_plant(
    py: Python<'_>,
    path: PathBuf,
    individual: Option<String>,
    unit: (f64, f64),
) -> PyResult<PlantHandle> {
    let graph = run(py, Length::Long, None, move |_| {
        let mut options = ReadOptions::new().unit([unit.0, unit.1]);
        options.individual = individual.as_deref();
        read_with(&path, &options)
    })?;
    Ok(PlantHandle { graph })
}

/// Implements `catamaran.grow_plant`.
#[pyfunction]
pub fn grow(py: Python<'_>, nodes: usize, seed: u64) -> PyResult<PlantHandle> {
    let options = GrowthOptions::new().nodes(nodes).seed(seed);
    run(py, Length::Long, None, move |_| grow_plant(&options)).map(|graph| PlantHandle { graph })
}

arguments! {
    /// What a plant goes through, as a dictionary.
    pub struct Weather {
        hours: f64,
        frames: usize,
        loss: f64,
        day_night: bool,
        conductance: f64,
        elasticity: (f64, f64),
        steepness: f64,
        shift: f64,
        damage: Vec<(usize, f64)>,
        /// The relative water content at which stomata are half closed, the steepness, and the
        /// share of the cuticle.
        stomata: Option<(f64, f64, f64)>,
        /// The capacity of the soil and its content, in g.
        soil: Option<(f64, f64)>,
        /// Hours, and grams; without these as much as the soil holds.
        rewater: Vec<(f64, Option<f64>)>,
        threads: Threads,
    }
}

impl Weather {
    fn simulate(
        &self,
        graph: &Graph,
        par: Par,
        progress: Progress<'_>,
    ) -> catamaran::Result<(Vec<f64>, Vec<f64>, Wilting)> {
        let loss = grams_per_hour(self.loss);
        let conductivity = Conductivity::Pipe { scale: self.conductance };
        let options = WaterOptions::new().loss(loss).conductivity(conductivity);
        let mut model = WaterModel::new(graph, &options)?;
        for &(node, factor) in &self.damage {
            model.weaken(node, factor)?;
        }
        let last = self.frames.max(1) as f64;
        let hours: Vec<f64> = (0..=self.frames).map(|i| self.hours * i as f64 / last).collect();
        let times: Vec<f64> = hours.iter().map(|h| 3600.0 * h).collect();
        let (full, dry) = self.elasticity;
        let elasticity =
            Elasticity::Relative { dry, full, steepness: self.steepness, shift: self.shift };
        let mut options = WiltOptions::new().elasticity(elasticity).par(par).progress(progress);
        if self.day_night {
            options = options.cycle(Interval::day_and_night(loss));
        }
        if let Some((half, steepness, cuticular)) = self.stomata {
            let stomata = Stomata::new().half(half).steepness(steepness).cuticular(cuticular);
            options = options.stomata(Some(stomata));
        }
        if let Some((capacity, content)) = self.soil {
            let soil = Soil::new(capacity / GRAMS).content(content / GRAMS);
            options = options.soil(Some(soil));
        }
        if let Some((late, _)) = self.rewater.iter().find(|(hours, _)| *hours > self.hours) {
            let why = format!("{late} hours is after the end, {} hours", self.hours);
            return Err(Error::Argument { what: "rewater", why });
        }
        let pour = |&(hours, grams): &(f64, Option<f64>)| Rewatering {
            seconds: 3600.0 * hours,
            amount: grams.map(|grams| grams / GRAMS),
        };
        options = options.rewatering(self.rewater.iter().map(pour).collect::<Vec<_>>());
        let rods = Rods::new(graph, &RodOptions::default())?;
        Ok((hours, model.full(), wilt_plant(&model, &rods, &times, &options)?))
    }
}

/// Hours, full water, water and moduli (frames x nodes), the balance (frames x 5), and for each
/// frame the heads, tails and rotations of the segments.
type Frames<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Vec<[Bound<'py, PyAny>; 3]>,
);

/// Implements `catamaran.wilt`.
#[pyfunction]
#[pyo3(signature = (plant, weather, progress))]
pub fn wilt<'py>(
    py: Python<'py>,
    plant: &Bound<'py, PlantHandle>,
    weather: Weather,
    progress: Option<Py<PyAny>>,
) -> PyResult<Frames<'py>> {
    if !(weather.hours > 0.0 && weather.hours.is_finite()) {
        return Err(refused("hours", format_args!("{} is not a positive number", weather.hours)));
    }
    let (graph, par) = (&plant.get().graph, par(weather.threads)?);
    let (hours, full, found) =
        run(py, Length::Long, progress, move |progress| weather.simulate(graph, par, progress))?;
    let table = |rows: &[Vec<f64>]| {
        let columns = rows.first().map_or(0, Vec::len);
        let matrix = Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]);
        Ok::<_, PyErr>(from_matrix(py, matrix.as_ref())?.into_any())
    };
    let (water, moduli) = (table(&found.water)?, table(&found.moduli)?);
    let balance = found.balance.iter();
    let balance: Vec<Vec<f64>> =
        balance.map(|b| vec![b.plant, b.soil, b.transpired, b.supplied, b.drained]).collect();
    let balance = table(&balance)?;
    let pose = |pose: Pose| {
        Ok::<_, PyErr>([
            from_rows(py, pose.heads)?.into_any(),
            from_rows(py, pose.tails)?.into_any(),
            from_rows(py, pose.rotations)?.into_any(),
        ])
    };
    let poses = found.poses.into_iter().map(pose).collect::<PyResult<_>>()?;
    let (hours, full) = (from_vec(py, hours).into_any(), from_vec(py, full).into_any());
    Ok((hours, full, water, moduli, balance, poses))
}

/// Returns a mesh of tubes around the segments of a pose; see `catamaran.Wilting`.
#[pyfunction]
#[pyo3(signature = (plant, pose, sides, thinnest))]
pub fn tubes<'py>(
    py: Python<'py>,
    plant: &Bound<'py, PlantHandle>,
    pose: [Bound<'py, PyAny>; 3],
    sides: usize,
    thinnest: f64,
) -> PyResult<Mesh<'py>> {
    let [heads, tails, rotations] = &pose;
    let rotations = Array::<f64>::new("rotations", rotations, &[2])?;
    let view = rotations.view();
    if view.ncols() != 4 {
        return Err(refused("rotations", "expected 4 columns"));
    }
    let pose = Pose {
        heads: positions("heads", heads)?,
        tails: positions("tails", tails)?,
        rotations: (0..view.nrows()).map(|i| [0, 1, 2, 3].map(|j| view[(i, j)])).collect(),
    };
    let graph = &plant.get().graph;
    arrays(py, run(py, Length::Long, None, move |_| tubes_of(graph, &pose, sides, thinnest))?)
}
