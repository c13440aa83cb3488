//! Materials over a fractal (thesis, figures 7.1c and 7.3): the root of a texel selects its
//! material, and slow convergence marks the joints between materials.

use std::collections::VecDeque;

use super::inlay::Inlay;
use super::texels::Texels;
use super::{Fractal, Newton};
use crate::texture::material::{to_light, to_screen};
use crate::texture::relief::{normal_colors, normal_map};
use crate::texture::slime;
use catamaran::base::{Error, Par, Result, reserved};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::io::{Attribute, Material, Picture};

impl Newton {
    /// Returns the material that `inlay` makes of the texels of a mesh, at which `fractal` was
    /// computed: colours, roughness and metalness, normals of the relief, and heights as an extra
    /// picture.
    ///
    /// `texels` come from [`texels`](super::texels()) for `size` x `size` texels; texels outside of
    /// the surface take the nearest one on it. Colours are mixed as linear light.
    ///
    /// ```
    /// use catamaran::{Par, base::Progress};
    /// use catamaran_geometry::mesh::{families, io::Attribute};
    /// use catamaran_simulation::texture::newton::{Inlay, Newton, NewtonOptions, Points, texels};
    ///
    /// let mesh = families::grid(4, 4)?;
    /// let values = mesh.vertices().iter().map(|p| [p[0], p[1]]).collect();
    /// let uv = Attribute { values, corners: None };
    /// let newton = Newton::new(&NewtonOptions::new())?;
    /// let found = texels(&mesh, &uv, 32, 32)?;
    /// let points = Points::List(&found.positions);
    /// let fractal = newton.evaluate(points, Par::all(), Progress::none())?;
    /// let made = newton.material(&mesh, &uv, &found, 32, &fractal, &Inlay::stones(), Par::all())?;
    /// assert_eq!(made.base_color.unwrap().width(), 32);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names a number of `inlay` that is out of its range; [`Error::Shape`]
    /// when the numbers of points of `fractal` and `texels` differ, or the texture has fewer
    /// texels; [`Error::Mesh`] for a mesh without relief: edges of three faces or more, faces
    /// without area or with coordinates outside of `[0, 1]`; [`Error::OutOfMemory`].
    pub fn material(
        &self,
        mesh: &TriMesh,
        uv: &Attribute<2>,
        texels: &Texels,
        size: usize,
        fractal: &Fractal,
        inlay: &Inlay,
        par: Par,
    ) -> Result<Material> {
        inlay.check()?;
        let count = texels.numbers.len();
        for len in [fractal.roots.len(), fractal.convergence.len()] {
            Error::check_shape("fractal", (count, 1), (len, 1))?;
        }
        let surface = slime::Surface::new(mesh, uv)?;
        let shown = nearest(&texels.numbers, size)?;
        let looks = self.looks(fractal, inlay)?;
        // A texture without a texel of the surface is black.
        let look = |t: &u32| looks.get(*t as usize).copied().unwrap_or_default();
        let looks = || shown.iter().map(look);

        // The relief has row 0 at v = 0.
        let mut heights: Vec<f32> = reserved(size * size)?;
        let row = |row: usize| &shown[row * size..(row + 1) * size];
        (0..size).rev().for_each(|r| heights.extend(row(r).iter().map(|t| look(t).height)));
        let grid = slime::Texels::new(&surface, size)?;
        let normals = normal_map(&surface, &grid, &heights, inlay.depth / 100.0, par)?;
        let margin = crate::texture::margin(&grid)?;
        let normals: Vec<_> = margin.iter().map(|&t| normals[t as usize]).collect();

        let colors: Vec<[u8; 3]> = looks().map(|l| l.light.map(to_screen)).collect();
        let byte = |x: f64| (255.0 * x).round() as u8;
        let roughness: Vec<u8> = looks().map(|l| byte(l.roughness)).collect();
        let metalness: Vec<u8> = looks().map(|l| byte(l.metalness)).collect();
        // -1 is black, 1 white.
        let heights: Vec<u16> =
            looks().map(|l| (32767.5 * f64::from(l.height) + 32767.5).round() as u16).collect();
        Ok(Material::new()
            .name("newton")
            .base_color(Picture::rgb(size, &colors)?)
            .roughness_metalness(Material::finish(size, &roughness, &metalness)?)
            .normal(Picture::rgb(size, &normal_colors(&normals))?.flipped())
            .extra(vec![("height".to_owned(), Picture::gray16(size, &heights)?)]))
    }

