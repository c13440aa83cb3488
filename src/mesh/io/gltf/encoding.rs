/// How a glTF file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GltfEncoding {
    /// JSON, with the numbers in it as base64 (`.gltf`).
    Text,
    /// Binary (`.glb`).
    Binary,
}
