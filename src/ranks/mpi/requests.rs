use ::mpi::ffi;

/// Messages of one owner that have been started. The memory that they read or write stays in place
/// until they have ended.
#[derive(Default)]
pub(super) struct Requests(Vec<ffi::MPI_Request>);

impl Requests {
    /// Adds a request, which `start` lets MPI set.
    pub(super) fn start(&mut self, start: impl FnOnce(&mut ffi::MPI_Request)) {
        // SAFETY: a constant of the MPI library.
        let mut request = unsafe { ffi::RSMPI_REQUEST_NULL };
        start(&mut request);
        self.0.push(request);
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns whether all have ended.
    pub(super) fn have_ended(&mut self) -> bool {
        let mut flag = 0;
        let count = self.0.len() as i32;
        // SAFETY: requests that were started; ended ones have become null.
        unsafe {
            ffi::MPI_Testall(count, self.0.as_mut_ptr(), &mut flag, ffi::RSMPI_STATUSES_IGNORE);
        }
        flag != 0
    }

    /// Waits until all have ended, and removes them.
    pub(super) fn wait(&mut self) {
        let count = self.0.len() as i32;
        // SAFETY: the requests were started by `start`, and `count` is their number; ended ones are
        // null, for which MPI does not wait.
        unsafe { ffi::MPI_Waitall(count, self.0.as_mut_ptr(), ffi::RSMPI_STATUSES_IGNORE) };
        self.0.clear();
    }
}
