//! No agent is ever lost, and nothing depends on threads or interruptions.

use std::ops::ControlFlow;
use std::path::Path;

use catamaran::base::Progress;
use catamaran::{Error, Par};
use catamaran_geometry::mesh::{TriMesh, families};
use catamaran_simulation::texture::slime::{
    Blur, FREE, Mask, OBSTACLE, Options, Simulation, TangentStep,
};

use super::support::{options, simulation, square, with_atlas};

#[test]
fn no_agent_is_lost() {
    let meshes: [(&str, TriMesh); 4] = [
        ("torus", families::torus(24, 12, 2.0, 0.7).unwrap()),
        ("closed", families::icosphere(2).unwrap()),
        ("boundary", families::terrain(10, 10, 1).unwrap()),
        ("Moebius strip", families::moebius(40, 4).unwrap()),
    ];
    for (name, mesh) in meshes {
        for tangent_step in [TangentStep::Unfold, TangentStep::Project { substeps: 4 }] {
            let options = options(1500, 256).tangent_step(tangent_step);
            let mut all = simulation(with_atlas(&mesh, 256), &options);
            for _ in 0..5 {
                all.run(50, Par::all(), Progress::none()).unwrap();
                let state = all.state().check(all.surface());
                assert_eq!(state, Ok(()), "{name}, {tangent_step:?}");
            }
        }
    }
}

#[test]
fn no_agent_is_beyond_a_sharp_corner() {
    // Steps as long as the faces, on faces of which some are slivers.
    let steps = TangentStep::Project { substeps: 2 };
    let quick = options(2000, 128).movement_speed(2000.0).length_rescaling(false);
    for (name, mesh) in [
        ("flat", families::grid(12, 12).unwrap()),
        ("slivers", families::torus(36, 3, 2.0, 0.1).unwrap()),
    ] {
        let options = quick.tangent_step(steps);
        let mut all = simulation(with_atlas(&mesh, 128), &options);
        all.run(60, Par::all(), Progress::none()).unwrap();
        assert_eq!(all.state().check(all.surface()), Ok(()), "{name}");
    }
}

#[test]
fn threads_do_not_show() {
    for blur in [Blur::SeamAware, Blur::Gaussian] {
        let run = |par: Par| {
            let mesh = families::torus(16, 8, 2.0, 0.7).unwrap();
            let options = options(9001, 128).blur(blur).species(2);
            let mut all = simulation(with_atlas(&mesh, 128), &options);
            all.run(40, par, Progress::none()).unwrap();
            (all.state().clone(), all.coverage(par))
        };
        let alone = run(Par::Seq);
        for threads in [2, 3, 7] {
            assert!(run(Par::Threads(threads)) == alone, "{threads} threads");
        }
    }
}

#[test]
fn a_run_that_stopped_goes_on_as_if_it_had_not() {
    let options = options(700, 64).species(3);
    let begin = || simulation(square(5), &options);
    let mut whole = begin();
    whole.run(37, Par::Seq, Progress::none()).unwrap();
    let mut first = begin();
    first.run(20, Par::Seq, Progress::none()).unwrap();
    let mut file = Vec::new();
    // More numbers than are read at a time.
    let history: Vec<f64> = (0..20_000).map(|i| f64::from(i).sqrt()).collect();
    first.save(&mut file, &history).unwrap();
    let mut second = begin();
    assert_eq!(second.resume(&mut &file[..], Path::new("state")).unwrap(), history);
    second.run(17, Par::Seq, Progress::none()).unwrap();
    assert!(second.state() == whole.state());
}

/// Bytes of a state before the arrays: name, version and head, without their checksum.
const HEAD: usize = 16 + 18 * 8;

/// A state with checksums that hold.
fn signed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - 4;
    for part in [0..HEAD, HEAD + 4..end] {
        let check = crc32fast::hash(&bytes[part.clone()]).to_le_bytes();
        bytes[part.end..part.end + 4].copy_from_slice(&check);
    }
    bytes
}

