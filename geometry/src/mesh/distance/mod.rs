//! Distances on meshes: along edges ([`Dijkstra`]), and over the surface, exactly
//! ([`Geodesics`]) or not ([`HeatMethod`]).

mod bounds;
mod dijkstra;
mod finer;
mod geodesics;
mod graph;
mod heat;
mod search;
#[cfg(test)]
mod tests;

pub use dijkstra::{Dijkstra, SearchLimits};
pub use geodesics::{GeodesicPath, GeodesicTrace, Geodesics, TraceEnd};
pub use graph::Graph;
pub use heat::{HeatMethod, HeatOptions};
pub(crate) use search::Search;
