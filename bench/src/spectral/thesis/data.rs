//! The thesis' shapes, as far as two public repositories have them, in CATAMARAN_THESIS_DATA.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use catamaran::Par;
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::{TriMesh, io};
use catamaran_geometry::spectral::Lift;

use super::matlab;
use crate::Result;
use crate::spectral::shapes::{Pair, Shape};
use crate::spectral::signals::MANY;

/// Folders of the repositories llorz/SGA18_orientation_BCICP_dataset and
/// filthynobleman/orthogonalized-fourier-polynomial.
const BCICP: &str = "SGA18_orientation_BCICP_dataset";
const POLYNOMIALS: &str = "orthogonalized-fourier-polynomial";

/// Where the data are.
#[derive(Debug, Clone)]
pub struct Data {
    folder: PathBuf,
}

impl Data {
    /// Finds the data.
    ///
    /// # Errors
    /// When CATAMARAN_THESIS_DATA is not set, or has not the folders of both repositories.
    pub fn find() -> Result<Self> {
        let what = format!(
            "names a folder with clones of llorz/{BCICP} and filthynobleman/{POLYNOMIALS}, the \
             thesis' shapes, which may be used for research only"
        );
        let Some(folder) = std::env::var_os("CATAMARAN_THESIS_DATA").map(PathBuf::from) else {
            return Err(format!("CATAMARAN_THESIS_DATA is not set: it {what}").into());
        };
        for repository in [BCICP, POLYNOMIALS] {
            if !folder.join(repository).is_dir() {
                let named = folder.display();
                let why = format!("CATAMARAN_THESIS_DATA={named} has no {repository}: it {what}");
                return Err(why.into());
            }
        }
        Ok(Self { folder })
    }

    fn meshes(&self, path: &str) -> PathBuf {
        self.folder.join(POLYNOMIALS).join("Meshes").join(path)
    }

    fn set(&self, name: &str) -> PathBuf {
        self.folder.join(BCICP).join("Dataset").join(name)
    }

    /// Returns the path of a remeshed registration of FAUST, the person in tens and the pose in
    /// ones, with the vertices of about 5,000 points that all registrations have, and those of
    /// their mirror images.
    ///
    /// # Errors
    /// When a list of vertices can't be read.
    pub fn registration(&self, number: usize) -> Result<(PathBuf, [Vec<u32>; 2])> {
        let folder = self.set("FAUST").join("vtx_5k");
        let name = format!("tr_reg_{number:03}");
        let of = |ending| lines(&folder.join("corres").join(format!("{name}{ending}")));
        Ok((folder.join(format!("{name}.off")), [of(".vts")?, of(".sym.vts")?]))
    }

    /// Returns the pairs of the repository's list for this set of shapes.
    fn listed(&self, set: &str) -> Result<Vec<(String, String)>> {
        let path = self.set(set).join("test_pairs.txt");
        let text = read(&path, std::fs::read_to_string(&path))?;
        let pair = |line: &str| {
            let mut names = line.split_whitespace().map(String::from);
            Some((names.next()?, names.next()?))
        };
        Ok(text.lines().filter_map(pair).collect())
    }
}

/// Returns what was read, or an error with the path.
fn read<T, E: std::fmt::Display>(path: &Path, found: std::result::Result<T, E>) -> Result<T> {
    found.map_err(|error| format!("{}: {error}", path.display()).into())
}

/// Sets of pairs, each with the table of the thesis for which it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// Table 1.2.
    Tosca,
    /// Table 1.3.
    Faust,
    /// Table 1.4.
    Shrec,
    /// Table 1.4 again.
    Remeshed,
    /// In place of table 1.5.
    Animals,
    /// Table 1.6.
    Misc,
}

/// All sets, in the order of the tables.
pub const SETS: [Set; 6] =
    [Set::Tosca, Set::Faust, Set::Shrec, Set::Remeshed, Set::Animals, Set::Misc];

