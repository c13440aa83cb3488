//! Cuts a surface open along curves, and selects the regions that they enclose.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::faer::MatRef;
use catamaran::io::{self as tables, Output};
use catamaran_geometry::curve::{Curve, Drawn, Region, Side, cut};
use catamaran_geometry::mesh::io::{MeshFile, MeshFormat, check_name};
use catamaran_geometry::mesh::{Components, Part, Refined};
use clap::ValueEnum;

use super::samples::{Group, side};
use crate::common::Force;
use crate::folder::{Folder, note_older};
use crate::output;
use crate::report::{note, report, status};

/// The beginning of the names of pieces, before their number.
const PIECE: &str = "piece-";

/// The colours of a region and of its surroundings, from 0 to 1.
pub const INSIDE: [f64; 3] = [0.96, 0.68, 0.25];
pub const OUTSIDE: [f64; 3] = [0.80, 0.84, 0.88];

/// The outputs of the surface.
#[derive(clap::Args)]
pub struct SurfaceArgs {
    /// Write the mesh cut open along the curves: to a mesh, or to a folder (an existing one, or a
    /// name that ends in /), which gets a file for each piece; piece-1 is the largest.
    #[arg(long, value_name = "MESH|DIR/")]
    cut: Option<PathBuf>,
    /// Write the region that the curves enclose: as a mesh, or as a table (.npy, .csv, ...) with
    /// the share of each face of MESH that is inside, from 0 to 1. May be given several times.
    #[arg(long, value_name = "FILE")]
    region: Vec<PathBuf>,
    /// Write everything but the region, in the same formats. May be given several times.
    #[arg(long, value_name = "FILE")]
    rest: Vec<PathBuf>,
    /// Write the whole mesh with the region in a distinct colour: .ply, or another format with
    /// colours.
    #[arg(long, value_name = "MESH")]
    paint: Option<PathBuf>,
    /// Side of a curve that is inside, unless the line of the curve in the file of samples sets it:
    /// small or large, by area, or seed:V, the piece with vertex V, numbered from 0 (seed:V,W for
    /// several pieces).
    #[arg(long, value_name = "SIDE", value_parser = side, default_value = "small")]
    side: Side,
    /// How the regions of several curves are combined, in the order of the file.
    #[arg(long, value_name = "HOW", default_value = "union")]
    combine: Combine,
}

/// How two regions are combined.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Combine {
    /// The area in any of the regions.
    Union,
    /// The area in all of the regions.
    Intersection,
    /// The area in the first region and in none of the others.
    Difference,
    /// The area in an odd number of the regions.
    Xor,
}

/// Output files that are begun.
pub struct Outputs {
    cut: Option<Output>,
    region: Vec<Output>,
    rest: Vec<Output>,
    paint: Option<Output>,
    /// The folder of pieces. Dropped after the files.
    _pieces: Option<Folder>,
}

impl SurfaceArgs {
    /// Returns whether there is an output of the surface.
    pub fn any(&self) -> bool {
        self.cut.is_some() || self.wants_region()
    }

    /// Returns whether there is an output of the region.
    pub fn wants_region(&self) -> bool {
        !self.region.is_empty() || !self.rest.is_empty() || self.paint.is_some()
    }

    /// Refuses options and names that do not fit, and begins the files.
    pub fn create(&self, force: Force) -> Result<Outputs> {
        if !self.wants_region() && (self.side != Side::Small || self.combine != Combine::Union) {
            bail!("--side and --combine need a region: --region, --rest or --paint");
        }
        for path in self.cut.iter().filter(|path| !is_folder(path)).chain(&self.paint) {
            check_name(path)?;
        }
        for path in self.region.iter().chain(&self.rest) {
            if MeshFormat::of(path).is_err() && tables::check_name(path).is_err() {
                bail!(
                    "{}: the name must end in that of a mesh (.ply, ...) or a table (.npy, ...)",
                    path.display()
                );
            }
        }
        let create = |path: &PathBuf| force.create(path);
        let (folder, whole) = match &self.cut {
            Some(path) if is_folder(path) => (Some(path), None),
            path => (None, path.as_ref()),
        };
        Ok(Outputs {
            cut: whole.map(create).transpose()?,
            region: self.region.iter().map(create).collect::<Result<_>>()?,
            rest: self.rest.iter().map(create).collect::<Result<_>>()?,
            paint: self.paint.as_ref().map(create).transpose()?,
            _pieces: folder.map(|path| Folder::create(path, "piece-1.ply")).transpose()?,
        })
    }

    /// Refuses to replace the first piece of the mesh in `source`, unless `force` allows that.
    pub fn check_pieces(&self, source: &MeshFile, force: Force) -> Result<()> {
        match &self.cut {
            Some(folder) if is_folder(folder) => force.check(&folder.join(piece(1, source))),
            _ => Ok(()),
        }
    }

