//! Colours of roots.

/// The colour of points that reach no root ([`Fractal::unreached`](super::Fractal::unreached)),
/// which no root has, however slowly a point reaches it: black.
///
/// ```
/// use catamaran_simulation::texture::newton::{UNREACHED_COLOR, darkened, root_color};
///
/// assert!((0..9).all(|root| darkened(root_color(root, 3), 1.0) != UNREACHED_COLOR));
/// ```
pub const UNREACHED_COLOR: [u8; 3] = [0; 3];

/// Returns the colour (red, green, blue on screens) of root `root` of a polynomial with `roots`
/// roots in C: the hue represents the first number of the pair, a shift of hue and the brightness
/// the second. Neighbours among the `roots`^2 colours can be distinguished up to some 8 roots.
///
/// ```
/// use catamaran_simulation::texture::newton::root_color;
///
/// // z^3 - 1 has 9 roots in pairs of complex numbers, all of different colours.
/// let colors: std::collections::HashSet<_> = (0..9).map(|root| root_color(root, 3)).collect();
/// assert_eq!(colors.len(), 9);
/// ```
pub fn root_color(root: u16, roots: usize) -> [u8; 3] {
    let n = roots.max(1);
    let [a, b] = [usize::from(root) / n % n, usize::from(root) % n].map(|k| k as f64 / n as f64);
    // A shift of at most a third of the way to the next hue.
    let hue = 6.0 * (a + b / (3.0 * n as f64) + 0.58);
    let value = 0.98 - 0.45 * b;
    let saturation = 0.72 - 0.35 * b;
    // The hue as three trapezoids.
    [5.0, 3.0, 1.0].map(|shift| {
        let k = (hue + shift) % 6.0;
        let share = k.min(4.0 - k).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - saturation * share)).round() as u8
    })
}

/// Returns `color` darkened by `share`: unchanged for 0, a fifth of it for 1. With t / P of
/// [`Gradient`](super::Gradient), it shows how slowly a point converges.
///
/// ```
/// use catamaran_simulation::texture::newton::darkened;
///
/// assert_eq!(darkened([200, 100, 50], 0.0), [200, 100, 50]);
/// assert_eq!(darkened([200, 100, 50], 1.0), [40, 20, 10]);
/// ```
pub fn darkened(color: [u8; 3], share: f64) -> [u8; 3] {
    let light = 1.0 - 0.8 * share.clamp(0.0, 1.0);
    color.map(|c| (f64::from(c) * light).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_root_has_a_colour_of_its_own() {
        for n in 1..=8_u16 {
            let colors: HashSet<_> = (0..n * n).map(|k| root_color(k, usize::from(n))).collect();
            assert_eq!(colors.len(), usize::from(n * n), "{n} roots");
        }
        assert_eq!(root_color(7, 0), root_color(0, 1), "no roots, no division");
    }

    #[test]
    fn slow_points_are_dark() {
        assert_eq!(darkened([200, 100, 0], 0.0), [200, 100, 0]);
        assert_eq!(darkened([200, 100, 0], 7.0), [40, 20, 0]);
    }
}
