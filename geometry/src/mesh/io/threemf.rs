//! 3MF: meshes for printers in XML, in a zip archive.
//!
//! Format: "3D Manufacturing Format, core specification 1.3" and "production extension 1.1"
//! (3mf.io).

use std::collections::HashMap;
use std::io::{self, Cursor, Read, Write};
use std::rc::Rc;

use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use super::super::TriMesh;
use super::attributes::MeshFile;
use super::draft::{Checked, Draft, Numbers};
use super::gltf::Transform;
use super::stored::Budget;
use super::text::{count, number, of_utf16, words};
use super::xml::{Event, Tag, Xml};
use catamaran::base::{Result, push};
use catamaran::io::Source;

/// The kind of the relationship that names the model of an archive, without its name space.
const MODEL: &str = "/3dmodel";

/// Bytes of memory that an object in its place counts as, besides its vertices and faces: bounds
/// the time that objects within objects take.
const PLACE: usize = 1 << 10;

/// Parts of the names of extensions that change no triangles, or that the reader applies. Slices
/// are those of the triangles, unless an object says that its mesh is coarse, which is noted.
const EXTENSIONS: [&str; 4] = ["/production/", "/material/", "/trianglesets/", "/slice/"];

/// Part of the name of the extension whose beams are refused where a model requires them and has
/// some.
const BEAMS: &str = "/beamlattice/";

/// Components within components, at most.
const DEEPEST: usize = 64;

pub(super) fn read(source: &mut Source<'_>) -> Result<MeshFile> {
    let bytes = source.read_all()?;
    mesh(&bytes, &mut Budget::new(source)).map_err(|fault| fault.at(source))
}

fn mesh(bytes: &[u8], budget: &mut Budget<'_, '_>) -> Checked<MeshFile> {
    let mut package = Package::open(bytes, budget)?;
    let mut draft = Draft::default();
    package.build(&mut draft)?;
    Ok(draft.finish(&mut [], &mut [])?)
}

/// An object: a mesh, or other objects.
#[derive(Default)]
struct Object {
    /// Whether it only holds others up while they are printed.
    is_support: bool,
    /// Whether its mesh is coarse, and what is printed are its slices.
    is_coarse: bool,
    vertices: Vec<[f64; 3]>,
    faces: Vec<[u32; 3]>,
    components: Vec<Item>,
}

impl Object {
    /// Adds a vertex or a triangle; other elements are skipped.
    fn add(&mut self, tag: &Tag<'_>, scale: f64) -> Checked<()> {
        match tag.name {
            b"vertex" => {
                let x = |name: &str| number(tag.bytes(name)?);
                push(&mut self.vertices, [x("x")?, x("y")?, x("z")?].map(|x| scale * x))?;
            }
            b"triangle" => push(&mut self.faces, triangle(tag, self.vertices.len())?)?,
            _ => {}
        }
        Ok(())
    }
}

/// An object in its place.
struct Item {
    /// The part of the archive that has the object, and its number there.
    object: (u32, usize),
    transform: Transform,
}

/// What an archive has.
struct Package<'p, 's, 'a> {
    archive: ZipArchive<Cursor<&'p [u8]>>,
    budget: &'p mut Budget<'s, 'a>,
    objects: HashMap<(u32, usize), Rc<Object>>,
    items: Vec<Item>,
    /// How often a support was left out, and its number at first.
    supports: (usize, usize),
    /// The names of the parts to read, the root first, and their numbers.
    parts: Vec<String>,
    numbers: Numbers,
    /// Millimetres in a unit of the file.
    scale: f64,
    unit: String,
}

impl<'p, 's, 'a> Package<'p, 's, 'a> {
    /// Reads the model that the archive names, and the parts that the model names.
    fn open(bytes: &'p [u8], budget: &'p mut Budget<'s, 'a>) -> Checked<Self> {
        let archive = ZipArchive::new(Cursor::new(bytes));
        let archive = archive.map_err(|e| format!("no archive (zip) that can be read: {e}"))?;
        let mut package = Self {
            archive,
            budget,
            objects: HashMap::new(),
            items: Vec::new(),
            supports: (0, 0),
            parts: Vec::new(),
            numbers: Numbers::default(),
            scale: 1.0,
            unit: "millimeter".into(),
        };
        let root = package.root()?;
        let mut part = package.want(root)?;
        while let Some(name) = package.parts.get(part as usize).cloned() {
            let text = package.part(&name)?;
            let mut xml = Xml::new(&text);
            let read = package.model(&mut xml, part);
            let place = || format!("{name}:{}", xml.cursor.line_number());
            read.map_err(|fault| fault.of(place))?;
            part += 1;
        }
        Ok(package)
    }

