use super::locate::texel;
use super::state::State;
use super::surface::Surface;
use catamaran::base::Result;

/// Number of texels along a side of a tile, a power of two that divides the size of every texture.
pub(crate) const TILE: usize = 16;

/// Number of steps between orderings: few agents leave their tile in the meantime.
pub(crate) const EVERY: u32 = 16;

/// Replaces counts by the start positions of the groups when they are stored one after the other.
fn starts_of(counts: &mut [u32]) {
    let mut start = 0;
    for count in counts {
        (*count, start) = (start, start + *count);
    }
}

/// Orders agents by the tile of the texture that they are in, and keeps the order within a tile, so
/// that the data of a thread are in its cache. The order has no other effect, because agents have
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
