//! `catamaran slime`.

mod config;
mod curves;
mod images;
mod look;
mod mask;
mod material;
mod on_device;
mod view;

use std::fs::File;
use std::io::{BufReader, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::io::Output;
use catamaran::{Error, Par};
use catamaran_geometry::mesh::io::{Attribute, Labels, MeshFile, Picture};
use catamaran_simulation::texture::slime::{
    Coverage, Mask, Options, Simulation, Surface, atlas, fitted, smallest_size,
};
use catamaran_simulation::texture::{Look, MaterialMaps, Preset};

use crate::claims::refuse_result;
use crate::common::{Force, Threads, as_option};
use crate::defaults::stated;
use crate::device::{self, DeviceArgs};
use crate::folder::{Folder, note_older};
use crate::input::{self, MeshArgs};
use crate::output;
use crate::picture::{self, Image, Projection, Up, View, guess_up, write_chart};
use crate::progress::Bar;
use crate::report::{note, report, seconds, status};
use crate::signals;
use curves::Moment;
pub use curves::chart;
use look::LookConfig;
use on_device::OnDevice;
use view::Subject;
pub use view::draw;

/// Side of the picture of the mesh, in pixels.
const PIXELS: usize = 900;

/// Grow slime moulds on a surface: textures of networks and cells.
///
/// The model is that of chapter 3 of the thesis.
///
/// The folder gets the texture at each frame (--every): up to three species are the channels of one
/// .png, and more species have one .png each. It also gets coverage.csv, and mesh.obj, the mesh
/// with its texture coordinates, whose material (mesh.mtl) shows the last frame; of more than three
/// species, mesh.png has this frame in colours. A mesh without texture coordinates gets an atlas of
/// its triangles. With --material the folder gets textures for physically based rendering, and the
/// mesh with these textures. Ctrl-C ends the run; a run with --state can be resumed (--resume),
/// with the same result as without the interruption.
#[derive(clap::Args)]
pub struct Args {
    #[arg(
        value_name = "MESH",
        required_unless_present = "tile",
        help = input::mesh_help("The mesh")
    )]
    mesh: Option<PathBuf>,
    /// Use a square whose opposite sides are joined, instead of a mesh: the texture repeats without
    /// a seam. --render shows four copies.
    #[arg(long, conflicts_with_all = ["mesh", "atlas", "weld", "drop_specks", "strict"])]
    tile: bool,
    /// Settings of the simulation: .toml with the names of table 3.1 of the thesis
    /// (docs/algorithms/slime.md) and a table [material] (docs/guide/slime.md), or an .ini of the
    /// reference implementation.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Number of steps in all; those of a resumed run count.
    #[arg(long, value_name = "NUMBER", default_value_t = 900)]
    steps: u32,
    /// Output folder.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of steps from frame to frame [default: the last step is the only frame].
    #[arg(long, value_name = "STEPS")]
    every: Option<u32>,
    #[arg(
        long,
        value_name = "TEXELS",
        help = stated(
            "Texels along each side of the texture, a multiple of 32; overrides --config",
            Options::default().size
        )
    )]
    size: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated("Number of agents; overrides --config", Options::default().agents)
    )]
    agents: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated("Number of species; overrides --config", Options::default().species)
    )]
    species: Option<usize>,
    #[arg(
        long,
        value_name = "NUMBER",
        help = stated("Seed of all randomness; overrides --config", Options::default().seed)
    )]
    seed: Option<u32>,
    /// Mask over the texture, a .png file: red is where agents start, green are obstacles, blue
    /// attracts agents.
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    /// Make an atlas of triangles even if the mesh has texture coordinates.
    #[arg(long)]
    atlas: bool,
    #[arg(
        long,
        value_name = "LOOK",
        num_args = 0..=1,
        require_equals = true,
        value_parser = material::parser(),
        help = stated(
            "Write albedo.png, roughness.png, metalness.png, height.png and normal.png, and \
             material.glb, the mesh with these textures, for glTF viewers. LOOK, after \
             an equals sign, is strands, marble, gold, wood, engraved or lava (which also writes \
             glow.png)",
            format_args!("that of --config, or {}", material::usual())
        )
    )]
    material: Option<Option<Preset>>,
    /// Draw the mesh with its last texture, or with its material, to this .png or .svg file.
    #[arg(long, value_name = "FILE")]
    render: Option<PathBuf>,
    #[arg(
        long,
        value_name = "AROUND,ABOVE",
        requires = "render",
        allow_hyphen_values = true,
        help = stated(
            "Viewpoint of --render: degrees around the upward axis and degrees above the \
             horizon, then ,flat for no perspective",
            format_args!("{},{}", View::DEFAULT.azimuth, View::DEFAULT.elevation)
        )
    )]
    view: Option<View>,
    /// Axis that points up in the picture of --render [default: that of the normals for a height
    /// field such as a terrain, otherwise z for .stl, and y for all other files].
    #[arg(long, value_name = "AXIS", requires = "render")]
    up: Option<Up>,
    /// Draw coverage and presence over time to this .svg or .png file.
    #[arg(long, value_name = "FILE")]
    coverage: Option<PathBuf>,
    /// Save the state to this file at the end, or at Ctrl-C, for --resume.
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Continue from the state in the file of --state, if there is one; mesh, configuration and
    /// mask must be those of the interrupted run.
    #[arg(long, requires = "state")]
    resume: bool,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let (options, look) = args.options()?;
    let mut frames = args.frames()?;
    let device = args.device.open()?;
    // Before the simulation is made, which may take long; the step of a saved state is read later.
    if args.saved().is_none() {
        args.check_names(&frames, options.species, look.as_ref())?;
    }
    let _folder = Folder::create(&args.output, TABLE)?;
    let outputs = Outputs::create(args)?;
    // The outputs have claimed their names; those of these files are claimed after steps only.
    let late = args.late_files(&frames, options.species, look.as_ref());
    late.iter().try_for_each(|name| refuse_result(&args.output.join(name)))?;
    let file = match &args.mesh {
        Some(path) => args.repair.read(path)?,
        None => MeshFile::from(Surface::tile_mesh()?),
    };
    let mut simulation = args.simulation(&file, &options)?;
    let earlier = args.resume(&mut simulation)?;
    let first = simulation.state().step;
    let all = args.frame_files(&frames, options.species);
    // The interrupted run has written the frames before.
    frames.retain(|&step| step > first || step == args.steps);
    let files = args.check_names(&frames, options.species, look.as_ref())?;
    let is_end = |end: &str| end == ".png" || end.starts_with("-species");
    note_older(&args.output, "frames", FRAME, is_end, &all);
    let on_device = device.as_ref().map(|device| OnDevice::new(device, &simulation)).transpose()?;
    // Ctrl-C keeps the state, which is whole after a step only.
    let whole_steps = outputs.state.as_ref().map(|_| signals::finish_first());
    let mut growth = Growth { simulation, on_device };
    let grown = args.grow(&mut growth, &options, &frames, earlier)?;
    let Grown { moments, done, time, ended } = grown;
    let simulation = growth.simulation()?;
    if let Some(mut output) = outputs.state {
        let history = curves::numbers(&moments);
        simulation.save(&mut output, &history).map_err(|e| output.error(e))?;
        let path = output.path().display().to_string();
        output.commit()?;
        status!("state", path = path, steps = done; "{path}: after {done} steps")?;
    }
    drop(whole_steps);
    ended?;
    curves::write_csv(outputs.table, &moments)?;
    let par = args.threads.par();
    let textured = textured(&file, simulation);
    output::mesh(outputs.mesh, &textured)?;
    if has_picture(options.species, look.as_ref()) {
        let picture = Picture::rgb(simulation.texels().size(), &view::colors(simulation))?;
        images::save(args.force.create(&args.output.join(PICTURE))?, picture)?;
    }
    let frame = frames.last().map(|&step| frame_names(step, args.steps, options.species));
    let frame = match has_picture(options.species, look.as_ref()) {
        true => Some(PICTURE),
        false => frame.as_ref().and_then(|names| names.first()).map(String::as_str),
    };
    write_material(outputs.material, frame, look.as_ref())?;
    let maps = look.map(|look| MaterialMaps::new(simulation, &look, par)).transpose()?;
    if let Some(maps) = &maps {
        material::write(maps, &textured, MATERIAL_NAME, &args.output, args.force)?;
    }
    if let Some(output) = outputs.coverage {
        write_chart(output, &chart(&moments))?;
    }
    if let Some(output) = outputs.render {
        args.draw(&file, simulation, maps.as_ref())?.write(output)?;
    }
    report_steps(time, done - first, &simulation.coverage(par))?;
    device::report_times(device.as_ref())?;
    let folder = args.output.display().to_string();
    status!("written", path = folder, files = files; "{folder}: {files} files")
}

