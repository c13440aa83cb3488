//! Volume files for viewers: ImageData of VTK (`.vti`) and NRRD (`.nrrd`).
//!
//! Formats: VTK's XML file formats (docs.vtk.org, "VTK XML file formats", appended raw data), and
//! "Definition of NRRD file format" (teem.sourceforge.net/nrrd/format.html).

use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

use super::points::Grid;
use catamaran::base::{Error, Result};
use catamaran::io::Output;

/// An array of numbers at the points of a [`Grid`], and its name in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Voxels<'a> {
    /// Numbers of roots: `root`, 16-bit integers.
    Roots(&'a [u16]),
    /// t of [`Gradient`](super::Gradient): `convergence`, in single precision.
    Convergence(&'a [f32]),
}

/// A format of volumes, and whether its numbers are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VolumeFormat {
    /// ImageData of VTK, for ParaView and the like: any number of arrays, the first the active one.
    /// Compressed by zlib, in blocks.
    Vti {
        /// Whether the numbers are compressed.
        packed: bool,
    },
    /// NRRD, for 3D Slicer and the like: one array. Compressed by gzip.
    Nrrd {
        /// Whether the numbers are compressed.
        packed: bool,
    },
}

impl VolumeFormat {
    /// Returns the format that the name of a file implies; `None` if it is not that of a volume.
    ///
    /// ```
    /// use catamaran_simulation::texture::newton::VolumeFormat;
    ///
    /// let packed = VolumeFormat::Nrrd { packed: true };
    /// assert_eq!(VolumeFormat::of("a.NRRD".as_ref(), true), Some(packed));
    /// assert_eq!(VolumeFormat::of("a.npy".as_ref(), true), None);
    /// ```
    pub fn of(path: &Path, packed: bool) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match &*extension {
            "vti" => Some(Self::Vti { packed }),
            "nrrd" => Some(Self::Nrrd { packed }),
            _ => None,
        }
    }
}

/// Writes numbers at the points of `grid` to a volume file, with the positions of the points.
///
/// Points of the grid are points of the volume: `PointData` in `.vti`, samples centred in their
/// cells in `.nrrd`. Numbers are little-endian.
///
/// ```
/// use catamaran::io::{Output, Overwrite};
/// use catamaran_simulation::texture::newton::{Grid, VolumeFormat, Voxels, write_volume};
///
/// let path = std::env::temp_dir().join(format!("catamaran-{}.nrrd", std::process::id()));
/// let output = Output::create(&path, Overwrite::Replace)?;
/// let voxels = [Voxels::Roots(&[0, 1, 2, 3, 4, 5, 6, 7])];
/// let format = VolumeFormat::Nrrd { packed: false };
/// write_volume(output, format, &Grid::cube(2, 2.0), &voxels)?;
/// let bytes = std::fs::read(&path).unwrap();
/// assert!(bytes.starts_with(b"NRRD0004\ntype: uint16\n"));
/// # std::fs::remove_file(path).unwrap();
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when the numbers of entries of an array and of points of the grid differ;
/// [`Error::Argument`] for no array, and for more than one in NRRD; [`Error::Io`].
pub fn write_volume(
    mut output: Output,
    format: VolumeFormat,
    grid: &Grid,
    arrays: &[Voxels<'_>],
) -> Result<()> {
    let points = grid.counts.iter().map(|&n| n as usize).product();
    for array in arrays {
        Error::check_shape(array.name(), (points, 1), (array.len(), 1))?;
    }
    let written = match (format, arrays) {
        (VolumeFormat::Vti { packed }, [_, ..]) => write_vti(&mut output, grid, arrays, packed),
        (VolumeFormat::Nrrd { packed }, [array]) => write_nrrd(&mut output, grid, *array, packed),
        _ => {
            let why = format!("NRRD has one array, and VTI at least one; got {}", arrays.len());
            return Err(Error::Argument { what: "arrays", why });
        }
    };
    written.map_err(|e| output.error(e))?;
    output.commit()
}

impl Voxels<'_> {
    fn name(&self) -> &'static str {
        match self {
            Self::Roots(_) => "root",
            Self::Convergence(_) => "convergence",
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Roots(all) => all.len(),
            Self::Convergence(all) => all.len(),
        }
    }

    /// Returns the size of a number in bytes.
    fn width(&self) -> usize {
        match self {
            Self::Roots(_) => 2,
            Self::Convergence(_) => 4,
        }
    }

    /// Returns the names of the type in VTK and in NRRD.
    fn types(&self) -> [&'static str; 2] {
        match self {
            Self::Roots(_) => ["UInt16", "uint16"],
            Self::Convergence(_) => ["Float32", "float"],
        }
    }

    /// Returns the bytes in blocks of [`BLOCK`]; the last block may be shorter.
    fn blocks(self) -> impl ExactSizeIterator<Item = Vec<u8>> {
        let numbers = BLOCK / self.width();
        (0..self.len().div_ceil(numbers)).map(move |i| {
            let range = i * numbers..self.len().min((i + 1) * numbers);
            match self {
                Self::Roots(all) => all[range].iter().flat_map(|x| x.to_le_bytes()).collect(),
                Self::Convergence(all) => all[range].iter().flat_map(|x| x.to_le_bytes()).collect(),
            }
        })
    }
}