    /// Returns the look of each point.
    fn looks(&self, fractal: &Fractal, inlay: &Inlay) -> Result<Vec<Look>> {
        let mut sorted = reserved(fractal.convergence.len())?;
        sorted.extend_from_slice(&fractal.convergence);
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |share: f64| {
            let last = sorted.len().saturating_sub(1);
            sorted.get((share * last as f64).round() as usize).map_or(0.0, |&t| self.share(t))
        };
        let [low, high] = inlay.range.map(at);
        let width = (high - low).max(1e-9);
        let mut looks = reserved(fractal.roots.len())?;
        looks.extend(fractal.roots.iter().zip(&fractal.convergence).map(|(&root, &t)| {
            let x = ((self.share(t) - low) / width).clamp(0.0, 1.0);
            // Hermite's cubic, smooth at both ends.
            let joint = x * x * (3.0 - 2.0 * x);
            let [own, other] = [inlay.basins[usize::from(root) % inlay.basins.len()], inlay.joint];
            let mix = |a: f64, b: f64| a + joint * (b - a);
            Look {
                light: [0, 1, 2].map(|c| mix(to_light(own.color[c]), to_light(other.color[c]))),
                roughness: mix(own.roughness, other.roughness),
                metalness: mix(own.metalness, other.metalness),
                height: mix(own.height, other.height) as f32,
            }
        }));
        Ok(looks)
    }
}

/// The look of a point of a surface.
#[derive(Debug, Clone, Copy, Default)]
struct Look {
    light: [f64; 3],
    roughness: f64,
    metalness: f64,
    height: f32,
}

