//! Draws volumes of coloured, lit, partly transparent voxels: emission and absorption along rays
//! (N. Max, "Optical models for direct volume rendering", IEEE Transactions on Visualization and
//! Computer Graphics 1, 1995).

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use anyhow::{Result, bail};
use catamaran::base::Progress;
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::vector::Vector;

use super::color::{to_light, to_screen};
use super::image::{Image, Rgb};
use super::mesh::View;
use super::mesh::camera::Camera;
use super::mesh::shade::{GLOSS, gloss, lambert};
use super::mesh::{LARGEST, MARGIN, PAPER};

/// Samples along a ray, per voxel.
const SAMPLES: f64 = 2.0;
/// A ray ends when less than this share of the light from behind is visible.
const HIDDEN: f32 = 1e-3;
/// Colour of the edges of the box that are behind the volume, and half their width in pixels.
const EDGE: (Rgb, f64) = ([150, 152, 158], 0.6);

/// Voxels, x running fastest, then y.
pub struct Volume {
    /// Voxels along x, y and z.
    pub counts: [usize; 3],
    /// The lowest corner of the first voxel.
    pub low: Vector,
    /// Sides of a voxel.
    pub step: Vector,
    /// The colour of each voxel.
    pub colors: Vec<Rgb>,
    /// The extinction of each voxel, not negative: the share of light after a distance s through
    /// voxels of this extinction is exp(-extinction s).
    pub extinction: Vec<f32>,
}

/// Draws a volume on paper, lit by the lamps of meshes. The same volume gives the same bytes for
/// any number of threads.
///
/// # Errors
/// The sides of the picture are too long; colours or extinctions do not fit the voxels;
/// `Cancelled`.
pub fn render_volume(
    volume: &Volume,
    view: &View,
    size: (usize, usize),
    threads: usize,
    progress: Progress<'_>,
) -> Result<Image> {
    let (width, height) = size;
    if !(1..=LARGEST).contains(&width) || !(1..=LARGEST).contains(&height) {
        bail!("a picture of {width} x {height} pixels, where sides are from 1 to {LARGEST}");
    }
    let count: usize = volume.counts.iter().product();
    if [volume.colors.len(), volume.extinction.len()] != [count; 2] || count == 0 {
        bail!("colours or extinctions that are not those of {:?} voxels", volume.counts);
    }
    let corners = volume.corners()?;
    let camera = Camera::new(&corners, view, width as f64, height as f64, MARGIN);
    let mut lit = vec![[0.0; 4]; count];
    let layer = volume.counts[0] * volume.counts[1];
    let layers = lit.chunks_mut(layer).collect();
    let light = |k: usize, out: &mut [[f32; 4]]| volume.light_layer(&camera, k, out);
    share_out(threads, layers, light, progress.part(0.0..0.1))?;
    let edges = hidden_edges(&corners, &camera);
    let mut pixels = vec![PAPER; width * height];
    let rows = pixels.chunks_mut(width).collect();
    let draw = |y: usize, row: &mut [Rgb]| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
            let behind = edges.behind(x, y);
            let (from, way) = camera.ray(x, y);
            if let Some(range) = volume.inside(from, way) {
                let seen = volume.march(&lit, from, way, range);
                *pixel = to_screen(
                    [0, 1, 2].map(|c| f64::from(seen[c]) + f64::from(seen[3]) * behind[c]),
                );
            } else {
                *pixel = to_screen(behind);
            }
        }
    };
    share_out(threads, rows, draw, progress.part(0.1..1.0))?;
    Ok(Image::from_pixels(width, pixels))
}

impl Volume {
    fn high(&self) -> Vector {
        std::array::from_fn(|c| self.low[c] + self.counts[c] as f64 * self.step[c])
    }

    /// Returns the box as a mesh: corner b has the high end along those axes whose bits are in b.
    fn corners(&self) -> Result<TriMesh> {
        let ends = [self.low, self.high()];
        let corner = |b: usize| std::array::from_fn(|c| ends[b >> c & 1][c]);
        let sides =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let faces = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Ok(TriMesh::new((0..8).map(corner).collect(), faces)?)
    }

    /// Returns the extinction of a voxel; 0 outside of the volume.
    fn at(&self, place: [usize; 3]) -> f32 {
        let [nx, ny, _] = self.counts;
        // Indices below 0 have wrapped around.
        if (0..3).any(|c| place[c] >= self.counts[c]) {
            return 0.0;
        }
        self.extinction[place[0] + nx * (place[1] + ny * place[2])]
    }

