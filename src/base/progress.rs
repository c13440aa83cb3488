/// What a progress callback answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Stop soon; the call returns [`Error::Cancelled`](crate::Error::Cancelled).
    Cancel,
}

/// A progress callback: called with the fraction of the work done, in `[0, 1]`, never decreasing
/// as seen by one thread, from whichever thread finished a piece. It must be cheap.
pub type Progress<'a> = &'a (dyn Fn(f64) -> Flow + Sync);
