//! Files of data sets.

use std::path::Path;

use catamaran::faer::{Mat, MatRef};
use catamaran::io::{Array, Arrays, ArraysWriter, Output, read_arrays};
use catamaran::{Error, Result};

use super::{Dataset, Samples, Shapes, Template, Triples};

/// A field of a group, as an array.
trait Field {
    fn array(&self) -> Array<'_>;
    fn read(arrays: &Arrays, name: &str) -> Result<Self>
    where
        Self: Sized;
}

impl Field for Vec<f64> {
    fn array(&self) -> Array<'_> {
        Array::Vector(self)
    }

    fn read(arrays: &Arrays, name: &str) -> Result<Self> {
        arrays.vector(name)
    }
}

impl Field for Vec<usize> {
    fn array(&self) -> Array<'_> {
        Array::Indices(self)
    }

    fn read(arrays: &Arrays, name: &str) -> Result<Self> {
        arrays.indices(name)
    }
}

impl Field for Mat<f64> {
    fn array(&self) -> Array<'_> {
        Array::Matrix(self.as_ref())
    }

    fn read(arrays: &Arrays, name: &str) -> Result<Self> {
        arrays.matrix(name)
    }
}

impl<const N: usize> Field for Vec<[f64; N]> {
    fn array(&self) -> Array<'_> {
        Array::Matrix(MatRef::from_row_major_slice(self.as_flattened(), self.len(), N))
    }

    fn read(arrays: &Arrays, name: &str) -> Result<Self> {
        let matrix = arrays.matrix(name)?;
        if matrix.ncols() != N {
            let (expected, got) = ((matrix.nrows(), N), matrix.shape());
            return Err(Error::Shape { what: "array of the data set", expected, got });
        }
        Ok((0..matrix.nrows()).map(|i| std::array::from_fn(|j| matrix[(i, j)])).collect())
    }
}

/// Arrays that belong together; the name of each is the name of the group and that of its field.
pub(super) trait Group: Sized {
    fn write(&self, group: &str, writer: &mut ArraysWriter) -> Result<()>;
    fn read(group: &str, arrays: &Arrays) -> Result<Self>;
}

macro_rules! group {
    ($type:ident: $($field:ident),*) => {
        impl Group for $type {
            fn write(&self, group: &str, writer: &mut ArraysWriter) -> Result<()> {
                $(writer.array(&format!("{group}_{}", stringify!($field)), self.$field.array())?;)*
                Ok(())
            }

            fn read(group: &str, arrays: &Arrays) -> Result<Self> {
                Ok(Self {
                    $($field: Field::read(arrays, &format!("{group}_{}", stringify!($field)))?,)*
                })
            }
        }
    };
}

group!(Template: vertices, faces, mirror, mass, eigenvalues, eigenfunctions, masks, mask_words);
group!(Samples: part1, part2, union, areas, family, identity, body, pose, mask1, mask2, mask_union, remeshed, split, knowledge);
group!(Shapes: spectrum, area, family, identity, body, pose, knowledge);
group!(Triples: part1, part2, part3, union12, union23, whole, family, identity, pose, mask, knowledge);

/// Writes a data set to `.npz`, or to `.h5` with the feature `hdf5`.
///
/// # Errors
/// Those of [`ArraysWriter`]; then no file is left behind.
pub fn write(dataset: &Dataset, output: Output) -> Result<()> {
    let mut writer = ArraysWriter::new(output)?;
    for (f, template) in dataset.templates.iter().enumerate() {
        template.write(&format!("template{f}"), &mut writer)?;
    }
    dataset.samples.write("samples", &mut writer)?;
    dataset.shapes.write("shapes", &mut writer)?;
    dataset.triples.write("triples", &mut writer)?;
    writer.finish()
}

/// Reads a data set that [`write`](fn@write) has written.
///
/// # Errors
/// [`Error::Io`] names the array that is missing or invalid.
pub fn read(path: &Path) -> Result<Dataset> {
    let arrays = read_arrays(path)?;
    let templates = (0..)
        .map(|f| format!("template{f}"))
        .take_while(|group| arrays.names().any(|name| name == format!("{group}_faces")));
    Ok(Dataset {
        templates: templates.map(|group| Group::read(&group, &arrays)).collect::<Result<_>>()?,
        samples: Group::read("samples", &arrays)?,
        shapes: Group::read("shapes", &arrays)?,
        triples: Group::read("triples", &arrays)?,
    })
}
