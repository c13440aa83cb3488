//! The defaults of options in help texts, taken from where the defaults are.

use std::fmt::{self, Display};

use clap::ValueEnum;

/// Returns the help text of an option that is `None` where it is not given, with the default that
/// then holds.
pub fn stated(text: &str, default: impl Display) -> String {
    format!("{text} [default: {default}]")
}

/// Returns the value of an option that stands for a default of the library.
pub fn variant<V: ValueEnum + Into<L>, L: PartialEq>(default: L) -> V {
    let stands = |value: &&V| -> bool {
        let value: L = V::clone(value).into();
        value == default
    };
    let found = V::value_variants().iter().find(stands);
    found.expect("an option has a value for the default of the library").clone()
}

/// Numbers separated by commas, for options of several numbers that have a default.
#[derive(Debug, Clone, Copy)]
pub struct Numbers<const N: usize>(pub [f64; N]);

impl<const N: usize> Display for Numbers<N> {
    /// Writes each number with or without an exponent, whichever is shorter.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let short = |x: f64| {
            let (plain, scientific) = (format!("{x}"), format!("{x:e}"));
            if scientific.len() < plain.len() { scientific } else { plain }
        };
        f.write_str(&self.0.map(short).join(","))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The options whose defaults are typed: no option of a library stands behind them.
    const TYPED: [&str; 45] = [
        "ata/mod.rs block_rows",
        "ata/mod.rs memory",
        // The command line computes both triangles, the library the lower one.
        "ata/mod.rs uplo",
        "basis.rs k",
        "basis.rs order",
        "common.rs threads",
        "curve/surface.rs combine",
        "curve/surface.rs side",
        // `None` in the library.
        "decimate.rs first",
        "demo/mod.rs output",
        "device.rs device",
        "distance.rs method",
        "farthest.rs first",
        "filter.rs k",
        "filter.rs order",
        "gram/mod.rs block_rows",
        "main.rs input_limit",
        "merge.rs uplo",
        "newton/mod.rs basins",
        "newton/mod.rs extent",
        "newton/mod.rs inlay",
        "newton/mod.rs opacity",
        // `Components::All` in the library.
        "pca.rs k",
        "picture/args.rs up",
        "predict.rs confidence",
        "rows/checkpoint.rs checkpoint_every",
        "shapedna.rs nearest",
        "slime/mod.rs every",
        "slime/mod.rs steps",
        "slime/mod.rs up",
        "transfer.rs k",
        "transfer.rs order",
        "transfer.rs refine",
        "transfer.rs target_k",
        "tune.rs isa",
        "unions/dataset.rs size",
        "unions/interpolate.rs steps",
        "unions/parts.rs weights",
        "unions/shape.rs k",
        "unions/train.rs architecture",
        "unions/tune.rs weights",
        "wilt/args.rs frames",
        "wilt/args.rs hours",
        "wilt/args.rs mesh",
        // `None` in the library.
        "wilt/args.rs wind",
    ];

    /// Returns the options of a source file whose defaults are typed, in the help or as a literal.
    fn typed(text: &str) -> Vec<&str> {
        let starts = |c: char| c.is_ascii_digit() || "\"[-".contains(c);
        let (mut found, mut is_typed) = (Vec::new(), false);
        for line in text.lines().map(str::trim) {
            let value =
                line.split_once("default_value").and_then(|(_, rest)| rest.split_once(" = "));
            is_typed |= line.contains("[default:");
            is_typed |= value.is_some_and(|(_, value)| value.starts_with(starts));
            let Some(field) = line.strip_suffix(',').and_then(|line| line.split_once(": ")) else {
                continue;
            };
            let name = field.0.trim_start_matches("pub ");
            if name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_') {
                if is_typed {
                    found.push(name);
                }
                is_typed = false;
            }
        }
        found
    }

    fn collect(folder: &Path, name: &str, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            let file = path.file_name().expect("a name").to_string_lossy();
            let name = format!("{name}{file}");
            if path.is_dir() {
                collect(&path, &format!("{name}/"), found);
            } else if name.ends_with(".rs") && name != "defaults.rs" {
                let text = std::fs::read_to_string(&path).expect("a source file");
                found.extend(typed(&text).into_iter().map(|field| format!("{name} {field}")));
            }
        }
    }

    #[test]
    fn defaults_are_typed_only_for_options_that_no_library_has() {
        let mut found = Vec::new();
        collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "", &mut found);
        found.sort();
        assert_eq!(found, TYPED);
    }

    #[test]
    fn typed_defaults_are_found() {
        let text = r#"
            /// Number of passes [default:
            /// 12].
            #[arg(long)]
            passes: Option<usize>,
            #[arg(
                long,
                default_values_t = [2, 2],
            )]
            pub layers: Vec<usize>,
            #[arg(long, default_value = "auto", value_name = "SCHEME")]
            scheme: Scheme,
            #[arg(long, help = stated("Number of passes", Options::default().passes))]
            stated: Option<usize>,
            #[arg(long, default_value_t = Options::default().k)]
            k: usize,
            #[arg(long, default_missing_value = "0")]
            weld: Option<Weld>,
        "#;
        assert_eq!(typed(text), ["passes", "layers", "scheme"]);
    }

    #[test]
    fn numbers_are_written_in_the_shorter_form() {
        assert_eq!(Numbers([0.0, -2.5, 5e7]).to_string(), "0,-2.5,5e7");
        assert_eq!(Numbers([1e-9]).to_string(), "1e-9");
    }
}
