//! FAUST: ten people in ten poses, of CATAMARAN_THESIS_DATA.

use std::array;
use std::collections::{BTreeSet, VecDeque};

use catamaran::Par;
use catamaran_bench::Result;
use catamaran_bench::spectral::thesis::Data;
use catamaran_geometry::mesh::{LaplacianOptions, TriMesh, io};
use catamaran_geometry::unions::{MetricOptions, PartSpectra, SpectralUnion};
use catamaran_training::cuts::Mask;
use catamaran_training::dataset::{EIGENVALUES, Spectrum};
use catamaran_training::evaluate::{
    BODY_CUTS, BodyCut, DOCUMENTED_THRESHOLD, Frame, Judgement, Query, RetrievalStudy, Source,
    WRONG, body_parts, mirrored_union, part_pairs,
};
use catamaran_training::families::{Family, Model};
use catamaran_training::train::{LEAST_SHARE, Pair};

use super::super::Report;

/// Number of people, and of poses of each.
const COUNT: usize = 10;

/// The axes of FAUST, and of generated people.
const FRAME: Frame = Frame { up: 1, side: 0 };
const GENERATED: Frame = Frame { up: 2, side: 0 };

/// Number of vertices of generated people, and a seed that no data set has.
const VERTICES: usize = 5000;
const SEED: u64 = 31;

/// Largest change of a union if a part is mirrored, as a share of the area, that counts as none:
/// mirror images of vertices are known to about the length of an edge.
const SAME: f64 = 0.03;

/// First eigenvalue times area of a union below which only the end of a limb is missing; a disk has
/// 18.
const TIP: f64 = 3.0;

/// The cuts whose parts end at vertical planes through stretched arms; planes at these heights cut
/// the trunk or the legs of a person whose arms hang.
const PLANES: [&str; 2] = ["upper half; middle of the span", "one side; legs"];

/// Factors of the network's errors.
const FACTORS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// A registration, cut.
struct Shape {
    query: Query,
    area: f64,
    pairs: Vec<Done>,
    /// Of the cuts of pose 0, along known points.
    carried: Vec<Done>,
    left_out: Vec<String>,
}

/// A pair of parts, and its prediction.
struct Done {
    cut: &'static BodyCut,
    person: usize,
    pose: usize,
    /// The area of the shape.
    area: f64,
    /// The change of the union if a part is mirrored, as a share of the area.
    change: f64,
    pair: Pair,
    predicted: Spectrum,
    judgement: Judgement,
}

impl Done {
    fn complete(&self) -> bool {
        self.pair.union[0] <= LEAST_SHARE * self.pair.union[EIGENVALUES - 1]
    }

    fn lacks_a_tip(&self) -> bool {
        !self.complete() && self.pair.union[0] * self.area < TIP
    }

    /// Returns the mean relative error if that of each logarithm is multiplied by a factor.
    fn error(&self, factor: f64) -> f64 {
        let Pair { union, .. } = &self.pair;
        let errors = self.predicted.iter().zip(union).skip(usize::from(self.complete()));
        let errors: Vec<f64> =
            errors.map(|(found, truth)| ((found / truth).powf(factor) - 1.0).abs()).collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    }
}

/// Reports the errors on cuts of all registrations, retrieval, and what limits both.
pub fn tables(report: &mut Report, data: &Data, network: &SpectralUnion) -> Result<()> {
    let shapes = shapes(data, network)?;
    let pairs: Vec<&Done> = shapes.iter().flat_map(|shape| &shape.pairs).collect();
    let carried: Vec<&Done> = shapes.iter().flat_map(|shape| &shape.carried).collect();
    let left_out: Vec<&String> = shapes.iter().flat_map(|shape| &shape.left_out).collect();
    let reasons: BTreeSet<&str> = left_out.iter().map(|why| why.as_str()).collect();
    report.say(&format!(
        "\n## FAUST\n\nThe 100 registrations of FAUST, ten people in ten poses, remeshed to 5,000 vertices and scaled to the same height \
         of the bounding box (llorz/SGA18_orientation_BCICP_dataset), cut in the six ways of the real people; all spectra are computed. Left out: \
         {} ({}). Goal: at most 6 % in the mean, and none above 15 % without a warning (score > 1).\n",
        left_out.len(),
        reasons.into_iter().collect::<Vec<_>>().join("; ")
    ));
    header(report, "cut");
    row(report, "**all**", &pairs);
    for cut in cuts() {
        row(
            report,
            cut.name,
            &pairs.iter().copied().filter(|done| done.cut == cut).collect::<Vec<_>>(),
        );
    }
    poses(report, &pairs);
    limits(report, &pairs, &carried);
    generated(report, network)?;
    improved(report, &pairs);
    retrieval(report, &shapes)?;
    for (table, pairs) in [("faust", &pairs), ("faust carried", &carried)] {
        report.lines.extend(pairs.iter().map(|done| {
            let Judgement { error, score, .. } = done.judgement;
            let (cut, number) = (done.cut.name.replace(',', ""), COUNT * done.person + done.pose);
            format!("{table},tr_reg_{number:03},{cut},,,{error:.6e},,{score:.4},")
        }));
    }
    Ok(())
}

