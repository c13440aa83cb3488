//! Writes the plant in time as binary glTF: a skinned mesh whose joints are segments, for Blender
//! and engines.

use std::borrow::Cow;
use std::io::Write;

use anyhow::{Result, bail};
use catamaran::io::Output;
use catamaran_simulation::plant::{Plant, Pose, RodOptions, Rods, tubes};
use gltf::Glb;
use gltf::binary::Header;
use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf::json::animation::{Animation, Channel, Interpolation, Property, Sampler, Target};
use gltf::json::buffer::{self, Buffer, View};
use gltf::json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf::json::scene::UnitQuaternion;
use gltf::json::validation::Checked::Valid;
use gltf::json::{Index, Node, Root, Scene, Skin, Value};

use crate::report::note;

/// Joints have numbers of 16 bits.
const MOST_SEGMENTS: usize = 1 << 16;

/// Rounding of coordinates up to this is not noted, in metres.
const ROUNDING: f64 = 1e-6;

/// Linear colours of a leaf and of a stem.
const COLORS: [[f32; 3]; 2] = [[0.10, 0.42, 0.09], [0.28, 0.17, 0.07]];

/// Writes the poses at these times, in seconds. A segment is a joint below the joint of its parent,
/// so that only its rotation changes, and nothing stretches between frames either; a pinned segment
/// has no parent joint and does not move.
pub fn write_animation(
    plant: &Plant,
    poses: &[Pose],
    seconds: &[f64],
    sides: usize,
    mut output: Output,
) -> Result<()> {
    let n = plant.len();
    if n > MOST_SEGMENTS {
        bail!("--animation: {n} segments, where a skin of glTF has at most {MOST_SEGMENTS}");
    }
    let rest = Rods::new(plant, &RodOptions::default())?.rest_pose();
    let mut file = File::default();
    let mesh = file.mesh(plant, &rest, sides)?;
    let skin = file.joints(plant, &rest);
    let skinned = Node {
        mesh: Some(mesh),
        skin: Some(skin),
        name: Some("surface".into()),
        ..Node::default()
    };
    let nodes = vec![Index::new(n as u32), file.root.push(skinned)];
    let scene = Scene { nodes, name: None, extensions: None, extras: Default::default() };
    file.root.scene = Some(file.root.push(scene));
    file.motion(plant, poses, seconds);
    output.write_all(&file.bytes()?).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// A document and its binary data.
#[derive(Default)]
struct File {
    root: Root,
    numbers: Vec<u8>,
}

impl File {
    /// Adds binary data, at a multiple of four bytes.
    fn view(&mut self, bytes: &[u8], target: Option<buffer::Target>) -> Index<View> {
        self.numbers.resize(self.numbers.len().next_multiple_of(4), 0);
        let view = View {
            buffer: Index::new(0),
            byte_length: bytes.len().into(),
            byte_offset: Some(self.numbers.len().into()),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: Default::default(),
        };
        self.numbers.extend_from_slice(bytes);
        self.root.push(view)
    }

    fn accessor(
        &mut self,
        view: Index<View>,
        offset: usize,
        count: usize,
        component: ComponentType,
        kind: Type,
    ) -> Index<Accessor> {
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: Some(offset.into()),
            count: count.into(),
            component_type: Valid(GenericComponentType(component)),
            extensions: None,
            extras: Default::default(),
            type_: Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: component == ComponentType::U8,
            sparse: None,
        })
    }

    /// Adds an accessor with a separate view.
    fn numbers<const N: usize>(
        &mut self,
        values: &[[f32; N]],
        kind: Type,
        target: Option<buffer::Target>,
    ) -> Index<Accessor> {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, target);
        self.accessor(view, 0, values.len(), ComponentType::F32, kind)
    }

    fn bound<const N: usize>(&mut self, accessor: Index<Accessor>, values: &[[f32; N]]) {
        let over = |f: fn(f32, f32) -> f32, start: f32| -> Value {
            (0..N).map(|k| values.iter().map(|x| x[k]).fold(start, f)).collect::<Vec<_>>().into()
        };
        let accessor = &mut self.root.accessors[accessor.value()];
        accessor.min = Some(over(f32::min, f32::INFINITY));
        accessor.max = Some(over(f32::max, f32::NEG_INFINITY));
    }

    /// Adds the surface of the plant at rest.
    fn mesh(&mut self, plant: &Plant, rest: &Pose, sides: usize) -> Result<Index<Mesh>> {
        let (vertices, faces) = tubes(plant, rest, sides, 0.0)?.into_parts();
        let vertex_data = Some(buffer::Target::ArrayBuffer);
        let positions: Vec<[f32; 3]> = vertices.iter().map(|p| p.map(|x| x as f32)).collect();
        let moved = |x: &f64| (f64::from(*x as f32) - x).abs();
        let moved = vertices.as_flattened().iter().map(moved).fold(0.0, f64::max);
        if moved > ROUNDING {
            note(format_args!(
                "--animation: glTF has single precision: coordinates are rounded by up to \
                 {moved:.1e} m"
            ));
        }
        let segment = |i: usize| i / (2 * sides);
        let color = |i: usize| COLORS[usize::from(!plant.segments()[segment(i)].leaf)];
        let colors: Vec<[f32; 3]> = (0..vertices.len()).map(color).collect();
        let joints: Vec<u8> = (0..vertices.len())
            .flat_map(|i| [segment(i) as u16, 0, 0, 0])
            .flat_map(u16::to_le_bytes)
            .collect();
        let weights = [255, 0, 0, 0].repeat(vertices.len());
        let corners: Vec<u8> = faces.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();

        let position = self.numbers(&positions, Type::Vec3, vertex_data);
        self.bound(position, &positions);
        let color = self.numbers(&colors, Type::Vec3, vertex_data);
        let count = vertices.len();
        let view = self.view(&joints, vertex_data);
        let joint = self.accessor(view, 0, count, ComponentType::U16, Type::Vec4);
        let view = self.view(&weights, vertex_data);
        let weight = self.accessor(view, 0, count, ComponentType::U8, Type::Vec4);
        let view = self.view(&corners, Some(buffer::Target::ElementArrayBuffer));
        let indices = self.accessor(view, 0, 3 * faces.len(), ComponentType::U32, Type::Scalar);
        let primitive = Primitive {
            attributes: [
                (Valid(Semantic::Positions), position),
                (Valid(Semantic::Colors(0)), color),
                (Valid(Semantic::Joints(0)), joint),
                (Valid(Semantic::Weights(0)), weight),
            ]
            .into(),
            extensions: None,
            extras: Default::default(),
            indices: Some(indices),
            material: None,
            mode: Valid(Mode::Triangles),
            targets: None,
        };
        Ok(self.root.push(Mesh {
            extensions: None,
            extras: Default::default(),
            name: Some("surface".into()),
            primitives: vec![primitive],
            weights: None,
        }))
    }

    /// Adds nodes 0 to n - 1, the segments, each where it begins, and node n, the plant, turned
    /// from z upwards to y upwards.
    fn joints(&mut self, plant: &Plant, rest: &Pose) -> Index<Skin> {
        let n = plant.len();
        let mut children: Vec<Vec<Index<Node>>> = vec![vec![]; n + 1];
        for v in 0..n {
            children[above(plant, v).unwrap_or(n)].push(Index::new(v as u32));
        }
        let ground = children.pop();
        for (v, children) in children.into_iter().enumerate() {
            let from = above(plant, v).map_or([0.0; 3], |p| rest.heads[p]);
            let offset = [0, 1, 2].map(|i| (rest.heads[v][i] - from[i]) as f32);
            self.root.push(Node {
                children: (!children.is_empty()).then_some(children),
                name: Some(format!("segment {v}")),
                translation: Some(offset),
                ..Node::default()
            });
        }
        let quarter = std::f32::consts::FRAC_1_SQRT_2;
        let plant_node = self.root.push(Node {
            children: ground,
            name: Some("plant".into()),
            rotation: Some(UnitQuaternion([-quarter, 0.0, 0.0, quarter])),
            ..Node::default()
        });
        // By columns: from the plant at rest to the segment.
        let inverse = |p: &[f64; 3]| {
            let [x, y, z] = p.map(|x| -x as f32);
            [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]
        };
        let inverses: Vec<[f32; 16]> = rest.heads.iter().map(inverse).collect();
        let inverses = self.numbers(&inverses, Type::Mat4, None);
        self.root.push(Skin {
            extensions: None,
            extras: Default::default(),
            inverse_bind_matrices: Some(inverses),
            joints: (0..n as u32).map(Index::new).collect(),
            name: None,
            skeleton: Some(plant_node),
        })
    }

    /// Adds the rotations of segments relative to their parents.
    fn motion(&mut self, plant: &Plant, poses: &[Pose], seconds: &[f64]) {
        let times: Vec<[f32; 1]> = seconds.iter().map(|t| [*t as f32]).collect();
        let input = self.numbers(&times, Type::Scalar, None);
        self.bound(input, &times);
        let moving: Vec<usize> =
            (0..plant.len()).filter(|&v| !plant.segments()[v].pinned).collect();
        let mut bytes = Vec::with_capacity(16 * moving.len() * poses.len());
        for &v in &moving {
            let mut before = [0.0; 4];
            for pose in poses {
                let [w, x, y, z] = local(plant, pose, v);
                // Of the two quaternions of a rotation, the one near that of the frame before.
                let dot: f64 = before.iter().zip([x, y, z, w]).map(|(a, b)| a * b).sum();
                let sign = if dot < 0.0 { -1.0 } else { 1.0 };
                before = [x, y, z, w].map(|c| sign * c);
                bytes.extend(before.iter().flat_map(|c| (*c as f32).to_le_bytes()));
            }
        }
        if moving.is_empty() {
            return;
        }
        let view = self.view(&bytes, None);
        let (mut channels, mut samplers) = (vec![], vec![]);
        for (i, &v) in moving.iter().enumerate() {
            let (offset, count) = (16 * i * poses.len(), poses.len());
            let output = self.accessor(view, offset, count, ComponentType::F32, Type::Vec4);
            let sampler = Sampler {
                extensions: None,
                extras: Default::default(),
                input,
                interpolation: Valid(Interpolation::Linear),
                output,
            };
            let target = Target {
                extensions: None,
                extras: Default::default(),
                node: Index::new(v as u32),
                path: Valid(Property::Rotation),
            };
            let sampler = Index::push(&mut samplers, sampler);
            channels.push(Channel {
                sampler,
                target,
                extensions: None,
                extras: Default::default(),
            });
        }
        self.root.push(Animation {
            extensions: None,
            extras: Default::default(),
            channels,
            name: Some("wilting".into()),
            samplers,
        });
    }

    fn bytes(mut self) -> Result<Vec<u8>> {
        const MOST: usize = 1 << 31;
        if self.numbers.len() > MOST {
            bail!("--animation: more than 2 GiB of numbers; give fewer --frames");
        }
        self.numbers.resize(self.numbers.len().next_multiple_of(4), 0);
        self.root.push(Buffer {
            byte_length: self.numbers.len().into(),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        let json = self.root.to_vec()?;
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let file = Glb { header, json: Cow::Owned(json), bin: Some(Cow::Owned(self.numbers)) };
        Ok(file.to_vec()?)
    }
}

/// Returns the parent joint of a segment; `None` for the root and for a pinned segment.
fn above(plant: &Plant, v: usize) -> Option<usize> {
    plant.parent(v).filter(|_| !plant.segments()[v].pinned)
}

/// Returns the rotation of a segment relative to its parent joint: `conj(q_parent) q`, (w, x, y,
/// z).
fn local(plant: &Plant, pose: &Pose, v: usize) -> [f64; 4] {
    let [b0, b1, b2, b3] = pose.rotations[v];
    let Some(p) = above(plant, v).filter(|&p| !plant.segments()[p].pinned) else {
        return [b0, b1, b2, b3];
    };
    let [a0, a1, a2, a3] = pose.rotations[p];
    [
        a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3,
        a0 * b1 - a1 * b0 - a2 * b3 + a3 * b2,
        a0 * b2 - a2 * b0 - a3 * b1 + a1 * b3,
        a0 * b3 - a3 * b0 - a1 * b2 + a2 * b1,
    ]
}
