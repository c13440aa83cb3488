//! Bar charts as SVG that follows the colours of the page.

use std::fmt::Write;

use super::page::escape;

/// One bar.
pub struct Bar {
    /// Its name.
    pub name: String,
    /// Its length, at least 0.
    pub value: f64,
    /// What is written at its end.
    pub label: String,
    /// Drawn in the accent colour.
    pub accent: bool,
}

/// Horizontal bars over an axis from 0, with gridlines at round values.
pub fn bars(bars: &[Bar], unit: &str) -> String {
    const WIDTH: f64 = 960.0;
    const LEFT: f64 = 110.0;
    const RIGHT: f64 = 90.0;
    const ROW: f64 = 38.0;
    let largest = bars.iter().map(|b| b.value).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let step = round_step(largest / 6.0);
    let scale = (WIDTH - LEFT - RIGHT) / largest;
    let bottom = bars.len() as f64 * ROW + 6.0;
    let mut svg = format!(
        r#"<svg viewBox="0 0 {WIDTH} {}" role="img" aria-label="{}" font-size="15">"#,
        bottom + 30.0,
        escape(unit)
    );
    let mut tick = 0.0;
    while tick <= largest * 1.0001 {
        let x = LEFT + tick * scale;
        let _ = write!(
            svg,
            r#"<line class="grid" x1="{x:.1}" x2="{x:.1}" y1="0" y2="{bottom}"/><text class="soft" x="{x:.1}" y="{}" font-size="13" text-anchor="middle">{}</text>"#,
            bottom + 20.0,
            (tick * 1000.0).round() / 1000.0
        );
        tick += step;
    }
    let _ = write!(
        svg,
        r#"<text class="soft" x="{WIDTH}" y="{}" font-size="13" text-anchor="end">{}</text>"#,
        bottom + 20.0,
        escape(unit)
    );
    for (i, bar) in bars.iter().enumerate() {
        let (y, width) = (i as f64 * ROW + 6.0, bar.value * scale);
        let middle = y + (ROW - 12.0) / 2.0 + 5.0;
        let _ = write!(
            svg,
            r#"<text x="{}" y="{middle}" text-anchor="end">{}</text><rect class="{}" x="{LEFT}" y="{y}" width="{width:.1}" height="{}" rx="3"/><text class="soft" x="{:.1}" y="{middle}">{}</text>"#,
            LEFT - 12.0,
            escape(&bar.name),
            if bar.accent { "accent" } else { "bar" },
            ROW - 12.0,
            LEFT + width + 10.0,
            escape(&bar.label),
        );
    }
    svg.push_str("</svg>");
    svg
}

/// The smallest of 1, 2, 5 times a power of ten that is at least `step`.
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|f| f * power).find(|&s| s >= step).unwrap_or(10.0 * power)
}
