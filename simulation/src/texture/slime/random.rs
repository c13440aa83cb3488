/// The purpose of a random number. For each purpose, an agent and a step have other numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// The angle by which an agent turns, and the side where both are equally good.
    Turn = 0,
    /// The position at which an agent starts.
    Place = 1,
    /// The heading with which an agent starts; each further number is another draw.
    Heading = 2,
}

/// Returns four random numbers for an agent and a step, from a counter alone: PCG4D (Jarzynski and
/// Olano, "Hash functions for GPU rendering", JCGT 9(3), 2020) of (agent, step, purpose, seed).
///
/// ```
/// use catamaran_simulation::texture::slime::draw;
///
/// assert_eq!(draw(1, 2, 3, 4), draw(1, 2, 3, 4));
/// assert_ne!(draw(1, 2, 3, 4), draw(1, 2, 4, 4));
/// ```
#[inline]
pub fn draw(seed: u32, agent: u32, step: u32, purpose: u32) -> [u32; 4] {
    let mut v = [agent, step, purpose, seed].map(|x| {
        let spread = x.wrapping_mul(1_664_525);
        spread.wrapping_add(1_013_904_223)
    });
    mix(&mut v);
    v = v.map(|x| x ^ (x >> 16));
    mix(&mut v);
    v
}

#[inline]
fn mix(v: &mut [u32; 4]) {
    for (to, a, b) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
        v[to] = v[to].wrapping_add(v[a].wrapping_mul(v[b]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_even_and_neighbours_differ() {
        let mut ones = [0_u32; 4];
        let count = 4096;
        for agent in 0..count {
            let numbers = draw(7, agent, 3, Purpose::Turn as u32);
            assert_ne!(numbers, draw(7, agent, 4, Purpose::Turn as u32));
            assert_ne!(numbers, draw(7, agent, 3, Purpose::Place as u32));
            assert_ne!(numbers, draw(8, agent, 3, Purpose::Turn as u32));
            for (sum, x) in ones.iter_mut().zip(numbers) {
                *sum += x.count_ones();
            }
        }
        // Each count has 131,072 bits: six standard deviations are 1,086.
        for sum in ones {
            assert!(sum.abs_diff(16 * count) < 1086, "{sum}");
        }
    }
}