    /// Returns the number of a part, which is added to those to read unless it is one of them.
    fn want(&mut self, name: String) -> Checked<u32> {
        let words = name.bytes().map(u64::from);
        let (number, is_new) = self.numbers.of(words, |k| self.parts[k] == name)?;
        if is_new {
            push(&mut self.parts, name)?;
        }
        Ok(number)
    }

    /// Returns the content of a part.
    fn part(&mut self, name: &str) -> Checked<Vec<u8>> {
        // Names of parts differ in more than the case of letters (OPC, section 6.3.5).
        let is_same = |other: &[u8]| other.eq_ignore_ascii_case(name.as_bytes());
        let at = self.archive.index_for_name(name);
        let at = at.or_else(|| self.archive.file_names_raw().position(is_same));
        let at = at.ok_or_else(|| format!("the archive has no part {name:?}"))?;
        let fail = |e: &dyn std::fmt::Display| format!("{name}: can't be unpacked: {e}");
        let mut entry = self.archive.by_index(at).map_err(|e| fail(&e))?;
        let size = usize::try_from(entry.size()).map_err(|e| fail(&e))?;
        self.budget.take(size)?;
        let mut content = Vec::new();
        // One byte more than announced, so that the content of a wrong size is not all unpacked.
        let most = (size as u64).saturating_add(1);
        entry.by_ref().take(most).read_to_end(&mut content).map_err(|e| fail(&e))?;
        if content.len() > size {
            return Err(format!("{name}: unpacks to more than {size} bytes").into());
        }
        Ok(of_utf16(&content).unwrap_or(content))
    }

    /// Returns the name of the part that has the model.
    fn root(&mut self) -> Checked<String> {
        let text = self.part("_rels/.rels")?;
        let mut xml = Xml::new(&text);
        while let Some(event) = xml.next()? {
            if let Event::Start(tag) = event
                && tag.name == b"Relationship"
                && tag.need("Type")?.to_ascii_lowercase().ends_with(MODEL)
            {
                return Ok(plain(&tag.need("Target")?));
            }
        }
        Err("the archive names no model: not 3MF".into())
    }

    /// Reads a part with objects, and the items of the root.
    fn model(&mut self, xml: &mut Xml<'_>, part: u32) -> Checked<()> {
        let is_root = part == 0;
        let mut scale = 1.0;
        // The object that is being read, and its number.
        let mut open: Option<(usize, Object)> = None;
        let mut is_model = false;
        // The extension of beams, if the model requires it.
        let mut beams = None;
        while let Some(event) = xml.next()? {
            let tag = match event {
                Event::Start(tag) => tag,
                Event::End(b"object") => {
                    if let Some((id, object)) = open.take()
                        && self.objects.insert((part, id), Rc::new(object)).is_some()
                    {
                        return Err(format!("object {id} exists twice").into());
                    }
                    continue;
                }
                _ => continue,
            };
            match tag.name {
                b"model" => {
                    is_model = true;
                    beams = check_extensions(&tag)?;
                    let unit = tag.get("unit").unwrap_or("millimeter".into());
                    scale = millimetres(&unit)
                        .ok_or_else(|| format!("unknown unit {unit:?} of the model"))?;
                    if is_root {
                        (self.scale, self.unit) = (scale, unit.into_owned());
                    }
                }
                b"beamlattice" => {
                    if let Some(name) = &beams {
                        return Err(requires(name).into());
                    }
                }
                b"object" => {
                    let kind = tag.get("type");
                    let is_support = matches!(kind.as_deref(), Some("support" | "solidsupport"));
                    let is_coarse = tag.get("meshresolution").as_deref() == Some("lowres");
                    let object = Object { is_support, is_coarse, ..Object::default() };
                    open = Some((count(tag.bytes("id")?)?, object));
                }
                b"item" if is_root => {
                    let item = self.placed(&tag, part, scale)?;
                    push(&mut self.items, item)?;
                }
                name => {
                    let Some((id, object)) = &mut open else { continue };
                    let at = object.vertices.len() + object.faces.len();
                    let added = if name == b"component" {
                        let item = self.placed(&tag, part, scale);
                        item.and_then(|item| Ok(push(&mut object.components, item)?))
                    } else {
                        object.add(&tag, scale)
                    };
                    added.map_err(|fault| fault.of(|| format!("object {id}, element {at}")))?;
                }
            }
        }
        if is_model { Ok(()) } else { Err("has no <model>".into()) }
    }

