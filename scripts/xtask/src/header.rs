//! `include/catamaran.h`, generated from capi/src.

use std::path::Path;

use crate::generated::Generated;

/// `include/catamaran.h`.
pub const HEADER: Generated = Generated {
    name: "include/catamaran.h",
    source: "capi/src",
    command: "cargo xtask header",
    generate,
};

/// A section of the header: its name among the groups of the documentation, and the files of
/// capi/src that it is made of, one of which has its title, text and example in its `//!`.
pub struct Section {
    /// Of its group.
    pub name: &'static str,
    /// What names of functions begin with after `cata_`.
    #[cfg_attr(not(test), expect(dead_code, reason = "of the tests of the conventions"))]
    pub chapters: &'static [&'static str],
    pub files: &'static [&'static str],
}

const fn section(
    name: &'static str,
    chapters: &'static [&'static str],
    files: &'static [&'static str],
) -> Section {
    Section { name, chapters, files }
}

/// In the order of the header.
pub const SECTIONS: &[Section] = &[
    section(
        "status",
        &["status", "last_error_message", "version", "capabilities", "memory", "threads"],
        &["status", "version", "memory"],
    ),
    section("progress", &["progress"], &["progress"]),
    section("backend", &["backend"], &["backend"]),
    section(
        "ata",
        &["ata", "aat", "atb", "aha", "ahb", "verify"],
        &[
            "layout",
            "ata_params",
            "ata",
            "ata_batched",
            "ata_sparse",
            "ata_plan",
            "atb",
            "aha",
            "verify",
        ],
    ),
    section("gram", &["lstsq", "pca", "svd", "gram"], &["lstsq", "pca", "gram"]),
    section("rows", &["ata_rows", "accumulator"], &["rows", "accumulator"]),
    section("tables", &["table"], &["table"]),
    section("cholesky", &["cholesky"], &["cholesky"]),
    section("eigs", &["eigs", "ortho"], &["eigs", "ortho"]),
    section("mesh_files", &["mesh_file", "mesh_bytes"], &["mesh_file", "mesh_attributes"]),
    section("repair", &["repair"], &["repair"]),
    section("mesh", &["mesh"], &["mesh"]),
    section("surfaces", &["mesh"], &["topology", "measures", "generated"]),
    section("laplacians", &["laplacian", "cloud_laplacian"], &["laplacian"]),
    section("distances", &["heat", "distance", "path"], &["distance"]),
    section("decimation", &["decimation"], &["decimation"]),
    section("curves", &["curve", "curves"], &["curve"]),
    section("regions", &["drawing", "drawn", "region", "part"], &["drawing", "surface_region"]),
    section(
        "spectra",
        &["basis", "filter", "map", "product_map", "transfer", "shape_dna", "shape"],
        &["basis", "filter", "map", "transfer", "shape_dna", "shape"],
    ),
    section("descriptors", &["descriptor"], &["descriptor"]),
    section("unions", &["unions"], &["unions"]),
    section("plants", &["plant"], &["plant", "rods"]),
    section("slime", &["slime"], &["slime"]),
    section("newton", &["newton"], &["newton"]),
    section("devices", &["device"], &["device"]),
    section("mpi", &["world", "symmetric", "cyclic", "traffic"], &["world", "mpi"]),
];

/// Files of capi/src without exports, or with those of tests alone.
const WITHOUT_EXPORTS: &[&str] = &[
    "lib", "absent", "boundary", "defaults", "entries", "internal", "message", "outputs", "params",
    "pointer", "ranks", "regions",
];

fn generate(root: &Path) -> Result<String, String> {
    let capi = root.join("capi/src");
    every_file_is_known(&capi)?;
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml"))?;
    let mut header = preamble();
    for section in SECTIONS {
        header += &opening(section, &capi)?;
        for file in section.files {
            let builder = cbindgen::Builder::new().with_config(config.clone());
            let path = capi.join(file).with_extension("rs");
            let bindings = builder.with_src(path).generate();
            let mut text = Vec::new();
            bindings.map_err(|e| format!("cbindgen: {e}"))?.write(&mut text);
            let text = String::from_utf8(text).map_err(|e| format!("cbindgen: {e}"))?;
            let text = beside(&joined(&tidied(text.trim_matches('\n'))));
            let text = text.trim_end();
            if !text.is_empty() {
                header += text;
                header += "\n\n";
            }
        }
        header += "/** @} */\n\n";
    }
    Ok(header + CLOSING)
}