/// Number of bytes that are compressed at a time.
const BLOCK: usize = 1 << 20;

/// Returns the first point, and the direction and length of a step along each axis. An axis without
/// a step, such as the third one of a plane, gets a step of length 1.
fn frame(grid: &Grid) -> ([f64; 3], [[f64; 3]; 3], [f64; 3]) {
    let mut steps = grid.steps.map(|step| step.map(f64::from));
    let mut lengths = [0.0; 3];
    for c in 0..3 {
        lengths[c] = steps[c].iter().map(|x| x * x).sum::<f64>().sqrt();
        if lengths[c] == 0.0 {
            (steps[c][c], lengths[c]) = (1.0, 1.0);
        }
    }
    (grid.origin.map(f64::from), steps, lengths)
}

/// Returns numbers as text with `between` between them.
fn joined(numbers: impl IntoIterator<Item = f64>, between: &str) -> String {
    numbers.into_iter().map(|x| x.to_string()).collect::<Vec<_>>().join(between)
}

fn write_nrrd(
    sink: &mut impl Write,
    grid: &Grid,
    array: Voxels<'_>,
    packed: bool,
) -> io::Result<()> {
    let (origin, steps, _) = frame(grid);
    let [nx, ny, nz] = grid.counts;
    let vector = |v: [f64; 3]| format!("({})", joined(v, ","));
    let directions = steps.map(vector).join(" ");
    let encoding = if packed { "gzip" } else { "raw" };
    let header = format!(
        "NRRD0004\ntype: {}\ndimension: 3\nspace dimension: 3\nsizes: {nx} {ny} {nz}\n\
         space directions: {directions}\nspace origin: {}\ncenterings: cell cell cell\n\
         kinds: domain domain domain\nendian: little\nencoding: {encoding}\ncontent: {}\n\n",
        array.types()[1],
        vector(origin),
        array.name(),
    );
    sink.write_all(header.as_bytes())?;
    if !packed {
        return array.blocks().try_for_each(|block| sink.write_all(&block));
    }
    let mut encoder = GzEncoder::new(sink, Compression::default());
    array.blocks().try_for_each(|block| encoder.write_all(&block))?;
    encoder.finish().map(|_| ())
}

fn write_vti(
    sink: &mut impl Write,
    grid: &Grid,
    arrays: &[Voxels<'_>],
    packed: bool,
) -> io::Result<()> {
    let (origin, steps, lengths) = frame(grid);
    let [x, y, z] = grid.counts.map(|n| i64::from(n) - 1);
    let extent = format!("0 {x} 0 {y} 0 {z}");
    // Column c of the matrix is axis c.
    let matrix = (0..9).map(|i| steps[i % 3][i / 3] / lengths[i % 3]);
    let compressor = if packed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    let active = arrays.first().map_or("", Voxels::name);
    writeln!(
        sink,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\"{compressor}>\n\
         <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\" Direction=\"{}\">\n\
         <Piece Extent=\"{extent}\">\n<PointData Scalars=\"{active}\">",
        joined(origin, " "),
        joined(lengths, " "),
        joined(matrix, " "),
    )?;
    let parts = arrays.iter().map(|a| Part::new(*a, packed)).collect::<io::Result<Vec<_>>>()?;
    let mut offset = 0;
    for part in &parts {
        let (kind, name) = (part.array.types()[0], part.array.name());
        writeln!(
            sink,
            "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>"
        )?;
        offset += part.len();
    }
    // The data begin after the underscore.
    write!(sink, "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_")?;
    parts.iter().try_for_each(|part| part.write(sink))?;
    writeln!(sink, "\n</AppendedData>\n</VTKFile>")
}

/// The appended data of an array.
struct Part<'a> {
    array: Voxels<'a>,
    header: Vec<u64>,
    /// The compressed blocks; empty if the data are not compressed.
    blocks: Vec<Vec<u8>>,
}

