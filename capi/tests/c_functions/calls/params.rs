//! Parameter structs of any version, with fields of any value.

use std::ptr;

use catamaran_capi::*;

use super::choices::Choices;

/// A parameter struct in memory of its own size.
pub struct Params<T> {
    words: Vec<usize>,
    null: bool,
    /// What the message must begin with if it has to be refused.
    pub refused: Vec<&'static str>,
    /// What was chosen, of a struct that is not refused.
    pub value: T,
}

impl<T: Copy> Params<T> {
    /// Creates a struct, of the size of this version, or of another one. `refused` names its field
    /// that is invalid.
    pub fn new(choices: &mut Choices<'_>, value: T, refused: Option<&'static str>) -> Self {
        let own = size_of::<T>().div_ceil(size_of::<usize>());
        let mut refused: Vec<_> = refused.into_iter().collect();
        let mut words = vec![0; own];
        // SAFETY: as many bytes as T has; all of them are initialized but padding, whose value
        // nothing depends on.
        unsafe { words.as_mut_ptr().cast::<T>().write_unaligned(value) };
        words[0] = size_of::<T>();
        match choices.below(16) {
            15 => {
                words[0] = choices.pick(&[0, 8, 20, 4097, usize::MAX]);
                refused = vec!["params.struct_size: "];
            }
            14 => {
                words.extend([0, 0]);
                words[0] += 16;
            }
            13 => {
                words.extend([0, 1]);
                words[0] += 16;
                refused = vec!["params: "];
            }
            _ => {}
        }
        Self { words, null: false, refused, value }
    }

    /// Creates NULL.
    pub fn null(value: T) -> Self {
        Self { words: Vec::new(), null: true, refused: Vec::new(), value }
    }

    pub fn pointer(&self) -> *const T {
        if self.null { ptr::null() } else { self.words.as_ptr().cast() }
    }
}

/// Chooses a field: mostly one of the valid values, or else an invalid one, which is then named.
pub fn field<V: Copy>(
    choices: &mut Choices<'_>,
    name: &'static str,
    valid: &[V],
    invalid: &[V],
    refused: &mut Option<&'static str>,
) -> V {
    // An earlier field is named first, whose message is then the one that is known.
    if refused.is_none() && choices.one_in(24) {
        *refused = Some(name);
        return choices.pick(invalid);
    }
    choices.pick(valid)
}

/// How near a product must be to plain loops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Nearness {
    /// `4 m u` times the norms of two columns; NaN and infinities as in loops.
    Loops,
    /// The same bound; NaN and infinities may spread.
    Norms,
    /// A bound of the largest entries only.
    Largest,
}

/// Chooses the parameters of a product.
pub fn of_product(choices: &mut Choices<'_>) -> (Params<cata_ata_params>, Nearness) {
    let mut refused = None;
    let r = &mut refused;
    let error_factor = field(
        choices,
        "params.error_factor: ",
        &[0.0, 0.0, 0.0, 1.0, CATA_ERROR_LEAST, f64::INFINITY, 4.0, 2.5, 100.0],
        &[f64::NAN, 0.5, -2.0, -f64::INFINITY, 1e-300],
        r,
    );
    let scheme = field(
        choices,
        "params.scheme: ",
        &[0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8],
        &[-1, 9, i32::MAX],
        r,
    );
    let leafs = [0, 0, 0, 1, 2, 3, 8, 17, 64, 1 << 31];
    let most_leafs = [(1 << 31) + 1, usize::MAX];
    let most_tasks = [(1 << 16) + 1, usize::MAX];
    let mut value = cata_ata_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 2, 3, 5, 1, 1, 1]),
        progress: None,
        progress_user: ptr::null_mut(),
        leaf: field(choices, "params.leaf: ", &leafs, &most_leafs, r),
        tasks: field(choices, "params.tasks: ", &[0, 0, 1, 2, 7, 100], &most_tasks, r),
        error_factor,
        backend: ptr::null(),
        scheme,
        reproducible: 0,
        pin: field(choices, "params.pin: ", &[0], &[2, -1], r),
    };
    let exact = scheme == CATA_SCHEME_EXACT || scheme == CATA_SCHEME_AUTO;
    if exact && refused.is_none() {
        value.reproducible =
            field(choices, "params.reproducible: ", &[0, 0, 0, 1], &[2, -1], &mut refused);
    } else if refused.is_none() && choices.one_in(16) {
        value.reproducible = 1;
        refused = Some("params.reproducible: ");
    }
    let automatic = scheme == CATA_SCHEME_AUTO || scheme == CATA_SCHEME_FLOAT;
    let nearness = match scheme {
        // Fewer moduli, without a bound of their own.
        _ if error_factor >= 8.0 => Nearness::Largest,
        CATA_SCHEME_CLASSICAL | CATA_SCHEME_EXACT => Nearness::Loops,
        _ if value.reproducible == 1 => Nearness::Loops,
        CATA_SCHEME_AUTO if error_factor == CATA_ERROR_LEAST => Nearness::Loops,
        _ if automatic && (error_factor == 1.0 || error_factor == CATA_ERROR_LEAST) => {
            Nearness::Loops
        }
        _ if automatic && (error_factor == 0.0 || error_factor <= 4.0) => Nearness::Norms,
        _ => Nearness::Largest,
    };
    if choices.one_in(8) {
        return (Params::null(value), Nearness::Norms);
    }
    (Params::new(choices, value, refused), nearness)
}
