//! Colours of files, converted to the range 0 to 1.

/// The note about colours that only some vertices have, and that are left out.
const SOME_COLORS: &str = "left out colours, which only some of the vertices have";

/// Colours with a larger number are taken to be from 0 to 255, also where their numbers are not
/// whole: brighter light than this many times white is rare.
const BRIGHTEST: f64 = 16.0;

/// The colours of the vertices of a text file, some of which count from 0 to 1 and some from 0 to
/// 255.
#[derive(Default)]
pub(super) struct Colors {
    pub values: Vec<[f64; 4]>,
    pub has_opacity: bool,
    /// Whether a number is written with a point or an exponent, as those from 0 to 1 are.
    has_point: bool,
}

impl Colors {
    /// Looks at a number of a colour as it is written.
    pub fn see(&mut self, word: &[u8]) {
        self.has_point |= word.iter().any(|byte| matches!(byte, b'.' | b'e' | b'E'));
    }

    /// Returns the colours of `count` vertices from 0 to 1, `None` unless each vertex has one.
    /// Notes what is left out, and where the numbers may be meant otherwise.
    pub fn finish(mut self, count: usize, notes: &mut Vec<String>) -> Option<Vec<[f64; 4]>> {
        if count == 0 || self.values.len() != count {
            if !self.values.is_empty() {
                notes.push(SOME_COLORS.into());
            }
            return None;
        }
        let given = if self.has_opacity { 4 } else { 3 };
        let numbers = || self.values.iter().flat_map(move |color| &color[..given]).copied();
        let largest = numbers().fold(0.0, f64::max);
        let above = |limit: f64| numbers().filter(|&x| x > limit).count();
        if largest <= 1.0 {
            return Some(self.values);
        }
        if self.has_point && largest <= BRIGHTEST {
            notes.push(format!(
                "took colours to be from 0 to 1, although numbers of them are above 1: {}, the \
                 largest is {largest}",
                above(1.0)
            ));
            return Some(self.values);
        }
        if self.has_point || largest > 255.0 {
            notes.push(format!(
                "took colours to be from 0 to 255: the largest number is {largest}, and {} are \
                 above 255",
                above(255.0)
            ));
        }
        for x in self.values.iter_mut().flat_map(|color| &mut color[..given]) {
            *x /= 255.0;
        }
        Some(self.values)
    }
}

/// Returns the byte that is 255 times a colour; `None` where that is not a whole number.
pub(super) fn byte(x: f64) -> Option<u8> {
    nearest_byte(x).filter(|&byte| f64::from(byte) / 255.0 == x)
}

/// Returns the byte nearest to 255 times a colour; `None` for a colour that is not from 0 to 1.
pub(super) fn nearest_byte(x: f64) -> Option<u8> {
    (0.0..=1.0).contains(&x).then_some((x * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sign_does_not_decide_how_numbers_count() {
        let first = |words: [&str; 2]| {
            let mut colors = Colors::default();
            for word in words {
                colors.see(word.as_bytes());
                let x: f64 = word.parse().unwrap();
                colors.values.push([x, x, x, 1.0]);
            }
            let mut notes = Vec::new();
            let found = colors.finish(2, &mut notes).unwrap();
            (found[0][0], notes.len())
        };
        assert_eq!(first(["16", "2"]), (16.0 / 255.0, 0));
        assert_eq!(first(["+16", "-0"]), (16.0 / 255.0, 0));
        assert_eq!(first(["1.5", "+1"]), (1.5, 1));
        assert_eq!(first(["15e-1", "1"]), (1.5, 1));
    }
}
