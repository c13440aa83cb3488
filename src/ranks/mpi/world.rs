use std::cell::Cell;
use std::mem::ManuallyDrop;
use std::ops::{AddAssign, Range};
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use ::mpi::Threading;
use ::mpi::collective::SystemOperation;
use ::mpi::datatype::Equivalence;
use ::mpi::ffi;
use ::mpi::raw::AsRaw;
use ::mpi::topology::{Communicator, SimpleCommunicator};

use crate::base::{Error, FloatEnv, Real, Result};
use crate::blas::BlasReal;
use crate::product::AtaOptions;

/// A scalar that ranks can exchange: f32 or f64. Sealed, as [`BlasReal`] is.
pub trait MpiReal: BlasReal + Equivalence {}

impl MpiReal for f32 {}
impl MpiReal for f64 {}

/// What a rank has sent and received: words are matrix entries. The few numbers by which ranks
/// agree on shapes and errors are not counted.
///
/// ```no_run
/// use catamaran::ranks::{Traffic, World, sum_symmetric};
/// use catamaran::faer::Mat;
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// sum_symmetric(&world, Mat::<f64>::identity(8, 8).as_ref())?;
/// let traffic = world.take_traffic();
/// assert!(world.size() == 1 || traffic.words_sent > 0);
/// assert_eq!(world.traffic(), Traffic::default());
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Entries sent.
    pub words_sent: u64,
    /// Entries received.
    pub words_received: u64,
    /// Messages sent.
    pub messages_sent: u64,
    /// Messages received.
    pub messages_received: u64,
}

impl AddAssign for Traffic {
    fn add_assign(&mut self, other: Self) {
        self.words_sent += other.words_sent;
        self.words_received += other.words_received;
        self.messages_sent += other.messages_sent;
        self.messages_received += other.messages_received;
    }
}

/// The ranks that work together: a duplicate of the caller's communicator, so that messages of the
/// caller and of this crate never mix.
///
/// All calls of MPI are made by the calling thread, which must be allowed to call MPI: with
/// `MPI_THREAD_FUNNELED`, a call on another thread than the one that started MPI returns
/// [`Error::Argument`] on its rank, at once and without a message to the other ranks. MPI is
/// neither initialized nor finalized; a world should be dropped before the caller finalizes it.
///
/// ```no_run
/// use catamaran::ranks::World;
///
/// // Started by `mpirun -n 4`.
/// let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// let (universe, _) = start.expect("MPI is started once");
/// let world = World::new(&universe.world())?;
/// assert!(world.rank() < world.size());
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct World {
    comm: ManuallyDrop<SimpleCommunicator>,
    rank: usize,
    size: usize,
    traffic: Cell<Traffic>,
    work_time: Cell<Duration>,
    longest: Cell<usize>,
}

/// Most entries of a message: counts are 32-bit in MPI.
const LONGEST: usize = 1 << 30;
/// Time between two polls of messages while no rank waits for this one. A poll every 50
/// microseconds costs a product on the same core a quarter of its speed.
const PAUSE: Duration = Duration::from_millis(1);
/// Entries that the MPI library sums at a time.
const SUMMED: usize = 1 << 16;
/// Exit code of an abort because of a panic.
pub(super) const PANICKED: i32 = 101;
/// Numbers that ranks compare at the start of a call.
const FACTS: usize = 10;

/// Checks that MPI was not started for a single thread, and that the calling thread may call MPI.
///
/// # Errors
/// [`Error::Argument`] when MPI was started with `MPI_THREAD_SINGLE`, or with `MPI_THREAD_FUNNELED`
/// by another thread.
fn check_threads() -> Result<()> {
    let refuse = |why: &str| Err(Error::Argument { what: "communicator", why: why.into() });
    match ::mpi::environment::threading_support() {
        Threading::Single => refuse(
            "MPI was started with MPI_THREAD_SINGLE; MPI_THREAD_FUNNELED is needed \
             (MPI_Init_thread), because calls compute on other threads",
        ),
        Threading::Funneled if !is_main_thread() => refuse(
            "MPI was started with MPI_THREAD_FUNNELED, and only the thread that started it may \
             call it, which this thread is not; other threads need MPI_THREAD_SERIALIZED",
        ),
        Threading::Funneled | Threading::Serialized | Threading::Multiple => Ok(()),
    }
}

/// Returns whether the calling thread is the one that started MPI.
fn is_main_thread() -> bool {
    let mut flag = 0;
    // SAFETY: MPI runs, the call is local and allowed on every thread, and the flag is a place for
    // its result.
    unsafe { ffi::MPI_Is_thread_main(&mut flag) };
    flag != 0
}

