//! The shapes, and pairs of shapes.

use std::path::PathBuf;
use std::rc::Rc;

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::Mat;
use catamaran::sparse::{CsMat, EigenOptions, eigs};
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::{
    Components, LaplacianOptions, Normalization, SurfacePoint, TriMesh, families, laplacian,
};
use catamaran_geometry::spectral::Eigenbasis;
use catamaran_geometry::spectral::functional_map::nearest_rows;

use super::functions::geodesic_cells;
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
    /// Creates a shape from a mesh, scaled to area 1, with `k` eigenfunctions besides the constant.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn new(name: &str, mesh: &TriMesh, k: usize) -> Result<Self> {
        let mesh = mesh.normalized(Normalization::UnitArea)?;
        let problem = laplacian(&mesh, &LaplacianOptions::default())?;
        let options = EigenOptions::new().k(k + 1);
        let pairs = eigs(problem.stiffness.view(), &problem.mass, &options)?;
        let eigenbasis = Eigenbasis::new(pairs.values, pairs.vectors, problem.mass)?;
        Ok(Self { name: name.into(), mesh, stiffness: problem.stiffness, eigenbasis })
    }

    /// Returns the constant and the next `k` eigenfunctions.
    ///
    /// # Errors
    /// When there is not enough memory.
    pub fn first(&self, k: usize) -> Result<Eigenbasis> {
        Ok(self.eigenbasis.truncated(k + 1)?)
    }
}

/// Two shapes, and for each vertex of the target the corresponding vertex of the source.
pub struct Pair {
    /// The shape from which functions are transferred.
    pub source: Rc<Shape>,
    /// The shape to which functions are transferred.
    pub target: Rc<Shape>,
    /// The true correspondence.
    pub truth: Vec<u32>,
    /// The vertices of the target that have a counterpart on the source: all, unless parts are
    /// missing.
    pub known: Vec<u32>,
}

impl Pair {
    fn new(source: &Rc<Shape>, target: &Rc<Shape>, truth: Vec<u32>) -> Self {
        let known = (0..truth.len() as u32).collect();
        Self { source: source.clone(), target: target.clone(), truth, known }
    }

    /// Creates a pair in which vertices with the same index correspond.
    fn same(source: &Rc<Shape>, target: &Rc<Shape>) -> Self {
        Self::new(source, target, (0..target.mesh.vertices().len() as u32).collect())
    }

    /// Returns vertices of the target with a known counterpart, each the farthest from the previous
    /// ones.
    pub fn samples(&self, count: usize) -> Vec<u32> {
        let points = self.target.mesh.vertices();
        let mut far = vec![f64::INFINITY; self.known.len()];
        let mut next = 0;
        let mut found = Vec::new();
        while found.len() < count.min(self.known.len()) {
            let last = points[self.known[next] as usize];
            found.push(self.known[next]);
            for (distance, &v) in far.iter_mut().zip(&self.known) {
                *distance = distance.min(square(&points[v as usize], &last));
            }
            let farthest =
                (0..far.len()).max_by(|&x, &y| far[x].total_cmp(&far[y]).then(y.cmp(&x)));
            next = farthest.unwrap_or(0);
        }
        found
    }
}

/// A pair of meshes of the same surface: the original, and one with fewer vertices and another
/// connectivity.
struct Remeshed {
    shape: Rc<Shape>,
    /// For each vertex of the remeshed surface, the nearest vertex of the original.
    original: Vec<u32>,
    /// For each vertex of the original, the nearest vertex of the remeshed surface, along edges.
    nearest: Vec<u32>,
}

impl Remeshed {
    fn new(of: &Shape, vertices: usize, k: usize) -> Result<Self> {
        let found = decimate(&of.mesh, vertices, &DecimateOptions::new())?;
        let corner = |place: &SurfacePoint| of.mesh.faces()[place.face as usize][place.heaviest()];
        let original = found.places.iter().map(corner).collect();
        let nearest = found.cells.of_vertices().to_vec();
        let shape = Rc::new(Shape::new(&format!("{} {vertices}", of.name), &found.mesh, k)?);
        Ok(Self { shape, original, nearest })
    }

    /// Returns the pair from this mesh to a shape that corresponds to the original by index.
    fn to(&self, target: &Rc<Shape>) -> Pair {
        Pair::new(&self.shape, target, self.nearest.clone())
    }

    /// Returns the pair from a shape that corresponds to the original by index to this mesh.
    fn from(&self, source: &Rc<Shape>) -> Pair {
        Pair::new(source, &self.shape, self.original.clone())
    }
}

