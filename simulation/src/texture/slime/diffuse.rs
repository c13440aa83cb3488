use super::kinds::OUTSIDE;
use super::options::Parameters;
use super::texels::Texels;

/// Blurs and evaporates a row of one species: `next = max((1 - b) p + b G p - e, 0)` with b
/// [`Parameters::blend`], e [`Parameters::evaporation`], and G the kernel (1 2 1)^T (1 2 1) / 16,
/// which repeats the texels at the border of the texture.
///
/// `texture` and `marks` are those of the species; `row` is below the size. With a seam-aware blur,
/// texels outside of charts become 0, and [`diffuse_border`] computes those at borders of charts.
/// `rows` is a buffer of four rows.
///
/// ```
/// use catamaran_simulation::texture::slime::{Options, Surface, Texels, diffuse_row};
///
/// let parameters = Options::new().agents(1).size(32).parameters()?;
/// let texels = Texels::new(&Surface::tile()?, 32)?;
/// // An agent has marked texel 5 of row 3.
/// let (texture, mut marks) = (vec![0.0; 32 * 32], vec![0; 32]);
/// marks[3] = 1 << 5;
/// let (mut rows, mut next) = (vec![0.0; 4 * 32], vec![0.0; 32]);
/// diffuse_row(&parameters, texels.kinds(), &texture, &marks, 3, &mut rows, &mut next);
/// assert!(next[5] > next[4] && next[4] > 0.0 && next[20] == 0.0);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn diffuse_row(
    parameters: &Parameters,
    kinds: &[u8],
    texture: &[f32],
    marks: &[u32],
    row: usize,
    rows: &mut [f32],
    next: &mut [f32],
) {
    let size = parameters.size as usize;
    let [above, below] = [row.saturating_sub(1), (row + 1).min(size - 1)];
    let (pheromone, sums) = rows.split_at_mut(size);
    for (i, source) in [above, below, row].into_iter().enumerate() {
        let from = source * size..(source + 1) * size;
        marked(&texture[from.clone()], &marks[from.start / 32..from.end / 32], pheromone);
        sum_along(pheromone, &mut sums[i * size..(i + 1) * size]);
    }
    // The row itself came last, so that `pheromone` holds it.
    let (up, rest) = sums.split_at(size);
    let (down, middle) = rest.split_at(size);
    let (blend, evaporation) = (parameters.blend, parameters.evaporation);
    for i in 0..size {
        let blurred = ((up[i] + down[i]) + 2.0 * middle[i]) * 0.0625;
        let p = pheromone[i];
        next[i] = (p + blend * (blurred - p) - evaporation).max(0.0);
    }
    if parameters.seam_aware != 0 {
        let kinds = &kinds[row * size..(row + 1) * size];
        for (x, &kind) in next.iter_mut().zip(kinds) {
            *x = if kind == OUTSIDE { 0.0 } else { *x };
        }
    }
}

/// Copies a row, with 1 where it is marked.
fn marked(texture: &[f32], marks: &[u32], out: &mut [f32]) {
    for ((out, from), &word) in out.chunks_mut(32).zip(texture.chunks(32)).zip(marks) {
        for (bit, (out, &x)) in out.iter_mut().zip(from).enumerate() {
            *out = if word >> bit & 1 == 1 { 1.0 } else { x };
        }
    }
}

/// Computes the sum (1 2 1) along a row.
fn sum_along(row: &[f32], out: &mut [f32]) {
    let last = row.len() - 1;
    out[0] = (row[0] + row[1]) + 2.0 * row[0];
    out[last] = (row[last - 1] + row[last]) + 2.0 * row[last];
    for (out, w) in out[1..last].iter_mut().zip(row.windows(3)) {
        *out = (w[0] + w[2]) + 2.0 * w[1];
    }
}

/// Computes [`diffuse_row`] for texel number `border` of [`Texels::border`], with the kernel of its
/// links: `(G p)_i = p_i + sum_j w_ij (p_j - p_i)`, summed in their order.
pub fn diffuse_border(
    parameters: &Parameters,
    texels: &Texels,
    texture: &[f32],
    marks: &[u32],
    border: usize,
) -> f32 {
    let value = |t: u32| {
        if marks[t as usize / 32] >> (t % 32) & 1 == 1 { 1.0 } else { texture[t as usize] }
    };
    let p = value(texels.border()[border]);
    let mut flow = 0.0;
    let starts = texels.link_starts();
    for link in starts[border] as usize..starts[border + 1] as usize {
        flow += texels.link_weights()[link] * (value(texels.links()[link]) - p);
    }
    (p + parameters.blend * flow - parameters.evaporation).max(0.0)
}
