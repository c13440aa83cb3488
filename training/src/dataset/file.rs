//! Files of data sets.

use std::path::Path;

use catamaran::faer::{Mat, MatRef};
use catamaran::io::{Array, Arrays, ArraysWriter, Output, read_arrays};
use catamaran::{Error, Result};

use super::{Dataset, Samples, Shapes, Template, Triples, WORD};

/// A field of a group, as an array.
trait Field {
    fn array(&self) -> Array<'_>;
    /// Reads the array with this name among those of the file at `path`.
    fn read(arrays: &Arrays, path: &Path, name: &str) -> Result<Self>
    where
        Self: Sized;
    /// Returns the number of rows.
    fn rows(&self) -> usize;
}

impl Field for Vec<f64> {
    fn array(&self) -> Array<'_> {
        Array::Vector(self)
    }

    fn read(arrays: &Arrays, _path: &Path, name: &str) -> Result<Self> {
        arrays.vector(name)
    }

    fn rows(&self) -> usize {
        self.len()
    }
}

impl Field for Vec<usize> {
    fn array(&self) -> Array<'_> {
        Array::Indices(self)
    }

    fn read(arrays: &Arrays, _path: &Path, name: &str) -> Result<Self> {
        arrays.indices(name)
    }

    fn rows(&self) -> usize {
        self.len()
    }
}

impl Field for Mat<f64> {
    fn array(&self) -> Array<'_> {
        Array::Matrix(self.as_ref())
    }

    fn read(arrays: &Arrays, _path: &Path, name: &str) -> Result<Self> {
        arrays.matrix(name)
    }

    fn rows(&self) -> usize {
        self.nrows()
    }
}

impl<const N: usize> Field for Vec<[f64; N]> {
    fn array(&self) -> Array<'_> {
        Array::Matrix(MatRef::from_row_major_slice(self.as_flattened(), self.len(), N))
    }

    fn read(arrays: &Arrays, path: &Path, name: &str) -> Result<Self> {
        let matrix = arrays.matrix(name)?;
        if matrix.ncols() != N {
            let why = format!("`{name}`: {} columns, where {N} are needed", matrix.ncols());
            return Err(Error::file(path, why));
        }
        Ok((0..matrix.nrows()).map(|i| std::array::from_fn(|j| matrix[(i, j)])).collect())
    }

    fn rows(&self) -> usize {
        self.len()
    }
}

