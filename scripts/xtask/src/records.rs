//! Lists the records of bench/record that are older than the sources they measure (records.txt): a
//! reader's measure of how far a number can be trusted. It fails where a record has no line there.

use std::path::Path;
use std::process::Command;

/// Lines `start of a name | paths`.
const MEASURED: &str = include_str!("records.txt");

/// Prints each record with commits to its sources since, the most first.
///
/// # Errors
/// When a record measures nothing known, or git fails.
pub fn list(root: &Path) -> Result<(), String> {
    let files = git(root, &["ls-files", "bench/record"])?;
    let mut stale = Vec::new();
    for file in files.lines() {
        let name = file.rsplit('/').next().unwrap_or(file);
        if name.ends_with("host.txt") {
            continue;
        }
        let paths = measured(MEASURED, name).ok_or_else(|| {
            format!("{file}: scripts/xtask/src/records.txt must say what it measures")
        })?;
        let commit = git(root, &["log", "-1", "--format=%H", "--", file])?;
        // Not committed yet: new.
        if commit.is_empty() {
            continue;
        }
        let range = format!("{}..HEAD", commit.trim());
        let arguments = [&["rev-list", "--count", &range, "--"], &paths[..]].concat();
        let count = git(root, &arguments)?;
        let count: usize = count.trim().parse().map_err(|e| format!("git rev-list: {e}"))?;
        if count > 0 {
            stale.push((count, file, paths));
        }
    }
    stale.sort_by(|a, b| (b.0, a.1).cmp(&(a.0, b.1)));
    for (count, file, paths) in &stale {
        println!("{file}: {count} later commits to {}", paths.join(" "));
    }
    println!("{} records are older than what they measure", stale.len());
    Ok(())
}

/// Returns the paths of the longest start that fits.
fn measured<'a>(table: &'a str, name: &str) -> Option<Vec<&'a str>> {
    let lines = table.lines().filter(|line| !line.starts_with('#'));
    let fitting = lines
        .filter_map(|line| line.split_once('|'))
        .filter(|(start, _)| name.starts_with(start.trim()));
    let (_, paths) = fitting.max_by_key(|(start, _)| start.trim().len())?;
    Some(paths.split_whitespace().collect())
}

fn git(root: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new("git")
        .arg("-C")
        .arg(root)
        .args(arguments)
        .output()
        .map_err(|e| format!("git: {e}"))?;
    if !output.status.success() {
        return Err(format!(
            "git {}: {}",
            arguments.join(" "),
            String::from_utf8_lossy(&output.stderr)
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use super::measured;

    #[test]
    fn the_longest_start_of_a_records_name_says_what_it_measures() {
        let table = "# comment | no\nata | a\nata-mpi | b c\n";
        assert_eq!(measured(table, "ata-avx2.csv"), Some(vec!["a"]));
        assert_eq!(measured(table, "ata-mpi.csv"), Some(vec!["b", "c"]));
        assert_eq!(measured(table, "other.csv"), None);
    }
}
