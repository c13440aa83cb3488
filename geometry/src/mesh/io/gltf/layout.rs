//! How elements of accessors are stored.

use super::document::code;

/// Returns the number of components of an element of this type; `None` for matrices, which meshes
/// do not use.
pub(super) fn width(kind: &str) -> Option<usize> {
    Some(match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => return None,
    })
}

/// Returns the bytes of a component with this code.
pub(super) fn component_size(code: u32) -> Option<usize> {
    Some(match code {
        code::I8 | code::U8 => 1,
        code::I16 | code::U16 => 2,
        code::U32 | code::F32 => 4,
        _ => return None,
    })
}

/// The storage of elements.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub component: u32,
    /// Whether integers represent fractions of their maximum.
    pub normalized: bool,
    pub count: usize,
}

impl Layout {
    /// Returns the number in these bytes, as many as the component type has.
    #[inline(always)]
    pub fn number(&self, bytes: &[u8]) -> f64 {
        let mut wide = [0; 4];
        wide.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        let bits = u32::from_le_bytes(wide);
        let (value, one) = match self.component {
            code::I8 => (f64::from(bits as i8), f64::from(i8::MAX)),
            code::U8 => (f64::from(bits as u8), f64::from(u8::MAX)),
            code::I16 => (f64::from(bits as i16), f64::from(i16::MAX)),
            code::U16 => (f64::from(bits as u16), f64::from(u16::MAX)),
            code::F32 => return f64::from(f32::from_bits(bits)),
            _ => return f64::from(bits),
        };
        if self.normalized { (value / one).max(-1.0) } else { value }
    }
}
