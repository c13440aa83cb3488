//! A picture of the task tree: which process owns which block of C.

use std::fmt::Write;

use catamaran::product::{Node, Task};
use colorous::{Color, RAINBOW};

/// Draws the lower triangle of C with its owners, and the tree that says so.
pub fn draw(tree: &Node, n: usize, processes: usize) -> String {
    const WIDTH: f64 = 480.0;
    const SIDE: f64 = 340.0;
    const TREE_TOP: f64 = SIDE + 36.0;
    const HEIGHT: f64 = TREE_TOP + 170.0;
    let mut svg = format!(
        r#"<svg class="tree" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="Blocks of C and the task tree" font-size="13"><g transform="translate({} 2)">"#,
        (WIDTH - SIDE) / 2.0
    );
    let unit = SIDE / n.max(1) as f64;
    for task in tree.tasks() {
        block(&mut svg, &task, unit, processes);
    }
    let _ = write!(svg, "</g><g transform=\"translate(0 {TREE_TOP})\">");
    let leaves = tree.tasks().len().max(1);
    let layout = Layout {
        step: WIDTH / leaves as f64,
        level: (HEIGHT - TREE_TOP - 30.0) / tree.depth().max(1) as f64,
        processes,
    };
    let (mut edges, mut dots) = (String::new(), String::new());
    layout.node(tree, 0, &mut 0, &mut edges, &mut dots);
    let _ = write!(svg, "{edges}{dots}</g></svg>");
    svg
}

/// Returns the colour of a process, dark enough for white digits.
fn color(process: usize, processes: usize) -> String {
    let Color { r, g, b } = RAINBOW.eval_rational(process, processes + 1);
    let dim = |v: u8| (f64::from(v) * 0.72) as u8;
    format!("#{:02x}{:02x}{:02x}", dim(r), dim(g), dim(b))
}

fn block(svg: &mut String, task: &Task, unit: f64, processes: usize) {
    let at = |range: &std::ops::Range<usize>| (range.start as f64 * unit, range.end as f64 * unit);
    let ((top, bottom), (left, right)) = (at(&task.rows), at(&task.cols));
    let fill = color(task.process, processes);
    let (x, y) = if task.triangle {
        let _ = write!(
            svg,
            r#"<path class="block" fill="{fill}" d="M{left:.1} {top:.1}V{bottom:.1}H{right:.1}Z"/>"#
        );
        (left + (right - left) * 0.32, top + (bottom - top) * 0.7)
    } else {
        let _ = write!(
            svg,
            r#"<rect class="block" fill="{fill}" x="{left:.1}" y="{top:.1}" width="{:.1}" height="{:.1}"/>"#,
            right - left,
            bottom - top
        );
        ((left + right) / 2.0, (top + bottom) / 2.0)
    };
    let _ = write!(svg, r#"<text class="label" x="{x:.1}" y="{y:.1}">{}</text>"#, task.process);
}

struct Layout {
    /// Distance between leaves.
    step: f64,
    /// Distance between levels.
    level: f64,
    processes: usize,
}

impl Layout {
    /// Draws a node and what is below it; returns its x.
    fn node(
        &self,
        node: &Node,
        depth: usize,
        leaf: &mut usize,
        edges: &mut String,
        dots: &mut String,
    ) -> f64 {
        let y = 8.0 + depth as f64 * self.level;
        match node {
            Node::Leaf(task) => {
                let x = (*leaf as f64 + 0.5) * self.step;
                *leaf += 1;
                let radius = (self.step / 2.0 - 1.0).min(12.0);
                let _ = write!(
                    dots,
                    r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius:.1}" fill="{}"/><text class="label" x="{x:.1}" y="{y:.1}" font-size="11">{}</text>"#,
                    color(task.process, self.processes),
                    task.process
                );
                x
            }
            Node::Inner(children) => {
                let below: Vec<f64> = children
                    .iter()
                    .map(|child| self.node(child, depth + 1, leaf, edges, dots))
                    .collect();
                let x = below.iter().sum::<f64>() / below.len().max(1) as f64;
                let next = y + self.level;
                let middle = (y + next) / 2.0;
                for child in below {
                    let _ = write!(
                        edges,
                        r#"<path class="edge" d="M{x:.1} {y:.1}C{x:.1} {middle:.1} {child:.1} {middle:.1} {child:.1} {next:.1}"/>"#
                    );
                }
                let _ = write!(dots, r#"<circle class="inner" cx="{x:.1}" cy="{y:.1}" r="6"/>"#);
                x
            }
        }
    }
}
