//! Pieces of a block of rows, for threads to prepare.

/// The rows that one thread works on at a time.
pub(super) struct Piece<'p, T, const N: usize> {
    pub rows: &'p mut [T],
    pub weights: Option<&'p [T]>,
    /// The parts of the outputs: as long as the rows, or empty.
    pub outputs: [&'p mut [T]; N],
}

/// Cuts a block of rows of `n` columns (at least 1), their weights and what is computed from them
/// into pieces of `height` rows, the last one with what is left. An output is as long as the block,
/// or empty.
pub(super) fn block_pieces<'p, T, const N: usize>(
    block: &'p mut [T],
    n: usize,
    height: usize,
    weights: Option<&'p [T]>,
    outputs: [&'p mut [T]; N],
) -> impl Iterator<Item = Piece<'p, T, N>> {
    let mut outputs = outputs.map(|output| output.chunks_mut(height * n));
    let mut weights = weights.map(|weights| weights.chunks(height));
    block.chunks_mut(height * n).map(move |rows| Piece {
        rows,
        weights: weights.as_mut().and_then(Iterator::next),
        outputs: outputs.each_mut().map(|output| output.next().unwrap_or_default()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_have_the_rows_the_weights_and_the_outputs_of_each_other() {
        let (mut block, weights) = ([0, 1, 2, 3, 4, 5], [10, 11, 12]);
        let (mut weighted, mut none) = ([20, 21, 22, 23, 24, 25], [0; 0]);
        let outputs = [&mut weighted[..], &mut none[..]];
        let pieces: Vec<_> = block_pieces(&mut block, 2, 2, Some(&weights[..]), outputs).collect();
        assert_eq!(pieces.len(), 2);
        assert_eq!((&*pieces[0].rows, pieces[0].weights), (&[0, 1, 2, 3][..], Some(&[10, 11][..])));
        assert_eq!((&*pieces[1].rows, pieces[1].weights), (&[4, 5][..], Some(&[12][..])));
        assert_eq!(*pieces[1].outputs[0], [24, 25]);
        assert!(pieces.iter().all(|piece| piece.outputs[1].is_empty()));
    }
}
