//! An empty crate, whose `Cargo.toml` matters: a package that depends on this one has the features
//! that the tests of the workspace ask for, so that cargo takes faer and all above it as the other
//! suites of `scripts/test` have compiled them.
