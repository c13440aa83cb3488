use std::ops::ControlFlow;

use super::super::session::{DeviceTimes, tests::device};
use super::*;
use crate::texture::slime::{
    Blur, FREE, GOAL, Mask, OBSTACLE, Options, Surface, TangentStep, atlas,
};
use catamaran::base::{Par, Progress};
use catamaran_geometry::mesh::io::Attribute;
use catamaran_geometry::mesh::{TriMesh, families};

const SIZE: usize = 128;

/// Inverse share of agents and entries of the texture that may differ. On devices that round
/// correctly, as processors do, none differs.
const BUDGET: usize = 4_000;

fn options() -> Options {
    Options {
        agents: 3_001,
        size: SIZE,
        vision_distance: 4.0,
        movement_speed: 30.0,
        ..Options::default()
    }
}

fn in_atlas(mesh: &TriMesh) -> Surface {
    Surface::of_faces(mesh, atlas(mesh, SIZE).unwrap()).unwrap()
}

/// Returns a square that is its own texture, with a boundary.
fn square() -> Surface {
    let mesh = families::grid(12, 12).unwrap();
    let values = mesh.vertices().iter().map(|p| [p[0] / 12.0, p[1] / 12.0]).collect();
    Surface::new(&mesh, &Attribute { values, corners: None }).unwrap()
}

/// Returns the agents in the order of their numbers.
fn agents(state: &State) -> Vec<(u32, [f32; 2], [f32; 2])> {
    let mut all = vec![(0, [0.0; 2], [0.0; 2]); state.ids.len()];
    for (i, &id) in state.ids.iter().enumerate() {
        all[id as usize] = (state.triangles[i], state.positions[i], state.headings[i]);
    }
    all
}

fn compare(
    device: &Device,
    surface: &Surface,
    options: &Options,
    mask: &Mask,
    group: Option<usize>,
) {
    let mut twin = Simulation::new(surface.clone(), options, mask).unwrap();
    let mut kernels = SlimeOnDevice::in_groups(device, &twin, group).unwrap();
    // The agents are ordered twice.
    let steps = EVERY + 2;
    twin.run(steps, Par::Threads(2), Progress::none()).unwrap();
    kernels.run(steps, Progress::none()).unwrap();
    let (expected, found) = (twin.state(), kernels.state().unwrap());
    assert_eq!(found.step, expected.step);
    assert!(found.ids.is_sorted());
    found.check(twin.surface()).unwrap();
    let pairs = agents(expected).into_iter().zip(agents(&found));
    let moved = pairs.filter(|(a, b)| a != b).count();
    let texels = expected.texture.iter().zip(&found.texture).filter(|(a, b)| a != b).count();
    let (all, entries) = (expected.ids.len(), expected.texture.len());
    println!("{options:?} {group:?}: {moved} of {all} agents, {texels} of {entries} texels differ");
    assert!(moved <= all / BUDGET && texels <= entries / BUDGET, "{options:?}");
    assert!(expected.texture.iter().any(|&x| x > 0.1), "there is nothing to compare");
    if texels == 0 {
        assert_eq!(kernels.coverage().unwrap(), twin.coverage(Par::Seq));
    }
}

#[test]
fn kernels_do_what_their_twins_do() {
    let Some(device) = device() else { return };
    let sphere = in_atlas(&families::icosphere(2).unwrap());
    let moebius = in_atlas(&families::moebius(24, 3).unwrap());
    let none = Mask::default();
    for surface in [&sphere, &moebius, &square()] {
        compare(&device, surface, &options(), &none, None);
        let other = Options {
            tangent_step: TangentStep::Project { substeps: 10 },
            blur: Blur::Gaussian,
            length_rescaling: false,
            species: 3,
            seed: 7,
            ..options()
        };
        compare(&device, surface, &other, &none, None);
    }
    let project = TangentStep::Project { substeps: 3 };
    compare(
        &device,
        &sphere,
        &Options { tangent_step: project, species: 2, ..options() },
        &none,
        None,
    );
    compare(&device, &moebius, &Options { length_rescaling: false, ..options() }, &none, None);
}

#[test]
fn obstacles_and_attractors_are_the_same_on_devices() {
    let Some(device) = device() else { return };
    let ground = |t: usize| match (t % SIZE, t / SIZE) {
        (30..=40, 10..=100) => OBSTACLE,
        (90..=100, 90..=100) => GOAL,
        _ => FREE,
    };
    let all = 0..SIZE * SIZE;
    let mask = Mask {
        start: all.clone().map(|t| t % SIZE < 30).collect(),
        ground: all.map(ground).collect(),
    };
    compare(&device, &square(), &Options { species: 2, ..options() }, &mask, None);
}

#[test]
fn groups_of_any_size_give_the_same() {
    let Some(device) = device() else { return };
    let surface = square();
    for group in [1, 64, 256] {
        for agents in [1, 127, 3_001] {
            let options = Options { agents, ..options() };
            compare(&device, &surface, &options, &Mask::default(), Some(group));
        }
    }
    let simulation = Simulation::new(surface, &options(), &Mask::default()).unwrap();
    assert!(SlimeOnDevice::in_groups(&device, &simulation, Some(0)).is_err());
}

