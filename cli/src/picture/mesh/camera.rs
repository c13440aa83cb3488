use std::str::FromStr;

use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::vector::{Vector, norm, sub};

/// Half the angle that a perspective view opens to, in radians.
const HALF_ANGLE: f64 = 0.22;

/// Which coordinate points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Up {
    /// The axis x.
    X,
    /// The axis y, as in most models.
    Y,
    /// The axis z, as in maps and in files for 3D printing.
    Z,
}

/// How distant parts are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// Distant parts are smaller.
    Perspective,
    /// Distant parts have the same size as near ones.
    Orthographic,
}

/// The viewpoint of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Degrees around the upward axis. With y up, 0 looks from z and 90 from x; with z up, from -y
    /// and from x; with x up, from y and from z.
    pub azimuth: f64,
    /// Degrees above the horizon, from -90 to 90.
    pub elevation: f64,
    /// Which coordinate points up.
    pub up: Up,
    /// The projection.
    pub projection: Projection,
}

impl View {
    /// From the front, a little from the side and above; y is up.
    pub const DEFAULT: Self =
        Self { azimuth: 30.0, elevation: 15.0, up: Up::Y, projection: Projection::Perspective };
}

impl Default for View {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl FromStr for View {
    type Err = String;

    /// Parses "azimuth,elevation" in degrees, then ",flat" for no perspective; y is up.
    fn from_str(text: &str) -> Result<Self, String> {
        let angle = |part: Option<&str>, most: f64| {
            let angle = part.and_then(|p| p.trim().parse::<f64>().ok());
            angle.filter(|a| a.abs() <= most)
        };
        let mut parts = text.split(',');
        let (azimuth, elevation) = (angle(parts.next(), 360.0), angle(parts.next(), 90.0));
        let projection = match parts.map(str::trim).collect::<Vec<_>>()[..] {
            [] => Some(Projection::Perspective),
            ["flat"] => Some(Projection::Orthographic),
            _ => None,
        };
        match (azimuth, elevation, projection) {
            (Some(azimuth), Some(elevation), Some(projection)) => {
                Ok(Self { azimuth, elevation, up: Up::Y, projection })
            }
            _ => Err("expected AROUND,ABOVE in degrees (up to 360 and 90), then ,flat for no \
                      perspective; --up sets the upward axis"
                .into()),
        }
    }
}

/// The position of a point on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Samples from the left.
    pub x: f64,
    /// Samples from the top.
    pub y: f64,
    /// Larger for nearer points, and linear on the screen over a flat face.
    pub nearness: f64,
    /// The factor of weights of corners for a mean that is linear in space.
    pub weight: f64,
}

/// A view that a mesh just fits into.
#[derive(Debug)]
pub struct Camera {
    /// To the right, up, and towards the viewer.
    axes: [Vector; 3],
    middle: Vector,
    /// Distance of the viewer from the middle, relative to `size`; `None` from infinity.
    distance: Option<f64>,
    /// Radius of a ball around the middle that has the mesh inside.
    size: f64,
    zoom: f64,
    /// The centre of the mesh on the screen, before zooming.
    centre: [f64; 2],
    screen: [f64; 2],
}

