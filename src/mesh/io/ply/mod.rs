//! Stanford PLY (Turk 1994): ASCII, and binary in both byte orders.

mod element;
mod encoding;
mod header;
mod rows;
mod write;

use self::element::{Element, Name};
use self::header::Header;
use self::rows::Rows;
use super::attributes::{Attribute, MeshFile};
use super::draft::{Checked, Draft, push, roomy};
use super::text::finite;
use crate::base::Result;
use crate::io::Source;

pub use self::encoding::PlyEncoding;
pub(super) use self::write::write;

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let header = Header::read(source)?;
    let mut reader = Reader::default();
    for element in &header.elements {
        let mut rows = Rows::new(source, header.encoding, element);
        let read = match element.name.as_str() {
            "vertex" => reader.vertices(element, &mut rows),
            "face" => reader.faces(element, &mut rows),
            "tristrips" => Err("triangle strips (element tristrips) are not read".into()),
            _ => rows.skip(),
        };
        read.map_err(|fault| fault.at(source))?;
    }
    header.nothing_more(source)?;
    reader.finish().map_err(|fault| fault.at(source))
}

/// Where among the scalars of a vertex is what.
struct Places {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    uv: Option<[usize; 2]>,
    /// Of each channel the place, and the number that stands for 1; opacity may be missing.
    color: Option<[Option<(usize, f64)>; 4]>,
}

impl Places {
    fn new(element: &Element) -> Checked<Self> {
        let position = element.scalars([Name::X, Name::Y, Name::Z]);
        let channel = |name| element.scalar(name).map(|i| (i, element.full_scale(i)));
        let rgb = [Name::Red, Name::Green, Name::Blue].map(channel);
        let [r, g, b] = rgb;
        Ok(Self {
            position: position.ok_or("vertices without x, y and z")?,
            normal: element.scalars([Name::NormalX, Name::NormalY, Name::NormalZ]),
            uv: element.scalars([Name::U, Name::V]),
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
            let read = self.vertex(&places, &row.scalars);
            read.map_err(|fault| fault.of(|| format!("vertex {}", row.index)))?;
        }
        Ok(())
    }

    fn vertex(&mut self, places: &Places, scalars: &[f64]) -> Checked<()> {
        self.draft.push_vertex(places.position.map(|i| scalars[i]))?;
        if let Some(at) = places.normal {
            push(&mut self.normals, finite(at.map(|i| scalars[i]))?)?;
        }
        if let Some(at) = places.uv {
            push(&mut self.uv, finite(at.map(|i| scalars[i]))?)?;
        }
        if let Some(at) = places.color {
            let color = at.map(|channel| channel.map_or(1.0, |(i, full)| scalars[i] / full));
            push(&mut self.colors, finite(color)?)?;
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, rows: &mut Rows<'_, '_>) -> Checked<()> {
        let Some(corners) = element.list(Name::Corners) else {
            return if element.count == 0 {
                Ok(())
            } else {
                Err("faces without a list vertex_indices".into())
            };
        };
        let uv = element.list(Name::CornerUv);
        self.draft.faces = roomy(element.count);
        let mut polygon = Vec::new();
        while let Some(row) = rows.next()? {
            let uv = uv.map(|uv| &row.lists[uv][..]);
            let read = self.face(&row.lists[corners], uv, &mut polygon);
            read.map_err(|fault| fault.of(|| format!("face {}", row.index)))?;
        }
        Ok(())
    }

    /// A face of these vertices and texture coordinates; `polygon` is scratch.
    fn face(&mut self, corners: &[f64], uv: Option<&[f64]>, polygon: &mut Vec<u32>) -> Checked<()> {
        polygon.clear();
        for &number in corners {
            // Every integer type of PLY is exact in a double.
            if !(number >= 0.0 && number < f64::from(u32::MAX) && number.fract() == 0.0) {
                return Err(format!("vertex {number}").into());
            }
            push(polygon, number as u32)?;
        }
        let before = self.draft.faces.len();
        self.draft.push_polygon(polygon)?;
        uv.map_or(Ok(()), |uv| self.corner_uv(uv, polygon.len(), before))
    }

    /// The texture coordinates of the corners of a polygon, whose triangles begin at face `before`.
    fn corner_uv(&mut self, values: &[f64], corners: usize, before: usize) -> Checked<()> {
        if !values.is_empty() && values.len() != 2 * corners {
            let count = values.len();
            return Err(format!("{count} texture coordinates of {corners} corners").into());
        }
        if values.is_empty() {
            for _ in before..self.draft.faces.len() {
                push(&mut self.uv_corners, [Attribute::<2>::ABSENT; 3])?;
            }
            return Ok(());
        }
        let first = u32::try_from(self.corner_uv.len() + corners)
            .map(|end| end - corners as u32)
            .map_err(|_| "more than 2^32 texture coordinates")?;
        for pair in values.chunks_exact(2) {
            push(&mut self.corner_uv, finite([pair[0], pair[1]])?)?;
        }
        for i in 2..corners as u32 {
            push(&mut self.uv_corners, [first, first + i - 1, first + i])?;
        }
        Ok(())
    }

    fn finish(self) -> Checked<MeshFile> {
        let mesh = self.draft.finish()?;
        let mut file = MeshFile::from(mesh);
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
        Ok(file)
    }
}
