//! What the elimination of all columns of a factor leaves of the rows of its border.

use faer::linalg::matmul::matmul;
use faer::prelude::{IntoConst, ReborrowMut};
use faer::{Accum, MatMut};

use super::numeric::resize;
use super::pattern::Pattern;
use crate::base::{PIECE, Result, spend, zeros};

/// Computes `-sum of L_s B L_s^T` over the columns of a factor with these values, where `L_s` has
/// the rows of the border: what elimination adds to the block of the border. The matrix is stored
/// by columns, of which the entries from the diagonal down are computed. `subdiagonal` has the
/// entries of B below its diagonal; without it, B is the identity.
pub(super) fn complement(
    pattern: &Pattern,
    values: &[f64],
    subdiagonal: Option<&[f64]>,
) -> Result<Vec<f64>> {
    let first = pattern.columns();
    let n = pattern.n - first;
    let mut found = zeros(n * n)?;
    let (mut weighted, mut product) = (Vec::new(), Vec::new());
    for (s, node) in pattern.nodes.iter().enumerate() {
        let below = pattern.below(s);
        let skipped = below.partition_point(|&row| (row as usize) < first);
        let rows = &below[skipped..];
        let (height, k) = (rows.len(), node.columns);
        if height == 0 {
            continue;
        }
        let source = node.panel(&values[node.range()]).subrows(k + skipped, height);
        let across = match subdiagonal {
            None => source,
            Some(subdiagonal) => {
                resize(&mut weighted, height * k)?;
                let mut across = MatMut::from_column_major_slice_mut(&mut weighted, height, k);
                across.copy_from(source);
                let blocks = node.blocks(values, subdiagonal);
                blocks.for_each(|(i, block)| block.multiply_columns(across.rb_mut(), i));
                across.into_const()
            }
        };
        let width = (PIECE / (2 * height * k)).clamp(1, height);
        for start in (0..height).step_by(width) {
            let (width, height) = (width.min(height - start), height - start);
            resize(&mut product, height * width)?;
            let piece = MatMut::from_column_major_slice_mut(&mut product, height, width);
            let left = source.subrows(start, height);
            let right = across.subrows(start, width).transpose();
            matmul(piece, Accum::Replace, left, right, 1.0, faer::Par::Seq);
            let rows = &rows[start..];
            for (j, update) in product.chunks_exact(height).enumerate() {
                let column = &mut found[(rows[j] as usize - first) * n..][..n];
                for (&row, x) in rows.iter().zip(update).skip(j) {
                    column[row as usize - first] -= x;
                }
            }
            spend((2 * height * width * k) as f64)?;
        }
    }
    Ok(found)
}