fn cuts() -> impl Iterator<Item = &'static BodyCut> {
    BODY_CUTS.iter().filter(|cut| cut.clear)
}

/// Reads and cuts all registrations, and predicts the spectra of unions.
fn shapes(data: &Data, network: &SpectralUnion) -> Result<Vec<Shape>> {
    let mut found = Vec::new();
    for person in 0..COUNT {
        let mut first = None;
        for pose in 0..COUNT {
            let (path, [known, mirrored]) = data.registration(COUNT * person + pose)?;
            let mesh = io::read(&path)?.mesh;
            let mirror = nearest(&mesh, &known, &mirrored);
            let parts = body_parts(&mesh, FRAME, Par::all())?;
            let (first_known, first_parts) =
                &*first.get_or_insert_with(|| (known.clone(), parts.clone()));
            let counterparts = nearest(&mesh, &known, first_known);
            let carry = |part: &Mask| counterparts.iter().map(|&v| part[v as usize]).collect();
            let carried: Vec<[Mask; 2]> =
                first_parts.iter().map(|parts| parts.each_ref().map(carry)).collect();
            let spectra = PartSpectra::new(&mesh, &LaplacianOptions::new().par(Par::all()))?;
            let whole = spectra.dirichlet(&vec![true; mesh.vertices().len()], EIGENVALUES)?;
            let query = Query { identity: person, pose, spectrum: array::from_fn(|i| whole[i]) };
            let (pairs, left_out) = predicted(&mesh, &mirror, &parts, query, network)?;
            let (carried, _) = predicted(&mesh, &mirror, &carried, query, network)?;
            found.push(Shape { query, area: mesh.area(), pairs, carried, left_out });
        }
    }
    Ok(found)
}

/// Returns for each vertex the value of a known one that is as near as any along edges.
fn nearest(mesh: &TriMesh, known: &[u32], values: &[u32]) -> Vec<u32> {
    let neighbours = mesh.vertex_neighbors();
    let mut found = vec![None; mesh.vertices().len()];
    let mut queue = VecDeque::new();
    for (&v, &value) in known.iter().zip(values) {
        if found[v as usize].replace(value).is_none() {
            queue.push_back(v);
        }
    }
    while let Some(v) = queue.pop_front() {
        for &w in neighbours.row(v as usize) {
            if found[w as usize].is_none() {
                found[w as usize] = found[v as usize];
                queue.push_back(w);
            }
        }
    }
    found.into_iter().map(Option::unwrap_or_default).collect()
}

/// Predicts the spectra of the unions of the parts of clear cuts; returns also why others are no
/// pairs.
fn predicted(
    mesh: &TriMesh,
    mirror: &[u32],
    parts: &[[Mask; 2]],
    Query { identity: person, pose, .. }: Query,
    network: &SpectralUnion,
) -> Result<(Vec<Done>, Vec<String>)> {
    let (mut done, mut left_out) = (Vec::new(), Vec::new());
    let pairs = BODY_CUTS.iter().zip(parts).zip(part_pairs(mesh, parts, Par::all())?);
    for ((cut, parts), pair) in pairs.filter(|((cut, _), _)| cut.clear) {
        match pair {
            Err(why) => left_out.push(why.to_string()),
            Ok(pair) => done.push(Done {
                cut,
                person,
                pose,
                area: mesh.area(),
                change: mirrored_union(mesh, mirror, parts),
                predicted: network.predict(&pair.first, &pair.second)?,
                judgement: Judgement::of(network, &pair, true)?,
                pair,
            }),
        }
    }
    Ok((done, left_out))
}

