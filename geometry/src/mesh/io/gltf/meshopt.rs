//! Buffer views that EXT_meshopt_compression packs.
//!
//! Source: "EXT_meshopt_compression" (Khronos): appendix A has the three streams, appendix B the
//! filters.

use super::super::draft::{Checked, roomy};
use super::document::Packed;
use catamaran::base::push;

/// The name of the extension.
pub(super) const NAME: &str = "EXT_meshopt_compression";

/// Bytes of elements in a block of attributes, and elements in a group.
const BLOCK: usize = 8192;
const GROUP: usize = 16;

/// Least number of bytes of the tail of attributes, which ends with the first element.
const TAIL: usize = 32;

/// Returns the bytes of a buffer view, of which `data` is the stream.
pub(super) fn unpacked(about: &Packed, data: &[u8]) -> Checked<Vec<u8>> {
    let (stride, count) = (about.byte_stride, about.count);
    let filter = about.filter.as_deref().unwrap_or("NONE");
    let mut bytes = match about.mode.as_str() {
        "ATTRIBUTES" => attributes(data, count, stride)?,
        "TRIANGLES" => stored(&triangles(data, count)?, stride)?,
        "INDICES" => stored(&indices(data, count)?, stride)?,
        other => return Err(format!("unknown mode {other:?} of {NAME}").into()),
    };
    match (about.mode.as_str(), filter, stride) {
        (_, "NONE", _) => {}
        ("ATTRIBUTES", "OCTAHEDRAL", 4) => octahedral::<1>(&mut bytes),
        ("ATTRIBUTES", "OCTAHEDRAL", 8) => octahedral::<2>(&mut bytes),
        ("ATTRIBUTES", "QUATERNION", 8) => quaternion(&mut bytes),
        ("ATTRIBUTES", "EXPONENTIAL", _) => exponential(&mut bytes),
        (mode, ..) => {
            let what = format!("filter {filter:?} of {NAME} for {stride} bytes in mode {mode}");
            return Err(format!("unknown {what}").into());
        }
    }
    Ok(bytes)
}

/// Bytes that are taken from the front.
struct Stream<'a>(&'a [u8]);

impl<'a> Stream<'a> {
    /// Returns the stream between a first byte that says its format and a tail, and the tail.
    fn open(data: &'a [u8], head: u8, tail: usize) -> Checked<(Self, &'a [u8])> {
        match data.split_first() {
            Some((&first, rest)) if first == head => {
                let length = rest.len().checked_sub(tail).ok_or("truncated")?;
                let (body, tail) = rest.split_at(length);
                Ok((Self(body), tail))
            }
            Some((first, _)) => {
                Err(format!("begins with byte {first:#x}, where {head:#x} is supported").into())
            }
            None => Err("truncated".into()),
        }
    }

    fn take(&mut self, count: usize) -> Checked<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("truncated")?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Checked<u8> {
        Ok(self.take(1)?[0])
    }

    /// Takes a number whose bytes have seven bits each, the lowest first.
    fn number(&mut self) -> Checked<u32> {
        let mut value = 0u32;
        for shift in (0..32).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("a number of more than 32 bits".into())
    }

    fn end(&self) -> Checked<()> {
        match self.0.len() {
            0 => Ok(()),
            left => Err(format!("{left} bytes come after the last element").into()),
        }
    }
}

/// Returns `count` elements of `stride` bytes.
fn attributes(data: &[u8], count: usize, stride: usize) -> Checked<Vec<u8>> {
    if !(4..=256).contains(&stride) || !stride.is_multiple_of(4) {
        return Err(format!("elements of {stride} bytes").into());
    }
    let (mut stream, tail) = Stream::open(data, 0xa0, stride.max(TAIL))?;
    let mut last = tail[tail.len() - stride..].to_vec();
    let most = ((BLOCK / stride) & !(GROUP - 1)).min(256);
    let mut bytes: Vec<u8> = Vec::new();
    let mut left = count;
    while left > 0 {
        let elements = left.min(most);
        left -= elements;
        let start = bytes.len();
        for _ in 0..elements * stride {
            push(&mut bytes, 0)?;
        }
        let block = &mut bytes[start..];
        let groups = elements.div_ceil(GROUP);
        for (k, last) in last.iter_mut().enumerate() {
            let modes = stream.take(groups.div_ceil(4))?;
            for group in 0..groups {
                let deltas = group_of(&mut stream, (modes[group / 4] >> (2 * (group % 4))) & 3)?;
                let own = block.chunks_exact_mut(stride).skip(GROUP * group);
                for (element, delta) in own.zip(deltas) {
                    *last = last.wrapping_add((delta >> 1) ^ (delta & 1).wrapping_neg());
                    element[k] = *last;
                }
            }
        }
    }
    stream.end()?;
    Ok(bytes)
}

