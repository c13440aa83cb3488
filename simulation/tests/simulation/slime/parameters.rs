//! Table 3.1 of the thesis: what each parameter does to the pattern, on a flat square. It stands
//! for a quarter of a larger one, so lengths are twice those of the table.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_simulation::texture::slime::{Options, Pattern, Simulation};

use super::support::{options, simulation, square};

const SIZE: usize = 256;
/// Pheromone above this is part of the pattern.
const THRESHOLD: f32 = 0.3;

fn grown(change: impl Fn(&mut Options)) -> Simulation {
    let small = options(25_000, SIZE);
    let mut options = small.movement_speed(3.0).vision_distance(2.0);
    change(&mut options);
    let mut all = simulation(square(8), &options);
    all.run(200, Par::all(), Progress::none()).unwrap();
    all
}

fn pattern(change: impl Fn(&mut Options)) -> Pattern {
    Pattern::of(grown(change).texture(0), SIZE, THRESHOLD).unwrap()
}

#[test]
fn movement_speed_scales_the_pattern_up() {
    let [slow, fast] = [2.0, 4.0].map(|v| pattern(|o| o.movement_speed = v).gap);
    assert!(fast > 1.05 * slow, "{slow} {fast}");
}

#[test]
fn vision_distance_makes_cells() {
    let [near, far] = [0.8, 4.0].map(|v| pattern(|o| o.vision_distance = v).cell);
    assert!(far > 1.5 * near, "{near} {far}");
}

#[test]
fn vision_angle_thickens() {
    // Strands as a sparse network has them when it is there; before, what is thick is the noise of
    // the start. Turns of up to 20 degrees a step, not 60: agents that turn by far more than their
    // sensors are apart find no strand.
    let thickness = |vision_angle: f64| {
        let sparse = options(5000, SIZE)
            .movement_speed(3.0)
            .vision_distance(2.0)
            .turn_speed(600.0)
            .vision_angle(vision_angle);
        let mut all = simulation(square(8), &sparse);
        all.run(900, Par::all(), Progress::none()).unwrap();
        Pattern::of(all.texture(0), SIZE, THRESHOLD).unwrap().thickness
    };
    let [narrow, middle, wide] = [10.0, 30.0, 50.0].map(thickness);
    assert!(middle > 1.05 * narrow && wide > 1.03 * middle, "{narrow} {middle} {wide}");
}

#[test]
fn evaporation_breaks_clusters() {
    let [slow, fast] = [0.2, 1.0].map(|v| pattern(|o| o.evaporation_rate = v).cluster);
    assert!(fast < 0.7 * slow, "{slow} {fast}");
}

#[test]
fn turn_speed_keeps_the_pattern_from_settling() {
    let [slow, fast] = [1800.0, 3000.0].map(|speed| {
        let mut all = grown(|o| o.turn_speed = speed);
        let before = all.texture(0).to_vec();
        all.run(10, Par::all(), Progress::none()).unwrap();
        let change = |(a, b): (&f32, &f32)| f64::from((a - b).abs());
        let changed: f64 = before.iter().zip(all.texture(0)).map(change).sum();
        changed / before.iter().map(|&p| f64::from(p)).sum::<f64>()
    });
    assert!(fast > 1.1 * slow, "{slow} {fast}");
}