impl Camera {
    /// Returns a camera for a screen of width x height samples, with a margin on all sides that is
    /// this share of the shorter one.
    pub fn new(mesh: &TriMesh, view: &View, width: f64, height: f64, margin: f64) -> Self {
        let axes = axes(view);
        // Vertices in no face are not seen.
        let mut seen = vec![false; mesh.vertices().len()];
        for &v in mesh.faces().as_flattened() {
            seen[v as usize] = true;
        }
        let points =
            || mesh.vertices().iter().zip(&seen).filter(|(_, seen)| **seen).map(|(p, _)| *p);
        let middle = middle(points().map(|p| inside(&axes, p)));
        let spread = points().map(|p| norm(sub(inside(&axes, p), middle))).fold(0.0, f64::max);
        let distance = match view.projection {
            Projection::Perspective => Some(1.0 / HALF_ANGLE.sin()),
            Projection::Orthographic => None,
        };
        let size = if spread > 0.0 { spread } else { 1.0 };
        let mut camera =
            Self { axes, middle, distance, size, zoom: 1.0, centre: [0.0; 2], screen: [0.0; 2] };
        let flat = || {
            points().map(|p| {
                let Projected { x, y, .. } = camera.project(p);
                [x, -y, 0.0]
            })
        };
        let bounds = bounds(flat());
        let centre = [0, 1].map(|k| bounds[0][k] / 2.0 + bounds[1][k] / 2.0);
        let border = 2.0 * margin * width.min(height);
        let fits = |k: usize, room: f64| (room - border) / (bounds[1][k] - bounds[0][k]).max(1e-9);
        let zoom = fits(0, width).min(fits(1, height));
        camera.centre = centre;
        camera.zoom = zoom;
        camera.screen = [width, height];
        camera
    }

    /// Projects a point of the mesh to the screen.
    pub fn project(&self, p: Vector) -> Projected {
        let [x, y, z] = sub(inside(&self.axes, p), self.middle).map(|c| c / self.size);
        let weight = self.distance.map_or(1.0, |d| d / (d - z));
        let place = |c: f64, k: usize| self.zoom * (c * weight - self.centre[k]);
        Projected {
            x: self.screen[0] / 2.0 + place(x, 0),
            y: self.screen[1] / 2.0 - place(y, 1),
            nearness: if self.distance.is_some() { weight } else { z },
            weight,
        }
    }

    /// Returns the ray of light that arrives at a place on the screen: a point of the ray on the
    /// viewer's side of the mesh, and the direction, of length 1, away from the viewer.
    pub fn ray(&self, x: f64, y: f64) -> (Vector, Vector) {
        let flat = [x - self.screen[0] / 2.0, self.screen[1] / 2.0 - y];
        let [u, v] = [0, 1].map(|k| flat[k] / self.zoom + self.centre[k]);
        let (from, way) = match self.distance {
            Some(d) => ([0.0, 0.0, d], [u, v, -d]),
            // The mesh is in a ball of radius 1.
            None => ([u, v, 2.0], [0.0, 0.0, -1.0]),
        };
        let length = norm(way);
        let place: Vector = std::array::from_fn(|k| self.middle[k] + self.size * from[k]);
        (self.outside(place), self.outside(way.map(|c| c / length)))
    }

    /// Inverts [`Camera::turn`].
    fn outside(&self, p: Vector) -> Vector {
        std::array::from_fn(|k| (0..3).map(|i| self.axes[i][k] * p[i]).sum())
    }

    /// Returns a direction as the viewer sees it: right, up, near.
    pub fn turn(&self, direction: Vector) -> Vector {
        inside(&self.axes, direction)
    }
}

/// Returns the directions right, up and near.
fn axes(view: &View) -> [Vector; 3] {
    let (sa, ca) = view.azimuth.to_radians().sin_cos();
    let (se, ce) = view.elevation.to_radians().sin_cos();
    let axes = [[ca, 0.0, -sa], [-se * sa, ce, -se * ca], [ce * sa, se, ce * ca]];
    match view.up {
        Up::X => axes.map(|[x, y, z]| [y, z, x]),
        Up::Y => axes,
        Up::Z => axes.map(|[x, y, z]| [x, -z, y]),
    }
}

fn inside(axes: &[Vector; 3], p: Vector) -> Vector {
    axes.map(|a| a[0] * p[0] + a[1] * p[1] + a[2] * p[2])
}

fn bounds(points: impl Iterator<Item = Vector>) -> [Vector; 2] {
    let empty = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let bounds = points.fold(empty, |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    });
    if bounds[0][0] <= bounds[1][0] { bounds } else { [[0.0; 3]; 2] }
}

fn middle(points: impl Iterator<Item = Vector>) -> Vector {
    let [low, high] = bounds(points);
    std::array::from_fn(|k| low[k] / 2.0 + high[k] / 2.0)
}
