//! Setters of options.

/// Defines a setter for each of the listed fields, named like the field. The setter of a field
/// after `#[into]` takes any value that converts into its type; the field `par` also gets the
/// setter `threads`. For structs that have no default, or one that is a choice among several; the
/// others are declared by [`options!`](crate::options), which uses the rules with `@`.
#[doc(hidden)]
#[macro_export]
macro_rules! builder {
    ($options:ident$(<$generic:lifetime>)? { $($(#[$into:ident])? $field:ident: $type:ty,)* }) => {
        impl$(<$generic>)? $options$(<$generic>)? {
            $($crate::base::builder! { @ $($into)? $field $type })*
        }
    };
    (@ own $(#[doc = $doc:literal])* $field:ident $type:ty) => {};
    (@ into $(#[doc = $doc:literal])* $field:ident $type:ty) => {
        #[doc = concat!(
            " Sets [`", stringify!($field), "`](#structfield.", stringify!($field), ").\n"
        )]
        $(#[doc = $doc])*
        pub fn $field(mut self, $field: impl Into<$type>) -> Self {
            self.$field = $field.into();
            self
        }
    };
    (@ $(#[doc = $doc:literal])* par $type:ty) => {
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
    (@ $(#[doc = $doc:literal])* $field:ident $type:ty) => {
        #[doc = concat!(
            " Sets [`", stringify!($field), "`](#structfield.", stringify!($field), ").\n"
        )]
        $(#[doc = $doc])*
        pub fn $field(mut self, $field: $type) -> Self {
            self.$field = $field;
            self
        }
    };
}
