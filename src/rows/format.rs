//! An [`Accumulator`] as bytes, little-endian:
//!
//! - Preamble: `CATAACC` and a zero; version, u32; bytes of a scalar (4 or 8), u32.
//! - Head: its length in bytes, u32; columns, first and end of the strip, rows, expected rows and
//!   rows of a block, u64 each; flags, u8; number of labels, u32; for each label name and value, as
//!   length (u32) and UTF-8.
//! - Check: CRC-32 of everything before, u32.
//! - Body, floating point: sum of the weights, and of their sizes, f64; shift, n scalars, if given;
//!   sum of the shifted rows, n f64, if centred; each row of the strip up to the diagonal, scalars.
//! - Body, exact: of the grid, lower and upper bounds, shift if given, n scalars each; powers,
//!   n i32; bound of the weights, scalar, if given; exponent and power of the weights, i32. Then
//!   sum of the weights, and of their sizes, i128; number of rows of weight 0, i128, if there are
//!   some; sums of the columns, n i128, if centred; each row of the strip up to the diagonal, i128;
//!   what is not finite, u8 for each entry, if given.
//! - Check: CRC-32 of the body, u32.
//!
//! Flags: 1 centred, 2 shift given, 4 exact, 8 bound of the weights given, 16 some terms are not
//! finite, 32 extended precision (entries of 256 bits), 64 some entries were rounded there, 128
//! some rows have weight 0.
//!
//! No allocation depends on the head alone: vectors and C grow with the bytes that arrive, unless
//! the source is known to be as long as its head says.

use std::fmt::Display;
use std::io::{self, Read, Write};
use std::ops::Range;

use crc32fast::Hasher;

use super::accumulator::{Accumulator, Sums, check_strip};
use super::exact::ExactSums;
use super::float::FloatSums;
use super::grid::Grid;
use super::moments::Moments;
use super::strip::Strip;
use super::wide::SumInteger;
use crate::base::{Error, Real, reserved};
use crate::blas::BlasReal;
use crate::kernel::int8::I256;
use crate::product::exact::Flags;

const MAGIC: &[u8; 8] = b"CATAACC\0";

/// Version of this format; data of another version is rejected.
const VERSION: u32 = 2;

/// A longer head is not one of this format.
const LONGEST_HEAD: u32 = 1 << 20;

/// Most rows of a sum: the numbers of rows of two sums can be added without overflow.
const MOST_ROWS: u64 = 1 << 62;

/// Values converted at a time.
const CHUNK: usize = 1 << 13;

const CENTERED: u8 = 1;
const SHIFTED: u8 = 2;
const EXACT: u8 = 4;
const WEIGHTED: u8 = 8;
const NON_FINITE: u8 = 16;
const EXTENDED: u8 = 32;
const ROUNDED: u8 = 64;
const WEIGHTLESS: u8 = 128;

/// Returns the scalar of the accumulator at the start of `source`: `"f32"` or `"f64"`.
///
/// ```
/// use catamaran::rows::{Accumulator, scalar_of};
///
/// let mut bytes = Vec::new();
/// Accumulator::<f32>::new(3, false)?.write(&mut bytes).unwrap();
/// assert_eq!(scalar_of(&mut &bytes[..]).unwrap(), "f32");
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// Those of the source; [`io::ErrorKind::InvalidData`] when the bytes are not an accumulator, or
/// one of another version.
pub fn scalar_of(source: &mut dyn Read) -> io::Result<&'static str> {
    preamble(&mut Checked::new(source))
}

/// Returns the number of rows in the accumulator at the start of `source`, and its labels.
///
/// # Errors
/// As [`scalar_of`]; [`io::ErrorKind::InvalidData`] when the head is damaged.
pub(crate) fn labels_of(source: &mut dyn Read) -> io::Result<(u64, Vec<(String, String)>)> {
    let mut source = Checked::new(source);
    preamble(&mut source)?;
    let head = Head::read(&mut source)?;
    Ok((head.numbers[3], head.labels))
}

