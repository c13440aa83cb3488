//! Materials of slime moulds: pheromone as mask for compositing and as relief (thesis, figures 3.1
//! and 3.11).

use super::margin::margin;
use super::relief::{normal_colors, normal_map};
use super::slime::{Blur, Options, Parameters, Simulation, diffuse_border, diffuse_row};
use catamaran::base::{Error, Par, Result, builder, options, reserved, within, zeros};

options! {
    /// The appearance of a part of a surface: colour, roughness, metalness, height and glow.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Finish {
        /// Colour in sRGB; for a metal, the colour that it reflects.
        color: [u8; 3] = [40, 44, 52];
        /// 0 for a mirror, 1 for a matte surface.
        roughness: f64 = 0.8, check(from 0.0 to 1.0);
        /// 1 for metal, 0 otherwise.
        metalness: f64 = 0.0, check(from 0.0 to 1.0);
        /// The height of the surface, in units of [`Look::depth`].
        height: f64 = 0.0, check(from -1.0 to 1.0);
        /// Share of its colour that the surface emits.
        glow: f64 = 0.0, range "from 0 to 1";
    }
}

impl Finish {
    /// Returns an error unless every number is in its range; the glow may be up to `glow`.
    pub(super) fn check(&self, glow: f64) -> Result<()> {
        self.check_ranges()?;
        within("glow", self.glow, 0.0, glow)
    }
}

/// The finishes of a surface, bare and under each species, and the way they are mixed.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Look {
    /// The finish without pheromone.
    pub bare: Finish,
    /// The finishes of the species; they repeat when there are more species.
    pub species: Vec<Finish>,
    /// Pheromone at which a species begins to show, and at which it hides the rest; from 0 to 1.
    /// Default 0.05, 0.5.
    pub mask: [f64; 2],
    /// The height that a value of 1 stands for, in hundredths of the square root of the area of the
    /// surface, at least 0. Default 0.5.
    pub depth: f64,
    /// Number of blurs of the pheromone, at most 64: fresh traces of agents are one texel wide.
    /// Default 2.
    pub smoothing: u32,
}

builder! { Look {
    bare: Finish,
    #[into]
    species: Vec<Finish>,
    mask: [f64; 2],
    depth: f64,
    smoothing: u32,
}}

/// Named looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Preset {
    /// Coloured strands, smooth and raised, on a dark rough ground.
    #[default]
    Strands,
    /// Grey veins in polished white stone (figure 3.1, left).
    Marble,
    /// A golden web on dark glass (figure 3.1, middle).
    Gold,
    /// Dark grain in wood (figure 3.1, right).
    Wood,
    /// Incisions in steel (figure 3.11).
    Engraved,
    /// Rivers of lava that glow in black rock (figure 3.11).
    Lava,
}

impl Preset {
    /// All presets with their names.
    pub const ALL: [(&'static str, Self); 6] = [
        ("strands", Self::Strands),
        ("marble", Self::Marble),
        ("gold", Self::Gold),
        ("wood", Self::Wood),
        ("engraved", Self::Engraved),
        ("lava", Self::Lava),
    ];
}

impl Default for Look {
    fn default() -> Self {
        Self::of(Preset::default())
    }
}

impl Look {
    /// Returns the look of a preset.
    ///
    /// ```
    /// use catamaran_simulation::texture::{Look, Preset};
    ///
    /// let look = Look::of(Preset::Gold).depth(1.0);
    /// assert!(look.check().is_ok());
    /// assert!(look.depth(-1.0).check().is_err());
    /// ```
    pub fn of(preset: Preset) -> Self {
        let finish = |color, roughness, metalness, height| {
            Finish::new().color(color).roughness(roughness).metalness(metalness).height(height)
        };
        let look = |bare, species, mask, depth| Self { bare, species, mask, depth, smoothing: 2 };
        match preset {
            Preset::Strands => {
                let colors = [
                    [255, 205, 80],
                    [90, 190, 255],
                    [255, 110, 140],
                    [150, 230, 130],
                    [200, 150, 255],
                    [240, 240, 240],
                ];
                let species = colors.map(|color| finish(color, 0.35, 0.0, 1.0));
                look(finish([40, 44, 52], 0.8, 0.0, 0.0), species.into(), [0.05, 0.5], 0.5)
            }
            Preset::Marble => look(
                finish([236, 233, 226], 0.18, 0.0, 0.0),
                vec![
                    finish([112, 116, 126], 0.26, 0.0, -0.3),
                    finish([188, 166, 132], 0.22, 0.0, 0.0),
                ],
                [0.0, 0.9],
                0.1,
            ),
            Preset::Gold => look(
                finish([22, 34, 44], 0.08, 0.0, 0.0),
                vec![
                    finish([255, 202, 96], 0.28, 1.0, 1.0),
                    finish([214, 216, 222], 0.25, 1.0, 1.0),
                ],
                [0.1, 0.45],
                0.6,
            ),
            Preset::Wood => look(
                finish([196, 148, 96], 0.55, 0.0, 0.0),
                vec![finish([104, 62, 34], 0.7, 0.0, -0.6), finish([148, 96, 54], 0.62, 0.0, -0.3)],
                [0.0, 0.8],
                0.3,
            ),
            Preset::Engraved => look(
                finish([188, 190, 196], 0.3, 1.0, 0.0),
                vec![finish([84, 82, 80], 0.65, 1.0, -1.0), finish([176, 124, 74], 0.4, 1.0, -1.0)],
                [0.1, 0.5],
                0.5,
            ),
            Preset::Lava => look(
                finish([30, 26, 26], 0.95, 0.0, 0.0),
                vec![finish([255, 96, 16], 0.6, 0.0, -1.0).glow(1.0)],
                [0.1, 0.7],
                0.8,
            ),
        }
    }

