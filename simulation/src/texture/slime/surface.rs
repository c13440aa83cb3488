use catamaran::base::{Error, Result, Sets, reserved};
use catamaran_geometry::mesh::io::Attribute;
use catamaran_geometry::mesh::vector::{Vector, cross, dot, norm, scale, sub, unit};
use catamaran_geometry::mesh::{Edges, TriMesh, families};

/// The absence of a triangle, across a boundary edge.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// A bit of [`Surface::across`] that is set where the triangles disagree about which side is
/// outside, so that a hop includes a reflection.
pub const ACROSS_FLIP: u32 = 4;

/// The index of the first hop in a record.
pub const HOPS: usize = 9;
/// The index of the map to UV in a record.
pub const UV: usize = 21;
/// The length of a record.
pub const RECORD: usize = 28;

/// Largest number of triangles for [`Surface::across`].
const MOST_TRIANGLES: usize = (1 << 29) - 1;

/// A surface on which agents walk: flat records of triangles, for any device.
///
/// Lengths are in units of the square root of the area of the mesh.
///
/// ```
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::slime::{Surface, atlas};
///
/// let mesh = families::icosphere(1)?;
/// let surface = Surface::of_faces(&mesh, atlas(&mesh, 128)?)?;
/// assert_eq!(surface.len(), 80);
/// assert!((surface.areas().iter().sum::<f64>() - 1.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Surface {
    records: Vec<[f32; RECORD]>,
    across: Vec<[u32; 3]>,
    frames: Vec<[f32; 12]>,
    corners: Vec<[[f64; 2]; 3]>,
    uv: Vec<[[f64; 2]; 3]>,
    areas: Vec<f64>,
    charts: Vec<u32>,
    flipped: Vec<u32>,
    tile: bool,
}

/// Number of cells along a side of a tile: the smallest power of two for which no two edges have
/// the same ends.
const TILE_CELLS: usize = 4;

impl Surface {
    /// Creates a surface from a mesh with texture coordinates, in `[0, 1]` (up to 1e-6).
    ///
    /// ```
    /// use catamaran_geometry::mesh::{families, io::Attribute};
    /// use catamaran_simulation::texture::slime::Surface;
    ///
    /// // A square that is its own texture.
    /// let square = families::grid(2, 2)?;
    /// let values = square.vertices().iter().map(|p| [p[0], p[1]]).collect();
    /// let surface = Surface::new(&square, &Attribute { values, corners: None })?;
    /// assert_eq!(surface.len(), 8);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] names an element on which agents can't walk or deposit: an edge of three
    /// faces or more, a face without area, without coordinates, with coordinates outside of
    /// `[0, 1]` or without area in the texture, and a mesh without faces; [`Error::Shape`] or
    /// [`Error::Argument`] when coordinates do not fit the mesh; [`Error::OutOfMemory`].
    pub fn new(mesh: &TriMesh, uv: &Attribute<2>) -> Result<Self> {
        let count = mesh.faces().len();
        match &uv.corners {
            Some(corners) => Error::check_shape("uv", (count, 3), (corners.len(), 3))?,
            None => {
                Error::check_shape("uv", (mesh.vertices().len(), 2), (uv.values.len(), 2))?;
            }
        }
        let mut of_faces = reserved(count)?;
        for f in 0..count {
            of_faces.push(uv.of_face(mesh, f).ok_or_else(|| Error::Mesh {
                what: "has no texture coordinates".into(),
                element: format!("face {f}"),
            })?);
        }
        Self::of_faces(mesh, of_faces)
    }

    /// Creates a surface from a mesh with texture coordinates of the corners of its faces.
    ///
    /// # Errors
    /// As [`Surface::new`].
    pub fn of_faces(mesh: &TriMesh, mut uv: Vec<[[f64; 2]; 3]>) -> Result<Self> {
        let count = mesh.faces().len();
        Error::check_shape("uv", (count, 3), (uv.len(), 3))?;
        let edges = checked(mesh)?;
        for (f, corners) in uv.iter_mut().enumerate() {
            check_uv(f, corners)?;
        }
        let factor = 1.0 / mesh.area().sqrt();
        let mut places = reserved(count)?;
        for &face in mesh.faces() {
            places.push(face.map(|v| scale(mesh.vertices()[v as usize], factor)));
        }
        let total = mesh.area();
        let areas = mesh.face_areas().into_iter().map(|a| a / total).collect();
        Self::joined(mesh.faces(), &edges, &places, areas, uv)
    }