/// Arrays that belong together; the name of each is the name of the group and that of its field.
pub(super) trait Group: Sized {
    fn write(&self, group: &str, writer: &mut ArraysWriter) -> Result<()>;
    fn read(group: &str, arrays: &Arrays, path: &Path) -> Result<Self>;
    /// Returns the names of the fields, and their numbers of rows.
    fn rows(&self) -> Vec<(&'static str, usize)>;
}

macro_rules! group {
    ($type:ident: $($field:ident),*) => {
        impl Group for $type {
            fn write(&self, group: &str, writer: &mut ArraysWriter) -> Result<()> {
                $(writer.array(&format!("{group}_{}", stringify!($field)), self.$field.array())?;)*
                Ok(())
            }

            fn read(group: &str, arrays: &Arrays, path: &Path) -> Result<Self> {
                let name = |field: &str| format!("{group}_{field}");
                Ok(Self {
                    $($field: Field::read(arrays, path, &name(stringify!($field)))?,)*
                })
            }

            fn rows(&self) -> Vec<(&'static str, usize)> {
                vec![$((stringify!($field), Field::rows(&self.$field)),)*]
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
    let dataset = Dataset {
        templates: templates
            .map(|group| Group::read(&group, &arrays, path))
            .collect::<Result<_>>()?,
        samples: Group::read("samples", &arrays, path)?,
        shapes: Group::read("shapes", &arrays, path)?,
        triples: Group::read("triples", &arrays, path)?,
    };
    check(&dataset).map_err(|why| Error::file(path, why))?;
    Ok(dataset)
}

/// Checks the lengths of arrays, and that indices are in range; an error names the array.
fn check(dataset: &Dataset) -> std::result::Result<(), String> {
    for (f, template) in dataset.templates.iter().enumerate() {
        check_template(template).map_err(|why| format!("`template{f}_{why}"))?;
    }
    let groups = [
        ("samples", dataset.samples.rows()),
        ("shapes", dataset.shapes.rows()),
        ("triples", dataset.triples.rows()),
    ];
    for (group, fields) in groups {
        let [(first, rows), others @ ..] = fields.as_slice() else { continue };
        if let Some((field, other)) = others.iter().find(|(_, other)| other != rows) {
            return Err(format!(
                "`{group}_{field}`: {other} rows, but `{group}_{first}` has {rows}"
            ));
        }
    }
    Ok(())
}

/// Checks a template; an error is the rest of the array's name, and what is wrong with it.
fn check_template(template: &Template) -> std::result::Result<(), String> {
    let vertices = template.vertices.len();
    let words = template.masks.len() * vertices.div_ceil(WORD);
    let lengths = [
        ("mirror", template.mirror.len(), vertices),
        ("mass", template.mass.len(), vertices),
        ("eigenfunctions", template.eigenfunctions.nrows(), vertices),
        ("eigenvalues", template.eigenvalues.len(), template.eigenfunctions.ncols()),
        ("mask_words", template.mask_words.len(), words),
    ];
    if let Some((field, rows, needed)) = lengths.iter().find(|(_, rows, needed)| rows != needed) {
        return Err(format!("{field}`: {rows} rows, where {needed} are needed"));
    }
    if !template.faces.len().is_multiple_of(3) {
        return Err(format!("faces`: {} indices, no multiple of 3", template.faces.len()));
    }
    for (field, indices) in [("faces", &template.faces), ("mirror", &template.mirror)] {
        if let Some(vertex) = indices.iter().find(|&&vertex| vertex >= vertices) {
            return Err(format!("{field}`: vertex {vertex} of {vertices}"));
        }
    }
    if !template.masks.is_sorted_by(|a, b| a < b) {
        return Err("masks`: do not ascend".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use catamaran::io::Overwrite;

    use super::super::EIGENVALUES;
    use super::*;

    /// A data set with a template and one sample.
    fn dataset() -> Dataset {
        let spectrum = vec![[1.0; EIGENVALUES]];
        let template = Template {
            vertices: vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            faces: vec![0, 1, 2],
            mirror: vec![1, 0, 2],
            mass: vec![1.0 / 3.0; 3],
            eigenvalues: vec![0.0],
            eigenfunctions: Mat::full(3, 1, 1.0),
            masks: vec![3, 5],
            mask_words: vec![7; 2],
        };
        let samples = Samples {
            part1: spectrum.clone(),
            part2: spectrum.clone(),
            union: spectrum,
            areas: vec![[1.0; 3]],
            family: vec![0],
            identity: vec![0],
            body: vec![0],
            pose: vec![0],
            mask1: vec![3],
            mask2: vec![5],
            mask_union: vec![5],
            remeshed: vec![0],
            split: vec![0],
            knowledge: vec![0],
        };
        Dataset { templates: vec![template], samples, ..Dataset::default() }
    }

    #[test]
    fn damaged_data_sets_are_refused_with_their_array() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.npz");
        let through_file = |dataset: &Dataset| {
            write(dataset, Output::create(&path, Overwrite::Replace).unwrap()).unwrap();
            read(&path)
        };
        assert_eq!(through_file(&dataset()).unwrap(), dataset());
        type Damage = fn(&mut Dataset);
        let damages: [(Damage, &str); 8] = [
            (|set| set.samples.mask2.clear(), "`samples_mask2`: 0 rows, but `samples_part1` has 1"),
            (|set| set.shapes.area.push(1.0), "`shapes_area`: 1 rows, but `shapes_spectrum` has 0"),
            (|set| set.triples.pose.push(0), "`triples_pose`: 1 rows"),
            (|set| set.templates[0].faces[1] = 3, "`template0_faces`: vertex 3 of 3"),
            (|set| set.templates[0].faces.push(0), "`template0_faces`: 4 indices"),
            (|set| set.templates[0].mirror[2] = 9, "`template0_mirror`: vertex 9 of 3"),
            (|set| set.templates[0].mass.clear(), "`template0_mass`: 0 rows, where 3 are needed"),
            (|set| set.templates[0].masks.reverse(), "`template0_masks`: do not ascend"),
        ];
        for (damage, says) in damages {
            let mut set = dataset();
            damage(&mut set);
            let refused = through_file(&set).unwrap_err().to_string();
            assert!(refused.contains("set.npz: ") && refused.contains(says), "{refused}");
        }
    }
}
