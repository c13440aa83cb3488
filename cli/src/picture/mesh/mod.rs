//! Draws coloured meshes, with a rasterizer of our own.

pub mod camera;
mod lamp;
mod legend;
mod raster;
pub(super) mod shade;
mod tangent;
#[cfg(test)]
mod tests;
pub mod up;

use anyhow::{Result, bail};
use catamaran_geometry::mesh::TriMesh;

use super::color::{ColorScale, Lights};
use super::image::{Image, Rgb};
use super::text::{Size, write_text};
use camera::Camera;
pub use camera::{Projection, Up, View};

/// Samples along each side of a pixel.
const SAMPLES: usize = 3;
/// Longest side of a panel, in pixels.
pub(super) const LARGEST: usize = 4096;
/// Margin of a panel, as a share of its shorter side.
pub(super) const MARGIN: f64 = 0.06;
pub(super) const PAPER: Rgb = [255; 3];
const INK: Rgb = [60, 60, 65];

/// The paint of a surface.
#[derive(Debug, Clone, Copy)]
pub enum Paint<'a> {
    /// One colour.
    Plain(Rgb),
    /// A number for each vertex, and the colours of [`Scene::scale`].
    Values(&'a [f64]),
    /// A colour for each vertex.
    Colors(&'a [Rgb]),
    /// A picture that is wrapped around the surface.
    Texture(Texture<'a>),
}

/// A square picture, and the positions of the corners of faces in it.
#[derive(Debug, Clone, Copy)]
pub struct Texture<'a> {
    /// (u, v) of the corners of each face, from 0 to 1.
    pub uv: &'a [[[f64; 2]; 3]],
    /// Texels of a side.
    pub size: usize,
    /// Rows along u, the first at v = 0.
    pub texels: &'a [Rgb],
    /// The material, if the texture has more than colours.
    pub material: Option<Material<'a>>,
}

/// Textures of a material, of as many texels as the colours.
#[derive(Debug, Clone, Copy)]
pub struct Material<'a> {
    /// Normals in the frame of the surface: 0 for -1, 255 for 1.
    pub normals: &'a [[u8; 3]],
    /// 255 for 1.
    pub roughness: &'a [u8],
    /// 255 for 1.
    pub metalness: &'a [u8],
    /// Light that is emitted.
    pub glow: Option<&'a [Rgb]>,
}

impl Texture<'_> {
    /// Returns the light of a point of a face, given by shares of its corners.
    fn light(&self, face: usize, shares: [f64; 3]) -> [f64; 3] {
        self.mixed(face, shares, |t| super::color::to_light(self.texels[t]))
    }

    /// Returns the value of a point of a face, interpolated from the four texels around it.
    fn mixed(&self, face: usize, shares: [f64; 3], value: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        let corners = self.uv[face];
        let at = |axis: usize| {
            let x: f64 = (0..3).map(|k| shares[k] * corners[k][axis]).sum();
            let x = (x * self.size as f64 - 0.5).clamp(0.0, (self.size - 1) as f64);
            let low = x.floor() as usize;
            (low, (low + 1).min(self.size - 1), x - x.floor())
        };
        let ((left, right, s), (below, above, t)) = (at(0), at(1));
        let texel = |i: usize, j: usize| value(j * self.size + i);
        let mix = |a: [f64; 3], b: [f64; 3], s: f64| [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]));
        let row = |j: usize| mix(texel(left, j), texel(right, j), s);
        mix(row(below), row(above), t)
    }
}

/// One mesh in a picture.
#[derive(Debug, Clone, Copy)]
pub struct Panel<'a> {
    /// The mesh.
    pub mesh: &'a TriMesh,
    /// Its colours.
    pub paint: Paint<'a>,
    /// The viewpoint.
    pub view: View,
    /// The title above the mesh; empty for none.
    pub title: &'a str,
}

/// Meshes side by side, each as large as its panel allows.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    /// The panels, from left to right.
    pub panels: Vec<Panel<'a>>,
    /// Width and height of a panel, in pixels.
    pub size: (usize, usize),
    /// The scale of all numbers; `None`, the default, selects one that suits the numbers of all
    /// panels.
    pub scale: Option<ColorScale>,
    /// Whether the scale is drawn, if there are numbers; default true.
    pub legend: bool,
    /// Whether edges of faces are drawn; default false.
    pub edges: bool,
    /// Whether the surface is shaded as a smooth one, not as flat faces; default true.
    pub smooth: bool,
}