/// Reports the time of the steps, and the coverage after them.
fn report_steps(time: Duration, steps: u32, species: &[Coverage]) -> Result<()> {
    if steps > 0 {
        let step = time / steps;
        status!(
            "time",
            seconds = time.as_secs_f64(),
            step_seconds = step.as_secs_f64();
            "{}, {} a step",
            seconds(time),
            seconds(step)
        )?;
    }
    for (s, Coverage { coverage, presence }) in species.iter().enumerate() {
        let (coverage, presence) = (100.0 * coverage, 100.0 * presence);
        report!(
            "species": &format!("species {s}"),
            number = s,
            coverage_percent = coverage,
            presence_percent = presence;
            "coverage {coverage:.2} %, presence {presence:.2} %"
        )?;
    }
    Ok(())
}

/// A simulation that runs on the device, if there is one.
struct Growth {
    simulation: Simulation,
    on_device: Option<OnDevice>,
}

impl Growth {
    /// Computes at least one and at most `most` steps, and returns the coverage after each.
    fn advance(&mut self, most: u32, par: Par) -> Result<Vec<Vec<Coverage>>> {
        if let Some(kernels) = &mut self.on_device {
            return kernels.advance(most);
        }
        self.simulation.step(par);
        Ok(vec![self.simulation.coverage(par)])
    }

