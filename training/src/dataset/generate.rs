//! Generates data sets shape by shape. Finished shapes are stored in a folder until the data set is
//! complete.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::base::{Pin, Progress, ThreadPool};
use catamaran::io::{Array, ArraysWriter, Output, Overwrite, read_arrays};
use catamaran::sparse::{EigenOptions, eigs};
use catamaran::{Error, Par, Result, faer::MatRef};
use catamaran_geometry::mesh::{LaplacianOptions, TriMesh, laplacian, vertex_areas};
use catamaran_geometry::unions::PartSpectra;
use rayon::prelude::*;

use super::plan::{DatasetOptions, HeldOut, Job, Parts, jobs};
use super::{Dataset, EIGENVALUES, Spectrum, TRAIN, Template, WORD, packed};
use crate::cuts::{Cuts, Pair, cuts};
use crate::families::{Family, Model, mixed};
use crate::remesh::remove_vertices;

/// Number of eigenfunctions of a template.
const EIGENFUNCTIONS: usize = 128;

/// Smallest number of interior vertices of a part.
const INSIDE: usize = 40;

/// Share of the vertices that are removed from remeshed shapes.
const REMOVED: f64 = 0.3;

/// The file with the options that the shapes in its folder belong to.
const OPTIONS: &str = "options.txt";

/// Generates a data set. Finished shapes are stored in `folder`, which is created if it does not
/// exist; another call with the same options continues from there. When the data set is written,
/// the caller has to call [`remove_shapes`]. The same options give the same data set for any number
/// of threads.
///
/// # Errors
/// [`Error::Argument`] for sizes out of range; [`Error::Io`] when the folder belongs to other
/// options, or has other files, or can't be written; [`Error::Cancelled`]. After an error, a folder
/// without shapes is removed.
pub fn generate(
    options: &DatasetOptions,
    folder: &Path,
    par: Par,
    progress: Progress<'_>,
) -> Result<Dataset> {
    options.check()?;
    prepare(folder, &format!("{options:?}\n"))?;
    let generated = generate_in(options, folder, par, progress);
    if generated.is_err() && is_unused(folder).is_ok_and(|unused| unused) {
        // Options that are refused must not refuse others. The first error is the one to report.
        let _ = remove_shapes(folder);
    }
    generated
}

/// Returns whether a folder has nothing but options, and files that a killed program has begun.
fn is_unused(folder: &Path) -> Result<bool> {
    let unfinished = unfinished(folder)?;
    let is_left = |path: &PathBuf| path.ends_with(OPTIONS) || unfinished.contains(path);
    Ok(names(folder)?.iter().all(is_left))
}

/// Removes what [`generate`] has stored in `folder`: the finished shapes and the options. Then
/// removes the folder, unless it has other files. Returns whether the folder is removed.
///
/// # Errors
/// [`Error::Io`] when a file can't be removed.
pub fn remove_shapes(folder: &Path) -> Result<bool> {
    let failed = |path: &Path, e: std::io::Error| Error::io(path, e);
    for path in shapes(folder)?.into_iter().chain(unfinished(folder)?) {
        fs::remove_file(&path).map_err(|e| failed(&path, e))?;
    }
    // The options come last: they say whose shapes an interrupted removal leaves.
    let options = folder.join(OPTIONS);
    fs::remove_file(&options).map_err(|e| failed(&options, e))?;
    let is_empty = names(folder)?.is_empty();
    if is_empty {
        fs::remove_dir(folder).map_err(|e| failed(folder, e))?;
    }
    Ok(is_empty)
}

/// Generates a data set in a folder with its options.
fn generate_in(
    options: &DatasetOptions,
    folder: &Path,
    par: Par,
    progress: Progress<'_>,
) -> Result<Dataset> {
    let jobs = jobs(options);
    let subjects = subjects(options, &jobs, par)?;
    let done = AtomicUsize::new(0);
    let one = |(number, job): (usize, &Job)| {
        let found = shape(options, job, number, subjects.get(job.family.number()), folder);
        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
        progress.report(done as f64 / jobs.len() as f64)?;
        found
    };
    let team = ThreadPool::new(par.threads(), Pin::No)?;
    let shapes: Vec<Found> =
        team.run(|| jobs.par_iter().enumerate().map(one).collect::<Result<_>>())?;
    let mut dataset = Dataset::default();
    for subject in &subjects {
        let own = jobs.iter().zip(&shapes).filter(|(job, _)| job.family == subject.model.family());
        dataset.templates.push(template(subject, own.map(|(_, found)| found), par)?);
    }
    for (job, found) in jobs.iter().zip(&shapes) {
        add(&mut dataset, options, job, subjects.get(job.family.number()), found);
    }
    Ok(dataset)
}

