//! Any bytes as a call of a function of C, with arguments that are valid or not: results within
//! their bounds of plain loops, or an error that names the argument, and no byte written beside.
#![no_main]

#[path = "../../capi/tests/c_functions/calls/mod.rs"]
mod calls;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| calls::call(bytes));
