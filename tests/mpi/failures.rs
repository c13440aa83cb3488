//! What goes wrong on one rank: an error on every rank, or an abort, within the time limit.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::faer::Mat;
use catamaran::ranks::{World, ata_columns, ata_rows, ata_tree};

use crate::Scene;
use crate::matrices::{options, part, tell};

pub const SCENES: &[Scene] = &[
    Scene {
        name: "a_rank_with_another_shape_is_named_on_every_rank",
        ranks: 4,
        starved: None,
        play: another_shape,
        printed: &[
            "0: rank 2: n is 8, where rank 0 has 7",
            "3: rank 2: n is 8, where rank 0 has 7",
        ],
        succeeds: true,
    },
    Scene {
        name: "a_rank_with_another_factor_is_named",
        ranks: 3,
        starved: None,
        play: another_factor,
        printed: &[
            "0: rank 1: alpha is 2, where rank 0 has 1",
            "1: rank 1: alpha is 2",
            "2: rank 1: alpha is 2",
        ],
        succeeds: true,
    },
    Scene {
        name: "a_rank_without_memory_is_named_on_every_rank",
        ranks: 3,
        starved: None,
        play: no_memory,
        printed: &["0: rank 1: out of memory", "1: out of memory", "2: rank 1: out of memory"],
        succeeds: true,
    },
    Scene {
        name: "a_rank_that_cancels_ends_the_call_on_every_rank",
        ranks: 4,
        starved: None,
        play: cancel,
        printed: &["0: rank 3: cancelled", "1: rank 3: cancelled", "3: cancelled"],
        succeeds: true,
    },
    Scene {
        name: "ranks_in_different_calls_notice",
        ranks: 2,
        starved: None,
        play: different_calls,
        printed: &["0: rank 1: called another function", "1: rank 1: called another function"],
        succeeds: true,
    },
    Scene {
        name: "a_rank_without_threads_is_named_on_every_rank",
        ranks: 3,
        starved: Some(1),
        play: no_threads,
        printed: &[
            "0: rank 1: threads: one more than",
            "1: threads: one more than",
            "2: rank 1: threads: one more than",
        ],
        succeeds: true,
    },
    Scene {
        name: "calls_on_a_thread_that_may_not_call_mpi_are_refused",
        ranks: 2,
        starved: None,
        play: other_thread,
        printed: &["0: communicator: MPI was started", "1: communicator: MPI was started"],
        succeeds: true,
    },
    Scene {
        name: "a_killed_rank_ends_the_job",
        ranks: 4,
        starved: None,
        play: killed,
        printed: &[],
        succeeds: false,
    },
    Scene {
        name: "a_rank_that_panics_ends_the_job",
        ranks: 3,
        starved: None,
        play: panicking,
        printed: &["this rank panics"],
        succeeds: false,
    },
];

fn another_shape(world: &World) {
    let n = if world.rank() == 2 { 8 } else { 7 };
    let a = part::<f64>(0..5, 0..n);
    tell(world, ata_rows(world, 1.0, a.as_ref(), &options()).unwrap_err());
    // The world is as good as before.
    let a = part::<f64>(0..5, 0..3);
    ata_rows(world, 1.0, a.as_ref(), &options()).unwrap();
}

fn another_factor(world: &World) {
    let alpha = if world.rank() == 1 { 2.0 } else { 1.0 };
    let a = part::<f64>(0..5, 0..3);
    tell(world, ata_rows(world, alpha, a.as_ref(), &options()).unwrap_err());
}

fn no_memory(world: &World) {
    if world.rank() == 1 {
        // SAFETY: sets a limit of this process: no more than what it has and 64 MiB.
        unsafe {
            let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
            let pages: u64 = text.split(' ').next().unwrap().parse().unwrap();
            let limit =
                libc::rlimit { rlim_cur: pages * 4096 + (64 << 20), rlim_max: libc::RLIM_INFINITY };
            assert_eq!(libc::setrlimit(libc::RLIMIT_AS, &limit), 0);
        }
    }
    let a = Mat::<f64>::zeros(1, 8000);
    tell(world, ata_rows(world, 1.0, a.as_ref(), &options()).unwrap_err());
}