/// Returns the beginning of a section: a comment with its title, text and example, which opens a
/// group of the documentation.
fn opening(section: &Section, capi: &Path) -> Result<String, String> {
    let name = section.name;
    let mut source = None;
    for file in section.files {
        let text = super::read(&capi.join(file).with_extension("rs"))?;
        if text.starts_with("//! # ") {
            source = Some(text);
        }
    }
    let source = source.ok_or_else(|| format!("capi/src: no title for the section {name}"))?;
    let lines = source.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim_end);
    let mut lines = lines.map(|line| line.strip_prefix(' ').unwrap_or(line));
    let title = lines.next().unwrap_or_default().trim_start_matches("# ");
    let rule = "=".repeat(86 - title.len());
    let mut text = format!("/* ==== {title} {rule} */\n/**\n * @defgroup {name} {title}\n");
    let mut is_code = false;
    for line in lines.filter(|line| !line.is_empty()) {
        let line = match (line, is_code) {
            ("```c", false) => "@code{.c}",
            ("```", true) => "@endcode",
            (line, _) => line,
        };
        is_code = line == "@code{.c}" || (is_code && line != "@endcode");
        text += format!(" * {line}").trim_end();
        text += "\n";
    }
    Ok(text + " * @{\n */\n\n")
}

/// A new file of capi/src must be entered above, or its exports would be missing silently.
fn every_file_is_known(capi: &Path) -> Result<(), String> {
    let known = |name: &str| SECTIONS.iter().any(|section| section.files.contains(&name));
    let entries = std::fs::read_dir(capi).map_err(|e| format!("{}: {e}", capi.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| e.to_string())?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !known(&name) && !WITHOUT_EXPORTS.contains(&name.as_str()) {
            return Err(format!("{}: add it to a section in scripts/xtask", path.display()));
        }
    }
    Ok(())
}

/// Comments as in C: in as few lines as they need, and without the sections that say the same to
/// readers of Rust.
fn tidied(header: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    let mut in_safety = false;
    for line in header.lines() {
        in_safety = (in_safety || line == " * # Safety") && line != " */";
        if in_safety {
            continue;
        }
        // No gap before the end, nor before a list.
        if (line == " */" || line.starts_with(" * - ")) && lines.last() == Some(&" *") {
            lines.pop();
        }
        lines.push(line);
    }
    let text = lines.join("\n") + "\n";
    let mut tidy = String::new();
    let mut rest = text.as_str();
    while let Some(start) = rest.find("/**\n") {
        let (before, comment) = rest.split_at(start);
        tidy += before;
        let end = comment.find("*/").map_or(comment.len(), |end| end + 2);
        let (comment, after) = comment.split_at(end);
        let inner: Vec<&str> = comment.lines().collect();
        match inner[..] {
            ["/**", only, _] => {
                tidy += &format!("/** {} */", only.trim_start().trim_start_matches("* "));
            }
            ["/**", first, ref middle @ .., last, _] => {
                tidy += &format!("/** {}\n", first.trim_start().trim_start_matches("* "));
                middle.iter().for_each(|line| tidy += &format!("{line}\n"));
                tidy += &format!("{last} */");
            }
            _ => tidy += comment,
        }
        rest = after;
    }
    tidy + rest
}

/// Comments of a constant, a field or a function behind it, where the line is wide enough; such
/// constants and functions follow each other without a gap.
fn beside(header: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for line in header.lines() {
        let comment = lines.last().and_then(|last| last.trim_start().strip_prefix("/** "));
        let comment = comment.filter(|comment| {
            let is_type = line.starts_with("typedef");
            !is_type && comment.ends_with(" */") && !line.trim_start().starts_with('/')
        });
        let joined = comment.map(|comment| format!("{line} /**< {comment}"));
        let Some(joined) = joined.filter(|joined| joined.chars().count() <= 100) else {
            // A struct and its `_init` belong together.
            let is_init = line.contains("_params_init(") && lines.len() >= 2;
            if is_init && lines[lines.len() - 2].is_empty() {
                lines.remove(lines.len() - 2);
            }
            lines.push(line.to_owned());
            continue;
        };
        lines.pop();
        let is_short = |line: &String| line.starts_with("#define") || line.contains("; /**< ");
        let after_init = joined.contains("_params_init(");
        let before = lines.len().checked_sub(2).map(|at| &lines[at]);
        let follows = before.is_some_and(|before| is_short(before) && !before.starts_with(' '));
        if lines.last().is_some_and(String::is_empty) && (follows || after_init) {
            lines.pop();
        }
        lines.push(joined);
    }
    lines.join("\n")
}

/// Declarations in as few lines of at most 100 columns as they take, with types by their names
/// alone.
fn joined(header: &str) -> String {
    let mut text = String::new();
    let mut lines = header.lines();
    while let Some(line) = lines.next() {
        // A pointer to a function is wrapped as one.
        let is_pointer = line.starts_with("typedef") && line.contains("(*");
        let is_type = (line.starts_with("typedef") && !is_pointer) || line.starts_with('}');
        if line.starts_with([' ', '/', '#']) || is_type || !line.contains('(') {
            let is_field = line.starts_with("    ") && !line.trim_start().starts_with('*');
            text += &if is_field { line.replace("struct ", "") } else { line.to_owned() };
            text += "\n";
            continue;
        }
        let mut declaration = line.to_owned();
        while !declaration.ends_with(';') {
            let Some(more) = lines.next() else { break };
            declaration += " ";
            declaration += more.trim();
        }
        let mut width = 0;
        for word in declaration.replace("struct ", "").split_inclusive(", ") {
            if width > 0 && width + word.trim_end().len() > 100 {
                text.truncate(text.trim_end().len());
                text += "\n    ";
                width = 4;
            }
            text += word;
            width += word.len();
        }
        text += "\n";
    }
    text.truncate(text.trim_end().len());
    text
}

