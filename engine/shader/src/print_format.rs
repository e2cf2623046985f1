//! The text of `debugPrintfEXT`: its conversions, and their results. The conversions are those of C, with `v2` to `v4` for vectors. The
//! shader's type of a value counts: a conversion chooses how a value looks and never its type.

use raxel_spirv::{PrintedScalar, PrintedType};

/// Most characters that a number is padded to, and most digits behind its point.
const MAX_WIDTH: usize = 64;

/// A part of a text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Piece {
    Text(String),
    /// The next value.
    Value(Conversion),
}

/// How a component looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[allow(clippy::struct_excessive_bools, reason = "each is a flag of its own, as C has them")]
pub(crate) struct Conversion {
    left: bool,
    zeros: bool,
    plus: bool,
    prefix: bool,
    width: usize,
    precision: Option<usize>,
    kind: char,
}

/// The parts of a text.
///
/// # Errors
/// The mistake, in words.
pub(crate) fn pieces(format: &str) -> Result<Vec<Piece>, String> {
    let mut pieces = Vec::new();
    let mut text = String::new();
    let mut rest = format;
    while let Some(c) = rest.chars().next() {
        rest = &rest[c.len_utf8()..];
        if c != '%' {
            text.push(c);
        } else if let Some(behind) = rest.strip_prefix('%') {
            text.push('%');
            rest = behind;
        } else {
            let (conversion, behind) = conversion(rest)?;
            if !text.is_empty() {
                pieces.push(Piece::Text(std::mem::take(&mut text)));
            }
            pieces.push(Piece::Value(conversion));
            rest = behind;
        }
    }
    if !text.is_empty() {
        pieces.push(Piece::Text(text));
    }
    Ok(pieces)
}

/// The conversion that a text begins with, and the rest.
fn conversion(text: &str) -> Result<(Conversion, &str), String> {
    let mut found = Conversion::default();
    let mut rest = text.trim_start_matches(['-', '0', '+', '#', ' ']);
    for flag in text[..text.len() - rest.len()].chars() {
        match flag {
            '-' => found.left = true,
            '0' => found.zeros = true,
            '+' => found.plus = true,
            '#' => found.prefix = true,
            _ => {}
        }
    }
    let number = |rest: &mut &str| {
        let digits = &rest[..rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len()];
        *rest = &rest[digits.len()..];
        digits.parse::<usize>().unwrap_or(if digits.is_empty() { 0 } else { MAX_WIDTH }).min(MAX_WIDTH)
    };
    found.width = number(&mut rest);
    if let Some(behind) = rest.strip_prefix('.') {
        rest = behind;
        found.precision = Some(number(&mut rest));
    }
    if let Some(behind) = rest.strip_prefix('v') {
        rest = behind.strip_prefix(['2', '3', '4']).ok_or("`%v` needs `2`, `3` or `4` behind it")?;
    }
    let kind = rest.chars().next().ok_or("it ends within a conversion; a percent sign is `%%`")?;
    if !"diuxXoeEfFgG".contains(kind) {
        return Err(format!(
            "`%{kind}` is no conversion; there are d i u x X o e E f F g G, and a percent sign is `%%`"
        ));
    }
    found.kind = kind;
    rest = &rest[kind.len_utf8()..];
    // `%ul` and its kin are of 64 bits elsewhere.
    Ok((found, rest))
}

impl Conversion {
    /// A value as text: the components of a vector with commas between them.
    pub(crate) fn value(self, ty: PrintedType, words: &[u32]) -> String {
        let components: Vec<String> = words.iter().map(|word| self.component(ty.scalar, *word)).collect();
        components.join(", ")
    }

    #[expect(clippy::cast_possible_wrap, reason = "the word holds a signed number")]
    fn component(self, scalar: PrintedScalar, word: u32) -> String {
        let hex = |prefix: &str, digits: String| if self.prefix { format!("{prefix}{digits}") } else { digits };
        let text = match (scalar, self.kind) {
            (PrintedScalar::Bool, _) => return self.padded((word != 0).to_string(), false),
            (_, 'x') => hex("0x", format!("{word:x}")),
            (_, 'X') => hex("0X", format!("{word:X}")),
            (_, 'o') => hex("0", format!("{word:o}")),
            (PrintedScalar::Float, _) => self.float(f64::from(f32::from_bits(word)), f32::from_bits(word).to_string()),
            (PrintedScalar::Int, 'e' | 'E' | 'f' | 'F') => self.float(f64::from(word as i32), String::new()),
            (PrintedScalar::Uint, 'e' | 'E' | 'f' | 'F') => self.float(f64::from(word), String::new()),
            (PrintedScalar::Int, _) => (word as i32).to_string(),
            (PrintedScalar::Uint, _) => word.to_string(),
        };
        let signed = if self.plus && !text.starts_with('-') { format!("+{text}") } else { text };
        self.padded(signed, true)
    }