/// Returns the differences of a group: zeros, of 2 or 4 bits (all of them set: a byte behind them),
/// or of bytes.
fn group_of(stream: &mut Stream<'_>, mode: u8) -> Checked<[u8; GROUP]> {
    let mut deltas = [0; GROUP];
    let bits = match mode {
        0 => return Ok(deltas),
        1 => 2,
        2 => 4,
        _ => {
            deltas.copy_from_slice(stream.take(GROUP)?);
            return Ok(deltas);
        }
    };
    let (each, largest) = (8 / bits, u8::MAX >> (8 - bits));
    let short = stream.take(GROUP / each)?;
    for (i, delta) in deltas.iter_mut().enumerate() {
        *delta = (short[i / each] >> (8 - bits * (i % each + 1))) & largest;
        if *delta == largest {
            *delta = stream.byte()?;
        }
    }
    Ok(deltas)
}

/// The last 16 items.
struct Recent<T> {
    items: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { items: [T::default(); 16], next: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.next % 16] = item;
        self.next += 1;
    }

    /// Returns the item before the last `age` ones, of which there may be 15.
    fn get(&self, age: u8) -> T {
        self.items[(self.next + 15 - usize::from(age)) % 16]
    }
}

/// What is known of the triangles so far.
struct Triangles<'a> {
    extra: Stream<'a>,
    /// The next new vertex, and the last one that was given by its number.
    next: u32,
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

