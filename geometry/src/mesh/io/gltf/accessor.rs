//! Reads numbers from buffers.

use super::super::draft::{Checked, roomy};
use super::container::Content;
use super::document::{Accessor, View};
use super::layout::{Layout, component_size, width};
use catamaran::base::push;

impl Content {
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
        let accessor = self.accessor(number)?;
        let read = || -> Checked<Vec<[f64; N]>> {
            let width = width(&accessor.kind);
            if width != Some(N) {
                return Err(format!("type {:?} does not have {N} numbers", accessor.kind).into());
            }
            match self.decoded.get(&number) {
                Some(Ok(values)) => return Ok(values.as_chunks::<N>().0.to_vec()),
                Some(Err(what)) => return Err(what.as_str().into()),
                None => {}
            }
            let layout = Layout {
                component: accessor.component_type,
                normalized: accessor.normalized,
                count: accessor.count,
            };
            let mut values = match accessor.buffer_view {
                Some(view) => self.elements(view, accessor.byte_offset, &layout)?,
                None => {
                    let mut zeros = Vec::new();
                    for _ in 0..accessor.count {
                        push(&mut zeros, [0.0; N])?;
                    }
                    zeros
                }
            };
            let Some(sparse) = &accessor.sparse else { return Ok(values) };
            let indices = Layout {
                component: sparse.indices.component_type,
                normalized: false,
                count: sparse.count,
            };
            let places: Vec<[f64; 1]> =
                self.elements(sparse.indices.buffer_view, sparse.indices.byte_offset, &indices)?;
            let layout = Layout { count: sparse.count, ..layout };
            let replaced: Vec<[f64; N]> =
                self.elements(sparse.values.buffer_view, sparse.values.byte_offset, &layout)?;
            for ([place], value) in places.into_iter().zip(replaced) {
                let count = values.len();
                let slot = index(place).and_then(|place| values.get_mut(place));
                *slot.ok_or_else(|| format!("sparse element {place} exceeds {count}"))? = value;
            }
            Ok(values)
        };
        read().map_err(|fault| fault.of(|| format!("accessor {number}")))
    }

    /// Returns the elements that lie in a buffer view from byte `start` on.
    fn elements<const N: usize>(
        &self,
        view: usize,
        start: usize,
        layout: &Layout,
    ) -> Checked<Vec<[f64; N]>> {
        let views = &self.document.buffer_views;
        let (index, view) = (view, views.get(view));
        let view =
            view.ok_or_else(|| format!("view {index} is out of range: {} views", views.len()))?;
        let bytes = self.bytes(index, view)?;
        let size = component_size(layout.component)
            .ok_or_else(|| format!("unknown component type {}", layout.component))?;
        let stride = view.byte_stride.unwrap_or(N * size);
        if stride < N * size {
            return Err(format!("stride {stride} is less than {} bytes", N * size).into());
        }
        let mut values = roomy(layout.count);
        for i in 0..layout.count {
            let at = i.checked_mul(stride).and_then(|at| at.checked_add(start));
            let element = at.and_then(|at| bytes.get(at..)?.get(..N * size));
            let element = element
                .ok_or_else(|| format!("element {i} of {} is beyond view {index}", layout.count))?;
            let mut value = [0.0; N];
            for (x, bytes) in value.iter_mut().zip(element.chunks_exact(size)) {
                *x = layout.number(bytes);
            }
            push(&mut values, value)?;
        }
        Ok(values)
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
        let size = buffer.map_or(0, Vec::len);
        let beyond = || format!("view {number} is beyond its buffer, which has {size} bytes");
        Ok(own.ok_or_else(beyond)?)
    }
}

/// Returns a number as an index; `None` if it is negative or not whole.
pub(super) fn index(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0).then_some(number as usize)
}
