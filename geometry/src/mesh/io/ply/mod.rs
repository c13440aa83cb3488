//! Stanford PLY (Turk 1994): ASCII, and binary in both byte orders.

mod element;
mod encoding;
mod header;
mod rows;
mod write;

use self::element::{COLOR, Element, NORMAL, Name, UV};
use self::header::Header;
use self::rows::{Block, Rows};
use super::super::has_corner_twice;
use super::attributes::{Attribute, MeshFile};
use super::draft::{Checked, Draft, roomy};
use super::notes::Notes;
use super::polygon::fan;
use super::stored::{NO_INDEX, index};
use catamaran::base::{Result, push};
use catamaran::io::Source;

pub use self::encoding::PlyEncoding;
pub(super) use self::write::write;

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let mut reader = Reader::default();
    let header = Header::read(source, &mut reader.draft.notes)?;
    let mut block = Block::default();
    for element in &header.elements {
        let mut rows = Rows::new(source, &mut block, header.encoding, element);
        let read = match element.name.as_str() {
            "vertex" => reader.vertices(element, &mut rows),
            "face" => reader.faces(element, &mut rows),
            "tristrips" => reader.strips(element, &mut rows),
            _ => rows.skip(),
        };
        note_left_out(element, &mut reader.draft.notes);
        let (longer, first) = rows.longer;
        read.map_err(|fault| fault.at(source))?;
        let what = "left out numbers after those that the header declares, in lines";
        reader.draft.notes.add_many(what, longer, || format!("line {first}"));
    }
    header.skip_rest(source, block.left(), &mut reader.draft.notes)?;
    reader.finish().map_err(|fault| fault.at(source))
}

/// Notes the rows or the properties of an element that the reader leaves out.
fn note_left_out(element: &Element, notes: &mut Notes) {
    if element.count == 0 || element.properties.is_empty() {
        return;
    }
    match element.name.as_str() {
        "vertex" => {
            let mut used = vec![Name::X, Name::Y, Name::Z];
            if element.scalars(NORMAL).is_some() {
                used.extend(NORMAL);
            }
            if element.scalars(UV).is_some() {
                used.extend(UV);
            }
            if element.has_colors() {
                used.extend(COLOR);
            }
            element.note_unused(&used, "left out properties of vertices", notes);
        }
        "face" => {
            let mut known = vec![Name::Corners, Name::CornerUv];
            if element.has_colors() {
                let first = || "face 0".to_owned();
                notes.add_many("left out colours of faces", element.count, first);
                known.extend(COLOR);
            }
            element.note_unused(&known, "left out properties of faces", notes);
        }
        "tristrips" => {
            element.note_unused(&[Name::Corners], "left out properties of strips", notes);
        }
        _ => {
            // Such as grids of scanners.
            let what = match element.list(Name::Corners) {
                Some(_) => "left out elements of vertices that are no faces",
                None => "left out elements that are no part of a mesh",
            };
            notes.add_many(what, element.count, || element.name.clone());
        }
    }
}

/// The indices of the scalars of a vertex.
struct Places {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    uv: Option<[usize; 2]>,
    /// For each channel the index, and the value that represents 1; the opacity may be missing.
    color: Option<[Option<(usize, f64)>; 4]>,
}

impl Places {
    fn new(element: &Element) -> Checked<Self> {
        let position = element.scalars([Name::X, Name::Y, Name::Z]);
        let channel = |name| element.scalar(name).map(|i| (i, element.full_scale(i)));
        let rgb = [Name::Red, Name::Green, Name::Blue].map(channel);
        let [r, g, b] = rgb;
        Ok(Self {
            position: position.ok_or("vertices have no x, y and z")?,
            normal: element.scalars(NORMAL),
            uv: element.scalars(UV),
            color: rgb.iter().all(Option::is_some).then(|| [r, g, b, channel(Name::Alpha)]),
        })
    }
}

#[derive(Default)]
struct Reader {
    draft: Draft,
    normals: Vec<[f64; 3]>,
    uv: Vec<[f64; 2]>,
    colors: Vec<[f64; 4]>,
    corner_uv: Vec<[f64; 2]>,
    uv_corners: Vec<[u32; 3]>,
}

impl Reader {
    fn vertices(&mut self, element: &Element, rows: &mut Rows<'_, '_>) -> Checked<()> {
        let places = Places::new(element)?;
        self.draft.vertices = roomy(element.count);
        while let Some(row) = rows.next()? {
            let read = self.vertex(&places, &row.scalars, row.index);
            read.map_err(|fault| fault.of(|| format!("vertex {}", row.index)))?;
        }
        Ok(())
    }

