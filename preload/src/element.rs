//! The elements of matrices, real and complex, and their products.

use std::ops::{Add, Mul};

use catamaran::faer::{MatMut, MatRef, c32, c64};
use catamaran::product::{ComplexPlan, aha_planned, ahb_planned, ata_planned, atb_planned};
use catamaran::{AtaOptions, Par, Plan, Result};

use crate::request::{Kind, Shape};

/// A plan of the crate.
#[derive(Debug, Clone)]
pub enum Planned {
    Real(Plan),
    Complex(Box<ComplexPlan>),
}

impl Planned {
    /// Returns [`Plan::expected_ratio`].
    pub fn expected_ratio(&self) -> f64 {
        match self {
            Self::Real(plan) => plan.expected_ratio(),
            Self::Complex(plan) => plan.expected_ratio(),
        }
    }

    /// Returns [`Plan::isa`].
    pub fn isa(&self) -> Option<&'static str> {
        match self {
            Self::Real(plan) => plan.isa(),
            Self::Complex(plan) => plan.isa(),
        }
    }

    /// Returns [`Plan::is_exact`].
    #[cfg(test)]
    pub fn is_exact(&self) -> bool {
        match self {
            Self::Real(plan) => plan.is_exact(),
            Self::Complex(plan) => plan.is_exact(),
        }
    }
}

/// f32, f64, or complex numbers of them.
pub trait Element:
    Copy + PartialEq + Add<Output = Self> + Mul<Output = Self> + Send + Sync + 'static
{
    const ZERO: Self;
    const ONE: Self;
    const IS_COMPLEX: bool;
    /// Bytes of the real and of the imaginary part.
    const PART: usize;

    /// Returns the real part.
    fn real(self) -> Self;

    /// Returns a plan for products of this shape.
    fn plan(shape: &Shape, options: &AtaOptions<'_>) -> Result<Planned>;

    /// Returns the bytes that a product by `plan` takes on so many threads.
    fn scratch(plan: &Planned, threads: usize) -> usize;

    /// Computes `C := alpha L^T R + beta C`, with conjugates as in the plan, which is for these
    /// elements.
    fn multiply(
        plan: &Planned,
        alpha: Self,
        left: MatRef<'_, Self>,
        right: Option<MatRef<'_, Self>>,
        beta: Self,
        c: MatMut<'_, Self>,
        options: &AtaOptions<'_>,
    ) -> Result<()>;
}

/// Message of a panic for a plan of other elements, which is never passed.
const OTHER: &str = "a plan is one of the elements of its request";

macro_rules! real {
    ($t:ty) => {
        impl Element for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const IS_COMPLEX: bool = false;
            const PART: usize = size_of::<$t>();

            fn real(self) -> Self {
                self
            }

            fn plan(shape: &Shape, options: &AtaOptions<'_>) -> Result<Planned> {
                let [m, n, k] = shape.sides;
                let plan = match shape.kind {
                    Kind::Symmetric => Plan::ata::<$t>(k, m, options),
                    Kind::General => Plan::atb::<$t>(k, m, n, options),
                    Kind::Triangle => Plan::atb_triangle::<$t>(k, m, options),
                };
                plan.map(Planned::Real)
            }

            fn scratch(plan: &Planned, threads: usize) -> usize {
                let Planned::Real(plan) = plan else { unreachable!("{OTHER}") };
                let len = plan.scratch_len::<$t>(Par::Threads(threads));
                len.saturating_mul(Self::PART)
            }

            fn multiply(
                plan: &Planned,
                alpha: Self,
                left: MatRef<'_, Self>,
                right: Option<MatRef<'_, Self>>,
                beta: Self,
                c: MatMut<'_, Self>,
                options: &AtaOptions<'_>,
            ) -> Result<()> {
                let Planned::Real(plan) = plan else { unreachable!("{OTHER}") };
                match right {
                    None => ata_planned(plan, alpha, left, beta, c, options, None),
                    Some(right) => atb_planned(plan, alpha, left, right, beta, c, options, None),
                }
            }
        }
    };
}

macro_rules! complex {
    ($t:ty, $real:ty) => {
        impl Element for $t {
            const ZERO: Self = <$t>::new(0.0, 0.0);
            const ONE: Self = <$t>::new(1.0, 0.0);
            const IS_COMPLEX: bool = true;
            const PART: usize = size_of::<$real>();

            fn real(self) -> Self {
                <$t>::new(self.re, 0.0)
            }

            fn plan(shape: &Shape, options: &AtaOptions<'_>) -> Result<Planned> {
                let ([m, n, k], [left, right]) = (shape.sides, shape.conjugated);
                let (plan, conjugated) = match shape.kind {
                    Kind::Symmetric => (ComplexPlan::aha::<$real>(k, m, options)?, !left),
                    // `gemmt` is exported for real elements only.
                    Kind::Triangle => unreachable!("gemmt of complex elements"),
                    _ if left != right => (ComplexPlan::ahb::<$real>(k, m, n, options)?, right),
                    _ => (ComplexPlan::atb::<$real>(k, m, n, options)?, right),
                };
                let plan = if conjugated { plan.conjugated() } else { plan };
                Ok(Planned::Complex(Box::new(plan)))
            }

            fn scratch(plan: &Planned, threads: usize) -> usize {
                let Planned::Complex(plan) = plan else { unreachable!("{OTHER}") };
                let len = plan.scratch_len::<$real>(Par::Threads(threads));
                len.saturating_mul(Self::PART)
            }

            fn multiply(
                plan: &Planned,
                alpha: Self,
                left: MatRef<'_, Self>,
                right: Option<MatRef<'_, Self>>,
                beta: Self,
                c: MatMut<'_, Self>,
                options: &AtaOptions<'_>,
            ) -> Result<()> {
                let Planned::Complex(plan) = plan else { unreachable!("{OTHER}") };
                match right {
                    None => aha_planned(plan, alpha.re, left, beta.re, c, options),
                    Some(right) => ahb_planned(plan, alpha, left, right, beta, c, options),
                }
            }
        }
    };
}

real!(f32);
real!(f64);
complex!(c32, f32);
complex!(c64, f64);
