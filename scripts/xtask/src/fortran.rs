//! `include/catamaran.f90`, generated from the declarations of `include/catamaran.h`.

use std::path::Path;

use crate::declarations::{Constant, Function, Header, type_and_name};
use crate::generated::Generated;
use crate::header::HEADER;

/// `include/catamaran.f90`.
pub const FORTRAN: Generated = Generated {
    name: "include/catamaran.f90",
    source: "include/catamaran.h",
    command: "cargo xtask fortran",
    generate,
};

/// The sections of the header that Fortran has.
const SECTIONS: [&str; 9] =
    ["status", "backend", "ata", "gram", "rows", "cholesky", "eigs", "mesh", "plants"];

/// Factors of complex products, which are read.
const FACTORS: [&str; 2] = ["alpha", "beta"];

/// Pointers to one number that is written, as are all those of a function of [`ONE_EACH`]; others
/// are arrays.
const SCALARS: [&str; 16] = [
    "major",
    "minor",
    "patch",
    "len",
    "passed",
    "residual",
    "tolerance",
    "exact",
    "max",
    "frobenius",
    "rows",
    "weight",
    "count",
    "rank",
    "iterations",
    "gap",
];

/// Ends of the names of functions that write one number at a time.
const ONE_EACH: [&str; 2] = ["_size", "_weakest"];

fn generate(root: &Path) -> Result<String, String> {
    module(&Header::parse(&super::read(&root.join(HEADER.name))?))
}

fn module(header: &Header) -> Result<String, String> {
    let wanted = |section: &str| SECTIONS.contains(&section);
    let functions: Vec<&Function> =
        header.functions.iter().filter(|function| wanted(&function.section)).collect();
    let mut text = OPENING.to_owned();
    let constants = header.constants.iter().filter(|constant| wanted(&constant.section));
    constants.for_each(|constant| text += &parameter(constant));
    for (name, fields) in &header.structs {
        let takes = |argument: &String| base_of(type_and_name(argument).0) == name;
        if functions.iter().any(|function| function.arguments.iter().any(takes)) {
            text += &format!("\n  type, bind(C) :: {name}\n");
            for field in fields {
                text += &format!("    {}\n", component(field)?);
            }
            text += &format!("  end type {name}\n");
        }
    }
    text += "\n  interface\n";
    for function in functions {
        text += &interface(function, header)?;
    }
    Ok(text + CLOSING)
}

/// Returns a type without `const` and asterisks.
fn base_of(kind: &str) -> &str {
    kind.trim_start_matches("const ").trim_end_matches(['*', ' '])
}

/// Returns the type of Fortran for a type of numbers; the unsigned ones have the bits of theirs.
fn number(base: &str) -> Option<&'static str> {
    Some(match base {
        "double" => "real(c_double)",
        "float" => "real(c_float)",
        "size_t" => "integer(c_size_t)",
        "int32_t" | "uint32_t" | "cata_status" => "integer(c_int32_t)",
        "uint64_t" => "integer(c_int64_t)",
        "uint8_t" => "integer(c_int8_t)",
        "char" => "character(kind=c_char)",
        _ => return None,
    })
}

fn parameter(constant: &Constant) -> String {
    let Constant { name, value, .. } = constant;
    let value = if value == "UINT32_MAX" { "-1" } else { value.as_str() };
    let kind = if name.starts_with("CATA_CAP_") { "c_int64_t" } else { "c_int32_t" };
    if value.contains('.') {
        format!("  real(c_double), parameter :: {name} = {value}_c_double\n")
    } else {
        format!("  integer({kind}), parameter :: {name} = {value}_{kind}\n")
    }
}

/// Returns a field of a struct as a component: 0, or null, unless it is set.
fn component(field: &str) -> Result<String, String> {
    let (kind, name) = type_and_name(field);
    if kind.contains('*') {
        return Ok(format!("type(c_ptr) :: {name} = c_null_ptr"));
    }
    let entity = name.replace('[', "(").replace(']', ")");
    match number(kind) {
        Some(number) => Ok(format!("{number} :: {entity} = 0")),
        None if kind == "cata_progress" => {
            Ok(format!("type(c_funptr) :: {entity} = c_null_funptr"))
        }
        None => Err(format!("{field}: teach scripts/xtask/src/fortran.rs")),
    }
}

fn interface(function: &Function, header: &Header) -> Result<String, String> {
    let Function { name, returns, arguments, .. } = function;
    let arguments: &[String] = if arguments[0] == "void" { &[] } else { arguments };
    let names: Vec<&str> = arguments.iter().map(|argument| type_and_name(argument).1).collect();
    let is_function = returns != "void";
    let (unit, result) =
        if is_function { ("function", " result(returned)") } else { ("subroutine", "") };
    let mut text = wrapped(&format!("{unit} {name}({}) bind(C){result}", names.join(", ")));
    text += "      import\n";
    if is_function {
        let unknown = || format!("{name} returns {returns}: teach scripts/xtask/src/fortran.rs");
        let kind = match returns.as_str() {
            "const char *" => "type(c_ptr)",
            returns => number(returns).ok_or_else(unknown)?,
        };
        text += &format!("      {kind} :: returned\n");
    }
    let mut before = String::new();
    for argument in arguments {
        let (attributes, entity) = dummy(function, argument, header)?;
        let width = text.lines().last().map_or(0, str::len);
        if attributes == before && width + 2 + entity.len() <= 100 {
            // Behind the one before, which has the same type.
            text.truncate(text.trim_end().len());
            text += &format!(", {entity}\n");
        } else {
            text += &format!("      {attributes} :: {entity}\n");
            before = attributes;
        }
    }
    Ok(text + &format!("    end {unit} {name}\n"))
}