impl World {
    /// Creates a world of the ranks of `comm`. All ranks must call this function.
    ///
    /// # Errors
    /// [`Error::Argument`] when MPI was started with less than `MPI_THREAD_FUNNELED`, because calls
    /// compute on other threads than the one that calls MPI; when it was started with
    /// `MPI_THREAD_FUNNELED` by another thread.
    pub fn new(comm: &impl Communicator) -> Result<Self> {
        check_threads()?;
        Ok(Self::owning(comm.duplicate()))
    }

    /// Creates a world of the ranks of the communicator with this Fortran handle (`MPI_Comm_c2f`).
    /// All ranks must call this function.
    ///
    /// # Errors
    /// As [`World::new`]; [`Error::Argument`] too when MPI is not initialized, or finalized
    /// already, or the handle is that of no communicator.
    pub fn from_fortran(handle: ffi::RSMPI_Fint) -> Result<Self> {
        let refuse = |why: &str| Err(Error::Argument { what: "communicator", why: why.into() });
        if !::mpi::environment::is_initialized() {
            return refuse("MPI is not initialized");
        }
        if ::mpi::environment::is_finalized() {
            return refuse("MPI is finalized already");
        }
        check_threads()?;
        // SAFETY: MPI runs. Its library maps handles that it doesn't know to the null communicator,
        // or reports an error by the handler of MPI_COMM_WORLD.
        let comm = unsafe {
            let theirs = ffi::RSMPI_Comm_f2c(handle);
            if theirs == ffi::RSMPI_COMM_NULL {
                return refuse("not a communicator");
            }
            let mut ours = ffi::RSMPI_COMM_NULL;
            ffi::MPI_Comm_dup(theirs, &mut ours);
            <SimpleCommunicator as ::mpi::raw::FromRaw>::from_raw(ours)
        };
        Ok(Self::owning(comm))
    }

    fn owning(comm: SimpleCommunicator) -> Self {
        let (rank, size) = (comm.rank() as usize, comm.size() as usize);
        let comm = ManuallyDrop::new(comm);
        let (traffic, work_time) = (Cell::default(), Cell::default());
        Self { comm, rank, size, traffic, work_time, longest: Cell::new(LONGEST) }
    }

    /// Returns this rank, from 0.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns the number of ranks.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Checks that there is a rank `root`.
    pub(super) fn check_root(&self, root: usize) -> Result<()> {
        if root < self.size {
            return Ok(());
        }
        let why = format!("must be less than {}, the number of ranks", self.size);
        Err(Error::Argument { what: "root", why })
    }

    /// Returns the communicator.
    pub fn communicator(&self) -> &SimpleCommunicator {
        &self.comm
    }

    /// Returns what this rank has sent and received since the world was created, or since the last
    /// call of [`World::take_traffic`].
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    /// Returns [`World::traffic`] and resets it to zero.
    pub fn take_traffic(&self) -> Traffic {
        self.traffic.take()
    }

    /// Returns the time that the local products of this rank took since the world was created or
    /// since the last call of this function. Messages travel during this time.
    pub fn take_work_time(&self) -> Duration {
        self.work_time.take()
    }

    /// Sets the number of entries above which a message is cut, from 1 to 2^30 (the default); other
    /// numbers become the nearest of these. All ranks must set the same number.
    pub fn set_longest_message(&self, entries: usize) {
        self.longest.set(entries.clamp(1, LONGEST));
    }

    pub(super) fn longest_message(&self) -> usize {
        self.longest.get()
    }

    /// Adds to the traffic.
    pub(super) fn count(&self, traffic: Traffic) {
        let mut sum = self.traffic.get();
        sum += traffic;
        self.traffic.set(sum);
    }