#[test]
fn files_that_are_no_state_are_refused() {
    let options = options(40, 32);
    let mut all = simulation(square(2), &options);
    let mut file = Vec::new();
    all.save(&mut file, &[0.5]).unwrap();
    assert_eq!(signed(file.clone()), file);
    let before = all.state().clone();
    let mut refuse = |bytes: &[u8], why: &str| {
        let error = all.resume(&mut &bytes[..], Path::new("some.state")).unwrap_err().to_string();
        assert!(error.starts_with("some.state: ") && error.contains(why), "{error}");
        assert!(*all.state() == before);
    };
    refuse(b"", "is not a state file of slime moulds, or ends early");
    refuse(&[&file[..], &[0]].concat(), "after its end");
    let changed = |at: usize, value: u8| {
        let mut bytes = file.clone();
        bytes[at] = value;
        bytes
    };
    refuse(&changed(0, b'x'), "is not a state file of slime moulds");
    refuse(&changed(15, b'2'), "was written by an earlier version");
    refuse(&changed(15, b'4'), "was written by a later version");
    // Numbers that no run writes, behind checksums that hold.
    let forged = |at: usize, value: u8| signed(changed(at, value));
    refuse(&forged(HEAD - 16, file[HEAD - 16] ^ 1), "another surface");
    // A history of 2^59 numbers.
    refuse(&forged(HEAD - 1, 8), "ends early");
    let arrays = HEAD + 4;
    refuse(&forged(arrays, 200), "ids");
    // A triangle that is not there.
    refuse(&forged(arrays + 4 * 40 + 1, 77), "is not on the surface, or its heading");
    // Before the number of the history and the checksum.
    refuse(&forged(file.len() - 4 - 8 - 1, 0x7f), "texture");
}

#[test]
fn a_state_of_other_options_is_refused_by_their_names_and_values() {
    let own = options(40, 32);
    let mut all = simulation(square(2), &own);
    let before = all.state().clone();
    let mut refused = |mut other: Simulation| {
        let mut file = Vec::new();
        other.run(1, Par::Seq, Progress::none()).unwrap();
        other.save(&mut file, &[]).unwrap();
        let error = all.resume(&mut &file[..], Path::new("some.state")).unwrap_err().to_string();
        assert!(*all.state() == before, "{error}");
        error
    };
    let changes: [(&str, Change); 15] = [
        ("agents = 41, not 40", |o| o.agents = 41),
        ("species = 2, not 1", |o| o.species = 2),
        ("size = 64, not 32", |o| o.size = 64),
        ("seed = 99, not 7", |o| o.seed = 99),
        ("time_step = 0.25, not 0.03", |o| o.time_step = 0.25),
        ("movement_speed = 0.5, not 1.5", |o| o.movement_speed = 0.5),
        ("turn_speed = 90, not 1800", |o| o.turn_speed = 90.0),
        ("vision_distance = 2, not 1", |o| o.vision_distance = 2.0),
        ("vision_angle = 20, not 30", |o| o.vision_angle = 20.0),
        ("evaporation_rate = 0.5, not 0.4", |o| o.evaporation_rate = 0.5),
        ("diffusion_rate = 3, not 6", |o| o.diffusion_rate = 3.0),
        ("turn_noise = 0.5, not 1", |o| o.turn_noise = 0.5),
        ("tangent_step = project with 4 substeps, not unfold", |o| {
            o.tangent_step = TangentStep::Project { substeps: 4 };
        }),
        ("blur = gaussian, not seam-aware", |o| o.blur = Blur::Gaussian),
        ("length_rescaling = false, not true", |o| o.length_rescaling = false),
    ];
    assert_eq!(changes.len(), Options::FIELDS.len());
    for (why, change) in changes {
        let mut other = own;
        change(&mut other);
        let error = refused(simulation(square(2), &other));
        assert!(error.starts_with(&format!("some.state: was saved with {why}")), "{error}");
    }
    let start = (0..32 * 32).map(|texel| texel % 2 == 0).collect();
    let ground = (0..32 * 32).map(|texel| if texel < 32 { OBSTACLE } else { FREE }).collect();
    for mask in [Mask { start, ground: Vec::new() }, Mask { start: Vec::new(), ground }] {
        let error = refused(Simulation::new(square(2), &own, &mask).unwrap());
        assert_eq!(error, "some.state: was saved with another mask");
    }
}

