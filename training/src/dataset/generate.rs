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

/// Generates a data set. Finished shapes are stored in `folder`, which is created if it does not
/// exist; another call with the same options continues from there. The caller has to delete the
/// folder. The same options give the same data set for any number of threads.
///
/// # Errors
/// [`Error::Argument`] for sizes out of range; [`Error::Io`] when the folder belongs to other
/// options, or can't be written; [`Error::Cancelled`].
pub fn generate(
    options: &DatasetOptions,
    folder: &Path,
    par: Par,
    progress: Progress<'_>,
) -> Result<Dataset> {
    options.check()?;
    prepare(folder, &format!("{options:?}\n"))?;
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
    let name = folder.join("options.txt");
    let failed = |e: std::io::Error| Error::io(&name, e);
    fs::create_dir_all(folder).map_err(failed)?;
    match fs::read_to_string(&name) {
        Ok(there) if there == options => Ok(()),
        Ok(_) => Err(Error::file(&name, "the folder belongs to a data set with other options")),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            remove_shapes(folder).map_err(failed)?;
            let mut output = Output::create(&name, Overwrite::Replace)?;
            output.write_all(options.as_bytes()).map_err(|e| output.error(e))?;
            output.commit()
        }
        Err(e) => Err(failed(e)),
    }
}

/// Removes shapes of unknown options, which remain when a program is killed during the removal of
/// the folder. Other files are not removed.
fn remove_shapes(folder: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let number =
            name.to_str().and_then(|name| name.strip_prefix("shape")?.strip_suffix(".npz"));
        if number.is_some_and(|number| number.bytes().all(|b| b.is_ascii_digit())) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
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
        return read_found(&file);
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

fn read_found(file: &Path) -> Result<Found> {
    let arrays = read_arrays(file)?;
    let (masks, mask_words) = (arrays.indices("masks")?, arrays.indices("mask_words")?);
    let spectra = arrays.matrix("spectra")?;
    let (pairs, areas) = (arrays.indices("pairs")?, arrays.vector("areas")?);
    let count = masks.len() + 1;
    if spectra.shape() != (count, EIGENVALUES) || areas.len() != count {
        return Err(Error::file(file, "does not belong to this data set"));
    }
    let row = |i: usize| std::array::from_fn(|j| spectra[(i, j)]);
    let pair = |ids: &[usize]| Pair { parts: [ids[0], ids[1]], union: ids[2] };
    let pairs = pairs.chunks_exact(3).map(pair).collect();
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
        let folder = folder.path();
        prepare(folder, "one").unwrap();
        let shape = folder.join("shape00000.npz");
        fs::write(&shape, "of one").unwrap();
        prepare(folder, "one").unwrap();
        assert!(shape.exists() && prepare(folder, "two").is_err());
        let other = folder.join("shapes.npz");
        fs::write(&other, "not ours").unwrap();
        // The state that remains when the removal of the folder is interrupted.
        fs::remove_file(folder.join("options.txt")).unwrap();
        prepare(folder, "two").unwrap();
        assert!(!shape.exists() && other.exists());
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
