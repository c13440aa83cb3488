//! The text form of rates: a line that names the CPU and the isa, then lines `key = value`.

use super::{Rates, cpu};
use crate::kernel::packed::isa::FloatIsa;

/// A fault of a text: its line (from 1), if any, and the reason.
pub(super) type Fault = (Option<usize>, String);

/// The keys, in the order of the fields.
const KEYS: [&str; 4] = ["flops", "read_bytes", "pack_bytes", "update_bytes"];

impl Rates {
    /// Returns the rates as text, for [`Rates::parse`] on the same kind of CPU: a line with the
    /// isa, the CPU and the kind of build (debug or not), then a line `key = value` for each field,
    /// in units per second.
    pub fn to_text(&self, isa: FloatIsa) -> String {
        self.to_text_of(isa, &cpu::name())
    }

    fn to_text_of(self, isa: FloatIsa, cpu: &str) -> String {
        let values = [self.flops, self.read_bytes, self.pack_bytes, self.update_bytes];
        let lines = KEYS.iter().zip(values).map(|(key, value)| format!("{key} = {value}\n"));
        header(isa, cpu) + "\n" + &lines.collect::<String>()
    }

    /// Parses text that [`Rates::to_text`] wrote on this kind of CPU for the same isa.
    ///
    /// ```
    /// use catamaran::kernel::packed::{FloatIsa, Rates};
    ///
    /// let rates = Rates { flops: 6e10, ..Rates::of(FloatIsa::Avx2) };
    /// assert_eq!(Rates::parse(&rates.to_text(FloatIsa::Avx2), FloatIsa::Avx2), Ok(rates));
    /// assert!(Rates::parse(&rates.to_text(FloatIsa::Avx2), FloatIsa::Portable).is_err());
    /// ```
    ///
    /// # Errors
    /// The line at fault (from 1; `None` for a missing key) and the reason: another CPU, isa or
    /// kind of build, a line of another form, an unknown, missing or repeated key, or a value that
    /// is not a finite number above 0.
    pub fn parse(text: &str, isa: FloatIsa) -> Result<Self, (Option<usize>, String)> {
        Self::parse_of(text, isa, &cpu::name())
    }

    fn parse_of(text: &str, isa: FloatIsa, cpu: &str) -> Result<Self, Fault> {
        let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        let (first, expected) = (lines.next().map_or("", |(_, line)| line), header(isa, cpu));
        if first != expected {
            return Err((Some(1), format!("{first:?} where this machine needs {expected:?}")));
        }
        let mut values = [None; KEYS.len()];
        for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
            let fault = |what| Err((Some(number), what));
            let Some((key, value)) = line.split_once('=') else {
                return fault(format!("{line:?} is not of the form key = value"));
            };
            let (key, value) = (key.trim(), value.trim());
            let Some(i) = KEYS.iter().position(|known| *known == key) else {
                return fault(format!("{key}: unknown key; known are {}", KEYS.join(", ")));
            };
            match value.parse::<f64>() {
                _ if values[i].is_some() => return fault(format!("{key}: there twice")),
                Ok(rate) if rate > 0.0 && rate.is_finite() => values[i] = Some(rate),
                _ => return fault(format!("{key}: {value:?} is not a finite number above 0")),
            }
        }
        let get = |i: usize| values[i].ok_or_else(|| (None, format!("{}: missing", KEYS[i])));
        Ok(Self { flops: get(0)?, read_bytes: get(1)?, pack_bytes: get(2)?, update_bytes: get(3)? })
    }
}

/// Returns the first line of the text.
fn header(isa: FloatIsa, cpu: &str) -> String {
    // Rates of a debug build must not be used by a release build.
    let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
    format!("catamaran rates of {} on {cpu}{build}", isa.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CPU: &str = "Some(R) CPU @ 3 = GHz";
    const RATES: Rates =
        Rates { flops: 1.5e10, read_bytes: 1.0 / 3.0, pack_bytes: 7.0, update_bytes: 1e300 };

    #[test]
    fn text_gives_the_same_rates_back() {
        for isa in FloatIsa::ALL {
            let text = RATES.to_text(isa);
            assert_eq!(Rates::parse(&text, isa), Ok(RATES));
            assert_eq!(Rates::parse(&text.replace('\n', "\r\n\r\n"), isa), Ok(RATES));
        }
    }

    #[test]
    fn text_of_another_cpu_or_instance_is_refused() {
        let text = RATES.to_text_of(FloatIsa::Avx2, CPU);
        assert_eq!(Rates::parse_of(&text, FloatIsa::Avx2, CPU), Ok(RATES));
        for (isa, cpu) in [(FloatIsa::Avx2, "Another"), (FloatIsa::Portable, CPU)] {
            let (line, what) = Rates::parse_of(&text, isa, cpu).unwrap_err();
            assert_eq!(line, Some(1));
            assert!(what.contains(CPU) && what.contains("avx2"), "{what}");
            assert!(what.contains(cpu) && what.contains(isa.name()), "{what}");
        }
    }

    #[test]
    fn a_broken_text_is_refused_by_line_and_key() {
        let whole = RATES.to_text_of(FloatIsa::Avx2, CPU);
        let changed = |from: &str, to: &str| {
            assert!(whole.contains(from));
            whole.replace(from, to)
        };
        for (text, line, part) in [
            (String::new(), Some(1), "catamaran rates of avx2"),
            (changed("pack_bytes = 7\n", ""), None, "pack_bytes: missing"),
            (
                changed("pack_bytes", "page_bytes"),
                Some(4),
                "page_bytes: unknown key; known are flops",
            ),
            (changed("= 7", "= -7"), Some(4), "pack_bytes: \"-7\" is not"),
            (changed("= 7", "= 0"), Some(4), "pack_bytes: \"0\" is not"),
            (changed("= 7", "= inf"), Some(4), "pack_bytes: \"inf\" is not"),
            (changed("= 7", "= NaN"), Some(4), "pack_bytes: \"NaN\" is not"),
            (changed("= 7", "="), Some(4), "pack_bytes: \"\" is not"),
            (changed("= 7", "7"), Some(4), "\"pack_bytes 7\" is not of the form"),
            (whole.clone() + "flops = 1\n", Some(6), "flops: there twice"),
        ] {
            let (found, what) = Rates::parse_of(&text, FloatIsa::Avx2, CPU).unwrap_err();
            assert_eq!(found, line, "{what}");
            assert!(what.contains(part), "{part:?} in {what}");
        }
    }
}
