use super::INK;
use crate::picture::color::ColorScale;
use crate::picture::image::Image;
use crate::picture::text::{Size, number, write_text};

/// Width of the legend to the right of the panels, in pixels.
pub const WIDTH: usize = 120;

/// Width of the bar, and of the ticks beside it, in pixels.
const BAR: (usize, usize) = (18, 5);

/// Draws the colours of a scale as a bar with numbers beside it, from column x on.
pub fn draw(image: &mut Image, scale: &ColorScale, x: usize) {
    let height = image.height();
    let (top, bottom) = (height / 5, height - height / 5);
    let bar = bottom - top;
    if bar < 2 * Size::Small.height() {
        return; // no room for two numbers
    }
    let value = |y: usize| {
        let t = (bottom - 1 - y) as f64 / (bar - 1) as f64;
        scale.low + t * (scale.high - scale.low)
    };
    for y in top..bottom {
        for column in x..x + BAR.0 {
            let rim = y == top || y + 1 == bottom || column == x || column + 1 == x + BAR.0;
            if let Some(pixel) = image.pixel(column, y) {
                *pixel = if rim { INK } else { scale.color(value(y)) };
            }
        }
    }
    let ticks = if bar >= 8 * Size::Small.height() { 5 } else { 2 };
    for tick in 0..ticks {
        let y = top + tick * (bar - 1) / (ticks - 1);
        for column in x + BAR.0..x + BAR.0 + BAR.1 {
            if let Some(pixel) = image.pixel(column, y) {
                *pixel = INK;
            }
        }
        let label =
            number(scale.high - (scale.high - scale.low) * tick as f64 / (ticks - 1) as f64);
        let up = y.saturating_sub(Size::Small.height() / 2);
        write_text(image, &label, Size::Small, x + BAR.0 + BAR.1 + 6, up, INK);
    }
}
