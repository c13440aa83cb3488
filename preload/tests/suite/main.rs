//! The shared library as programs see it: its symbols, and calls by them in processes of their own,
//! for settings are read once in a process.
//!
//! `in_child` below is what such a process runs.

#![cfg(target_os = "linux")]

mod calls;
mod child;
mod host;
mod library;
mod oracle;
mod python;
mod symbols;
