use std::sync::atomic::AtomicU32;

use super::agents::{Field, agent_step, mark};
use super::coverage::{Coverage, coverage};
use super::diffuse::{diffuse_border, diffuse_row};
use super::kinds::{FREE, GOAL, OBSTACLE};
use super::options::{Options, Parameters};
use super::order::{EVERY, order};
use super::start::{everywhere, in_texels};
use super::state::State;
use super::surface::Surface;
use super::texels::Texels;
use super::walk::Walker;
use catamaran::base::{Error, Par, Progress, Result, check_request, reserved, zeros};

/// Number of agents that one thread moves at a time.
const AGENTS: usize = 4096;
/// Number of rows that one thread blurs at a time; divides the size of every texture.
const ROWS: usize = 32;

/// Where agents start, and where obstacles are: a value for each texel; an empty list stands for no
/// mask.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Mask {
    /// Whether agents start in a texel; empty for everywhere.
    pub start: Vec<bool>,
    /// [`FREE`], [`OBSTACLE`] or [`GOAL`]; empty for all free.
    pub ground: Vec<u8>,
}

/// Slime moulds on a surface (thesis, algorithm 3.2), on the CPU. The number of threads does not
/// change the state, bit for bit.
///
/// ```
/// use catamaran::{Par, base::Progress};
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, atlas};
///
/// let sphere = families::icosphere(2)?;
/// let surface = Surface::of_faces(&sphere, atlas(&sphere, 128)?)?;
/// let options = Options::new().agents(1000).size(128);
/// let mut simulation = Simulation::new(surface, &options, &Mask::default())?;
/// simulation.run(5, Par::all(), Progress::none())?;
/// assert!(simulation.texture(0).iter().any(|&trail| trail > 0.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct Simulation {
    surface: Surface,
    texels: Texels,
    options: Options,
    parameters: Parameters,
    ground: Vec<u8>,
    /// The checksum of the mask.
    mask: u32,
    state: State,
    next: Vec<f32>,
    marks: Vec<AtomicU32>,
    marked: Vec<u32>,
}

/// Returns an error when the textures or the agents need more memory than there is.
fn check_memory(options: &Options) -> Result<()> {
    /// Bytes of a texel of a species, before and after a step.
    const TRAIL: usize = 8;
    /// Bytes of a texel of the surface: its triangle and its area.
    const TEXEL: usize = 8;
    /// Bytes of an agent.
    const AGENT: usize = 24;
    let Options { species, size, agents, .. } = *options;
    let texels = size * size;
    let bytes = (texels * (species * TRAIL + TEXEL)) as f64 + agents as f64 * AGENT as f64;
    let request = format_args!("{species} textures of {size} x {size} and {agents} agents");
    check_request("size", request, bytes)
}

impl Simulation {
    /// Creates a simulation with agents at their start positions, and no pheromone.
    ///
    /// # Errors
    /// [`Error::Argument`] names an invalid option or mask, [`Error::Shape`] a mask that does not
    /// have `size` x `size` texels; [`Error::OutOfMemory`].
    pub fn new(surface: Surface, options: &Options, mask: &Mask) -> Result<Self> {
        let parameters = options.parameters()?;
        if surface.is_tile() && parameters.substeps != 0 {
            let why = "must be unfolded steps on a tile, which has no position in space".into();
            return Err(Error::Argument { what: "tangent_step", why });
        }
        let size = options.size;
        check_mask(mask, size)?;
        check_memory(options)?;
        let texels = Texels::new(&surface, size)?;
        let (agents, seed) = (options.agents, options.seed);
        let walkers = if mask.start.is_empty() && mask.ground.is_empty() {
            everywhere(&surface, agents, seed)?
        } else {
            let starts = |t: usize| mask.start.is_empty() || mask.start[t];
            in_texels(&surface, &texels, starts, &mask.ground, agents, seed)?
        };
        let entries = options.species * size * size;
        let mut marks = reserved(entries / 32)?;
        marks.resize_with(entries / 32, AtomicU32::default);
        let mut marked = reserved(entries / 32)?;
        marked.resize(entries / 32, 0);
        Ok(Self {
            state: State::new(&walkers, zeros(entries)?)?,
            ground: mask.ground.clone(),
            mask: mask.checksum(),
            options: *options,
            next: zeros(entries)?,
            surface,
            texels,
            parameters,
            marks,
            marked,
        })
    }

