//! Parses polynomials as people write them: `z^3 - 2z + (1 + 2i)`, `(z - 1)(z + i)^2`.

use catamaran::faer::c64;

/// Returns the coefficients of the polynomial that `text` describes, that of the highest power
/// first.
///
/// The syntax has sums, differences and products (with `*` or without) of numbers (also as `1e6`),
/// `i`, `z` and expressions in parentheses, each with an optional `^` and a whole power.
pub fn polynomial(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let mut parser = Parser { text, at: 0 };
    let found = parser.sum()?;
    match parser.next() {
        None => Ok(found.0.iter().rev().map(|c| [c.re, c.im]).collect()),
        Some(c) => Err(parser.error(&format!("`{c}` is not expected"))),
    }
}

/// The largest degree; polynomials of a larger degree are not computed.
const MOST: usize = 64;

/// Coefficients, that of the constant first; at least one.
struct Polynomial(Vec<c64>);

impl Polynomial {
    fn number(value: c64) -> Self {
        Self(vec![value])
    }

    fn plus(self, other: &Self, sign: f64) -> Self {
        let entry = |list: &[c64], i: usize| list.get(i).copied().unwrap_or(c64::new(0.0, 0.0));
        let len = self.0.len().max(other.0.len());
        Self((0..len).map(|i| entry(&self.0, i) + entry(&other.0, i) * sign).collect())
    }