fn preamble() -> String {
    format!("{CONVENTIONS}{}{OPENING}", version_macros())
}

const CONVENTIONS: &str = "\
/* Catamaran: A^T A, spectra and geometry at scale. The C interface.
 *
 * Generated from capi/src by `cargo xtask header`: do not edit. MIT OR Apache-2.0.
 *
 * Conventions
 * - Names: cata_<chapter>_<what>; _f64 and _f32 (_c64 and _c32: complex) where there are several
 *   scalars.
 * - Results: a function that can fail returns a cata_status: CATA_OK (0), or the kind of error,
 *   which cata_last_error_message explains. After an error outputs are untouched, unless the
 *   function says otherwise. Functions that need a capability that this build lacks return
 *   CATA_ERR_UNSUPPORTED (cata_capabilities).
 * - Sizes are size_t, any, 0 included, and numbers of elements, never bytes.
 * - Pointers may be NULL only where the function says so, or where there is no element to point to.
 *   They are not kept after the call. An output that overlaps another one or an input is
 *   CATA_ERR_ARGUMENT.
 * - Matrices: `layout` is CATA_ROW_MAJOR or CATA_COL_MAJOR, for all matrices of a call. m x n
 *   elements at `a` are m rows (n columns) of n (m) elements, each `lda` >= max(1, n) (max(1, m))
 *   elements after the one before. What lies between is neither read nor written.
 * - Meshes: `n_vertices`, `vertices` (x, y, z of each: 3 n_vertices doubles, finite), `n_faces`,
 *   `faces` (three vertices of each: 3 n_faces uint32_t, from 0, counter-clockwise as seen from
 *   outside).
 * - Parameters: `params` is NULL for the defaults, or a struct whose first field is its sizeof;
 *   all others are 0 (NULL) by default, and 0 stands for the default: after `cata_ata_params
 *   params = {.struct_size = sizeof params};`, which is what cata_ata_params_init does, only what
 *   differs is set. Later versions add fields at the end; one that the library does not know must
 *   be 0. It is read during the call; a handle that is made keeps `progress` and `progress_user`
 *   for its own calls.
 * - Handles: where sizes of results follow from the arguments, results are written into arrays of
 *   the caller. Elsewhere, and where there is a state to keep, the call makes a handle, a pointer
 *   to an opaque struct, whose functions tell the sizes and copy the values. Each has a `_free`,
 *   to be called once, for which NULL does nothing.
 * - Threads: functions may be called from any thread, and at the same time, as long as no output
 *   is shared and nobody else uses a handle that a call takes without const. Each call uses up to
 *   `params.threads` threads, by default one for each core in the affinity mask of the process, or
 *   fewer where CATAMARAN_NUM_THREADS or RAYON_NUM_THREADS is set to a lower number. Their number
 *   changes no result, not by a bit. Calls at the same time share the threads of the process,
 *   which cata_threads_release ends.
 * - Rounding: numbers are rounded to nearest, and subnormal numbers are kept, whatever mode the
 *   calling thread has set (fesetround, flush-to-zero); it has the same mode after the call. So no
 *   result encloses an exact value. Progress callbacks and back ends run in the mode to nearest.
 */

#ifndef CATAMARAN_H
#define CATAMARAN_H

#include <stddef.h>
#include <stdint.h>
";

const OPENING: &str = "
#ifdef __cplusplus
extern \"C\" {
#endif // __cplusplus

";

const CLOSING: &str = "\
#ifdef __cplusplus
} // extern \"C\"
#endif // __cplusplus

#endif // CATAMARAN_H
";

fn version_macros() -> String {
    // xtask shares the version of the workspace.
    let parts = [
        ("MAJOR", env!("CARGO_PKG_VERSION_MAJOR")),
        ("MINOR", env!("CARGO_PKG_VERSION_MINOR")),
        ("PATCH", env!("CARGO_PKG_VERSION_PATCH")),
    ];
    let mut text = String::from("\n");
    for (part, number) in parts {
        text += &format!("#define CATA_VERSION_{part} {number} /**< Of this header. */\n");
    }
    let whole = env!("CARGO_PKG_VERSION");
    text + &format!("#define CATA_VERSION_STRING \"{whole}\" /**< Of this header. */\n")
}

#[cfg(test)]
mod tests {
    use super::tidied;

    #[test]
    fn comments_are_tidied() {
        let raw = "/**\n * One.\n */\n#define A 1\n\n/**\n * Two\n * lines.\n *\n * # Safety\n \
                   * Rust.\n */\nint f(void);\n";
        let tidy = "/** One. */\n#define A 1\n\n/** Two\n * lines. */\nint f(void);\n";
        assert_eq!(tidied(raw), tidy);
    }
}