    /// Returns the object that an item or a component of a part names, and its place.
    fn placed(&mut self, tag: &Tag<'_>, part: u32, scale: f64) -> Checked<Item> {
        let id = count(tag.bytes("objectid")?)?;
        let part = match tag.get("path") {
            Some(path) => self.want(plain(&path))?,
            None => part,
        };
        let mut transform = Transform::IDENTITY;
        if let Some(text) = tag.get("transform") {
            let numbers: Vec<f64> = words(text.as_bytes()).map(number).collect::<Checked<_>>()?;
            let (&[x, y, z, origin], []) = numbers.as_chunks::<3>() else {
                return Err(format!("a transform has 12 numbers, not {}", numbers.len()).into());
            };
            transform = Transform::new([x, y, z], origin.map(|x| scale * x));
        }
        Ok(Item { object: (part, id), transform })
    }

    /// Adds the items of the build to a mesh.
    fn build(&mut self, draft: &mut Draft) -> Checked<()> {
        let items = std::mem::take(&mut self.items);
        if items.is_empty() {
            return Err("has no items to build".into());
        }
        for item in &items {
            self.place(item, &item.transform, 0, draft)?;
        }
        if draft.faces.is_empty() && self.supports.0 > 0 {
            return Err("has supports only, which are left out: no object to print".into());
        }
        let (supports, first) = self.supports;
        let what = "left out supports, which hold objects while they are printed: objects";
        draft.notes.add_many(what, supports, || format!("object {first}"));
        if self.scale != 1.0 {
            let unit = self.unit.clone();
            draft.notes.add("converted to millimetres", || format!("the unit {unit}"));
        }
        Ok(())
    }

    /// Adds an object in the place `transform`, at this depth of components.
    fn place(
        &mut self,
        item: &Item,
        transform: &Transform,
        depth: usize,
        draft: &mut Draft,
    ) -> Checked<()> {
        let (_, id) = &item.object;
        if depth > DEEPEST {
            return Err(format!("object {id}: components within components, without end").into());
        }
        let object = self.objects.get(&item.object).cloned();
        let object = object.ok_or_else(|| format!("object {id} does not exist"))?;
        if object.is_support {
            let (count, first) = self.supports;
            self.supports = (count + 1, if count == 0 { *id } else { first });
            return Ok(());
        }
        if object.is_coarse {
            let what = "read the coarse meshes of objects, not their slices";
            draft.notes.add(what, || format!("object {id}"));
        }
        // Few objects can be many in their places, also when they are empty.
        let (vertices, faces) = (object.vertices.len(), object.faces.len());
        let bytes = PLACE + size_of::<[f64; 3]>() * vertices;
        self.budget.take(bytes.saturating_add(size_of::<[u32; 3]>() * faces))?;
        let base = draft.vertices.len();
        for (v, &position) in object.vertices.iter().enumerate() {
            let pushed = draft.push_vertex(transform.point(position));
            pushed.map_err(|fault| fault.of(|| format!("object {id}: vertex {v}")))?;
        }
        let base = u32::try_from(base + vertices)
            .map(|end| end - vertices as u32)
            .map_err(|_| "more than 2^32 vertices")?;
        for (f, face) in object.faces.iter().enumerate() {
            let [a, b, c] = face.map(|v| base + v);
            let face = if transform.is_mirrored() { [b, a, c] } else { [a, b, c] };
            draft.push_polygon(&face, || format!("object {id}: triangle {f}"))?;
        }
        for component in &object.components {
            let inner = transform.after(&component.transform);
            self.place(component, &inner, depth + 1, draft)?;
        }
        Ok(())
    }
}