/// The head of an accumulator.
struct Head {
    /// Columns, first and end of the strip, rows, expected rows and rows of a block.
    numbers: [u64; 6],
    flags: u8,
    labels: Vec<(String, String)>,
}

impl Head {
    /// Reads the head after the preamble, and its checksum.
    fn read(source: &mut Checked<&mut dyn Read>) -> io::Result<Self> {
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
        let [flags] = head.bytes()?;
        let mut labels = Vec::new();
        for _ in 0..head.number()? {
            labels.push((head.text()?, head.text()?));
        }
        if !head.stream.is_empty() {
            return Err(invalid("damaged: its head"));
        }
        Ok(Self { numbers, flags, labels })
    }
}

fn flag(flag: u8, set: bool) -> u8 {
    if set { flag } else { 0 }
}

fn flags_of<T, I>(sums: &ExactSums<T, I>) -> u8 {
    flag(SHIFTED, !sums.grid.shift.is_empty())
        | flag(WEIGHTED, sums.grid.weight.is_some())
        | flag(NON_FINITE, !sums.flags.is_empty())
        | flag(ROUNDED, sums.rounded)
        | flag(WEIGHTLESS, sums.weightless > 0)
}

impl<T: BlasReal> Accumulator<T> {
    /// Writes the accumulator, for [`Accumulator::read`].
    ///
    /// ```
    /// use catamaran::{AtaOptions, Uplo, rows::Accumulator, faer::mat};
    ///
    /// let mut sum = Accumulator::<f64>::new(2, false)?;
    /// sum.add_block(mat![[1.0, 2.0]], None, &AtaOptions::new())?;
    /// let mut bytes = Vec::new();
    /// sum.write(&mut bytes).unwrap();
    /// let sum = Accumulator::<f64>::read(&mut &bytes[..]).unwrap();
    /// assert_eq!(sum.finish(1.0, Uplo::Lower)?.as_ref()[(1, 0)], 2.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of the sink; [`io::ErrorKind::InvalidInput`], before a byte is written, when the
    /// labels take more than about 1 MiB.
    pub fn write(&self, sink: &mut dyn Write) -> io::Result<()> {
        let (head, strip) = (self.head()?, self.strip());
        let mut sink = Checked::new(sink);
        sink.put(MAGIC)?;
        sink.put(&VERSION.to_le_bytes())?;
        sink.put(&(size_of::<T>() as u32).to_le_bytes())?;
        sink.put(&head)?;
        sink.put_check()?;
        match &self.sums {
            Sums::Float(sums) => {
                sink.put_all(&[sums.moments.weight, sums.moments.weight_size])?;
                sink.put_all(&sums.moments.shift)?;
                sink.put_all(&sums.moments.sum)?;
                for i in 0..strip.len() {
                    sink.put_all(sums.c.lower_row(i))?;
                }
            }
            Sums::Exact(sums) => put_exact(&mut sink, sums)?,
            Sums::Extended(sums) => put_exact(&mut sink, sums)?,
        }
        sink.put_check()
    }

