use sprs::{CsMat, CsMatView};

/// Returns the given rows of a matrix, with the columns that have a place, at these places; the
/// result has `columns` columns, in the order of the matrix.
pub fn select(
    matrix: CsMatView<'_, f64>,
    rows: &[usize],
    place: &[Option<usize>],
    columns: usize,
) -> CsMat<f64> {
    let (mut starts, mut places, mut entries) = (vec![0], vec![], vec![]);
    for &i in rows {
        let row = matrix.outer_view(i).expect("a row of the matrix");
        for (j, &x) in row.iter() {
            if let Some(place) = place[j] {
                places.push(place);
                entries.push(x);
            }
        }
        starts.push(places.len());
    }
    CsMat::new((rows.len(), columns), starts, places, entries)
}
