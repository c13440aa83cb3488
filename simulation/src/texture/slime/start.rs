use super::kinds::OBSTACLE;
use super::locate::anchor;
use super::random::{Purpose, draw};
use super::surface::{NO_TRIANGLE, Surface};
use super::texels::Texels;
use super::walk::Walker;
use catamaran::base::{Error, Result, reserved};

/// Headings are drawn until one is found; so many draws are practically never needed.
const TRIES: u32 = 64;

/// Places agents anywhere on the surface, with equal probability for equal areas.
pub(super) fn everywhere(surface: &Surface, agents: usize, seed: u32) -> Result<Vec<Walker>> {
    let ends = sums(surface.areas().iter().copied())?;
    let mut walkers = reserved(agents)?;
    for agent in 0..agents as u32 {
        let [high, low, a, b] = draw(seed, agent, 0, Purpose::Place as u32);
        let triangle = pick(&ends, high, low);
        let [_, [length, _], [x, y]] = surface.corners()[triangle];
        let (mut a, mut b) = (unit(a), unit(b));
        if a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        walkers.push(Walker {
            triangle: triangle as u32,
            position: [(a * length + b * x) as f32, (b * y) as f32],
            heading: heading(seed, agent),
        });
    }
    Ok(walkers)
}

/// Places agents in the texels where `allowed` holds and which are no obstacle.
pub(super) fn in_texels(
    surface: &Surface,
    texels: &Texels,
    allowed: impl Fn(usize) -> bool,
    ground: &[u8],
    agents: usize,
    seed: u32,
) -> Result<Vec<Walker>> {
    let free = |t: &u32| {
        allowed(*t as usize)
            && ground.get(*t as usize) != Some(&OBSTACLE)
            && texels.is_owned(*t as usize)
    };
    let places: Vec<u32> = (0..texels.owners().len() as u32).filter(free).collect();
    let ends = sums(places.iter().map(|&t| f64::from(texels.areas()[t as usize])))?;
    if agents > 0 && ends.last().is_none_or(|&sum| sum <= 0.0) {
        let why = "has no texel on the surface where agents may start".into();
        return Err(Error::Argument { what: "mask", why });
    }
    let mut walkers = reserved(agents)?;
    for agent in 0..agents as u32 {
        let [high, low, ..] = draw(seed, agent, 0, Purpose::Place as u32);
        let texel = places[pick(&ends, high, low)] as usize;
        let triangle = texels.owners()[texel];
        debug_assert_ne!(triangle, NO_TRIANGLE);
        walkers.push(Walker {
            triangle,
            position: anchor(surface, texels.size(), triangle, texel),
            heading: heading(seed, agent),
        });
    }
    Ok(walkers)
}

fn sums(areas: impl Iterator<Item = f64>) -> Result<Vec<f64>> {
    let mut ends = reserved(areas.size_hint().0)?;
    let mut sum = 0.0;
    for area in areas {
        sum += area;
        ends.push(sum);
    }
    Ok(ends)
}

/// Returns the index of the first sum above a random share of the last sum.
fn pick(ends: &[f64], high: u32, low: u32) -> usize {
    let part = unit(high) + unit(low) / (1_u64 << 32) as f64;
    let wanted = part * ends.last().copied().unwrap_or_default();
    ends.partition_point(|&end| end <= wanted).min(ends.len() - 1)
}

/// Returns a number in `[0, 1)`.
fn unit(bits: u32) -> f64 {
    f64::from(bits) / (1_u64 << 32) as f64
}

/// Returns a uniformly distributed direction: random points of the square until one is in the disk
/// (von Neumann 1951), so that no sine is needed.
fn heading(seed: u32, agent: u32) -> [f32; 2] {
    for attempt in 0..TRIES {
        let bits = draw(seed, agent, 0, Purpose::Heading as u32 + attempt);
        for pair in [[bits[0], bits[1]], [bits[2], bits[3]]] {
            let [x, y] = pair.map(|b| 2.0 * unit(b) - 1.0);
            let square = x * x + y * y;
            if (1e-4..=1.0).contains(&square) {
                let length = square.sqrt();
                return [(x / length) as f32, (y / length) as f32];
            }
        }
    }
    [1.0, 0.0]
}
