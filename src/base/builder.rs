//! Setters of options.

/// Defines `new`, which returns the defaults, and a setter for each of the listed fields, named
/// like the field. The setter of a field after `#[into]` takes any value that converts into its
/// type; the field `par` also gets the setter `threads`. A type parameter of the options is a
/// [`Real`](crate::Real).
///
/// With `setters only` the macro does not define `new`.
#[doc(hidden)]
#[macro_export]
macro_rules! builder {
    ($options:ident$(<$generic:lifetime $(, $scalar:ident)?>)? { $($fields:tt)* }) => {
        impl$(<$generic $(, $scalar: $crate::base::Real)?>)? $options$(<$generic $(, $scalar)?>)? {
            /// Returns the defaults.
            pub fn new() -> Self {
                Self::default()
            }
        }

        $crate::base::builder! {
            setters only $options$(<$generic $(, $scalar)?>)? { $($fields)* }
        }
    };
    (setters only $options:ident$(<$generic:lifetime $(, $scalar:ident)?>)? {
        $($(#[$into:ident])? $field:ident: $type:ty,)*
    }) => {
        impl$(<$generic $(, $scalar: $crate::base::Real)?>)? $options$(<$generic $(, $scalar)?>)? {
            $($crate::base::builder! { @ $($into)? $field $type })*
        }
    };
    (@ into $field:ident $type:ty) => {
        #[doc = concat!("Sets [`", stringify!($field), "`](#structfield.", stringify!($field), ").")]
        pub fn $field(mut self, $field: impl Into<$type>) -> Self {
            self.$field = $field.into();
            self
        }
    };
    (@ par $type:ty) => {
        /// Sets the [threads](#structfield.par).
        pub fn par(mut self, par: $type) -> Self {
            self.par = par;
            self
        }

        /// Sets the number of threads: [`Par::Threads`](crate::Par::Threads).
        pub fn threads(self, threads: usize) -> Self {
            self.par($crate::base::Par::Threads(threads))
        }
    };
    (@ $field:ident $type:ty) => {
        #[doc = concat!("Sets [`", stringify!($field), "`](#structfield.", stringify!($field), ").")]
        pub fn $field(mut self, $field: $type) -> Self {
            self.$field = $field;
            self
        }
    };
}
