//! The meshes of a scene with the transformations of their nodes.

use super::super::draft::Checked;
use super::super::notes::Notes;
use super::container::Content;
use super::document::{Document, Instances, Node};
use super::transform::Transform;
use catamaran::base::push;
use catamaran::io::Source;

/// A mesh at the place of its node.
pub(super) struct Placed<'c> {
    /// The index of the mesh.
    pub mesh: usize,
    pub transform: Transform,
    /// Weights of morph targets that replace those of the mesh.
    pub weights: Option<&'c [f64]>,
}

/// A node that is to be visited.
struct Visit {
    node: usize,
    /// From the parent of the node to the scene.
    parent: Transform,
    visible: bool,
}

/// Returns the meshes of the scene in the order of its nodes, and notes what is left out.
///
/// A file without scenes shows its nodes without parents, and a file without nodes its meshes.
pub(super) fn placed<'c>(
    content: &'c Content<'_>,
    source: &Source<'_>,
    notes: &mut Notes,
) -> Checked<Vec<Placed<'c>>> {
    let document = &content.document;
    let mut placed = Vec::new();
    let Some(roots) = roots(document)? else {
        for mesh in 0..document.meshes.len() {
            push(&mut placed, Placed { mesh, transform: Transform::IDENTITY, weights: None })?;
        }
        return Ok(placed);
    };
    let mut seen = vec![false; document.nodes.len()];
    let visit = |parent, visible| move |&node: &usize| Visit { node, parent, visible };
    let mut next: Vec<Visit> = roots.iter().rev().map(visit(Transform::IDENTITY, true)).collect();
    while let Some(Visit { node: index, parent, visible }) = next.pop() {
        let node = document.nodes.get(index).ok_or_else(|| format!("no node {index}"))?;
        // A node with two parents is an error: without this check, nodes could be visited
        // without end.
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("node {index} has two parents").into());
        }
        let visible =
            visible && node.extensions.visibility.as_ref().is_none_or(|given| given.visible);
        let own = Transform::of(node).map_err(|fault| fault.of(|| format!("node {index}")))?;
        let transform = parent.after(&own);
        match node.mesh {
            Some(mesh) if visible => {
                let transform = of_mesh(node, index, transform, notes);
                place(content, source, node, index, mesh, transform, &mut placed)?;
            }
            Some(_) => {
                notes
                    .add("left out hidden nodes (KHR_node_visibility)", || format!("node {index}"));
            }
            None => {}
        }
        next.extend(node.children.iter().rev().map(visit(transform, visible)));
    }
    note_outside(document, &seen, notes);
    Ok(placed)
}

/// Returns the nodes from which the scene is reached; `None` for a file without scenes in which no
/// node has a mesh.
fn roots(document: &Document) -> Checked<Option<Vec<usize>>> {
    let scene = match document.scene {
        Some(i) => Some(document.scenes.get(i).ok_or_else(|| format!("no scene {i}"))?),
        None => document.scenes.first(),
    };
    if let Some(scene) = scene {
        return Ok(Some(scene.nodes.clone()));
    }
    if document.nodes.iter().all(|node| node.mesh.is_none()) {
        return Ok(None);
    }
    let mut is_root = vec![true; document.nodes.len()];
    for &child in document.nodes.iter().flat_map(|node| &node.children) {
        *is_root.get_mut(child).ok_or_else(|| format!("no node {child}"))? = false;
    }
    Ok(Some((0..is_root.len()).filter(|&node| is_root[node]).collect()))
}

/// Returns the transformation of the mesh of a node.
fn of_mesh(node: &Node, index: usize, transform: Transform, notes: &mut Notes) -> Transform {
    if node.skin.is_none() {
        return transform;
    }
    // The joints place a skinned mesh, not its node (glTF 2.0, section 3.7.3.3).
    let what = "read skinned meshes as they are modelled, without the pose of their joints";
    notes.add(what, || format!("node {index}"));
    Transform::IDENTITY
}

/// Adds the mesh of a node, once for each of its instances.
fn place<'c>(
    content: &'c Content<'_>,
    source: &Source<'_>,
    node: &'c Node,
    index: usize,
    mesh: usize,
    transform: Transform,
    placed: &mut Vec<Placed<'c>>,
) -> Checked<()> {
    let weights = node.weights.as_deref();
    let Some(instances) = &node.extensions.instances else {
        return Ok(push(placed, Placed { mesh, transform, weights })?);
    };
    let read = each_instance(content, source, instances, placed.len(), &mut |instance| {
        Ok(push(placed, Placed { mesh, transform: transform.after(&instance), weights })?)
    });
    read.map_err(|fault| fault.of(|| format!("node {index}: EXT_mesh_gpu_instancing")))
}

/// Calls `add` with the transformation of each instance; `so_far` meshes are placed already.
fn each_instance(
    content: &Content<'_>,
    source: &Source<'_>,
    instances: &Instances,
    so_far: usize,
    add: &mut dyn FnMut(Transform) -> Checked<()>,
) -> Checked<()> {
    let mut count = None;
    for &accessor in instances.attributes.values() {
        let given = content.count(accessor)?;
        if *count.get_or_insert(given) != given {
            return Err("attributes of different counts".into());
        }
    }
    let count = count.ok_or("no attributes")?;
    source.check_memory::<Placed<'_>>("the instances", so_far.saturating_add(count))?;
    let named = |name: &str| instances.attributes.get(name).copied();
    let translations = named("TRANSLATION").map(|i| content.values::<3>(i)).transpose()?;
    let rotations = named("ROTATION").map(|i| content.values::<4>(i)).transpose()?;
    let scales = named("SCALE").map(|i| content.values::<3>(i)).transpose()?;
    for i in 0..count {
        let translation = translations.as_ref().and_then(|values| values.get(i)).copied();
        let rotation = rotations.as_ref().and_then(|values| values.get(i)).copied();
        let scale = scales.as_ref().and_then(|values| values.get(i)).copied();
        add(Transform::of_parts(translation, rotation, scale))?;
    }
    Ok(())
}

/// Notes the nodes with meshes that are not in the scene, and the meshes of no node.
fn note_outside(document: &Document, seen: &[bool], notes: &mut Notes) {
    let outside = |(node, seen): &(&Node, &bool)| node.mesh.is_some() && !**seen;
    let nodes = document.nodes.iter().zip(seen);
    let count = nodes.clone().filter(outside).count();
    let first = nodes.clone().position(|pair| outside(&pair)).unwrap_or_default();
    let what = "left out nodes with meshes that are not in the scene";
    notes.add_many(what, count, || format!("node {first}"));

    let mut shown = vec![false; document.meshes.len()];
    for mesh in document.nodes.iter().filter_map(|node| node.mesh) {
        if let Some(shown) = shown.get_mut(mesh) {
            *shown = true;
        }
    }
    let count = shown.iter().filter(|shown| !**shown).count();
    let first = shown.iter().position(|shown| !shown).unwrap_or_default();
    notes.add_many("left out meshes that no node has", count, || format!("mesh {first}"));
}
