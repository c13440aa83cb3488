use super::locate::texel;
use super::state::State;
use super::surface::Surface;
use crate::base::Result;

/// Texels of a side of a tile, a power of two that divides the size of every texture.
pub(crate) const TILE: usize = 16;

/// Steps from one ordering to the next: agents hardly leave their tile in between.
pub(crate) const EVERY: u32 = 16;

/// Turns counts into the positions at which each begins when they are put one after the other.
pub(crate) fn starts_of(counts: &mut [u32]) {
    let mut start = 0;
    for count in counts {
        (*count, start) = (start, start + *count);
    }
}

/// Orders agents by the tile of the texture that they are in, those of a tile as they were before,
/// so that what one thread reads is in its cache. Nothing else depends on the order, as agents have
/// numbers.
pub(super) fn order(state: &mut State, surface: &Surface, size: usize) -> Result<()> {
    let tiles = size / TILE;
    let tile = |i: usize| {
        let t = texel(surface, size as u32, &state.agent(i)) as usize;
        t / size / TILE * tiles + t % size / TILE
    };
    let count = state.ids.len();
    let mut starts = vec![0_u32; tiles * tiles];
    for i in 0..count {
        starts[tile(i)] += 1;
    }
    starts_of(&mut starts);
    let mut ordered = State::filled(count, 0)?;
    for i in 0..count {
        let place = &mut starts[tile(i)];
        ordered.put(*place as usize, state.ids[i], state.agent(i));
        *place += 1;
    }
    (ordered.step, ordered.texture) = (state.step, std::mem::take(&mut state.texture));
    *state = ordered;
    Ok(())
}
