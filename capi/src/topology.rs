//! # Surfaces
//!
//! Topology, measures and comparison of triangle meshes; meshes of lattices, and generated ones.
//!
//! ```c
//! double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, area; // a square
//! uint32_t f[] = {0, 1, 2, 0, 2, 3};
//! size_t edges, genus;
//! cata_mesh_edges(4, v, 2, f, 0, NULL, NULL, &edges);
//! cata_mesh_genus(4, v, 2, f, &genus, NULL);
//! cata_mesh_measures(4, v, 2, f, &area, NULL, NULL, NULL, NULL, NULL);
//! printf("%zu edges, genus %zu, area %g\n", edges, genus, area); // 5 edges, genus 0, area 1
//! ```

use super::boundary::boundary;
use super::outputs::{fill_room, fill_slice};
use super::pointer::{mesh, optional_output, optional_slice_mut, output, put};
use super::status::cata_status;
use catamaran_geometry::mesh::{Components, Edges, Genus};

/// Finds the edges of a mesh, ascending.
///
/// - `room`: the number of edges that `edges` and `face_counts` have room for; CATA_ERR_SHAPE where
///   there are more. 3 n_faces is always enough.
/// - `edges`: 2 vertices for each edge, the lower first, written. NULL where not wanted.
/// - `face_counts`: for each edge the number of its faces, written: 1 at the boundary, more than 2
///   where the mesh is no manifold. NULL where not wanted.
/// - `count`: written: the number of edges.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_edges(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    room: usize,
    edges: *mut u32,
    face_counts: *mut u32,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `edges`, `2 *
        // room` elements; `face_counts`, `room` elements; `count`, one value).
        let (mesh, ends, face_counts, count) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                optional_slice_mut("edges", edges.cast::<[u32; 2]>(), room)?,
                optional_slice_mut("face_counts", face_counts, room)?,
                output("count", count)?,
            )
        };
        let found = Edges::new(&mesh);
        let counts: Vec<_> = (0..found.len()).map(|e| found.faces(e).len() as u32).collect();
        fill_room("edges", ends, found.ends())?;
        fill_room("edges", face_counts, &counts)?;
        *count = found.len();
        Ok(())
    })
}

/// Finds the connected components of a mesh, numbered from 0 by their lowest vertex: two faces with
/// a common vertex are in the same one.
///
/// - `of_vertices`: n_vertices elements, written: the component of each vertex, UINT32_MAX for
///   those that no face has. NULL where not wanted.
/// - `of_faces`: n_faces elements, written. NULL where not wanted.
/// - `count`: written: the number of components.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_components(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    of_vertices: *mut u32,
    of_faces: *mut u32,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face;
        // `of_vertices`, `n_vertices` elements; `of_faces`, `n_faces` elements; `count`, one
        // value).
        let (mesh, of_vertices, of_faces, count) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                optional_slice_mut("of_vertices", of_vertices, n_vertices)?,
                optional_slice_mut("of_faces", of_faces, n_faces)?,
                output("count", count)?,
            )
        };
        let found = Components::new(&mesh);
        fill_slice(of_vertices, found.of_vertices());
        fill_slice(of_faces, found.of_faces());
        *count = found.len();
        Ok(())
    })
}

/// Computes the genus of a manifold with its boundary loops closed by disks, summed over its
/// components: the number of handles. CATA_ERR_MESH where the mesh is no manifold.
///
/// - `orientable`: written: 1, or 0 where a component is not orientable: then `genus` is the number
///   of cross-caps, where a handle counts as two. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_genus(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    genus: *mut usize,
    orientable: *mut i32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `genus`, one
        // value; `orientable`, one value).
        let (mesh, genus, orientable) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                output("genus", genus)?,
                optional_output("orientable", orientable)?,
            )
        };
        let (found, is_orientable) = match mesh.genus(&Edges::new(&mesh))? {
            Genus::Orientable(handles) => (handles, 1),
            Genus::NonOrientable(caps) => (caps, 0),
        };
        *genus = found;
        put(orientable, is_orientable);
        Ok(())
    })
}

/// Finds the boundary loops of a mesh, with the mesh on their left where it is oriented.
/// CATA_ERR_MESH where there is a boundary and an edge of more than two faces.
///
/// - `room`: the number of vertices that `loops` has room for, and of loops that `lengths` has;
///   CATA_ERR_SHAPE where there are more.
/// - `loops`: the vertices of each loop in order, one loop after the other, written. NULL where not
///   wanted.
/// - `lengths`: the number of vertices of each loop, written. NULL where not wanted.
/// - `total`: written: the number of vertices of all loops, which is that of boundary edges.
/// - `count`: written: the number of loops.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_mesh_boundary_loops(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    room: usize,
    loops: *mut u32,
    lengths: *mut usize,
    total: *mut usize,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `loops`,
        // `room` elements; `lengths`, `room` elements; `total`, one value; `count`, one value).
        let (mesh, loops, lengths, total, count) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                optional_slice_mut("loops", loops, room)?,
                optional_slice_mut("lengths", lengths, room)?,
                output("total", total)?,
                output("count", count)?,
            )
        };
        let found = mesh.boundary_loops(&Edges::new(&mesh))?;
        let (all, sizes) = (found.concat(), found.iter().map(Vec::len).collect::<Vec<_>>());
        fill_room("vertices", loops, &all)?;
        fill_room("loops", lengths, &sizes)?;
        (*total, *count) = (all.len(), sizes.len());
        Ok(())
    })
}
