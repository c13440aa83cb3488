use std::path::{Path, PathBuf};

use anyhow::Result;
use catamaran::io::Output;
use catamaran_geometry::mesh::TriMesh;

use super::color::ColorScale;
use super::format::create;
use super::image::Image;
use super::mesh::up::guess;
use super::mesh::{Paint, Panel, Scene, Up, View, render};
use crate::common::Force;
use crate::defaults::stated;
use crate::report::status;

/// The options of the picture that a subcommand draws.
#[derive(clap::Args)]
pub struct PictureArgs {
    /// Draw the result to this .png or .svg file.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[arg(
        long,
        value_name = "AROUND,ABOVE",
        requires = "picture",
        allow_hyphen_values = true,
        help = stated(
            "Viewpoint of the picture: degrees around the upward axis and degrees above the \
             horizon, then ,flat for no perspective",
            format_args!("{},{}", View::DEFAULT.azimuth, View::DEFAULT.elevation)
        )
    )]
    view: Option<View>,
    /// Axis that points up in the picture [default: that of the normals for a height field such as
    /// a terrain, otherwise z for .stl, and y for all other files].
    #[arg(long, value_name = "AXIS", requires = "picture")]
    up: Option<Up>,
}

/// The panels of a picture: meshes side by side, the paint of each, and its title.
type Panels<'a> = [(&'a TriMesh, Paint<'a>, &'a str)];

impl PictureArgs {
    /// Begins the picture, if one is requested.
    pub fn create(&self, force: Force) -> Result<Option<Output>> {
        self.picture.as_deref().map(|path| create(path, force)).transpose()
    }

    /// Draws meshes side by side, all from the same viewpoint. Without --up, the first mesh and the
    /// name of its file, `source`, determine the upward axis.
    pub fn draw(&self, output: Output, source: &Path, panels: &Panels<'_>) -> Result<()> {
        self.draw_as(output, source, panels, Scene::default())
    }

    /// Draws values from 0 to 1 on that scale, whatever their range; otherwise like
    /// [`PictureArgs::draw`].
    pub fn draw_shares(&self, output: Output, source: &Path, panels: &Panels<'_>) -> Result<()> {
        let scale = Some(ColorScale::of([0.0, 1.0].into_iter()));
        self.draw_as(output, source, panels, Scene { scale, ..Scene::default() })
    }

    /// Draws flat faces and their edges; otherwise like [`PictureArgs::draw`].
    pub fn draw_faces(&self, output: Output, source: &Path, panels: &Panels<'_>) -> Result<()> {
        let scene = Scene { edges: true, smooth: false, ..Scene::default() };
        self.draw_as(output, source, panels, scene)
    }

    /// Returns the name of the picture, if one is requested.
    pub fn path(&self) -> Option<&Path> {
        self.picture.as_deref()
    }

    /// Returns the viewpoint, with --up or else `up` as the upward axis.
    pub fn view(&self, up: Up) -> View {
        View { up: self.up.unwrap_or(up), ..self.view.unwrap_or_default() }
    }

    /// Returns the image that [`PictureArgs::draw`] writes.
    pub fn image(&self, source: &Path, panels: &Panels<'_>, scene: Scene<'_>) -> Result<Image> {
        let view = self.view(panels.first().map_or(Up::Y, |(mesh, ..)| guess(mesh, source)));
        let panels =
            panels.iter().map(|&(mesh, paint, title)| Panel { mesh, paint, view, title }).collect();
        render(&Scene { panels, ..scene })
    }

    fn draw_as(
        &self,
        output: Output,
        source: &Path,
        panels: &Panels<'_>,
        scene: Scene<'_>,
    ) -> Result<()> {
        let path = output.path().display().to_string();
        self.image(source, panels, scene)?.write(output)?;
        status!("picture", path = path; "{path}")
    }
}
