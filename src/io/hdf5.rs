//! Several arrays in one HDF5 file, each a dataset of its root.

use ::hdf5::{Dataset, Dataspace, Datatype, File, Hyperslab, Selection};
use faer::MatRef;

use super::npz::Array;
use super::output::Output;
use super::source::error;
use crate::base::{Error, Result, reserved};

/// Entries of rows that are written together.
const BUFFER: usize = 1 << 20;

/// Writes named arrays into `output` and lets it appear.
pub(super) fn write_hdf5(output: Output, arrays: &[(&str, Array<'_>)]) -> Result<()> {
    let path = output.path().to_owned();
    let fail = |e: ::hdf5::Error| error(&path, 0, format!("can't be written: HDF5 says: {e}"));
    let file = File::create(output.temporary_path()).map_err(fail)?;
    for (name, array) in arrays {
        match array {
            Array::Vector(values) => {
                let dataset = file.new_dataset::<f64>().shape(values.len()).create(*name);
                dataset.and_then(|dataset| dataset.write_raw(*values)).map_err(fail)?;
            }
            Array::Indices(values) => {
                let values: Vec<u64> = values.iter().map(|&value| value as u64).collect();
                let dataset = file.new_dataset::<u64>().shape(values.len()).create(*name);
                dataset.and_then(|dataset| dataset.write_raw(&values)).map_err(fail)?;
            }
            Array::Matrix(matrix) => {
                let dataset = file.new_dataset::<f64>().shape(matrix.shape()).create(*name);
                write_matrix(&dataset.map_err(fail)?, *matrix, fail)?;
            }
        }
    }
    file.close().map_err(fail)?;
    output.commit()
}

fn write_matrix(
    dataset: &Dataset,
    matrix: MatRef<'_, f64>,
    fail: impl Fn(::hdf5::Error) -> Error,
) -> Result<()> {
    let (rows, width) = matrix.shape();
    if width == 0 {
        return Ok(());
    }
    let at_once = (BUFFER / width).clamp(1, rows.max(1));
    let mut block = reserved(at_once * width)?;
    for first in (0..rows).step_by(at_once) {
        let height = at_once.min(rows - first);
        block.clear();
        for i in first..first + height {
            block.extend((0..width).map(|j| matrix[(i, j)]));
        }
        write_block(dataset, first, width, &block).map_err(&fail)?;
    }
    Ok(())
}

/// Rows of `width` entries from `first` on.
fn write_block(dataset: &Dataset, first: usize, width: usize, block: &[f64]) -> ::hdf5::Result<()> {
    let rows = block.len() / width;
    let span = [(first..first + rows).into(), (0..width).into()];
    let target = dataset.space()?.select(Selection::from(Hyperslab::from(span.to_vec())))?;
    let source = Dataspace::try_new([rows, width])?;
    let memory = Datatype::from_type::<f64>()?;
    ::hdf5::sync::sync(|| {
        // SAFETY: the handles are alive; HDF5 reads rows x width entries, which the block has.
        let status = unsafe {
            ::hdf5_sys::h5d::H5Dwrite(
                dataset.id(),
                memory.id(),
                source.id(),
                target.id(),
                ::hdf5_sys::h5p::H5P_DEFAULT,
                block.as_ptr().cast(),
            )
        };
        if status < 0 { Err(::hdf5::Error::query().unwrap_or_else(|e| e)) } else { Ok(()) }
    })
}
