//! The processes that `mpirun` started, each of which takes a part of the rows.

use std::ops::Range;

use anyhow::Result;
#[cfg(not(feature = "mpi"))]
pub use catamaran::blas::BlasReal as Scalar;
#[cfg(feature = "mpi")]
use catamaran::faer::Mat;
#[cfg(feature = "mpi")]
pub use catamaran::ranks::MpiReal as Scalar;
use catamaran::rows::{Accumulator, RowBounds};
use catamaran::sparse::{CsMat, EigenOptions, Eigenpairs, Mass, eigs_sliced};

use crate::report::status;

/// This process and its rank; the only process without `mpirun`.
pub struct Ranks {
    #[cfg(feature = "mpi")]
    // Dropped in this order: MPI ends last.
    mpi: Option<(catamaran::ranks::World, mpi::environment::Universe)>,
}

/// Variables in which Open MPI, and MPICH and its derivatives, pass the number of processes.
const SIZES: [&str; 2] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"];

fn started_by_mpirun() -> bool {
    let size = |name| std::env::var(name).ok().and_then(|text| text.parse::<usize>().ok());
    SIZES.into_iter().filter_map(size).any(|size| size > 1)
}

#[cfg(not(feature = "mpi"))]
impl Ranks {
    /// Refuses `mpirun`, under which every process would do all of the work.
    pub fn join() -> Result<Self> {
        if started_by_mpirun() {
            anyhow::bail!(
                "mpirun: this program was built without MPI; build it with --features mpi"
            );
        }
        Ok(Self {})
    }

    fn rank(&self) -> usize {
        0
    }

    /// Returns the number of processes.
    pub fn size(&self) -> usize {
        1
    }

    /// Merges the sums of all processes, and returns them on the first one.
    pub fn merge<T: Scalar>(&self, sum: Accumulator<T>) -> Result<Option<Accumulator<T>>> {
        Ok(Some(sum))
    }

    /// Returns the bounds of the rows of all processes.
    pub fn common_bounds<T: Scalar>(&self, bounds: RowBounds<T>) -> Result<RowBounds<T>> {
        Ok(bounds)
    }

    /// Computes the eigenpairs in slices that fit into `memory` bytes.
    pub fn eigenpairs(
        &self,
        stiffness: &CsMat<f64>,
        mass: &Mass,
        options: &EigenOptions<'_>,
        memory: usize,
        sink: impl FnMut(Eigenpairs) -> catamaran::Result<()>,
    ) -> catamaran::Result<()> {
        eigs_sliced(stiffness.view(), mass, options, memory, sink)
    }

    /// Waits for all processes.
    pub fn wait(&self) {}

    /// Returns the result.
    pub fn end(self, done: Result<()>) -> Result<()> {
        done
    }
}

#[cfg(feature = "mpi")]
impl Ranks {
    /// Starts MPI under `mpirun`; all but the first process are quiet from now on.
    pub fn join() -> Result<Self> {
        use anyhow::Context;
        if !started_by_mpirun() {
            return Ok(Self { mpi: None });
        }
        let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
        let (universe, _) = start.context("MPI is initialized already")?;
        let world = catamaran::ranks::World::new(&universe.world())?;
        let ranks = Self { mpi: Some((world, universe)) };
        if !ranks.is_first() {
            crate::report::be_silent();
        }
        Ok(ranks)
    }

    fn rank(&self) -> usize {
        self.mpi.as_ref().map_or(0, |(world, _)| world.rank())
    }

    /// Returns the number of processes.
    pub fn size(&self) -> usize {
        self.mpi.as_ref().map_or(1, |(world, _)| world.size())
    }

    /// Merges the sums of all processes, and returns them on the first one.
    pub fn merge<T: Scalar>(&self, sum: Accumulator<T>) -> Result<Option<Accumulator<T>>> {
        match &self.mpi {
            Some((world, _)) => Ok(catamaran::ranks::merge_accumulators(world, sum)?),
            None => Ok(Some(sum)),
        }
    }

    /// Returns the bounds of the rows of all processes, on each of them.
    pub fn common_bounds<T: Scalar>(&self, bounds: RowBounds<T>) -> Result<RowBounds<T>> {
        match &self.mpi {
            Some((world, _)) => Ok(catamaran::ranks::agree_bounds(world, &bounds)?),
            None => Ok(bounds),
        }
    }

    /// Computes the eigenpairs. One process computes them in slices that fit into `memory` bytes;
    /// several processes compute all at once, and the first one gets all rows of the vectors.
    pub fn eigenpairs(
        &self,
        stiffness: &CsMat<f64>,
        mass: &Mass,
        options: &EigenOptions<'_>,
        memory: usize,
        mut sink: impl FnMut(Eigenpairs) -> catamaran::Result<()>,
    ) -> catamaran::Result<()> {
        let Some((world, _)) = &self.mpi else {
            return eigs_sliced(stiffness.view(), mass, options, memory, sink);
        };
        let own = self.share(stiffness.rows());
        let rows = |matrix: &CsMat<f64>| matrix.slice_outer(own.clone()).to_owned();
        let own_mass = match mass {
            Mass::Lumped(masses) => Mass::Lumped(masses[own.clone()].to_vec()),
            Mass::Full(matrix) => Mass::Full(rows(matrix)),
        };
        let found = catamaran::ranks::eigs(world, rows(stiffness).view(), &own_mass, options)?;
        let vectors = catamaran::ranks::gather_rows(world, 0, found.vectors.as_ref())?;
        sink(Eigenpairs { vectors: vectors.unwrap_or_else(Mat::new), ..found })
    }

    /// Waits for all processes.
    pub fn wait(&self) {
        use mpi::collective::CommunicatorCollectives;
        if let Some((world, _)) = &self.mpi {
            world.communicator().barrier();
        }
    }

    /// Returns the result. An error on one of several processes ends all of them, because the
    /// others would wait for ever.
    pub fn end(self, done: Result<()>) -> Result<()> {
        use mpi::topology::Communicator;
        if let (Some((world, _)), Err(error)) = (&self.mpi, &done) {
            crate::signals::wait_for_end();
            crate::shortage::wait_for_abort();
            let said = crate::report::message(error);
            crate::report::complain(format_args!("rank {}: {said}", world.rank()));
            let cancelled = matches!(error.downcast_ref(), Some(catamaran::Error::Cancelled));
            let status = if cancelled { crate::signals::status() } else { 1 };
            world.communicator().abort(status.into());
        }
        done
    }
}

impl Ranks {
    /// Returns whether this process is the one that writes and reports.
    pub fn is_first(&self) -> bool {
        self.rank() == 0
    }

    /// Reports how many processes there are.
    pub fn report(&self) -> Result<()> {
        status!("ranks", count = self.size(); "{}, each with its part of the rows", self.size())
    }

    /// Returns the rows of `m` that this process takes.
    pub fn share(&self, m: usize) -> Range<usize> {
        let bound = |rank: usize| m / self.size() * rank + (m % self.size()).min(rank);
        bound(self.rank())..bound(self.rank() + 1)
    }

    /// Returns the rank and the number of processes, for names and labels; `None` for a single
    /// process.
    pub fn label(&self) -> Option<String> {
        (self.size() > 1).then(|| format!("{}-of-{}", self.rank(), self.size()))
    }
}
