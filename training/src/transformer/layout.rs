use catamaran_geometry::unions::network::{K, Parameter};

use crate::network::random_parameters;

/// Number of channels of a token.
pub const WIDTH: usize = 32;
/// Number of heads of every attention.
pub const HEADS: usize = 8;
/// Number of layers of `T_A` and of `T_B`.
pub const LAYERS: [usize; 2] = [6, 3];
/// Number of hidden neurons of a layer of `T_A` and of `T_B`.
const HIDDEN: [usize; 2] = [64, 32];
/// Number of learned channels for each position.
pub const POSITIONAL: usize = 16;
/// Number of learned multiples of an offset.
pub const MULTIPLES: usize = WIDTH - POSITIONAL - 1;
/// Number of elements of the largest matrix of weights.
pub const LARGEST: usize = WIDTH * 2 * WIDTH;

/// The operation of a residual branch between its linear maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Attention to the tokens of the same spectrum.
    Own,
    /// Attention to the embedded tokens of the other spectrum.
    Other,
    /// Hidden neurons, rectified.
    Hidden,
}

/// Places of the parameters of a residual branch. A layer is two or three branches.
#[derive(Debug, Clone, Copy)]
pub struct Branch {
    /// The operation.
    pub kind: Kind,
    /// Scale and shift of the normalization before the branch.
    pub norm: [Parameter; 2],
    /// Weights and bias of the queries, or of the hidden neurons.
    pub inner: [Parameter; 2],
    /// Weights and bias of the keys, then the values, of an attention.
    pub source: Option<[Parameter; 2]>,
    /// Weights and bias of the output, which is added to the tokens.
    pub down: [Parameter; 2],
}

/// Places of the parameters of `T_A` or `T_B`.
#[derive(Debug, Clone)]
pub struct Stack {
    /// The branches.
    pub branches: Vec<Branch>,
    /// Scale and shift of the normalization after the last branch.
    pub norm: [Parameter; 2],
}

/// Places of all parameters in one array.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Learned channels, `POSITIONAL` for each position.
    pub positions: Parameter,
    /// Factors of the multiples of an offset.
    pub multiples: Parameter,
    /// `T_A`.
    pub first: Stack,
    /// `T_B`.
    pub second: Stack,
    /// Weights and bias of the predicted offset.
    pub head: [Parameter; 2],
    /// Name and place of every matrix, in order.
    pub named: Vec<(String, Parameter)>,
    /// Number of parameters.
    pub len: usize,
}

impl Layout {
    /// Creates the layout with `layers` layers in `T_A` and `T_B`: [`LAYERS`], or fewer in tests.
    pub fn new(layers: [usize; 2]) -> Self {
        let mut list = List::default();
        let positions = list.matrix("positions".into(), K, POSITIONAL);
        let multiples = list.matrix("multiples".into(), 1, MULTIPLES);
        let kinds = [Kind::Own, Kind::Other, Kind::Hidden];
        let first = list.stack("first", &kinds.repeat(layers[0]), HIDDEN[0]);
        let kinds = [Kind::Own, Kind::Hidden];
        let second = list.stack("second", &kinds.repeat(layers[1]), HIDDEN[1]);
        let head = list.linear("head", WIDTH, 1);
        let List { named, len } = list;
        Self { positions, multiples, first, second, head, named, len }
    }

    /// Draws initial parameters.
    pub fn initial(&self, seed: u64) -> Vec<f32> {
        let depth = self.first.branches.len() + self.second.branches.len();
        random_parameters(&self.named, depth, seed)
    }
}

#[derive(Default)]
struct List {
    named: Vec<(String, Parameter)>,
    len: usize,
}

impl List {
    fn matrix(&mut self, name: String, rows: usize, columns: usize) -> Parameter {
        let parameter = Parameter { start: self.len, rows, columns };
        self.len += rows * columns;
        self.named.push((name, parameter));
        parameter
    }

    /// Adds weights, and a bias for each column. (For a normalization: scale and shift.)
    fn linear(&mut self, name: &str, rows: usize, columns: usize) -> [Parameter; 2] {
        [("weight", rows), ("bias", 1)]
            .map(|(part, rows)| self.matrix(format!("{name}.{part}"), rows, columns))
    }

    fn stack(&mut self, name: &str, kinds: &[Kind], hidden: usize) -> Stack {
        let branch = |(number, &kind): (usize, &Kind)| {
            let name = |part: &str| format!("{name}.{number}.{part}");
            let attends = kind != Kind::Hidden;
            let inner = if attends { WIDTH } else { hidden };
            Branch {
                kind,
                norm: self.linear(&name("norm"), 1, WIDTH),
                inner: self.linear(&name("inner"), WIDTH, inner),
                source: attends.then(|| self.linear(&name("source"), WIDTH, 2 * WIDTH)),
                down: self.linear(&name("down"), inner, WIDTH),
            }
        };
        let branches = kinds.iter().enumerate().map(branch).collect();
        Stack { branches, norm: self.linear(&format!("{name}.norm"), 1, WIDTH) }
    }
}
