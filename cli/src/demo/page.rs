//! The page: what a station says, as HTML that needs nothing from elsewhere.

use std::time::Duration;

use anyhow::Result;
use catamaran::base::{VERSION, available_cores};
use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use serde::Serialize;

use crate::info::cpu_model;

/// Tells a page of ours from other people's.
pub const MARKER: &str = r#"<meta name="generator" content="catamaran demo">"#;

/// What one system shows. Texts are HTML.
#[derive(Serialize)]
pub struct Station {
    /// Name of its anchor.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// A paragraph or two.
    pub text: String,
    /// Headline numbers: value and what it is.
    pub numbers: Vec<(String, &'static str)>,
    /// Pictures.
    pub figures: Vec<Figure>,
    /// Tables.
    pub tables: Vec<Table>,
}

/// A picture and what it shows.
#[derive(Serialize)]
pub struct Figure {
    /// `<svg>` or `<img>`.
    pub body: String,
    /// One or two sentences.
    pub caption: String,
    /// As wide as the page, not half.
    pub wide: bool,
}

/// A table; numbers are aligned right in all columns but those named.
#[derive(Serialize)]
pub struct Table {
    /// One sentence.
    pub caption: String,
    /// Column headings.
    pub head: Vec<&'static str>,
    /// How many of the first columns hold text.
    pub text_columns: usize,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
}

/// Returns the whole page.
///
/// # Errors
/// None but those of a template that does not fit the structures above.
pub fn render(stations: &[Station], elapsed: Duration) -> Result<String> {
    let mut templates = Environment::new();
    templates.add_template("page.html", include_str!("page.html"))?;
    let page = context! {
        marker => MARKER,
        style => include_str!("style.css"),
        version => VERSION.to_string(),
        cpu => cpu_model(),
        cores => available_cores(),
        seconds => format!("{:.1}", elapsed.as_secs_f64()),
        stations => Value::from(Serde(stations)),
    };
    Ok(templates.get_template("page.html")?.render(page)?)
}
