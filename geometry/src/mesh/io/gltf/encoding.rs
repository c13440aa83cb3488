/// The encoding of a glTF file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GltfEncoding {
    /// JSON, with the numbers in it as base64 (`.gltf`).
    Text,
    /// Binary (`.glb`).
    Binary,
}
