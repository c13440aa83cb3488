//! Colours of files, converted to the range 0 to 1.

/// The note about colours that only some vertices have, and that are left out.
pub(super) const SOME_COLORS: &str = "left out colours, which only some of the vertices have";

/// Returns the colours of a file scaled to 0 to 1: colours with a number above 1 are taken to be
/// from 0 to 255.
pub(super) fn scaled_colors(mut colors: Vec<[f64; 4]>, explicit_opacity: bool) -> Vec<[f64; 4]> {
    let given = if explicit_opacity { 4 } else { 3 };
    if colors.iter().any(|color| color[..given].iter().any(|&x| x > 1.0)) {
        for x in colors.iter_mut().flat_map(|color| &mut color[..given]) {
            *x /= 255.0;
        }
    }
    colors
}

/// Returns the byte that is 255 times a colour; `None` where that is not a whole number.
pub(super) fn byte(x: f64) -> Option<u8> {
    let scaled = (x * 255.0).round();
    ((0.0..=255.0).contains(&scaled) && scaled / 255.0 == x).then_some(scaled as u8)
}
