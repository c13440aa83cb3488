/// The measure t of the speed of convergence. With d_k the length of step k, P iterations and
/// f(d) = 1 / (1 + exp(d + theta) - exp(theta)), which is 1 for a step of length 0 and near 0 for a
/// long step:
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gradient {
    /// Equation 7.3: t = P - (f(d_0) + ... + f(d_P)), P + 1 terms: from -1 (at a root) to P. P + 1
    /// steps are taken.
    Thesis,
    /// The formula of the authors' shader: t = (P - (f(e_0) + ... + f(e_{P-1}))) / P, from 0 to 1,
    /// with e_k = d_k^2, without the square root.
    Shader,
}