    fn vertex(&mut self, places: &Places, scalars: &[f64], index: usize) -> Checked<()> {
        self.draft.push_vertex_or_lose(places.position.map(|i| scalars[i]), None)?;
        let place = || format!("vertex {index}");
        if let Some(at) = places.normal {
            push(&mut self.normals, self.draft.finite(at.map(|i| scalars[i]), place))?;
        }
        if let Some(at) = places.uv {
            push(&mut self.uv, self.draft.finite(at.map(|i| scalars[i]), place))?;
        }
        if let Some(at) = places.color {
            let color = at.map(|channel| channel.map_or(1.0, |(i, full)| scalars[i] / full));
            push(&mut self.colors, self.draft.finite(color, place))?;
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, rows: &mut Rows<'_, '_>) -> Checked<()> {
        let Some(corners) = list_of_corners(element, "faces")? else { return Ok(()) };
        let uv = element.list(Name::CornerUv);
        if self.draft.faces.is_empty() {
            self.draft.faces = roomy(element.count);
        }
        let mut polygon = Vec::new();
        while let Some(row) = rows.next()? {
            let uv = uv.map(|uv| &row.lists[uv][..]);
            let read = self.face(&row.lists[corners], uv, row.index, &mut polygon);
            read.map_err(|fault| fault.of(|| format!("face {}", row.index)))?;
        }
        Ok(())
    }

    /// Adds a face of these vertices and texture coordinates; `polygon` is a buffer.
    fn face(
        &mut self,
        corners: &[f64],
        uv: Option<&[f64]>,
        index: usize,
        polygon: &mut Vec<u32>,
    ) -> Checked<()> {
        polygon.clear();
        for &number in corners {
            push(polygon, vertex_number(number)?)?;
        }
        let before = self.draft.faces.len();
        if !self.draft.push_polygon(polygon, || format!("face {index}"))? {
            return Ok(());
        }
        uv.map_or(Ok(()), |uv| self.corner_uv(uv, polygon.len(), before, index))
    }

    /// Adds the texture coordinates of the corners of a polygon, whose triangles begin at face
    /// `before`.
    fn corner_uv(
        &mut self,
        values: &[f64],
        corners: usize,
        before: usize,
        index: usize,
    ) -> Checked<()> {
        let place = || format!("face {index}");
        self.without_uv(before)?;
        if values.len() != 2 * corners {
            if !values.is_empty() {
                let what = "left out texture coordinates that are not as many as the corners";
                self.draft.notes.add(what, place);
            }
            return self.without_uv(self.draft.faces.len());
        }
        let first = u32::try_from(self.corner_uv.len() + corners)
            .map(|end| end - corners as u32)
            .map_err(|_| "more than 2^32 texture coordinates")?;
        for pair in values.chunks_exact(2) {
            push(&mut self.corner_uv, self.draft.finite([pair[0], pair[1]], place))?;
        }
        let numbers: Vec<u32> = (first..first + corners as u32).collect();
        for triangle in fan(&numbers) {
            push(&mut self.uv_corners, triangle)?;
        }
        Ok(())
    }

    /// Marks the faces before number `faces` that have no entry yet as faces without texture
    /// coordinates.
    fn without_uv(&mut self, faces: usize) -> Checked<()> {
        while self.uv_corners.len() < faces {
            push(&mut self.uv_corners, [Attribute::<2>::ABSENT; 3])?;
        }
        Ok(())
    }

    /// Reads strips of triangles. Each vertex makes a triangle with the two vertices before it,
    /// with alternating orientation; -1 ends a strip. Degenerate triangles, which only turn a
    /// strip, are skipped.
    fn strips(&mut self, element: &Element, rows: &mut Rows<'_, '_>) -> Checked<()> {
        let Some(corners) = list_of_corners(element, "strips")? else { return Ok(()) };
        while let Some(row) = rows.next()? {
            let read = self.strip(&row.lists[corners]);
            read.map_err(|fault| fault.of(|| format!("tristrips {}", row.index)))?;
        }
        Ok(())
    }

    fn strip(&mut self, corners: &[f64]) -> Checked<()> {
        for run in corners.split(|&number| number == -1.0 || number == f64::from(u32::MAX)) {
            let numbers = run.iter().map(|&number| vertex_number(number));
            let numbers = numbers.collect::<Checked<Vec<u32>>>()?;
            for (i, triangle) in numbers.windows(3).enumerate() {
                let (a, b, c) = (triangle[0], triangle[1], triangle[2]);
                if !has_corner_twice(&[a, b, c]) {
                    let face = if i % 2 == 0 { [a, b, c] } else { [b, a, c] };
                    push(&mut self.draft.faces, face)?;
                }
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Checked<MeshFile> {
        if !self.uv_corners.is_empty() {
            self.without_uv(self.draft.faces.len())?;
        }
        let lost = self.draft.lost()?;
        let mut file = self.draft.finish(&mut [&mut self.uv_corners], &mut [])?;
        if !self.normals.is_empty() {
            file.normals = Some(Attribute { values: self.normals, corners: None });
        }
        if !self.corner_uv.is_empty() {
            file.uv = Some(Attribute::simplified(self.corner_uv, self.uv_corners, &file.mesh));
        } else if !self.uv.is_empty() {
            file.uv = Some(Attribute { values: self.uv, corners: None });
        }
        if !self.colors.is_empty() {
            file.colors = Some(self.colors);
        }
        Ok(lost.removed_from(file)?)
    }
}

fn vertex_number(number: f64) -> Checked<u32> {
    match index(number) {
        NO_INDEX => Err(format!("{number} is not the number of a vertex").into()),
        vertex => Ok(vertex),
    }
}

/// Returns the index of the list of corners of an element of faces or strips; `None` if the element
/// is empty and has no such list.
fn list_of_corners(element: &Element, what: &str) -> Checked<Option<usize>> {
    match element.list(Name::Corners) {
        None if element.count > 0 => {
            Err(format!("{what} have no list vertex_indices or vertex_index").into())
        }
        found => Ok(found),
    }
}
