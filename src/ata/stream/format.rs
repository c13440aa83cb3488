//! An [`Accumulator`] as bytes, little-endian:
//!
//! | part | content |
//! |---|---|
//! | preamble | `CATAACC` and a zero; version, u32; bytes of a scalar (4 or 8), u32 |
//! | head | its length in bytes, u32; columns, first and end of the strip, rows, expected rows and rows of a block, u64 each; centred (0 or 1), u8; shift given (0 or 1), u8; number of labels, u32; for each label name and value, as length (u32) and UTF-8 |
//! | check | CRC-32 of everything before, u32 |
//! | body | sum of the weights, and of their sizes, f64; shift, n scalars, if given; sum of the shifted rows, n f64, if centred; each row of the strip up to the diagonal, scalars |
//! | check | CRC-32 of the body, u32 |

use std::io::{self, Read, Write};

use crc32fast::Hasher;

use super::accumulator::Accumulator;
use crate::base::Real;
use crate::blas::BlasReal;

const MAGIC: &[u8; 8] = b"CATAACC\0";

/// Of this format; another one is refused.
const VERSION: u32 = 1;

/// A head beyond this is no head of ours.
const LONGEST_HEAD: u32 = 1 << 20;

/// Scalars converted at a time.
const CHUNK: usize = 1 << 13;

/// The scalar of the accumulator whose bytes `source` begins with, `"f32"` or `"f64"`.
///
/// # Errors
/// Those of the source; [`io::ErrorKind::InvalidData`] when they are of something else, or of another version.
pub fn scalar_of(source: &mut dyn Read) -> io::Result<&'static str> {
    preamble(&mut Checked::new(source))
}

impl<T: BlasReal> Accumulator<T> {
    /// Writes it, for [`Accumulator::read`].
    ///
    /// # Errors
    /// Those of the sink.
    pub fn write(&self, sink: &mut dyn Write) -> io::Result<()> {
        let mut head = Vec::new();
        let strip = self.c.rows();
        let numbers = [
            self.ncols as u64,
            strip.start as u64,
            strip.end as u64,
            self.moments.rows,
            self.expected_rows,
            self.block_rows,
        ];
        numbers.iter().for_each(|number| head.extend(number.to_le_bytes()));
        head.push(u8::from(self.moments.centered));
        head.push(u8::from(!self.moments.shift.is_empty()));
        head.extend((self.labels.len() as u32).to_le_bytes());
        for text in self.labels.iter().flat_map(|(name, value)| [name, value]) {
            head.extend((text.len() as u32).to_le_bytes());
            head.extend(text.as_bytes());
        }
        let mut sink = Checked::new(sink);
        sink.put(MAGIC)?;
        sink.put(&VERSION.to_le_bytes())?;
        sink.put(&(size_of::<T>() as u32).to_le_bytes())?;
        sink.put(&(head.len() as u32).to_le_bytes())?;
        sink.put(&head)?;
        sink.put_check()?;

        sink.put(&self.moments.weight.to_le_bytes())?;
        sink.put(&self.moments.weight_size.to_le_bytes())?;
        sink.put_scalars(&self.moments.shift)?;
        sink.put_scalars(&self.moments.sum)?;
        for i in 0..strip.len() {
            sink.put_scalars(self.c.lower_row(i))?;
        }
        sink.put_check()
    }

    /// What [`Accumulator::write`] wrote, bit for bit.
    ///
    /// # Errors
    /// Those of the source; [`io::ErrorKind::InvalidData`] when the bytes are cut off or damaged, or not an
    /// accumulator of T in this version; [`io::ErrorKind::OutOfMemory`].
    pub fn read(source: &mut dyn Read) -> io::Result<Self> {
        let mut source = Checked::new(source);
        let scalar = preamble(&mut source)?;
        if scalar != T::NAME {
            return Err(invalid(format!("an accumulator of {scalar}, not of {}", T::NAME)));
        }
        let length = source.number()?;
        if length > LONGEST_HEAD {
            return Err(invalid("damaged: its head is too long"));
        }
        let mut head = vec![0; length as usize];
        source.get(&mut head)?;
        source.get_check()?;

        let mut head = Checked::new(&head[..]);
        let mut numbers = [0; 6];
        for number in &mut numbers {
            *number = u64::from_le_bytes(head.bytes()?);
        }
        let [centered, shifted] = head.bytes()?;
        let (centered, shifted) = (centered != 0, shifted != 0);
        let mut labels = Vec::new();
        for _ in 0..head.number()? {
            labels.push((head.text()?, head.text()?));
        }

        let fits = |number: u64| usize::try_from(number).map_err(|_| invalid("damaged: its shape"));
        let [ncols, first, end] = [fits(numbers[0])?, fits(numbers[1])?, fits(numbers[2])?];
        let mut new = Self::of_strip(ncols, first..end, centered)
            .map_err(|e| io::Error::new(io::ErrorKind::OutOfMemory, e.to_string()))?;
        new.labels = labels;
        [new.moments.rows, new.expected_rows, new.block_rows] =
            [numbers[3], numbers[4], numbers[5]];
        new.moments.weight = f64::from_le_bytes(source.bytes()?);
        new.moments.weight_size = f64::from_le_bytes(source.bytes()?);
        if shifted {
            new.moments.shift = vec![T::ZERO; ncols];
        }
        source.get_scalars(&mut new.moments.shift)?;
        source.get_scalars(&mut new.moments.sum)?;
        for i in 0..end - first {
            source.get_scalars(new.c.lower_row_mut(i))?;
        }
        source.get_check()?;
        if source.stream.read(&mut [0])? != 0 {
            return Err(invalid("damaged: it goes on after its end"));
        }
        Ok(new)
    }
}

