use super::*;
use catamaran::base::Rng;

const LOGS: usize = 19;

fn base() -> Vec<f64> {
    (0..LOGS).map(|i| i as f64).collect()
}

fn plus(mut logs: Vec<f64>, at: usize, length: f64) -> Vec<f64> {
    logs[at] += length;
    logs
}

/// Returns the spectrum with these logarithms, of a closed shape.
fn spectrum(logs: &[f64]) -> Vec<f64> {
    [0.0].into_iter().chain(logs.iter().map(|x| x.exp())).collect()
}

/// Spectra and identities.
type Shapes = (Vec<Vec<f64>>, Vec<usize>);

/// Returns two identities for each logarithm, which differ from the mean by plus or minus
/// `apart` in this logarithm, each in two poses that add plus or minus `turned`, and five
/// identities that are the mean, in one pose.
fn shapes(apart: f64, turned: f64) -> Shapes {
    let (mut spectra, mut identities) = (Vec::new(), Vec::new());
    for at in 0..LOGS {
        for (number, own) in [apart, -apart].into_iter().enumerate() {
            for pose in [turned, -turned] {
                spectra.push(spectrum(&plus(base(), at, own + pose)));
                identities.push(2 * at + number);
            }
        }
    }
    for i in 0..5 {
        spectra.push(spectrum(&base()));
        identities.push(100 + i);
    }
    (spectra, identities)
}

/// Returns errors with the mean `mean` and the independent deviations `0.01 (i + 1)`.
fn errors(mean: f64) -> Vec<Vec<f64>> {
    let length = |i: usize| 0.01 * (i + 1) as f64 * (LOGS as f64).sqrt();
    let of = |i: usize| [length(i), -length(i)].map(|x| plus(vec![mean; LOGS], i, x));
    (0..LOGS).flat_map(of).collect()
}

fn fit(shapes: &Shapes, errors: &[Vec<f64>], options: &MetricOptions) -> RetrievalMetric {
    RetrievalMetric::fit(&shapes.0, &shapes.1, errors, options).unwrap()
}

#[test]
fn distances_are_those_of_the_conditional_distribution() {
    let (apart, turned) = (0.5, 0.1);
    let options = MetricOptions::new().shrinkage(0.25);
    let shapes = shapes(apart, turned);
    let metric = fit(&shapes, &errors(0.02), &options);
    let n = LOGS as f64;
    // 4 of 4 n + 5 shapes differ from the mean in each logarithm, 4 of the 4 n in several poses
    // from their identities; the variance of two poses is twice the square.
    let within = 2.0 * turned * turned / n + NOISE;
    let total = 4.0 * (apart * apart + turned * turned) / (4.0 * n + 5.0) + NOISE;
    let mean_variance = (1..=LOGS).map(|i| 1e-4 * (i * i) as f64).sum::<f64>() / n;
    for i in [0, 7, 18] {
        let error = 0.75 * 1e-4 * ((i + 1) * (i + 1)) as f64 + 0.25 * mean_variance;
        let scatter = 2.0 * within - within * within / total + error;
        for (query, shape) in [(0.3, 0.3), (0.1, -0.2)] {
            let off: Vec<f64> = base().iter().map(|x| x + 0.02).collect();
            let found = metric
                .distance(&spectrum(&plus(off, i, query)), &spectrum(&plus(base(), i, shape)))
                .unwrap();
            let apart = query - (1.0 - within / total) * shape;
            let expected = apart.abs() / scatter.sqrt();
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}

#[test]
fn the_covariance_within_identities_is_found() {
    let factor = [[0.1, 0.0, 0.0], [0.05, 0.08, 0.0], [0.0, 0.02, 0.05]];
    let by = |z: [f64; 3]| factor.map(|row| row.iter().zip(z).map(|(f, z)| f * z).sum::<f64>());
    let mut rng = Rng::new(4);
    let (mut spectra, mut identities) = (Vec::new(), Vec::new());
    for identity in 0..500 {
        let own: [f64; 3] = std::array::from_fn(|_| rng.normal());
        for _ in 0..3 {
            let pose = by(std::array::from_fn(|_| rng.normal()));
            let logs: Vec<f64> = own.iter().zip(pose).map(|(x, y)| x + y).collect();
            spectra.push(spectrum(&logs));
            identities.push(identity);
        }
    }
    let here = spectrum(&[0.0; 3]);
    // The variance of the difference of two poses is twice that of one.
    for (poses_only, tolerance) in [(true, 0.1), (false, 0.15)] {
        let options = MetricOptions::new().poses_only(poses_only);
        let metric = fit(&(spectra.clone(), identities.clone()), &[], &options);
        for z in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, -1.0, 1.0]] {
            let found = metric.distance(&spectrum(&by(z)), &here).unwrap();
            let expected = (z.iter().map(|x| x * x).sum::<f64>() / 2.0).sqrt();
            assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected}");
        }
    }
}