    fn times(&self, other: &Self) -> Result<Self, String> {
        let degree = self.0.len() + other.0.len() - 2;
        if degree > MOST {
            return Err(format!("the degree is above {MOST}"));
        }
        let mut product = vec![c64::new(0.0, 0.0); degree + 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Ok(Self(product))
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl Parser<'_> {
    fn sum(&mut self) -> Result<Polynomial, String> {
        let mut sum = Polynomial::number(c64::new(0.0, 0.0));
        let mut sign = match self.next() {
            Some(c @ ('+' | '-')) => self.take(c),
            _ => 1.0,
        };
        loop {
            sum = sum.plus(&self.product()?, sign);
            sign = match self.next() {
                Some(c @ ('+' | '-')) => self.take(c),
                _ => return Ok(sum),
            };
        }
    }

    /// Takes a sign.
    fn take(&mut self, sign: char) -> f64 {
        self.at += 1;
        if sign == '-' { -1.0 } else { 1.0 }
    }

    fn product(&mut self) -> Result<Polynomial, String> {
        let mut product = self.power()?;
        loop {
            match self.next() {
                Some('*') => self.at += 1,
                Some('(' | 'z' | 'i') => {}
                _ => return Ok(product),
            }
            let factor = self.power()?;
            product = product.times(&factor).map_err(|why| self.error(&why))?;
        }
    }

    fn power(&mut self) -> Result<Polynomial, String> {
        let base = self.atom()?;
        if self.next() != Some('^') {
            return Ok(base);
        }
        self.at += 1;
        self.next();
        let digits = self.digits(|c| c.is_ascii_digit());
        let power: usize = digits.parse().map_err(|_| self.error("a whole power is needed"))?;
        if power > MOST {
            return Err(self.error(&format!("the power is above {MOST}")));
        }
        let mut result = Polynomial::number(c64::new(1.0, 0.0));
        for _ in 0..power {
            result = result.times(&base).map_err(|why| self.error(&why))?;
        }
        Ok(result)
    }

    fn atom(&mut self) -> Result<Polynomial, String> {
        match self.next() {
            Some('z') => {
                self.at += 1;
                Ok(Polynomial(vec![c64::new(0.0, 0.0), c64::new(1.0, 0.0)]))
            }
            Some('i') => {
                self.at += 1;
                Ok(Polynomial::number(c64::new(0.0, 1.0)))
            }
            Some('(') => {
                self.at += 1;
                let inside = self.sum()?;
                match self.next() {
                    Some(')') => self.at += 1,
                    _ => return Err(self.error("`)` is missing")),
                }
                Ok(inside)
            }
            Some(c) if c == '.' || c.is_ascii_digit() => {
                let digits = self.digits(|c| c == '.' || c.is_ascii_digit());
                let digits = digits + &self.exponent();
                let value: f64 =
                    digits.parse().map_err(|_| self.error(&format!("{digits} is not a number")))?;
                if value.is_infinite() {
                    return Err(self.error(&format!("{digits} is too large")));
                }
                Ok(Polynomial::number(c64::new(value, 0.0)))
            }
            Some(c) => Err(self.error(&format!("`{c}` where a number, i, z or `(` is needed"))),
            None => Err(self.error("the text ends where a number, i, z or `(` is needed")),
        }
    }

    /// Takes the exponent of a number, such as the `e-3` of `2e-3`; empty if there is none.
    fn exponent(&mut self) -> String {
        let rest = &self.text[self.at..];
        let Some(power) = rest.strip_prefix(['e', 'E']) else { return String::new() };
        let digits = power.strip_prefix(['+', '-']).unwrap_or(power);
        let count = digits.chars().take_while(char::is_ascii_digit).count();
        if count == 0 {
            return String::new();
        }
        let len = rest.len() - digits.len() + count;
        self.at += len;
        rest[..len].to_owned()
    }

    /// Returns the next character that is no space, without taking it.
    fn next(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        let trimmed = rest.trim_start();
        self.at += rest.len() - trimmed.len();
        trimmed.chars().next()
    }

    /// Takes ASCII characters of this kind.
    fn digits(&mut self, kind: impl Fn(char) -> bool) -> String {
        let digits: String = self.text[self.at..].chars().take_while(|&c| kind(c)).collect();
        self.at += digits.len();
        digits
    }

    fn error(&self, why: &str) -> String {
        format!(
            "{why}, at character {} of `{}`",
            self.text[..self.at].chars().count() + 1,
            self.text
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_products_and_powers_are_polynomials() {
        let one = [1.0, 0.0];
        for (text, wanted) in [
            ("7", vec![[7.0, 0.0]]),
            ("z", vec![one, [0.0; 2]]),
            ("z^3 - 2z + 2", vec![one, [0.0; 2], [-2.0, 0.0], [2.0, 0.0]]),
            ("-z+1", vec![[-1.0, 0.0], one]),
            ("(1+2i) z^2 + .5i", vec![[1.0, 2.0], [0.0; 2], [0.0, 0.5]]),
            ("(z - 1)(z + 1)", vec![one, [0.0; 2], [-1.0, 0.0]]),
            ("2*(z+i)^2", vec![[2.0, 0.0], [0.0, 4.0], [-2.0, 0.0]]),
            ("z^0", vec![one]),
            ("i^2 z", vec![[-1.0, 0.0], [0.0; 2]]),
            ("z - 1e6", vec![one, [-1e6, 0.0]]),
            ("2.5E+1z-1e-3i", vec![[25.0, 0.0], [0.0, -1e-3]]),
        ] {
            let found = polynomial(text).unwrap();
            // Leading zeros stay: the search for roots removes them.
            let first = found.iter().position(|c| *c != [0.0; 2]).unwrap_or(0);
            assert_eq!(found[first..], wanted, "{text}");
        }
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        for (text, why) in [
            ("", "the text ends where a number, i, z or `(` is needed, at character 1"),
            ("z^", "a whole power is needed"),
            ("z^-1", "a whole power is needed"),
            ("z^65", "the power is above 64"),
            ("z^40 z^40", "the degree is above 64"),
            ("(z + 1", "`)` is missing, at character 7"),
            ("z)", "`)` is not expected, at character 2"),
            ("3z2", "`2` is not expected, at character 3"),
            ("x + 1", "`x` where a number, i, z or `(` is needed, at character 1"),
            ("1.2.3", "1.2.3 is not a number"),
            ("2 ** z", "`*` where a number"),
            ("π z", "`π` where a number"),
            ("z + 2x", "`x` is not expected, at character 6"),
            ("z + 2e", "`e` is not expected, at character 6"),
            ("z + 2e-z", "`e` is not expected, at character 6"),
            ("z + 1e999", "1e999 is too large"),
        ] {
            let refused = polynomial(text).unwrap_err();
            assert!(refused.contains(why), "{text}: {refused}");
        }
    }
}
