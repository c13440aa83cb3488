/// How the numbers of a PLY file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlyEncoding {
    /// Text.
    Ascii,
    /// Binary, lowest byte first.
    LittleEndian,
    /// Binary, highest byte first.
    BigEndian,
}
