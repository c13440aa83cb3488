use super::super::TriMesh;
use super::bent::Bend;
use super::draft::Draft;
use super::voxels;
use catamaran::base::{Error, Result, at_least};

/// A joint of a limb on the side of positive x; its mirror image is the joint of the limb on the
/// other side, unless the joint is `one_sided`.
struct Joint {
    bend: Bend,
    one_sided: bool,
}

/// The joints from the ends of the limbs to the trunk, so that each joint turns what earlier joints
/// bent.
const JOINTS: [Joint; 4] = [
    joint([4.0, 0.0, 3.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.3, false),
    joint([1.6, 0.0, 3.5], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], 0.9, false),
    joint([0.0, 0.0, -2.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0], 1.2, false),
    joint([0.0, 0.0, -0.4], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], 0.8, true),
];

const fn joint(
    at: [f64; 3],
    along: [f64; 3],
    towards: [f64; 3],
    angle: f64,
    one_sided: bool,
) -> Joint {
    Joint { bend: Bend { at, along, towards, angle, length: 1.2 }, one_sided }
}

/// Generates a human figure, 13 tall along z, facing y, its arms 13 wide along x. `pose` from 0 to
/// 1 bends the elbows, lowers the arms, bends the knees and lifts a leg. All poses have the same
/// faces, and are nearly isometric to each other. F = 300 cells^2, V = F / 2 + 2, genus 0.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let (standing, bent) = (families::figure(1, 0.0)?, families::figure(1, 1.0)?);
/// assert_eq!(standing.faces().len(), 300);
/// assert_eq!(standing.faces(), bent.faces());
/// assert_ne!(standing.vertices(), bent.vertices());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] without cells, for too many vertices, or for a pose outside of 0 to 1.
pub fn figure(cells: usize, pose: f64) -> Result<TriMesh> {
    at_least("cells", cells, 1)?;
    if !(0.0..=1.0).contains(&pose) {
        return Err(Error::Argument { what: "pose", why: format!("must be in 0..=1, is {pose}") });
    }
    let faces = cells.checked_mul(cells).and_then(|n| n.checked_mul(300));
    let draft = Draft::with_counts(faces.map(|n| n / 2 + 2), faces)?;
    // Columns of cubes: x, and the range of z.
    let mut columns = vec![(-1, -5..5), (0, 0..6), (1, -5..5)];
    columns.extend((2..=6).flat_map(|x| [(x, 3..4), (-x, 3..4)]));
    columns.extend((-1..=1).map(|x| (x, 6..8)));
    let cubes: Vec<_> = columns.into_iter().flat_map(|(x, z)| z.map(move |z| [x, 0, z])).collect();
    let (mut vertices, faces) = voxels::surface(&cubes, cells as i32, draft)?.into_parts();
    for p in &mut vertices {
        *p = posed([p[0] - 0.5, p[1] - 0.5, p[2]], pose);
    }
    TriMesh::new(vertices, faces)
}

fn posed(p: [f64; 3], pose: f64) -> [f64; 3] {
    let side = p[0].signum();
    // The limb on the other side is the mirror image.
    let mut q = [p[0].abs(), p[1], p[2]];
    for Joint { bend, one_sided } in &JOINTS {
        if *one_sided && side < 0.0 {
            continue;
        }
        q = Bend { angle: pose * bend.angle, ..*bend }.apply(q);
    }
    [side * q[0], q[1], q[2]]
}