    /// Returns the direction and rate at which the extinction falls, by Sobel's operator, which
    /// smooths across.
    fn slope(&self, place: [usize; 3]) -> Vector {
        let mut slope = [0.0; 3];
        for d in 0..27_usize {
            let way = [d % 3, d / 3 % 3, d / 9];
            let at = std::array::from_fn(|c| place[c].wrapping_add(way[c]).wrapping_sub(1));
            let value = f64::from(self.at(at));
            for c in 0..3 {
                let across = |k: usize| if k == c { 1.0 } else { [1.0, 2.0, 1.0][way[k]] };
                slope[c] += value * [1.0, 0.0, -1.0][way[c]] * across(0) * across(1) * across(2);
            }
        }
        // The weights on each side add up to 16.
        std::array::from_fn(|c| slope[c] / (32.0 * self.step[c]))
    }

    /// Computes the light that each voxel of a layer sends to the viewer, and its extinction.
    fn light_layer(&self, camera: &Camera, k: usize, out: &mut [[f32; 4]]) {
        let [nx, ny, _] = self.counts;
        for (p, out) in out.iter_mut().enumerate() {
            let place = [p % nx, p / nx, k];
            let number = p + nx * ny * k;
            let extinction = self.extinction[number];
            if extinction <= 0.0 {
                continue;
            }
            let slope = self.slope(place);
            let steep = slope.iter().map(|x| x * x).sum::<f64>().sqrt();
            let mut normal = camera.turn(slope.map(|x| if steep > 0.0 { x / steep } else { 0.0 }));
            // Sheets are lit on the side that is seen.
            if normal[2] < 0.0 {
                normal = normal.map(|x| -x);
            }
            // Where nothing changes there is no surface to light.
            let step = self.step.iter().fold(f64::INFINITY, |least, s| s.min(least));
            let surface = (2.0 * step * steep / f64::from(extinction)).min(1.0);
            let factor = surface * lambert(normal) + (1.0 - surface);
            let shine = surface * GLOSS.0 * gloss(normal);
            let light = to_light(self.colors[number]).map(|c| (c * factor + shine) as f32);
            *out =
                [light[0] * extinction, light[1] * extinction, light[2] * extinction, extinction];
        }
    }

    /// Returns the part of a ray that is in the box.
    fn inside(&self, from: Vector, way: Vector) -> Option<[f64; 2]> {
        let (low, high) = (self.low, self.high());
        let mut range = [0.0_f64, f64::INFINITY];
        for c in 0..3 {
            if way[c] == 0.0 {
                if !(low[c]..high[c]).contains(&from[c]) {
                    return None;
                }
                continue;
            }
            let ends = [low, high].map(|end| (end[c] - from[c]) / way[c]);
            range = [range[0].max(ends[0].min(ends[1])), range[1].min(ends[0].max(ends[1]))];
        }
        (range[0] < range[1]).then_some(range)
    }

    /// Returns the light that comes along a ray, and the remaining share of light from behind.
    fn march(&self, lit: &[[f32; 4]], from: Vector, way: Vector, range: [f64; 2]) -> [f32; 4] {
        let step = self.step.iter().fold(f64::INFINITY, |least, s| s.min(least)) / SAMPLES;
        let count = ((range[1] - range[0]) / step).ceil().max(1.0);
        let step = (range[1] - range[0]) / count;
        // In voxels, whose centres are at the integers.
        let place = |s: f64| -> Vector {
            std::array::from_fn(|c| (from[c] + s * way[c] - self.low[c]) / self.step[c] - 0.5)
        };
        let first = place(range[0] + 0.5 * step);
        let forward: Vector = std::array::from_fn(|c| step * way[c] / self.step[c]);
        let (mut light, mut left) = ([0.0; 3], 1.0_f32);
        for i in 0..count as usize {
            let here = std::array::from_fn(|c| first[c] + i as f64 * forward[c]);
            let [r, g, b, extinction] = self.sample(lit, here);
            if extinction <= 0.0 {
                continue;
            }
            let through = (-extinction * step as f32).exp();
            // The part of the light that this stretch sends, by its mean colour.
            let sent = left * (1.0 - through) / extinction;
            light = [light[0] + sent * r, light[1] + sent * g, light[2] + sent * b];
            left *= through;
            if left < HIDDEN {
                left = 0.0;
                break;
            }
        }
        [light[0], light[1], light[2], left]
    }

