//! Decimal numbers.

/// The integers up to here, and the powers of ten up to [`EXACT_SCALE`], are numbers of f64, so
/// that a division rounds once.
const EXACT: u64 = 1 << 53;
const EXACT_SCALE: i32 = 22;

/// Returns the number `value / 10^scale`, rounded to the nearest.
pub fn decimal(value: i128, scale: i32) -> f64 {
    if value.unsigned_abs() <= u128::from(EXACT) && (0..=EXACT_SCALE).contains(&scale) {
        return value as f64 / 10_f64.powi(scale);
    }
    // The standard library rounds the number that a text says.
    format!("{value}e{}", -i64::from(scale)).parse().unwrap_or(f64::NAN)
}

/// Returns the integer in two's complement, the highest byte first; `None` beyond 16 bytes, where
/// bytes that repeat the sign do not count.
pub fn big_endian(bytes: &[u8]) -> Option<i128> {
    let sign = if bytes.first().is_some_and(|byte| byte & 0x80 != 0) { 0xff } else { 0 };
    let (above, last) = bytes.split_at(bytes.len().saturating_sub(16));
    let mut whole = [sign; 16];
    whole[16 - last.len()..].copy_from_slice(last);
    let value = i128::from_be_bytes(whole);
    let is_whole = above.iter().all(|&byte| byte == sign) && (value < 0) == (sign != 0);
    is_whole.then_some(value)
}

/// Returns the integer as [`big_endian`] does, of bytes of which the lowest is the first.
pub fn little_endian<const N: usize>(mut bytes: [u8; N]) -> Option<i128> {
    bytes.reverse();
    big_endian(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_the_nearest_numbers() {
        assert_eq!(decimal(12345, 2), 123.45);
        assert_eq!(decimal(-7, 0), -7.0);
        assert_eq!(decimal(3, -2), 300.0);
        let large = "1234567890123.4567890123".parse().unwrap();
        assert_eq!(decimal(12345678901234567890123, 10), large);
        assert_eq!(decimal(1, 30), 1e-30);
    }

    #[test]
    fn bytes_are_integers_with_a_sign() {
        assert_eq!(big_endian(&[0xff, 0x85]), Some(-123));
        assert_eq!(big_endian(&[1, 0]), Some(256));
        assert_eq!(big_endian(&[]), Some(0));
        assert_eq!([[0; 17], [0xff; 17]].map(|bytes| big_endian(&bytes)), [Some(0), Some(-1)]);
        let mut beyond = [0; 17];
        beyond[1] = 0x80;
        assert_eq!([[1; 17], beyond].map(|bytes| big_endian(&bytes)), [None; 2]);
        assert_eq!([little_endian([0x85, 0xff]), little_endian([0, 1])], [Some(-123), Some(256)]);
    }
}