/// A family with its cuts.
struct Subject {
    model: Model,
    cuts: Cuts,
    held_out: HeldOut,
}

fn subjects(options: &DatasetOptions, jobs: &[Job], par: Par) -> Result<Vec<Subject>> {
    let used = |family: &Family| jobs.iter().any(|job| job.family == *family);
    let one = |family: Family| {
        let model = Model::new(family, options.vertices)?;
        let own = crate::cuts::CutOptions {
            seed: mixed(&[options.seed, options.cuts.seed, family as u64]),
            ..options.cuts
        };
        let cuts = cuts(&model, &own, par)?;
        let mut held_out = HeldOut::new(&cuts, family, options.seed);
        let fresh = |job: &&Job| job.family == family && job.parts == Parts::Fresh && !job.remeshed;
        for job in jobs.iter().filter(fresh) {
            held_out.test_with(&crate::cuts::cuts(&model, &options.own_cuts(job), par)?);
        }
        Ok(Subject { model, cuts, held_out })
    };
    // Pairs that are used come first.
    Family::TEMPLATED.into_iter().filter(used).map(one).collect()
}

/// The results for a shape.
struct Found {
    pairs: Vec<Pair>,
    /// Ids of the masks, ascending.
    masks: Vec<usize>,
    /// The masks packed into words, as in [`Template`]; empty if they are those of the family.
    mask_words: Vec<usize>,
    /// Spectra of all masks, then of the complete shape.
    spectra: Vec<Spectrum>,
    areas: Vec<f64>,
}

impl Found {
    fn number(&self, id: usize) -> usize {
        self.masks.partition_point(|&mask| mask < id)
    }

    fn spectrum(&self, id: usize) -> Spectrum {
        self.spectra[self.number(id)]
    }

    fn area(&self, id: usize) -> f64 {
        self.areas[self.number(id)]
    }
}

/// Creates the folder if necessary, and checks that it belongs to these options.
fn prepare(folder: &Path, options: &str) -> Result<()> {
    let name = folder.join(OPTIONS);
    let failed = |e: std::io::Error| Error::io(&name, e);
    fs::create_dir_all(folder).map_err(failed)?;
    match fs::read_to_string(&name) {
        Ok(there) if there == options => Ok(()),
        Ok(_) => Err(Error::file(&name, "the folder belongs to a data set with other options")),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            let unfinished = unfinished(folder)?;
            if let Some(other) = names(folder)?.iter().find(|path| !unfinished.contains(path)) {
                let other = other.file_name().unwrap_or_default().display();
                let why = format!("has {other}, but no {OPTIONS}: is no folder of finished shapes");
                return Err(Error::file(folder, why));
            }
            let mut output = Output::create(&name, Overwrite::Replace)?;
            output.write_all(options.as_bytes()).map_err(|e| output.error(e))?;
            output.commit()
        }
        Err(e) => Err(failed(e)),
    }
}

/// Returns the paths of everything in a folder, sorted.
fn names(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).and_then(|entries| {
        entries.map(|entry| entry.map(|entry| entry.path())).collect::<std::io::Result<Vec<_>>>()
    });
    let mut paths = entries.map_err(|e| Error::io(folder, e))?;
    paths.sort_unstable();
    Ok(paths)
}

/// Returns the paths of the finished shapes in a folder.
fn shapes(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_number = |text: &str| text.len() >= 5 && text.bytes().all(|b| b.is_ascii_digit());
    named(folder, "shape", ".npz", is_number)
}

/// Returns the paths of the files in a folder that a killed program has begun; see [`Output`].
fn unfinished(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_hash = |text: &str| text.len() == 16 && text.bytes().all(|b| b.is_ascii_hexdigit());
    named(folder, ".catamaran-", ".tmp", is_hash)
}

