//! Writes the plant in time as binary glTF: a skinned mesh whose joints are segments, for Blender
//! and engines.

use anyhow::{Result, bail};
use catamaran::io::Output;
use catamaran_geometry::mesh::io::write_glb;
use catamaran_simulation::plant::{Plant, Pose, RodOptions, Rods, tubes};
use serde_json::{Value, json};

use crate::report::note;

/// Joints have numbers of 16 bits.
const MOST_SEGMENTS: usize = 1 << 16;

/// Buffers of more bytes are refused by some readers.
const MOST_BYTES: usize = 1 << 31;

/// Rounding of coordinates up to this is not noted, in metres.
const ROUNDING: f64 = 1e-6;

/// Linear colours of a leaf and of a stem.
const COLORS: [[f32; 3]; 2] = [[0.10, 0.42, 0.09], [0.28, 0.17, 0.07]];

/// Refuses a plant, or a number of frames after the first, that no file can hold.
pub fn check(plant: &Plant, frames: usize) -> Result<()> {
    let n = plant.len();
    if n > MOST_SEGMENTS {
        bail!("--animation: {n} segments, where a skin of glTF has at most {MOST_SEGMENTS}");
    }
    let moving = plant.segments().iter().filter(|segment| !segment.pinned).count();
    check_bytes(moving.saturating_mul(frames + 1).saturating_mul(size_of::<[f32; 4]>()))
}

fn check_bytes(count: usize) -> Result<()> {
    if count > MOST_BYTES {
        bail!("--animation: more than 2 GiB of numbers; give fewer --frames");
    }
    Ok(())
}

/// Writes the poses at these times, in seconds, of a plant that [`check`] accepts. A segment is a
/// joint below the joint of its parent, so that only its rotation changes, and nothing stretches
/// between frames either; a pinned segment has no parent joint and does not move.
pub fn write_animation(
    plant: &Plant,
    poses: &[Pose],
    seconds: &[f64],
    sides: usize,
    mut output: Output,
) -> Result<()> {
    let n = plant.len();
    let rest = Rods::new(plant, &RodOptions::default())?.rest_pose();
    let mut file = File::default();
    let mesh = file.mesh(plant, &rest, sides)?;
    let mut nodes = joints(plant, &rest);
    nodes.push(json!({ "name": "surface", "mesh": 0, "skin": 0 }));
    let skin = file.skin(&rest);
    let animation = file.motion(plant, poses, seconds);
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "catamaran" },
        "scene": 0,
        "scenes": [{ "nodes": [n, n + 1] }],
        "nodes": nodes,
        "meshes": [mesh],
        "skins": [skin],
        "accessors": file.accessors,
        "bufferViews": file.views,
    });
    if let Some(animation) = animation {
        document["animations"] = json!([animation]);
    }
    let mut numbers = file.numbers;
    check_bytes(numbers.len())?;
    numbers.resize(numbers.len().next_multiple_of(4), 0);
    document["buffers"] = json!([{ "byteLength": numbers.len() }]);
    let text = serde_json::to_vec(&document)?;
    write_glb(&mut output, text, numbers).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// Codes of glTF 2.0: types of components, and targets of views.
mod code {
    pub const U8: u32 = 5121;
    pub const U16: u32 = 5123;
    pub const U32: u32 = 5125;
    pub const F32: u32 = 5126;
    pub const VERTICES: u32 = 34962;
    pub const INDICES: u32 = 34963;
}

/// The binary data of a document, its views and its accessors.
#[derive(Default)]
struct File {
    numbers: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// Adds binary data, at a multiple of four bytes. Returns the index of its view.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.numbers.resize(self.numbers.len().next_multiple_of(4), 0);
        let offset = self.numbers.len();
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.numbers.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor. Returns its index.
    fn accessor(
        &mut self,
        view: usize,
        offset: usize,
        count: usize,
        component: u32,
        kind: &str,
    ) -> usize {
        let mut accessor = json!({
            "bufferView": view, "byteOffset": offset, "count": count,
            "componentType": component, "type": kind,
        });
        if component == code::U8 {
            accessor["normalized"] = true.into();
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds an accessor with a separate view. Returns its index.
    fn numbers<const N: usize>(
        &mut self,
        values: &[[f32; N]],
        kind: &str,
        target: Option<u32>,
    ) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, target);
        self.accessor(view, 0, values.len(), code::F32, kind)
    }

