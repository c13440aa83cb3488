//! Slime moulds on surfaces: walks against geodesics in space, and the bars of the specification.

mod atlas;
mod ground;
mod parameters;
mod robustness;
mod support;
mod texels;
mod tile;
mod walks;
