//! # Regions
//!
//! Curves drawn into a mesh, so that they run along its edges; the regions that they enclose, which
//! are sets of faces (1 for a face inside, 0 for any other), and their algebra; cuts and parts.
//!
//! ```c
//! double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, area; // a square
//! uint32_t f[] = {0, 1, 3, 1, 2, 3}, along[] = {1, 3};
//! uint8_t inside[2];
//! cata_region_enclosed(4, v, 2, f, 1, along, CATA_SIDE_SMALL, 0, NULL, inside);
//! cata_region_area(4, v, 2, f, inside, &area);
//! printf("%d %d, area %g\n", inside[0], inside[1], area); // 1 0, area 0.5
//! ```

use super::boundary::boundary;
use super::outputs::{copy_wanted, fill_room, tell};
use super::pointer::{
    free, hand_over, known, mask, mesh, optional_slice_mut, output, slice, slice_mut,
};
use super::status::{Failure, cata_status};
use catamaran_geometry::curve::{Region, Side, cut};
use catamaran_geometry::mesh::Part;

/// `side`: that of smaller area.
pub const CATA_SIDE_SMALL: i32 = 0;
/// `side`: that of larger area.
pub const CATA_SIDE_LARGE: i32 = 1;
/// `side`: the pieces with the seeds.
pub const CATA_SIDE_SEEDS: i32 = 2;

/// `operation`: the faces in one of two regions, or both.
pub const CATA_REGION_UNION: i32 = 0;
/// `operation`: the faces in both.
pub const CATA_REGION_INTERSECTION: i32 = 1;
/// `operation`: the faces in the first one alone.
pub const CATA_REGION_DIFFERENCE: i32 = 2;
/// `operation`: the faces in one of them alone.
pub const CATA_REGION_SYMMETRIC_DIFFERENCE: i32 = 3;

/// A part of a mesh, or the whole, cut open; and where it comes from. Constant.
pub struct cata_part {
    part: Part,
}

/// Finds the region that curves along edges enclose. With a side by area, each curve leads from one
/// side to the other, and one side is taken on each part of the surface with curves; a ring, too,
/// is a region. CATA_ERR_MESH: the message names an edge with the same region on both sides.
///
/// - `count`, `along`: edges, 2 vertices each.
/// - `side`: CATA_SIDE_*; of equal areas, the side with the lowest face is the small one.
/// - `n_seeds`, `seeds`: with CATA_SIDE_SEEDS: vertices on no curve. Otherwise ignored.
/// - `inside`: n_faces elements, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_region_enclosed(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    count: usize,
    along: *const u32,
    side: i32,
    n_seeds: usize,
    seeds: *const u32,
    inside: *mut u8,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `along`, `2 *
        // count` elements).
        let (mesh, along) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("along", along.cast::<[u32; 2]>(), count)?,
            )
        };
        let side = match side {
            CATA_SIDE_SMALL => Side::Small,
            CATA_SIDE_LARGE => Side::Large,
            // SAFETY: clause `memory` (`seeds`, `n_seeds` elements).
            CATA_SIDE_SEEDS => Side::Seeds(unsafe { slice("seeds", seeds, n_seeds) }?.to_vec()),
            other => return Err(Failure::argument("side", "a CATA_SIDE_* value", other)),
        };
        // SAFETY: clause `memory` (`inside`, `n_faces` elements).
        let inside = unsafe { slice_mut("inside", inside, n_faces) }?;
        write(inside, &Region::enclosed(&mesh, along, &side)?);
        Ok(())
    })
}

/// Combines two regions of the same mesh: `operation`, CATA_REGION_*; n_faces elements each, the
/// result written. The difference from a region of all faces is the complement.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_region_combine(
    operation: i32,
    n_faces: usize,
    first: *const u8,
    second: *const u8,
    result: *mut u8,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`result`, `n_faces` elements), clause `passed on` (`region`).
        let (first, second, result) = unsafe {
            (
                region("first", first, n_faces)?,
                region("second", second, n_faces)?,
                slice_mut("result", result, n_faces)?,
            )
        };
        let found = match operation {
            CATA_REGION_UNION => first.union(&second)?,
            CATA_REGION_INTERSECTION => first.intersection(&second)?,
            CATA_REGION_DIFFERENCE => first.difference(&second)?,
            CATA_REGION_SYMMETRIC_DIFFERENCE => first.symmetric_difference(&second)?,
            other => return Err(Failure::argument("operation", "a CATA_REGION_* value", other)),
        };
        write(result, &found);
        Ok(())
    })
}

