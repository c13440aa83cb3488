//! The ranks of one machine, which share its memory and its cores.

use ::mpi::collective::CommunicatorCollectives;
use ::mpi::topology::Communicator;

use super::world::World;
use crate::base::{core_ids, share_cores};

/// The ranks on the machine of this rank.
///
/// ```no_run
/// use catamaran::base::available_memory;
/// use catamaran::ranks::World;
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let node = world.node();
/// let bytes = available_memory() / node.ranks() as u64;
/// println!("rank {} may take {bytes} bytes", world.rank());
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Node {
    ranks: usize,
    place: usize,
    sharing: usize,
    cores: usize,
}

impl Node {
    /// Returns the number of ranks on this machine, at least 1.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// Returns the number of ranks on this machine that have the affinity mask of this rank, itself
    /// included.
    pub fn sharing(&self) -> usize {
        self.sharing
    }

    /// Returns the number of cores in the affinity mask of this rank; 0 where the system does not
    /// report them.
    pub fn cores(&self) -> usize {
        self.cores
    }
}

impl World {
    /// Finds the ranks on the machine of this rank (`MPI_Comm_split_type`). All ranks must call
    /// this function.
    pub fn node(&self) -> Node {
        let node = self.communicator().split_shared(self.rank() as i32);
        let cores = core_ids();
        let mask = cores.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &core| {
            (hash ^ core as u64).wrapping_mul(0x0100_0000_01b3)
        });
        let (ranks, own) = (node.size() as usize, node.rank() as usize);
        let mut masks = vec![0_u64; ranks];
        node.all_gather_into(&mask, &mut masks[..]);
        let like_own = |masks: &[u64]| masks.iter().filter(|&&other| other == mask).count();
        let (place, sharing) = (like_own(&masks[..own]), like_own(&masks));
        Node { ranks, place, sharing, cores: cores.len() }
    }

    /// Gives each rank its part of the cores that it shares with other ranks, for threads that are
    /// pinned from now on ([`Pin::Cores`](crate::base::Pin::Cores)): ranks with the same affinity
    /// mask on one machine take parts of it in their order. Returns the number of cores of this
    /// rank, at least 1. All ranks must call this function, before the first pinned call.
    ///
    /// ```no_run
    /// use catamaran::base::Pin;
    /// use catamaran::ranks::World;
    /// use catamaran::AtaOptions;
    ///
    /// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
    /// # let (universe, _) = start.expect("MPI is started once");
    /// # let world = World::new(&universe.world())?;
    /// let options = AtaOptions::new().threads(world.share_cores()).pin(Pin::Cores);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn share_cores(&self) -> usize {
        let node = self.node();
        share_cores(node.place, node.sharing)
    }
}
