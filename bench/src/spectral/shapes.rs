//! The shapes, and the pairs of them.

use std::path::{Path, PathBuf};

use catamaran::mesh::{LaplacianOptions, Normalization, TriMesh, families, laplacian};
use catamaran::sparse::{CsMat, EigenOptions, eigs};
use catamaran::spectral::Eigenbasis;

use crate::Result;

/// A mesh of area 1 and its eigenpairs.
pub struct Shape {
    /// Its name.
    pub name: String,
    /// The mesh.
    pub mesh: TriMesh,
    /// The stiffness matrix of its Laplacian.
    pub stiffness: CsMat<f64>,
    /// Its first eigenfunctions, with the constant.
    pub eigenbasis: Eigenbasis,
}

impl Shape {
    /// The mesh, scaled to area 1, with `k` eigenfunctions beside the constant.
    ///
    /// # Errors
    /// Those of the library.
    pub fn new(name: &str, mesh: &TriMesh, k: usize) -> Result<Self> {
        let mesh = mesh.normalized(Normalization::UnitArea)?;
        let problem = laplacian(&mesh, &LaplacianOptions::default())?;
        let options = EigenOptions::new().k(k + 1);
        let pairs = eigs(problem.stiffness.view(), &problem.mass, &options)?;
        let eigenbasis = Eigenbasis::new(pairs.values, pairs.vectors, problem.mass)?;
        Ok(Self { name: name.into(), mesh, stiffness: problem.stiffness, eigenbasis })
    }

    /// The constant and the next `k` eigenfunctions.
    ///
    /// # Errors
    /// When there is not enough memory.
    pub fn first(&self, k: usize) -> Result<Eigenbasis> {
        Ok(self.eigenbasis.truncated(k + 1)?)
    }
}

/// Two shapes, and the vertex of the source that corresponds to each of the target.
pub struct Pair {
    /// From where functions come.
    pub source: Shape,
    /// Where they go.
    pub target: Shape,
    /// The true correspondence.
    pub truth: Vec<u32>,
}

/// Where real shapes are, if anywhere.
pub struct Shapes {
    folder: Option<PathBuf>,
}

impl Shapes {
    /// Those of CATAMARAN_DATA (default ../shared).
    pub fn new() -> Self {
        let data = crate::input::data_folder();
        let folder = data.join("meshes");
        Self { folder: folder.is_dir().then_some(folder) }
    }

    fn read(folder: &Path, name: &str) -> Result<TriMesh> {
        Ok(catamaran::mesh::io::read(&folder.join(name))?.mesh)
    }

    /// The shapes for approximation, of `k` eigenfunctions each.
    ///
    /// # Errors
    /// Those of the library.
    pub fn single(&self, k: usize) -> Result<Vec<Shape>> {
        let mut shapes = vec![Shape::new("figure", &families::figure(5, 0.5)?, k)?];
        let Some(folder) = &self.folder else { return Ok(shapes) };
        for (name, file) in [
            ("bunny", "ofp_bunny10k.off.gz"),
            ("man", "human_man.obj.gz"),
            ("woman", "human_woman.obj.gz"),
        ] {
            shapes.push(Shape::new(name, &Self::read(folder, file)?, k)?);
        }
        Ok(shapes)
    }

    /// Nearly isometric pairs with the same connections: poses of a figure.
    ///
    /// # Errors
    /// Those of the library.
    pub fn isometric(&self, k: usize) -> Result<Vec<Pair>> {
        let pose =
            |pose: f64| Shape::new(&format!("figure {pose}"), &families::figure(5, pose)?, k);
        let pair = |from: f64, to: f64| -> Result<Pair> {
            let (source, target) = (pose(from)?, pose(to)?);
            let truth = (0..target.mesh.vertices().len() as u32).collect();
            Ok(Pair { source, target, truth })
        };
        [(0.0, 0.5), (0.0, 1.0), (0.3, 0.9), (1.0, 0.6)]
            .map(|(a, b)| pair(a, b))
            .into_iter()
            .collect()
    }

    /// Pairs that are not isometric, with the same connections: two people, two surfaces of a brain; none without data.
    ///
    /// # Errors
    /// Those of the library.
    pub fn people(&self, k: usize) -> Result<Vec<Pair>> {
        let Some(folder) = &self.folder else { return Ok(Vec::new()) };
        let names = [
            ("human_man.obj.gz", "human_woman.obj.gz"),
            ("human_woman.obj.gz", "human_man.obj.gz"),
            ("fsaverage5_L_white.ply.gz", "fsaverage5_L_pial.ply.gz"),
            ("fsaverage5_L_pial.ply.gz", "fsaverage5_L_inflated.ply.gz"),
        ];
        let pair = |(source, target): (&str, &str)| -> Result<Pair> {
            let [source, target] =
                [source, target].map(|name| Shape::new(name, &Self::read(folder, name)?, k));
            let (source, target) = (source?, target?);
            let truth = (0..target.mesh.vertices().len() as u32).collect();
            Ok(Pair { source, target, truth })
        };
        names.into_iter().map(pair).collect()
    }

    /// Pairs with different connections: poses of figures of different fineness, which correspond where they are nearest in
    /// the same pose.
    ///
    /// # Errors
    /// Those of the library.
    pub fn remeshed(&self, k: usize) -> Result<Vec<Pair>> {
        let pair = |from: (usize, f64), to: (usize, f64)| -> Result<Pair> {
            let shape = |(cells, pose): (usize, f64)| {
                Shape::new(&format!("figure {cells} {pose}"), &families::figure(cells, pose)?, k)
            };
            let (source, target) = (shape(from)?, shape(to)?);
            let rest = |cells| families::figure(cells, 0.0);
            let truth = nearest(rest(from.0)?.vertices(), rest(to.0)?.vertices());
            Ok(Pair { source, target, truth })
        };
        let pairs = [
            ((5, 0.0), (7, 0.6)),
            ((7, 0.2), (4, 1.0)),
            ((4, 0.8), (6, 0.1)),
            ((6, 0.5), (5, 1.0)),
        ];
        pairs.into_iter().map(|(from, to)| pair(from, to)).collect()
    }
}

impl Default for Shapes {
    fn default() -> Self {
        Self::new()
    }
}

/// For each of `to` the index of the nearest of `from`.
fn nearest(from: &[[f64; 3]], to: &[[f64; 3]]) -> Vec<u32> {
    let square = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>();
    let index = |q: &[f64; 3]| {
        let distances = from.iter().map(|p| square(p, q)).enumerate();
        distances.min_by(|x, y| x.1.total_cmp(&y.1)).map_or(0, |(i, _)| i as u32)
    };
    to.iter().map(index).collect()
}
