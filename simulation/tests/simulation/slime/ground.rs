//! Species, obstacles and attractors.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_simulation::texture::slime::{FREE, GOAL, Mask, OBSTACLE, Simulation};

use super::support::{options, simulation, square};

const SIZE: usize = 64;

/// The texel of each agent.
fn places(all: &Simulation) -> Vec<usize> {
    let state = all.state();
    let of = |i: usize| {
        let w = state.agent(i);
        let r = &all.surface().records()[w.triangle as usize];
        let [x, y] = w.position;
        let at = |c: f32| ((c * SIZE as f32) as usize).min(SIZE - 1);
        at(r[24] + r[25] * x + r[26] * y) * SIZE + at(r[21] + r[22] * x + r[23] * y)
    };
    (0..state.ids.len()).map(of).collect()
}

/// A wall from below with a door at the top, a start on its left, an attractor on its right.
fn mask() -> Mask {
    let (mut start, mut ground) = (Vec::new(), Vec::new());
    for t in 0..SIZE * SIZE {
        let (x, y) = (t % SIZE, t / SIZE);
        start.push(x < 8 && y < 8);
        ground.push(match x {
            30..=33 if y < 52 => OBSTACLE,
            54.. if y < 10 => GOAL,
            _ => FREE,
        });
    }
    Mask { start, ground }
}

#[test]
fn agents_go_around_walls_and_stay_where_they_want_to_be() {
    let options = options(2000, SIZE)
        .species(3)
        .movement_speed(30.0)
        .vision_distance(6.0)
        // Trails that last keep agents where they are.
        .evaporation_rate(3.0);
    let mut all = Simulation::new(square(6), &options, &mask()).unwrap();
    let ground = mask().ground;
    assert!(places(&all).iter().all(|&t| t % SIZE < 8 && t / SIZE < 8));
    let arrived = |all: &Simulation| places(all).iter().filter(|&&t| ground[t] == GOAL).count();
    let mut before = 0;
    for _ in 0..20 {
        all.run(40, Par::all(), Progress::none()).unwrap();
        assert!(places(&all).iter().all(|&t| ground[t] != OBSTACLE));
        let now = arrived(&all);
        assert!(now >= before, "an agent left the attractor");
        before = now;
    }
    assert!(before > 50, "{before} of 2000 found the way");
}

#[test]
fn species_keep_apart() {
    let options = options(6000, 128).species(2);
    let mut all = simulation(square(4), &options);
    all.run(120, Par::all(), Progress::none()).unwrap();
    let (a, b) = (all.texture(0), all.texture(1));
    let product: f32 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    let [first, second] = [a, b].map(|t| t.iter().sum::<f32>());
    // If one did not care for the other, the mean of the product would be the product of the means.
    let careless = first * second / a.len() as f32;
    assert!(product < 0.5 * careless, "{product} {careless}");
}

#[test]
fn masks_that_do_not_fit_are_refused() {
    let refused = |mask: Mask| Simulation::new(square(2), &options(5, SIZE), &mask).unwrap_err();
    let error = refused(Mask { start: vec![true; 9], ground: vec![] }).to_string();
    assert!(error.contains("mask.start"), "{error}");
    let error = refused(Mask { start: vec![], ground: vec![7; SIZE * SIZE] }).to_string();
    assert!(error.contains("mask.ground") && error.contains('7'), "{error}");
    let error = refused(Mask { start: vec![], ground: vec![OBSTACLE; SIZE * SIZE] }).to_string();
    assert!(error.contains("no texel"), "{error}");
}