/// Number of vertices of a mesh with another connectivity.
const FEWER: usize = 4000;

/// Share of the area that a part lacks.
const MISSING: f64 = 0.15;

/// The source of real shapes, if there are any.
pub struct Shapes {
    folder: Option<PathBuf>,
    /// Whether to use only the first shape and pair of each kind.
    quick: bool,
}

impl Shapes {
    /// Creates the shapes of CATAMARAN_DATA (default ../shared), with only the first one of each
    /// kind if `quick`.
    pub fn new(quick: bool) -> Self {
        let data = crate::input::data_folder();
        let folder = data.join("meshes");
        Self { folder: folder.is_dir().then_some(folder), quick }
    }

    fn read(&self, name: &str, file: &str, k: usize) -> Result<Rc<Shape>> {
        let folder = self.folder.as_ref().ok_or("CATAMARAN_DATA is missing")?;
        let mesh = catamaran_geometry::mesh::io::read(&folder.join(file))?.mesh;
        Ok(Rc::new(Shape::new(name, &mesh, k)?))
    }

    fn some<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        if self.quick { &all[..1] } else { all }
    }

    /// Returns the shapes for approximation, with `k` eigenfunctions each.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn single(&self, k: usize) -> Result<Vec<Rc<Shape>>> {
        let mut shapes = vec![Rc::new(Shape::new("figure", &families::figure(5, 0.5)?, k)?)];
        if self.folder.is_none() || self.quick {
            return Ok(shapes);
        }
        for (name, file) in [("bunny", BUNNY), ("man", MAN), ("woman", WOMAN)] {
            shapes.push(self.read(name, file, k)?);
        }
        Ok(shapes)
    }

    /// Returns two shapes with fine details, a statue and an animal, with `k` eigenfunctions each;
    /// none without data or if quick.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn detailed(&self, k: usize) -> Result<Vec<Rc<Shape>>> {
        if self.folder.is_none() || self.quick {
            return Ok(Vec::new());
        }
        let files = [("statue", "nefertiti35k.obj.gz"), ("elephant", "refined_elephant44k.off.gz")];
        files.into_iter().map(|(name, file)| self.read(name, file, k)).collect()
    }

    /// Returns nearly isometric pairs with the same connectivity: poses of a figure.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn isometric(&self, k: usize) -> Result<Vec<Pair>> {
        let poses: Vec<_> = [0.0, 0.3, 0.5, 0.6, 0.9, 1.0]
            .map(|pose| figure(5, pose, k))
            .into_iter()
            .collect::<Result<_>>()?;
        let pairs =
            [(0, 2), (0, 5), (1, 4), (1, 5), (2, 0), (2, 4), (3, 1), (4, 0), (5, 3), (5, 1)];
        Ok(self.some(&pairs).iter().map(|&(a, b)| Pair::same(&poses[a], &poses[b])).collect())
    }

    /// Returns two people with the same connectivity, in both directions; none without data.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn people(&self, k: usize) -> Result<Vec<Pair>> {
        if self.folder.is_none() {
            return Ok(Vec::new());
        }
        let (man, woman) = (self.read("man", MAN, k)?, self.read("woman", WOMAN, k)?);
        let pairs = [(&man, &woman), (&woman, &man)];
        Ok(self.some(&pairs).iter().map(|(a, b)| Pair::same(a, b)).collect())
    }

    /// Returns all pairs of surfaces of a brain, with the same connectivity; none without data.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn brains(&self, k: usize) -> Result<Vec<Pair>> {
        if self.folder.is_none() {
            return Ok(Vec::new());
        }
        let surfaces = self.surfaces(k)?;
        let each = surfaces.iter().flat_map(|a| surfaces.iter().map(move |b| (a, b)));
        let pairs: Vec<_> = each.filter(|(a, b)| !Rc::ptr_eq(a, b)).collect();
        Ok(self.some(&pairs).iter().map(|(a, b)| Pair::same(a, b)).collect())
    }

    /// Returns surfaces of a brain: white, pial, inflated, sphere.
    fn surfaces(&self, k: usize) -> Result<Vec<Rc<Shape>>> {
        let surface = |name: &str| self.read(name, &format!("fsaverage5_L_{name}.ply.gz"), k);
        ["white", "pial", "inflated", "sphere"].into_iter().map(surface).collect()
    }

    /// Returns pairs with different connectivity: poses of figures of different resolution, whose
    /// correspondence is the nearest vertex in the same pose; with data, people and surfaces of a
    /// brain, one of each pair decimated.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn remeshed(&self, k: usize) -> Result<Vec<Pair>> {
        let pairs = [
            ((5, 0.0), (7, 0.6)),
            ((7, 0.2), (4, 1.0)),
            ((4, 0.8), (6, 0.1)),
            ((6, 0.5), (5, 1.0)),
        ];
        let mut pairs: Vec<Pair> = self
            .some(&pairs)
            .iter()
            .map(|&(from, to)| figures(from, to, k))
            .collect::<Result<_>>()?;
        if self.folder.is_some() && !self.quick {
            let (man, woman) = (self.read("man", MAN, k)?, self.read("woman", WOMAN, k)?);
            let (few, fewer) = (Remeshed::new(&man, FEWER, k)?, Remeshed::new(&woman, FEWER, k)?);
            pairs.extend([few.to(&woman), few.from(&woman), fewer.to(&man), fewer.from(&man)]);
            let surfaces = self.surfaces(k)?;
            let [white, pial] = [&surfaces[0], &surfaces[1]];
            pairs.push(Remeshed::new(white, FEWER, k)?.from(pial));
            pairs.push(Remeshed::new(pial, FEWER, k)?.from(white));
        }
        Ok(pairs)
    }

    /// Returns replacements for the animals of SHREC'20: one pair for each of its five sets, from
    /// the most to the least isometric, and one whose source lacks a part; all with different
    /// connectivity. None without data.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn graded(&self, k: usize) -> Result<Vec<Pair>> {
        if self.folder.is_none() {
            return Ok(Vec::new());
        }
        let mut pairs = vec![figures((5, 0.2), (6, 0.9), k)?];
        let (man, woman) = (self.read("man", MAN, k)?, self.read("woman", WOMAN, k)?);
        let fewer = Remeshed::new(&woman, FEWER, k)?;
        if self.quick {
            pairs = vec![without_part(&fewer.from(&man), k)?];
        } else {
            let surfaces = self.surfaces(k)?;
            pairs.push(fewer.from(&man));
            pairs.push(Remeshed::new(&surfaces[1], FEWER, k)?.from(&surfaces[0]));
            pairs.push(Remeshed::new(&surfaces[2], FEWER, k)?.from(&surfaces[1]));
            pairs.push(without_part(&fewer.from(&man), k)?);
        }
        Ok(pairs)
    }

    /// Returns replacements for the woman, man and gorilla of MISC: two people with different
    /// connectivity, and surfaces of a brain that are far from isometric. None without data.
    ///
    /// # Errors
    /// The errors of the library.
    pub fn distant(&self, k: usize) -> Result<Vec<Pair>> {
        if self.folder.is_none() {
            return Ok(Vec::new());
        }
        let (man, woman) = (self.read("man", MAN, k)?, self.read("woman", WOMAN, k)?);
        let fewer = Remeshed::new(&woman, FEWER, k)?;
        let mut pairs = vec![fewer.from(&man), fewer.to(&man)];
        if self.quick {
            pairs.truncate(1);
            return Ok(pairs);
        }
        let s = self.surfaces(k)?;
        let far = [(0, 2), (0, 3), (1, 2), (1, 3), (2, 0), (2, 1), (3, 0), (3, 1)];
        pairs.extend(far.map(|(a, b)| Pair::same(&s[a], &s[b])));
        Ok(pairs)
    }
}