impl Triangles<'_> {
    fn new_vertex(&mut self) -> u32 {
        self.next = self.next.wrapping_add(1);
        self.next.wrapping_sub(1)
    }

    fn given(&mut self) -> Checked<u32> {
        let delta = self.extra.number()?;
        self.last = self.last.wrapping_add((delta >> 1) ^ (delta & 1).wrapping_neg());
        Ok(self.last)
    }

    /// Returns a vertex of half a byte: new, recent or given.
    fn vertex(&mut self, code: u8) -> Checked<u32> {
        match code {
            0 => Ok(self.new_vertex()),
            15 => self.given(),
            recent => Ok(self.vertices.get(recent - 1)),
        }
    }

    /// Returns the triangle at a recent edge.
    fn at_edge(&mut self, edge: u8, code: u8) -> Checked<[u32; 3]> {
        let [a, b] = self.edges.get(edge);
        let c = match code {
            0 => self.new_vertex(),
            13 | 14 => {
                let step = if code == 13 { u32::MAX } else { 1 };
                self.last = self.last.wrapping_add(step);
                self.last
            }
            15 => self.given()?,
            recent => self.vertices.get(recent),
        };
        if matches!(code, 0 | 13..=15) {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// Returns a triangle whose second and third vertex are those of `code`.
    fn apart(&mut self, is_given: bool, code: u8) -> Checked<[u32; 3]> {
        let [second, third] = [code >> 4, code & 15];
        let a = if is_given { self.given()? } else { self.new_vertex() };
        let b = self.vertex(second)?;
        let c = self.vertex(third)?;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        self.vertices.push(a);
        for (vertex, code) in [(b, second), (c, third)] {
            if matches!(code, 0 | 15) {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }
}

/// Returns the `count` vertices of triangles.
fn triangles(data: &[u8], count: usize) -> Checked<Vec<u32>> {
    if !count.is_multiple_of(3) {
        return Err(format!("{count} corners are no triangles").into());
    }
    let (mut stream, table) = Stream::open(data, 0xe1, 16)?;
    if table.iter().any(|entry| entry >> 4 == 15 || entry & 15 == 15) {
        return Err("a broken table of codes".into());
    }
    let codes = stream.take(count / 3)?;
    let (edges, vertices) = (Recent::new(), Recent::new());
    let mut state = Triangles { extra: stream, next: 0, last: 0, edges, vertices };
    let mut corners = roomy(count);
    for &code in codes {
        let triangle = match (code >> 4, code & 15) {
            (15, 14 | 15) => {
                let vertices = state.extra.byte()?;
                if vertices == 0 {
                    state.next = 0;
                }
                state.apart(code == 0xff, vertices)?
            }
            (15, entry) => state.apart(false, table[usize::from(entry)])?,
            (edge, third) => state.at_edge(edge, third)?,
        };
        for corner in triangle {
            push(&mut corners, corner)?;
        }
    }
    state.extra.end()?;
    Ok(corners)
}

/// Returns `count` numbers, each of which is given by its difference to one of two before.
fn indices(data: &[u8], count: usize) -> Checked<Vec<u32>> {
    let (mut stream, _) = Stream::open(data, 0xd1, 4)?;
    let mut last = [0u32; 2];
    let mut numbers = roomy(count);
    for _ in 0..count {
        let code = stream.number()?;
        let base = &mut last[(code & 1) as usize];
        let delta = (code >> 2) ^ ((code >> 1) & 1).wrapping_neg();
        *base = base.wrapping_add(delta);
        push(&mut numbers, *base)?;
    }
    stream.end()?;
    Ok(numbers)
}

/// Returns numbers of 2 or 4 bytes.
fn stored(numbers: &[u32], stride: usize) -> Checked<Vec<u8>> {
    if !matches!(stride, 2 | 4) {
        return Err(format!("numbers of vertices of {stride} bytes").into());
    }
    let mut bytes = roomy(numbers.len() * stride);
    for number in numbers {
        let own = number.to_le_bytes();
        if own[stride..].iter().any(|&byte| byte != 0) {
            return Err(format!("vertex {number} does not fit into {stride} bytes").into());
        }
        for &byte in &own[..stride] {
            push(&mut bytes, byte)?;
        }
    }
    Ok(bytes)
}

/// Replaces each four signed integers of `N` bytes by what `filter` makes of them.
fn each<const N: usize>(bytes: &mut [u8], filter: impl Fn([f64; 4]) -> [f64; 4]) {
    let shift = 32 - 8 * N;
    for element in bytes.chunks_exact_mut(4 * N) {
        let mut values = [0.0; 4];
        for (value, own) in values.iter_mut().zip(element.chunks_exact(N)) {
            let mut wide = [0; 4];
            wide[4 - N..].copy_from_slice(own);
            *value = f64::from(i32::from_le_bytes(wide) >> shift);
        }
        for (own, value) in element.chunks_exact_mut(N).zip(filter(values)) {
            own.copy_from_slice(&(value.round() as i32).to_le_bytes()[..N]);
        }
    }
}

/// Decodes unit vectors, of integers of `N` bytes; the fourth number stays.
fn octahedral<const N: usize>(bytes: &mut [u8]) {
    let full = f64::from((1u32 << (8 * N - 1)) - 1);
    each::<N>(bytes, |[x, y, one, fourth]| {
        let (x, y) = (x / one, y / one);
        let z = 1.0 - x.abs() - y.abs();
        // The lower half is folded outwards.
        let below = z.min(0.0);
        let (x, y) = (x - below.copysign(x), y - below.copysign(y));
        let length = (x * x + y * y + z * z).sqrt();
        [x / length * full, y / length * full, z / length * full, fourth]
    });
}

/// Decodes unit quaternions without their largest number, whose place the last two bits have.
fn quaternion(bytes: &mut [u8]) {
    each::<2>(bytes, |[x, y, z, last]| {
        let bits = last as i32;
        let scale = std::f64::consts::FRAC_1_SQRT_2 / f64::from(bits | 3);
        let [x, y, z] = [x, y, z].map(|value| value * scale);
        let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let mut turned = [0.0; 4];
        for (i, value) in [largest, x, y, z].into_iter().enumerate() {
            turned[((bits & 3) as usize + i) % 4] = value * f64::from(i16::MAX);
        }
        turned
    });
}

/// Numbers of single precision: an exponent of 8 bits and a mantissa of 24.
fn exponential(bytes: &mut [u8]) {
    for own in bytes.as_chunks_mut::<4>().0 {
        let bits = i32::from_le_bytes(*own);
        let value = f64::from((bits << 8) >> 8) * 2f64.powi(bits >> 24);
        *own = (value as f32).to_le_bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::families;
    use crate::mesh::io::draft::Fault;

    fn said<T>(read: Checked<T>) -> Result<T, String> {
        read.map_err(|fault| match fault {
            Fault::What(what) => what,
            Fault::Error(error) => error.to_string(),
        })
    }

    /// Packs a group in 2 or 4 bits for each number.
    fn short(deltas: &[u8], bits: usize) -> Vec<u8> {
        let largest = u8::MAX >> (8 - bits);
        let joined = |own: &[u8]| own.iter().fold(0u8, |all, &d| (all << bits) | d.min(largest));
        let mut bytes: Vec<u8> = deltas.chunks(8 / bits).map(joined).collect();
        bytes.extend(deltas.iter().filter(|&&d| d >= largest));
        bytes
    }

    fn packed_attributes(bytes: &[u8], stride: usize) -> Vec<u8> {
        let mut last = bytes[..stride].to_vec();
        let mut packed = vec![0xa0];
        for block in bytes.chunks(((8192 / stride) & !15).min(256) * stride) {
            for (k, last) in last.iter_mut().enumerate() {
                let (mut heads, mut groups) = (Vec::<u8>::new(), Vec::<u8>::new());
                for (g, group) in block.chunks(16 * stride).enumerate() {
                    let mut deltas = [0u8; 16];
                    for (delta, element) in deltas.iter_mut().zip(group.chunks(stride)) {
                        let change = element[k].wrapping_sub(*last);
                        *delta = (change << 1) ^ (change >> 7).wrapping_neg();
                        *last = element[k];
                    }
                    let zeros = if deltas == [0; 16] { vec![] } else { vec![0; 99] };
                    let forms = [zeros, short(&deltas, 2), short(&deltas, 4), deltas.to_vec()];
                    let mode = (0..4).min_by_key(|&mode| forms[mode].len()).unwrap();
                    if g % 4 == 0 {
                        heads.push(0);
                    }
                    heads[g / 4] |= (mode as u8) << (2 * (g % 4));
                    groups.extend(&forms[mode]);
                }
                packed.extend(heads);
                packed.extend(groups);
            }
        }
        packed.resize(packed.len() + 32usize.saturating_sub(stride), 0);
        packed.extend(&bytes[..stride]);
        packed
    }

    #[test]
    fn attributes_come_back_from_each_form_of_a_group() {
        for stride in [4, 12, 256] {
            for count in [1, 16, 17, 300, 700] {
                let byte = |at: usize| {
                    let (i, k) = (at / stride, at % stride);
                    [7, i, i / 3 * (k + 1), i * i * 37 + k * i][k % 4] as u8
                };
                let bytes: Vec<u8> = (0..count * stride).map(byte).collect();
                let packed = packed_attributes(&bytes, stride);
                assert!(said(attributes(&packed, count, stride)) == Ok(bytes), "{stride}, {count}");
                for length in 0..packed.len().min(100) {
                    assert!(attributes(&packed[..length], count, stride).is_err(), "{length}");
                }
            }
        }
        // The example of the specification.
        let group = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let found = said(group_of(&mut Stream(&group), 2)).unwrap();
        let found = found.map(|d| ((d >> 1) ^ (d & 1).wrapping_neg()) as i8);
        assert_eq!(found, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        // A small stream announces much.
        assert_eq!(said(attributes(&[0xa0; 99], usize::MAX / 8, 4)), Err("truncated".into()));
        assert!(said(attributes(&[0xa1; 99], 1, 4)).unwrap_err().contains("byte 0xa1"));
    }

    fn push_number(bytes: &mut Vec<u8>, mut number: u32) {
        while number >= 0x80 {
            bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        bytes.push(number as u8);
    }

    fn push_change(bytes: &mut Vec<u8>, last: &mut u32, number: u32) {
        let change = number.wrapping_sub(*last) as i32;
        push_number(bytes, ((change << 1) ^ (change >> 31)) as u32);
        *last = number;
    }

    /// Packs triangles with each kind of code, and returns them as they come back: turned.
    fn packed_triangles(faces: &[[u32; 3]]) -> (Vec<u8>, Vec<u32>) {
        let table = [0x00, 0x10, 0x01, 0x21, 0x12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let (mut codes, mut extra, mut turned) = (vec![0xe1], Vec::new(), Vec::new());
        let (mut edges, mut vertices) = (Vec::new(), Vec::new());
        let (mut next, mut last) = (0u32, 0u32);
        for &[a, b, c] in faces {
            let age = |edge: [u32; 2]| edges.iter().rev().take(15).position(|e| *e == edge);
            let turns = [[a, b, c], [b, c, a], [c, a, b]];
            let known = turns.into_iter().find_map(|t| Some((age([t[0], t[1]])?, t)));
            if let Some((edge, [a, b, c])) = known {
                let recent = vertices.iter().rev().take(13).skip(1).position(|v| *v == c);
                let code = match recent {
                    _ if c == next => 0,
                    Some(age) => age as u8 + 1,
                    None if c == last.wrapping_sub(1) => 13,
                    None if c == last + 1 => 14,
                    None => 15,
                };
                match code {
                    0 => next += 1,
                    13 | 14 => last = c,
                    15 => push_change(&mut extra, &mut last, c),
                    _ => {}
                }
                codes.push((edge as u8) << 4 | code);
                edges.extend([[c, b], [a, c]]);
                if matches!(code, 0 | 13..=15) {
                    vertices.push(c);
                }
                turned.extend([a, b, c]);
                continue;
            }
            let is_new = a == next;
            next += u32::from(is_new);
            let halves = [b, c].map(|v| {
                if is_new && v == next {
                    next += 1;
                    return 0;
                }
                let age = vertices.iter().rev().take(14).position(|known| *known == v);
                age.map_or(15, |age| age as u8 + 1)
            });
            let both = halves[0] << 4 | halves[1];
            match table[..5].iter().position(|entry| is_new && *entry == both) {
                Some(entry) => codes.push(0xf0 | entry as u8),
                None => {
                    codes.push(if is_new { 0xfe } else { 0xff });
                    extra.push(both);
                }
            }
            if !is_new {
                push_change(&mut extra, &mut last, a);
            }
            vertices.push(a);
            for (v, half) in [b, c].into_iter().zip(halves) {
                if half == 15 {
                    push_change(&mut extra, &mut last, v);
                }
                if matches!(half, 0 | 15) {
                    vertices.push(v);
                }
            }
            edges.extend([[b, a], [c, b], [a, c]]);
            turned.extend([a, b, c]);
        }
        ([codes, extra, table.to_vec()].concat(), turned)
    }

    #[test]
    fn triangles_come_back_in_any_order() {
        let faces = families::icosphere(2).unwrap().into_parts().1;
        let count = faces.len();
        let strided: Vec<[u32; 3]> = (0..count).map(|i| faces[i * 7 % count]).collect();
        // Vertices in the order of their first face, as programs store them.
        let mut order = Vec::new();
        let renumbered: Vec<[u32; 3]> = faces
            .iter()
            .map(|face| {
                face.map(|v| {
                    let at = order.iter().position(|known| *known == v).unwrap_or(order.len());
                    if at == order.len() {
                        order.push(v);
                    }
                    at as u32
                })
            })
            .collect();
        for faces in [&faces, &strided, &renumbered] {
            let (packed, turned) = packed_triangles(faces);
            assert_eq!(said(triangles(&packed, 3 * count)), Ok(turned));
            for length in 0..packed.len() {
                assert!(triangles(&packed[..length], 3 * count).is_err(), "{length}");
            }
        }
        assert!(triangles(&[0xe1; 40], 4).is_err());
        // The code that begins to count anew: two triangles of the same new vertices.
        let again = [&[0xe1, 0xf0, 0xfe, 0][..], &[0; 16]].concat();
        assert_eq!(said(triangles(&again, 6)), Ok(vec![0, 1, 2, 0, 1, 2]));
    }

    #[test]
    fn numbers_come_back_from_two_sequences() {
        let numbers: Vec<u32> = (0..99).flat_map(|i| [i / 2, 70_000 - 3 * i]).collect();
        let mut packed = vec![0xd1];
        let mut last = [0u32; 2];
        for (i, &number) in numbers.iter().enumerate() {
            let change = number.wrapping_sub(last[i % 2]) as i32;
            push_number(
                &mut packed,
                (((change << 1) ^ (change >> 31)) as u32) << 1 | (i % 2) as u32,
            );
            last[i % 2] = number;
        }
        packed.extend([0; 4]);
        let found = said(indices(&packed, numbers.len())).unwrap();
        assert_eq!(found, numbers);
        let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
        assert_eq!(said(stored(&found, 4)), Ok(bytes));
        assert_eq!(said(stored(&[1, 513], 2)), Ok(vec![1, 0, 1, 2]));
        assert!(said(stored(&found, 2)).unwrap_err().contains("vertex 70000 does not fit"));
        for length in 0..packed.len() {
            assert!(indices(&packed[..length], numbers.len()).is_err(), "{length}");
        }
        assert!(indices(&[0xd1, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0], 1).is_err());
    }

    #[test]
    fn filters_make_unit_vectors_rotations_and_floats() {
        let mut bytes = [0i8, 0, 127, 5, 7, 7, 7, 6, -7, 0, 7, 0].map(|x| x as u8);
        octahedral::<1>(&mut bytes);
        assert_eq!(bytes.map(|x| x as i8), [0, 0, 127, 5, 0, 0, -127, 6, -127, 0, 0, 0]);
        let words = |words: [i16; 4]| words.map(i16::to_le_bytes).concat();
        let mut bytes = words([0, -511, 511, 9]);
        octahedral::<2>(&mut bytes);
        assert_eq!(bytes, words([0, -32767, 0, 9]));
        for (packed, expected) in
            [([0, 0, 0, 0x7fff], [0, 0, 0, 32767]), ([0x7fff, 0, 0, 0x7ffc], [23170, 23170, 0, 0])]
        {
            let mut bytes = words(packed);
            quaternion(&mut bytes);
            assert_eq!(bytes, words(expected));
        }
        let mut bytes = [0xff00_0003u32, 0x02ff_fffb].map(u32::to_le_bytes).concat();
        exponential(&mut bytes);
        assert_eq!(bytes, [1.5f32, -20.0].map(f32::to_le_bytes).concat());
    }

    /// Streams of meshoptimizer (Python package meshopt 0.1.1).
    #[test]
    fn streams_of_another_program_are_read() {
        #[rustfmt::skip]
        let packed = [
            0xe1, 0xfe, 0x1e, 0x00, 0x1e, 0x00, 0x1e, 0x9e, 0x0e, 0x04, 0x1e, 0x03, 0x1e, 0x9e,
            0x0e, 0x03, 0x1e, 0x03, 0x1e, 0xff, 0xf0, 0x08, 0xcf, 0x0b, 0x7a, 0x00, 0x76, 0x87,
            0x56, 0x67, 0x78, 0xa9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0x00, 0x00,
        ];
        let expected = vec![
            0, 4, 1, 1, 4, 5, 1, 5, 2, 2, 5, 6, 2, 6, 3, 3, 6, 7, 5, 4, 8, 5, 8, 9, 5, 9, 6, 6, 9,
            10, 6, 10, 7, 7, 10, 11, 9, 8, 12, 9, 12, 13, 9, 13, 10, 10, 13, 14, 10, 14, 11, 11,
            14, 15, 9, 2, 70,
        ];
        assert_eq!(said(triangles(&packed, expected.len())), Ok(expected));
        #[rustfmt::skip]
        let mut packed = vec![
            0xa0, 0x05, 0x2a, 0xaa, 0xaa, 0xaa, 0xa0, 0x00, 0x00, 0x00, 0x00, 0x07, 0x00, 0x02,
            0x06, 0x0a, 0x0e, 0x12, 0x16, 0x1a, 0x1e, 0x22, 0x26, 0x2a, 0x2e, 0x32, 0x36, 0x3a,
            0xf0, 0x00, 0x00, 0x00, 0x3e, 0x42, 0x04, 0x80, 0x00, 0x00, 0x00, 0x06, 0x0d, 0xdd,
            0xdd, 0xdd, 0xdd, 0xdd, 0xdd, 0xdd, 0xf0, 0x00, 0x00, 0x00, 0x0d, 0x0d, 0x01, 0x00,
            0x01,
        ];
        packed.extend([0; 32]);
        packed.extend([0x2c, 0x01, 0x00, 0x00]);
        let row = |i: i16| [i, i * i, 300 - 7 * i, 0].map(i16::to_le_bytes).concat();
        let expected: Vec<u8> = (0..18).flat_map(row).collect();
        assert_eq!(said(attributes(&packed, 18, 8)), Ok(expected));
    }
}