    /// Returns the texture of each species as bytes.
    fn frame(&mut self) -> Result<Vec<Vec<u8>>> {
        let species = 0..self.simulation.species();
        let Some(kernels) = &mut self.on_device else {
            return Ok(species.map(|s| self.simulation.frame(s)).collect());
        };
        let texels = self.simulation.texels().size().pow(2);
        species
            .map(|s| {
                let mut frame = vec![0; texels];
                kernels.frame(s, &mut frame)?;
                Ok(frame)
            })
            .collect()
    }

    /// Returns the simulation after the last step.
    fn simulation(&mut self) -> Result<&Simulation> {
        if let Some(kernels) = &self.on_device {
            kernels.give_back(&mut self.simulation)?;
        }
        Ok(&self.simulation)
    }
}

/// The course of a run.
struct Grown {
    /// Before the first step, and after each step, with those before a resumed run.
    moments: Vec<Moment>,
    /// Number of steps, with those before a resumed run.
    done: u32,
    time: Duration,
    /// An error if a signal ended the run.
    ended: catamaran::Result<()>,
}

/// The outputs besides frames.
struct Outputs {
    table: Output,
    mesh: Output,
    material: Output,
    coverage: Option<Output>,
    render: Option<Output>,
    state: Option<Output>,
}

impl Outputs {
    fn create(args: &Args) -> Result<Self> {
        let picture = |path: &Option<PathBuf>| {
            path.as_deref().map(|path| picture::create(path, args.force)).transpose()
        };
        let (coverage, render) = (picture(&args.coverage)?, picture(&args.render)?);
        let state = |path| args.force.create_resumable(path, args.resume);
        let state = args.state.as_deref().map(state).transpose()?;
        let table = args.force.create(&args.output.join(TABLE))?;
        let mesh = args.force.create(&args.output.join(MESH))?;
        let material = args.force.create(&args.output.join(MATERIAL))?;
        Ok(Self { table, mesh, material, coverage, render, state })
    }
}