const BUNNY: &str = "ofp_bunny10k.off.gz";
const MAN: &str = "human_man.obj.gz";
const WOMAN: &str = "human_woman.obj.gz";

fn figure(cells: usize, pose: f64, k: usize) -> Result<Rc<Shape>> {
    let name = format!("figure {cells} {pose}");
    Ok(Rc::new(Shape::new(&name, &families::figure(cells, pose)?, k)?))
}

/// Returns two figures, each with this number of cells and in this pose.
fn figures(from: (usize, f64), to: (usize, f64), k: usize) -> Result<Pair> {
    let (source, target) = (figure(from.0, from.1, k)?, figure(to.0, to.1, k)?);
    let rest = |cells| families::figure(cells, 0.0);
    let truth = nearest_vertices(&rest(from.0)?, &rest(to.0)?)?;
    Ok(Pair::new(&source, &target, truth))
}

/// Returns the pair without a geodesic cell of its source.
fn without_part(pair: &Pair, k: usize) -> Result<Pair> {
    let mesh = &pair.source.mesh;
    let cell = geodesic_cells(mesh, MISSING, 1, 4)?;
    let missing = |v: u32| cell[(v as usize, 0)] > 0.0;
    let faces = mesh.faces().iter().enumerate();
    let kept: Vec<u32> =
        faces.filter(|(_, f)| !f.iter().any(|&v| missing(v))).map(|(i, _)| i as u32).collect();
    let part = mesh.submesh(&kept)?;
    // The cell may separate small pieces.
    let components = Components::new(&part.mesh);
    let faces = |c: usize| components.of_faces().iter().filter(|f| **f as usize == c).count();
    let largest = (0..components.len()).max_by_key(|&c| faces(c)).unwrap_or(0);
    let piece = part.mesh.component(&components, largest)?;
    let source = Rc::new(Shape::new(&format!("part of {}", pair.source.name), &piece.mesh, k)?);
    let mut places = vec![None; mesh.vertices().len()];
    for (place, &v) in piece.vertices.iter().enumerate() {
        places[part.vertices[v as usize] as usize] = Some(place as u32);
    }
    let kept = |y: &u32| places[pair.truth[*y as usize] as usize].is_some();
    let known = (0..pair.truth.len() as u32).filter(kept).collect();
    // Missing vertices have no counterpart, and no error is measured there.
    let truth = pair.truth.iter().map(|&x| places[x as usize].unwrap_or(0)).collect();
    Ok(Pair { source, target: pair.target.clone(), truth, known })
}

