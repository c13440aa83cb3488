//! What happens when memory or threads run out in code that has no way to return an error.
//!
//! Most allocations of Rust abort the process when they are refused. Here an abort of a thread on
//! which an allocation was refused becomes an error like others: a line on stderr, no unfinished
//! output, exit status 1. An abort for any other reason still ends the process by SIGABRT, without
//! leaving unfinished outputs either. Windows ends a process that aborts without any handler.

use std::alloc::{GlobalAlloc, Layout, System};
use std::any::Any;
use std::cell::Cell;
use std::io;
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::{Result, bail};
use catamaran::io::try_discard_unfinished;

/// How long an abort waits for a thread that is just creating or committing an output. The aborting
/// thread may be that thread: it then waits without effect.
const PATIENCE: Duration = Duration::from_millis(200);

/// What `libc` has under these names on POSIX systems only.
const STDERR: libc::c_int = 2;
const SIG_ERR: libc::sighandler_t = !0;

/// A separate line, after the one in which the standard library says how many bytes it wanted.
const MESSAGE: &[u8] = b"catamaran: not enough memory\n";

/// Set by the first thread that aborts, which ends the process.
static ABORTING: AtomicBool = AtomicBool::new(false);

/// The system's allocator, which notes on which threads a request was refused.
///
/// The note covers all requests, not only the last: before the standard library aborts it may print
/// a backtrace, for which there may be memory.
struct Noting;

#[global_allocator]
static ALLOCATOR: Noting = Noting;

thread_local! {
    /// Whether a request of this thread was refused.
    static REFUSED: Cell<bool> = const { Cell::new(false) };
}

/// Set once a panic was due to a lack of memory or threads.
static SHORT: AtomicBool = AtomicBool::new(false);

/// Notes a refusal, and returns the block of the system.
fn noted(block: *mut u8) -> *mut u8 {
    if block.is_null() {
        REFUSED.set(true);
    }
    block
}

// SAFETY: the system's allocator does all of the work; a constant cell without a destructor can be
// set from any thread at any time.
unsafe impl GlobalAlloc for Noting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the contract of this method is that of the system's allocator.
        noted(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the contract of this method is that of the system's allocator.
        noted(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the contract of this method is that of the system's allocator.
        noted(unsafe { System.realloc(block, layout, size) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the contract of this method is that of the system's allocator.
        unsafe { System.dealloc(block, layout) }
    }
}

/// Watches for aborts and for panics about a lack of memory or threads from now on.
///
/// # Errors
/// The operating system refuses the handler.
pub fn watch() -> io::Result<()> {
    let others = panic::take_hook();
    panic::set_hook(Box::new(move |about| {
        // Some packages unwrap what a refused allocation returned.
        if REFUSED.get() || is_shortage(message_of(about.payload())) {
            SHORT.store(true, Ordering::Relaxed);
        }
        // A panic after a shortage is its consequence, and [`guard`] reports it.
        if !SHORT.load(Ordering::Relaxed) {
            others(about);
        }
    }));
    // SAFETY: the handler fits its signal, and `on_abort` says why it may do what it does.
    unsafe {
        let handler = on_abort as extern "C" fn(libc::c_int) as libc::sighandler_t;
        if libc::signal(libc::SIGABRT, handler) == SIG_ERR {
            return Err(io::Error::last_os_error());
        }
    }
    Ok(())
}

/// Runs a command; a panic about a lack of memory or threads becomes an error.
///
/// # Errors
/// Those of the command; a lack of memory or threads.
pub fn guard(command: impl FnOnce() -> Result<()>) -> Result<()> {
    match panic::catch_unwind(AssertUnwindSafe(command)) {
        Ok(done) => done,
        Err(panic) if SHORT.load(Ordering::Relaxed) => {
            bail!("not enough memory or threads: {}", message_of(&*panic))
        }
        Err(panic) => panic::resume_unwind(panic),
    }
}

/// Returns unless a thread aborts: that thread ends the process, and reports why.
pub fn wait_for_abort() {
    while ABORTING.load(Ordering::Acquire) {
        thread::sleep(PATIENCE);
    }
}

/// Returns the message of a panic.
fn message_of(payload: &(dyn Any + Send)) -> &str {
    let owned = || payload.downcast_ref().map(String::as_str);
    payload.downcast_ref::<&str>().copied().or_else(owned).unwrap_or_default()
}

/// Returns whether a message of the standard library or rayon is about a shortage: EAGAIN for
/// threads, ENOMEM for their stacks.
fn is_shortage(message: &str) -> bool {
    ["os error 11)", "os error 12)", "code: 11,", "code: 12,"].iter().any(|c| message.contains(c))
}

/// Runs on the thread that aborts, in the middle of anything but the allocator, which has returned;
/// other threads are at work. It allocates nothing, unless an output's path is longer than the
/// buffer of the standard library.
extern "C" fn on_abort(_: libc::c_int) {
    if ABORTING.swap(true, Ordering::AcqRel) {
        wait_for_abort();
    }
    // A file whose thread holds the list stays behind; nothing better can be done.
    let _ = try_discard_unfinished(PATIENCE);
    let is_short = REFUSED.get() || SHORT.load(Ordering::Relaxed);
    // SAFETY: the message is there; nobody is left to tell that stderr is closed. The signal comes
    // back, with its default effect, when this handler returns.
    unsafe {
        if is_short {
            libc::write(STDERR, MESSAGE.as_ptr().cast(), MESSAGE.len() as _);
            libc::_exit(1);
        }
        libc::signal(libc::SIGABRT, libc::SIG_DFL);
        libc::raise(libc::SIGABRT);
    }
}