#[test]
fn poses_in_common_cost_little_and_other_differences_much() {
    // Poses change all logarithms together.
    let by = |x: f64| base().iter().map(|logarithm| logarithm + x).collect::<Vec<f64>>();
    let (mut spectra, mut identities) = shapes(0.5, 0.0);
    spectra.extend([0.3, -0.3].map(|x| spectrum(&by(x))));
    identities.extend([1000; 2]);
    let metric = fit(&(spectra, identities), &[], &MetricOptions::new());
    let here = spectrum(&base());
    let together = metric.distance(&spectrum(&by(0.1)), &here).unwrap();
    let alone = metric.distance(&spectrum(&plus(base(), 4, 0.1)), &here).unwrap();
    assert!(20.0 * together < alone, "{together} {alone}");
}

#[test]
fn the_size_may_be_left_out() {
    let (one, other) = (spectrum(&base()), spectrum(&plus(base(), 3, 0.2)));
    let larger: Vec<f64> = one.iter().map(|x| 3.0 * x).collect();
    let metric = fit(&shapes(0.5, 0.1), &errors(0.0), &MetricOptions::new().scale_free(true));
    let apart = metric.distance(&one, &other).unwrap();
    assert!(metric.distance(&one, &one).unwrap() < 1e-9 && apart > 0.1);
    assert!((metric.distance(&larger, &other).unwrap() - apart).abs() < 1e-9);
    let metric = fit(&shapes(0.5, 0.1), &errors(0.0), &MetricOptions::new());
    assert!(metric.distance(&larger, &one).unwrap() > 10.0);
}

#[test]
fn deviations_estimate_the_covariance_without_bias() {
    let logs = [vec![1.0; 2], vec![1.0; 2], vec![4.0; 2]];
    let found = Poses::new(&logs, &[4, 2, 4]);
    assert_eq!((found.identities, found.further, found.deviations.len()), (2, 1, 2));
    // The variance of 1 and 4 is 4.5.
    let squares: f64 = found.deviations.iter().map(|deviation| deviation[1].powi(2)).sum();
    assert!((squares / 2.0 - 4.5).abs() < 1e-12);
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let refused = |shapes: &Shapes, errors: &[Vec<f64>], options: MetricOptions| {
        RetrievalMetric::fit(&shapes.0, &shapes.1, errors, &options).unwrap_err().to_string()
    };
    let new = MetricOptions::new;
    let all = shapes(0.5, 0.1);
    assert!(refused(&all, &[], new().shrinkage(1.5)).starts_with("shrinkage"));
    assert!(refused(&all, &[], new().zeros(20)).starts_with("zeros: must be less than"));
    let nan = refused(&all, &[vec![f64::NAN; LOGS]], new());
    assert!(nan.starts_with("errors: not finite at row 0"), "{nan}");
    assert!(refused(&all, &[vec![1e200; LOGS], vec![0.0; LOGS]], new()).contains("differ"));
    let mut zero = all.clone();
    zero.0[3][1] = 1e-14;
    let zero = refused(&zero, &[], new());
    assert!(zero.contains("must be positive, but spectrum 3 (from 0) has 1e-14"), "{zero}");
    let mut short = all.clone();
    short.1.pop();
    assert!(refused(&short, &[], new()).starts_with("identities: expected 81 x 1"));
}

