//! Shows voxels as pictures of volumes, and as surfaces of basins.

use anyhow::{Result, bail};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::mesh::io::{Labels, MeshFile};
use catamaran_geometry::mesh::{Rim, TriMesh};
use catamaran_simulation::texture::newton::{Fractal, Grid, Newton, UNREACHED_COLOR, root_color};
use clap::ValueEnum;

use crate::picture::Volume;

/// Numbers of roots; `None` for all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Basins(Option<Vec<u16>>);

impl Basins {
    /// Parses `all`, or numbers separated by commas.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self(None));
        }
        let numbers: Result<Vec<u16>, _> =
            text.split(',').map(|n| n.trim().parse::<u16>()).collect();
        match numbers {
            Ok(mut numbers) => {
                numbers.sort_unstable();
                numbers.dedup();
                Ok(Self(Some(numbers)))
            }
            Err(_) => Err("expected `all`, or numbers of roots such as 0,4,8".into()),
        }
    }

    /// Returns the numbers, and refuses roots that the polynomial does not have.
    pub fn of(&self, newton: &Newton) -> Result<Vec<u16>> {
        let count = newton.roots().pow(2);
        let Some(numbers) = &self.0 else { return Ok((0..count as u16).collect()) };
        match numbers.iter().find(|&&number| usize::from(number) >= count) {
            Some(number) => bail!("--basins {number}: the roots are 0 to {}", count - 1),
            None => Ok(numbers.clone()),
        }
    }
}

/// The part of a volume that is opaque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Opacity {
    /// The basins.
    Solid,
    /// Where points converge slowly: borders of basins.
    Slow,
}

/// The extinction of a solid voxel, per side: some 2 % of the light comes through.
const SOLID: f64 = 4.0;
/// The largest extinction of slow voxels, per side of the cube.
const SLOW: f64 = 60.0;
/// The shares of voxels, ordered by speed of convergence, from which voxels are seen, and from
/// which they are as opaque as possible.
const SEEN: [f64; 2] = [0.7, 0.995];

/// Converts shares of convergence to opacity.
#[derive(Debug, Clone, Copy)]
pub struct Transfer {
    low: f64,
    high: f64,
}

impl Transfer {
    /// Returns a transfer function that suits this fractal.
    pub fn new(newton: &Newton, fractal: &Fractal) -> Self {
        let mut all: Vec<f32> = fractal.convergence.clone();
        let last = all.len().saturating_sub(1);
        let mut at = |share: f64| match (share * last as f64) as usize {
            i if i < all.len() => newton.share(*all.select_nth_unstable_by(i, f32::total_cmp).1),
            _ => 0.0,
        };
        let [low, high] = SEEN.map(&mut at);
        Self { low, high: high.max(low + 1e-6) }
    }

    fn opacity(self, share: f64) -> f64 {
        ((share - self.low) / (self.high - self.low)).clamp(0.0, 1.0).powi(2)
    }
}

/// Returns voxels in the colours of their roots; only those of the given basins are opaque.
pub fn volume(
    newton: &Newton,
    grid: &Grid,
    fractal: &Fractal,
    basins: &[u16],
    opacity: Opacity,
    transfer: Transfer,
) -> Volume {
    let n = newton.roots();
    let shown = |root: &u16| basins.binary_search(root).is_ok();
    let step = [0, 1, 2].map(|c| f64::from(grid.steps[c][c]));
    let side = step[0] * f64::from(grid.counts[0]);
    let extinction = |(root, &t): (&u16, &f32)| match (shown(root), opacity) {
        (false, _) => 0.0,
        (true, Opacity::Solid) => (SOLID / step[0]) as f32,
        (true, Opacity::Slow) => (SLOW / side * transfer.opacity(newton.share(t))) as f32,
    };
    let mut colors: Vec<_> = fractal.roots.iter().map(|&root| root_color(root, n)).collect();
    for &i in &fractal.unreached {
        colors[i as usize] = UNREACHED_COLOR;
    }
    Volume {
        counts: grid.counts.map(|count| count as usize),
        low: [0, 1, 2].map(|c| f64::from(grid.origin[c]) - 0.5 * step[c]),
        step,
        colors,
        extinction: fractal.roots.iter().zip(&fractal.convergence).map(extinction).collect(),
    }
}