    /// Creates the unit square with opposite sides joined, in its own texture: a texture that grows
    /// on it is a tile, and repeats without a seam. Its faces are those of [`Surface::tile_mesh`].
    ///
    /// The tile is flat, so that a walk is a straight line. [`project`](super::project) does not
    /// apply, because there is no such surface in space.
    ///
    /// ```
    /// use catamaran_simulation::texture::slime::{NO_TRIANGLE, Surface};
    ///
    /// let tile = Surface::tile()?;
    /// assert!(!tile.across().as_flattened().contains(&NO_TRIANGLE));
    /// assert_eq!(tile.len(), Surface::tile_mesh()?.faces().len());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn tile() -> Result<Self> {
        let (vertices, faces) = Self::tile_mesh()?.into_parts();
        let wrapped = |v: u32| {
            let [i, j, _] =
                vertices[v as usize].map(|x| (x * TILE_CELLS as f64).round() as usize % TILE_CELLS);
            (i + TILE_CELLS * j) as u32
        };
        let joined: Vec<_> = faces.iter().map(|face| face.map(wrapped)).collect();
        let edges = Edges::new(&TriMesh::new(vec![[0.0; 3]; TILE_CELLS.pow(2)], joined.clone())?);
        let places: Vec<_> = faces.iter().map(|face| face.map(|v| vertices[v as usize])).collect();
        let areas = vec![1.0 / faces.len() as f64; faces.len()];
        let uv = places.iter().map(|corners| corners.map(|[x, y, _]| [x, y])).collect();
        Ok(Self { tile: true, ..Self::joined(&joined, &edges, &places, areas, uv)? })
    }

    /// Creates the square on which a tile is shown; x and y are its texture coordinates.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn tile_mesh() -> Result<TriMesh> {
        families::grid(TILE_CELLS, TILE_CELLS)
    }

    /// Returns whether the surface is that of [`Surface::tile`].
    pub fn is_tile(&self) -> bool {
        self.tile
    }

    /// Creates a surface of faces with these corners, joined across edges.
    fn joined(
        faces: &[[u32; 3]],
        edges: &Edges,
        places: &[[Vector; 3]],
        areas: Vec<f64>,
        uv: Vec<[[f64; 2]; 3]>,
    ) -> Result<Self> {
        let count = faces.len();
        let mut planes = reserved(count)?;
        planes.extend(places.iter().map(|&corners| Plane::new(corners)));
        let mut records = reserved(count)?;
        let mut across = reserved(count)?;
        for (f, plane) in planes.iter().enumerate() {
            let mut record = [0.0; RECORD];
            let mut beyond = [NO_TRIANGLE; 3];
            for k in 0..3 {
                plane.write_edge(k, &mut record);
                let corner = (3 * f + k) as u32;
                let edge = edges.of_corners()[corner as usize] as usize;
                let others = edges.corners().row(edge);
                let Some(&other) = others.iter().find(|&&c| c != corner) else { continue };
                let (g, j) = (other as usize / 3, other as usize % 3);
                let flip = faces[f][k] == faces[g][j];
                plane.write_hop(k, &planes[g], j, flip, &mut record);
                let flag = if flip { ACROSS_FLIP } else { 0 };
                beyond[k] = ((g as u32) << 3) | flag | j as u32;
            }
            plane.write_uv(&uv[f], &mut record);
            records.push(record);
            across.push(beyond);
        }
        let charts = charts(edges, faces, &uv);
        let flipped = flipped(&charts, &uv);
        Ok(Self {
            records,
            across,
            frames: planes.iter().map(Plane::in_space).collect(),
            corners: planes.iter().map(|p| p.corners).collect(),
            uv,
            areas,
            charts,
            flipped,
            tile: false,
        })
    }

    /// Returns the number of triangles.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Returns false, because a surface always has triangles.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Returns a record of 28 numbers for each triangle:
    /// - 3 k + (0, 1, 2), k = 0, 1, 2: (a, b, c) of edge k, from corner k to the next one;
    ///   `a x + b y + c` is the distance of (x, y) from it, (a, b) its inward unit normal.
    /// - 9 + 4 k + (0, 1, 2, 3): (p, q, x0, y0) of the hop over edge k: (x, y) is
    ///   `(p x - q y + x0, q x + p y + y0)` in the frame of the triangle across; with
    ///   [`ACROSS_FLIP`], `(p x + q y + x0, q x - p y + y0)`.
    /// - 21 + (0, 1, 2): u is their sum times (1, x, y); 24 + (0, 1, 2): v likewise.
    /// - 27: zero.
    pub fn records(&self) -> &[[f32; RECORD]] {
        &self.records
    }

    /// Returns for each triangle and edge k what is across: 8 g + j, g the triangle and j its
    /// edge there, plus [`ACROSS_FLIP`]; [`NO_TRIANGLE`] on the boundary.
    pub fn across(&self) -> &[[u32; 3]] {
        &self.across
    }

    /// Returns the frame of each triangle in space: its origin, the x axis, the y axis, the normal,
    /// of unit length. Only [`project`](super::project) needs them.
    pub fn frames(&self) -> &[[f32; 12]] {
        &self.frames
    }

    /// Returns the corners of each triangle in its frame.
    pub fn corners(&self) -> &[[[f64; 2]; 3]] {
        &self.corners
    }

    /// Returns the texture coordinates of the corners of each triangle.
    pub fn uv(&self) -> &[[[f64; 2]; 3]] {
        &self.uv
    }

    /// Returns the areas of the triangles; their sum is 1.
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// Returns for each triangle the lowest triangle of its chart: triangles that are connected
    /// in the texture are of one chart.
    pub fn charts(&self) -> &[u32] {
        &self.charts
    }

    /// Returns the triangles that are mirrored in the texture while most of their chart is not: the
    /// texture is folded there, and its texels belong to several triangles.
    pub fn flipped(&self) -> &[u32] {
        &self.flipped
    }

    /// Returns the memory of the surface, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.records[..])
            + size_of_val(&self.across[..])
            + size_of_val(&self.frames[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.uv[..])
            + size_of_val(&self.areas[..])
            + size_of_val(&self.charts[..])
    }

    /// Returns a hash of the surface, which identifies it in files.
    pub(super) fn fingerprint(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |x: u32| {
            hash = (hash ^ u64::from(x)).wrapping_mul(0x0000_0100_0000_01b3);
        };
        self.records.as_flattened().iter().for_each(|x| add(x.to_bits()));
        self.across.as_flattened().iter().for_each(|&x| add(x));
        hash
    }
}

