//! The shared library as programs see it: its symbols, and calls of them in separate processes,
//! because settings are read once in a process.
//!
//! `in_child` below is what such a process runs.

#![cfg(target_os = "linux")]

mod calls;
mod child;
mod host;
mod library;
mod oracle;
mod python;
mod rounding;
mod symbols;