/// Returns for each texel of a square the nearest of the texels in `numbers`, in steps to
/// neighbours in the same row or column.
fn nearest(numbers: &[u32], size: usize) -> Result<Vec<u32>> {
    let mut nearest: Vec<u32> = reserved(size * size)?;
    nearest.resize(size * size, u32::MAX);
    let mut queue = VecDeque::new();
    for (i, &number) in numbers.iter().enumerate() {
        match nearest.get_mut(number as usize) {
            Some(own) => *own = i as u32,
            None => {
                let (most, found) = (size * size, number as usize + 1);
                return Err(Error::Shape { what: "texels", expected: (most, 1), got: (found, 1) });
            }
        }
        queue.push_back(number as usize);
    }
    while let Some(t) = queue.pop_front() {
        let (x, y) = (t % size, t / size);
        let beside = [
            (x > 0).then(|| t - 1),
            (x + 1 < size).then(|| t + 1),
            (y > 0).then(|| t - size),
            (y + 1 < size).then(|| t + size),
        ];
        for n in beside.into_iter().flatten() {
            if nearest[n] == u32::MAX {
                nearest[n] = nearest[t];
                queue.push_back(n);
            }
        }
    }
    Ok(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Finish;
    use crate::texture::newton::{NewtonOptions, Points, root_color, texels};
    use catamaran::base::Progress;
    use catamaran_geometry::mesh::families;

    /// Returns the unit square, its texture and its fractal.
    fn square(size: u32) -> (TriMesh, Attribute<2>, Texels, Newton, Fractal) {
        let mesh = families::grid(6, 6).unwrap();
        let uv: Vec<_> = mesh.vertices().iter().map(|p| [p[0], p[1]]).collect();
        let uv = Attribute { values: uv, corners: None };
        let found = texels(&mesh, &uv, size, size).unwrap();
        let options = NewtonOptions::new().offset([-0.5; 3]).scale(3.0);
        let newton = Newton::new(&options).unwrap();
        let points = Points::List(&found.positions);
        let fractal = newton.evaluate(points, Par::Seq, Progress::none()).unwrap();
        (mesh, uv, found, newton, fractal)
    }

    /// Returns the bytes of the pixels of a picture.
    fn pixels(picture: &Picture) -> Vec<u8> {
        let png = picture.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let len = reader.next_frame(&mut bytes).unwrap().buffer_size();
        bytes.truncate(len);
        bytes
    }

    #[test]
    fn fast_texels_are_of_their_root_and_the_slowest_are_joints() {
        let (mesh, uv, found, newton, fractal) = square(64);
        let inlay = Inlay::enamel(3);
        let run = |par| newton.material(&mesh, &uv, &found, 64, &fractal, &inlay, par).unwrap();
        let made = run(Par::Seq);
        assert_eq!(run(Par::Threads(3)), made, "the number of threads changes nothing");
        let colors = pixels(&made.base_color.unwrap());
        let finish = pixels(&made.roughness_metalness.unwrap());
        let mut sorted = fractal.convergence.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let [fast, slow] = [0.7, 0.97].map(|share| sorted[(share * 4095.0) as usize]);
        let mut counts = [0; 2];
        for (i, &number) in found.numbers.iter().enumerate() {
            let at = 3 * number as usize;
            let color = [colors[at], colors[at + 1], colors[at + 2]];
            if fractal.convergence[i] <= fast {
                assert_eq!(color, root_color(fractal.roots[i], 3));
                assert_eq!(finish[at + 1..at + 3], [41, 0]);
                counts[0] += 1;
            } else if fractal.convergence[i] > slow {
                assert_eq!(color, [255, 202, 96]);
                assert_eq!(finish[at + 1..at + 3], [77, 255]);
                counts[1] += 1;
            }
        }
        assert!(counts[0] > 2000 && counts[1] > 50, "{counts:?}");
    }

    #[test]
    fn relief_leans_away_from_joints_and_vanishes_without_depth() {
        let (mesh, uv, found, newton, fractal) = square(64);
        let normals = |depth: f64| {
            let inlay = Inlay::stones().depth(depth);
            let made = newton.material(&mesh, &uv, &found, 64, &fractal, &inlay, Par::Seq).unwrap();
            (pixels(&made.normal.unwrap()), pixels(&made.extra[0].1))
        };
        let (flat, _) = normals(0.0);
        assert!(flat.chunks_exact(3).all(|n| n == [128, 128, 255]));
        let (normal, height) = normals(2.0);
        let height = |t: usize| i32::from(height[2 * t]) * 256 + i32::from(height[2 * t + 1]);
        let mut checked = 0;
        for row in 1..63 {
            for column in 1..63 {
                let t = 64 * row + column;
                // Rows run downwards, v upwards.
                let (right, up) = (height(t + 1) - height(t - 1), height(t - 64) - height(t + 64));
                for (slope, lean) in [(right, normal[3 * t]), (up, normal[3 * t + 1])] {
                    if slope.abs() > 2000 {
                        assert_eq!(lean < 128, slope > 0, "{row} {column} {slope} {lean}");
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 200, "{checked}");
    }

    #[test]
    fn texels_outside_show_the_nearest_inside() {
        assert_eq!(nearest(&[5], 4).unwrap(), [0; 16]);
        let two = nearest(&[0, 15], 4).unwrap();
        assert_eq!((two[1], two[4], two[14], two[11]), (0, 0, 1, 1));
        assert_eq!(nearest(&[], 2).unwrap(), [u32::MAX; 4]);
        assert!(matches!(nearest(&[16], 4), Err(Error::Shape { what: "texels", .. })));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let (mesh, uv, found, newton, fractal) = square(8);
        let run = |inlay: &Inlay, fractal: &Fractal| {
            newton.material(&mesh, &uv, &found, 8, fractal, inlay, Par::Seq).unwrap_err()
        };
        for (inlay, part) in [
            (Inlay::stones().basins(vec![]), "basins"),
            (
                Inlay::stones().joint(Finish::new().roughness(2.0)),
                "roughness: must be from 0 to 1, is 2",
            ),
            (Inlay::stones().joint(Finish::new().glow(1.0)), "glow"),
            (Inlay::stones().depth(-1.0), "depth"),
            (Inlay::stones().range([0.9, 0.1]), "range"),
        ] {
            let error = run(&inlay, &fractal).to_string();
            assert!(error.contains(part), "{error}");
        }
        let none = Fractal::default();
        assert!(matches!(run(&Inlay::stones(), &none), Error::Shape { what: "fractal", .. }));
    }
}