    /// Calls `work` with options whose progress is part `share` of the whole, on another thread.
    /// The calling thread keeps messages moving, because a product takes seconds without a call of
    /// MPI. It calls `meanwhile`, which returns whether other ranks wait for what this rank sends:
    /// then there is no pause.
    ///
    /// # Errors
    /// Those of `work`; [`Error::Argument`] when the operating system refuses the thread.
    pub(super) fn with_progress<X: Send>(
        &self,
        options: &AtaOptions<'_>,
        share: Range<f64>,
        meanwhile: &dyn Fn() -> bool,
        work: impl FnOnce(&AtaOptions<'_>) -> Result<X> + Send,
    ) -> Result<X> {
        let options = AtaOptions { progress: options.progress.part(share), ..options.clone() };
        let start = Instant::now();
        let done = if self.size == 1 {
            work(&options)
        } else {
            beside(
                || work(&options),
                || {
                    self.poll();
                    meanwhile()
                },
            )
        };
        self.work_time.set(self.work_time.get() + start.elapsed());
        done
    }

    /// Lets the MPI library continue with what has been started. Many libraries do nothing between
    /// calls.
    fn poll(&self) {
        use ::mpi::point_to_point::Source;
        let _ = self.comm.any_process().immediate_probe();
    }

    /// Begins a call that all ranks make together. Returns `Ok` everywhere if all ranks are
    /// `prepared` and have the same `facts`, else an error everywhere, of the first rank at fault.
    ///
    /// # Errors
    /// The error of this rank; [`Error::Rank`] for that of another rank, and for facts that differ;
    /// [`Error::Argument`], on this rank alone, on a thread that may not call MPI.
    #[doc(hidden)]
    pub fn begin<X>(&self, operation: Operation, facts: &[Fact], prepared: Result<X>) -> Result<X> {
        use ::mpi::collective::CommunicatorCollectives;
        check_threads()?;
        assert!(facts.len() + 2 <= FACTS, "room for {FACTS} numbers");
        let mut own = [0_u64; FACTS];
        own[0] = operation as u64;
        own[1] = u64::from(prepared.is_err());
        for (slot, fact) in own[2..].iter_mut().zip(facts) {
            *slot = fact.bits;
        }
        let mut all = vec![0_u64; FACTS * self.size];
        self.comm.all_gather_into(&own[..], &mut all[..]);
        let (all, _) = all.as_chunks::<FACTS>();
        if let Some(rank) = all.iter().position(|theirs| theirs[0] != all[0][0]) {
            let why = "called another function than rank 0".to_owned();
            return Err(Error::Rank { rank, why });
        }
        if let Some(rank) = all.iter().position(|theirs| theirs[1] != 0) {
            return self.error_of(rank, prepared);
        }
        for (i, Fact { what, text, .. }) in facts.iter().enumerate() {
            if let Some(rank) = all.iter().position(|theirs| theirs[2 + i] != all[0][2 + i]) {
                let [got, expected] = [rank, 0].map(|rank| text(all[rank][2 + i]));
                let why = format!("{what} is {got}, where rank 0 has {expected}");
                return Err(Error::Rank { rank, why });
            }
        }
        prepared
    }

    /// Ends a call that all ranks make together: returns `Ok` everywhere if it is `Ok` everywhere.
    ///
    /// # Errors
    /// The error of this rank; [`Error::Rank`] for that of another rank.
    #[doc(hidden)]
    pub fn agree<X>(&self, own: Result<X>) -> Result<X> {
        use ::mpi::collective::CommunicatorCollectives;
        let at_fault = if own.is_err() { self.rank as i32 } else { i32::MAX };
        let mut first = 0_i32;
        self.comm.all_reduce_into(&at_fault, &mut first, SystemOperation::min());
        if first == i32::MAX { own } else { self.error_of(first as usize, own) }
    }

    /// Returns the error of `rank`, sent to all ranks. A rank with an error of its own keeps that.
    fn error_of<X>(&self, rank: usize, own: Result<X>) -> Result<X> {
        use ::mpi::collective::Root;
        let text = match &own {
            Err(Error::Rank { rank: at_fault, why }) if rank == self.rank && *at_fault == rank => {
                why.clone().into_bytes()
            }
            Err(e) if rank == self.rank => e.to_string().into_bytes(),
            _ => Vec::new(),
        };
        let root = self.comm.process_at_rank(rank as i32);
        let mut len = text.len() as u64;
        root.broadcast_into(&mut len);
        let mut text = if rank == self.rank { text } else { vec![0; len as usize] };
        root.broadcast_into(&mut text[..]);
        own.and_then(|_| Err(Error::Rank { rank, why: String::from_utf8_lossy(&text).into() }))
    }

    /// Returns one number of every rank, on every rank.
    pub(super) fn gather_numbers(&self, own: usize) -> Vec<usize> {
        use ::mpi::collective::CommunicatorCollectives;
        let mut all = vec![0_u64; self.size];
        self.comm.all_gather_into(&(own as u64), &mut all[..]);
        all.into_iter().map(|number| number as usize).collect()
    }

    /// Computes the sums over the ranks of the entries of `values`, on every rank, by the MPI
    /// library. They are not counted as traffic.
    pub(super) fn sum(&self, values: &mut [f64]) {
        use ::mpi::collective::CommunicatorCollectives;
        let mut own = Vec::new();
        for part in values.chunks_mut(SUMMED) {
            own.clear();
            own.extend_from_slice(part);
            self.comm.all_reduce_into(&own[..], part, SystemOperation::sum());
        }
    }

    /// Computes the least of each entry of `values` over the ranks, on every rank, by the MPI
    /// library. It is not counted as traffic.
    pub(super) fn least(&self, values: &mut [f64]) {
        use ::mpi::collective::CommunicatorCollectives;
        let mut own = Vec::new();
        for part in values.chunks_mut(SUMMED) {
            own.clear();
            own.extend_from_slice(part);
            self.comm.all_reduce_into(&own[..], part, SystemOperation::min());
        }
    }

    /// Aborts the whole job if the scope is left by a panic, because the other ranks would wait
    /// forever.
    #[doc(hidden)]
    pub fn abort_on_panic(&self) -> impl Drop + '_ {
        struct Guard<'w>(&'w World);
        impl Drop for Guard<'_> {
            fn drop(&mut self) {
                if thread::panicking() {
                    self.0.comm.abort(PANICKED);
                }
            }
        }
        Guard(self)
    }

    pub(super) fn raw(&self) -> ffi::MPI_Comm {
        self.comm.as_raw()
    }
}

