//! Series of points over two axes.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axis::Axis;

/// Widths and heights in pixels.
const WIDTH: u32 = 900;
const LEGEND: i32 = 190;
const LINE: i32 = 18;
pub(crate) const FONT: &str = "sans-serif";
pub(crate) const GRID: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);

/// A colour, red, green and blue.
pub type Rgb = [u8; 3];

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What it shows; empty: no title.
    pub title: String,
    /// The axis across.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// What is drawn, the later ones above the earlier.
    pub series: Vec<Series>,
    /// Lines across, below the series.
    pub rules: Vec<Rule>,
}

/// Points with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend; empty: none.
    pub name: String,
    /// Its colour.
    pub color: Rgb,
    /// How its points are joined.
    pub line: Line,
    /// Whether each point has a dot. A series of one point always has one.
    pub dots: bool,
    /// Values of x and y. Points that the axes cannot show are left out.
    pub points: Vec<(f64, f64)>,
}

/// How the points of a series are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// Not at all.
    None,
    /// By a line of one pixel.
    Thin,
    /// By a line of two pixels.
    Solid,
    /// By dashes of two pixels.
    Dashed,
}

/// A line across a chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Its value of y.
    pub y: f64,
    /// Its colour.
    pub color: Rgb,
}

impl Chart {
    /// Creates a chart without a title or rules.
    pub fn new(x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self { title: String::new(), x, y, series, rules: Vec::new() }
    }
}

impl Series {
    /// Creates a series of joined points.
    pub fn curve(name: impl Into<String>, color: Rgb, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), color, line: Line::Solid, dots: false, points }
    }

    /// Returns colour number `index` of those that colour-blind readers can tell apart (Okabe and
    /// Ito 2008); the colours repeat after seven.
    pub fn color(index: usize) -> Rgb {
        const COLORS: [Rgb; 7] = [
            [0x00, 0x72, 0xb2],
            [0xd5, 0x5e, 0x00],
            [0x00, 0x9e, 0x73],
            [0xcc, 0x79, 0xa7],
            [0xe6, 0x9f, 0x00],
            [0x56, 0xb4, 0xe9],
            [0x00, 0x00, 0x00],
        ];
        COLORS[index % COLORS.len()]
    }
}

/// Draws charts below one another, as one SVG document.
pub fn svg(charts: &[Chart]) -> String {
    let mut document = String::new();
    let drawn = draw(charts, SVGBackend::with_string(&mut document, size(charts)));
    drawn.expect("a string takes all that is drawn");
    document
}

/// Returns the width and the height of charts below one another, in pixels.
pub fn size(charts: &[Chart]) -> (u32, u32) {
    let height = if charts.len() == 1 { 420 } else { 310 };
    (WIDTH, height * charts.len().max(1) as u32)
}

/// Draws charts below one another, on an area of their [`size`].
///
/// # Errors
/// Those of the back end.
pub fn draw<B: DrawingBackend>(charts: &[Chart], backend: B) -> Result<(), DrawError<B>> {
    on_white(backend, |root| {
        for (chart, area) in charts.iter().zip(root.split_evenly((charts.len().max(1), 1))) {
            chart.draw(&area)?;
        }
        Ok(())
    })
}

/// The reason why drawing failed.
pub type DrawError<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;
/// The area in which something is drawn.
pub(crate) type Area<B> = DrawingArea<B, Shift>;

/// Draws on a white background.
pub(crate) fn on_white<B: DrawingBackend>(
    backend: B,
    draw: impl FnOnce(&Area<B>) -> Result<(), DrawError<B>>,
) -> Result<(), DrawError<B>> {
    let root = backend.into_drawing_area();
    root.fill(&WHITE).and_then(|()| draw(&root)).and_then(|()| root.present())
}

pub(crate) fn rgb([r, g, b]: Rgb) -> RGBColor {
    RGBColor(r, g, b)
}