/// The beginning of the names of frames, before the number of the step.
const FRAME: &str = "frame-";
/// The mesh with the texture coordinates of the frames.
const MESH: &str = "mesh.obj";
/// The material of the mesh, which shows the last frame.
const MATERIAL: &str = "mesh.mtl";
const MATERIAL_NAME: &str = "slime";
/// The last frame of more species than a picture has channels, in their colours.
const PICTURE: &str = "mesh.png";
/// Coverage and presence after each step.
const TABLE: &str = "coverage.csv";

/// Returns whether there is a picture of all species for the material of the mesh.
fn has_picture(species: usize, look: Option<&Look>) -> bool {
    species > images::CHANNELS && look.is_none()
}

fn frame_names(step: u32, last: u32, species: usize) -> Vec<String> {
    let digits = last.to_string().len().max(4);
    images::names(&format!("{FRAME}{step:0digits$}"), species)
}

impl Args {
    /// Returns the options, and the look of the material if one is requested.
    fn options(&self) -> Result<(Options, Option<Look>)> {
        let mut options = Options::default();
        let mut look = LookConfig::default();
        if let Some(path) = &self.config {
            let loaded = config::load(path)?;
            if !loaded.without_effect.is_empty() {
                let names = loaded.without_effect.join(", ");
                note(format_args!("{}: settings without effect here: {names}", path.display()));
            }
            options = loaded.options;
            if loaded.look.is_some() && self.material.is_none() {
                note(format_args!("{}: [material] needs --material", path.display()));
            }
            look = loaded.look.unwrap_or_default();
        }
        options.size = self.size.unwrap_or(options.size);
        options.agents = self.agents.unwrap_or(options.agents);
        options.species = self.species.unwrap_or(options.species);
        options.seed = self.seed.unwrap_or(options.seed);
        options.check().map_err(as_option)?;
        let look = self.material.map(|preset| look.look(preset)).transpose()?;
        Ok((options, look))
    }

    /// Returns the steps after which there is a frame.
    fn frames(&self) -> Result<Vec<u32>> {
        let mut frames: Vec<u32> = match self.every {
            Some(0) => bail!("--every 0: at least 1 is needed"),
            Some(every) => (1..=self.steps / every).map(|i| i * every).collect(),
            None => Vec::new(),
        };
        if self.steps > 0 && frames.last() != Some(&self.steps) {
            frames.push(self.steps);
        }
        Ok(frames)
    }

    /// Returns the names of the pictures of frames.
    fn frame_files(&self, frames: &[u32], species: usize) -> Vec<String> {
        frames.iter().flat_map(|&step| frame_names(step, self.steps, species)).collect()
    }

    /// Returns the names of the files that are created after steps: the pictures of frames and of
    /// all species, and the files of a look.
    fn late_files(&self, frames: &[u32], species: usize, look: Option<&Look>) -> Vec<String> {
        let mut files = self.frame_files(frames, species);
        files.extend(look.map(material::names).unwrap_or_default().into_iter().map(String::from));
        files.extend(has_picture(species, look).then(|| PICTURE.to_owned()));
        files
    }

    /// Returns the number of files that the folder receives, after a check that none of them exists
    /// yet, unless --force allows that.
    fn check_names(&self, frames: &[u32], species: usize, look: Option<&Look>) -> Result<usize> {
        let mut files = self.late_files(frames, species, look);
        files.extend([TABLE.into(), MESH.into(), MATERIAL.into()]);
        files.iter().try_for_each(|name| self.force.check(&self.output.join(name)))?;
        Ok(files.len())
    }

    /// Returns the file to continue from, with --resume and if there is one.
    fn saved(&self) -> Option<&Path> {
        self.state.as_deref().filter(|path| self.resume && path.symlink_metadata().is_ok())
    }

