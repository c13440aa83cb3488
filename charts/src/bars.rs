//! Horizontal bars.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axis::Axis;
use crate::chart::{FONT, GRID, Rgb, on_white, rgb};

/// A bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Its name.
    pub name: String,
    /// Its length, at least 0.
    pub value: f64,
    /// What is written at its end.
    pub label: String,
    /// Its colour.
    pub color: Rgb,
}

/// Draws horizontal bars from the top down over an axis from 0, as an SVG document.
pub fn bars(bars: &[Bar], unit: &str) -> String {
    const WIDTH: u32 = 960;
    const ROW: u32 = 36;
    const AXIS: u32 = 50;
    let mut document = String::new();
    let size = (WIDTH, ROW * bars.len() as u32 + AXIS);
    let drawn = on_white(SVGBackend::with_string(&mut document, size), |root| {
        // From the bottom up, as the axis goes.
        let names = bars.iter().rev().map(|bar| bar.name.clone()).collect();
        let across = Axis::linear(unit).coordinates(bars.iter().map(|bar| bar.value), true);
        let upwards = Axis::names(names).coordinates([].into_iter(), false);
        let mut context = ChartBuilder::on(root)
            .margin_right(110)
            .x_label_area_size(AXIS)
            .y_label_area_size(120)
            .build_cartesian_2d(across, upwards)?;
        context
            .configure_mesh()
            .disable_y_mesh()
            .x_desc(unit)
            .axis_desc_style((FONT, 14))
            .x_label_style((FONT, 13))
            .y_label_style((FONT, 15))
            .axis_style(GRID)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .draw()?;
        let place = |i: usize| (bars.len() - 1 - i) as f64;
        let rectangle = |(i, bar): (usize, &Bar)| {
            let corners = [(0.0, place(i) - 0.34), (bar.value, place(i) + 0.34)];
            Rectangle::new(corners, rgb(bar.color).filled())
        };
        context.draw_series(bars.iter().enumerate().map(rectangle))?;
        let style = (FONT, 14).into_text_style(root).pos(Pos::new(HPos::Left, VPos::Center));
        let label = |(i, bar): (usize, &Bar)| {
            EmptyElement::at((bar.value, place(i)))
                + Text::new(bar.label.clone(), (8, 0), style.clone())
        };
        context.draw_series(bars.iter().enumerate().map(label))?;
        Ok(())
    });
    drawn.expect("a string takes all that is drawn");
    document
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bar_has_its_name_and_label() {
        let bar = |name: &str, value| Bar {
            name: name.into(),
            value,
            label: format!("{value} s"),
            color: [0, 114, 178],
        };
        let document = bars(&[bar("one & two", 2.0), bar("three", 0.0)], "seconds");
        for text in ["one &amp; two", "three", "2 s", "0 s", "seconds"] {
            assert!(document.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(!document.contains("NaN"));
        assert!(!bars(&[], "seconds").contains("NaN"));
    }
}
