//! The JSON of a glTF file, as far as it concerns triangles.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IgnoredAny;

/// The extensions of an object, by name.
pub(super) type Extensions = BTreeMap<String, IgnoredAny>;

/// Codes of components and primitives, and types of elements.
pub(super) mod code {
    pub const I8: u32 = 5120;
    pub const U8: u32 = 5121;
    pub const I16: u32 = 5122;
    pub const U16: u32 = 5123;
    pub const U32: u32 = 5125;
    pub const F32: u32 = 5126;
    pub const POINTS: u32 = 0;
    pub const LINES: u32 = 1;
    pub const LINE_STRIP: u32 = 3;
    pub const TRIANGLES: u32 = 4;
    pub const TRIANGLE_STRIP: u32 = 5;
    pub const TRIANGLE_FAN: u32 = 6;
    pub const VERTICES: u32 = 34962;
    pub const INDICES: u32 = 34963;
    pub const LINEAR: u32 = 9729;
    pub const LINEAR_MIPMAP_LINEAR: u32 = 9987;
    pub const REPEAT: u32 = 10497;
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Document {
    pub asset: Asset,
    pub extensions_required: Vec<String>,
    pub extensions_used: Vec<String>,
    pub extensions: Extensions,
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub materials: Vec<Material>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<View>,
    pub buffers: Vec<Buffer>,
    pub textures: Vec<IgnoredAny>,
    pub animations: Vec<IgnoredAny>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Asset {
    pub version: String,
    pub min_version: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Scene {
    pub nodes: Vec<usize>,
    pub extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    /// Present where joints deform the mesh.
    pub skin: Option<IgnoredAny>,
    /// Weights of the morph targets of the mesh, in place of its own.
    pub weights: Option<Vec<f64>>,
    pub extensions: NodeExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instances: Option<Instances>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
    #[serde(flatten)]
    pub others: Extensions,
}

/// Instances of the mesh of a node: accessors of their transformations, by name.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Instances {
    pub attributes: BTreeMap<String, usize>,
}

#[derive(Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "visible")]
    pub visible: bool,
}

fn visible() -> bool {
    true
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Mesh {
    pub primitives: Vec<Primitive>,
    /// Weights of the morph targets.
    pub weights: Vec<f64>,
    pub extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    /// Morph targets: displacements of the attributes.
    pub targets: Vec<Attributes>,
    pub extensions: PrimitiveExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
    #[serde(flatten)]
    pub others: Extensions,
}

/// The view that has a stream of Draco, and the numbers of its attributes, by name.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Draco {
    pub buffer_view: usize,
    #[serde(default)]
    pub attributes: BTreeMap<String, u32>,
}

/// Indices of accessors.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    pub position: Option<usize>,
    pub normal: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    pub uv: Option<usize>,
    #[serde(rename = "COLOR_0")]
    pub color: Option<usize>,
    #[serde(flatten)]
    pub others: BTreeMap<String, IgnoredAny>,
}

impl Attributes {
    /// Returns the names and accessors of the attributes that are read.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let all = [
            ("POSITION", self.position),
            ("NORMAL", self.normal),
            ("TEXCOORD_0", self.uv),
            ("COLOR_0", self.color),
        ];
        all.into_iter().filter_map(|(name, accessor)| Some((name, accessor?)))
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Material {
    pub name: String,
    #[serde(flatten)]
    pub others: BTreeMap<String, IgnoredAny>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    pub byte_offset: usize,
    pub component_type: u32,
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
    pub extensions: Extensions,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub count: usize,
    pub indices: SparsePart,
    pub values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    /// Present for indices only.
    #[serde(default)]
    pub component_type: u32,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct View {
    pub buffer: usize,
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    pub extensions: ViewExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub packed: Option<Packed>,
    #[serde(flatten)]
    pub others: Extensions,
}

/// The packed bytes of a view, in a buffer of their own.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Packed {
    pub buffer: usize,
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: String,
    pub filter: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
    pub extensions: BufferExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct BufferExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub unpacked: Option<Unpacked>,
    #[serde(flatten)]
    pub others: Extensions,
}

/// Whether a buffer has only the bytes that packed views unpack to.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Unpacked {
    pub fallback: bool,
}