    /// Cuts the mesh, writes all files, and returns the region if there is one.
    ///
    /// - `source`: the file of MESH, which `drawn` refines;
    /// - `groups`: the groups of samples, one for each layer of `drawn`.
    pub fn write(
        &self,
        outputs: Outputs,
        source: &MeshFile,
        drawn: &Drawn,
        groups: &[Group],
        force: Force,
    ) -> Result<Option<Region>> {
        let file = source.refined(&drawn.refined)?;
        let along = walls(&drawn.layers.concat());
        let open = cut(&file.mesh, &along)?;
        let open_file = file.part(open.clone())?;
        // Before anything is written.
        let region = self.wants_region().then(|| self.combined(drawn, groups)).transpose()?;
        if self.cut.is_some() {
            let (edges, faces) = (along.len(), open.mesh.faces().len());
            let pieces = Components::new(&open.mesh).len();
            report!(
                "cut",
                edges = edges,
                components = pieces,
                faces = faces;
                "{edges} edges, {pieces} components, {faces} faces"
            )?;
        }
        match (&self.cut, outputs.cut) {
            (Some(folder), None) => write_pieces(folder, &open_file, source, force)?,
            (_, Some(output)) => write_mesh(output, &open_file)?,
            (None, None) => {}
        }
        let Some(region) = region else { return Ok(None) };
        let (area, whole) = (region.area(&file.mesh)?, file.mesh.area());
        let (faces, percent) = (region.faces().len(), 100.0 * area / whole);
        report!(
            "region",
            faces = faces,
            area = area,
            percent = percent;
            "{faces} faces, area {area}, {percent:.2} % of the surface"
        )?;
        if region.is_empty() {
            note(format_args!("the region is empty"));
        }
        for output in outputs.region {
            write_region(output, &file, &drawn.refined, &region)?;
        }
        for output in outputs.rest {
            write_region(output, &file, &drawn.refined, &region.complement())?;
        }
        if let Some(output) = outputs.paint {
            let colors = paint(&open, &region);
            let mut painted = open_file;
            painted.colors = Some(colors.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect());
            write_mesh(output, &painted)?;
        }
        Ok(Some(region))
    }

    /// Combines the regions of all groups.
    fn combined(&self, drawn: &Drawn, groups: &[Group]) -> Result<Region> {
        let mut all: Option<Region> = None;
        for (group, layer) in groups.iter().zip(&drawn.layers) {
            let side = group.side.as_ref().unwrap_or(&self.side);
            let own = Region::enclosed(&drawn.refined.mesh, &walls(layer), side);
            let own = match &group.name {
                Some(name) => own.with_context(|| format!("curve {name}"))?,
                None => own?,
            };
            all = Some(match all {
                None => own,
                Some(all) => match self.combine {
                    Combine::Union => all.union(&own)?,
                    Combine::Intersection => all.intersection(&own)?,
                    Combine::Difference => all.difference(&own)?,
                    Combine::Xor => all.symmetric_difference(&own)?,
                },
            });
        }
        all.context("no curves")
    }
}

/// Returns the colours of the vertices of a cut mesh, by region and surroundings.
pub fn paint(open: &Part, region: &Region) -> Vec<[f64; 3]> {
    let mut colors = vec![OUTSIDE; open.mesh.vertices().len()];
    for f in region.faces() {
        for v in open.mesh.faces()[f as usize] {
            colors[v as usize] = INSIDE;
        }
    }
    colors
}

/// Returns the edges of curves.
pub fn walls(curves: &[Curve]) -> Vec<[u32; 2]> {
    let mut all: Vec<[u32; 2]> = curves.iter().flat_map(Curve::edges).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.as_os_str().to_string_lossy().ends_with(['/', '\\'])
}

/// Returns the name of a piece of a mesh.
fn piece(number: usize, source: &MeshFile) -> String {
    // Texture coordinates and materials need .obj.
    let rich = source.uv.is_some() || source.materials.is_some();
    format!("{PIECE}{number}.{}", if rich { "obj" } else { "ply" })
}

/// Writes a file for each component, the largest first.
fn write_pieces(folder: &Path, open: &MeshFile, source: &MeshFile, force: Force) -> Result<()> {
    let components = Components::new(&open.mesh);
    let mut pieces = Vec::new();
    for i in 0..components.len() {
        let piece = open.part(open.mesh.component(&components, i)?)?;
        pieces.push((piece.mesh.area(), piece));
    }
    pieces.sort_by(|a, b| b.0.total_cmp(&a.0));
    let names: Vec<String> = (1..=pieces.len()).map(|i| piece(i, source)).collect();
    let is_mesh = |end: &str| [".obj", ".ply"].contains(&end);
    note_older(folder, "pieces", PIECE, is_mesh, &names);
    let create = |name: &String| force.create(&folder.join(name));
    let outputs: Result<Vec<Output>> = names.iter().map(create).collect();
    for (output, (area, piece)) in outputs?.into_iter().zip(&pieces) {
        let (path, faces) = (output.path().display().to_string(), piece.mesh.faces().len());
        report!(
            "piece",
            path = path,
            faces = faces,
            area = area;
            "{path}: {faces} faces, area {area}"
        )?;
        output::mesh(output, piece)?;
    }
    Ok(())
}

fn write_region(output: Output, file: &MeshFile, refined: &Refined, region: &Region) -> Result<()> {
    if MeshFormat::of(output.path()).is_ok() {
        return write_mesh(output, &file.part(region.part(&file.mesh)?)?);
    }
    let path = output.path().display().to_string();
    let shares = refined.shares(region.mask())?;
    tables::write(output, MatRef::from_column_major_slice(&shares, shares.len(), 1))?;
    status!("written", path = path; "{path}")
}

fn write_mesh(output: Output, file: &MeshFile) -> Result<()> {
    let path = output.path().display().to_string();
    output::mesh(output, file)?;
    status!("written", path = path; "{path}")
}
