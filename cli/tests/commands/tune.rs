//! `catamaran tune`, from outside.

use std::fs;

use catamaran::kernel::packed::{FloatIsa, Rates};

use crate::common::{CACHE, Folder};

/// The four rates of the table's only line, each with the built-in one.
fn table(report: &str) -> Vec<(f64, f64)> {
    let line = report.lines().find_map(|line| line.strip_prefix("portable ")).expect("its line");
    let words: Vec<&str> = line.split_whitespace().collect();
    let number = |word: &str| word.trim_matches(['(', ')']).parse().expect("a number");
    words.chunks(2).map(|pair| (number(pair[0]), number(pair[1]))).collect()
}

#[test]
fn dry_run_prints_a_table_and_writes_nothing() {
    let folder = Folder::new();
    let report = folder.succeed("tune --dry-run --isa portable");
    let rates = table(&report);
    let of = Rates::of(FloatIsa::Portable);
    let built_in = [of.flops, of.read_bytes, of.pack_bytes, of.update_bytes];
    assert_eq!(rates.iter().map(|r| r.1).collect::<Vec<_>>(), built_in.map(|rate| rate / 1e9));
    assert!(rates.iter().all(|r| r.0 >= 0.0), "{report}");
    for part in ["GFLOP/s f64", "GB/s read", "GB/s pack", "GB/s update"] {
        assert!(report.contains(part), "{part:?} in {report}");
    }
    assert!(!report.contains("written") && folder.names().is_empty(), "{report}");
}

#[test]
fn measured_rates_are_kept_and_info_says_where() {
    let folder = Folder::new();
    let report = folder.succeed("tune --isa portable");
    let path = report.lines().find_map(|line| line.strip_prefix("written     ")).expect("a file");
    assert!(path.starts_with(&*folder.path(CACHE).to_string_lossy()), "{path}");
    let kept = Rates::load(path.as_ref(), FloatIsa::Portable).unwrap();
    for (rate, (shown, _)) in
        [kept.flops, kept.read_bytes, kept.pack_bytes, kept.update_bytes].iter().zip(table(&report))
    {
        assert!((rate / 1e9 - shown).abs() <= 0.06, "{rate} and {shown}");
    }
    let info = folder.succeed("info");
    assert!(info.contains(&format!("portable: measured, {path}")), "{info}");
    // A product asks for them too.
    folder.write("a.csv", "1,2\n3,4\n");
    folder.succeed("ata a.csv -o c.csv --backend native");

    let text = fs::read_to_string(path).unwrap();
    fs::write(path, text.replace("flops = ", "flops = -")).unwrap();
    let info = folder.succeed("info");
    assert!(
        info.contains(&format!("portable: built in, as this file is refused: {path}:2: flops"))
    );
    folder.succeed("ata a.csv -o c.csv --force");
}

#[test]
fn unknown_instances_say_what_is_known() {
    let run = Folder::new().run("tune --isa magic");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("magic") && run.stderr.contains("portable"), "{}", run.stderr);
}

#[test]
fn an_instance_that_the_machine_lacks_is_refused() {
    let folder = Folder::new();
    for isa in FloatIsa::ALL {
        if let Some(why) = isa.refusal() {
            let run = folder.run(&format!("tune --isa {}", isa.name()));
            assert_eq!(run.code, Some(1));
            assert!(run.stderr.contains(why) && folder.names().is_empty(), "{}", run.stderr);
        }
    }
}
