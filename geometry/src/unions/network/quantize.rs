use super::Parameter;

/// Largest whole number of a quantized weight.
const LARGEST: f32 = 127.0;
/// From this number up to its double, numbers in single precision are whole.
const ROUNDING: f32 = 1.5 * (1 << 23) as f32;

/// Returns for each column of these weights the value of one unit: the largest weight is 127 units.
pub fn column_units(weights: &[f32], columns: usize) -> Vec<f32> {
    let mut units = vec![0.0f32; columns];
    for row in weights.chunks_exact(columns) {
        units.iter_mut().zip(row).for_each(|(unit, x)| *unit = unit.max(x.abs()));
    }
    // So small that it changes no weight, and the division is defined.
    units.iter_mut().for_each(|unit| *unit = (*unit / LARGEST).max(f32::MIN_POSITIVE));
    units
}

/// Returns the nearest whole numbers of units, from -127 to 127.
pub fn to_integers(weights: &[f32], units: &[f32]) -> Vec<f32> {
    let mut whole = weights.to_vec();
    for row in whole.chunks_exact_mut(units.len()) {
        for (x, unit) in row.iter_mut().zip(units) {
            // Adding and subtracting rounds numbers below 2^22, and is vectorized, unlike `round`.
            *x = ((*x / unit).clamp(-LARGEST, LARGEST) + ROUNDING) - ROUNDING;
        }
    }
    whole
}

/// Converts whole numbers of units back to weights.
pub fn from_integers(whole: &mut [f32], units: &[f32]) {
    for row in whole.chunks_exact_mut(units.len()) {
        row.iter_mut().zip(units).for_each(|(x, unit)| *x *= unit);
    }
}

/// Returns whether these parameters are stored as whole numbers: the matrices, which are nearly all
/// parameters.
pub fn is_quantized(parameter: &Parameter) -> bool {
    parameter.rows > 1
}

/// Rounds a parameter as a file stores it: weights to one of 255 numbers for each column, others
/// unchanged.
pub fn quantize(parameter: &Parameter, part: &mut [f32]) {
    if is_quantized(parameter) {
        let units = column_units(part, parameter.columns);
        part.copy_from_slice(&to_integers(part, &units));
        from_integers(part, &units);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    #[test]
    fn weights_are_kept_to_half_a_unit_of_their_column() {
        let mut rng = Rng::new(6);
        const COLUMNS: usize = 5;
        let weights: Vec<f32> =
            (0..40).map(|at| (rng.normal() * 10f64.powi((at % COLUMNS) as i32)) as f32).collect();
        let units = column_units(&weights, COLUMNS);
        let mut whole = to_integers(&weights, &units);
        assert!(whole.iter().all(|x| x.abs() <= 127.0 && x.fract() == 0.0));
        let kept = whole.clone();
        from_integers(&mut whole, &units);
        for (at, (x, y)) in whole.iter().zip(&weights).enumerate() {
            assert!((x - y).abs() <= 0.5001 * units[at % COLUMNS], "{at}: {x} {y}");
        }
        assert_eq!(to_integers(&whole, &units), kept);
        assert!(column_units(&[0.0; 4], 2).iter().all(|unit| *unit > 0.0));
    }
}