#[test]
fn few_identities_and_poses_are_refused_with_the_number_needed() {
    let (spectra, identities) = shapes(0.5, 0.1);
    let of = |count: usize, errors: &[Vec<f64>], poses_only| {
        let options = MetricOptions::new().poses_only(poses_only);
        RetrievalMetric::fit(&spectra[..count], &identities[..count], errors, &options)
    };
    // 38 identities in two poses, then others in one.
    assert!(of(79, &[], false).is_ok());
    let refused = of(78, &[], false).unwrap_err().to_string();
    assert!(refused.contains("at least 41 identities, are of 40"), "{refused}");
    assert!(refused.contains("poses_only"), "{refused}");
    assert!(of(38, &[], true).is_ok());
    let refused = of(36, &[], true).unwrap_err().to_string();
    assert!(refused.contains("at least 19 poses beside their first ones, have 18"), "{refused}");
    // Errors of predictions are a covariance of their own.
    assert!(of(2, &errors(0.0), true).is_ok());
    let refused = of(1, &errors(0.0), true).unwrap_err().to_string();
    assert!(refused.contains("at least 1 poses"), "{refused}");
}

#[test]
fn a_file_gives_the_same_metric_and_broken_ones_are_refused() {
    let options = MetricOptions::new().scale_free(true).spectrum("of people");
    let metric = fit(&shapes(0.5, 0.1), &errors(0.02), &options);
    assert_eq!((metric.k(), metric.zeros(), metric.spectrum()), (20, 1, "of people"));
    let text = String::from_utf8(metric.to_bytes().unwrap()).unwrap();
    assert_eq!(RetrievalMetric::from_bytes(text.as_bytes()).unwrap(), metric);
    let small = fit(
        &(vec![vec![0.0, 1.0], vec![0.0, 2.0]], vec![0, 0]),
        &[],
        &MetricOptions::new().poses_only(true),
    );
    let text = String::from_utf8(small.to_bytes().unwrap()).unwrap();
    let broken = |from: &str, to: &str| {
        assert!(text.contains(from), "{text}");
        let bytes = text.replacen(from, to, 1).into_bytes();
        RetrievalMetric::from_bytes(&bytes).unwrap_err().to_string()
    };
    for (from, to, says) in [
        ("\"version\": 1", "\"version\": 2", "has version 2, only 1"),
        ("retrieval metric", "model", "its format is \"catamaran model\""),
        ("\"shape_mean\": [", "\"shape_mean\": [0.5,", "query_mean: must have 2 numbers, has 1"),
        ("\"of_query\": [", "\"of_query\": [[0.5],", "of_query: must have 1 rows, has 2"),
        ("\"of_shape\": [", "\"of_shape\": [[],", "of_shape: must have 1 rows, has 2"),
        ("\"zeros\": 1", "\"zeros\": 18446744073709551615", "too many zeros"),
        ("\"zeros\": 1", "\"zeros\": -1", "not a metric"),
        ("\"zeros\": 1", "\"more\": 1", "unknown field"),
        ("\"query_mean\": [", "\"query_mean\": [1e999,", "not a metric"),
        ("{", "", "not a metric"),
    ] {
        let refused = broken(from, to);
        assert!(refused.contains(says), "{refused}");
    }
    assert!(RetrievalMetric::from_bytes(&text.as_bytes()[..text.len() / 2]).is_err());
    assert!(
        RetrievalMetric::read(Path::new("none.json")).unwrap_err().to_string().contains("none")
    );
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let metric = fit(&shapes(0.5, 0.1), &[], &MetricOptions::new());
    let whole = spectrum(&base());
    let refused =
        |query: &[f64], shape: &[f64]| metric.distance(query, shape).unwrap_err().to_string();
    assert!(refused(&whole[..7], &whole).starts_with("query: expected 20 x 1, got 7 x 1"));
    let mut other = whole.clone();
    other[1] = -1.0;
    assert!(refused(&whole, &other).starts_with("shape: eigenvalues behind"));
    other[1] = f64::INFINITY;
    assert!(refused(&whole, &other).starts_with("shape: not finite"));
}
