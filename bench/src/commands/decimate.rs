//! `decimate`: decimation beside other libraries, each call in a separate process.

use std::path::PathBuf;

use catamaran_bench::decimate::{
    Contender, Input, Inputs, Rivals, Row, Run, Set, Soundness, race, solve, summary,
};
use catamaran_bench::{Result, host, record};

#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, each with the number of vertices wanted, as in mesh.ply:5000; by default those of
    /// --set, if CATAMARAN_DATA (default ../shared) has them.
    meshes: Vec<String>,
    /// The meshes, and who decimates them by default.
    #[arg(long, value_enum, default_value_t = Set::Bars, conflicts_with = "meshes")]
    set: Set,
    /// Who; by default, for the bars, all without those known to take minutes on meshes beyond half
    /// a million vertices; for varied meshes one of each kind.
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
    /// Writes NAME.csv, the summary as NAME.md, and host.txt under bench/record.
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

pub fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { threads, repeat, .. } = *arguments;
    if let (Some(contender), Some(n), Some(output), [input]) =
        (arguments.solve, arguments.n, &arguments.output, &arguments.meshes[..])
    {
        return solve(contender, input.as_ref(), n, threads, output);
    }
    let host = host::describe(&[]);
    println!("{host}\nreading is not counted; {threads} threads\n");
    let (inputs, rivals) = (Inputs::new()?, Rivals::find(&arguments.libraries));
    let (mut lines, mut runs, mut case) = (Vec::new(), Vec::new(), 0);
    for (input, sizes) in meshes(&inputs, arguments)? {
        let vertices = input.mesh.vertices().len();
        let before = Soundness::of(&input.mesh, rivals.intersecting_faces(&[&input.path])[0]);
        let contenders = match &arguments.contenders[..] {
            [] => arguments.set.contenders(vertices),
            named => named,
        };
        for n in sizes {
            println!(
                "**{}**, {vertices} vertices, intersecting faces {}, to {n}\n\n{}",
                input.name,
                before.intersecting,
                Row::TITLES
            );
            for row in race(contenders, &rivals, &inputs, &input, n, threads, repeat)? {
                println!("{}", row.markdown());
                let [before_line, line] = [before.line(), row.line()];
                lines.push(format!("{},{vertices},{before_line},{n},{threads},{line}", input.name));
                runs.push(Run::new(case, &before, n, &row));
            }
            println!();
            case += 1;
        }
    }
    let table = format!("{case} races on {threads} threads\n\n{}\n", summary(&runs));
    print!("{table}");
    if let Some(name) = &arguments.record {
        let header = format!(
            "mesh,input_vertices,{},n,threads,{}",
            Soundness::header("input_"),
            Row::header()
        );
        let csv = record::csv(&header, lines);
        let files =
            [(&*format!("{name}.csv"), csv), (&*format!("{name}.md"), table), ("host.txt", host)];
        println!("recorded in {}", record::write(&files)?.display());
    }
    Ok(())
}

/// Returns the meshes that the arguments name, or those of their set that exist, each with numbers
/// of vertices.
fn meshes(inputs: &Inputs, arguments: &Arguments) -> Result<Vec<(Input, Vec<usize>)>> {
    if arguments.meshes.is_empty() {
        let real = arguments.set.meshes().into_iter();
        let real = real.map(|(file, sizes)| Ok(inputs.real(file)?.map(|input| (input, sizes))));
        return real.filter_map(Result::transpose).collect();
    }
    let mesh = |text: &String| -> Result<_> {
        let (path, n) = text
            .rsplit_once(':')
            .ok_or_else(|| format!("{text}: must end in :N, a number of vertices"))?;
        let n = n.parse().map_err(|_| format!("{text}: {n:?} is not a number of vertices"))?;
        let name = path.rsplit('/').next().unwrap_or(path);
        let name = name.split('.').next().unwrap_or(name);
        Ok((inputs.of(name, catamaran_geometry::mesh::io::read(path.as_ref())?)?, vec![n]))
    };
    arguments.meshes.iter().map(mesh).collect()
}
