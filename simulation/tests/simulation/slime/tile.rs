//! Textures that repeat: the square whose opposite sides are joined.

use catamaran::base::Progress;
use catamaran::{Error, Par};
use catamaran_simulation::texture::slime::{
    Mask, Options, Simulation, State, Surface, TangentStep, Walker, unfold,
};

use super::support::{options, simulation, square};

const SIZE: usize = 128;

/// The mean difference of texels on both sides of the lines between columns (or rows) i - 1 and i,
/// for each i; the first is that over the seam.
fn differences(texture: &[f32], along_rows: bool) -> Vec<f64> {
    let at = |i: usize, j: usize| texture[if along_rows { i * SIZE + j } else { j * SIZE + i }];
    let line = |i: usize| {
        let before = (i + SIZE - 1) % SIZE;
        (0..SIZE).map(|j| f64::from((at(i, j) - at(before, j)).abs())).sum::<f64>() / SIZE as f64
    };
    (0..SIZE).map(line).collect()
}

fn grown(surface: Surface) -> Vec<f32> {
    let options = options(6000, SIZE).vision_distance(2.0).movement_speed(3.0);
    let mut all = simulation(surface, &options);
    all.run(150, Par::all(), Progress::none()).unwrap();
    assert_eq!(all.state().check(all.surface()), Ok(()));
    all.texture(0).to_vec()
}

#[test]
fn a_tile_goes_on_over_its_sides_and_a_square_does_not() {
    let (tile, plain) = (grown(Surface::tile().unwrap()), grown(square(4)));
    for along_rows in [false, true] {
        let lines = differences(&tile, along_rows);
        let inside = lines[1..].iter().sum::<f64>() / (SIZE - 1) as f64;
        let most = lines[1..].iter().copied().fold(0.0, f64::max);
        assert!(lines[0] <= most && lines[0] < 1.3 * inside, "{} {inside} {most}", lines[0]);
        // Side by side with itself, a texture of a bounded square breaks off.
        let lines = differences(&plain, along_rows);
        let inside = lines[1..].iter().sum::<f64>() / (SIZE - 1) as f64;
        assert!(lines[0] > 1.5 * inside, "{} {inside}", lines[0]);
    }
}

#[test]
fn pheromone_spreads_over_the_sides_as_it_does_elsewhere() {
    let settings = options(0, SIZE).evaporation_rate(0.0).diffusion_rate(6.0);
    let spot = |column: usize, row: usize| {
        let mut all = simulation(Surface::tile().unwrap(), &settings);
        let mut texture = vec![0.0; SIZE * SIZE];
        texture[row * SIZE + column] = 1.0;
        all.set_state(State { texture, ..all.state().clone() }).unwrap();
        all.run(20, Par::Seq, Progress::none()).unwrap();
        all.texture(0).to_vec()
    };
    let middle = spot(64, 64);
    for (column, row) in [(0, 0), (127, 3), (5, 127)] {
        let moved = spot(column, row);
        for (t, value) in middle.iter().enumerate() {
            let (i, j) = ((t % SIZE + column + 64) % SIZE, (t / SIZE + row + 64) % SIZE);
            let found = moved[j * SIZE + i];
            assert!((found - value).abs() < 1e-6, "{column} {row}: {found} {value} at {i} {j}");
        }
    }
}

#[test]
fn walks_wrap_around() {
    let tile = Surface::tile().unwrap();
    let start = Walker { triangle: 0, position: [0.05, 0.02], heading: [0.6, 0.8] };
    let uv = |w: &Walker| {
        let r = &tile.records()[w.triangle as usize];
        [21, 24].map(|k| r[k] + r[k + 1] * w.position[0] + r[k + 2] * w.position[1])
    };
    let from = uv(&start);
    // The frame of a face is turned in the texture; its first edge says how.
    let end = unfold(&tile, start, 5.0, true);
    let [[u0, v0], [u1, v1], _] = tile.uv()[0].map(|p| p.map(|x| x as f32));
    let length = (u1 - u0).hypot(v1 - v0);
    let (cos, sin) = ((u1 - u0) / length, (v1 - v0) / length);
    let way = [5.0 * (0.6 * cos - 0.8 * sin), 5.0 * (0.6 * sin + 0.8 * cos)];
    for (k, found) in uv(&end).into_iter().enumerate() {
        let expected = (from[k] + way[k]).rem_euclid(1.0);
        let off = (found - expected).abs();
        assert!(off.min(1.0 - off) < 1e-5, "{found} {expected}");
    }
}

#[test]
fn projected_steps_are_refused_on_a_tile() {
    let options: Options = options(5, 32).tangent_step(TangentStep::Project { substeps: 4 });
    let tile = Surface::tile().unwrap();
    assert!(tile.is_tile() && !square(2).is_tile());
    let refused = Simulation::new(tile, &options, &Mask::default()).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "tangent_step", .. }), "{refused}");
}
