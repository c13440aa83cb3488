//! Slime moulds and Newton's fractals.

use catamaran::faer::Mat;
use catamaran_simulation::opencl::{Device, SlimeOnDevice, evaluate_newton};
use catamaran_simulation::texture::newton::{
    Gradient, Grid, Newton, NewtonOptions, Points, Polynomial,
};
use catamaran_simulation::texture::slime::{
    Blur, Coverage, Mask, Options, Simulation, Surface, TangentStep, atlas, fitted,
};
use pyo3::prelude::*;

use crate::array::{Array, from_matrix, from_rows, from_vec};
use crate::error::refused;
use crate::mesh::mesh;
use crate::mesh_file::texture_coordinates;
use crate::options::{Threads, arguments, par, word};
use crate::task::{Length, run};

arguments! {
    /// What a slime mould is like, as a dictionary; names as in the library.
    pub struct Mould {
        agents: usize,
        species: usize,
        size: usize,
        seed: u32,
        time_step: Option<f64>,
        movement_speed: Option<f64>,
        turn_speed: Option<f64>,
        vision_distance: Option<f64>,
        vision_angle: Option<f64>,
        evaporation_rate: Option<f64>,
        diffusion_rate: Option<f64>,
        turn_noise: Option<f64>,
        project: Option<u32>,
        gaussian: bool,
        length_rescaling: bool,
        device: String,
        threads: Threads,
    }
}

impl Mould {
    fn options(&self) -> Options {
        let mut options = Options::new()
            .agents(self.agents)
            .species(self.species)
            .size(self.size)
            .seed(self.seed)
            .length_rescaling(self.length_rescaling);
        for (field, value) in [
            (&mut options.time_step, self.time_step),
            (&mut options.movement_speed, self.movement_speed),
            (&mut options.turn_speed, self.turn_speed),
            (&mut options.vision_distance, self.vision_distance),
            (&mut options.vision_angle, self.vision_angle),
            (&mut options.evaporation_rate, self.evaporation_rate),
            (&mut options.diffusion_rate, self.diffusion_rate),
            (&mut options.turn_noise, self.turn_noise),
        ] {
            *field = value.unwrap_or(*field);
        }
        if let Some(substeps) = self.project {
            options.tangent_step = TangentStep::Project { substeps };
        }
        if self.gaussian {
            options.blur = Blur::Gaussian;
        }
        options
    }
}

/// Opens a device; `None` stands for the CPU without OpenCL.
fn opened(device: &str) -> catamaran::Result<Option<Device>> {
    match device {
        "cpu" => Ok(None),
        "opencl" => Device::open("").map(Some),
        name => Device::open(name).map(Some),
    }
}

/// Textures (species x size x size), texture coordinates (faces x 3 x 2), coverage after each step
/// (steps x species), and the number of triangles that overlap others in the texture.
type Grown<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, usize);