    /// Replaces the state of a simulation by the saved one, with --resume and if there is one.
    /// Returns the moments until then; none without a saved state.
    fn resume(&self, simulation: &mut Simulation) -> Result<Vec<Moment>> {
        let Some(path) = self.state.as_deref().filter(|_| self.resume) else {
            return Ok(Vec::new());
        };
        let name = path.display().to_string();
        if self.saved().is_none() {
            status!(
                "resumed",
                path = name,
                step = 0;
                "no {name}: the run starts from the first step"
            )?;
            return Ok(Vec::new());
        }
        let source = File::open(path).with_context(|| name.clone())?;
        let history = simulation.resume(&mut BufReader::new(source), path)?;
        let (step, all) = (simulation.state().step, self.steps);
        if step > all {
            bail!("--steps {all}: {name} is after {step} steps already");
        }
        let earlier = curves::moments(&history, simulation.species(), step as usize + 1);
        if !curves::are_of_a_run(&earlier) {
            bail!("{name}: has coverage that no run writes");
        }
        if earlier.is_empty() {
            note(format_args!("{name}: has no coverage; {TABLE} starts at step {step}"));
        }
        status!("resumed", path = name, step = step, steps = all; "{name}: step {step} of {all}")?;
        Ok(earlier)
    }

    /// Computes the steps and writes the frames, until a signal ends the run. `moments` are those
    /// until the first of these steps.
    fn grow(
        &self,
        growth: &mut Growth,
        options: &Options,
        frames: &[u32],
        mut moments: Vec<Moment>,
    ) -> Result<Grown> {
        let par = self.threads.par();
        let first = growth.simulation.state().step;
        let time_at = |step: u32| f64::from(step) * options.time_step;
        if moments.is_empty() {
            moments.push((time_at(first), growth.simulation.coverage(par)));
        }
        let start = Instant::now();
        let bar = Bar::new("slime");
        let mut done = first;
        let mut ended = Ok(());
        if frames.contains(&done) {
            self.write_frame(growth, done, options.species)?;
        }
        while done < self.steps && ended.is_ok() {
            let next = frames.iter().find(|&&step| step > done).map_or(self.steps, |&step| step);
            for covered in growth.advance(next - done, par)? {
                done += 1;
                moments.push((time_at(done), covered));
            }
            if frames.contains(&done) {
                self.write_frame(growth, done, options.species)?;
            }
            if bar.update(f64::from(done - first) / f64::from(self.steps - first))
                == ControlFlow::Break(())
            {
                ended = Err(Error::Cancelled);
            }
        }
        drop(bar);
        Ok(Grown { moments, done, time: start.elapsed(), ended })
    }

    fn write_frame(&self, growth: &mut Growth, step: u32, species: usize) -> Result<()> {
        let create = |name: String| self.force.create(&self.output.join(name));
        let files = frame_names(step, self.steps, species).into_iter().map(create);
        let size = growth.simulation.texels().size();
        images::write(&growth.frame()?, size, files.collect::<Result<_, _>>()?)
    }

    /// Draws the picture of --render.
    fn draw(
        &self,
        file: &MeshFile,
        simulation: &Simulation,
        maps: Option<&MaterialMaps>,
    ) -> Result<Image> {
        let Some(path) = &self.mesh else {
            let (mesh, uv) = view::four_tiles()?;
            // From above.
            let (azimuth, elevation, projection) = (0.0, 0.0, Projection::Orthographic);
            let above = View { azimuth, elevation, projection, ..View::DEFAULT };
            let view = View { up: self.up.unwrap_or(Up::Y), ..self.view.unwrap_or(above) };
            return Subject { mesh: &mesh, uv: &uv, simulation, maps }.draw(view, PIXELS);
        };
        let up = self.up.unwrap_or_else(|| guess_up(&file.mesh, path));
        let view = View { up, ..self.view.unwrap_or_default() };
        let uv = simulation.surface().uv();
        Subject { mesh: &file.mesh, uv, simulation, maps }.draw(view, PIXELS)
    }