fn header(report: &mut Report, what: &str) {
    report.say(&format!(
        "| {what} | pairs | error % | worst % | above 15 % | of these score > 1 | not |\n|---|---|---|---|---|---|---|"
    ));
}

fn row(report: &mut Report, name: &str, pairs: &[&Done]) {
    let wrong: Vec<&&Done> = pairs.iter().filter(|done| done.judgement.wrong().1).collect();
    let warned = wrong.iter().filter(|done| done.judgement.score > DOCUMENTED_THRESHOLD).count();
    let worst = pairs.iter().map(|done| done.judgement.error).fold(0.0, f64::max);
    report.say(&format!(
        "| {name} | {} | {:.1} | {:.1} | {} | {warned} | {} |",
        pairs.len(),
        mean(pairs),
        100.0 * worst,
        wrong.len(),
        wrong.len() - warned
    ));
}

/// Returns the mean error in per cent.
fn mean(pairs: &[&Done]) -> f64 {
    let sum: f64 = pairs.iter().map(|done| done.judgement.error).sum();
    100.0 * sum / pairs.len().max(1) as f64
}

/// Reports the errors of each pose, by cut, and of each person.
fn poses(report: &mut Report, pairs: &[&Done]) {
    let of = |keep: &dyn Fn(&Done) -> bool| -> Vec<&Done> {
        pairs.iter().copied().filter(|done| keep(done)).collect()
    };
    let people = array::from_fn::<f64, COUNT, _>(|i| mean(&of(&|done| done.person == i)));
    let names: Vec<&str> = cuts().map(|cut| cut.name).collect();
    report.say(&format!(
        "\nMean errors in per cent by pose: 0 arms half raised, 1 hands on the hips, 2 and 5 arms hang, 3 hands at the face, 4 a leg raised, 6 arms \
         forward, 7 a leg raised and hands on the head, 8 turned, 9 arms raised. By person: {}.\n\n\
         | pose | all | {} |\n|---|---{}|",
        people.map(|error| format!("{error:.1}")).join(", "),
        names.join(" | "),
        "|---".repeat(names.len())
    ));
    for pose in 0..COUNT {
        let cells: Vec<String> = cuts()
            .map(|cut| mean(&of(&|done| done.pose == pose && done.cut == cut)))
            .map(|error| format!("{error:.1}"))
            .collect();
        let all = mean(&of(&|done| done.pose == pose));
        report.say(&format!("| {pose} | {all:.1} | {} |", cells.join(" | ")));
    }
}

/// Reports errors by what distinguishes pairs from those of people with stretched arms.
fn limits(report: &mut Report, pairs: &[&Done], carried: &[&Done]) {
    report.say(
        "\n### What limits the errors\n\nThe cuts are windows of height and span, for people with stretched arms. FAUST has none: the same windows \
         cut other parts. Each pair counts in the first of four rows that applies; mirror images are known. *Carried*: the parts of pose 0 \
         of the same person, along known points.\n",
    );
    header(report, "pairs");
    let class = |done: &Done| match done {
        done if done.lacks_a_tip() => 0,
        done if done.change > SAME => 1,
        done if PLANES.contains(&done.cut.name) => 2,
        _ => 3,
    };
    let classes = [
        "the union lacks only the end of a limb",
        "the union changes by more than 3 % of the area if a part is mirrored",
        "a vertical plane, meant for arms, cuts trunk or legs",
        "others",
    ];
    let of = |of: usize| pairs.iter().copied().filter(|done| class(done) == of).collect::<Vec<_>>();
    for (number, name) in classes.iter().enumerate() {
        row(report, name, &of(number));
    }
    row(report, "carried, all", carried);
    for cut in cuts() {
        let of: Vec<&Done> = carried.iter().copied().filter(|done| done.cut == cut).collect();
        row(report, &format!("carried, {}", cut.name), &of);
    }
    let some = |done: &&Done| !done.lacks_a_tip() && !PLANES.contains(&done.cut.name);
    let of: Vec<&Done> = carried.iter().copied().filter(some).collect();
    row(report, "carried, without lacking ends and vertical planes", &of);
}