    /// Returns an error unless every value is in its range.
    ///
    /// # Errors
    /// [`Error::Argument`] names the value.
    pub fn check(&self) -> Result<()> {
        for finish in self.species.iter().chain([&self.bare]) {
            finish.check(1.0)?;
        }
        if self.species.is_empty() {
            let why = "must have at least one finish".into();
            return Err(Error::Argument { what: "species", why });
        }
        within("depth", self.depth, 0.0, 100.0)?;
        within("smoothing", self.smoothing, 0, 64)?;
        let [low, high] = self.mask;
        within("mask", low, 0.0, 1.0)?;
        within("mask", high, 0.0, 1.0)?;
        if low >= high {
            let why = format!("the first number must be smaller, is [{low}, {high}]");
            return Err(Error::Argument { what: "mask", why });
        }
        Ok(())
    }
}

/// The textures of a material for physically based rendering, of [`MaterialMaps::size`] rows and
/// columns, row 0 at v = 0. They have a [`margin`] around charts.
///
/// ```
/// use catamaran::{Par, base::Progress};
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, atlas};
/// use catamaran_simulation::texture::{Look, MaterialMaps, Preset};
///
/// let sphere = families::icosphere(2)?;
/// let surface = Surface::of_faces(&sphere, atlas(&sphere, 128)?)?;
/// let options = Options::new().agents(1000).size(128);
/// let mut simulation = Simulation::new(surface, &options, &Mask::default())?;
/// simulation.run(5, Par::all(), Progress::none())?;
/// let maps = MaterialMaps::new(&simulation, &Look::of(Preset::Gold), Par::all())?;
/// assert!(maps.metalness.contains(&0) && maps.metalness.contains(&255));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MaterialMaps {
    /// Texels of a side.
    pub size: usize,
    /// Colours (sRGB).
    pub albedo: Vec<[u8; 3]>,
    /// Roughness, 255 for 1.
    pub roughness: Vec<u8>,
    /// Metalness, 255 for 1.
    pub metalness: Vec<u8>,
    /// Height, 0 for the lowest finish, 65535 for the highest.
    pub height: Vec<u16>,
    /// Difference in height between the lowest finish and the highest, in the unit of the surface,
    /// the square root of its area.
    pub depth: f64,
    /// Normals, as from [`normal_map`] and [`normal_colors`].
    pub normal: Vec<[u8; 3]>,
    /// Emitted light (sRGB); `None` when no finish emits any.
    pub glow: Option<Vec<[u8; 3]>>,
}

impl MaterialMaps {
    /// Creates the textures of a simulation in its current state. Colours are mixed as linear
    /// light.
    ///
    /// # Errors
    /// As [`Look::check`]; [`Error::OutOfMemory`].
    pub fn new(simulation: &Simulation, look: &Look, par: Par) -> Result<Self> {
        look.check()?;
        let texels = simulation.texels();
        let count = texels.size() * texels.size();
        let mixture = Mixture::new(simulation, look, par)?;
        let heights = mixture.heights(count)?;
        let (low, high) = mixture.extremes();
        let depth = unless_zero(high - low) * look.depth / 100.0;
        let shown = margin(texels)?;
        let normals =
            normal_colors(&normal_map(simulation.surface(), texels, &heights, depth, par)?);
        let mut maps = Self {
            size: texels.size(),
            albedo: reserved(count)?,
            roughness: reserved(count)?,
            metalness: reserved(count)?,
            height: reserved(count)?,
            depth: if high > low { depth } else { 0.0 },
            normal: reserved(count)?,
            glow: None,
        };
        let Mixture { finishes, lights, .. } = &mixture;
        let glows = finishes.iter().any(|f| f.glow > 0.0);
        let mut glow = reserved(if glows { count } else { 0 })?;
        let byte = |x: f64| (255.0 * x).round() as u8;
        let mut shares = vec![0.0; finishes.len()];
        for t in shown.iter().map(|&t| t as usize) {
            mixture.shares(t, &mut shares);
            let mix = |value: &dyn Fn(usize) -> f64| mean(&shares, value);
            let light = |c: usize| mix(&|i| lights[i][c]);
            maps.albedo.push([0, 1, 2].map(|c| to_screen(light(c))));
            maps.roughness.push(byte(mix(&|i| finishes[i].roughness)));
            maps.metalness.push(byte(mix(&|i| finishes[i].metalness)));
            maps.height.push((65535.0 * heights[t].clamp(0.0, 1.0)).round() as u16);
            maps.normal.push(normals[t]);
            if glows {
                let light = |c: usize| mix(&|i| finishes[i].glow * lights[i][c]);
                glow.push([0, 1, 2].map(|c| to_screen(light(c))));
            }
        }
        maps.glow = glows.then_some(glow);
        Ok(maps)
    }
}