    /// Computes one step of all agents and of the texture.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface};
    ///
    /// let options = Options::new().agents(100).size(64);
    /// let mut simulation = Simulation::new(Surface::tile()?, &options, &Mask::default())?;
    /// simulation.step(Par::Seq);
    /// assert_eq!(simulation.state().step, 1);
    /// assert!(simulation.coverage(Par::Seq)[0].coverage > 0.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn step(&mut self, par: Par) {
        if self.state.step.is_multiple_of(EVERY) {
            // Without memory for the ordering, the step is slower, and has the same result.
            let _ = order(&mut self.state, &self.surface, self.texels.size());
        }
        self.move_agents(par);
        self.collect_marks();
        self.diffuse(par);
        self.state.step = self.state.step.wrapping_add(1);
    }

    /// Computes `steps` steps; `progress` is called after each, and may cancel.
    ///
    /// # Errors
    /// [`Error::Cancelled`]: earlier steps are complete, and a later call can continue.
    pub fn run(&mut self, steps: u32, par: Par, progress: Progress<'_>) -> Result<()> {
        for done in 1..=steps {
            self.step(par);
            progress.report(f64::from(done) / f64::from(steps))?;
        }
        Ok(())
    }

    fn move_agents(&mut self, par: Par) {
        let (surface, parameters, marks) = (&self.surface, &self.parameters, &self.marks);
        let plane = parameters.size * parameters.size;
        let State { step, ids, triangles, positions, headings, texture } = &mut self.state;
        let field = Field { texture, ground: &self.ground };
        let blocks = triangles
            .chunks_mut(AGENTS)
            .zip(positions.chunks_mut(AGENTS))
            .zip(headings.chunks_mut(AGENTS))
            .zip(ids.chunks(AGENTS));
        par.for_each(blocks, |_, (((triangles, positions), headings), ids)| {
            let agents = triangles.iter_mut().zip(positions).zip(headings).zip(ids);
            for (((triangle, position), heading), &agent) in agents {
                let walker = Walker { triangle: *triangle, position: *position, heading: *heading };
                let (next, texel) = agent_step(surface, field, parameters, walker, agent, *step);
                (*triangle, *position, *heading) = (next.triangle, next.position, next.heading);
                mark(marks, agent % parameters.species * plane + texel);
            }
        });
    }

    /// Takes the marks of this step, and clears them.
    fn collect_marks(&mut self) {
        for (out, word) in self.marked.iter_mut().zip(&mut self.marks) {
            *out = std::mem::take(word.get_mut());
        }
    }

    fn diffuse(&mut self, par: Par) {
        let (parameters, texels, marked) = (&self.parameters, &self.texels, &self.marked);
        let texture = &self.state.texture;
        let size = parameters.size as usize;
        let plane = size * size;
        par.for_each(self.next.chunks_mut(ROWS * size), |block, next| {
            let first = block * ROWS * size;
            let (species, row) = (first / plane, first % plane / size);
            let texture = &texture[species * plane..(species + 1) * plane];
            let marks = &marked[species * plane / 32..(species + 1) * plane / 32];
            let mut scratch = vec![0.0; 4 * size];
            for (row, next) in (row..).zip(next.chunks_mut(size)) {
                diffuse_row(parameters, texels.kinds(), texture, marks, row, &mut scratch, next);
            }
            if parameters.seam_aware == 0 {
                return;
            }
            let from = (row * size) as u32;
            let border = texels.border();
            let start = border.partition_point(|&t| t < from);
            let end = from + next.len() as u32;
            let own = border[start..].iter().take_while(|&&t| t < end);
            for (number, &texel) in (start..).zip(own) {
                next[(texel - from) as usize] =
                    diffuse_border(parameters, texels, texture, marks, number);
            }
        });
        std::mem::swap(&mut self.next, &mut self.state.texture);
    }

    /// Returns the coverage of the surface by each species.
    pub fn coverage(&self, par: Par) -> Vec<Coverage> {
        let of = |s| coverage(&self.texels, self.texture(s), par);
        (0..self.species()).map(of).collect()
    }

    /// Returns the texture of a species: [`Texels::size`] rows and columns of values in `[0, 1]`,
    /// row 0 at v = 0.
    ///
    /// # Panics
    /// When the species does not exist.
    pub fn texture(&self, species: usize) -> &[f32] {
        let plane = self.texels.size() * self.texels.size();
        &self.state.texture[species * plane..(species + 1) * plane]
    }

    /// Returns the texture of a species as bytes: 255 times the pheromone, rounded.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface};
    ///
    /// let options = Options::new().agents(100).size(64);
    /// let mut simulation = Simulation::new(Surface::tile()?, &options, &Mask::default())?;
    /// simulation.step(Par::Seq);
    /// let frame = simulation.frame(0);
    /// assert_eq!(f32::from(frame[0]), (255.0 * simulation.texture(0)[0]).round());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Panics
    /// When the species does not exist.
    pub fn frame(&self, species: usize) -> Vec<u8> {
        self.texture(species).iter().map(|p| (255.0 * p).round() as u8).collect()
    }

    /// Returns the memory that the simulation holds, in bytes.
    pub fn bytes(&self) -> usize {
        let textures = 2 * size_of_val(&self.next[..]) + 2 * size_of_val(&self.marked[..]);
        let agents = self.state.ids.len() * (2 * size_of::<u32>() + 4 * size_of::<f32>());
        textures + agents + self.ground.len() + self.texels.bytes() + self.surface.bytes()
    }

    /// Returns the number of species.
    pub fn species(&self) -> usize {
        self.parameters.species as usize
    }

    /// Returns the agents and textures.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Continues from another state.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface};
    ///
    /// let options = Options::new().agents(100).size(64);
    /// let mut simulation = Simulation::new(Surface::tile()?, &options, &Mask::default())?;
    /// let start = simulation.state().clone();
    /// simulation.step(Par::Seq);
    /// simulation.set_state(start)?;
    /// assert_eq!(simulation.state().step, 0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when the state has another number of agents or texels, [`Error::Argument`]
    /// when it is no valid state of this simulation; the error names the agent or the entry of the
    /// texture.
    pub fn set_state(&mut self, state: State) -> Result<()> {
        state.check(&self.surface)?;
        self.put_state(state)
    }

    /// Continues from another state as [`Simulation::set_state`] does, but without a check of each
    /// agent: the state comes from the kernels of this simulation.
    pub(crate) fn put_state(&mut self, state: State) -> Result<()> {
        let count = |state: &State| (state.triangles.len(), 1);
        Error::check_shape("agents", count(&self.state), count(&state))?;
        Error::check_shape("texture", (self.next.len(), 1), (state.texture.len(), 1))?;
        self.state = state;
        Ok(())
    }

    /// Returns the surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Returns the texels of the texture.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// Returns the options.
    pub(super) fn options(&self) -> &Options {
        &self.options
    }

    /// Returns the checksum of the mask.
    pub(super) fn mask_checksum(&self) -> u32 {
        self.mask
    }

    /// Returns the options as the kernels take them.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Returns [`FREE`], [`OBSTACLE`] or [`GOAL`] for each texel; empty when all are free.
    pub fn ground(&self) -> &[u8] {
        &self.ground
    }
}

fn check_mask(mask: &Mask, size: usize) -> Result<()> {
    let expected = (size, size);
    for (what, len) in [("mask.start", mask.start.len()), ("mask.ground", mask.ground.len())] {
        if len != 0 && len != size * size {
            return Err(Error::Shape { what, expected, got: (len / size, size) });
        }
    }
    match mask.ground.iter().position(|g| ![FREE, OBSTACLE, GOAL].contains(g)) {
        None => Ok(()),
        Some(t) => Err(Error::Argument {
            what: "mask.ground",
            why: format!("must be 0, 1 or 2, is {} at texel {t}", mask.ground[t]),
        }),
    }
}