    /// Returns the length of the head, and the head.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] for what [`Accumulator::read`] refuses.
    pub(crate) fn head(&self) -> io::Result<Vec<u8>> {
        let (strip, rows) = (self.strip(), [self.rows(), self.expected_rows, self.block_rows]);
        if let Some(rows) = rows.iter().find(|&&rows| rows > MOST_ROWS) {
            let what = format!("{rows} rows are more than a file can have, {MOST_ROWS}");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        let mut head = Vec::new();
        let numbers = [self.ncols, strip.start, strip.end].map(|number| number as u64);
        numbers.iter().chain(&rows).for_each(|number| head.extend(number.to_le_bytes()));
        head.push(
            match &self.sums {
                Sums::Float(sums) => flag(SHIFTED, !sums.moments.shift.is_empty()),
                Sums::Exact(sums) => EXACT | flags_of(sums),
                Sums::Extended(sums) => EXACT | EXTENDED | flags_of(sums),
            } | flag(CENTERED, self.is_centered()),
        );
        let mut texts = Vec::new();
        for (name, value) in &self.labels {
            for text in [name, value] {
                texts.extend(stored_length(format_args!("label {name:.32}"), text.len())?);
                texts.extend(text.as_bytes());
            }
        }
        // There are fewer labels than bytes of them.
        stored_length("all labels", texts.len())?;
        head.extend(stored_length("all labels", self.labels.len())?);
        head.extend(texts);
        let length = stored_length("all labels", head.len())?;
        Ok([&length[..], &head[..]].concat())
    }

    /// Reads an accumulator that [`Accumulator::write`] wrote, bit for bit.
    ///
    /// # Errors
    /// Those of the source; [`io::ErrorKind::InvalidData`] when the bytes are cut off or damaged,
    /// or not an accumulator of T in this version; [`io::ErrorKind::OutOfMemory`].
    pub fn read(source: &mut dyn Read) -> io::Result<Self> {
        Self::read_within(source, u64::MAX)
    }

    /// Reads as [`Accumulator::read`] does, from a source of at most `bytes` bytes. A head that
    /// announces more is rejected before memory is allocated.
    pub(crate) fn read_within(source: &mut dyn Read, bytes: u64) -> io::Result<Self> {
        let mut source = Checked::new(source);
        let scalar = preamble(&mut source)?;
        if scalar != T::NAME {
            return Err(invalid(format!("an accumulator of {scalar}, not of {}", T::NAME)));
        }
        let Head { numbers, flags, labels } = Head::read(&mut source)?;
        let has = |flag: u8| flags & flag != 0;
        let fits = |number: u64| usize::try_from(number).map_err(|_| invalid("damaged: its shape"));
        let [ncols, first, end] = [fits(numbers[0])?, fits(numbers[1])?, fits(numbers[2])?];
        let [rows, expected_rows, block_rows] = [numbers[3], numbers[4], numbers[5]];
        if numbers[3..].iter().any(|&rows| rows > MOST_ROWS) {
            return Err(invalid("damaged: its numbers of rows"));
        }
        let strip = first..end;
        check_strip(&strip, ncols).map_err(|_| invalid("damaged: its strip"))?;
        let triangle = |rows: usize| rows as u128 * (rows as u128 + 1) / 2;
        let len = triangle(end) - triangle(first);
        let entry = match (has(EXACT), has(EXTENDED)) {
            (false, false) => size_of::<T>(),
            (true, false) => i128::BYTES,
            (true, true) => I256::BYTES,
            (false, true) => return Err(invalid("damaged: its head")),
        };
        if len.saturating_mul(entry as u128) > bytes.into() {
            return Err(invalid("truncated: it ends too early"));
        }
        let n_if = |flag: u8| if has(flag) { ncols } else { 0 };
        let sums = if has(EXTENDED) {
            Sums::Extended(get_exact(&mut source, ncols, strip, flags, rows)?)
        } else if has(EXACT) {
            Sums::Exact(get_exact(&mut source, ncols, strip, flags, rows)?)
        } else {
            let (weight, weight_size): (f64, f64) = (source.value()?, source.value()?);
            // The two are rounded differently.
            if !weight_size.is_finite() || weight.is_nan() || weight.abs() > 1.001 * weight_size {
                return Err(invalid("damaged: its weights"));
            }
            let shift = source.get_vec(n_if(SHIFTED))?;
            let sum = source.get_vec(n_if(CENTERED))?;
            let centered = has(CENTERED);
            let moments = Moments { rows, weight, weight_size, centered, shift, sum };
            let c = get_strip(&mut source, strip, bytes != u64::MAX)?;
            Sums::Float(FloatSums { c, moments })
        };
        source.get_check()?;
        if source.stream.read(&mut [0])? != 0 {
            return Err(invalid("damaged: data after its end"));
        }
        Ok(Self { expected_rows, block_rows, labels, ..Self::of(ncols, sums) })
    }
}

/// Reads the rows of C; `is_long` tells that they are known to be in the source.
fn get_strip<T: BlasReal>(
    source: &mut Checked<&mut dyn Read>,
    strip: Range<usize>,
    is_long: bool,
) -> io::Result<Strip<T>> {
    let len = strip.len().saturating_mul(strip.end);
    let mut values = reserved(if is_long { len } else { 0 }).map_err(no_memory)?;
    for i in strip.clone() {
        source.append(&mut values, i + 1)?;
        let above = strip.end - i - 1;
        values.try_reserve(above).map_err(|_| {
            no_memory(Error::OutOfMemory { bytes: len.saturating_mul(size_of::<T>()) })
        })?;
        values.resize(values.len() + above, T::ZERO);
    }
    Ok(Strip::from_rows(strip, values))
}

fn put_exact<T: BlasReal, I: Value>(
    sink: &mut Checked<&mut dyn Write>,
    sums: &ExactSums<T, I>,
) -> io::Result<()> {
    let Grid { lower, upper, shift, powers, extended: _, weight, weight_exponent, weight_power } =
        &sums.grid;
    for values in [lower, upper, shift] {
        sink.put_all(values)?;
    }
    sink.put_all(powers)?;
    sink.put_all(weight.as_slice())?;
    sink.put_all(&[*weight_exponent, *weight_power])?;
    sink.put_all(&sums.weights)?;
    if sums.weightless > 0 {
        sink.put_all(&[i128::from(sums.weightless)])?;
    }
    sink.put_all(&sums.sums)?;
    sink.put_all(&sums.entries)?;
    sink.put(&sums.flags)
}

fn get_exact<T: BlasReal, I: Value + SumInteger>(
    source: &mut Checked<&mut dyn Read>,
    ncols: usize,
    strip: Range<usize>,
    flags: u8,
    rows: u64,
) -> io::Result<ExactSums<T, I>> {
    let has = |flag: u8| flags & flag != 0;
    let n_if = |flag: u8| if has(flag) { ncols } else { 0 };
    let grid = Grid {
        lower: source.get_vec(ncols)?,
        upper: source.get_vec(ncols)?,
        shift: source.get_vec(n_if(SHIFTED))?,
        powers: source.get_vec(ncols)?,
        extended: I::EXTENDED,
        weight: source.get_vec(has(WEIGHTED).into())?.pop(),
        weight_exponent: source.value()?,
        weight_power: source.value()?,
    };
    if !grid.is_sound() {
        return Err(invalid("damaged: its grid"));
    }
    let weights = [source.value()?, source.value()?];
    let weightless = match has(WEIGHTLESS) {
        true => source.value::<i128>()?,
        false => 0,
    };
    // None are not written.
    let weightless = u64::try_from(weightless).ok().filter(|&n| (n > 0) == has(WEIGHTLESS));
    let weightless = weightless.ok_or_else(|| invalid("damaged: its rows of weight 0"))?;
    let sums = source.get_vec(n_if(CENTERED))?;
    let mut entries = Vec::new();
    for i in strip.clone() {
        source.append(&mut entries, i + 1)?;
    }
    let mut flags = vec![];
    if has(NON_FINITE) {
        source.append(&mut flags, entries.len())?;
        if flags.iter().any(|&flags| flags > Flags::MOST) {
            return Err(invalid("damaged: its flags of terms that are not finite"));
        }
    }
    let (centered, rounded) = (has(CENTERED), has(ROUNDED));
    let read = ExactSums {
        grid,
        strip,
        centered,
        rows,
        weightless,
        weights,
        sums,
        entries,
        flags,
        rounded,
    };
    if !read.is_sound() {
        return Err(invalid("damaged: sums that its rows can't have"));
    }
    Ok(read)
}

/// Returns a length of the head as it is stored; the error says that `what` is too long.
fn stored_length(what: impl Display, length: usize) -> io::Result<[u8; 4]> {
    match u32::try_from(length) {
        Ok(length) if length <= LONGEST_HEAD => Ok(length.to_le_bytes()),
        _ => {
            let what = format!("{what}: {length} bytes, but a file has room for {LONGEST_HEAD}");
            Err(io::Error::new(io::ErrorKind::InvalidInput, what))
        }
    }
}

fn no_memory(e: Error) -> io::Error {
    io::Error::new(io::ErrorKind::OutOfMemory, e.to_string())
}

/// A number with a fixed representation in bytes.
trait Value: Copy {
    const BYTES: usize = size_of::<Self>();
    fn put(self, bytes: &mut Vec<u8>);
    fn get(bytes: &[u8]) -> Self;
}

macro_rules! values {
    ($($t:ident)*) => {
        $(impl Value for $t {
            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }

            fn get(bytes: &[u8]) -> Self {
                Self::from_le_bytes(bytes.try_into().expect("as many bytes as it has"))
            }
        })*
    };
}
values!(u8 i32 i128 u128);

