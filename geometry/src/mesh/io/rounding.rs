//! What single precision does to a mesh: some formats have coordinates of 32 bits.

use std::path::Path;

use super::super::TriMesh;
use super::super::measure::is_flat;
use super::super::vector::{Vector, add, bits, middle, sub};
use catamaran::base::{Error, Result, reserved};

/// Coordinates are relative to the middle of a mesh where they then are at least this many times
/// as accurate.
const GAIN: f64 = 4.0;

/// How a file in single precision rounds the vertices of a mesh. The default rounds nothing.
#[derive(Default)]
pub(super) struct Rounding {
    /// The point from which coordinates count before they are rounded.
    pub origin: Vector,
    /// Largest distance by which a vertex moves, and the vertex.
    moved: f64,
    vertex: usize,
    /// Number of vertices that meet another one, from which they were apart.
    met: usize,
}

impl Rounding {
    /// Returns how a mesh that is written to `path` is rounded if coordinates count from zero.
    ///
    /// # Errors
    /// [`Error::Io`] with the path for a coordinate that single precision can't store, and for
    /// faces that would have no area any more; [`Error::OutOfMemory`].
    pub fn from_zero(mesh: &TriMesh, path: &Path) -> Result<Self> {
        Self::around([0.0; 3], mesh).checked(mesh, path)
    }

    /// Returns how a mesh that is written to `path` is rounded if coordinates count from its
    /// middle, where this is more accurate, else from zero.
    ///
    /// # Errors
    /// As those of [`Rounding::from_zero`].
    pub fn from_middle(mesh: &TriMesh, path: &Path) -> Result<Self> {
        Self::centered(mesh).checked(mesh, path)
    }

    fn checked(self, mesh: &TriMesh, path: &Path) -> Result<Self> {
        self.check(mesh).map_err(|what| Error::file(path, what))?;
        let met = if self.moved > 0.0 { self.meetings(mesh)? } else { 0 };
        Ok(Self { met, ..self })
    }

    /// Returns the rounding of coordinates that count from `origin`.
    fn around(origin: Vector, mesh: &TriMesh) -> Self {
        let mut found = Self { origin, ..Self::default() };
        for (v, &p) in mesh.vertices().iter().enumerate() {
            let [x, y, z] = sub(found.stored(p), p);
            // Not by squares, which underflow.
            let moved = x.hypot(y).hypot(z);
            if moved > found.moved {
                (found.moved, found.vertex) = (moved, v);
            }
        }
        found
    }

    /// Returns the rounding of coordinates that count from the middle of the mesh, where this is
    /// more accurate, else from zero.
    fn centered(mesh: &TriMesh) -> Self {
        let plain = Self::around([0.0; 3], mesh);
        let Some([low, high]) = mesh.bounding_box().filter(|_| plain.moved > 0.0) else {
            return plain;
        };
        // A point that readers with single precision have, too.
        let origin = middle(low, high).map(|x| f64::from(x as f32));
        let centered = Self::around(origin, mesh);
        if GAIN * centered.moved <= plain.moved { centered } else { plain }
    }

    /// Returns the coordinates of a point in the file.
    pub fn single(&self, p: Vector) -> [f32; 3] {
        sub(p, self.origin).map(|x| x as f32)
    }

    /// Returns the place of a point as readers find it.
    fn stored(&self, p: Vector) -> Vector {
        add(self.single(p).map(f64::from), self.origin)
    }

    /// Returns a text about a coordinate that is not a number of the file, or about faces that lose
    /// their area.
    fn check(&self, mesh: &TriMesh) -> std::result::Result<(), String> {
        let infinite = |p: &&Vector| self.single(**p).iter().any(|x| !x.is_finite());
        if let Some(p) = mesh.vertices().iter().find(infinite) {
            let far = p.iter().fold(0.0, |far: f64, x| if x.abs() > far.abs() { *x } else { far });
            return Err(format!("{far:e} is beyond single precision"));
        }
        let vanishes = |face: &[u32; 3]| {
            let corners = mesh.corners_of(*face);
            let stored = corners.map(|p| self.single(p).map(f64::from));
            let joined = |i: usize, j: usize| corners[i] != corners[j] && stored[i] == stored[j];
            joined(0, 1) || joined(1, 2) || joined(2, 0) || (is_flat(stored) && !is_flat(corners))
        };
        let faces = mesh.faces();
        let Some(first) = faces.iter().position(vanishes) else { return Ok(()) };
        let count = faces[first..].iter().filter(|face| vanishes(face)).count();
        Err(format!(
            "{count} of {} faces vanish in the single precision of this format, the first is face \
             {first}; .ply, .obj, .off and STL as text (`catamaran mesh --text`) keep every digit",
            faces.len()
        ))
    }

