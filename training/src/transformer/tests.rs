use catamaran::Par;
use catamaran::base::Rng;
use catamaran::io::Overwrite;

use super::backward::Gradient;
use super::train::{BATCH, warm_restarts};
use super::*;

/// Returns spectra of one shape in many sizes, whose areas add up.
fn scaled(count: usize) -> Vec<Pair> {
    let mut rng = Rng::new(5);
    let of_area = |area: f64| std::array::from_fn(|i| (i + 1 + i % 2) as f64 / area);
    (0..count)
        .map(|_| {
            let [a, b] = [1.0 + rng.uniform(), 1.0 + rng.uniform()];
            Pair { first: of_area(a), second: of_area(b), union: of_area(a + b), regions: None }
        })
        .collect()
}

fn small(epochs: usize, par: Par) -> TransformerOptions {
    TransformerOptions { epochs, par, ..TransformerOptions::default() }
}

/// Returns a weighted sum of the outputs of a network for random offsets, and its gradient.
fn value_and_gradient(layout: &Layout, parameters: &[f64]) -> (f64, Vec<f64>) {
    let mut rng = Rng::new(4);
    let mut tape = Tape::new(layout, 2);
    tape.offsets.iter_mut().for_each(|x| *x = 2.0 * rng.uniform());
    let weights: Vec<f64> = tape.output.iter().map(|_| rng.normal()).collect();
    forward(layout, parameters, &mut tape);
    let value = tape.output.iter().zip(&weights).map(|(a, b)| a * b).sum();
    let mut gradient = Gradient::new(layout);
    gradient.run(layout, parameters, &tape, &weights);
    (value, std::mem::take(gradient.values()))
}

#[test]
fn gradients_are_those_of_finite_differences() {
    let layout = Layout::new([2, 1]);
    let mut rng = Rng::new(2);
    let mut parameters: Vec<f64> =
        layout.initial(1).iter().map(|&x| f64::from(x) + 0.2 * rng.normal()).collect();
    let (_, gradient) = value_and_gradient(&layout, &parameters);
    for (name, parameter) in &layout.named {
        for _ in 0..3 {
            let at = parameter.start + (rng.uniform() * parameter.range().len() as f64) as usize;
            let before = parameters[at];
            let step = 1e-6;
            let mut at_step = |sign: f64| {
                parameters[at] = before + sign * step;
                value_and_gradient(&layout, &parameters).0
            };
            let slope = (at_step(1.0) - at_step(-1.0)) / (2.0 * step);
            parameters[at] = before;
            let error = (slope - gradient[at]).abs();
            assert!(error < 1e-6 * (1.0 + slope.abs()), "{name} {at}: {slope} {}", gradient[at]);
        }
    }
}

#[test]
fn sizes_are_those_of_the_thesis() {
    let layout = Layout::new(LAYERS);
    let attention = 2 * 32 + 4 * (32 * 32 + 32);
    let hidden = |count: usize| 2 * 32 + 2 * 32 * count + count + 32;
    let stacks = 6 * (2 * attention + hidden(64)) + 3 * (attention + hidden(32)) + 2 * 2 * 32;
    assert_eq!(layout.len, 20 * 16 + 15 + stacks + 33);
}

#[test]
fn predictions_commute_bit_for_bit_and_ascend() {
    let layout = Layout::new(LAYERS);
    let transformer = Transformer { parameters: layout.initial(3), layout };
    for Pair { first, second, .. } in scaled(3) {
        let found = transformer.predict(&first, &second).unwrap();
        assert_eq!(found, transformer.predict(&second, &first).unwrap());
        assert!(found[0] > 0.0 && found.is_sorted());
    }
}

#[test]
fn predictions_have_the_units_of_their_inputs() {
    let layout = Layout::new(LAYERS);
    let transformer = Transformer { parameters: layout.initial(3), layout };
    let Pair { first, second, .. } = scaled(1)[0];
    let found = transformer.predict(&first, &second).unwrap();
    let twice = transformer.predict(&first.map(|x| 2.0 * x), &second.map(|x| 2.0 * x)).unwrap();
    assert_eq!(found.map(|x| 2.0 * x), twice);
}

#[test]
fn a_few_steps_reduce_the_loss_for_any_number_of_threads() {
    let pairs = scaled(BATCH + 10);
    let run = |par| {
        let mut losses = Vec::new();
        let layout = Layout::new([1, 1]);
        let found = train::train(layout, [&pairs, &pairs[..20]], &small(9, par), |_, loss| {
            losses.push(loss);
            ControlFlow::Continue(())
        });
        (found.unwrap(), losses)
    };
    let (one, losses) = run(Par::Seq);
    assert!(losses[8].validation < 0.6 * losses[0].validation, "{losses:?}");
    let (two, others) = run(Par::Threads(2));
    assert_eq!((one.parameters, losses), (two.parameters, others));
}

#[test]
fn time_and_callback_end_the_training_and_the_best_parameters_are_kept() {
    let pairs = scaled(20);
    // The training moves away from these parameters.
    let others: Vec<Pair> = pairs.iter().map(|pair| Pair { union: [0.0; K], ..*pair }).collect();
    let run = |minutes, last| {
        let options = TransformerOptions { minutes, ..small(4, Par::Seq) };
        let mut losses = Vec::new();
        let watch = |epoch, loss: Losses| {
            losses.push(loss.validation);
            if epoch == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let found = train::train(Layout::new([1, 0]), [&pairs, &others], &options, watch).unwrap();
        (losses, found.parameters)
    };
    let (losses, best) = run(f64::INFINITY, 9);
    assert!(losses.len() == 4 && losses.is_sorted(), "{losses:?}");
    assert_eq!(run(f64::INFINITY, 1).0, losses[..2]);
    assert_eq!(run(0.0, 9), (losses[..1].to_vec(), best));
    let none = Transformer::train(&[], &pairs, &small(1, Par::Seq), |_, _| ControlFlow::Break(()));
    assert!(none.unwrap_err().to_string().starts_with("training"));
}

#[test]
fn rates_begin_again_after_ten_thirty_and_seventy_epochs() {
    for start in [0.0, 10.0, 30.0, 70.0] {
        assert_eq!(warm_restarts(start), 1.0);
    }
    for (middle, share) in [(5.0, 0.5), (20.0, 0.5), (50.0, 0.5), (9.999, 0.0), (29.999, 0.0)] {
        assert!((warm_restarts(middle) - share).abs() < 1e-6);
    }
}

#[test]
fn files_keep_the_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let path = &folder.path().join("t.npz");
    let layout = Layout::new(LAYERS);
    let transformer = Transformer { parameters: layout.initial(3), layout };
    transformer.write(Output::create(path, Overwrite::Never).unwrap()).unwrap();
    let again = Transformer::read(path).unwrap();
    assert_eq!(again.parameters, transformer.parameters);
    let other = Transformer { parameters: vec![0.0; 5], ..transformer };
    other.write(Output::create(path, Overwrite::Replace).unwrap()).unwrap();
    let why = Transformer::read(path).unwrap_err().to_string();
    assert!(why.contains("finite numbers"), "{why}");
}