/// Returns the paths of the files in a folder whose names have this prefix and suffix, and a text
/// between them that `is_ours` accepts.
fn named(
    folder: &Path,
    prefix: &str,
    suffix: &str,
    is_ours: impl Fn(&str) -> bool,
) -> Result<Vec<PathBuf>> {
    let mut paths = names(folder)?;
    paths.retain(|path| {
        let name = path.file_name().and_then(|name| name.to_str());
        let between = name.and_then(|name| name.strip_prefix(prefix)?.strip_suffix(suffix));
        between.is_some_and(&is_ours) && path.is_file()
    });
    Ok(paths)
}

/// Returns the results for a shape: those that are stored, or new ones.
fn shape(
    options: &DatasetOptions,
    job: &Job,
    number: usize,
    subject: Option<&Subject>,
    folder: &Path,
) -> Result<Found> {
    let file: PathBuf = folder.join(format!("shape{number:05}.npz"));
    if file.exists() {
        let family = subject.filter(|_| job.parts == Parts::Common).map(|subject| &subject.cuts);
        let vertices = subject.filter(|_| job.parts != Parts::Common);
        let vertices = vertices.map_or(0, |subject| subject.model.mirror().len());
        return read_found(&file, family, vertices);
    }
    let found = match subject {
        None => {
            let creature = Model::creature(options.seed, job.identity, options.vertices)?;
            let own = cuts(&creature, &options.own_cuts(job), Par::Seq)?;
            compute(options, job, &creature, &own)?
        }
        Some(subject) if job.parts == Parts::Common => {
            compute(options, job, &subject.model, &subject.cuts)?
        }
        Some(Subject { model, held_out, .. }) => {
            let mut own = cuts(model, &options.own_cuts(job), Par::Seq)?;
            if job.parts == Parts::Varied {
                held_out.withhold(&mut own);
            }
            let found = compute(options, job, model, &own)?;
            let mask_words = found.masks.iter().flat_map(|id| packed(&own.masks[id])).collect();
            Found { mask_words, ..found }
        }
    };
    let mut writer = ArraysWriter::new(Output::create(&file, Overwrite::Replace)?)?;
    let rows = found.spectra.as_flattened();
    let spectra = MatRef::from_row_major_slice(rows, found.spectra.len(), EIGENVALUES);
    let pairs: Vec<usize> =
        found.pairs.iter().flat_map(|pair| [pair.parts[0], pair.parts[1], pair.union]).collect();
    writer.array("pairs", Array::Indices(&pairs))?;
    writer.array("masks", Array::Indices(&found.masks))?;
    writer.array("mask_words", Array::Indices(&found.mask_words))?;
    writer.array("spectra", Array::Matrix(spectra))?;
    writer.array("areas", Array::Vector(&found.areas))?;
    writer.finish()?;
    Ok(found)
}

/// Reads the results for a shape. `family` has its cuts if they are those of its family. Otherwise
/// the file has masks of this number of `vertices`, or none if it is 0.
fn read_found(file: &Path, family: Option<&Cuts>, vertices: usize) -> Result<Found> {
    let arrays = read_arrays(file)?;
    let (masks, mask_words) = (arrays.indices("masks")?, arrays.indices("mask_words")?);
    let spectra = arrays.matrix("spectra")?;
    let (pairs, areas) = (arrays.indices("pairs")?, arrays.vector("areas")?);
    let count = masks.len() + 1;
    let pair = |ids: &[usize]| Pair { parts: [ids[0], ids[1]], union: ids[2] };
    let triples = pairs.chunks_exact(3);
    let are_triples = triples.remainder().is_empty();
    let pairs: Vec<Pair> = triples.map(pair).collect();
    let is_known = |id: &usize| masks.binary_search(id).is_ok();
    let are_known = |pair: &Pair| pair.parts.iter().chain([&pair.union]).all(is_known);
    let is_sound = [
        ("masks", masks.is_sorted_by(|a, b| a < b)),
        ("masks", family.is_none_or(|family| masks.iter().eq(family.masks.keys()))),
        ("mask_words", mask_words.len() == masks.len() * vertices.div_ceil(WORD)),
        ("spectra", spectra.shape() == (count, EIGENVALUES)),
        ("areas", areas.len() == count),
        ("pairs", are_triples && pairs.iter().all(are_known)),
        ("pairs", family.is_none_or(|family| pairs == family.pairs)),
    ];
    if let Some((array, _)) = is_sound.iter().find(|(_, is_sound)| !is_sound) {
        return Err(Error::file(file, format!("`{array}`: does not belong to this data set")));
    }
    let row = |i: usize| std::array::from_fn(|j| spectra[(i, j)]);
    Ok(Found { pairs, masks, mask_words, spectra: (0..count).map(row).collect(), areas })
}

