//! Numbers of bytes in messages.

/// Returns a number of bytes in the largest unit, up to GiB, of which there is at least one.
pub(crate) fn byte_size(bytes: f64) -> String {
    let in_unit = |power: i32| bytes / 1024_f64.powi(power);
    match bytes {
        _ if in_unit(3) >= 1e6 => format!("{:.1e} GiB", in_unit(3)),
        _ if in_unit(3) >= 1.0 => format!("{:.2} GiB", in_unit(3)),
        _ if in_unit(2) >= 1.0 => format!("{:.2} MiB", in_unit(2)),
        _ if in_unit(1) >= 1.0 => format!("{:.2} KiB", in_unit(1)),
        _ => format!("{bytes:.0} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_in_the_largest_unit() {
        for (bytes, size) in [
            (0.0, "0 bytes"),
            (1023.0, "1023 bytes"),
            (1024.0, "1.00 KiB"),
            (15_999.0, "15.62 KiB"),
            (1.5 * 1024.0 * 1024.0, "1.50 MiB"),
            (1e9, "953.67 MiB"),
            (f64::from(1 << 30), "1.00 GiB"),
            (1e18, "9.3e8 GiB"),
        ] {
            assert_eq!(byte_size(bytes), size);
        }
    }
}