impl Default for Scene<'_> {
    fn default() -> Self {
        Self {
            panels: Vec::new(),
            size: (800, 800),
            scale: None,
            legend: true,
            edges: false,
            smooth: true,
        }
    }
}

/// Draws a scene. The same scene gives the same bytes.
pub fn render(scene: &Scene<'_>) -> Result<Image> {
    let (width, height) = scene.size;
    if !(1..=LARGEST).contains(&width) || !(1..=LARGEST).contains(&height) {
        bail!("a picture of {width} x {height} pixels, where sides are from 1 to {LARGEST}");
    }
    for panel in &scene.panels {
        let n = panel.mesh.vertices().len();
        let given = match panel.paint {
            Paint::Plain(_) => n,
            Paint::Values(values) => values.len(),
            Paint::Colors(colors) => colors.len(),
            Paint::Texture(texture) => {
                let (faces, texels) = (panel.mesh.faces().len(), texture.texels.len());
                if texture.uv.len() != faces || texels != texture.size.pow(2) || texels == 0 {
                    bail!("a texture of {texels} texels for a mesh of {faces} faces");
                }
                if let Some(m) = texture.material {
                    let glow = m.glow.map_or(texels, <[Rgb]>::len);
                    let all = [m.normals.len(), m.roughness.len(), m.metalness.len(), glow];
                    if let Some(other) = all.into_iter().find(|&len| len != texels) {
                        bail!("a material of {other} texels with colours of {texels}");
                    }
                }
                n
            }
        };
        if given != n {
            bail!("{given} values or colours for a mesh of {n} vertices");
        }
    }
    let numbers = || {
        scene.panels.iter().filter_map(|p| match p.paint {
            Paint::Values(values) => Some(values),
            Paint::Plain(_) | Paint::Colors(_) | Paint::Texture(_) => None,
        })
    };
    let scale = scene.scale.unwrap_or_else(|| ColorScale::of(numbers().flatten().copied()));
    let legend = scene.legend && numbers().next().is_some();
    let all = width * scene.panels.len() + if legend { legend::WIDTH } else { 0 };
    let mut image = Image::new(all.max(1), height, PAPER);
    let lights = Lights::new(scale);
    for (i, panel) in scene.panels.iter().enumerate() {
        let top = if panel.title.is_empty() { 0 } else { 2 * Size::Large.height() };
        let (left, below) = (i * width, height.saturating_sub(top));
        if below > 0 {
            image.paste(&draw(panel, scene, &lights, width, below), left, top);
        }
        let indent = width.saturating_sub(Size::Large.width(panel.title)) / 2;
        let down = Size::Large.height() / 2;
        write_text(&mut image, panel.title, Size::Large, left + indent, down, INK);
    }
    if legend {
        legend::draw(&mut image, &scale, all - legend::WIDTH);
    }
    Ok(image)
}

/// Draws one panel without its title.
fn draw(
    panel: &Panel<'_>,
    scene: &Scene<'_>,
    lights: &Lights,
    width: usize,
    height: usize,
) -> Image {
    let (w, h) = (width * SAMPLES, height * SAMPLES);
    let camera = Camera::new(panel.mesh, &panel.view, w as f64, h as f64, MARGIN);
    let points: Vec<camera::Projected> =
        panel.mesh.vertices().iter().map(|p| camera.project(*p)).collect();
    let buffer = raster::Buffer::of(w, h, &points, panel.mesh.faces());
    let shader = shade::Shader::new(panel, scene, lights, &camera, &points);
    Image::from_fn(width, height, |x, y| {
        let mut light = [0.0; 3];
        for j in 0..SAMPLES {
            for i in 0..SAMPLES {
                let sample = buffer.at(x * SAMPLES + i, y * SAMPLES + j);
                let seen = sample.map_or([1.0; 3], |hit| shader.light(hit));
                for k in 0..3 {
                    light[k] += seen[k] / (SAMPLES * SAMPLES) as f64;
                }
            }
        }
        super::color::to_screen(light)
    })
}