/// The correspondence of a pair.
enum Truth {
    /// Vertices with the same number.
    Same,
    /// The same lines of two files with numbers of vertices.
    Lines(PathBuf, PathBuf),
    /// The same entries of an array in two MATLAB files.
    Entries(PathBuf, PathBuf, &'static str),
    /// An array in a MATLAB file with a vertex of the source for each of the target.
    Matches(PathBuf, &'static str),
}

/// A pair that is not read yet.
pub struct Listed {
    source: PathBuf,
    target: PathBuf,
    truth: Truth,
}

impl Set {
    /// Says which pairs are taken.
    pub fn rule(self) -> &'static str {
        match self {
            Self::Tosca => {
                "TOSCA: all six ordered pairs of one class that the thesis' repository has, with \
                 one connectivity (centaur 2 and 4, horse 7 and 15, wolf 0 and 2), then the first \
                 pair of cat, david, dog and michael in the list of BCICP, remeshed to 5,000 \
                 vertices, at the vertices whose counterpart is known"
            }
            Self::Faust => {
                "FAUST: of the six registrations that the thesis' repository has, the first 20 \
                 ordered pairs of other people in other poses, every source in turn"
            }
            Self::Shrec => {
                "SHREC'19: the only pair that the thesis' repository has, 32 to 10, with its map; \
                 both decimated from 50,000 to 10,000 vertices"
            }
            Self::Remeshed => {
                "FAUST remeshed to 5,000 vertices, in place of more pairs of SHREC'19: every tenth \
                 of the last 100 pairs of the list of BCICP, which are of other people in other \
                 poses, at the vertices whose counterpart is known"
            }
            Self::Animals => {
                "animals of the thesis' repository in place of SHREC'20, which neither repository \
                 has: horse and camel of about 20,000 vertices, both ways, and elephant and horse, \
                 both ways, decimated from 40,000 to 10,000; 50 landmarks, each the farthest from \
                 those before it"
            }
            Self::Misc => {
                "MISC: ten pairs at equal distances in the list of BCICP (man, woman, gorilla; \
                 5,000 vertices), at all of about 880 known vertices"
            }
        }
    }

    /// Returns at most `most` pairs, fewer by leaving out the last ones.
    ///
    /// # Errors
    /// When a list of pairs can't be read.
    pub fn pairs(self, data: &Data, most: usize) -> Result<Vec<Listed>> {
        let mut pairs = match self {
            Self::Tosca => tosca(data)?,
            Self::Faust => faust(data),
            Self::Shrec => {
                let shape = |number: u32| data.meshes(&format!("SHREC/{number}.off"));
                let truth = Truth::Matches(data.meshes("SHREC/10_32.mat"), "gt_matches");
                vec![Listed { source: shape(32), target: shape(10), truth }]
            }
            Self::Remeshed => {
                let listed = data.listed("FAUST")?;
                let last = listed.iter().skip(listed.len().saturating_sub(100)).step_by(10);
                last.map(|names| remeshed(data, "FAUST", names)).collect()
            }
            Self::Animals => animals(data),
            Self::Misc => {
                let listed = data.listed("TOSCA_nonIsometric")?;
                let some = (0..10).filter_map(|i| listed.get(i * listed.len() / 10));
                some.map(|names| remeshed(data, "TOSCA_nonIsometric", names)).collect()
            }
        };
        pairs.truncate(most);
        Ok(pairs)
    }
}

/// Returns a pair of the BCICP repository.
fn remeshed(data: &Data, set: &str, (source, target): &(String, String)) -> Listed {
    let folder = data.set(set).join("vtx_5k");
    let shape = |name: &str| folder.join(format!("{name}.off"));
    let known = |name: &str| folder.join("corres").join(format!("{name}.vts"));
    let truth = Truth::Lines(known(source), known(target));
    Listed { source: shape(source), target: shape(target), truth }
}

fn tosca(data: &Data) -> Result<Vec<Listed>> {
    let shape = |name: &str| data.meshes(&format!("TOSCA/{name}.off"));
    let both = |[a, b]: [&str; 2]| {
        [(a, b), (b, a)].map(|(source, target)| Listed {
            source: shape(source),
            target: shape(target),
            truth: Truth::Same,
        })
    };
    let mut pairs: Vec<Listed> =
        [["centaur2", "centaur4"], ["horse7", "horse15"], ["wolf0", "wolf2"]]
            .into_iter()
            .flat_map(both)
            .collect();
    let listed = data.listed("TOSCA_Isometric")?;
    for class in ["cat", "david", "dog", "michael"] {
        if let Some(names) = listed.iter().find(|(source, _)| source.starts_with(class)) {
            pairs.push(remeshed(data, "TOSCA_Isometric", names));
        }
    }
    Ok(pairs)
}

/// Numbers of the registrations: the person in tens, the pose in ones.
const REGISTRATIONS: [u32; 6] = [0, 19, 20, 87, 93, 94];

fn faust(data: &Data) -> Vec<Listed> {
    let shape = |number: u32| data.meshes(&format!("tr_reg/tr_reg_{number:03}.ply"));
    faust_numbers()
        .into_iter()
        .map(|(a, b)| Listed { source: shape(a), target: shape(b), truth: Truth::Same })
        .collect()
}

/// Returns the pairs of other people in other poses; each shape is a source before any is one
/// again.
fn faust_numbers() -> Vec<(u32, u32)> {
    let count = REGISTRATIONS.len();
    let pair = |i: usize| {
        let (shift, place) = (1 + i / count, i % count);
        (REGISTRATIONS[place], REGISTRATIONS[(place + shift) % count])
    };
    let differ = |&(a, b): &(u32, u32)| a / 10 != b / 10 && a % 10 != b % 10;
    (0..count * (count - 1)).map(pair).filter(differ).take(20).collect()
}

fn animals(data: &Data) -> Vec<Listed> {
    let pairs = [
        ("Horse_camel/horse.mat", "Horse_camel/camel.mat"),
        ("Horse_camel/camel.mat", "Horse_camel/horse.mat"),
        ("Elephant_horse/elephant.mat", "Elephant_horse/horse.mat"),
        ("Elephant_horse/horse.mat", "Elephant_horse/elephant.mat"),
    ];
    let listed = |(a, b): (&str, &str)| {
        let (source, target) = (data.meshes(a), data.meshes(b));
        let truth = match a.starts_with("Horse") {
            true => Truth::Entries(source.clone(), target.clone(), "shape.cor"),
            false => Truth::Same,
        };
        Listed { source, target, truth }
    };
    pairs.map(listed).into()
}

/// Number of vertices above which a shape is decimated, and to which: the time of the points grows
/// with the square. The camel, with 22,000 vertices, is no manifold, so that a decimation cuts
/// single faces off.
const MOST: usize = 25_000;
const DECIMATED: usize = 10_000;

/// A shape, and how it represents the vertices of its file.
#[derive(Clone)]
struct Known {
    shape: Rc<Shape>,
    /// The number of vertices of the file.
    vertices: usize,
    lift: Option<Rc<Lift>>,
}

impl Known {
    /// Returns the vertex of the shape that is nearest to one of the file.
    fn nearest(&self, v: u32) -> u32 {
        self.lift.as_ref().map_or(v, |lift| lift.nearest()[v as usize])
    }
}

/// The shapes that were read.
#[derive(Default)]
pub struct Read(HashMap<PathBuf, Known>);

impl Read {
    /// Reads a pair; shapes that were read before are the same.
    ///
    /// # Errors
    /// When a file can't be read, or numbers are no vertices.
    pub fn pair(&mut self, listed: &Listed) -> Result<Pair> {
        let (source, target) = (self.shape(&listed.source)?, self.shape(&listed.target)?);
        let (n, m) = (source.vertices, target.vertices);
        let counterparts: Vec<(u32, u32)> = match &listed.truth {
            Truth::Same if n != m => {
                return Err(format!("{} has {m} vertices, not {n}", listed.target.display()).into());
            }
            Truth::Same => (0..m as u32).map(|v| (v, v)).collect(),
            Truth::Lines(a, b) => lines(a)?.into_iter().zip(lines(b)?).collect(),
            Truth::Entries(a, b, name) => {
                entries(a, name)?.into_iter().zip(entries(b, name)?).collect()
            }
            Truth::Matches(path, name) => entries(path, name)?.into_iter().zip(0..).collect(),
        };
        let named = |why: String| format!("{}: {why}", listed.target.display());
        let (mut truth, mut known) = of_target(&counterparts, (n, m)).map_err(named)?;
        if source.lift.is_some() || target.lift.is_some() {
            let moved: Vec<(u32, u32)> = match &target.lift {
                // The corner next to a vertex of the decimation is nearer than most of its cell.
                Some(lift) if known.len() == m => {
                    let at = |(y, v): (usize, u32)| (source.nearest(truth[v as usize]), y as u32);
                    lift.corners().into_iter().enumerate().map(at).collect()
                }
                _ => {
                    let at = |&y: &u32| (source.nearest(truth[y as usize]), target.nearest(y));
                    known.iter().map(at).collect()
                }
            };
            let sizes = [&source, &target].map(|known| known.shape.mesh.vertices().len());
            (truth, known) = of_target(&moved, (sizes[0], sizes[1])).map_err(named)?;
        }
        Ok(Pair { source: source.shape, target: target.shape, truth, known })
    }