/// Reports the errors on generated people in poses, cut before and after they take the pose.
fn generated(report: &mut Report, network: &SpectralUnion) -> Result<()> {
    let model = Model::new(Family::Humanoid, VERTICES)?;
    let template = body_parts(model.template(), GENERATED, Par::all())?;
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for person in 0..COUNT {
        let mesh = model.shape(SEED, person, 0, 1)?;
        let own = body_parts(&mesh, GENERATED, Par::all())?;
        let query = Query { identity: person, pose: 0, spectrum: [0.0; EIGENVALUES] };
        before.extend(predicted(&mesh, model.mirror(), &template, query, network)?.0);
        after.extend(predicted(&mesh, model.mirror(), &own, query, network)?.0);
    }
    report.say(&format!(
        "\n{COUNT} generated people, each in a pose: the same windows, on the template with stretched arms, as for the training, and on the \
         person in the pose.\n"
    ));
    header(report, "pairs");
    let planes = |done: &&Done| PLANES.contains(&done.cut.name);
    for (name, done) in [("cut on the template", &before), ("cut in the pose", &after)] {
        row(report, name, &done.iter().collect::<Vec<_>>());
        let some: Vec<&Done> = done.iter().filter(planes).collect();
        row(report, &format!("{name}, the two cuts with vertical planes"), &some);
    }
    Ok(())
}

/// Reports the errors if those of the network were smaller.
fn improved(report: &mut Report, pairs: &[&Done]) {
    report.say(
        "\nErrors of logarithms of the predictions, multiplied by a factor:\n\n\
         | factor | error % | above 15 % |\n|---|---|---|",
    );
    for factor in FACTORS {
        let errors: Vec<f64> = pairs.iter().map(|done| done.error(factor)).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let wrong = errors.iter().filter(|&&error| error > WRONG).count();
        report.say(&format!("| x {factor} | {:.1} | {wrong} |", 100.0 * mean));
    }
}

/// Reports retrieval by the predictions whose union is complete.
fn retrieval(report: &mut Report, shapes: &[Shape]) -> Result<()> {
    report.say(
        "\n### Retrieval\n\nQueries are the predictions whose union is complete (first eigenvalue 0), by cut; the gallery are the true spectra of all \
         shapes, and the shape of a query is no result. Goal: 95 % of what true spectra reach. *Area 1*: spectra times the area of the shape, \
         since the meshes are scaled to one height, whether arms are raised or not. Top-1 in per cent by Euclidean distance and by likelihood \
         (`RetrievalMetric` of `poses_only`, fitted to the poses and errors of the nine other people; without it 41 identities are necessary), of true \
         spectra, and of predictions with errors multiplied by a factor.\n\n\
         | cut | scale | queries | true: Euclidean | likelihood | factor | predicted: Euclidean | likelihood |\n|---|---|---|---|---|---|---|---|",
    );
    let options = MetricOptions::new().poses_only(true);
    for cut in cuts() {
        for (scale, to_area) in [("as in the files", false), ("area 1", true)] {
            let sized = |query: Query, area: f64| {
                let size = if to_area { area } else { 1.0 };
                Query { spectrum: query.spectrum.map(|x| size * x), ..query }
            };
            let gallery = shapes.iter().map(|shape| sized(shape.query, shape.area)).collect();
            let of_cut = |done: &&Done| done.cut == cut && done.complete();
            let queries: Vec<Query> = shapes
                .iter()
                .flat_map(|shape| shape.pairs.iter().filter(of_cut).map(move |done| (shape, done)))
                .map(|(shape, done)| {
                    sized(Query { spectrum: done.predicted, ..shape.query }, shape.area)
                })
                .collect();
            // The others have too few.
            if queries.len() < shapes.len() / 2 {
                continue;
            }
            let count = queries.len();
            let study = RetrievalStudy::of_shapes(gallery, queries)?;
            let truth =
                [study.euclidean(Source::True)?, study.by_likelihood(Source::True, &options)?];
            let [true_e, true_l] = truth.map(|found| 100.0 * found.top[0]);
            for factor in FACTORS {
                let found = study.improved(factor, &options)?;
                let [e, l] = found.map(|found| 100.0 * found.top[0]);
                report.say(&format!(
                    "| {} | {scale} | {count} | {true_e:.0} | {true_l:.0} | x {factor} | {e:.0} | {l:.0} |",
                    cut.name
                ));
                for (distance, top) in [("Euclidean", e), ("likelihood", l)] {
                    report.lines.push(format!(
                        "faust retrieval x {factor} {scale},{distance},{},,,,,,{:.4}",
                        cut.name.replace(',', ""),
                        top / 100.0
                    ));
                }
            }
        }
    }
    Ok(())
}