fn compute(options: &DatasetOptions, job: &Job, model: &Model, cuts: &Cuts) -> Result<Found> {
    let Job { identity, body, pose, .. } = *job;
    let mesh = model.shape(options.seed, identity, body, pose)?;
    let (mesh, vertices): (TriMesh, Vec<u32>) = if job.remeshed {
        let seed = mixed(&[options.seed, identity as u64, pose as u64, 0x4E35]);
        let remeshed = remove_vertices(&mesh, REMOVED, seed)?;
        (remeshed.mesh, remeshed.vertices)
    } else {
        let all = (0..mesh.vertices().len() as u32).collect();
        (mesh, all)
    };
    // The shapes are processed in parallel; each one is processed by a single thread.
    let settings = LaplacianOptions::new().par(Par::Seq);
    let spectra = PartSpectra::new(&mesh, &settings)?;
    let complete = vec![true; model.mirror().len()];
    let here =
        |mask: &[bool]| -> Vec<bool> { vertices.iter().map(|&v| mask[v as usize]).collect() };
    let mut masks = Vec::new();
    for (&id, mask) in &cuts.masks {
        let inside = spectra.inside(&here(mask))?.iter().filter(|inside| **inside).count();
        // Remeshing may leave too little of a part. The pairs of a family are the same for all
        // shapes.
        if inside >= INSIDE || job.parts == Parts::Common {
            masks.push(id);
        }
    }
    let kept = |id: usize| masks.binary_search(&id).is_ok();
    let whole = |pair: &&Pair| kept(pair.parts[0]) && kept(pair.parts[1]) && kept(pair.union);
    let pairs = cuts.pairs.iter().filter(whole).copied().collect();
    let mut found = Found { pairs, masks, mask_words: vec![], spectra: vec![], areas: vec![] };
    let face_areas = mesh.face_areas();
    for mask in found.masks.iter().map(|id| &cuts.masks[id]).chain([&complete]) {
        let own = here(mask);
        let values = spectra.dirichlet(&own, EIGENVALUES)?;
        found.spectra.push(std::array::from_fn(|i| values[i]));
        let inside = |f: &[u32; 3]| f.iter().all(|&v| own[v as usize]);
        let areas = mesh.faces().iter().zip(&face_areas).filter(|(f, _)| inside(f));
        found.areas.push(areas.map(|(_, area)| area).sum());
    }
    Ok(found)
}

/// Creates the template, with the masks of all shapes.
fn template<'a>(
    subject: &Subject,
    shapes: impl Iterator<Item = &'a Found>,
    par: Par,
) -> Result<Template> {
    let mesh = subject.model.template();
    let settings = LaplacianOptions::new().par(par);
    let operator = laplacian(mesh, &settings)?;
    let k = EIGENFUNCTIONS.min(operator.kept.len());
    let wanted = EigenOptions::new().k(k).par(par);
    let pairs = eigs(operator.stiffness.view(), &operator.mass, &wanted)?;
    let words = subject.model.mirror().len().div_ceil(WORD);
    let mut masks: BTreeMap<usize, Vec<usize>> =
        subject.cuts.masks.iter().map(|(&id, mask)| (id, packed(mask))).collect();
    for found in shapes {
        let own = found.masks.iter().zip(found.mask_words.chunks_exact(words));
        masks.extend(own.map(|(&id, words)| (id, words.to_vec())));
    }
    Ok(Template {
        vertices: mesh.vertices().to_vec(),
        faces: mesh.faces().as_flattened().iter().map(|&v| v as usize).collect(),
        mirror: subject.model.mirror().iter().map(|&v| v as usize).collect(),
        mass: vertex_areas(mesh),
        eigenvalues: pairs.values,
        eigenfunctions: operator.extend(pairs.vectors.as_ref())?,
        masks: masks.keys().copied().collect(),
        mask_words: masks.into_values().flatten().collect(),
    })
}