fn cancel(world: &World) {
    let calls = AtomicUsize::new(0);
    let progress = |_| {
        let enough = calls.fetch_add(1, Ordering::Relaxed) > 2;
        if enough && world_rank() == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let options = options().progress(&progress);
    let a = Mat::<f64>::from_fn(600, 1500, |i, j| (i + j) as f64);
    tell(world, ata_rows(world, 1.0, a.as_ref(), &options).unwrap_err());
}

/// The rank of this process; a progress callback can't hold a world.
fn world_rank() -> usize {
    use mpi::topology::{Communicator, SimpleCommunicator};
    SimpleCommunicator::world().rank() as usize
}

fn different_calls(world: &World) {
    let a = part::<f64>(0..5, 0..5);
    let error = if world.rank() == 0 {
        ata_rows(world, 1.0, a.as_ref(), &options()).unwrap_err()
    } else {
        catamaran::ranks::sum_symmetric(world, a.as_ref()).unwrap_err()
    };
    tell(world, error);
}

/// Every product that computes beside messages, where rank 1 gets no thread for that.
fn no_threads(world: &World) {
    let a = part::<f64>(0..5, 0..7);
    let a = a.as_ref();
    let exact = options().reproducible(true);
    let mut told = vec![
        ata_rows(world, 1.0, a, &options()).map(drop),
        ata_rows(world, 1.0, a, &exact).map(drop),
        ata_columns(world, 1.0, a, &options()).map(drop),
    ];
    // With `ata_deal` no rank but the root computes beside messages.
    let mut c = Mat::<f64>::zeros(7, 7);
    let on_root = (world.rank() == 0).then_some((a, c.as_mut()));
    let (a, c) = on_root.unzip();
    told.push(ata_tree(world, 0, 1.0, a, 0.0, c, &options()));
    let told: Vec<_> = told.into_iter().map(Result::unwrap_err).collect();
    assert!(told.iter().all(|error| error.to_string() == told[0].to_string()), "{told:?}");
    tell(world, told[0].clone());
}

/// Calls on another thread than the one that started MPI, with MPI_THREAD_FUNNELED.
fn other_thread(world: &World) {
    struct Sent<'w>(&'w World);
    // SAFETY: the thread that owns the world waits for the one that uses it.
    unsafe impl Send for Sent<'_> {}
    let sent = Sent(world);
    let refused = std::thread::scope(|scope| {
        let calls = scope.spawn(move || {
            let Sent(world) = { sent };
            // SAFETY: the communicator is alive.
            let handle =
                unsafe { mpi::ffi::RSMPI_Comm_c2f(mpi::raw::AsRaw::as_raw(world.communicator())) };
            let a = part::<f64>(0..5, 0..7);
            [
                World::from_fortran(handle).map(drop).unwrap_err(),
                World::new(world.communicator()).map(drop).unwrap_err(),
                ata_rows(world, 1.0, a.as_ref(), &options()).unwrap_err(),
            ]
        });
        calls.join().unwrap()
    });
    assert!(refused.iter().all(|error| error.to_string() == refused[0].to_string()));
    tell(world, refused[0].clone());
    // The world is as good as before.
    let a = part::<f64>(0..5, 0..3);
    ata_rows(world, 1.0, a.as_ref(), &options()).unwrap();
}

fn killed(world: &World) {
    if world.rank() == 2 {
        // SAFETY: ends this process, at once.
        unsafe { libc::raise(libc::SIGKILL) };
    }
    let a = part::<f64>(0..5, 0..700);
    let _ = ata_rows(world, 1.0, a.as_ref(), &options());
}

fn panicking(world: &World) {
    let progress = |_| -> ControlFlow<()> {
        if world_rank() == 1 { panic!("this rank panics") } else { ControlFlow::Continue(()) }
    };
    let options = options().progress(&progress);
    let a = part::<f64>(0..50, 0..700);
    let _ = ata_rows(world, 1.0, a.as_ref(), &options);
}
