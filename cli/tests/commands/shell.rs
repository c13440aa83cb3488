//! What all commands have in common: usage, exit codes, completions, man pages, `-`.

use std::io::Write as _;
use std::process::Stdio;

use crate::common::{Folder, Run, subcommands};
use crate::lines::LINES;

#[test]
fn completions_of_every_shell_name_commands_and_options() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.succeed(&format!("completions {shell}"));
        for word in ["ata-merge", "interpolate", "by-column", "input-limit"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn lines_of_help_have_at_most_100_columns() {
    let folder = Folder::new();
    let mut open = vec![String::new()];
    let mut count = 0;
    while let Some(command) = open.pop() {
        let helps = ["-h", "--help"].map(|flag| folder.succeed(&format!("{command} {flag}")));
        for line in helps.iter().flat_map(|help| help.lines()) {
            assert!(line.chars().count() <= 100, "{command}: {line}");
        }
        let below = subcommands(&helps[1]).into_iter();
        open.extend(below.map(|name| format!("{command} {name}").trim().into()));
        count += 1;
    }
    assert!(count > 30, "{count}");
    // Without arguments the program prints its help, too.
    let run = folder.run("");
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert_eq!(run.stderr, folder.succeed("--help"));
}

#[test]
fn help_prints_what_the_option_prints_and_pages_about_topics() {
    let folder = Folder::new();
    for command in ["", "ata", "unions", "unions predict", "help"] {
        let help = folder.succeed(&format!("help {command}"));
        assert_eq!(help, folder.succeed(&format!("{command} --help")), "{command}");
    }
    let topics = folder.succeed("help topics");
    let names: Vec<&str> = topics.lines().filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(names, ["files", "memory", "ranks", "exit-codes", "reproducibility"]);
    for (name, line) in names.iter().zip(topics.lines()) {
        let page = folder.succeed(&format!("help {name}"));
        let title = page.lines().next().unwrap().strip_prefix("# ").unwrap();
        assert!(line.ends_with(&format!("  {title}")), "{line}: {title}");
    }
    let run = folder.run("help spectrun");
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("`spectrun` is neither a command nor a topic"), "{}", run.stderr);
}

#[test]
fn there_is_a_man_page_for_every_command() {
    let folder = Folder::new();
    folder.succeed("man -o man");
    for line in LINES {
        let words: Vec<&str> = line.split_whitespace().collect();
        let count = if words[0] == "unions" { 2 } else { 1 };
        let name = format!("man/catamaran-{}.1", words[..count].join("-"));
        let page = std::fs::read_to_string(folder.path(&name)).expect(&name);
        assert!(page.contains(".SH OPTIONS") && page.contains("Examples:"), "{name}");
    }
    let page = std::fs::read_to_string(folder.path("man/catamaran.1")).unwrap();
    assert!(page.contains("Exit codes"), "{page}");
    assert!(folder.fail("man -o man").contains("exists already"));
    folder.succeed("man -o man --force");
}

#[test]
fn usage_errors_exit_with_2_and_suggest_what_is_alike() {
    let folder = Folder::new();
    for (line, suggestion) in [
        ("spectrun x.ply", "'spectrum'"),
        ("ata a.npy --verfy", "'--verify'"),
        ("ata a.npy --scheme winogard", "'winograd'"),
        ("filter x.ply --low-pass 3 -o y.ply --laplacian intrinsc", "'intrinsic'"),
        ("slime x.obj -o y --material=marbel", "'marble'"),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, Some(2), "{line}: {}", run.stderr);
        assert!(run.stderr.contains(suggestion), "{line}: {}", run.stderr);
    }
}

#[test]
fn dashes_are_refused_where_names_tell_formats() {
    let folder = Folder::new();
    for (line, option) in [
        ("ata a.npy -o -", "--output <C>"),
        ("unions predict - b.off", "<PARTS>"),
        ("mesh a.ply --picture -", "--picture <FILE>"),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, Some(2), "{line}: {}", run.stderr);
        assert!(run.stderr.contains(option), "{line}: {}", run.stderr);
    }
}

#[test]
fn samples_and_measurements_come_from_stdin() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    let with_stdin = |line: &str, text: &str| {
        let mut command = folder.program();
        command.args(line.split_whitespace()).stdin(Stdio::piped());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        Run::new(child.wait_with_output().unwrap())
    };
    let run = with_stdin("curve a.obj --samples - -o c.obj", "0\n1\n2\n3\n");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let run = with_stdin("curve a.obj --samples - -o d.obj", "0\nx\n");
    assert!(run.stderr.contains("stdin:2: neither a vertex"), "{}", run.stderr);
    let run = with_stdin("wilt --grow 9 -o out --fit -", "time_h\n");
    assert!(run.stderr.contains("stdin: line 1: expected"), "{}", run.stderr);
}