/// Calls `work` on another thread, and `meanwhile` on this one until `work` is done: again at once
/// where `meanwhile` returns true, else after a [`PAUSE`].
///
/// # Errors
/// Those of `work`; [`Error::Argument`] when the operating system refuses the thread.
fn beside<X: Send>(
    work: impl FnOnce() -> Result<X> + Send,
    meanwhile: impl Fn() -> bool,
) -> Result<X> {
    let caller = thread::current();
    let over = AtomicBool::new(false);
    thread::scope(|scope| {
        let over = &over;
        let named = thread::Builder::new().name("catamaran-work".into());
        let worker = named.spawn_scoped(scope, move || {
            let _says_so = Over { over, caller };
            // Threads inherit the environment of the thread that makes them.
            let _nearest = FloatEnv::nearest();
            work()
        });
        let worker = worker.map_err(|e| Error::Argument {
            what: "threads",
            why: format!("one more than that of the call is needed: {e}"),
        })?;
        while !over.load(Ordering::Acquire) {
            if meanwhile() {
                thread::yield_now();
            } else {
                thread::park_timeout(PAUSE);
            }
        }
        worker.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}

/// Wakes the caller when the work is over, also by a panic.
struct Over<'o> {
    over: &'o AtomicBool,
    caller: Thread,
}

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        self.caller.unpark();
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // A communicator can't be freed once MPI is finalized, nor on a thread that may not call
        // MPI; then it stays.
        if !::mpi::environment::is_finalized() && check_threads().is_ok() {
            // SAFETY: dropped here only, with the world, after which nobody can use it.
            unsafe { ManuallyDrop::drop(&mut self.comm) };
        }
    }
}

/// A number that all ranks of a call must have in common.
#[derive(Debug, Clone, Copy)]
pub struct Fact {
    what: &'static str,
    bits: u64,
    /// Writes the number that has these bits.
    text: fn(u64) -> String,
}

/// Returns the fact that all ranks have the same count `what`.
pub(super) fn fact(what: &'static str, count: usize) -> Fact {
    Fact { what, bits: count as u64, text: |bits| bits.to_string() }
}

/// Returns the fact that all ranks have the same hash `what`.
pub(super) fn hash_fact(what: &'static str, hash: u64) -> Fact {
    Fact { what, bits: hash, text: |bits| format!("{bits:016x}") }
}

/// Returns the fact that `what` is on or off on all ranks.
pub(super) fn flag(what: &'static str, on: bool) -> Fact {
    Fact { what, bits: u64::from(on), text: |bits| (bits != 0).to_string() }
}

/// Returns the fact that all ranks have the same scalar T.
pub(super) fn scalar_fact<T>() -> Fact {
    fact("the size of a scalar", size_of::<T>())
}

/// Returns the fact that all ranks have the same number `what`, bit for bit.
pub(super) fn number_fact<T: Real>(what: &'static str, value: T) -> Fact {
    Fact { what, bits: value.to_f64().to_bits(), text: |bits| f64::from_bits(bits).to_string() }
}

/// The collective calls, by which ranks notice that they make different ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
#[allow(missing_docs)] // named after the calls
pub enum Operation {
    Rows = 1,
    Columns,
    Root,
    Cyclic,
    Gather,
    Verify,
    Sum,
    Merge,
    GramSchmidt,
    CholeskyQr,
    Eigenpairs,
    GatherRows,
    Bounds,
    LeastSquares,
    SameShape,
    SameRows,
    SameNumbers,
    Bricks,
}