impl<'a> Part<'a> {
    fn new(array: Voxels<'a>, packed: bool) -> io::Result<Self> {
        let bytes = array.len() * array.width();
        if !packed {
            return Ok(Self { array, header: vec![bytes as u64], blocks: Vec::new() });
        }
        let pack = |block: Vec<u8>| {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
            encoder.write_all(&block)?;
            encoder.finish()
        };
        let blocks = array.blocks().map(pack).collect::<io::Result<Vec<_>>>()?;
        // The number of blocks, the size of a block, the size of the last block if it is not full,
        // then the compressed sizes.
        let mut header = [blocks.len(), BLOCK, bytes % BLOCK].map(|n| n as u64).to_vec();
        header.extend(blocks.iter().map(|block| block.len() as u64));
        Ok(Self { array, header, blocks })
    }

    fn len(&self) -> usize {
        let numbers = match self.blocks.is_empty() {
            true => self.array.len() * self.array.width(),
            false => self.blocks.iter().map(Vec::len).sum(),
        };
        8 * self.header.len() + numbers
    }

    fn write(&self, sink: &mut impl Write) -> io::Result<()> {
        self.header.iter().try_for_each(|n| sink.write_all(&n.to_le_bytes()))?;
        if self.blocks.is_empty() {
            return self.array.blocks().try_for_each(|block| sink.write_all(&block));
        }
        self.blocks.iter().try_for_each(|block| sink.write_all(block))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;
    use std::io::Read;

    use super::*;
    use catamaran::io::Overwrite;

    /// Returns 300,000 numbers, more than one block of either type holds.
    fn grid() -> (Grid, Vec<u16>, Vec<f32>) {
        let grid = Grid {
            origin: [-1.25, 0.5, 2.0],
            steps: [[0.5, 0.0, 0.0], [0.0, 0.0, 0.25], [0.0, -0.125, 0.0]],
            counts: [100, 60, 100],
        };
        let roots =
            (0..600_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 20) as u16).collect();
        let convergence = (0..600_000).map(|i| (i as f32).sin() * 31.0).collect();
        (grid, roots, convergence)
    }

    fn written(format: VolumeFormat, grid: &Grid, arrays: &[Voxels<'_>]) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("volume");
        let output = Output::create(&path, Overwrite::Never).unwrap();
        write_volume(output, format, grid, arrays).unwrap();
        std::fs::read(path).unwrap()
    }

    /// Returns the text before `end`, and the bytes after it.
    fn split<'a>(bytes: &'a [u8], end: &str) -> (String, &'a [u8]) {
        let at = bytes.windows(end.len()).position(|w| w == end.as_bytes()).unwrap();
        (String::from_utf8(bytes[..at].to_vec()).unwrap(), &bytes[at + end.len()..])
    }

    fn u16s(bytes: &[u8]) -> Vec<u16> {
        bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect()
    }

