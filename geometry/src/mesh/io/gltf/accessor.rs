//! Reads numbers from buffers.

use std::array::from_fn;

use super::super::draft::Checked;
use super::super::stored::index;
use super::container::Content;
use super::document::{Accessor, View, code};
use super::layout::{Layout, component_size, width};
use catamaran::base::{repeated, reserved};

impl Content<'_> {
    /// Returns the accessor with this index.
    pub fn accessor(&self, index: usize) -> Checked<&Accessor> {
        let found = self.document.accessors.get(index);
        let count = self.document.accessors.len();
        Ok(found.ok_or_else(|| format!("accessor {index} is out of range: {count} accessors"))?)
    }

    /// Returns whether the file has numbers of an accessor; other accessors are all zeros, unless
    /// an extension says where their numbers are.
    pub fn is_stored(&self, index: usize) -> Checked<bool> {
        let accessor = self.accessor(index)?;
        let is_plain = accessor.buffer_view.is_some() || accessor.sparse.is_some();
        Ok(is_plain || self.decoded.contains_key(&index))
    }

    /// Returns the number of elements of an accessor: those that are unpacked, where it is packed.
    pub fn count(&self, index: usize) -> Checked<usize> {
        let accessor = self.accessor(index)?;
        let width = width(&accessor.kind).unwrap_or(1);
        match self.decoded.get(&index) {
            Some(Ok(values)) => Ok(values.len() / width),
            _ => Ok(accessor.count),
        }
    }

    /// Returns the elements of an accessor, of `N` numbers each.
    pub fn values<const N: usize>(&self, number: usize) -> Checked<Vec<[f64; N]>> {
        self.converted(number, |x| x)
    }

    /// Returns the numbers of an accessor as indices; [`NO_INDEX`](super::super::stored::NO_INDEX)
    /// for those that are none.
    pub fn indices(&self, number: usize) -> Checked<Vec<[u32; 1]>> {
        self.converted(number, index)
    }

    /// Returns the elements of an accessor, of `N` numbers each, which `of` converts.
    fn converted<T: Copy, const N: usize>(
        &self,
        number: usize,
        of: impl Fn(f64) -> T + Copy,
    ) -> Checked<Vec<[T; N]>> {
        let accessor = self.accessor(number)?;
        let read = || -> Checked<Vec<[T; N]>> {
            let width = width(&accessor.kind);
            if width != Some(N) {
                return Err(format!("type {:?} does not have {N} numbers", accessor.kind).into());
            }
            match self.decoded.get(&number) {
                Some(Ok(values)) => {
                    let (elements, _) = values.as_chunks::<N>();
                    let mut values = reserved(elements.len())?;
                    values.extend(elements.iter().map(|element| element.map(of)));
                    return Ok(values);
                }
                Some(Err(what)) => return Err(what.as_str().into()),
                None => {}
            }
            let layout = Layout {
                component: accessor.component_type,
                normalized: accessor.normalized,
                count: accessor.count,
            };
            let mut values = match accessor.buffer_view {
                Some(view) => self.elements(view, accessor.byte_offset, &layout, of)?,
                None => repeated([of(0.0); N], accessor.count)?,
            };
            let Some(sparse) = &accessor.sparse else { return Ok(values) };
            let indices = Layout {
                component: sparse.indices.component_type,
                normalized: false,
                count: sparse.count,
            };
            let (view, start) = (sparse.indices.buffer_view, sparse.indices.byte_offset);
            let places: Vec<[f64; 1]> = self.elements(view, start, &indices, |x| x)?;
            let layout = Layout { count: sparse.count, ..layout };
            let (view, start) = (sparse.values.buffer_view, sparse.values.byte_offset);
            let replaced: Vec<[T; N]> = self.elements(view, start, &layout, of)?;
            for ([place], value) in places.into_iter().zip(replaced) {
                let count = values.len();
                let slot = values.get_mut(index(place) as usize);
                *slot.ok_or_else(|| format!("sparse element {place} exceeds {count}"))? = value;
            }
            Ok(values)
        };
        read().map_err(|fault| fault.of(|| format!("accessor {number}")))
    }

    /// Returns the elements that lie in a buffer view from byte `start` on, whose numbers `of`
    /// converts.
    fn elements<T: Copy, const N: usize>(
        &self,
        view: usize,
        start: usize,
        layout: &Layout,
        of: impl Fn(f64) -> T + Copy,
    ) -> Checked<Vec<[T; N]>> {
        let views = &self.document.buffer_views;
        let (v, view) = (view, views.get(view));
        let view =
            view.ok_or_else(|| format!("view {v} is out of range: {} views", views.len()))?;
        let bytes = self.bytes(v, view)?;
        let unknown = || format!("unknown component type {}", layout.component);
        let size = component_size(layout.component).ok_or_else(unknown)?;
        let stride = view.byte_stride.unwrap_or(N * size);
        if stride < N * size {
            return Err(format!("stride {stride} is less than {} bytes", N * size).into());
        }
        let room = bytes.len().checked_sub(start).and_then(|room| room.checked_sub(N * size));
        let fitting = room.map_or(0, |room| room / stride + 1);
        if fitting < layout.count {
            let count = layout.count;
            return Err(format!("element {fitting} of {count} is beyond view {v}").into());
        }
        let bytes = bytes.get(start..).unwrap_or_default();
        // Each loop is compiled for a type of components.
        let typed = |component: u32| {
            let layout = Layout { component, ..*layout };
            move |bytes: &[u8]| of(layout.number(bytes))
        };
        match layout.component {
            code::I8 => gathered::<T, 1, N>(bytes, stride, layout.count, typed(code::I8)),
            code::U8 => gathered::<T, 1, N>(bytes, stride, layout.count, typed(code::U8)),
            code::I16 => gathered::<T, 2, N>(bytes, stride, layout.count, typed(code::I16)),
            code::U16 => gathered::<T, 2, N>(bytes, stride, layout.count, typed(code::U16)),
            code::U32 => gathered::<T, 4, N>(bytes, stride, layout.count, typed(code::U32)),
            code::F32 => gathered::<T, 4, N>(bytes, stride, layout.count, typed(code::F32)),
            _ => Err(unknown().into()),
        }
    }

    /// Returns the bytes of a view, unpacked.
    pub fn bytes(&self, number: usize, view: &View) -> Checked<&[u8]> {
        match self.unpacked.get(&number) {
            Some(Ok(bytes)) => return Ok(bytes),
            Some(Err(what)) => return Err(format!("view {number}: {what}").into()),
            None => {}
        }
        let buffer = self.buffers.get(view.buffer);
        let own = buffer.and_then(|all| all.get(view.byte_offset..)?.get(..view.byte_length));
        let size = buffer.map_or(0, |all| all.len());
        let beyond = || format!("view {number} is beyond its buffer, which has {size} bytes");
        Ok(own.ok_or_else(beyond)?)
    }
}

/// Returns `count` elements of `N` components of so many bytes, which begin `stride` bytes apart.
#[inline(always)]
fn gathered<T, const SIZE: usize, const N: usize>(
    bytes: &[u8],
    stride: usize,
    count: usize,
    of: impl Fn(&[u8]) -> T,
) -> Checked<Vec<[T; N]>> {
    let mut values = reserved(count)?;
    let element = |own: &[u8]| from_fn::<T, N, _>(|k| of(&own[k * SIZE..(k + 1) * SIZE]));
    if stride == N * SIZE {
        values.extend(bytes.chunks_exact(N * SIZE).take(count).map(element));
    } else {
        let elements = bytes.chunks(stride).take(count);
        values.extend(elements.map(|own| element(&own[..N * SIZE])));
    }
    Ok(values)
}
