//! The extents of arrays that files announce.

/// Most bytes of an array: sums and small multiples of them fit an `isize`.
const MOST: usize = isize::MAX as usize / 16;

/// Returns the bytes of an array of this shape whose entries take `size` bytes each (at least 1),
/// where an extent of 0 counts as 1: an array without entries may have many rows or columns, which
/// loops visit.
///
/// # Errors
/// A message that ends with the shape, when the bytes are 2^59 or more.
pub(super) fn padded_bytes(shape: &[usize], size: usize) -> Result<usize, String> {
    let product = shape.iter().try_fold(size, |bytes, &extent| bytes.checked_mul(extent.max(1)));
    let within = product.filter(|&bytes| bytes <= MOST);
    within.ok_or_else(|| format!("shape too large: {}", tuple(shape)))
}

/// Returns a shape as Python writes it.
pub(super) fn tuple(shape: &[usize]) -> String {
    let extents: Vec<String> = shape.iter().map(usize::to_string).collect();
    match &extents[..] {
        [extent] => format!("({extent},)"),
        extents => format!("({})", extents.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_of_zero_count_as_one() {
        for (shape, bytes) in
            [(&[0; 0][..], 8), (&[0], 8), (&[3, 0], 24), (&[0, 5, 0], 40), (&[1 << 55, 0], 1 << 58)]
        {
            assert_eq!(padded_bytes(shape, 8), Ok(bytes), "{shape:?}");
        }
        for shape in [&[1 << 56, 0][..], &[0, 1 << 61], &[usize::MAX, 0], &[1 << 32, 1 << 32, 0]] {
            let said = padded_bytes(shape, 8).unwrap_err();
            assert!(said.contains(&format!("({}, ", shape[0])), "{said}");
        }
    }
}
