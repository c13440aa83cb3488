//! `decimate`: decimation beside other libraries, each call in a process of its own.

use std::path::PathBuf;

use catamaran_bench::decimate::{Contender, Inputs, Job, Rivals, Row, race, solve};
use catamaran_bench::{Result, host, record};

#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, each with the number of vertices wanted, as in mesh.ply:5000; by default those of the bars, if
    /// CATAMARAN_DATA (default ../shared) has them.
    meshes: Vec<String>,
    /// Who; all by default, without those known to take minutes on meshes beyond half a million vertices.
    #[arg(long, value_delimiter = ',')]
    contenders: Vec<Contender>,
    /// Threads.
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Repetitions.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Where scripts/rivals installed the others.
    #[arg(long, default_value = "target/rivals")]
    libraries: PathBuf,
    /// Writes NAME.csv and host.txt under bench/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
    /// Decimates the mesh once, by this contender of ours, and prints seconds and bytes.
    #[arg(long, hide = true, requires = "output", requires = "n")]
    solve: Option<Contender>,
    #[arg(short, hide = true)]
    n: Option<usize>,
    #[arg(short, hide = true)]
    output: Option<PathBuf>,
}

/// The meshes of the bars.
const BARS: [(&str, usize); 4] = [
    ("armadillo43k.obj.gz", 5000),
    ("mni152_wm317k.ply.xz", 10_000),
    ("srtm_n44w072_1p44M.ply.xz", 10_000),
    ("mni152_wm1p24M.ply.xz", 50_000),
];

/// Those that finish on a million vertices within a minute.
const FAST: [Contender; 5] = [
    Contender::Ours,
    Contender::Thesis,
    Contender::Pyacvd,
    Contender::FastSimplification,
    Contender::Meshoptimizer,
];

/// From how many vertices on only [`FAST`] ones are asked.
const MANY: usize = 500_000;

pub fn run(arguments: &Arguments) -> Result<()> {
    if let (Some(contender), Some(n), Some(output), [input]) =
        (arguments.solve, arguments.n, &arguments.output, &arguments.meshes[..])
    {
        return solve(
            contender,
            &Job { input: input.as_ref(), n, threads: arguments.threads, output },
        );
    }
    let host = host::describe(&[]);
    println!("{host}\nreading is not counted; {} threads\n", arguments.threads);
    let (inputs, rivals) = (Inputs::new()?, Rivals::find(&arguments.libraries));
    let mut lines = Vec::new();
    for (input, n) in meshes(&inputs, &arguments.meshes)? {
        let vertices = input.mesh.vertices().len();
        let contenders = match &arguments.contenders[..] {
            [] if vertices > MANY => &FAST[..],
            [] => &Contender::ALL[..],
            named => named,
        };
        println!("**{}**, {vertices} vertices, to {n}\n\n{}", input.name, Row::TITLES);
        for row in
            race(contenders, &rivals, &inputs, &input, n, arguments.threads, arguments.repeat)?
        {
            println!("{}", row.markdown());
            lines.push(format!(
                "{},{vertices},{n},{},{}",
                input.name,
                arguments.threads,
                row.line()
            ));
        }
        println!();
    }
    if let Some(name) = &arguments.record {
        let csv = record::csv(&format!("mesh,input_vertices,n,threads,{}", Row::HEADER), lines);
        let files = [(&*format!("{name}.csv"), csv), ("host.txt", host)];
        println!("recorded in {}", record::write(&files)?.display());
    }
    Ok(())
}

fn meshes(
    inputs: &Inputs,
    named: &[String],
) -> Result<Vec<(catamaran_bench::decimate::Input, usize)>> {
    if named.is_empty() {
        let real = BARS.map(|(file, n)| inputs.real(file).map(|input| Some((input?, n))));
        return Ok(real.into_iter().collect::<Result<Vec<_>>>()?.into_iter().flatten().collect());
    }
    let mesh = |text: &String| -> Result<_> {
        let (path, n) = text.rsplit_once(':').ok_or_else(|| format!("{text}: no :N at its end"))?;
        let n = n.parse().map_err(|_| format!("{text}: {n:?} is not a number of vertices"))?;
        let name = path.rsplit('/').next().unwrap_or(path);
        let name = name.split('.').next().unwrap_or(name);
        Ok((inputs.of(name, &catamaran::mesh::io::read(path.as_ref())?.mesh)?, n))
    };
    named.iter().map(mesh).collect()
}