/// Returns slime moulds on a mesh; see `catamaran.slime`.
#[pyfunction]
#[pyo3(signature = (v, f, steps, mould, uv, start, ground, progress))]
pub fn slime<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    steps: u32,
    mould: Mould,
    uv: Option<&Bound<'py, PyAny>>,
    start: Option<&Bound<'py, PyAny>>,
    ground: Option<&Bound<'py, PyAny>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Grown<'py>> {
    let (options, par, mesh) = (mould.options(), par(mould.threads)?, mesh(v, f)?);
    let uv = uv.map(|uv| texture_coordinates(uv, mesh.faces().len())).transpose()?;
    let numbers = |name, object: Option<&Bound<'_, PyAny>>| -> PyResult<Vec<u8>> {
        let Some(object) = object else { return Ok(Vec::new()) };
        let array = Array::<i64>::new(name, object, &[2])?;
        let (view, (m, n)) = (array.view(), array.shape());
        let cells = (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
        let number = |(i, j)| {
            u8::try_from(view[(i, j)]).map_err(|_| refused(name, "expected numbers from 0 to 2"))
        };
        cells.map(number).collect()
    };
    let start = numbers("start", start)?.into_iter().map(|inside| inside > 0).collect();
    let mask = Mask { start, ground: numbers("ground", ground)? };
    let (simulation, coverage) = run(py, Length::Long, progress, move |progress| {
        let device = opened(&mould.device)?;
        let surface = match uv {
            Some(uv) => Surface::new(&mesh, &fitted(&uv))?,
            None => Surface::of_faces(&mesh, atlas(&mesh, options.size)?)?,
        };
        let mut simulation = Simulation::new(surface, &options, &mask)?;
        let mut on_device =
            device.map(|device| SlimeOnDevice::new(&device, &simulation)).transpose()?;
        let mut coverage: Vec<Vec<Coverage>> = Vec::new();
        let mut done = 0;
        while done < steps {
            let covered = match &mut on_device {
                Some(on_device) => on_device.advance(steps - done)?,
                None => {
                    simulation.step(par);
                    vec![simulation.coverage(par)]
                }
            };
            done += covered.len() as u32;
            coverage.extend(covered);
            progress.report(f64::from(done) / f64::from(steps))?;
        }
        if let Some(on_device) = on_device {
            on_device.give_back(&mut simulation)?;
        }
        Ok((simulation, coverage))
    })?;
    let (size, species) = (simulation.texels().size(), simulation.species());
    let mut texels = Vec::with_capacity(species * size * size);
    (0..species).for_each(|s| texels.extend_from_slice(simulation.texture(s)));
    let textures = from_vec(py, texels).call_method1("reshape", ((species, size, size),))?;
    let corners = simulation.surface().uv();
    let count = corners.len();
    let corners = from_rows(py, corners.as_flattened().to_vec())?;
    let table = Mat::from_fn(coverage.len(), species, |i, s| coverage[i][s].coverage);
    Ok((
        textures,
        corners.call_method1("reshape", ((count, 3, 2),))?,
        from_matrix(py, table.as_ref())?.into_any(),
        simulation.texels().overlapping().len(),
    ))
}

arguments! {
    /// What a fractal is of, as a dictionary.
    pub struct Fractal {
        power: Option<u32>,
        roots: Option<Vec<(f64, f64)>>,
        iterations: u32,
        theta: f64,
        gradient: String,
        scale: f64,
        offset: [f64; 3],
        w: f64,
        device: String,
        threads: Threads,
    }
}

arguments! {
    /// Which points: a list of three coordinates each, a plane of width x height, or a cube.
    pub struct Where {
        kind: String,
        points: Option<Py<PyAny>>,
        size: (u32, u32),
        center: [f64; 2],
        extent: f64,
    }
}

/// Returns the root of each point, how fast it is reached, and how many points reach none; see
/// `catamaran.newton`.
#[pyfunction]
#[pyo3(signature = (at, fractal, progress))]
pub fn newton<'py>(
    py: Python<'py>,
    at: Where,
    fractal: Fractal,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, usize)> {
    let polynomial = match (fractal.power, &fractal.roots) {
        (Some(power), None) => Polynomial::Power(power),
        (None, Some(roots)) => Polynomial::Roots(roots.iter().map(|&(re, im)| [re, im]).collect()),
        _ => return Err(refused("power", "expected either a power or roots")),
    };
    let kind = word("kind", &at.kind, &[("list", 0), ("plane", 1), ("cube", 2)])?;
    let par = par(fractal.threads)?;
    let known = [("thesis", Gradient::Thesis), ("shader", Gradient::Shader)];
    let gradient = word("gradient", &fractal.gradient, &known)?;
    let options = NewtonOptions::new()
        .polynomial(polynomial)
        .iterations(fractal.iterations)
        .theta(fractal.theta)
        .gradient(gradient)
        .scale(fractal.scale)
        .offset(fractal.offset)
        .w(fractal.w);
    let list: Vec<[f32; 3]> = match &at.points {
        Some(points) => crate::mesh::positions("points", points.bind(py))?
            .into_iter()
            .map(|p| p.map(|x| x as f32))
            .collect(),
        None => Vec::new(),
    };
    let found = run(py, Length::Long, progress, move |progress| {
        let points = match kind {
            0 => Points::List(&list),
            1 => Points::Grid(Grid::plane(at.size.0, at.size.1, at.center, at.extent)),
            _ => Points::Grid(Grid::cube(at.size.0, at.extent)),
        };
        let newton = Newton::new(&options)?;
        match opened(&fractal.device)? {
            Some(device) => evaluate_newton(&device, &newton, points, progress),
            None => newton.evaluate(points, par, progress),
        }
    })?;
    let (roots, convergence) = (from_vec(py, found.roots), from_vec(py, found.convergence));
    Ok((roots.into_any(), convergence.into_any(), found.unreached.len()))
}