    fn shape(&mut self, path: &Path) -> Result<Known> {
        if let Some(known) = self.0.get(path) {
            return Ok(known.clone());
        }
        let mesh = match path.extension().is_some_and(|extension| extension == "mat") {
            true => read(path, from_matlab(path))?,
            false => read(path, io::read(path))?.mesh,
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let vertices = mesh.vertices().len();
        let (mesh, lift) = match vertices > MOST {
            true => {
                let found = read(path, decimate(&mesh, DECIMATED, &DecimateOptions::new()))?;
                let lift = read(path, Lift::new(&mesh, &found, Par::all()))?;
                (found.mesh, Some(Rc::new(lift)))
            }
            false => (mesh, None),
        };
        let shape = Rc::new(read(path, Shape::new(&name, &mesh, MANY))?);
        let known = Known { shape, vertices, lift };
        self.0.insert(path.into(), known.clone());
        Ok(known)
    }
}

/// Returns for each of m vertices of the target that of the source, 0 where there is none, and the
/// vertices that have one; of several counterparts the first.
fn of_target(
    counterparts: &[(u32, u32)],
    (n, m): (usize, usize),
) -> std::result::Result<(Vec<u32>, Vec<u32>), String> {
    let mut places = vec![None; m];
    for &(x, y) in counterparts {
        if x as usize >= n || y as usize >= m {
            return Err(format!("{x} and {y} are no vertices of meshes of {n} and {m}"));
        }
        places[y as usize].get_or_insert(x);
    }
    let known = (0..m as u32).filter(|&y| places[y as usize].is_some()).collect();
    Ok((places.into_iter().map(Option::unwrap_or_default).collect(), known))
}

/// Returns the numbers of a file, from 1 there and from 0 here.
fn lines(path: &Path) -> Result<Vec<u32>> {
    let text = read(path, std::fs::read_to_string(path))?;
    let number = |word: &str| word.parse::<u32>().ok()?.checked_sub(1);
    let numbers: Option<Vec<u32>> = text.split_whitespace().map(number).collect();
    read(path, numbers.ok_or("is no list of numbers of vertices from 1"))
}

/// Returns the numbers of an array, from 1 there and from 0 here.
fn entries(path: &Path, name: &str) -> Result<Vec<u32>> {
    let found = read(path, matlab::arrays(&read(path, std::fs::read(path))?))?;
    let numbers = found.into_iter().find(|(other, _)| other == name);
    let numbers = read(path, numbers.ok_or(format!("has no array {name}")))?.1;
    Ok(numbers.into_iter().map(|number| number as u32 - 1).collect())
}

/// Returns the mesh of a MATLAB file with `shape.X`, `shape.Y`, `shape.Z` and `shape.TRIV`.
fn from_matlab(path: &Path) -> Result<TriMesh> {
    let found: HashMap<String, Vec<f64>> =
        matlab::arrays(&std::fs::read(path)?)?.into_iter().collect();
    let part = |name: &str| found.get(name).ok_or(format!("has no array {name}"));
    let [x, y, z] = [part("shape.X")?, part("shape.Y")?, part("shape.Z")?];
    let faces = part("shape.TRIV")?;
    let count = faces.len() / 3;
    let corner = |i: usize, k: usize| (faces[k * count + i] as u32).wrapping_sub(1);
    let faces = (0..count).map(|i| [0, 1, 2].map(|k| corner(i, k))).collect();
    let points = x.iter().zip(y).zip(z).map(|((&x, &y), &z)| [x, y, z]).collect();
    Ok(TriMesh::new(points, faces)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_pairs_of_faust_are_of_other_people_in_other_poses() {
        let pairs = faust_numbers();
        assert_eq!(pairs.len(), 20);
        assert!(pairs.iter().all(|(a, b)| a / 10 != b / 10 && a % 10 != b % 10));
        assert!((0..20).all(|i| (0..i).all(|j| pairs[i] != pairs[j])));
        for number in REGISTRATIONS {
            assert!(pairs.iter().filter(|pair| pair.0 == number).count() >= 3);
        }
    }

    #[test]
    fn the_first_counterpart_counts_and_others_are_unknown() {
        let found = of_target(&[(4, 1), (3, 1), (0, 2)], (5, 4)).unwrap();
        assert_eq!(found, (vec![0, 4, 0, 0], vec![1, 2]));
        assert!(of_target(&[(5, 0)], (5, 4)).is_err());
        assert!(of_target(&[(0, 4)], (5, 4)).is_err());
    }
}