    /// Returns the number of vertices that meet another one, from which they were apart.
    fn meetings(&self, mesh: &TriMesh) -> Result<usize> {
        let mut keys = reserved(mesh.vertices().len())?;
        keys.extend(
            mesh.vertices().iter().map(|&p| (bits(self.single(p).map(f64::from)), bits(p))),
        );
        keys.sort_unstable();
        Ok(keys.windows(2).filter(|pair| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1).count())
    }

    /// Adds notes about what rounding changes.
    pub fn note(&self, mesh: &TriMesh, notes: &mut Vec<String>) {
        if self.moved > 0.0 {
            let side = mesh
                .bounding_box()
                .map_or(0.0, |[low, high]| sub(high, low).into_iter().fold(0.0, f64::max));
            let (moved, v) = (self.moved, self.vertex);
            let part = moved / side;
            let part = match part.is_finite() {
                true => format!(", {part:.1e} of the longest side of the mesh"),
                // All vertices are at one point.
                false => String::new(),
            };
            notes.push(format!(
                "rounded coordinates to single precision: vertices move by up to {moved:.1e} \
                 (vertex {v}){part}"
            ));
        }
        if self.met > 0 {
            let met = self.met;
            notes.push(format!("{met} vertices meet another one, as single precision rounds them"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::families;
    use super::*;

    type Way = fn(&TriMesh, &Path) -> Result<Rounding>;

    const STL: Way = Rounding::from_zero;
    const GLB: Way = Rounding::from_middle;

    fn rounding(way: Way, mesh: &TriMesh) -> Result<Rounding> {
        way(mesh, Path::new("a"))
    }

    fn moved(mesh: TriMesh, scale: f64, by: Vector) -> TriMesh {
        let (points, faces) = mesh.into_parts();
        let place = |p: Vector| add(p.map(|x| scale * x), by);
        TriMesh::new(points.into_iter().map(place).collect(), faces).unwrap()
    }

    #[test]
    fn what_single_precision_has_is_not_rounded() {
        let grid = moved(families::grid(4, 4).unwrap(), 1.0, [4096.0, 0.0, -7.5]);
        for way in [STL, GLB] {
            let found = rounding(way, &grid).unwrap();
            assert_eq!((found.moved, found.met, found.origin), (0.0, 0, [0.0; 3]));
        }
    }

    #[test]
    fn the_largest_displacement_is_that_of_the_farthest_vertex() {
        let (points, faces) = families::grid(1, 1).unwrap().into_parts();
        let mut points = points;
        // Between 2^20 and 2^20 + 1/8, which are neighbours in single precision.
        points[2] = [f64::from(1 << 20) + 0.0625, 0.0, 0.0];
        let mesh = TriMesh::new(points, faces).unwrap();
        let found = rounding(STL, &mesh).unwrap();
        assert_eq!((found.moved, found.vertex), (0.0625, 2));
        let mut notes = Vec::new();
        found.note(&mesh, &mut notes);
        let said = "rounded coordinates to single precision: vertices move by up to 6.2e-2 \
                    (vertex 2), 6.0e-8 of the longest side of the mesh";
        assert_eq!(notes, [said]);
        // A mesh without a longest side.
        let mesh = TriMesh::new(vec![[0.1, 0.0, 0.0]; 3], vec![[0, 1, 2]]).unwrap();
        let mut notes = Vec::new();
        Rounding::around([0.0; 3], &mesh).note(&mesh, &mut notes);
        let said = "rounded coordinates to single precision: vertices move by up to 1.5e-9 \
                    (vertex 0)";
        assert_eq!(notes, [said]);
    }

    #[test]
    fn coordinates_count_from_the_middle_where_that_is_more_accurate() {
        let sphere = families::icosphere(2).unwrap();
        let near = rounding(GLB, &sphere).unwrap();
        assert!(near.origin == [0.0; 3] && near.moved < 1e-7);
        let far = moved(sphere, 1e-3, [1e6, -4e6, 5.0]);
        let found = rounding(GLB, &far).unwrap();
        assert_eq!(found.origin, [1e6, -4e6, 5.0]);
        // The sum of origin and coordinate is rounded in double precision.
        assert!(found.moved < 1e-9, "{}", found.moved);
        let refused = rounding(STL, &far).err().unwrap().to_string();
        assert!(refused.starts_with("a: 320 of 320 faces vanish"), "{refused}");
    }

    #[test]
    fn vertices_that_meet_are_counted_and_faces_that_were_flat_are_not() {
        let near = f64::from(1.0f32) + 1e-12;
        let points = vec![
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [near, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 2.0, 0.1],
        ];
        // The last face had no area before.
        let faces = vec![[0, 1, 2], [3, 4, 5], [0, 1, 4]];
        let found = rounding(STL, &TriMesh::new(points, faces).unwrap()).unwrap();
        assert_eq!(found.met, 1);
    }
}
