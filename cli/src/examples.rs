//! The examples at the end of the help of each command.

use clap::Command;

/// The commands, by their words, and their examples.
const EXAMPLES: [(&str, &[&str]); 35] = [
    (
        "ata",
        &[
            "catamaran ata A.npy -o C.npy --verify",
            "catamaran ata table.csv --covariance -o cov.csv --picture cov.png",
            "catamaran ata A.npy --times B.npy -o AtB.npy",
        ],
    ),
    (
        "ata-merge",
        &[
            "catamaran ata-merge first.sums second.sums -o C.npy",
            "catamaran ata-merge first.sums second.sums --accumulator both.sums",
        ],
    ),
    (
        "lstsq",
        &[
            "catamaran lstsq A.npy b.npy -o x.npz",
            "catamaran lstsq table.csv --by-column y --intercept --confidence 0.95",
            "catamaran lstsq cars.csv --by-column mpg --intercept --covariance -o cars.json",
        ],
    ),
    (
        "predict",
        &[
            "catamaran predict cars.json new.csv -o predicted.csv",
            "catamaran predict cars.json new.csv --interval observation -o predicted.csv",
        ],
    ),
    (
        "pca",
        &[
            "catamaran pca A.npy -k 3 -o pca.npz --scores",
            "catamaran pca table.csv --standardize --variance 0.95 -o pca.npz --picture scree.svg",
        ],
    ),
    ("svd", &["catamaran svd A.npy", "catamaran svd A.npy -o svd.npz --left"]),
    (
        "mesh",
        &[
            "catamaran mesh scan.ply",
            "catamaran mesh scan.ply --repair --fill-holes 30 -o repaired.ply",
            "catamaran mesh repaired.ply --compare scan.ply",
        ],
    ),
    (
        "generate",
        &[
            "catamaran generate torus 60 30 2 0.8 -o torus.ply",
            "catamaran generate figure 4 0.2 -o figure.obj",
        ],
    ),
    (
        "decimate",
        &[
            "catamaran decimate scan.ply -n 500 -o small.ply",
            "catamaran decimate scan.ply --edge-length 0.1 -o even.ply --picture even.png",
        ],
    ),
    (
        "farthest",
        &[
            "catamaran farthest scan.ply -n 100 -o samples.csv",
            "catamaran farthest scan.ply -n 100 -o samples.csv --cells cells.npy",
        ],
    ),
    (
        "distance",
        &[
            "catamaran distance scan.ply --from 0,7 -o distances.npy",
            "catamaran distance scan.ply --from 0 --method edges -o distances.csv --picture d.png",
            "catamaran distance scan.ply --from 310 --trace 0,0,1 --length 5",
        ],
    ),
    (
        "curve",
        &[
            "catamaran curve scan.obj --samples clicks.txt --smooth -o curve.json",
            "catamaran curve scan.obj --samples clicks.txt --smooth --cut pieces/",
            "catamaran curve scan.obj --samples clicks.txt --region mask.npy --paint selection.ply",
        ],
    ),
    (
        "spectrum",
        &[
            "catamaran spectrum scan.ply -k 20 -o eigen.npz --picture eigen.png",
            "catamaran spectrum scan.ply -k 20 --via-decimation 600 -o eigen.npz",
        ],
    ),
    ("basis", &["catamaran basis scan.ply -k 8 --order 2 -o basis.npz"]),
    (
        "filter",
        &[
            "catamaran filter scan.ply --low-pass 20 -k 30 -o smooth.ply --picture smooth.png",
            "catamaran filter scan.ply --heat 0.01 -k 30 --functions f.csv -o g.csv",
        ],
    ),
    (
        "transfer",
        &[
            "catamaran transfer a.ply b.ply --functions f.csv --landmarks pairs.txt -k 10 -o g.csv",
            "catamaran transfer a.ply b.ply --details heights --identity -k 12 -o details.ply",
        ],
    ),
    (
        "descriptors",
        &[
            "catamaran descriptors man.ply --kind wks -k 40 -o wks.npy",
            "catamaran descriptors man.ply --kind shot --radius 0.8 -o shot.csv",
        ],
    ),
    ("shapedna", &["catamaran shapedna b.ply c.ply --query a.ply --distances distances.csv"]),
    (
        "unions",
        &[
            "catamaran unions predict top.ply bottom.ply -o spectra.csv",
            "catamaran unions shape top.ply --spectrum spectra.csv -k 8 -o union.ply",
        ],
    ),
    (
        "unions predict",
        &[
            "catamaran unions predict top.ply bottom.ply -o spectra.csv",
            "catamaran unions predict top.ply bottom.ply --localize man.ply --picture where.png",
        ],
    ),
    (
        "unions interpolate",
        &["catamaran unions interpolate a.ply b.ply c.ply --localize man.ply --picture morph.png"],
    ),
    ("unions shape", &["catamaran unions shape top.ply --spectrum spectra.csv -k 8 -o union.ply"]),
    ("unions dataset", &["catamaran unions dataset -o data.npz --seed 1"]),
    (
        "unions train",
        &[
            "catamaran unions train data.npz -o own.safetensors",
            "catamaran unions train data.npz -o own.safetensors --resume",
        ],
    ),
    ("unions tune", &["catamaran unions tune a.ply b.ply c.ply d.ply -o family.safetensors"]),
    ("unions template", &["catamaran unions template -o man.ply"]),
    (
        "wilt",
        &[
            "catamaran wilt --grow 300 --hours 24 --frames 4 -o grown",
            "catamaran wilt plant.txt --hours 48 --frames 12 --animation -o film",
            "catamaran wilt plant.txt --fit measured.csv -o fit",
        ],
    ),
    (
        "slime",
        &[
            "catamaran slime torus.obj --steps 300 -o texture --render torus.png",
            "catamaran slime torus.obj --steps 300 -o gold --material=gold",
            "catamaran slime --tile --size 512 --steps 300 -o tile",
        ],
    ),
    (
        "newton",
        &[
            "catamaran newton --power 5 --size 800x600 -o plane.png",
            "catamaran newton vase.obj -o colored.ply --picture colored.png",
            "catamaran newton --volume --basins 0 -o basin.ply --picture basin.png",
        ],
    ),
    ("info", &["catamaran info", "catamaran info --backend libblis.so"]),
    ("tune", &["catamaran tune"]),
    ("demo", &["catamaran demo -o page"]),
    (
        "completions",
        &[
            "catamaran completions bash > ~/.local/share/bash-completion/completions/catamaran",
            "catamaran completions zsh > ~/.zfunc/_catamaran",
            "catamaran completions fish > ~/.config/fish/completions/catamaran.fish",
        ],
    ),
    ("help", &["catamaran help ata", "catamaran help unions predict", "catamaran help topics"]),
    ("man", &["catamaran man -o ~/.local/share/man/man1", "catamaran man -o man1 --force"]),
];

