//! The datasets that a file holds.

use std::path::Path;

use ::hdf5::{File, Group, LinkType, LocationType};

use super::access::fail;
use super::packing;
use crate::base::{Error, Result};
use crate::io::source::error;

/// Datasets named in an error.
const LISTED: usize = 20;

/// Returns the name of the only dataset of two dimensions.
pub(super) fn only(path: &Path, file: &File) -> Result<String> {
    let names = datasets(file).map_err(|e| fail(path, &e))?;
    let mut matrices = names.iter().filter(|name| file.dataset(name).is_ok_and(|d| d.ndim() == 2));
    match (matrices.next(), matrices.next()) {
        (Some(name), None) => Ok(name.clone()),
        (first, _) => {
            let count = if first.is_some() { "several datasets" } else { "no dataset" };
            let what = format!(
                "{count} of two dimensions, so name one ({}:/path/to/dataset); {}",
                path.file_name().unwrap_or_default().display(),
                listing(path, file)?
            );
            Err(error(path, None, what))
        }
    }
}

/// Returns the error for a name that is not that of a dataset.
pub(super) fn missing(path: &Path, file: &File, name: &str) -> Error {
    let what = match sparse(file, name) {
        Some(kind) => format!(
            "{name} is a sparse matrix ({kind}) in several datasets, which is not read: write it \
             as .mtx, or densely"
        ),
        None => format!("no dataset {name}"),
    };
    match listing(path, file) {
        Ok(listing) => error(path, None, format!("{what}; {listing}")),
        Err(e) => e,
    }
}

/// Returns who writes such a group for a sparse matrix, if it is one.
fn sparse(file: &File, name: &str) -> Option<String> {
    let group = file.group(name).ok()?;
    if group.attr("MATLAB_sparse").is_ok() {
        return Some("MATLAB".into());
    }
    let encoding = packing::text(&group.attr("encoding-type").ok()?)?;
    encoding.ends_with("_matrix").then(|| format!("{encoding} of AnnData"))
}

/// Returns the part of a message that lists the datasets of the file.
fn listing(path: &Path, file: &File) -> Result<String> {
    let names = datasets(file).map_err(|e| fail(path, &e))?;
    let described: Vec<String> = names
        .iter()
        .take(LISTED)
        .map(|name| {
            let shape = file.dataset(name).map(|dataset| {
                dataset.shape().iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
            });
            format!("{name} ({})", shape.unwrap_or_else(|_| "unreadable".into()))
        })
        .collect();
    Ok(match names.len() {
        0 => "the file has no datasets".into(),
        count if count > LISTED => {
            format!("the file has {}, and {} more", described.join(", "), count - LISTED)
        }
        _ => format!("the file has {}", described.join(", ")),
    })
}

/// Returns the names of all datasets that the file itself holds, sorted.
fn datasets(file: &File) -> ::hdf5::Result<Vec<String>> {
    let mut found = Vec::new();
    // Visited groups: groups may have several names, and may contain themselves.
    let mut seen = vec![file.loc_info_by_name("/")?.token];
    let mut waiting = vec![String::new()];
    while let Some(group) = waiting.pop() {
        let folder: Group = file.group(if group.is_empty() { "/" } else { &group })?;
        let mut names = Vec::new();
        folder.iter_visit_default(|name, link| {
            // Other links lead to objects that have a name already, out of the file, or nowhere.
            if link.link_type == LinkType::Hard {
                names.push(format!("{group}/{name}"));
            }
            Ok(())
        })?;
        for name in names {
            let about = file.loc_info_by_name(&name)?;
            match about.loc_type {
                LocationType::Dataset => found.push(name),
                LocationType::Group if about.num_links < 2 => waiting.push(name),
                LocationType::Group if !seen.contains(&about.token) => {
                    seen.push(about.token);
                    waiting.push(name);
                }
                _ => {}
            }
        }
    }
    found.sort_unstable();
    Ok(found)
}
