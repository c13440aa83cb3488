//! The page: what a station says, as HTML that needs nothing from elsewhere.

use std::time::Duration;

use anyhow::Result;
use catamaran::base::{VERSION, available_cores};
use minijinja::value::{Serde, Value};
use minijinja::{AutoEscape, Environment, UndefinedBehavior, context};
use serde::Serialize;

use crate::info::cpu_model;

/// Marks the pages that `catamaran demo` has written, and may replace.
pub const MARKER: &str = r#"<meta name="generator" content="catamaran demo">"#;

/// What one system shows. Title and body are HTML.
#[derive(Serialize)]
pub struct Station {
    /// Name of its anchor.
    id: &'static str,
    /// Heading.
    title: &'static str,
    /// Text, headline numbers, figures and tables.
    body: String,
}

impl Station {
    /// Fills `values` into the template of a station.
    ///
    /// # Errors
    /// If the template is malformed, or prints a value that is missing.
    pub fn new(
        id: &'static str,
        title: &'static str,
        template: &str,
        values: Value,
    ) -> Result<Self> {
        let mut templates = Environment::new();
        templates.set_undefined_behavior(UndefinedBehavior::Strict);
        // Charts and some of the texts among the values are HTML.
        templates.set_auto_escape_callback(|_| AutoEscape::None);
        Ok(Self { id, title, body: templates.render_named_str(id, template, values)? })
    }
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
