//! Numbers in text, in the notation of a file.

use std::borrow::Cow;

use super::encoding;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Notation {
    /// A point or a comma.
    pub decimal: char,
    /// Separates groups of three digits before the decimal separator.
    pub thousands: Option<char>,
}

/// The minus sign of typesetters, and of spreadsheets in Scandinavian languages.
const MINUS: char = '\u{2212}';

/// The usual notation.
pub(super) const PLAIN: Notation = Notation { decimal: '.', thousands: None };

/// That of 1.234,5.
pub(super) const POINTS_OF_THOUSANDS: Notation = Notation { decimal: ',', thousands: Some('.') };

/// All notations, the likelier first.
pub(super) const NOTATIONS: [Notation; 8] = [
    PLAIN,
    Notation { decimal: ',', thousands: None },
    Notation { decimal: '.', thousands: Some(',') },
    POINTS_OF_THOUSANDS,
    Notation { decimal: '.', thousands: Some(' ') },
    Notation { decimal: ',', thousands: Some(' ') },
    Notation { decimal: '.', thousands: Some('\'') },
    Notation { decimal: ',', thousands: Some('\'') },
];

/// A set of notations: bit i stands for notation i.
pub(super) type Readings = u8;

/// Returns the notations in which a field is a number; no word such as `inf` is one.
pub(super) fn readings(field: &[u8]) -> Readings {
    let is_word = unwrapped(field).iter().find(|byte| byte.is_ascii_alphanumeric());
    if is_word.is_none_or(u8::is_ascii_alphabetic) {
        return 0;
    }
    let is_short = field.iter().all(|byte| byte.is_ascii_digit() || b"+-eE".contains(byte));
    if is_short && parse(field, PLAIN).is_some() {
        return Readings::MAX;
    }
    let bit = |i: usize| Readings::from(parse(field, NOTATIONS[i]).is_some()) << i;
    (0..NOTATIONS.len()).map(bit).fold(0, |all, bit| all | bit)
}

/// Returns the number in a field without blanks around it; `D` is an exponent as `E` is.
#[inline]
pub(super) fn parse(field: &[u8], notation: Notation) -> Option<f64> {
    if notation.decimal == '.'
        && let Some(value) = std::str::from_utf8(field).ok().and_then(|text| text.parse().ok())
    {
        return Some(value);
    }
    in_notation(field, notation)
}

fn in_notation(field: &[u8], notation: Notation) -> Option<f64> {
    let text = encoding::text(unwrapped(field));
    let text = match text.contains(MINUS) {
        true => Cow::Owned(text.replace(MINUS, "-")),
        false => text,
    };
    let text = text.trim();
    let (sign, unsigned) = match text.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", text.strip_prefix('+').unwrap_or(text)),
    };
    if unsigned.starts_with(|c: char| c.is_ascii_alphabetic()) {
        // inf and nan, which no notation changes.
        return text.parse().ok();
    }
    let (mantissa, exponent) = match unsigned.find(['e', 'E', 'd', 'D']) {
        Some(at) => (&unsigned[..at], Some(&unsigned[at + 1..])),
        None => match exponent_of_three_digits(unsigned, notation.decimal) {
            Some(at) => (&unsigned[..at], Some(&unsigned[at..])),
            None => (unsigned, None),
        },
    };
    let (whole, fraction) = mantissa.split_once(notation.decimal).unwrap_or((mantissa, ""));
    let mut plain = String::with_capacity(text.len() + 2);
    plain.push_str(sign);
    push_whole(whole, notation.thousands, &mut plain)?;
    if !is_digits(fraction) || whole.is_empty() && fraction.is_empty() {
        return None;
    }
    plain.push('.');
    plain.push_str(fraction);
    if let Some(exponent) = exponent {
        let digits = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
        if digits.is_empty() || !is_digits(digits) {
            return None;
        }
        plain.push('e');
        plain.push_str(exponent);
    }
    plain.parse().ok()
}