fn preamble<S: Read>(source: &mut Checked<S>) -> io::Result<&'static str> {
    if &source.bytes()? != MAGIC {
        return Err(invalid("not an accumulator of catamaran"));
    }
    let version = source.number()?;
    if version != VERSION {
        let what = format!("an accumulator of version {version}, where {VERSION} is known");
        return Err(invalid(what));
    }
    match source.number()? {
        4 => Ok(f32::NAME),
        8 => Ok(f64::NAME),
        _ => Err(invalid("damaged: its scalar")),
    }
}

fn invalid(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

/// A stream, and the checksum of what went through it.
struct Checked<S> {
    stream: S,
    check: Hasher,
}

impl<S> Checked<S> {
    fn new(stream: S) -> Self {
        Self { stream, check: Hasher::new() }
    }
}

impl<S: Write> Checked<S> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.check.update(bytes);
        self.stream.write_all(bytes)
    }

    fn put_scalars<T: Real>(&mut self, values: &[T]) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(CHUNK * size_of::<T>());
        for chunk in values.chunks(CHUNK) {
            bytes.clear();
            for value in chunk {
                // An f32 survives f64 and back.
                match size_of::<T>() {
                    4 => bytes.extend((value.to_f64() as f32).to_le_bytes()),
                    _ => bytes.extend(value.to_f64().to_le_bytes()),
                }
            }
            self.put(&bytes)?;
        }
        Ok(())
    }

    fn put_check(&mut self) -> io::Result<()> {
        let sum = self.check.clone().finalize();
        self.check.reset();
        self.stream.write_all(&sum.to_le_bytes())
    }
}

impl<S: Read> Checked<S> {
    fn get(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        self.stream.read_exact(bytes).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => invalid("truncated: it ends too early"),
            _ => e,
        })?;
        self.check.update(bytes);
        Ok(())
    }

    fn bytes<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.get(&mut bytes)?;
        Ok(bytes)
    }

    fn number(&mut self) -> io::Result<u32> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    fn text(&mut self) -> io::Result<String> {
        let length = self.number()?;
        let mut text = Vec::new();
        (&mut self.stream).take(length.into()).read_to_end(&mut text)?;
        if text.len() != length as usize {
            return Err(invalid("damaged: a label"));
        }
        String::from_utf8(text).map_err(|_| invalid("damaged: a label"))
    }

    fn get_scalars<T: Real>(&mut self, values: &mut [T]) -> io::Result<()> {
        let mut bytes = vec![0; CHUNK.min(values.len()) * size_of::<T>()];
        for chunk in values.chunks_mut(CHUNK) {
            let bytes = &mut bytes[..size_of_val(chunk)];
            self.get(bytes)?;
            match size_of::<T>() {
                4 => convert(chunk, bytes, |b| f64::from(f32::from_le_bytes(b))),
                _ => convert(chunk, bytes, f64::from_le_bytes),
            }
        }
        Ok(())
    }

    fn get_check(&mut self) -> io::Result<()> {
        let sum = self.check.clone().finalize();
        if u32::from_le_bytes(self.bytes()?) != sum {
            return Err(invalid("damaged: its checksum is another"));
        }
        self.check.reset();
        Ok(())
    }
}

fn convert<T: Real, const N: usize>(
    values: &mut [T],
    bytes: &[u8],
    number: impl Fn([u8; N]) -> f64,
) {
    for (value, &bytes) in values.iter_mut().zip(bytes.as_chunks().0) {
        *value = T::from_f64(number(bytes));
    }
}