    /// `shortest` is the shortest text that gives the same `f32` again.
    fn float(self, value: f64, shortest: String) -> String {
        if value.is_nan() {
            return "nan".to_owned();
        }
        if value.is_infinite() {
            return if value > 0.0 { "inf" } else { "-inf" }.to_owned();
        }
        let digits = self.precision.unwrap_or(6);
        match self.kind {
            'f' | 'F' => format!("{value:.digits$}"),
            'e' | 'E' => exponent(&format!("{value:.digits$e}"), self.kind),
            'g' | 'G' => self.precision.map_or(shortest, |digits| general(value, digits.max(1), self.kind)),
            _ => shortest,
        }
    }

    fn padded(self, text: String, number: bool) -> String {
        let missing = self.width.saturating_sub(text.chars().count());
        let digits = text.trim_start_matches(['-', '+']);
        if self.left {
            text + &" ".repeat(missing)
        } else if self.zeros && number && digits.starts_with(|c: char| c.is_ascii_hexdigit()) && digits != "inf" {
            let sign = &text[..text.len() - digits.len()];
            format!("{sign}{}{digits}", "0".repeat(missing))
        } else {
            " ".repeat(missing) + &text
        }
    }
}

/// `1.5e-7` as C writes it: `1.5e-07`.
fn exponent(text: &str, kind: char) -> String {
    let e = if kind.is_ascii_uppercase() { 'E' } else { 'e' };
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (sign, digits) = exponent.strip_prefix('-').map_or(('+', exponent), |digits| ('-', digits));
    format!("{mantissa}{e}{sign}{digits:0>2}")
}

/// So many significant digits, with an exponent where the number is very large or small.
fn general(value: f64, digits: usize, kind: char) -> String {
    let scientific = format!("{value:.*e}", digits - 1);
    let power: i32 = scientific.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0);
    let most = i32::try_from(digits).unwrap_or(i32::MAX);
    let trimmed = |text: &str| {
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text.to_owned() }
    };
    if power < -4 || power >= most {
        let (mantissa, power) = scientific.split_once('e').unwrap_or((&scientific, "0"));
        return exponent(&format!("{}e{power}", trimmed(mantissa)), kind);
    }
    trimmed(&format!("{value:.*}", usize::try_from(most - 1 - power).unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(format: &str, scalar: PrintedScalar, words: &[u32]) -> String {
        let ty = PrintedType { scalar, components: u32::try_from(words.len()).unwrap() };
        let piece = |piece| match piece {
            Piece::Text(text) => text,
            Piece::Value(conversion) => conversion.value(ty, words),
        };
        pieces(format).unwrap().into_iter().map(piece).collect()
    }

    #[test]
    fn numbers_look_as_in_c() {
        use PrintedScalar::{Bool, Float, Int, Uint};
        let float = |format, value: f32| shown(format, Float, &[value.to_bits()]);
        assert_eq!(float("%f", 0.5), "0.500000");
        assert_eq!(float("%.2f|%8.3f|%-8.1f|%08.2f", -1.25), "-1.25|  -1.250|-1.2    |-0001.25");
        assert_eq!(float("%e %.1E", 12345.0), "1.234500e+04 1.2E+04");
        assert_eq!(float("%g %.3g %.3G", 0.1), "0.1 0.1 0.1");
        assert_eq!(float("%.3g", 123_456.0), "1.23e+05");
        assert_eq!(float("%.3g", 0.000_012_3), "1.23e-05");
        assert_eq!(float("%f %d", f32::NAN), "nan nan");
        assert_eq!(float("%05f", f32::NEG_INFINITY), " -inf");
        assert_eq!(float("%x", 1.0), "3f800000");
        assert_eq!(float("%d", 1.5), "1.5");
        assert_eq!(shown("%d|%5d|%-5d|%05d|%+d", Int, &[7]), "7|    7|7    |00007|+7");
        assert_eq!(shown("%i %u %.1f", Int, &[u32::MAX]), "-1 -1 -1.0");
        assert_eq!(shown("%u %d %#x %X %o", Uint, &[255]), "255 255 0xff FF 377");
        assert_eq!(shown("%d %6u|", Bool, &[1]), "true   true|");
        assert_eq!(
            shown("<%v3f> 100%%", Float, &[0, 1f32.to_bits(), 2f32.to_bits()]),
            "<0.000000, 1.000000, 2.000000> 100%"
        );
        assert_eq!(shown("%2.1v2f", Float, &[0, 0]), "0.0, 0.0");
    }

    #[test]
    fn wrong_texts_are_told() {
        for (format, wrong) in [("%", "ends"), ("a %5", "ends"), ("%s", "`%s`"), ("%v5f", "`%v`"), ("%é", "`%é`")] {
            assert!(pieces(format).unwrap_err().contains(wrong), "{format}");
        }
        assert_eq!(pieces("").unwrap(), []);
        assert!(pieces("%99999999999999999999.99999999999f").is_ok());
    }
}