/// Adds the results for a shape to the data set.
fn add(
    dataset: &mut Dataset,
    options: &DatasetOptions,
    job: &Job,
    subject: Option<&Subject>,
    found: &Found,
) {
    let Dataset { samples, shapes, triples, .. } = dataset;
    for (i, pair) in found.pairs.iter().enumerate() {
        let [a, b] = pair.parts;
        samples.part1.push(found.spectrum(a));
        samples.part2.push(found.spectrum(b));
        samples.union.push(found.spectrum(pair.union));
        samples.areas.push([a, b, pair.union].map(|id| found.area(id)));
        samples.family.push(job.family.number());
        samples.identity.push(job.identity);
        samples.body.push(job.body);
        samples.pose.push(job.pose);
        samples.mask1.push(a);
        samples.mask2.push(b);
        samples.mask_union.push(pair.union);
        samples.remeshed.push(usize::from(job.remeshed));
        let split = |s: &Subject| s.held_out.split(i, pair.union, job, options.poses);
        samples.split.push(subject.map_or(TRAIN, split));
        samples.knowledge.push(job.knowledge);
    }
    if job.remeshed || job.parts != Parts::Common {
        return;
    }
    shapes.spectrum.push(found.spectra[found.masks.len()]);
    shapes.area.push(found.areas[found.masks.len()]);
    shapes.family.push(job.family.number());
    shapes.identity.push(job.identity);
    shapes.body.push(job.body);
    shapes.pose.push(job.pose);
    shapes.knowledge.push(job.knowledge);
    // Shapes of the training contribute no new triples.
    if !job.is_test(options.poses) {
        return;
    }
    for triple in subject.iter().flat_map(|subject| &subject.cuts.triples) {
        let [a, b, c] = triple.parts.map(|id| found.spectrum(id));
        let [ab, bc] = triple.unions.map(|id| found.spectrum(id));
        triples.part1.push(a);
        triples.part2.push(b);
        triples.part3.push(c);
        triples.union12.push(ab);
        triples.union23.push(bc);
        triples.whole.push(found.spectrum(triple.whole));
        triples.family.push(job.family.number());
        triples.identity.push(job.identity);
        triples.pose.push(job.pose);
        triples.mask.push(triple.whole);
        triples.knowledge.push(job.knowledge);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::ops::ControlFlow;

    use super::super::{Samples, TEST_B, TRAIN, UNKNOWN_FAMILY, read, write};
    use super::*;
    use crate::cuts::CutOptions;

    /// Returns options with a few shapes of each kind.
    fn tiny() -> DatasetOptions {
        let cuts =
            CutOptions { regions: 9, pairs: 6, composites: 0, splits: 5, triples: 2, seed: 1 };
        DatasetOptions {
            seed: 5,
            vertices: 900,
            known: 1,
            unknown: 1,
            others: 1,
            poses: 2,
            cuts,
            varied: 1,
            creatures: 1,
        }
    }

    #[test]
    fn shapes_of_unknown_options_are_not_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("set.npz.parts");
        prepare(&folder, "one").unwrap();
        let shape = folder.join("shape00000.npz");
        fs::write(&shape, "of one").unwrap();
        prepare(&folder, "one").unwrap();
        assert!(prepare(&folder, "two").unwrap_err().to_string().contains("other options"));
        fs::remove_file(folder.join(OPTIONS)).unwrap();
        let refused = prepare(&folder, "two").unwrap_err().to_string();
        let says = "set.npz.parts: has shape00000.npz, but no options.txt";
        assert!(refused.contains(says) && shape.exists(), "{refused}");
    }

    #[test]
    fn only_the_files_of_a_data_set_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("set.npz.parts");
        // What a program leaves that is killed while it writes the options.
        let unfinished = ".catamaran-0123456789abcdef.tmp";
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join(unfinished), "").unwrap();
        prepare(&folder, "one").unwrap();
        let others = ["notes.md", "shape.npz", "shape1.npz", "shapes.npz"];
        for name in ["shape00000.npz", "shape123456.npz"].iter().chain(&others) {
            fs::write(folder.join(name), "").unwrap();
        }
        assert!(!remove_shapes(&folder).unwrap());
        assert_eq!(names(&folder).unwrap(), others.map(|name| folder.join(name)));
        others.iter().for_each(|name| fs::remove_file(folder.join(name)).unwrap());
        prepare(&folder, "one").unwrap();
        assert!(remove_shapes(&folder).unwrap() && !folder.exists());
    }

    #[test]
    fn options_that_are_refused_do_not_refuse_others() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("set.npz.parts");
        let small = DatasetOptions { vertices: 3, ..tiny() };
        let refused = generate(&small, &folder, Par::Seq, Progress::none()).unwrap_err();
        assert!(matches!(refused, Error::Argument { what: "vertices", .. }), "{refused}");
        assert!(!folder.exists());
    }

    #[test]
    fn damaged_shapes_are_refused_with_their_array() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("shape00000.npz");
        let spectra = catamaran::faer::Mat::<f64>::full(3, EIGENVALUES, 1.0);
        let read = |pairs: &[usize], masks: &[usize], words: &[usize], areas: &[f64]| {
            let mut writer =
                ArraysWriter::new(Output::create(&file, Overwrite::Replace).unwrap()).unwrap();
            for (name, array) in [
                ("pairs", Array::Indices(pairs)),
                ("masks", Array::Indices(masks)),
                ("mask_words", Array::Indices(words)),
                ("spectra", Array::Matrix(spectra.as_ref())),
                ("areas", Array::Vector(areas)),
            ] {
                writer.array(name, array).unwrap();
            }
            writer.finish().unwrap();
            // Masks of 65 vertices have two words.
            read_found(&file, None, 65).map(|found| found.pairs.len()).map_err(|e| e.to_string())
        };
        let (masks, words, areas) = ([4, 7], [0; 4], [1.0; 3]);
        assert_eq!(read(&[4, 7, 7], &masks, &words, &areas), Ok(1));
        for (found, array) in [
            (read(&[4, 7], &masks, &words, &areas), "`pairs`"),
            (read(&[4, 7, 8], &masks, &words, &areas), "`pairs`"),
            (read(&[4, 7, 7], &[7, 4], &words, &areas), "`masks`"),
            (read(&[4, 7, 7], &masks, &words[1..], &areas), "`mask_words`"),
            (read(&[4, 7, 7], &masks, &words, &areas[1..]), "`areas`"),
            (read(&[], &[4], &words[2..], &areas), "`spectra`"),
        ] {
            let refused = found.unwrap_err();
            assert!(refused.contains("shape00000.npz") && refused.contains(array), "{refused}");
        }
    }

    #[test]
    fn spectra_of_unions_are_below_those_of_parts() {
        let folder = tempfile::tempdir().unwrap();
        let set = generate(&tiny(), folder.path(), Par::all(), Progress::none()).unwrap();
        let Samples { part1, part2, union, areas, .. } = &set.samples;
        assert!(set.templates.len() == 4 && part1.len() > 20);
        for i in 0..part1.len() {
            for j in 0..EIGENVALUES {
                let bound = part1[i][j].min(part2[i][j]);
                assert!(union[i][j] <= bound * (1.0 + 1e-6), "{i} {j}: {} {bound}", union[i][j]);
                assert!(j == 0 || union[i][j] >= union[i][j - 1]);
            }
            let [a, b, all] = areas[i];
            assert!(all < a + b && all > a && all > b);
        }
    }

    #[test]
    fn templates_have_the_masks_of_all_samples() {
        let folder = tempfile::tempdir().unwrap();
        let Dataset { templates, samples, .. } =
            generate(&tiny(), folder.path(), Par::all(), Progress::none()).unwrap();
        let varied = (0..samples.pose.len()).filter(|&i| samples.pose[i] >= tiny().poses).count();
        let creature = Family::Creature.number();
        assert!(varied > 0 && samples.family.contains(&creature));
        for i in (0..samples.part1.len()).filter(|&i| samples.family[i] != creature) {
            let template = &templates[samples.family[i]];
            let [a, b, all] = [samples.mask1[i], samples.mask2[i], samples.mask_union[i]]
                .map(|id| template.mask(id).unwrap().into_iter().collect::<BTreeSet<usize>>());
            assert_eq!(&a | &b, all);
        }
        assert_eq!(templates[0].mask(12), None);
    }

    #[test]
    fn creatures_train_and_each_differs() {
        let folder = tempfile::tempdir().unwrap();
        let options = DatasetOptions { creatures: 2, others: 0, varied: 0, ..tiny() };
        let Dataset { templates, samples, .. } =
            generate(&options, folder.path(), Par::all(), Progress::none()).unwrap();
        assert_eq!(templates.len(), 1);
        let creature = Family::Creature.number();
        let own = |identity: usize| -> Vec<usize> {
            let is = |i: &usize| samples.family[*i] == creature && samples.identity[*i] == identity;
            (0..samples.family.len()).filter(is).collect()
        };
        for identity in 0..2 {
            assert!(!own(identity).is_empty());
            assert!(own(identity).iter().all(|&i| samples.split[i] == TRAIN));
            assert!(own(identity).iter().all(|&i| samples.remeshed[i] == identity));
        }
        let unions = |identity| own(identity).into_iter().map(|i| samples.mask_union[i]);
        assert!(unions(0).all(|union| unions(1).all(|other| other != union)));
    }

    #[test]
    fn what_was_interrupted_goes_on_and_is_the_same_for_any_number_of_threads() {
        let folder = tempfile::tempdir().unwrap();
        let whole =
            generate(&tiny(), &folder.path().join("a"), Par::Seq, Progress::none()).unwrap();
        let other = folder.path().join("b");
        let stop = |fraction: f64| {
            if fraction > 0.4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let stopped = generate(&tiny(), &other, Par::Seq, (&stop).into()).unwrap_err();
        assert_eq!(stopped, Error::Cancelled);
        assert!(other.join("shape00000.npz").exists());
        assert_eq!(generate(&tiny(), &other, Par::Threads(2), Progress::none()).unwrap(), whole);
        let strange = DatasetOptions { seed: 6, ..tiny() };
        let refused = generate(&strange, &other, Par::Seq, Progress::none()).unwrap_err();
        assert!(refused.to_string().contains("other options"), "{refused}");

        let path = folder.path().join("set.npz");
        write(&whole, Output::create(&path, Overwrite::Never).unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), whole);
    }

    #[test]
    fn no_training_sample_has_a_union_of_test_b() {
        let folder = tempfile::tempdir().unwrap();
        let cuts =
            CutOptions { regions: 12, pairs: 20, composites: 0, splits: 15, triples: 2, seed: 1 };
        let options = DatasetOptions { known: 2, others: 0, cuts, ..tiny() };
        let Dataset { templates, samples, .. } =
            generate(&options, folder.path(), Par::all(), Progress::none()).unwrap();
        let Samples { split, mask_union, knowledge, remeshed, pose, .. } = samples;
        let of = |wanted: usize| {
            let rows = (0..split.len()).filter(|&i| split[i] == wanted);
            rows.map(|i| mask_union[i]).collect::<BTreeSet<_>>()
        };
        assert!(!of(TEST_B).is_empty());
        assert!(of(TRAIN).is_disjoint(&of(TEST_B)));
        for i in 0..split.len() {
            let varied = pose[i] > options.poses;
            assert!(split[i] != TRAIN || knowledge[i] == 0 && (varied || remeshed[i] == 0));
            assert!(knowledge[i] != UNKNOWN_FAMILY);
        }
        let mask = |id: &usize| -> BTreeSet<usize> {
            templates[0].mask(*id).unwrap().into_iter().collect()
        };
        let tests: Vec<_> = of(TEST_B).iter().map(mask).collect();
        for i in (0..split.len()).filter(|&i| pose[i] > options.poses) {
            let own = mask(&mask_union[i]);
            for test in &tests {
                let (both, either) = ((test & &own).len(), (test | &own).len());
                assert!((both as f64) < 0.95 * either as f64);
            }
        }
    }
}
