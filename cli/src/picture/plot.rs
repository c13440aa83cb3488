//! Draws charts as pixels.

use std::convert::Infallible;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;
use catamaran_charts::Chart;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::format::Format;
use super::image::Image;
use super::text::{Size, write_text};

/// Writes a chart as the name of the file selects: as SVG, or as PNG.
pub fn write_chart(mut output: Output, chart: &Chart) -> Result<()> {
    let charts = std::slice::from_ref(chart);
    if Format::of(output.path()) == Some(Format::Png) {
        return draw(charts).write(output);
    }
    let svg = catamaran_charts::svg(charts);
    output.write_all(svg.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// Draws charts below one another.
fn draw(charts: &[Chart]) -> Image {
    let (width, height) = catamaran_charts::size(charts);
    let mut image = Image::new(width as usize, height as usize, [255; 3]);
    let drawn = catamaran_charts::draw(charts, Canvas { image: &mut image });
    drawn.expect("an image takes all that is drawn");
    image
}

/// The letters of charts.
const LETTERS: Size = Size::Small;

/// An image that charts are drawn on.
struct Canvas<'a> {
    image: &'a mut Image,
}

/// The result of drawing, which can't fail.
type Drawn<T> = Result<T, DrawingErrorKind<Infallible>>;

impl DrawingBackend for Canvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.image.width() as u32, self.image.height() as u32)
    }

    fn ensure_prepared(&mut self) -> Drawn<()> {
        Ok(())
    }

    fn present(&mut self) -> Drawn<()> {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn<()> {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return Ok(()) };
        let Some(pixel) = self.image.pixel(x, y) else { return Ok(()) };
        let ink: [u8; 3] = color.rgb.into();
        *pixel = std::array::from_fn(|k| {
            let mixed = color.alpha * f64::from(ink[k]) + (1.0 - color.alpha) * f64::from(pixel[k]);
            mixed.round() as u8
        });
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        at: BackendCoord,
    ) -> Drawn<()> {
        let (width, height) = (LETTERS.width(text), LETTERS.height());
        // Black on white, from which the cover of each pixel is read.
        let mut letters = Image::new(width, height, [255; 3]);
        write_text(&mut letters, text, LETTERS, 0, 0, [0; 3]);
        let (across, down) = (width as i32, height as i32);
        let left = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Right => -across,
            HPos::Center => -across / 2,
        };
        let top = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -down / 2,
            VPos::Bottom => -down,
        };
        let color = style.color();
        for (i, pixel) in letters.bytes().chunks_exact(3).enumerate() {
            let (x, y) = ((i % width) as i32 + left, (i / width) as i32 + top);
            let (x, y) = style.transform().transform(x, y);
            let cover = 1.0 - f64::from(pixel[0]) / 255.0;
            let alpha = color.alpha * cover;
            self.draw_pixel((at.0 + x, at.1 + y), BackendColor { alpha, ..color })?;
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(&self, text: &str, _: &S) -> Drawn<(u32, u32)> {
        Ok((LETTERS.width(text) as u32, LETTERS.height() as u32))
    }
}

#[cfg(test)]
mod tests {
    use catamaran_charts::{Axis, Series};

    use super::*;

    #[test]
    fn a_chart_has_its_curve_and_its_letters_in_pixels() {
        let blue = [0x1f, 0x6f, 0xeb];
        let chart = |name: &str| {
            let points = (0..5).map(|i| (f64::from(i), f64::from(i))).collect();
            let curve = Series::curve(name, blue, points);
            Chart::new(Axis::linear("x"), Axis::linear("y"), vec![curve])
        };
        let count = |chart: &Chart, wanted: fn(&[u8]) -> bool| {
            let image = draw(std::slice::from_ref(chart));
            assert_eq!((image.width(), image.height()), (900, 420));
            image.bytes().chunks_exact(3).filter(|pixel| wanted(pixel)).count()
        };
        let is_blue = |pixel: &[u8]| pixel[2] > 200 && pixel[0] < 60;
        let is_dark = |pixel: &[u8]| pixel[0] < 60 && pixel[2] < 60;
        // The diagonal of the plot, about 600 by 350 pixels, and two wide.
        assert!(count(&chart(""), is_blue) > 600);
        let [few, more] = ["", "a name in the legend"].map(|name| count(&chart(name), is_dark));
        assert!(few > 60 && more > few + 40, "{few} {more}");
    }
}