/// Returns the closed surfaces of basins as one mesh, in the colours of their roots, with a group
/// for each basin.
pub fn surfaces(
    newton: &Newton,
    grid: &Grid,
    fractal: &Fractal,
    basins: &[u16],
    par: Par,
    progress: Progress<'_>,
) -> Result<MeshFile> {
    let (mut vertices, mut faces, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    let mut groups = Labels { names: Vec::new(), of_faces: Vec::new() };
    let share = |i: usize| i as f64 / basins.len() as f64;
    for (i, &root) in basins.iter().enumerate() {
        let progress = progress.part(share(i)..share(i + 1));
        let basin = newton.basin(grid, fractal, root, Rim::Closed, par, progress)?;
        if basin.faces().is_empty() {
            continue;
        }
        let (places, corners) = basin.into_parts();
        let first = vertices.len() as u32;
        vertices.extend(places);
        if u32::try_from(vertices.len()).is_err() {
            bail!("{} vertices, where a mesh has at most 2^32 - 1", vertices.len());
        }
        faces.extend(corners.into_iter().map(|face| face.map(|v| first + v)));
        let [r, g, b] = root_color(root, newton.roots()).map(|c| f64::from(c) / 255.0);
        colors.resize(vertices.len(), [r, g, b, 1.0]);
        groups.of_faces.resize(faces.len(), groups.names.len() as u32);
        groups.names.push(format!("root-{root}"));
    }
    if faces.is_empty() {
        bail!("--basins: no voxel is in any of these basins");
    }
    let mut file = MeshFile::from(TriMesh::new(vertices, faces)?);
    file.colors = Some(colors);
    file.groups = Some(groups);
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran_simulation::texture::newton::{NewtonOptions, Points};

    #[test]
    fn basins_are_numbers_of_roots() {
        let newton = Newton::new(&NewtonOptions::new()).unwrap();
        let of = |text: &str| Basins::parse(text).unwrap().of(&newton);
        assert_eq!(of("all").unwrap(), (0..9).collect::<Vec<_>>());
        assert_eq!(of("7, 0,7").unwrap(), [0, 7]);
        assert!(of("9").unwrap_err().to_string().contains("the roots are 0 to 8"));
        for wrong in ["", "x", "1;2", "-1", "70000"] {
            assert!(Basins::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn only_slow_voxels_of_chosen_basins_are_seen() {
        let newton = Newton::new(&NewtonOptions::new()).unwrap();
        let grid = Grid::cube(24, 3.0);
        let fractal = newton.evaluate(Points::Grid(grid), Par::Seq, Progress::none()).unwrap();
        let transfer = Transfer::new(&newton, &fractal);
        let made = |basins: &[u16], opacity| {
            volume(&newton, &grid, &fractal, basins, opacity, transfer).extinction
        };
        let seen = |extinction: &[f32]| extinction.iter().filter(|&&x| x > 0.0).count();
        let all: Vec<u16> = (0..9).collect();
        let slow = seen(&made(&all, Opacity::Slow)) as f64 / fractal.roots.len() as f64;
        assert!((0.2..0.35).contains(&slow), "{slow}");
        assert_eq!(seen(&made(&all, Opacity::Solid)), fractal.roots.len());
        let one = fractal.roots.iter().filter(|&&root| root == 4).count();
        assert_eq!(seen(&made(&[4], Opacity::Solid)), one);
        let parts: usize = all.iter().map(|&root| seen(&made(&[root], Opacity::Slow))).sum();
        assert_eq!(parts, seen(&made(&all, Opacity::Slow)));
    }
}