#[test]
fn a_run_that_is_cancelled_goes_on() {
    let Some(device) = device() else { return };
    let simulation = Simulation::new(square(), &options(), &Mask::default()).unwrap();
    let mut stopped = SlimeOnDevice::new(&device, &simulation).unwrap();
    let stop = |fraction: f64| {
        if fraction > 0.2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    assert_eq!(stopped.run(8, (&stop).into()), Err(Error::Cancelled));
    assert_eq!(stopped.state().unwrap().step, 2);
    stopped.run(6, Progress::none()).unwrap();
    let mut whole = SlimeOnDevice::new(&device, &simulation).unwrap();
    whole.run(8, Progress::new(&|_| ControlFlow::Continue(()))).unwrap();
    assert_eq!(stopped.state().unwrap(), whole.state().unwrap());
    assert_eq!((whole.steps(), whole.device().info()), (8, device.info()));
}

#[test]
fn the_host_waits_once_for_many_steps() {
    let Some(device) = device() else { return };
    let simulation = Simulation::new(square(), &options(), &Mask::default()).unwrap();
    let mut kernels = SlimeOnDevice::new(&device, &simulation).unwrap();
    let before = device.waits();
    // The agents are ordered several times.
    kernels.run(3 * EVERY + 1, Progress::none()).unwrap();
    assert_eq!(device.waits() - before, 1);
    kernels.pace = 20;
    let before = device.waits();
    assert_eq!(kernels.advance(20).unwrap().len(), 20);
    assert_eq!(device.waits() - before, 1);
}

#[test]
fn steps_are_covered_one_by_one_however_many_are_computed_at_a_time() {
    let Some(device) = device() else { return };
    let options = Options { species: 2, ..options() };
    let simulation = Simulation::new(square(), &options, &Mask::default()).unwrap();
    let new = || SlimeOnDevice::new(&device, &simulation).unwrap();
    let (mut single, mut many) = (new(), new());
    many.pace = 7;
    let covered = many.advance(5).unwrap();
    assert_eq!((covered.len(), many.steps()), (5, 5));
    for after in covered {
        single.run(1, Progress::none()).unwrap();
        assert_eq!(after, single.coverage().unwrap());
    }
    assert!(single.coverage().unwrap().iter().all(|of| of.coverage > 0.0));
    assert!(matches!(many.advance(0), Err(Error::Argument { what: "most", .. })));
    // Rooms for sums of steps are bounded, whatever the pace.
    many.pace = many.slots;
    assert_eq!(many.advance(1_000).unwrap().len(), many.slots as usize);
}

#[test]
fn frames_of_eight_bits_are_those_of_the_twin() {
    let Some(device) = device() else { return };
    let options = Options { species: 3, ..options() };
    let mut twin = Simulation::new(square(), &options, &Mask::default()).unwrap();
    let mut kernels = SlimeOnDevice::new(&device, &twin).unwrap();
    kernels.run(6, Progress::none()).unwrap();
    kernels.give_back(&mut twin).unwrap();
    let mut frame = vec![7; SIZE * SIZE];
    for species in 0..3 {
        kernels.frame(species, &mut frame).unwrap();
        assert_eq!(frame, twin.frame(species));
    }
    let grays = frame.iter().filter(|&&byte| byte > 0 && byte < 255).count();
    assert!(grays > 100, "{grays}");
    assert!(matches!(kernels.frame(3, &mut frame), Err(Error::Argument { .. })));
    assert!(matches!(kernels.frame(0, &mut frame[1..]), Err(Error::Shape { .. })));
}

#[test]
fn a_timed_device_tells_kernels_from_transfers() {
    let Some(device) = device() else { return };
    assert_eq!(device.times(), Ok(None));
    let timed = Device::open_timed(&device.info().index.to_string()).unwrap();
    let simulation = Simulation::new(square(), &options(), &Mask::default()).unwrap();
    let mut kernels = SlimeOnDevice::new(&timed, &simulation).unwrap();
    let of_memory = timed.times().unwrap().unwrap();
    assert!(of_memory.kernels.is_zero() && !of_memory.transfers.is_zero(), "{of_memory:?}");
    kernels.run(20, Progress::none()).unwrap();
    let of_steps = timed.times().unwrap().unwrap();
    assert!(!of_steps.kernels.is_zero() && of_steps.transfers.is_zero(), "{of_steps:?}");
    assert_eq!(timed.times(), Ok(Some(DeviceTimes::default())));
}

#[test]
fn textures_of_species_come_one_by_one() {
    let Some(device) = device() else { return };
    let options = Options { species: 3, ..options() };
    let mut twin = Simulation::new(square(), &options, &Mask::default()).unwrap();
    let mut kernels = SlimeOnDevice::new(&device, &twin).unwrap();
    kernels.run(3, Progress::none()).unwrap();
    kernels.give_back(&mut twin).unwrap();
    let mut texture = vec![-1.0; options.size * options.size];
    for species in 0..3 {
        kernels.read_texture(species, &mut texture).unwrap();
        assert_eq!(texture, twin.texture(species));
    }
    assert!(matches!(kernels.read_texture(3, &mut texture), Err(Error::Argument { .. })));
    assert!(matches!(kernels.read_texture(0, &mut texture[1..]), Err(Error::Shape { .. })));
}