    /// Interpolates between the eight voxels around; beyond the outermost centres, values are those
    /// at the centres.
    fn sample(&self, lit: &[[f32; 4]], place: Vector) -> [f32; 4] {
        let (mut low, mut share, mut next) = ([0; 3], [0.0; 3], [0; 3]);
        let strides = [1, self.counts[0], self.counts[0] * self.counts[1]];
        for c in 0..3 {
            let most = self.counts[c] - 1;
            let x = place[c].clamp(0.0, most as f64);
            low[c] = (x as usize).min(most);
            share[c] = (x - low[c] as f64) as f32;
            next[c] = if low[c] < most { strides[c] } else { 0 };
        }
        let start = low[0] + strides[1] * low[1] + strides[2] * low[2];
        let mix = |a: [f32; 4], b: [f32; 4], s: f32| -> [f32; 4] {
            std::array::from_fn(|k| a[k] + s * (b[k] - a[k]))
        };
        let row = |at: usize| mix(lit[at], lit[at + next[0]], share[0]);
        let face = |at: usize| mix(row(at), row(at + next[1]), share[1]);
        mix(face(start), face(start + next[2]), share[2])
    }
}

/// Lines on the screen.
struct Edges(Vec<[[f64; 2]; 2]>);

/// Returns the edges of a box that belong to no visible side.
fn hidden_edges(corners: &TriMesh, camera: &Camera) -> Edges {
    let points: Vec<_> = corners.vertices().iter().map(|&p| camera.project(p)).collect();
    let seen = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| points[v as usize]);
        (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 0.0
    };
    let on_seen = |a: u32, b: u32| {
        let of = |face: &&[u32; 3]| face.contains(&a) && face.contains(&b);
        corners.faces().iter().filter(of).any(seen)
    };
    let all = (0..8_u32).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit)));
    let hidden = all.filter(|&(a, b)| a != b && !on_seen(a, b));
    let place = |v: u32| [points[v as usize].x, points[v as usize].y];
    Edges(hidden.map(|(a, b)| [place(a), place(b)]).collect())
}

impl Edges {
    /// Returns the light that comes from behind at a place on the screen.
    fn behind(&self, x: f64, y: f64) -> [f64; 3] {
        let distance = |[a, b]: &[[f64; 2]; 2]| {
            let along = [b[0] - a[0], b[1] - a[1]];
            let to = [x - a[0], y - a[1]];
            let square = along[0] * along[0] + along[1] * along[1];
            let share =
                if square > 0.0 { (to[0] * along[0] + to[1] * along[1]) / square } else { 0.0 };
            let share = share.clamp(0.0, 1.0);
            (to[0] - share * along[0]).hypot(to[1] - share * along[1])
        };
        let nearest = self.0.iter().map(distance).fold(f64::INFINITY, f64::min);
        let cover = (EDGE.1 + 0.5 - nearest).clamp(0.0, 1.0);
        let (paper, ink) = (to_light(PAPER), to_light(EDGE.0));
        std::array::from_fn(|c| paper[c] + cover * (ink[c] - paper[c]))
    }
}