    fn surface(&self, file: &MeshFile, size: usize) -> Result<Surface> {
        let Some(path) = &self.mesh else { return Ok(Surface::tile()?) };
        let uv = match &file.uv {
            Some(uv) if !self.atlas => uv,
            _ => return with_atlas(file, size, path),
        };
        let inside = fitted(uv);
        if inside != *uv {
            note(format_args!("{}: texture coordinates are scaled into 0 to 1", path.display()));
        }
        Surface::new(&file.mesh, &inside)
            .with_context(|| format!("{} (--atlas makes new texture coordinates)", path.display()))
    }

    fn simulation(&self, file: &MeshFile, options: &Options) -> Result<Simulation> {
        let surface = self.surface(file, options.size)?;
        let folded = surface.flipped().len();
        if folded > 0 {
            note(format_args!(
                "the texture is folded: {folded} triangles are upside down, the first is face {}",
                surface.flipped()[0]
            ));
        }
        let mask = match &self.mask {
            Some(path) => mask::read(path, options.size, &input::source())?,
            None => Mask::default(),
        };
        let mut charts = surface.charts().to_vec();
        charts.sort_unstable();
        charts.dedup();
        let (triangles, charts) = (surface.len(), charts.len());
        status!(
            "mesh",
            triangles = triangles,
            charts = charts;
            "{triangles} triangles, {charts} charts in the texture"
        )?;
        let simulation = Simulation::new(surface, options, &mask).map_err(|e| self.refused(e))?;
        if let Some(first) = simulation.texels().overlapping().first() {
            let count = simulation.texels().overlapping().len();
            note(format_args!(
                "faces share texture: {count} of {triangles} triangles overlap others in it, the \
                 first is face {first}; agents on one leave trails on all of them (--atlas makes \
                 texture coordinates without overlaps)"
            ));
        }
        let Options { agents, species, size, .. } = *options;
        status!(
            "slime",
            agents = agents,
            species = species,
            size = size,
            bytes = simulation.bytes();
            "{agents} agents of {species} species, {size} x {size} texels, {} MiB",
            simulation.bytes() >> 20
        )?;
        if agents < species {
            let without = species - agents;
            note(format_args!(
                "{without} of {species} species have no agents (--agents {agents}), and leave \
                 their textures black"
            ));
        }
        Ok(simulation)
    }

    /// Names the mask that an error of the library is about.
    fn refused(&self, error: Error) -> anyhow::Error {
        match (error, &self.mask) {
            (Error::Argument { what: "mask", why }, Some(path)) => {
                anyhow!("--mask {}: {why}", path.display())
            }
            (error, _) => error.into(),
        }
    }
}

/// Returns the mesh with the texture coordinates of the frames.
fn textured(file: &MeshFile, simulation: &Simulation) -> MeshFile {
    let values = simulation.surface().uv().as_flattened().to_vec();
    let corners = (0..values.len() as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let mut textured = MeshFile::from(file.mesh.clone());
    textured.uv = Some(Attribute { values, corners: Some(corners) });
    let of_faces = vec![0; file.mesh.faces().len()];
    textured.materials = Some(Labels { names: vec![MATERIAL_NAME.into()], of_faces });
    textured.material_files = vec![MATERIAL.into()];
    textured
}

/// Writes the material of the mesh (Wavefront MTL): the textures of its look, or the picture of a
/// frame.
fn write_material(mut output: Output, picture: Option<&str>, look: Option<&Look>) -> Result<()> {
    let texture = match look {
        Some(look) => material::statements(look),
        None => picture.map_or(String::new(), |name| format!("map_Kd {name}\n")),
    };
    let text = format!("newmtl {MATERIAL_NAME}\nKa 1 1 1\nKd 1 1 1\n{texture}");
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

fn with_atlas(file: &MeshFile, size: usize, path: &Path) -> Result<Surface> {
    let uv = atlas(&file.mesh, size).with_context(|| {
        let least = smallest_size(file.mesh.faces().len());
        format!("{}: its atlas needs --size {least} or more", path.display())
    })?;
    Surface::of_faces(&file.mesh, uv).with_context(|| path.display().to_string())
}