/// Computes the area of a region: `inside`, n_faces elements; `area`, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_region_area(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    inside: *const u8,
    area: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `area`, one
        // value), clause `passed on` (`region`).
        let (mesh, region, area) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                region("inside", inside, n_faces)?,
                output("area", area)?,
            )
        };
        *area = region.area(&mesh)?;
        Ok(())
    })
}

/// Finds the edges between faces inside of a region and others.
///
/// - `inside`: n_faces elements.
/// - `room`: the number of edges that `edges` has room for; CATA_ERR_SHAPE where there are more.
/// - `edges`: 2 vertices for each edge, the lower first, written; ascending. NULL where not wanted.
/// - `count`: written: the number of edges.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_region_boundary(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    inside: *const u8,
    room: usize,
    edges: *mut u32,
    count: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `edges`, `2 *
        // room` elements; `count`, one value), clause `passed on` (`region`).
        let (mesh, region, edges, count) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                region("inside", inside, n_faces)?,
                optional_slice_mut("edges", edges.cast::<[u32; 2]>(), room)?,
                output("count", count)?,
            )
        };
        let found = region.boundary(&mesh)?;
        fill_room("edges", edges, &found)?;
        *count = found.len();
        Ok(())
    })
}

/// Makes a mesh of the faces of a region, with the vertices that they use: `inside`, n_faces
/// elements; `part`, one pointer, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_region_part(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    inside: *const u8,
    part: *mut *mut cata_part,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `part`, one
        // value), clause `passed on` (`region`).
        let (mesh, region, place) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                region("inside", inside, n_faces)?,
                output("part", part)?,
            )
        };
        hand_over(place, cata_part { part: region.part(&mesh)? });
        Ok(())
    })
}

/// Cuts a mesh open along edges: a vertex whose faces they separate becomes one for each part.
/// Faces keep their order, and new vertices follow those of the mesh.
///
/// - `count`, `along`: edges, 2 vertices each.
/// - `part`: one pointer, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_region_cut(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    count: usize,
    along: *const u32,
    part: *mut *mut cata_part,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `along`, `2 *
        // count` elements; `part`, one value).
        let (mesh, along, place) = unsafe {
            (
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice("along", along.cast::<[u32; 2]>(), count)?,
                output("part", part)?,
            )
        };
        hand_over(place, cata_part { part: cut(&mesh, along)? });
        Ok(())
    })
}

/// Gets the numbers of vertices and faces of a part. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_part_size(
    part: *const cata_part,
    n_vertices: *mut usize,
    n_faces: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n_vertices`, one value; `n_faces`, one value), clause `handles`
        // (`part`).
        unsafe {
            let own = &known("part", part)?.part;
            tell!(n_vertices: own.vertices.len(), n_faces: own.faces.len());
        }
        Ok(())
    })
}

/// Gets a part; NULL where not wanted.
///
/// - `vertices`, `faces`: of the part, as many as cata_part_size tells, written.
/// - `of_vertices`: for each vertex its number in the mesh, written.
/// - `of_faces`: for each face its number in the mesh, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_part_get(
    part: *const cata_part,
    vertices: *mut f64,
    faces: *mut u32,
    of_vertices: *mut u32,
    of_faces: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`vertices` and `faces`, 3 elements for each of the part's;
        // `of_vertices` and `of_faces`, one), clause `handles` (`part`).
        unsafe {
            let own = &known("part", part)?.part;
            copy_wanted! {
                vertices: own.mesh.vertices().as_flattened(),
                faces: own.mesh.faces().as_flattened(),
                of_vertices: &own.vertices,
                of_faces: &own.faces,
            }
        }
        Ok(())
    })
}

/// Frees a part.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_part_free(part: *mut cata_part) {
    // SAFETY: clause `handles` (`part`).
    unsafe { free(part) };
}

/// Returns a region of the caller.
///
/// # Safety
/// The elements can be read, and no thread writes them.
unsafe fn region(what: &'static str, inside: *const u8, faces: usize) -> Result<Region, Failure> {
    // SAFETY: clause `passed on` (`mask`).
    unsafe { mask(what, inside, faces) }.map(Region::new)
}

fn write(place: &mut [u8], region: &Region) {
    place.iter_mut().zip(region.mask()).for_each(|(place, &inside)| *place = u8::from(inside));
}
