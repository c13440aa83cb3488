//! Colours as files have them.

/// The note about colours that are no attribute of all vertices.
pub(super) const SOME_COLORS: &str = "left out colours, which only some of the vertices have";

/// The colours of a file, whose numbers are from 0 to 255 if one of them is above 1.
pub(super) fn scaled_colors(mut colors: Vec<[f64; 4]>, explicit_opacity: bool) -> Vec<[f64; 4]> {
    let given = if explicit_opacity { 4 } else { 3 };
    if colors.iter().any(|color| color[..given].iter().any(|&x| x > 1.0)) {
        for x in colors.iter_mut().flat_map(|color| &mut color[..given]) {
            *x /= 255.0;
        }
    }
    colors
}

/// The byte that a colour is a 255th of.
pub(super) fn byte(x: f64) -> Option<u8> {
    let scaled = (x * 255.0).round();
    ((0.0..=255.0).contains(&scaled) && scaled / 255.0 == x).then_some(scaled as u8)
}
