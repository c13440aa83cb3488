//! The defaults of the library, as `Debug` prints them.

use std::fmt::Debug;
use std::path::Path;

use catamaran::AtaOptions;
use catamaran::ortho::GramSchmidtOptions;
use catamaran::solve::{LeastSquaresOptions, PrincipalComponentsOptions};
use catamaran::sparse::{CholeskyOptions, EigenOptions};
use catamaran_geometry::curve::CurveOptions;
use catamaran_geometry::decimate::DecimateOptions;
use catamaran_geometry::mesh::{CloudOptions, HeatOptions, LaplacianOptions, RepairOptions};
use catamaran_geometry::spectral::{ProductBasisOptions, ShapeOptions};
use catamaran_geometry::unions::{MetricOptions, ShapeDnaOptions};
use catamaran_simulation::plant::families::GrowthOptions;
use catamaran_simulation::plant::{
    Elasticity, MotionOptions, RelaxOptions, RodOptions, Stomata, SwayOptions, WaterOptions, Wind,
};
use catamaran_simulation::texture::{newton::NewtonOptions, slime};

use super::Defaults;

/// Fields that are compared under another name, or that no face has a default of: threads,
/// progress, options within options, what must be given.
const OTHERS: [&str; 14] = [
    "par",
    "progress",
    "laplacian",
    "elasticity",
    "motion",
    "rods",
    "water",
    "stomata",
    "soil",
    "wind",
    "cycle",
    "rewatering",
    "nights",
    "classes",
];

/// Structs with setters that are not compared: those whose options must be given or are those of
/// other structs, and looks. `Options` are those of slime moulds, here `SlimeOptions`.
const EXEMPT: [&str; 15] = [
    "Finish",
    "Inlay",
    "Look",
    "Material",
    "ReadOptions",
    "RingOptions",
    "RowOptions",
    "ShotOptions",
    "Soil",
    "SourceOptions",
    "TableOptions",
    "WiltOptions",
    "FitOptions",
    "LeafOptions",
    "Options",
];

/// The name and the default of each struct.
fn all() -> Vec<(&'static str, String)> {
    fn of<T: Default + Debug>(name: &'static str) -> (&'static str, String) {
        (name, format!("{:?}", T::default()))
    }
    vec![
        of::<AtaOptions<'_>>("AtaOptions"),
        of::<LeastSquaresOptions>("LeastSquaresOptions"),
        of::<PrincipalComponentsOptions>("PrincipalComponentsOptions"),
        of::<GramSchmidtOptions<'_>>("GramSchmidtOptions"),
        of::<CholeskyOptions<'_>>("CholeskyOptions"),
        of::<EigenOptions<'_>>("EigenOptions"),
        of::<LaplacianOptions>("LaplacianOptions"),
        of::<HeatOptions>("HeatOptions"),
        of::<CloudOptions>("CloudOptions"),
        of::<RepairOptions>("RepairOptions"),
        of::<ProductBasisOptions<'_>>("ProductBasisOptions"),
        of::<ShapeDnaOptions<'_>>("ShapeDnaOptions"),
        of::<MetricOptions>("MetricOptions"),
        of::<ShapeOptions<'_>>("ShapeOptions"),
        of::<DecimateOptions<'_>>("DecimateOptions"),
        of::<CurveOptions<'_>>("CurveOptions"),
        of::<WaterOptions>("WaterOptions"),
        of::<Elasticity>("Elasticity"),
        of::<RodOptions>("RodOptions"),
        of::<RelaxOptions<'_>>("RelaxOptions"),
        of::<MotionOptions>("MotionOptions"),
        of::<GrowthOptions>("GrowthOptions"),
        of::<Stomata>("Stomata"),
        of::<Wind>("Wind"),
        of::<SwayOptions<'_>>("SwayOptions"),
        of::<slime::Options>("SlimeOptions"),
        of::<NewtonOptions>("NewtonOptions"),
    ]
}

/// STRUCT.FIELD and its default, for all structs.
pub fn defaults() -> Defaults {
    let mut found = Defaults::new();
    for (name, printed) in all() {
        add(&mut found, name, &printed);
    }
    found
}

/// Adds the fields of a printed struct, and those of structs within.
fn add(found: &mut Defaults, name: &str, printed: &str) {
    let (_, body) = printed.split_once('{').expect("a struct with fields");
    for field in split(body.trim_end().trim_end_matches('}')) {
        let (field, value) = field.split_once(':').expect("a name and a value");
        if OTHERS.contains(&field.trim()) {
            continue;
        }
        let name = format!("{name}.{}", field.trim());
        match value.contains('{') {
            true => add(found, &name, value),
            false => drop(found.insert(name, value.trim().to_owned())),
        }
    }
}

/// Splits at the commas that are in no brackets; empty parts are left out.
pub fn split(text: &str) -> Vec<&str> {
    let mut depth = 0;
    let at_comma = |c: char| {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        c == ',' && depth == 0
    };
    text.split(at_comma).map(str::trim).filter(|part| !part.is_empty()).collect()
}

/// The structs that are compared or exempt.
pub fn structs() -> Vec<&'static str> {
    all().into_iter().map(|(name, _)| name).chain(EXEMPT).collect()
}

/// The structs that the sources declare with the macro `options!`, and those of `builder!`.
pub fn declared() -> [Vec<String>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for folder in ["../src", "../geometry/src", "../simulation/src"] {
        collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut found);
    }
    found
}

fn collect(folder: &Path, found: &mut [Vec<String>; 2]) {
    for entry in std::fs::read_dir(folder).expect("a folder of src") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let text = std::fs::read_to_string(&path).expect("a source file");
            let marks = [("\noptions! {", "pub struct "), ("\nbuilder! {", "")];
            for (found, (start, before)) in found.iter_mut().zip(marks) {
                let blocks = text.split(start).skip(1);
                let names = blocks.filter_map(|block| block.split_once(before)).map(|(_, name)| {
                    name.trim_start().split(|c: char| !c.is_alphanumeric()).next()
                });
                found.extend(names.flatten().map(str::to_owned));
            }
        }
    }
}

/// The structs in the lists of options of the crates.
pub fn listed() -> Vec<&'static str> {
    let crates = [catamaran::OPTIONS, catamaran_geometry::OPTIONS, catamaran_simulation::OPTIONS];
    let paths = crates.into_iter().flatten().map(|(path, _)| *path);
    paths.map(|path| path.rsplit("::").next().unwrap_or(path)).collect()
}