/// Returns a program whose commands, but not itself, have examples at the end of their long help.
pub fn with_examples(program: Command) -> Command {
    program.mut_subcommands(|command| {
        let name = command.get_name().to_owned();
        with_examples_of(command, &name)
    })
}

/// Returns a command with its examples, and those of the commands below it. The path has the words
/// of the command.
fn with_examples_of(command: Command, path: &str) -> Command {
    let found = EXAMPLES.iter().find(|(name, _)| *name == path);
    let lines = found.map(|(_, examples)| examples.join("\n  ")).unwrap_or_default();
    let command = command.after_long_help(format!("Examples:\n  {lines}"));
    command.mut_subcommands(|below| {
        let path = format!("{path} {}", below.get_name());
        with_examples_of(below, &path)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::program;
    use crate::{effects, stdio};

    /// Returns the words of a command and of those below it.
    fn paths(command: &Command, path: &str) -> Vec<String> {
        let below = command.get_subcommands().flat_map(|below| {
            let path = format!("{path} {}", below.get_name());
            let path = path.trim();
            [vec![path.to_owned()], paths(below, path)].concat()
        });
        below.collect()
    }

    #[test]
    fn every_command_has_one_to_three_examples_of_its_own() {
        let mut named: Vec<_> = EXAMPLES.iter().map(|(path, _)| (*path).to_owned()).collect();
        let mut paths = paths(&program(), "");
        named.sort();
        paths.sort();
        assert_eq!(named, paths);
        for (path, examples) in EXAMPLES {
            assert!((1..=3).contains(&examples.len()), "{path}");
            for example in examples {
                assert!(example.starts_with(&format!("catamaran {path}")), "{path}: {example}");
                assert!(example.len() + "  ".len() <= 100, "{example}");
            }
        }
    }

    #[test]
    fn examples_are_command_lines_that_the_program_accepts() {
        for example in EXAMPLES.iter().flat_map(|(_, examples)| examples.iter()) {
            let mut program = program();
            let words = example.split(' ').take_while(|word| *word != ">");
            let matches = program.try_get_matches_from_mut(words);
            let matches = matches.unwrap_or_else(|error| panic!("{example}: {error}"));
            assert_eq!(stdio::refusal(&program, &matches), None, "{example}");
            assert_eq!(effects::missing(&matches), None, "{example}");
        }
    }

    #[test]
    fn long_help_ends_with_the_examples() {
        let error = program().try_get_matches_from(["catamaran", "svd", "--help"]).unwrap_err();
        let end = "\n\nExamples:\n  catamaran svd A.npy\n  catamaran svd A.npy -o svd.npz --left\n";
        assert!(error.to_string().ends_with(end), "{error}");
    }
}