/// Calls `work(i, item)` once for every item, on this number of threads; the calling thread reports
/// progress.
fn share_out<T: Send>(
    threads: usize,
    items: Vec<T>,
    work: impl Fn(usize, T) + Sync,
    progress: Progress<'_>,
) -> catamaran::Result<()> {
    let count = items.len();
    let (items, done, stop) =
        (Mutex::new(items.into_iter().enumerate()), AtomicUsize::new(0), AtomicBool::new(false));
    let next = || {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        items.lock().unwrap_or_else(PoisonError::into_inner).next()
    };
    let serve = |report: &dyn Fn() -> catamaran::Result<()>| {
        while let Some((i, item)) = next() {
            work(i, item);
            done.fetch_add(1, Ordering::Relaxed);
            if let Err(e) = report() {
                stop.store(true, Ordering::Relaxed);
                return Err(e);
            }
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.min(count) {
            let other = || {
                // This thread reports nothing, which can't fail.
                let _ = serve(&|| Ok(()));
            };
            // Fewer threads where the system has no more: slower, but the same.
            let _ = std::thread::Builder::new().spawn_scoped(scope, other);
        }
        serve(&|| progress.report(done.load(Ordering::Relaxed) as f64 / count as f64))
    })?;
    // Other threads may have done all items before this thread reports.
    progress.report(1.0)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::super::mesh::{Projection, Up};
    use super::*;

    const FRONT: View =
        View { azimuth: 0.0, elevation: 0.0, up: Up::Y, projection: Projection::Orthographic };

    /// Returns a cube of side 1 of one colour.
    fn even(n: usize, extinction: f32) -> Volume {
        Volume {
            counts: [n; 3],
            low: [-0.5; 3],
            step: [1.0 / n as f64; 3],
            colors: vec![[200, 40, 40]; n * n * n],
            extinction: vec![extinction; n * n * n],
        }
    }

    fn draw(volume: &Volume, view: &View, size: usize, threads: usize) -> Image {
        render_volume(volume, view, (size, size), threads, Progress::none()).unwrap()
    }

    #[test]
    fn light_fades_exponentially() {
        let volume = even(8, 1.7);
        let lit = vec![[0.2 * 1.7, 0.4 * 1.7, 0.6 * 1.7, 1.7]; 512];
        let way = [0.0, 0.6, 0.8];
        let from = [0.1, -0.5, -0.5];
        let range = volume.inside(from, way).unwrap();
        assert!((range[0]).abs() < 1e-12 && (range[1] - 1.25).abs() < 1e-12, "{range:?}");
        let [r, g, b, left] = volume.march(&lit, from, way, range);
        let expected = (-1.7 * 1.25_f32).exp();
        assert!((left - expected).abs() < 1e-6, "{left}");
        for (found, color) in [(r, 0.2), (g, 0.4), (b, 0.6)] {
            assert!((found - color * (1.0 - expected)).abs() < 1e-6);
        }
        assert_eq!(volume.inside([2.0, 0.0, -5.0], [0.0, 0.0, 1.0]), None);
    }

    #[test]
    fn nothing_is_paper_and_much_is_opaque() {
        let view = View { azimuth: 20.0, elevation: 25.0, ..FRONT };
        let mut empty = draw(&even(4, 0.0), &view, 60, 1);
        assert_eq!(*empty.pixel(1, 1).unwrap(), PAPER);
        let mut full = draw(&even(4, 1e4), &view, 60, 1);
        let [r, g, b] = *full.pixel(30, 30).unwrap();
        assert!(r > 2 * g && g.abs_diff(b) < 3, "{r} {g} {b}");
        assert_eq!(*full.pixel(1, 1).unwrap(), PAPER);
    }

    #[test]
    fn what_is_in_front_hides_what_is_behind() {
        // Blue for large z, which is where the viewer is.
        let mut volume = even(6, 500.0);
        for (i, color) in volume.colors.iter_mut().enumerate() {
            *color = if i / 36 >= 3 { [40, 40, 200] } else { [200, 40, 40] };
        }
        let mut front = draw(&volume, &FRONT, 40, 2);
        let [r, _, b] = *front.pixel(20, 20).unwrap();
        assert!(b > 2 * r);
        let mut back = draw(&volume, &View { azimuth: 180.0, ..FRONT }, 40, 2);
        let [r, _, b] = *back.pixel(20, 20).unwrap();
        assert!(r > 2 * b);
    }

    #[test]
    fn rays_go_through_what_they_are_seen_at() {
        let volume = even(4, 1.0);
        let corners = volume.corners().unwrap();
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for up in [Up::X, Up::Y, Up::Z] {
                let view = View { azimuth: 37.0, elevation: -21.0, up, projection };
                let camera = Camera::new(&corners, &view, 300.0, 200.0, MARGIN);
                for p in [[0.3, -0.2, 0.4], [0.0; 3], [-0.5, 0.5, 0.1]] {
                    let seen = camera.project(p);
                    let (from, way) = camera.ray(seen.x, seen.y);
                    let to: Vector = std::array::from_fn(|c| p[c] - from[c]);
                    let along: f64 = (0..3).map(|c| to[c] * way[c]).sum();
                    let off = (0..3).map(|c| (to[c] - along * way[c]).powi(2)).sum::<f64>().sqrt();
                    assert!(off < 1e-9 && along > 0.0, "{off} {along}");
                }
            }
        }
    }

    #[test]
    fn threads_change_nothing_and_a_callback_stops() {
        let mut volume = even(12, 0.0);
        for (i, extinction) in volume.extinction.iter_mut().enumerate() {
            *extinction = (i * 7919 % 23) as f32;
        }
        let view = View { azimuth: 30.0, elevation: 15.0, ..View::DEFAULT };
        let one = draw(&volume, &view, 50, 1);
        assert_eq!(draw(&volume, &view, 50, 3), one);
        assert_eq!(draw(&volume, &view, 50, 64), one);
        for limit in [0.05, 0.5] {
            let stop = |fraction: f64| match fraction > limit {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            let stopped = render_volume(&volume, &view, (50, 50), 3, Progress::new(&stop));
            let error = stopped.unwrap_err().downcast::<catamaran::Error>().unwrap();
            assert_eq!(error, catamaran::Error::Cancelled);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut volume = even(2, 1.0);
        let run = |volume: &Volume, size| {
            render_volume(volume, &FRONT, size, 1, Progress::none()).unwrap_err().to_string()
        };
        assert!(run(&volume, (0, 5)).contains("sides are from 1"));
        volume.colors.pop();
        assert!(run(&volume, (5, 5)).contains("not those of [2, 2, 2] voxels"));
    }
}