/// Returns the attributes and the name of a dummy argument, with its shape. Pointers of C that may
/// be NULL are optional: one that is absent is NULL.
fn dummy(function: &Function, argument: &str, header: &Header) -> Result<(String, String), String> {
    let (kind, name) = type_and_name(argument);
    let base = base_of(kind);
    let entity = |is_scalar: bool| if is_scalar { name.to_owned() } else { format!("{name}(*)") };
    let intent = if kind.starts_with("const ") { "in" } else { "inout" };
    let optional = format!("intent({intent}), optional");
    let is_complex = function.name.ends_with("_c64") || function.name.ends_with("_c32");
    Ok(match (number(base), kind.matches('*').count()) {
        (Some(number), 0) => (format!("{number}, value"), entity(true)),
        (Some(number), 1) if base == "char" => {
            (format!("{number}, intent({intent})"), entity(false))
        }
        (Some(number), 1) => {
            let number = if is_complex { number.replace("real", "complex") } else { number.into() };
            let one_each = ONE_EACH.iter().any(|end| function.name.ends_with(end));
            let is_scalar = match intent {
                "in" => FACTORS.contains(&name),
                _ => one_each || SCALARS.contains(&name),
            };
            (format!("{number}, {optional}"), entity(is_scalar))
        }
        (None, 0) => ("type(c_funptr), value".to_owned(), entity(true)),
        (None, 1) if header.structs.contains_key(base) => {
            (format!("type({base}), {optional}"), entity(true))
        }
        (None, 1) => ("type(c_ptr), value".to_owned(), entity(true)),
        (None, 2) if kind.contains("*const *") => {
            ("type(c_ptr), intent(in), optional".to_owned(), entity(false))
        }
        (None, 2) => ("type(c_ptr), intent(inout)".to_owned(), entity(true)),
        _ => return Err(format!("{argument}: teach scripts/xtask/src/fortran.rs")),
    })
}

/// Returns a statement in lines of at most 100 columns.
fn wrapped(statement: &str) -> String {
    let (mut text, mut width) = ("    ".to_owned(), 4);
    for word in statement.split_inclusive(", ") {
        if width + word.len() > 98 {
            text += "&\n        ";
            width = 8;
        }
        text += word;
        width += word.len();
    }
    text + "\n"
}

const OPENING: &str = "\
! Catamaran from Fortran 2018: products, least squares, eigenpairs and the water of plants.
!
! Generated from include/catamaran.h by `cargo xtask fortran`: do not edit. MIT OR Apache-2.0.
!
! The functions are those of C: catamaran.h says what they compute and what their arguments are.
! - Arrays that are absent are NULL, and so are structs: without `params` all defaults hold.
! - A struct is 0 at first; its struct_size must be set: params%struct_size = c_sizeof(params).
! - Columns of Fortran's matrices are contiguous: layout is CATA_COL_MAJOR.
! - Vertices, columns and the like are numbered from 0. Strings end with c_null_char.
! - Handles are of type(c_ptr), and functions that are passed of type(c_funptr).
module catamaran
  use, intrinsic :: iso_c_binding
  implicit none
  public

";

const CLOSING: &str = "\
  end interface

contains

  !> Returns the message of the last call of this thread that failed.
  function cata_message() result(text)
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    type(c_ptr) :: first
    integer(c_size_t) :: i, length
    interface
      function c_strlen(string) bind(C, name='strlen') result(returned)
        import
        type(c_ptr), value :: string
        integer(c_size_t) :: returned
      end function c_strlen
    end interface
    first = cata_last_error_message()
    length = c_strlen(first)
    call c_f_pointer(first, letters, [length])
    allocate (character(len=length) :: text)
    do i = 1, length
      text(i:i) = letters(i)
    end do
  end function cata_message

end module catamaran
";

#[cfg(test)]
mod tests {
    use super::module;
    use crate::declarations::Header;

    #[test]
    fn pointers_become_arrays_numbers_handles_and_structs() {
        let header = "/**\n * @defgroup ata A^T A\n */\n#define CATA_K 1\ntypedef struct cata_p {\n    \
                      size_t n;\n    double g[3];\n    double *x;\n} cata_p;\ncata_status \
                      cata_f(size_t n, const double *a, size_t *count, cata_h *h, cata_h **made, \
                      const double *const *all, const cata_p *params);\n";
        let text = module(&Header::parse(header)).unwrap();
        let expected = "\
  integer(c_int32_t), parameter :: CATA_K = 1_c_int32_t

  type, bind(C) :: cata_p
    integer(c_size_t) :: n = 0
    real(c_double) :: g(3) = 0
    type(c_ptr) :: x = c_null_ptr
  end type cata_p

  interface
    function cata_f(n, a, count, h, made, all, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), intent(inout), optional :: count
      type(c_ptr), value :: h
      type(c_ptr), intent(inout) :: made
      type(c_ptr), intent(in), optional :: all(*)
      type(cata_p), intent(in), optional :: params
    end function cata_f
";
        assert!(text.contains(expected), "{text}");
    }
}
