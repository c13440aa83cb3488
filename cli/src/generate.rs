//! `catamaran generate`.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use catamaran_geometry::mesh::families;
use catamaran_geometry::mesh::io as meshes;
use clap::builder::{PossibleValue, PossibleValuesParser};

use crate::common::Force;
use crate::output;
use crate::parse;
use crate::report::status;

/// The shapes, with the names of their counts and of their sizes.
const SHAPES: [(&str, &str, &str); 9] = [
    ("icosphere", "SUBDIVISIONS", ""),
    ("torus", "AROUND TUBE", "MAJOR MINOR"),
    ("knot", "P Q ALONG TUBE", "RADIUS"),
    ("genus", "HOLES CELLS", ""),
    ("figure", "CELLS", "POSE"),
    ("grid", "COLUMNS ROWS", ""),
    ("disk", "RINGS SECTORS", ""),
    ("cylinder", "AROUND ALONG", "RADIUS HEIGHT"),
    ("terrain", "COLUMNS ROWS SEED", ""),
];

/// Counts above this are not exact as numbers of f64.
const LARGEST: f64 = 9_007_199_254_740_992.0;

/// Generate a triangle mesh: a sphere, a torus, a human figure, hills and others.
///
/// AROUND, TUBE and ALONG of a knot are numbers of vertices of a closed ring; ALONG of a cylinder
/// is the number of rings of cells. COLUMNS and ROWS are numbers of cells, of two triangles each.
/// CELLS is the number of cells along a side of the blocks of which a shape is made, RINGS and
/// SECTORS are those of a fan around its centre. SUBDIVISIONS is how often each face of an
/// icosahedron is cut into four. P and Q are the turns of a knot around its axis and through its
/// hole. POSE bends the limbs, from 0 to 1.
#[derive(clap::Args)]
pub struct Args {
    /// Name of the shape.
    #[arg(value_name = "SHAPE", value_parser = shapes())]
    shape: String,
    /// Numbers of the shape, in the order of their names.
    #[arg(
        value_name = "NUMBER",
        allow_negative_numbers = true,
        value_parser = parse::finite
    )]
    numbers: Vec<f64>,
    #[arg(short, long, value_name = "FILE", help = output::mesh_help("Output file of the mesh"))]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

/// Parses the name of a shape, whose help names the numbers.
fn shapes() -> PossibleValuesParser {
    let value = |(name, counts, sizes): (&'static str, &str, &str)| {
        PossibleValue::new(name).help(format!("{counts} {sizes}").trim_end().to_owned())
    };
    PossibleValuesParser::new(SHAPES.map(value))
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let Args { shape, numbers, .. } = args;
    let found = SHAPES.into_iter().find(|(name, ..)| name == shape);
    let (name, counts, sizes) = found.context("the parser accepts shapes of the list only")?;
    let needed: Vec<&str> = counts.split(' ').chain(sizes.split_whitespace()).collect();
    if numbers.len() != needed.len() {
        bail!("{name}: needs {}, and {} numbers are given", needed.join(" "), numbers.len());
    }
    let (counts, sizes) = numbers.split_at(counts.split(' ').count());
    let whole = |(i, &x): (usize, &f64)| match x.fract() == 0.0 && (0.0..=LARGEST).contains(&x) {
        true => Ok(x as usize),
        false => bail!("{name}: {} must be a whole number of at least 0, is {x}", needed[i]),
    };
    let counts = counts.iter().enumerate().map(whole).collect::<Result<Vec<_>>>()?;
    meshes::check_name(&args.output)?;
    let output = args.force.create(&args.output)?;
    let mesh = families::by_name(name, &counts, sizes).context(name)?;
    let path = output.path().display().to_string();
    let (vertices, faces) = (mesh.vertices().len(), mesh.faces().len());
    output::mesh(output, &mesh.into())?;
    status!(
        "written",
        path = path,
        vertices = vertices,
        faces = faces;
        "{path}: {vertices} vertices, {faces} faces"
    )
}
