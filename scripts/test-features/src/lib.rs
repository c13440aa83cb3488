//! Nothing. What depends on this asks for the features that the tests of the workspace ask for, so
//! that cargo takes faer and all above it as the other suites of `scripts/test` have compiled them.