#[test]
fn a_state_with_any_byte_damaged_is_refused() {
    let mut all = simulation(square(2), &options(40, 32));
    all.run(3, Par::Seq, Progress::none()).unwrap();
    let mut file = Vec::new();
    all.save(&mut file, &[0.0, 0.25, 0.5, 0.75]).unwrap();
    let before = all.state().clone();
    let mut refuse = |bytes: &[u8], what: &str| {
        let error = all.resume(&mut &bytes[..], Path::new("some.state")).unwrap_err().to_string();
        assert!(error.starts_with("some.state: "), "{what}: {error}");
        assert!(*all.state() == before, "{what}");
    };
    // All of the head, and some 60 bytes over the rest.
    let spread = (0..file.len()).step_by(file.len() / 60);
    for at in (0..HEAD + 4).chain(spread).chain([file.len() - 1]) {
        for bit in [0, 7] {
            let mut bytes = file.clone();
            bytes[at] ^= 1 << bit;
            refuse(&bytes, &format!("bit {bit} of byte {at}"));
        }
        refuse(&file[..at], &format!("the first {at} bytes"));
    }
    refuse(&[&file[..], &file[..]].concat(), "twice the file");
}

#[test]
fn progress_is_told_and_can_cancel() {
    let mut all = simulation(square(2), &options(10, 32));
    let calls = std::sync::atomic::AtomicU32::new(0);
    let stop = |fraction: f64| {
        calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        if fraction >= 0.3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    assert_eq!(all.run(10, Par::Seq, (&stop).into()), Err(Error::Cancelled));
    assert_eq!((calls.into_inner(), all.state().step), (3, 3));
    all.run(0, Par::Seq, Progress::new(&|_| ControlFlow::Break(()))).unwrap();
}

#[test]
fn no_agents_and_one_are_fine() {
    for agents in [0, 1, 4097] {
        let mut all = simulation(square(1), &options(agents, 32));
        all.run(20, Par::Threads(2), Progress::none()).unwrap();
        assert_eq!(all.coverage(Par::Seq)[0].coverage > 0.0, agents > 0);
        assert_eq!(all.state().check(all.surface()), Ok(()));
    }
}

/// Makes one option wrong.
type Change = fn(&mut Options);

#[test]
fn options_out_of_range_are_named() {
    let bad: [(&str, Change); 7] = [
        ("size", |o| o.size = 100),
        ("species", |o| o.species = 0),
        ("time_step", |o| o.time_step = 0.0),
        ("vision_angle", |o| o.vision_angle = 181.0),
        ("turn_noise", |o| o.turn_noise = f64::NAN),
        ("movement_speed", |o| o.movement_speed = -1.0),
        ("substeps", |o| o.tangent_step = TangentStep::Project { substeps: 0 }),
    ];
    for (name, change) in bad {
        let mut options = Options::default();
        change(&mut options);
        assert!(
            matches!(options.check(), Err(Error::Argument { what, .. }) if what == name),
            "{name}"
        );
    }
}

#[test]
fn bounds_on_both_sides_are_told_whichever_is_exceeded() {
    let bad: [(&str, Change); 6] = [
        ("movement_speed: must be from 0 to 1000000, is 10000000", |o| o.movement_speed = 1e7),
        ("turn_speed: must be from 0 to 1000000, is -1", |o| o.turn_speed = -1.0),
        ("time_step: must be above 0 and at most 1000000, is 10000000", |o| o.time_step = 1e7),
        ("time_step: must be above 0 and at most 1000000, is NaN", |o| o.time_step = f64::NAN),
        ("species: must be from 1 to 15, is 16", |o| o.species = 16),
        ("size: must be a multiple of 32 from 32 to 16384, is 20000", |o| o.size = 20_000),
    ];
    for (why, change) in bad {
        let mut options = Options::default();
        change(&mut options);
        assert_eq!(options.check().unwrap_err().to_string(), why);
    }
}
