//! Options: structs whose fields are declared once, with their defaults, units and ranges.

/// An option, as the struct of options declares it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub kind: &'static str,
    /// Its default, a Rust expression.
    pub default: &'static str,
    /// Its unit; empty if it has none.
    pub unit: &'static str,
    /// What completes "must be"; empty if every value of the type is allowed.
    pub range: &'static str,
    /// What it means: sentences in Markdown.
    pub doc: &'static str,
}

impl Field {
    /// For the macro `options!` alone.
    #[doc(hidden)]
    pub const fn new(
        [name, kind, default]: [&'static str; 3],
        [unit, range, doc]: [&'static str; 3],
    ) -> Self {
        Self { name, kind, default, unit, range, doc: doc.trim_ascii() }
    }
}

/// Defines a struct of options: its fields, with the default, unit and range of each at the end of
/// their documentation; `Default`, `new`, and a setter for each field
/// ([`builder!`](crate::builder)); the table `FIELDS`; `check_ranges`, which names the first option
/// out of its range. A type parameter of the options is a [`Real`](crate::Real).
///
/// A field is `name: type = default`, followed by those of these parts that it needs, in this
/// order, and a semicolon:
/// - `unit "..."`,
/// - `range "..."`, what completes "must be", for a range that other code checks,
/// - `check(...)`, a range that `check_ranges` checks: `positive`, `finite`, `at least 0`,
///   `at least L`, `from L to H`, `above L, at most H`, where L and H are literals of the type,
/// - `setter into` for a setter that takes any value that converts into the type, or `setter own`
///   for one that is written by hand.
///
/// ```
/// use catamaran::base::options;
///
/// options! {
///     /// How leaves fall.
///     #[derive(Debug, Clone)]
///     pub struct FallOptions {
///         /// Number of leaves.
///         leaves: usize = 10, check(at least 1);
///         /// Height that they fall from.
///         height: f64 = 2.0 * 1.5, unit "m", check(above 0.0, at most 1e3);
///         /// The first to fall.
///         first: Option<usize> = None, range "the index of a leaf", setter into;
///     }
/// }
///
/// let options = FallOptions::new().height(0.0).first(3);
/// assert_eq!((options.leaves, options.first), (10, Some(3)));
/// let refused = options.check_ranges().unwrap_err();
/// assert_eq!(refused.to_string(), "height: must be above 0 and at most 1000, is 0");
/// let height = FallOptions::FIELDS[1];
/// assert_eq!([height.name, height.kind, height.default], ["height", "f64", "2.0 * 1.5"]);
/// assert_eq!([height.unit, height.range], ["m", "above 0.0, at most 1e3"]);
/// assert_eq!(height.doc, "Height that they fall from.");
/// ```
#[doc(hidden)]
#[macro_export]
macro_rules! options {
    (
        $(#[$meta:meta])*
        pub struct $options:ident$(<$generic:lifetime $(, $scalar:ident)?>)? {
            $(
                $(#[doc = $doc:literal])+
                $field:ident: $type:ty = $default:expr
                $(, unit $unit:literal)?
                $(, range $range:literal)?
                $(, check($($rule:tt)+))?
                $(, setter $setter:ident)?;
            )+
        }
    ) => {
        $(#[$meta])*
        #[non_exhaustive]
        pub struct $options$(<$generic $(, $scalar)?>)? {
            $(
                $(#[doc = $doc])+
                #[doc = concat!(
                    " Default `", stringify!($default), "`"
                    $(, " ", $unit)?
                    $(, "; must be ", $range)?
                    $(, "; must be ", stringify!($($rule)+))?,
                    "."
                )]
                pub $field: $type,
            )+
        }

        impl$(<$generic $(, $scalar: $crate::base::Real)?>)? Default
            for $options$(<$generic $(, $scalar)?>)?
        {
            fn default() -> Self {
                Self { $($field: $default),+ }
            }
        }

        impl$(<$generic $(, $scalar: $crate::base::Real)?>)? $options$(<$generic $(, $scalar)?>)? {
            /// The options, in order.
            pub const FIELDS: &'static [$crate::base::Field] = &[$(
                $crate::base::Field::new(
                    [stringify!($field), stringify!($type), stringify!($default)],
                    [
                        concat!($($unit)?),
                        concat!("" $(, $range)? $(, stringify!($($rule)+))?),
                        concat!($($doc, "\n"),+),
                    ],
                ),
            )+];

            /// Returns the defaults.
            pub fn new() -> Self {
                Self::default()
            }

            /// Returns an error that names the first option out of its range.
            #[allow(dead_code)] // some options have no ranges, or ranges that other code checks
            pub(crate) fn check_ranges(&self) -> $crate::base::Result<()> {
                $($($crate::base::options!(@check self.$field, stringify!($field), $($rule)+)?;)?)+
                Ok(())
            }

            $($crate::base::builder! { @ $($setter)? $(#[doc = $doc])+ $field $type })+
        }
    };
    (@check $value:expr, $what:expr, positive) => {
        $crate::base::positive($what, $value)
    };
    (@check $value:expr, $what:expr, finite) => {
        $crate::base::finite($what, $value)
    };
    (@check $value:expr, $what:expr, at least 0) => {
        $crate::base::at_least_zero($what, $value)
    };
    (@check $value:expr, $what:expr, at least $low:literal) => {
        $crate::base::at_least($what, $value, $low)
    };
    (@check $value:expr, $what:expr, from $low:literal to $high:literal) => {
        $crate::base::within($what, $value, $low, $high)
    };
    (@check $value:expr, $what:expr, above $low:literal, at most $high:literal) => {
        $crate::base::above($what, $value, $low, $high)
    };
}