impl Value for I256 {
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.low.to_le_bytes());
        bytes.extend(self.high.to_le_bytes());
    }

    fn get(bytes: &[u8]) -> Self {
        let (low, high) = bytes.split_at(u128::BYTES);
        Self { high: i128::get(high), low: u128::get(low) }
    }
}

impl<T: Real> Value for T {
    fn put(self, bytes: &mut Vec<u8>) {
        // An f32 is converted to f64 and back without a change.
        match size_of::<T>() {
            4 => bytes.extend((self.to_f64() as f32).to_le_bytes()),
            _ => bytes.extend(self.to_f64().to_le_bytes()),
        }
    }

    fn get(bytes: &[u8]) -> Self {
        let all = |bytes: &[u8]| bytes.try_into().expect("as many bytes as it has");
        match bytes.try_into() {
            Ok(bytes) => T::from_f64(f32::from_le_bytes(bytes).into()),
            Err(_) => T::from_f64(f64::from_le_bytes(all(bytes))),
        }
    }
}

fn preamble<S: Read>(source: &mut Checked<S>) -> io::Result<&'static str> {
    if &source.bytes()? != MAGIC {
        return Err(invalid("not an accumulator of catamaran"));
    }
    let version = source.number()?;
    if version != VERSION {
        let what = format!("an accumulator of version {version}, but {VERSION} is supported");
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

/// A stream, and the checksum of the bytes that went through it.
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

    fn put_all<V: Value>(&mut self, values: &[V]) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(CHUNK.min(values.len()) * V::BYTES);
        for chunk in values.chunks(CHUNK) {
            bytes.clear();
            chunk.iter().for_each(|value| value.put(&mut bytes));
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

    fn value<V: Value>(&mut self) -> io::Result<V> {
        let mut bytes = [0; I256::BYTES];
        self.get(&mut bytes[..V::BYTES])?;
        Ok(V::get(&bytes[..V::BYTES]))
    }

    fn get_vec<V: Value>(&mut self, len: usize) -> io::Result<Vec<V>> {
        let mut values = Vec::new();
        self.append(&mut values, len)?;
        Ok(values)
    }

    /// Appends `len` values; memory grows with the bytes that arrive.
    fn append<V: Value>(&mut self, values: &mut Vec<V>, len: usize) -> io::Result<()> {
        let mut bytes = vec![0; CHUNK.min(len) * V::BYTES];
        let mut left = len;
        while left > 0 {
            let count = left.min(CHUNK);
            let bytes = &mut bytes[..count * V::BYTES];
            self.get(bytes)?;
            values.try_reserve(count).map_err(|_| {
                no_memory(Error::OutOfMemory { bytes: len.saturating_mul(V::BYTES) })
            })?;
            values.extend(bytes.chunks_exact(V::BYTES).map(V::get));
            left -= count;
        }
        Ok(())
    }

    fn get_check(&mut self) -> io::Result<()> {
        let sum = self.check.clone().finalize();
        if u32::from_le_bytes(self.bytes()?) != sum {
            return Err(invalid("damaged: its checksum differs"));
        }
        self.check.reset();
        Ok(())
    }
}
