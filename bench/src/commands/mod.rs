//! The commands, and what they share: who takes part.

pub mod accuracy;
pub mod exact;
pub mod race;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use catamaran::blas::{self, Backend};
use catamaran_bench::Result;
use catamaran_bench::contender::Contender;
use catamaran_bench::library::{Rival, find};

/// The rival called `name`: faer, a library that is found by its name, or NAME=PATH.
fn rival(name: &str, libraries: &Path) -> Result<Contender> {
    Ok(match name {
        "faer" => Contender::Faer,
        name => Contender::Cblas { rival: Arc::new(load(name, libraries)?), routine: None },
    })
}

/// The back end called `name`, and its name without a path: gemm, or a library as in [`rival`].
fn backend(name: &str, libraries: &Path) -> Result<(String, Arc<dyn Backend>)> {
    if name == "gemm" {
        return Ok((name.to_owned(), blas::native()));
    }
    // Loaded as a rival first: who loads a library first decides how it is bound.
    let rival = load(name, libraries)?;
    Ok((rival.name, blas::load(&rival.path)?))
}

fn load(name: &str, libraries: &Path) -> Result<Rival> {
    let (name, path) = match name.split_once('=') {
        Some((name, path)) => (name, Some(PathBuf::from(path))),
        None => (name, find(name, libraries)),
    };
    let path = path.ok_or_else(|| {
        format!("{name}: not found; run scripts/rivals, or give NAME=PATH of the library")
    })?;
    Rival::load(name, &path)
}

/// The libraries among the contenders.
fn libraries_of(contenders: &[Contender]) -> Vec<&Rival> {
    contenders
        .iter()
        .filter_map(|c| match c {
            Contender::Cblas { rival, .. } => Some(rival.as_ref()),
            _ => None,
        })
        .collect()
}

/// Whom ratios refer to: MKL, else the first rival, else the first.
fn yardstick(contenders: &[Contender]) -> usize {
    let place = |wanted: &dyn Fn(&Contender) -> bool| contenders.iter().position(wanted);
    place(&|c| c.to_string() == "mkl").or_else(|| place(&Contender::is_rival)).unwrap_or(0)
}
