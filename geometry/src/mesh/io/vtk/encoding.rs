/// The encoding of a legacy VTK file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VtkEncoding {
    /// Text, with every digit of double precision.
    Ascii,
    /// Binary, big endian, in double precision.
    Binary,
}
