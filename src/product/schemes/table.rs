//! Schemes, and the notation in which their tables are written.

/// The part of a product of two sums of blocks that is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ProductKind {
    /// All of it.
    Gemm,
    /// Left and right are different sums, and only the lower triangle is used.
    Gemmt,
    /// Left and right are the same sum (when A = B), and only the lower triangle is used.
    Syrk,
    /// Left and right are the same sum, and all of it is used: half is computed, half mirrored.
    SyrkFull,
}

/// `coefficient * block(row, col)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Term {
    /// Small integer, not zero.
    pub coefficient: i8,
    /// Block row.
    pub row: usize,
    /// Block column.
    pub col: usize,
}

/// One product of a scheme: `sum(outputs) += (sum left)^T (sum right)`.
#[derive(Debug, Clone)]
pub struct SchemeProduct {
    /// The part of the product that is used.
    pub kind: ProductKind,
    /// Sum of blocks of A.
    pub left: Vec<Term>,
    /// Sum of blocks of B.
    pub right: Vec<Term>,
    /// Blocks of C that it is added to.
    pub outputs: Vec<Term>,
}

/// A bilinear scheme for one level of recursion.
#[derive(Debug, Clone)]
pub struct Scheme {
    /// Its name.
    pub name: &'static str,
    /// Whether only the lower triangle of C is computed.
    pub symmetric: bool,
    /// Block rows of A and B.
    pub inner: usize,
    /// Block columns of A, block rows of C.
    pub left: usize,
    /// Block columns of B and of C.
    pub right: usize,
    /// The products, in the order in which they are computed.
    pub products: Vec<SchemeProduct>,
}

impl Scheme {
    /// Returns whether the scheme replaces products by additions, which adds to the rounding error.
    ///
    /// ```
    /// use catamaran::product::schemes::SchemeId;
    ///
    /// let fast = SchemeId::ALL.into_iter().filter(|id| id.scheme().is_fast()).count();
    /// assert!(!SchemeId::Classical2.scheme().is_fast() && fast == 5);
    /// ```
    pub fn is_fast(&self) -> bool {
        self.products.iter().any(|p| p.left.len() > 1 || p.right.len() > 1 || p.outputs.len() > 1)
    }

    /// Returns the multiplications of one level over the classical count, where a half product
    /// counts half.
    ///
    /// ```
    /// use catamaran::product::schemes::SchemeId;
    ///
    /// assert_eq!(SchemeId::Strassen.scheme().flop_ratio(), 7.0 / 8.0);
    /// ```
    pub fn flop_ratio(&self) -> f64 {
        let cost = |p: &SchemeProduct| if p.kind == ProductKind::Gemm { 2.0 } else { 1.0 };
        let ours: f64 = self.products.iter().map(cost).sum();
        let columns = if self.symmetric { self.left } else { 2 * self.right };
        ours / (self.inner * self.left * columns) as f64
    }
}

/// A scheme as written down: sums in the notation of the documentation of [`super`].
pub(super) struct Table {
    pub(super) name: &'static str,
    pub(super) symmetric: bool,
    /// inner, left, right
    pub(super) blocks: (usize, usize, usize),
    pub(super) products: &'static [(ProductKind, &'static str, &'static str, &'static str)],
}

impl Table {
    pub(super) fn parse(&self) -> Scheme {
        let (inner, left, right) = self.blocks;
        let product = |&(kind, l, r, o): &(ProductKind, &str, &str, &str)| SchemeProduct {
            kind,
            left: parse_sum(l, 'a'),
            right: parse_sum(r, 'b'),
            outputs: parse_sum(o, 'c'),
        };
        Scheme {
            name: self.name,
            symmetric: self.symmetric,
            inner,
            left,
            right,
            products: self.products.iter().map(product).collect(),
        }
    }
}

/// Parses `"a00 + a11 - 2a01"`; the tables are constants and the tests parse them all.
fn parse_sum(sum: &str, letter: char) -> Vec<Term> {
    let mut sign = 1;
    let mut terms = Vec::new();
    for word in sum.split_whitespace() {
        match word {
            "+" => sign = 1,
            "-" => sign = -1,
            _ => {
                let (unsigned, sign) = match word.strip_prefix('-') {
                    Some(rest) => (rest, -1),
                    None => (word, sign),
                };
                let (factor, index) = unsigned.split_once(letter).expect("a block name");
                let digit = |i: usize| usize::from(index.as_bytes()[i] - b'0');
                let factor: i8 = if factor.is_empty() { 1 } else { factor.parse().expect("int") };
                terms.push(Term { coefficient: sign * factor, row: digit(0), col: digit(1) });
            }
        }
    }
    terms
}
