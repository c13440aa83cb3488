//! The sets of meshes for races.

use super::Contender;

/// A set of meshes of `CATAMARAN_DATA`, each with numbers of vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Set {
    /// The meshes for which the bars are set.
    Bars,
    /// Meshes of at most 131,000 vertices as programs export them: CAD with slivers, scans,
    /// isosurfaces, surfaces split along texture seams, edges of many faces; each to 500, 2000 and
    /// 5000 vertices.
    Varied,
}

/// The meshes of [`Set::Bars`].
const BARS: [(&str, usize); 4] = [
    ("armadillo43k.obj.gz", 5000),
    ("mni152_wm317k.ply.xz", 10_000),
    ("srtm_n44w072_1p44M.ply.xz", 10_000),
    ("mni152_wm1p24M.ply.xz", 50_000),
];

/// The meshes of [`Set::Varied`].
const VARIED: [&str; 25] = [
    "vase.stl.gz",
    "conrod.stl.gz",
    "adis16480_slivers.stl.gz",
    "counter42k.stl.gz",
    "blade.off.gz",
    "cheese_genus133.off.gz",
    "sword_quads.obj.gz",
    "inspired_quads_multiline.off.gz",
    "suzanne_499components.ply.gz",
    "office_chair_degenerate.obj.gz",
    "chair_9545_nonmanifold.obj.gz",
    "cycloidal_nonmanifold.ply.gz",
    "human_man.obj.gz",
    "human_woman.obj.gz",
    "quadknot.obj.gz",
    "spot.obj.gz",
    "ofp_bunny10k.off.gz",
    "fsaverage5_L_pial.ply.gz",
    "fsaverage5_L_white.ply.gz",
    "mountain26k.obj.gz",
    "lionstatue32k.obj.gz",
    "nefertiti35k.obj.gz",
    "armadillo43k.obj.gz",
    "refined_elephant44k.off.gz",
    "mni152_t1_head131k.ply.xz",
];

/// The numbers of vertices of [`Set::Varied`].
const SIZES: [usize; 3] = [500, 2000, 5000];

/// Contenders that finish on a million vertices within a minute.
const FAST: [Contender; 5] = [
    Contender::Ours,
    Contender::Thesis,
    Contender::Pyacvd,
    Contender::FastSimplification,
    Contender::Meshoptimizer,
];

/// A contender of each kind.
const KINDS: [Contender; 5] = [
    Contender::Ours,
    Contender::Pyacvd,
    Contender::Meshoptimizer,
    Contender::Qslim,
    Contender::Pymeshlab,
];

/// Number of vertices from which on only the [`FAST`] contenders run.
const MANY: usize = 500_000;

impl Set {
    /// Returns the file names of the meshes, each with its numbers of vertices.
    pub fn meshes(self) -> Vec<(&'static str, Vec<usize>)> {
        match self {
            Self::Bars => BARS.map(|(file, n)| (file, vec![n])).into(),
            Self::Varied => VARIED.map(|file| (file, SIZES.to_vec())).into(),
        }
    }

    /// Returns the default contenders for a mesh of this number of vertices.
    pub fn contenders(self, vertices: usize) -> &'static [Contender] {
        match self {
            Self::Bars if vertices > MANY => &FAST,
            Self::Bars => &Contender::ALL,
            Self::Varied => &KINDS,
        }
    }
}
