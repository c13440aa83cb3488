//! `gram`: applications of A^T A beside other libraries: correct digits, errors and times.

use std::path::PathBuf;

use catamaran::base::available_cores;
use catamaran_bench::gram::ours::{self, Task};
use catamaran_bench::gram::{
    Turns, digits, gram_time, least_squares, orthogonality, principal_components, singular_values,
};
use catamaran_bench::plant::Part;
use catamaran_bench::{Result, child, host, record};
use clap::ValueEnum;

#[derive(clap::Args)]
pub struct Arguments {
    /// Tables; default all.
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Table>,
    /// Small matrices, for a look at the tables: times mean nothing.
    #[arg(long)]
    quick: bool,
    /// Threads of everyone.
    #[arg(long, default_value_t = available_cores())]
    threads: usize,
    /// Repetitions of everything that is timed.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Where scripts/rivals installed the rivals.
    #[arg(long, default_value = "target/rivals")]
    libraries: PathBuf,
    /// Writes NAME.csv, NAME.md and host.txt under bench/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
    /// Does a task in this folder once, and prints what bench/rivals/gram.py does.
    #[arg(long, hide = true, requires = "task")]
    solve: Option<PathBuf>,
    /// The task.
    #[arg(long, hide = true, value_enum)]
    task: Option<Task>,
}

/// A table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Table {
    /// Correct digits on the NIST data.
    Digits,
    /// Errors of singular values over condition numbers.
    Sigma,
    /// Times and errors of least squares.
    Lstsq,
    /// Principal components of a file.
    Pca,
    /// Time of the extended Gram matrix over that of the exact path.
    Ratio,
    /// Orthogonality of the Q of a QR decomposition.
    Orthogonality,
}

/// The columns of the record.
const HEADER: &str = "table,case,quantity,value";

pub fn run(arguments: &Arguments) -> Result<()> {
    if let (Some(folder), Some(task)) = (&arguments.solve, arguments.task) {
        println!("{}", ours::run(task, folder, arguments.threads)?);
        return Ok(());
    }
    let python = child::python(&arguments.libraries).ok_or("no scipy: run scripts/rivals first")?;
    let host = host::describe(&[]);
    println!("{host}");
    let turns = Turns { python, threads: arguments.threads, repeat: arguments.repeat };
    let mut text = String::from("# What people do with A^T A\n");
    let mut lines = Vec::new();
    for &table in Table::value_variants() {
        if !arguments.only.is_empty() && !arguments.only.contains(&table) {
            continue;
        }
        for part in parts(table, &turns, arguments.quick)? {
            println!("{}", part.markdown());
            text += &format!("\n{}", part.markdown());
            lines.extend(part.lines());
        }
    }
    if let Some(name) = &arguments.record {
        let [csv, markdown] = ["csv", "md"].map(|ending| format!("{name}.{ending}"));
        let table = record::csv(HEADER, lines);
        let files = [(csv.as_str(), table), (markdown.as_str(), text), ("host.txt", host)];
        println!("\nrecorded in {}", record::write(&files)?.display());
    }
    Ok(())
}

fn parts(table: Table, turns: &Turns, quick: bool) -> Result<Vec<Part>> {
    Ok(match table {
        Table::Digits => digits(turns)?,
        Table::Sigma => vec![singular_values(turns, quick)?],
        Table::Lstsq => vec![least_squares(turns, quick)?],
        Table::Pca => vec![principal_components(turns, quick)?],
        Table::Ratio => vec![gram_time(turns.threads, turns.repeat, quick)?],
        Table::Orthogonality => vec![orthogonality(turns, quick)?],
    })
}