/// The finishes that a simulation mixes in each texel.
struct Mixture {
    /// The finishes of the species, and the bare one last.
    finishes: Vec<Finish>,
    /// Their colours, as linear light.
    lights: Vec<[f64; 3]>,
    /// How much of each species shows in each texel, from 0 to 1.
    masks: Vec<Vec<f32>>,
}

impl Mixture {
    fn new(simulation: &Simulation, look: &Look, par: Par) -> Result<Self> {
        let finish = |s: usize| look.species[s % look.species.len()];
        let finishes: Vec<Finish> =
            (0..simulation.species()).map(finish).chain([look.bare]).collect();
        let masks = (0..simulation.species())
            .map(|s| {
                let mut mask = smoothed(simulation, s, look.smoothing, par)?;
                mask.iter_mut().for_each(|p| *p = step(look.mask, *p));
                Ok(mask)
            })
            .collect::<Result<Vec<_>>>()?;
        let lights = finishes.iter().map(|f| f.color.map(to_light)).collect();
        Ok(Self { finishes, lights, masks })
    }

    /// Computes the share of each finish in texel t.
    fn shares(&self, t: usize, shares: &mut [f64]) {
        let (bare, species) = shares.split_last_mut().expect("there is a bare finish");
        let mut sum = 0.0;
        for (share, mask) in species.iter_mut().zip(&self.masks) {
            *share = f64::from(mask[t]);
            sum += *share;
        }
        species.iter_mut().for_each(|share| *share /= f64::max(sum, 1.0));
        *bare = (1.0 - sum).max(0.0);
    }

    /// Returns the heights of the lowest finish and of the highest.
    fn extremes(&self) -> (f64, f64) {
        self.finishes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), f| {
            (l.min(f.height), h.max(f.height))
        })
    }

    /// Returns the height of each texel, from 0 for the lowest finish to 1 for the highest.
    fn heights(&self, texels: usize) -> Result<Vec<f32>> {
        let (low, high) = self.extremes();
        let range = unless_zero(high - low);
        let mut heights = zeros::<f32>(texels)?;
        let mut shares = vec![0.0; self.finishes.len()];
        for (t, height) in heights.iter_mut().enumerate() {
            self.shares(t, &mut shares);
            let mean = mean(&shares, &|i| self.finishes[i].height);
            *height = ((mean - low) / range) as f32;
        }
        Ok(heights)
    }
}

/// Returns the sum of the values of the finishes, each times its share.
fn mean(shares: &[f64], value: &dyn Fn(usize) -> f64) -> f64 {
    shares.iter().enumerate().map(|(i, share)| share * value(i)).sum()
}

/// Returns a number, or 1 for 0: a range by which heights are divided.
fn unless_zero(range: f64) -> f64 {
    if range > 0.0 { range } else { 1.0 }
}

/// Returns a smooth step from 0 to 1 between two values (a cubic of Hermite).
fn step([low, high]: [f64; 2], x: f32) -> f32 {
    let t = ((f64::from(x) - low) / (high - low)).clamp(0.0, 1.0);
    (t * t * (3.0 - 2.0 * t)) as f32
}

/// Returns the pheromone of a species, blurred across seams and without evaporation.
fn smoothed(simulation: &Simulation, species: usize, passes: u32, par: Par) -> Result<Vec<f32>> {
    let texels = simulation.texels();
    let size = texels.size();
    // The blur crosses seams, whatever the blur of the simulation, so that no seam shows.
    let parameters = Parameters {
        blend: 1.0,
        evaporation: 0.0,
        ..Options::new().size(size).blur(Blur::SeamAware).parameters()?
    };
    let mut no_marks: Vec<u32> = reserved(size * size / 32)?;
    no_marks.resize(size * size / 32, 0);
    let mut texture = reserved(size * size)?;
    texture.extend_from_slice(simulation.texture(species));
    let mut next = zeros::<f32>(size * size)?;
    for _ in 0..passes {
        par.for_each(next.chunks_mut(size), |row, next| {
            let mut rows = vec![0.0; 4 * size];
            diffuse_row(&parameters, texels.kinds(), &texture, &no_marks, row, &mut rows, next);
        });
        for (number, &texel) in texels.border().iter().enumerate() {
            next[texel as usize] = diffuse_border(&parameters, texels, &texture, &no_marks, number);
        }
        std::mem::swap(&mut texture, &mut next);
    }
    Ok(texture)
}

/// Returns the linear light of a number in sRGB (IEC 61966-2-1).
pub(super) fn to_light(number: u8) -> f64 {
    let c = f64::from(number) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Returns the sRGB number of linear light, rounded.
pub(super) fn to_screen(light: f64) -> u8 {
    let l = light.clamp(0.0, 1.0);
    let c = if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    (255.0 * c).round() as u8
}
