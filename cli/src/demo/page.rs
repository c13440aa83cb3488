//! The page: what a station says, as HTML that needs nothing from elsewhere.

use std::fmt::Write;
use std::time::Duration;

use catamaran::base::{VERSION, available_cores};

use crate::info::cpu_model;

/// Tells a page of ours from other people's.
pub const MARKER: &str = r#"<meta name="generator" content="catamaran demo">"#;

/// What one system shows. Texts are HTML.
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
pub struct Figure {
    /// `<svg>` or `<img>`.
    pub body: String,
    /// One or two sentences.
    pub caption: String,
    /// As wide as the page, not half.
    pub wide: bool,
}

/// A table; numbers are aligned right in all columns but those named.
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

/// The whole page.
pub fn render(stations: &[Station], elapsed: Duration) -> String {
    let mut html = String::new();
    let style = include_str!("style.css");
    html.push_str("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    html.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    html.push_str("<meta name=\"color-scheme\" content=\"light dark\">\n");
    html.push_str(MARKER);
    html.push_str("\n<title>Catamaran</title>\n<style>\n");
    html.push_str(style);
    html.push_str("</style>\n</head>\n<body>\n<main>\n<header>\n<h1>Catamaran</h1>\n");
    let machine = format!(
        "Version {VERSION}, on {} ({} cores), in {:.1} s. Every picture and number below was \
         computed by <code>catamaran demo</code> just before this page was written.",
        escape(&cpu_model()),
        available_cores(),
        elapsed.as_secs_f64()
    );
    html.push_str(&format!("<p class=\"lead\">{machine}</p>\n</header>\n"));
    if stations.len() > 1 {
        html.push_str("<nav>");
        for station in stations {
            html.push_str(&format!("<a href=\"#{}\">{}</a> ", station.id, station.title));
        }
        html.push_str("</nav>\n");
    }
    for station in stations {
        section(&mut html, station);
    }
    html.push_str("</main>\n</body>\n</html>\n");
    html
}

fn section(html: &mut String, station: &Station) {
    let Station { id, title, text, numbers, figures, tables } = station;
    let mut put = |part: String| html.push_str(&part);
    put(format!("<section id=\"{id}\">\n<h2>{title}</h2>\n{text}\n"));
    if !numbers.is_empty() {
        put("<dl class=\"numbers\">\n".into());
        for (value, name) in numbers {
            put(format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n"));
        }
        put("</dl>\n".into());
    }
    put("<div class=\"figures\">\n".into());
    for Figure { body, caption, wide } in figures {
        let class = if *wide { " class=\"wide\"" } else { "" };
        put(format!("<figure{class}>\n{body}\n<figcaption>{caption}</figcaption>\n</figure>\n"));
    }
    put("</div>\n".into());
    for table in tables {
        put(render_table(table));
    }
    put("</section>\n".into());
}

fn render_table(table: &Table) -> String {
    let class = |column| if column < table.text_columns { " class=\"text\"" } else { "" };
    let mut html =
        format!("<div class=\"scroll\"><table>\n<caption>{}</caption>\n<thead><tr>", table.caption);
    for (i, head) in table.head.iter().enumerate() {
        let _ = write!(html, "<th scope=\"col\"{}>{head}</th>", class(i));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        html.push_str("<tr>");
        for (i, cell) in row.iter().enumerate() {
            let _ = write!(html, "<td{}>{cell}</td>", class(i));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}

/// Text as HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
