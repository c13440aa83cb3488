use super::super::Part;
use catamaran::base::{Error, Result};

/// The names of sets of faces, and the set to which each face belongs.
///
/// ```
/// use catamaran_geometry::mesh::io::{MeshFormat, read_bytes};
///
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
/// let materials = read_bytes(text, MeshFormat::Obj)?.materials.unwrap();
/// assert_eq!(materials.of_face(0), Some("red"));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// The names: without leading or trailing blanks, control characters, or a backslash at the
    /// end.
    pub names: Vec<String>,
    /// For each face, the index of its name; [`Labels::ABSENT`] for a face without one.
    pub of_faces: Vec<u32>,
}

impl Labels {
    /// The index of an absent name.
    pub const ABSENT: u32 = u32::MAX;

    /// Returns the name of face f; `None` when it has none.
    pub fn of_face(&self, f: usize) -> Option<&str> {
        let number = *self.of_faces.get(f)?;
        self.names.get(number as usize).map(String::as_str)
    }

    /// Returns the labels of a part of the mesh that has these labels; all names stay.
    pub(super) fn part(&self, part: &Part) -> Self {
        let of_faces = part.faces.iter().map(|&f| self.of_faces[f as usize]).collect();
        Self { names: self.names.clone(), of_faces }
    }

    pub(super) fn check(&self, what: &'static str, faces: usize) -> Result<()> {
        Error::check_shape(what, (faces, 1), (self.of_faces.len(), 1))?;
        self.names.iter().try_for_each(|name| check_name(what, name))?;
        let beyond = |&number: &u32| number != Self::ABSENT && number as usize >= self.names.len();
        match self.of_faces.iter().position(beyond) {
            None => Ok(()),
            Some(f) => {
                let (number, names) = (self.of_faces[f], self.names.len());
                let why = format!("face {f} has name number {number}, out of range: {names} names");
                Err(Error::Argument { what, why })
            }
        }
    }
}

/// Returns an error unless the name can be read back from a text file.
pub(super) fn check_name(what: &'static str, name: &str) -> Result<()> {
    let ends = name.is_empty() || name.trim() != name || name.ends_with('\\');
    if ends || name.contains(char::is_control) {
        let why = format!(
            "the name {name:?} is empty, or has blanks around it, a control character or a \
             backslash at the end"
        );
        return Err(Error::Argument { what, why });
    }
    Ok(())
}

/// Returns the name in a form that can be written to another file; the result may be empty.
pub(super) fn clean_name(given: &str) -> String {
    let name = given.replace(char::is_control, " ");
    name.trim().trim_end_matches(|c: char| c == '\\' || c.is_whitespace()).into()
}
