//! Sums of a few numbers, rounded once.

/// Returns the f64 nearest to the sum of three numbers.
#[inline(always)]
pub(super) fn nearest([high, middle, low]: [f64; 3]) -> f64 {
    let (tail, tail_error) = two_sum(middle, low);
    let (head, head_error) = two_sum(high, tail);
    head + sum_to_odd(head_error, tail_error)
}

/// Returns `x + y` and its rounding error (Knuth 1969).
#[inline(always)]
fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let part = sum - x;
    (sum, (x - (sum - part)) + (y - part))
}

/// Returns `x + y`, rounded to an odd mantissa if it is not exact. Added to a larger number, it is
/// rounded as if it had all its bits (Boldo and Melquiond 2008): the result is the nearest number,
/// whichever representatives the residues were.
#[inline(always)]
fn sum_to_odd(x: f64, y: f64) -> f64 {
    let (sum, error) = two_sum(x, y);
    let bits = sum.to_bits();
    let towards =
        if (error > 0.0) == (sum > 0.0) { bits.wrapping_add(1) } else { bits.wrapping_sub(1) };
    if error != 0.0 && bits & 1 == 0 { f64::from_bits(towards) } else { sum }
}