/// Returns the edges of a mesh, or an error unless agents can walk on it.
fn checked(mesh: &TriMesh) -> Result<Edges> {
    let refused = |what: &str, element: String| Err(Error::Mesh { what: what.into(), element });
    if mesh.faces().is_empty() {
        return refused("has no faces", "mesh".into());
    }
    if mesh.faces().len() > MOST_TRIANGLES {
        return refused("has more than 2^29 - 1 faces", "mesh".into());
    }
    if let Some(f) = mesh.faces_without_area().first() {
        return refused("has no area", format!("face {f}"));
    }
    if !mesh.area().is_normal() {
        return refused("the area is out of range", "mesh".into());
    }
    let edges = Edges::new(mesh);
    edges.require_manifold()?;
    Ok(edges)
}

/// Returns texture coordinates translated and uniformly scaled into `[0, 1]`; unchanged when they
/// are already in this range (up to 1e-6). The coordinates of repeating textures may exceed it.
///
/// ```
/// use catamaran_geometry::mesh::io::Attribute;
/// use catamaran_simulation::texture::slime::fitted;
///
/// let uv = Attribute { values: vec![[-1.0, 0.0], [3.0, 2.0]], corners: None };
/// assert_eq!(fitted(&uv).values, [[0.0, 0.0], [1.0, 0.5]]);
/// ```
pub fn fitted(uv: &Attribute<2>) -> Attribute<2> {
    let ends = |axis: usize| {
        let all = uv.values.iter().map(|p| p[axis]);
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let [u, v] = [ends(0), ends(1)];
    let is_inside = |(low, high): (f64, f64)| low >= -SLACK && high <= 1.0 + SLACK;
    if is_inside(u) && is_inside(v) {
        return uv.clone();
    }
    let size = (u.1 - u.0).max(v.1 - v.0).max(1.0);
    let moved = |p: &[f64; 2]| [(p[0] - u.0) / size, (p[1] - v.0) / size];
    Attribute { values: uv.values.iter().map(moved).collect(), corners: uv.corners.clone() }
}

/// Texture coordinates may exceed `[0, 1]` by this, because files round them.
const SLACK: f64 = 1e-6;

fn check_uv(f: usize, corners: &mut [[f64; 2]; 3]) -> Result<()> {
    let refused = |what: String| Err(Error::Mesh { what, element: format!("face {f}") });
    for x in corners.as_flattened_mut() {
        if !(-SLACK..=1.0 + SLACK).contains(x) {
            return refused(format!("texture coordinates must be from 0 to 1, one is {x}"));
        }
        *x = x.clamp(0.0, 1.0);
    }
    let [a, b, c] = *corners;
    let longest =
        [(a, b), (b, c), (c, a)].map(|(p, q)| (q[0] - p[0]).hypot(q[1] - p[1])).into_iter();
    let longest = longest.fold(0.0, f64::max);
    if doubled_area(corners).abs() <= 1e-9 * longest * longest {
        return refused("has no area in the texture".into());
    }
    Ok(())
}

/// Returns twice the area of a triangle of the plane, negative when it is clockwise.
pub(super) fn doubled_area(&[a, b, c]: &[[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Joins triangles across edges at which their texture coordinates agree.
fn charts(edges: &Edges, faces: &[[u32; 3]], uv: &[[[f64; 2]; 3]]) -> Vec<u32> {
    let mut sets = Sets::new(uv.len());
    let ends = |corner: u32| {
        let (f, k) = (corner as usize / 3, corner as usize % 3);
        let mut ends = [k, (k + 1) % 3].map(|k| (faces[f][k], uv[f][k]));
        ends.sort_by_key(|end| end.0);
        ends
    };
    for row in edges.corners().rows() {
        if let &[a, b] = row
            && ends(a) == ends(b)
        {
            sets.join(a / 3, b / 3);
        }
    }
    (0..uv.len() as u32).map(|f| sets.find(f)).collect()
}

fn flipped(charts: &[u32], uv: &[[[f64; 2]; 3]]) -> Vec<u32> {
    let mut balance = vec![0_i64; uv.len()];
    let sign = |f: usize| if doubled_area(&uv[f]) > 0.0 { 1 } else { -1 };
    for (f, &chart) in charts.iter().enumerate() {
        balance[chart as usize] += sign(f);
    }
    let folded = |f: &u32| balance[charts[*f as usize] as usize] * sign(*f as usize) < 0;
    (0..uv.len() as u32).filter(folded).collect()
}

/// A triangle in its plane.
struct Plane {
    origin: Vector,
    axes: [Vector; 3],
    corners: [[f64; 2]; 3],
}

impl Plane {
    fn new([a, b, c]: [Vector; 3]) -> Self {
        let (ab, ac) = (sub(b, a), sub(c, a));
        let x = unit(ab);
        let normal = unit(cross(ab, ac));
        let y = cross(normal, x);
        Self {
            origin: a,
            axes: [x, y, normal],
            corners: [[0.0; 2], [norm(ab), 0.0], [dot(ac, x), dot(ac, y)]],
        }
    }

    /// Returns the unit vector along edge k, and its inward normal.
    fn edge(&self, k: usize) -> [[f64; 2]; 2] {
        let (a, b) = (self.corners[k], self.corners[(k + 1) % 3]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0].hypot(d[1]);
        let along = d.map(|x| x / length);
        [along, [-along[1], along[0]]]
    }

    fn write_edge(&self, k: usize, record: &mut [f32; RECORD]) {
        let [_, n] = self.edge(k);
        let a = self.corners[k];
        let c = -(n[0] * a[0] + n[1] * a[1]);
        record[3 * k..3 * k + 3].copy_from_slice(&[n[0], n[1], c].map(|x| x as f32));
    }

    /// Writes the hop across edge k to edge j of the other plane.
    fn write_hop(&self, k: usize, other: &Plane, j: usize, flip: bool, record: &mut [f32; RECORD]) {
        let [along, inward] = self.edge(k);
        let [other_along, other_inward] = other.edge(j);
        let (sign, start) = if flip { (1.0, j) } else { (-1.0, (j + 1) % 3) };
        // The matrix that maps `along` to its counterpart, and the outward normal to the inward
        // normal there.
        let entry = |row: usize, column: usize| {
            sign * other_along[row] * along[column] - other_inward[row] * inward[column]
        };
        let (p, q) = (entry(0, 0), entry(1, 0));
        let (a, b) = (self.corners[k], other.corners[start]);
        let moved = |row: usize| b[row] - entry(row, 0) * a[0] - entry(row, 1) * a[1];
        record[HOPS + 4 * k..HOPS + 4 * k + 4]
            .copy_from_slice(&[p, q, moved(0), moved(1)].map(|x| x as f32));
    }

    fn write_uv(&self, uv: &[[f64; 2]; 3], record: &mut [f32; RECORD]) {
        let [_, [length, _], [x, y]] = self.corners;
        for axis in 0..2 {
            let [a, b, c] = uv.map(|p| p[axis]);
            let by_x = (b - a) / length;
            let by_y = (c - a - by_x * x) / y;
            record[UV + 3 * axis..UV + 3 * axis + 3]
                .copy_from_slice(&[a, by_x, by_y].map(|x| x as f32));
        }
    }

    fn in_space(&self) -> [f32; 12] {
        let [x, y, normal] = self.axes;
        let mut all = [0.0; 12];
        for (to, from) in all.iter_mut().zip([self.origin, x, y, normal].as_flattened()) {
            *to = *from as f32;
        }
        all
    }
}
