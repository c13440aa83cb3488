//! Primitives that KHR_draco_mesh_compression packs, by crate draco-core.
//!
//! Source: "KHR_draco_mesh_compression" (Khronos).

use std::panic::{AssertUnwindSafe, catch_unwind};

use draco_core::draco_types::DataType;
use draco_core::geometry_indices::PointIndex;
use draco_core::{DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder};

use super::super::draft::{Checked, roomy};
use super::document::{Accessor, code};
use super::layout::{Layout, width};
use catamaran::base::push;
use catamaran::io::LARGER_MAX_MEMORY;

/// The name of the extension.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// Bytes of memory that a byte of a value takes while it is unpacked, and that a face takes.
const PER_BYTE: u64 = 8;
const PER_FACE: u64 = 256;

/// What a stream unpacks to.
pub(super) struct Unpacked(Mesh);

impl Unpacked {
    /// Unpacks a stream within so many bytes of memory.
    pub fn new(stream: &[u8], memory: u64) -> Checked<Self> {
        let limits = DecodeLimits::default()
            .with_max_faces(memory / PER_FACE)
            .with_max_points(memory / PER_FACE)
            .with_max_decoded_bytes(memory / PER_BYTE);
        let unpack = || {
            let mut mesh = Mesh::new();
            let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
            MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
        };
        // The crate is safe code, which may panic on unexpected input.
        match catch_unwind(AssertUnwindSafe(unpack)) {
            Ok(Ok(mesh)) => Ok(Self(mesh)),
            Ok(Err(e)) if e.kind() == ErrorKind::LimitExceeded => {
                Err(format!("takes more memory than the file may take: {LARGER_MAX_MEMORY}").into())
            }
            Ok(Err(e)) => Err(format!("can't be unpacked: {e}").into()),
            Err(_) => Err("can't be unpacked".into()),
        }
    }

    /// Returns the numbers of the vertices of the corners of all triangles.
    pub fn corners(&self) -> Checked<Vec<f64>> {
        let mut corners = roomy(self.0.num_faces().saturating_mul(3));
        for corner in self.0.faces().as_flattened() {
            push(&mut corners, f64::from(corner.0))?;
        }
        Ok(corners)
    }

    /// Returns the values of an attribute for all vertices, which an accessor describes.
    pub fn values(&self, id: u32, accessor: &Accessor) -> Checked<Vec<f64>> {
        let attribute = self.0.attribute_by_unique_id(id);
        let attribute = attribute.ok_or_else(|| format!("has no attribute {id}"))?;
        let given = usize::from(attribute.num_components());
        if width(&accessor.kind) != Some(given) {
            let kind = &accessor.kind;
            return Err(format!("attribute {id} has {given} numbers, which are no {kind}").into());
        }
        let component = match attribute.data_type() {
            DataType::Int8 => code::I8,
            DataType::Uint8 => code::U8,
            DataType::Int16 => code::I16,
            DataType::Uint16 => code::U16,
            DataType::Uint32 => code::U32,
            DataType::Float32 => code::F32,
            other => return Err(format!("attribute {id} is of type {other:?}").into()),
        };
        let points = self.0.num_points();
        let layout = Layout { component, normalized: accessor.normalized, count: points };
        let size = attribute.data_type().byte_length();
        let stride = usize::try_from(attribute.byte_stride()).unwrap_or_default();
        let bytes = attribute.buffer().data();
        let mut values = roomy(points.saturating_mul(given));
        for p in 0..points {
            let value = attribute.mapped_index(PointIndex(p as u32)).0 as usize;
            let own = value.checked_mul(stride).and_then(|at| bytes.get(at..)?.get(..given * size));
            let own = own.ok_or_else(|| format!("attribute {id}: no value of vertex {p}"))?;
            for number in own.chunks_exact(size) {
                push(&mut values, layout.number(number))?;
            }
        }
        Ok(values)
    }
}