    fn f32s(bytes: &[u8]) -> Vec<f32> {
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    #[test]
    fn nrrd_is_read_back() {
        let (grid, roots, convergence) = grid();
        for packed in [false, true] {
            for array in [Voxels::Roots(&roots), Voxels::Convergence(&convergence)] {
                let file = written(VolumeFormat::Nrrd { packed }, &grid, &[array]);
                let (head, data) = split(&file, "\n\n");
                let mut lines = head.lines();
                assert_eq!(lines.next(), Some("NRRD0004"));
                let fields: HashMap<_, _> =
                    lines.map(|line| line.split_once(": ").unwrap()).collect();
                assert_eq!(fields["sizes"], "100 60 100");
                assert_eq!(fields["space origin"], "(-1.25,0.5,2)");
                assert_eq!(fields["space directions"], "(0.5,0,0) (0,0,0.25) (0,-0.125,0)");
                let mut bytes = data.to_vec();
                match fields["encoding"] {
                    "gzip" => {
                        bytes.clear();
                        flate2::read::GzDecoder::new(data).read_to_end(&mut bytes).unwrap();
                        assert!(packed && data.len() < bytes.len());
                    }
                    encoding => assert!(!packed && encoding == "raw"),
                }
                match (fields["type"], fields["content"]) {
                    ("uint16", "root") => assert_eq!(u16s(&bytes), roots),
                    ("float", "convergence") => assert_eq!(f32s(&bytes), convergence),
                    other => panic!("{other:?}"),
                }
            }
        }
    }

    /// Returns the value of an attribute of XML.
    fn attribute<'a>(text: &'a str, name: &str) -> &'a str {
        let start = text.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        text[start..].split('"').next().unwrap()
    }

    fn u64_at(bytes: &[u8], i: usize) -> usize {
        u64::from_le_bytes(bytes[8 * i..8 * (i + 1)].try_into().unwrap()) as usize
    }

    /// Returns the data of an array that begins at the start of `data`.
    fn appended(data: &[u8], packed: bool) -> Vec<u8> {
        if !packed {
            return data[8..8 + u64_at(data, 0)].to_vec();
        }
        let [count, full, last] = [0, 1, 2].map(|i| u64_at(data, i));
        let (mut all, mut at) = (Vec::new(), 8 * (3 + count));
        for block in 0..count {
            let size = u64_at(data, 3 + block);
            let before = all.len();
            flate2::read::ZlibDecoder::new(&data[at..at + size]).read_to_end(&mut all).unwrap();
            let expected = if block + 1 == count && last > 0 { last } else { full };
            assert_eq!(all.len() - before, expected);
            at += size;
        }
        all
    }

    #[test]
    fn vti_is_read_back() {
        let (grid, roots, convergence) = grid();
        for packed in [false, true] {
            let arrays = [Voxels::Roots(&roots), Voxels::Convergence(&convergence)];
            let file = written(VolumeFormat::Vti { packed }, &grid, &arrays);
            let (head, data) = split(&file, "<AppendedData encoding=\"raw\">\n_");
            assert_eq!(attribute(&head, "WholeExtent"), "0 99 0 59 0 99");
            assert_eq!(attribute(&head, "Origin"), "-1.25 0.5 2");
            assert_eq!(attribute(&head, "Spacing"), "0.5 0.25 0.125");
            assert_eq!(attribute(&head, "Direction"), "1 0 0 0 0 -1 0 1 0");
            assert_eq!(attribute(&head, "Scalars"), "root");
            assert_eq!(head.contains("vtkZLibDataCompressor"), packed);
            let found: Vec<_> = head.split("<DataArray").skip(1).collect();
            assert_eq!(found.len(), 2);
            for (text, (name, kind)) in
                found.iter().zip([("root", "UInt16"), ("convergence", "Float32")])
            {
                assert_eq!((attribute(text, "Name"), attribute(text, "type")), (name, kind));
                let offset: usize = attribute(text, "offset").parse().unwrap();
                let bytes = appended(&data[offset..], packed);
                match name {
                    "root" => assert_eq!(u16s(&bytes), roots),
                    _ => assert_eq!(f32s(&bytes), convergence),
                }
            }
            assert!(data.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
        }
    }

    #[test]
    fn a_plane_is_a_volume_of_one_layer() {
        let plane = Grid::plane(3, 2, [0.0, 0.0], 3.0);
        let file = written(VolumeFormat::Vti { packed: false }, &plane, &[Voxels::Roots(&[7; 6])]);
        let (head, _) = split(&file, "<AppendedData");
        assert_eq!(attribute(&head, "WholeExtent"), "0 2 0 1 0 0");
        assert_eq!(attribute(&head, "Spacing"), "1 1 1");
        assert_eq!(attribute(&head, "Direction"), "1 0 0 0 -1 0 0 0 1");
    }

    #[test]
    fn arrays_that_do_not_fit_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("volume");
        let grid = Grid::cube(2, 1.0);
        let (few, many) = (Voxels::Roots(&[1; 7]), Voxels::Roots(&[1; 8]));
        let nrrd = VolumeFormat::Nrrd { packed: false };
        let run = |format, arrays: &[Voxels<'_>]| {
            let output = Output::create(&path, Overwrite::Never).unwrap();
            write_volume(output, format, &grid, arrays).unwrap_err()
        };
        assert!(matches!(run(nrrd, &[few]), Error::Shape { what: "root", .. }));
        assert!(run(nrrd, &[many, many]).to_string().contains("NRRD has one"));
        assert!(run(VolumeFormat::Vti { packed: false }, &[]).to_string().contains("at least one"));
        assert!(!path.exists());
    }
}