    fn bound<const N: usize>(&mut self, accessor: usize, values: &[[f32; N]]) {
        let over = |f: fn(f32, f32) -> f32, start: f32| -> Value {
            (0..N).map(|k| values.iter().map(|x| x[k]).fold(start, f)).collect::<Vec<_>>().into()
        };
        self.accessors[accessor]["min"] = over(f32::min, f32::INFINITY);
        self.accessors[accessor]["max"] = over(f32::max, f32::NEG_INFINITY);
    }

    /// Returns the mesh of the surface of the plant at rest.
    fn mesh(&mut self, plant: &Plant, rest: &Pose, sides: usize) -> Result<Value> {
        let (vertices, faces) = tubes(plant, rest, sides, 0.0)?.into_parts();
        let vertex_data = Some(code::VERTICES);
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

        let position = self.numbers(&positions, "VEC3", vertex_data);
        self.bound(position, &positions);
        let color = self.numbers(&colors, "VEC3", vertex_data);
        let count = vertices.len();
        let view = self.view(&joints, vertex_data);
        let joint = self.accessor(view, 0, count, code::U16, "VEC4");
        let view = self.view(&weights, vertex_data);
        let weight = self.accessor(view, 0, count, code::U8, "VEC4");
        let view = self.view(&corners, Some(code::INDICES));
        let indices = self.accessor(view, 0, 3 * faces.len(), code::U32, "SCALAR");
        let primitive = json!({
            "attributes": {
                "POSITION": position, "COLOR_0": color, "JOINTS_0": joint, "WEIGHTS_0": weight,
            },
            "indices": indices,
        });
        Ok(json!({ "name": "surface", "primitives": [primitive] }))
    }

    /// Returns the skin, whose joints are the segments.
    fn skin(&mut self, rest: &Pose) -> Value {
        let n = rest.heads.len();
        // By columns: from the plant at rest to the segment.
        let inverse = |p: &[f64; 3]| {
            let [x, y, z] = p.map(|x| -x as f32);
            [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]
        };
        let inverses: Vec<[f32; 16]> = rest.heads.iter().map(inverse).collect();
        let inverses = self.numbers(&inverses, "MAT4", None);
        json!({
            "inverseBindMatrices": inverses, "joints": (0..n).collect::<Vec<_>>(), "skeleton": n,
        })
    }

    /// Returns the animation: the rotations of segments relative to their parents. `None` when all
    /// are pinned.
    fn motion(&mut self, plant: &Plant, poses: &[Pose], seconds: &[f64]) -> Option<Value> {
        let times: Vec<[f32; 1]> = seconds.iter().map(|t| [*t as f32]).collect();
        let input = self.numbers(&times, "SCALAR", None);
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
            return None;
        }
        let view = self.view(&bytes, None);
        let (mut channels, mut samplers) = (vec![], vec![]);
        for (i, &v) in moving.iter().enumerate() {
            let (offset, count) = (16 * i * poses.len(), poses.len());
            let output = self.accessor(view, offset, count, code::F32, "VEC4");
            samplers.push(json!({ "input": input, "output": output }));
            channels.push(json!({ "sampler": i, "target": { "node": v, "path": "rotation" } }));
        }
        Some(json!({ "name": "wilting", "channels": channels, "samplers": samplers }))
    }
}

/// Returns nodes 0 to n - 1, the segments, each where it begins, and node n, the plant, turned
/// from z upwards to y upwards.
fn joints(plant: &Plant, rest: &Pose) -> Vec<Value> {
    let n = plant.len();
    let mut children: Vec<Vec<usize>> = vec![vec![]; n + 1];
    for v in 0..n {
        children[above(plant, v).unwrap_or(n)].push(v);
    }
    let ground = children.pop();
    let mut nodes: Vec<Value> = Vec::with_capacity(n + 2);
    for (v, children) in children.into_iter().enumerate() {
        let from = above(plant, v).map_or([0.0; 3], |p| rest.heads[p]);
        let offset = [0, 1, 2].map(|i| (rest.heads[v][i] - from[i]) as f32);
        let mut node = json!({ "name": format!("segment {v}"), "translation": offset });
        if !children.is_empty() {
            node["children"] = children.into();
        }
        nodes.push(node);
    }
    let quarter = std::f32::consts::FRAC_1_SQRT_2;
    let turn = [-quarter, 0.0, 0.0, quarter];
    nodes.push(json!({ "name": "plant", "children": ground, "rotation": turn }));
    nodes
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
