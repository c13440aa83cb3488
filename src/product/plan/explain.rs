//! Describes a plan in words.

use std::fmt::{Display, Formatter, Result};

use super::Plan;
use super::problem::Op;
use super::recursion::{Base, Recursion};
use super::strategy::{Exact, Fused, Strategy, Tasks};
use crate::product::schemes::SchemeId;

impl Display for Plan {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let (m, n, k) = (self.problem.m, self.problem.n, self.problem.k);
        match self.problem.op {
            Op::Syrk => writeln!(f, "C = A^T A, A {m} x {n}, {}", self.scalar)?,
            Op::Gemmt => {
                writeln!(f, "one triangle of C = A^T B, A and B {m} x {n}, {}", self.scalar)?;
            }
            Op::Gemm => writeln!(f, "C = A^T B, A {m} x {n}, B {m} x {k}, {}", self.scalar)?,
        }
        match &self.strategy {
            Strategy::Direct(isa) => {
                writeln!(
                    f,
                    "direct     one small product by {}, on the calling thread",
                    isa.name()
                )?;
            }
            Strategy::Fused(fused) => fused.fmt(f)?,
            Strategy::Tasks(tasks) => {
                tasks.fmt(f)?;
                let own = tasks.worker_scratch_len(self.problem.op);
                let partial = (tasks.cut.slabs - 1) * n * k;
                writeln!(f, "scratch    {own} elements a thread, {partial} for partial results")?;
            }
            Strategy::Exact(exact) => exact.fmt(f)?,
        }
        let (seconds, classical) = (self.seconds, self.classical_seconds);
        write!(f, "estimate   {seconds:.3} s on one core ({classical:.3} s classical)")
    }
}

impl Plan {
    /// Returns what the plan does in a few words without commas, for tables: `direct`, `classical`,
    /// `exact`, or the schemes of its fast levels, the symmetric ones first.
    pub fn scheme(&self) -> String {
        let recursion = match &self.strategy {
            Strategy::Direct(_) => return "direct".into(),
            Strategy::Exact(_) => return "exact".into(),
            Strategy::Fused(fused) => &fused.recursion,
            Strategy::Tasks(tasks) => &tasks.recursion,
        };
        if !self.is_fast() {
            return "classical".into();
        }
        let schemes = recursion.symmetric.iter().chain(&recursion.general);
        schemes.map(ToString::to_string).collect::<Vec<_>>().join(" + ")
    }

    /// Returns the name of the instruction set of our own kernels; `None` where a library computes.
    pub fn isa(&self) -> Option<&'static str> {
        match &self.strategy {
            Strategy::Direct(isa) => Some(isa.name()),
            Strategy::Fused(fused) => Some(fused.isa.name()),
            Strategy::Exact(exact) => Some(exact.isa.name()),
            Strategy::Tasks(_) => None,
        }
    }
}

impl Display for Exact {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let (moduli, isa) = (self.layout.moduli, self.isa.name());
        if self.small {
            return writeln!(f, "exact      products of integers by {isa}: the product is small");
        }
        writeln!(f, "exact      modulo {moduli} numbers of 8 bits, by {isa}")
    }
}

impl Display for Fused {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let products = match self.slabs.first().map_or(0, |slab| slab.program.len()) {
            1 => "one product".to_owned(),
            count => format!("{count} products with the additions fused"),
        };
        let slabs = slabs(self.slabs.len());
        writeln!(f, "kernels    {}, {products}, {slabs} of rows", self.isa.name())?;
        write_recursion(f, &self.recursion, self.is_fast())?;
        if self.is_fast() {
            writeln!(f, "columns    scaled by powers of two when their norms differ much")?;
        }
        Ok(())
    }
}

impl Display for Tasks {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let (tasks, levels, slabs) = (self.tasks.len(), self.tree.depth(), slabs(self.cut.slabs));
        writeln!(f, "tasks      {tasks} blocks of C on {levels} levels, {slabs} of rows")?;
        write_recursion(f, &self.recursion, self.fast)?;
        if self.fast && self.guarded {
            writeln!(f, "columns    classical products instead when their norms differ much")?;
        }
        Ok(())
    }
}

fn slabs(count: usize) -> String {
    format!("{count} {}", if count == 1 { "slab" } else { "slabs" })
}

fn write_recursion(f: &mut Formatter<'_>, recursion: &Recursion, fast: bool) -> Result {
    let Recursion { symmetric, general, base, fast_levels } = recursion;
    let names = |ids: &[SchemeId]| {
        if ids.is_empty() {
            return "back end".to_owned();
        }
        ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", then ")
    };
    writeln!(f, "symmetric  {}", names(symmetric))?;
    writeln!(f, "general    {}", names(general))?;
    if !(symmetric.is_empty() && general.is_empty()) {
        let Base { general, symmetric } = base;
        writeln!(
            f,
            "ends       when a block would be under {general} long, {symmetric} if symmetric"
        )?;
    }
    match *fast_levels {
        0 => writeln!(f, "fast       no level: classical products only"),
        _ if !fast => writeln!(f, "fast       no level: the blocks are too short"),
        usize::MAX => writeln!(f, "fast       as many levels as fit"),
        levels => writeln!(f, "fast       at most {levels} levels"),
    }
}