/// Returns an error if a model can't be read without an extension that is not supported; the name
/// of the extension of beams, if it is required.
fn check_extensions(model: &Tag<'_>) -> Checked<Option<String>> {
    let mut beams = None;
    let required = model.get("requiredextensions").unwrap_or_default();
    for prefix in required.split_whitespace() {
        // `xmlns:prefix`, of which a tag keeps the end.
        let name = model.get(prefix).unwrap_or(prefix.into());
        if name.contains(BEAMS) {
            beams = Some(name.into_owned());
        } else if !EXTENSIONS.iter().any(|known| name.contains(known)) {
            return Err(requires(&name).into());
        }
    }
    Ok(beams)
}

fn requires(extension: &str) -> String {
    format!("requires the extension {extension}, which is not supported")
}

/// Returns the name of a part as the archive has it: without a slash in front.
fn plain(name: &str) -> String {
    name.trim_start_matches('/').to_owned()
}

/// Returns the number of millimetres in a unit.
fn millimetres(unit: &str) -> Option<f64> {
    Some(match unit {
        "micron" => 1e-3,
        "millimeter" => 1.0,
        "centimeter" => 10.0,
        "inch" => 25.4,
        "foot" => 304.8,
        "meter" => 1e3,
        _ => return None,
    })
}

/// Returns the vertices of a triangle, of which there are `vertices`.
fn triangle(tag: &Tag<'_>, vertices: usize) -> Checked<[u32; 3]> {
    let mut face = [0; 3];
    for (corner, name) in face.iter_mut().zip(["v1", "v2", "v3"]) {
        let v = count(tag.bytes(name)?)?;
        let known = u32::try_from(v).ok().filter(|_| v < vertices);
        let wrong = || format!("vertex {v} is out of range: {vertices} vertices, from 0");
        *corner = known.ok_or_else(wrong)?;
    }
    Ok(face)
}

/// Writes the mesh as one object, in millimetres, with every digit.
pub(super) fn write(sink: &mut dyn Write, mesh: &TriMesh) -> io::Result<()> {
    // Sizes of 4 GiB and more.
    let is_large = mesh.faces().len() + mesh.vertices().len() > 1 << 25;
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let mut part = |name: &str, body: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>| {
        let options = SimpleFileOptions::default().large_file(is_large);
        archive.start_file(name, options).map_err(io::Error::from)?;
        body(&mut archive)
    };
    let head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>";
    part("[Content_Types].xml", &mut |sink| {
        writeln!(
            sink,
            "{head}\n<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\
             <Default Extension=\"rels\" \
             ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\
             <Default Extension=\"model\" \
             ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>"
        )
    })?;
    part("_rels/.rels", &mut |sink| {
        writeln!(
            sink,
            "{head}\n<Relationships \
             xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\
             <Relationship Target=\"/3D/3dmodel.model\" Id=\"model\" \
             Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>\
             </Relationships>"
        )
    })?;
    part("3D/3dmodel.model", &mut |sink| {
        let mut sink = io::BufWriter::new(sink);
        writeln!(
            sink,
            "{head}\n<model unit=\"millimeter\" \
             xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n<resources>\n\
             <object id=\"1\" type=\"model\">\n<mesh>\n<vertices>"
        )?;
        for [x, y, z] in mesh.vertices() {
            writeln!(sink, "<vertex x=\"{x:?}\" y=\"{y:?}\" z=\"{z:?}\"/>")?;
        }
        writeln!(sink, "</vertices>\n<triangles>")?;
        for [a, b, c] in mesh.faces() {
            writeln!(sink, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>")?;
        }
        writeln!(
            sink,
            "</triangles>\n</mesh>\n</object>\n</resources>\n<build><item objectid=\"1\"/></build>\
             \n</model>"
        )?;
        sink.flush()
    })?;
    let bytes = archive.finish().map_err(io::Error::from)?.into_inner();
    sink.write_all(&bytes)
}