fn square(p: &[f64; 3], q: &[f64; 3]) -> f64 {
    (0..3).map(|i| (p[i] - q[i]).powi(2)).sum()
}

/// Returns for each vertex of `to` the nearest vertex of `from`, the first of equally near ones.
///
/// # Errors
/// When `from` has no vertices.
pub fn nearest_vertices(from: &TriMesh, to: &TriMesh) -> Result<Vec<u32>> {
    let points =
        |mesh: &TriMesh| Mat::from_fn(mesh.vertices().len(), 3, |i, k| mesh.vertices()[i][k]);
    let (queries, candidates) = (points(to), points(from));
    let par = Par::all();
    Ok(nearest_rows(queries.as_ref(), candidates.as_ref(), par, Progress::none())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_keeps_true_places_and_samples_are_where_they_are_known() {
        let [source, target] = [0.0, 0.3].map(|pose| figure(2, pose, 5).unwrap());
        let pair = Pair::same(&source, &target);
        let part = without_part(&pair, 5).unwrap();
        assert_eq!(part.known.len(), part.source.mesh.vertices().len());
        assert!(part.known.len() < 9 * pair.known.len() / 10);
        // The part is translated and scaled only, so all distances have the same ratio.
        let first = part.known[0];
        let apart = |mesh: &TriMesh, v: u32, w: u32| {
            square(&mesh.vertices()[v as usize], &mesh.vertices()[w as usize]).sqrt()
        };
        let scale = |&y: &u32| {
            let place = |y: u32| part.truth[y as usize];
            apart(&part.source.mesh, place(y), place(first)) / apart(&source.mesh, y, first)
        };
        let scales: Vec<f64> = part.known[1..].iter().map(scale).collect();
        assert!(scales[0] > 1.0);
        assert!(scales.iter().all(|scale| (scale / scales[0] - 1.0).abs() < 1e-9));
        let mut samples = part.samples(20);
        assert!(samples.iter().all(|y| part.known.contains(y)));
        samples.sort_unstable();
        samples.dedup();
        assert_eq!(samples.len(), 20);
        assert_eq!(part.samples(usize::MAX).len(), part.known.len());
    }

    #[test]
    fn a_decimated_mesh_corresponds_either_way() {
        let [source, target] = [0.0, 0.3].map(|pose| figure(3, pose, 5).unwrap());
        let n = source.mesh.vertices().len();
        let fewer = Remeshed::new(&source, n / 2, 5).unwrap();
        let (to, from) = (fewer.to(&target), fewer.from(&target));
        assert_eq!((to.truth.len(), from.truth.len()), (n, n / 2));
        // Mapping there and back leads to a near vertex, because a cell has few vertices.
        let points = source.mesh.vertices();
        let apart =
            |v: usize| square(&points[v], &points[from.truth[to.truth[v] as usize] as usize]);
        let mean = (0..n).map(|v| apart(v).sqrt()).sum::<f64>() / n as f64;
        assert!(mean < 0.03, "{mean}");
    }
}