/// Returns where the exponent of a number such as `1.5-101` starts: Fortran leaves out the letter
/// where an exponent has three digits.
fn exponent_of_three_digits(unsigned: &str, decimal: char) -> Option<usize> {
    let at = unsigned.len().checked_sub(4)?;
    let (mantissa, exponent) = unsigned.split_at_checked(at)?;
    let digits = exponent.strip_prefix(['+', '-'])?;
    (is_digits(digits) && mantissa.contains(decimal)).then_some(at)
}

/// Appends the digits before the decimal separator; groups after the first have three digits.
fn push_whole(whole: &str, thousands: Option<char>, plain: &mut String) -> Option<()> {
    let separates = |c: char| match thousands {
        // The blanks that do not break or are thin, and the apostrophe of typesetters.
        Some(' ') => matches!(c, ' ' | '\u{a0}' | '\u{2007}' | '\u{2009}' | '\u{202f}'),
        Some('\'') => matches!(c, '\'' | '\u{2019}'),
        thousands => thousands == Some(c),
    };
    let mut groups = whole.split(separates);
    let first = groups.next().unwrap_or_default();
    if !is_digits(first) {
        return None;
    }
    plain.push_str(first);
    for group in groups {
        let leads = !first.is_empty() && first.len() <= 3 && !first.starts_with('0');
        if !leads || group.len() != 3 || !is_digits(group) {
            return None;
        }
        plain.push_str(group);
    }
    Some(())
}

