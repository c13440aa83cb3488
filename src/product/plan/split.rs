/// Returns the start of block `i` of `parts` along an extent of `len`: blocks differ by at most
/// one, the shorter ones first, so that two halves are floor and ceiling as in the thesis.
pub(crate) fn block_start(len: usize, parts: usize, i: usize) -> usize {
    let long = len % parts;
    let short_blocks = parts - long;
    (len / parts) * i + i.saturating_sub(short_blocks)
}
