//! What texels are on the surface, how agents are spread, and how pheromone spreads.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::mesh::families;
use catamaran_simulation::texture::slime::{
    BORDER, Blur, INSIDE, NO_TRIANGLE, OUTSIDE, Options, State, Surface, Texels,
};

use super::support::{options, simulation, square, with_atlas};

#[test]
fn texels_cover_the_surface_once() {
    for (surface, size) in [
        (square(3), 32),
        (square(7), 160),
        (with_atlas(&families::torus(12, 8, 2.0, 0.5).unwrap(), 256), 256),
    ] {
        let texels = Texels::new(&surface, size).unwrap();
        let sum: f64 = texels.areas().iter().map(|&a| f64::from(a)).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        for t in 0..size * size {
            let owned = texels.owners()[t] != NO_TRIANGLE;
            assert_eq!(owned, texels.kinds()[t] != OUTSIDE);
            assert!(owned || texels.areas()[t] == 0.0);
        }
    }
    // In the square all texels are alike.
    let texels = Texels::new(&square(3), 32).unwrap();
    assert!(texels.areas().iter().all(|a| (a * 1024.0 - 1.0).abs() < 1e-5));
    let inside = texels.kinds().iter().filter(|&&k| k == INSIDE).count();
    let border = texels.kinds().iter().filter(|&&k| k == BORDER).count();
    assert_eq!((inside, border), (30 * 30, 124));
}

#[test]
fn agents_start_evenly_by_area_and_direction() {
    let mut all = simulation(square(8), &options(40_000, 64));
    // The first step orders them; the start is what was before.
    let state = all.state().clone();
    let mut quarters = [0_usize; 4];
    let mut headings = [0_usize; 8];
    for i in 0..state.ids.len() {
        let w = state.agent(i);
        let r = &all.surface().records()[w.triangle as usize];
        let [x, y] = w.position;
        let (u, v) = (r[21] + r[22] * x + r[23] * y, r[24] + r[25] * x + r[26] * y);
        quarters[usize::from(u > 0.5) + 2 * usize::from(v > 0.5)] += 1;
        let angle = f64::from(w.heading[1]).atan2(f64::from(w.heading[0])) / std::f64::consts::TAU;
        headings[((angle + 0.5) * 8.0) as usize % 8] += 1;
    }
    // Six standard deviations: 520 of 10,000 and 397 of 5,000.
    assert!(quarters.iter().all(|q| q.abs_diff(10_000) < 520), "{quarters:?}");
    assert!(headings.iter().all(|h| h.abs_diff(5_000) < 397), "{headings:?}");
    all.step(Par::Seq);
    let mut ids = all.state().ids.clone();
    ids.sort_unstable();
    assert!(ids.iter().zip(0..).all(|(&id, i)| id == i));
}

/// Without agents and without evaporation: pheromone is only blurred, fast.
fn still() -> Options {
    Options::new().agents(0).size(128).evaporation_rate(0.0).diffusion_rate(30.0)
}

/// What is in the texture before and after it was blurred for a while, 1 at first in these texels.
fn spread(surface: Surface, from: &[usize]) -> (f64, f64) {
    let mut all = simulation(surface, &still());
    let mut texture = vec![0.0; 128 * 128];
    from.iter().for_each(|&t| texture[t] = 1.0);
    let sum = |state: &State| state.texture.iter().map(|&p| f64::from(p)).sum::<f64>();
    let state = State { texture, ..all.state().clone() };
    let before = sum(&state);
    all.set_state(state).unwrap();
    all.run(60, Par::Seq, Progress::none()).unwrap();
    assert!(all.state().texture.iter().all(|p| (0.0..=1.0).contains(p)));
    (before, sum(all.state()))
}

#[test]
fn the_seam_aware_blur_keeps_the_sum() {
    let torus = || with_atlas(&families::torus(8, 6, 2.0, 0.7).unwrap(), 128);
    let texels = Texels::new(&torus(), 128).unwrap();
    let owned: Vec<usize> = (0..128 * 128).filter(|&t| texels.kinds()[t] != OUTSIDE).collect();
    let from: Vec<usize> = owned.iter().copied().step_by(7).collect();
    let (before, after) = spread(torus(), &from);
    assert!((after / before - 1.0).abs() < 1e-5, "{before} {after}");
    let (before, after) = spread(torus(), &owned);
    assert!((after / before - 1.0).abs() < 1e-5, "even is even: {before} {after}");
}

#[test]
fn the_seam_aware_blur_crosses_seams() {
    let surface = with_atlas(&families::icosphere(1).unwrap(), 128);
    let texels = Texels::new(&surface, 128).unwrap();
    let charts = |all: &[f32]| {
        let mut reached: Vec<u32> = (0..128 * 128)
            .filter(|&t| all[t] > 0.0 && texels.owners()[t] != NO_TRIANGLE)
            .map(|t| surface.charts()[texels.owners()[t] as usize])
            .collect();
        reached.sort_unstable();
        reached.dedup();
        reached.len()
    };
    let mut all = simulation(surface.clone(), &still());
    let mut texture = vec![0.0; 128 * 128];
    let start = texels.kinds().iter().position(|&k| k == INSIDE).unwrap();
    texture[start] = 1.0;
    all.set_state(State { texture, ..all.state().clone() }).unwrap();
    all.run(200, Par::Seq, Progress::none()).unwrap();
    // All 80 triangles are charts, and pheromone came to all.
    assert_eq!(charts(&all.state().texture), 80);
}

#[test]
fn inside_of_a_chart_both_blurs_are_the_same() {
    let run = |blur: Blur| {
        let options = options(500, 64).blur(blur);
        let mut all = simulation(square(4), &options);
        all.run(3, Par::Seq, Progress::none()).unwrap();
        all.state().texture.clone()
    };
    let (gaussian, aware) = (run(Blur::Gaussian), run(Blur::SeamAware));
    // Three steps carry what the border does three texels inside.
    for row in 4..60 {
        let inside = 64 * row + 4..64 * row + 60;
        assert_eq!(gaussian[inside.clone()], aware[inside]);
    }
}

#[test]
fn evaporation_is_what_it_says() {
    let options = Options::new().agents(0).size(32).time_step(0.125).evaporation_rate(0.5);
    let mut all = simulation(square(2), &options);
    let texture = vec![0.5; 32 * 32];
    all.set_state(State { texture, ..all.state().clone() }).unwrap();
    let coverage = all.coverage(Par::Seq)[0];
    assert!((coverage.coverage - 0.5).abs() < 1e-6 && (coverage.presence - 1.0).abs() < 1e-6);
    for step in 1..=9 {
        all.step(Par::Seq);
        let expected = (0.5 - 0.0625 * step as f32).max(0.0);
        assert!(all.state().texture.iter().all(|&p| p == expected), "step {step}");
    }
    assert_eq!(all.coverage(Par::Seq)[0].presence, 0.0);
}