fn is_digits(text: &str) -> bool {
    text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Digits of the shortest integers that f64 may round: 2^53 has so many.
const LONG: usize = 16;

/// Returns whether a text may have an integer that [`is_rounded`], and so whether its fields are
/// worth a look.
pub(super) fn may_be_rounded(text: &[u8], notation: Notation) -> bool {
    // Thousands may be apart.
    if notation.thousands.is_some() {
        return true;
    }
    let mut at = LONG - 1;
    // Each run of so many digits has one of these places.
    while let Some(byte) = text.get(at) {
        if byte.is_ascii_digit() {
            let before = text[..at].iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
            let after = text[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
            let is_fraction = text[..at - before].last() == Some(&(notation.decimal as u8));
            if before + after >= LONG && !is_fraction {
                return true;
            }
            at += (after / LONG) * LONG;
        }
        at += LONG;
    }
    false
}

/// Returns whether a field is an integer in decimal digits that is not the f64 it is read as.
pub(super) fn is_rounded(field: &[u8], notation: Notation) -> bool {
    let text = encoding::text(unwrapped(field));
    let unsigned = text.trim().trim_start_matches(['-', '+', MINUS]);
    let mut digits = String::new();
    if push_whole(unsigned, notation.thousands, &mut digits).is_none() {
        return false;
    }
    let digits = digits.trim_start_matches('0');
    // An f64 is printed with all of its digits.
    let is_other = |value: f64| format!("{value:.0}") != digits;
    digits.len() >= LONG && digits.parse().is_ok_and(is_other)
}

/// Returns how many words of a line of numbers, without the first `before`, are integers of which
/// [`is_rounded`] is true.
pub(in crate::io) fn rounded_words(line: &str, before: usize) -> usize {
    if !may_be_rounded(line.as_bytes(), PLAIN) {
        return 0;
    }
    let words = line.split_ascii_whitespace().skip(before);
    words.filter(|word| is_rounded(word.as_bytes(), PLAIN)).count()
}

/// Returns what is in `"..."` or `="..."`, by which spreadsheets keep numbers from being changed,
/// or in `'...'`, which databases write.
fn unwrapped(field: &[u8]) -> &[u8] {
    let quoted = field.strip_prefix(b"=").unwrap_or(field);
    match quoted {
        [b'"', inner @ .., b'"'] => inner.trim_ascii(),
        _ => match field {
            [b'\'', inner @ .., b'\''] => inner.trim_ascii(),
            _ => field,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_their_notation_only() {
        let number = |text: &str, i: usize| parse(text.as_bytes(), NOTATIONS[i]);
        for (text, i, value) in [
            ("1.5", 0, Some(1.5)),
            ("+.5", 0, Some(0.5)),
            ("1.0D+01", 0, Some(10.0)),
            ("-2.5d-1", 0, Some(-0.25)),
            ("=\"123\"", 0, Some(123.0)),
            ("1,5", 0, None),
            ("1,5", 1, Some(1.5)),
            ("1.5", 1, None),
            ("-1,5e3", 1, Some(-1500.0)),
            ("10,000", 2, Some(10_000.0)),
            ("10,000.25", 2, Some(10_000.25)),
            ("1,0000", 2, None),
            ("0,500", 2, None),
            ("1000,000", 2, None),
            ("1.299,99", 3, Some(1299.99)),
            ("1.299", 3, Some(1299.0)),
            ("1\u{a0}299,5", 5, Some(1299.5)),
            ("1\u{2009}299,5", 5, Some(1299.5)),
            ("1\u{2007}299,5", 5, Some(1299.5)),
            ("\u{2212}1.5", 0, Some(-1.5)),
            ("\u{2212}1,5e\u{2212}3", 1, Some(-0.0015)),
            ("1.5-101", 0, Some(1.5e-101)),
            ("-1,5+101", 1, Some(-1.5e101)),
            ("1.5-10", 0, None),
            ("15-101", 0, None),
            ("'1.5'", 0, Some(1.5)),
            ("'", 0, None),
            ("1'299.5", 6, Some(1299.5)),
            (".", 0, None),
            (",", 1, None),
            ("1e", 0, None),
            ("e5", 0, None),
            ("", 0, None),
            ("12-5", 0, None),
        ] {
            assert_eq!(number(text, i), value, "{text} in {:?}", NOTATIONS[i]);
        }
        assert_eq!(number("-inf", 1), Some(f64::NEG_INFINITY));
        assert_eq!(parse(b"1\xa0299,5", NOTATIONS[5]), Some(1299.5), "Latin-1");
    }

    #[test]
    fn integers_that_f64_rounds_are_known() {
        for (text, i, rounded) in [
            ("9007199254740992", 0, false),
            ("9007199254740993", 0, true),
            ("-9007199254740993", 0, true),
            ("9007199254740994", 0, false),
            ("0009007199254740993", 0, true),
            ("\"9007199254740993\"", 0, true),
            ("\u{2212}9007199254740993", 0, true),
            ("18446744073709551615", 0, true),
            ("18446744073709551616", 0, false),
            // 2^130, and one more.
            ("1361129467683753853853498429727072845824", 0, false),
            ("1361129467683753853853498429727072845825", 0, true),
            ("9,007,199,254,740,993", 2, true),
            ("9.007.199.254.740.993", 3, true),
            ("9007199254740993.5", 0, false),
            ("0.9007199254740993", 0, false),
            ("9007199254740993,5", 1, false),
            ("nine", 0, false),
            ("", 0, false),
        ] {
            let (field, notation) = (text.as_bytes(), NOTATIONS[i]);
            assert_eq!(is_rounded(field, notation), rounded, "{text} in {notation:?}");
            for blanks in 0..20 {
                let line = [&b" 1 23456 7.123456789012345678 "[..], &vec![b' '; blanks], field];
                let line = [&line.concat()[..], b" 5\n"].concat();
                assert!(!rounded || may_be_rounded(&line, notation), "{text} behind {blanks}");
            }
        }
        for usual in ["0.1234567890123456789,1.0e+100", "123456789012345,1", "", "1,2\n3,4\n"] {
            assert!(!may_be_rounded(usual.as_bytes(), PLAIN), "{usual}");
        }
        let fractions = "0.12345678901234567890123456789012345678,9007199254740993";
        assert!(may_be_rounded(fractions.as_bytes(), PLAIN));
    }

    #[test]
    fn the_notations_that_read_a_field_are_known() {
        for (text, expected) in [
            ("12", 0b1111_1111),
            ("0,5", 0b1010_1010),
            ("10,000", 0b1010_1110),
            ("1.299,99", 0b0000_1000),
            ("1,299.99", 0b0000_0100),
            ("inf", 0),
            ("nan", 0),
            ("four", 0),
            ("2020-01-01", 0),
        ] {
            assert_eq!(readings(text.as_bytes()), expected, "{text}");
        }
    }
}