impl Chart {
    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Result<(), DrawError<B>> {
        let shown = |series: &Series| -> Vec<(f64, f64)> {
            let points = series.points.iter().copied();
            points.filter(|(x, y)| self.x.shows(*x) && self.y.shows(*y)).collect()
        };
        let points: Vec<_> = self.series.iter().map(shown).collect();
        let all = || points.iter().flatten();
        let rules = self.rules.iter().map(|rule| rule.y);
        let x = self.x.coordinates(all().map(|point| point.0), false);
        let y = self.y.coordinates(all().map(|point| point.1).chain(rules), true);
        let ends @ (first, last) = (Ranged::range(&x).start, Ranged::range(&x).end);
        debug_assert!(first < last, "{ends:?}");

        let named = self.series.iter().any(|series| !series.name.is_empty());
        let legend = if named { LEGEND } else { 0 };
        let (plot, names) = area.split_horizontally(WIDTH as i32 - legend);
        let mut builder = ChartBuilder::on(&plot);
        builder.margin(10).margin_right(24).x_label_area_size(44).y_label_area_size(70);
        if !self.title.is_empty() {
            builder.caption(&self.title, (FONT, 14));
        }
        let mut context = builder.build_cartesian_2d(x, y)?;
        context
            .configure_mesh()
            .x_desc(&self.x.title)
            .y_desc(&self.y.title)
            .axis_desc_style((FONT, 13))
            .label_style((FONT, 12))
            .axis_style(rgb([0x88; 3]))
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .draw()?;
        for Rule { y, color } in &self.rules {
            let style = rgb(*color).stroke_width(1);
            context.draw_series([PathElement::new(vec![(first, *y), (last, *y)], style)])?;
        }
        for (series, points) in self.series.iter().zip(&points) {
            let color = rgb(series.color);
            match series.line {
                Line::None => {}
                Line::Thin => drop(context.draw_series(LineSeries::new(points.clone(), color))?),
                Line::Solid => {
                    let style = color.stroke_width(2);
                    context.draw_series(LineSeries::new(points.clone(), style))?;
                }
                Line::Dashed => {
                    let style = color.stroke_width(2);
                    let dashes = DashedLineSeries::new(points.clone(), 6, 4, style);
                    context.draw_series(dashes)?;
                }
            }
            if series.dots || points.len() == 1 {
                let dot = |&point| Circle::new(point, 3, color.filled());
                context.draw_series(points.iter().map(dot))?;
            }
        }
        self.draw_legend(&names)
    }

    fn draw_legend<B: DrawingBackend>(&self, area: &Area<B>) -> Result<(), DrawError<B>> {
        let style = (FONT, 12).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
        let named = self.series.iter().filter(|series| !series.name.is_empty());
        let mut y = 44;
        for Series { name, color, line, .. } in named {
            let color = rgb(*color);
            match line {
                Line::None => area.draw(&Circle::new((12, y), 4, color.filled()))?,
                Line::Dashed => {
                    for start in [0, 9, 18] {
                        let style = color.stroke_width(2);
                        area.draw(&PathElement::new([(start, y), (start + 5, y)], style))?;
                    }
                }
                Line::Thin | Line::Solid => {
                    area.draw(&PathElement::new([(0, y), (23, y)], color.stroke_width(2)))?;
                }
            }
            area.draw(&Text::new(name.as_str(), (30, y), &style))?;
            y += LINE;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(x: Axis, y: Axis, points: Vec<(f64, f64)>) -> Chart {
        let series = |name, line| Series { line, ..Series::curve(name, [1, 2, 3], points.clone()) };
        let series = vec![
            series("a < b", Line::Solid),
            series("dashes", Line::Dashed),
            Series { dots: true, ..series("dots", Line::None) },
            series("", Line::Thin),
        ];
        let rules = vec![Rule { y: 1.0, color: [0; 3] }];
        Chart { title: "title".into(), x, y, series, rules }
    }

    #[test]
    fn series_of_any_length_are_finite_on_all_axes() {
        for length in [0, 1, 2, 50] {
            let points: Vec<(f64, f64)> =
                (0..length).map(|i| (f64::from(i), 1.0 / f64::from(i + 1))).collect();
            for y in [Axis::linear("y"), Axis::log10("y"), Axis::linear("y").range(0.0, 1.05)] {
                for x in [Axis::linear("x"), Axis::log2("x"), Axis::linear("x").range(0.0, 0.0)] {
                    let document = svg(&[chart(x, y.clone(), points.clone())]);
                    assert!(!document.contains("NaN") && !document.contains("inf"), "{document}");
                    assert_eq!(document.matches("a &lt; b").count(), 1);
                }
            }
        }
    }

    #[test]
    fn charts_are_below_one_another_and_values_without_a_logarithm_are_left_out() {
        let points = vec![(1.0, 0.1), (2.0, 0.0), (3.0, 0.001), (f64::NAN, 1.0)];
        let one = chart(Axis::linear("K"), Axis::log10("error"), points);
        let document = svg(&[one.clone(), Chart { series: vec![], ..one }]);
        assert!(document.contains("height=\"620\""));
        assert_eq!(document.matches(">\ntitle\n<").count(), 2);
        // Two points, and the dot of the legend.
        assert_eq!(document.matches("<circle").count(), 3);
        assert!(document.contains("\n0.001\n") && document.contains("\nK\n"), "{document}");
    }
}
