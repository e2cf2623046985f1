//! How cases and numbers are called in tables and charts.

use raxel_measure::bench::{Case, Row};

/// A file's name without folders and ending.
pub(super) fn stem(path: &str) -> &str {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.split('.').next().unwrap_or(name)
}

/// World, camera and size.
pub(super) fn view(case: &Case) -> String {
    let [width, height] = case.size;
    format!("{}, {}, {width} × {height}", stem(&case.world), case.camera)
}

/// Graph and layout.
pub(super) fn tracer(case: &Case) -> String {
    match case.layout {
        Some(layout) => format!("{} · {layout}", stem(&case.graph)),
        None => stem(&case.graph).to_owned(),
    }
}

/// Wrong hits of a million; `None` if it is unknown.
pub(super) fn wrong_ppm(row: &Row) -> Option<f64> {
    Some(row.outcome.as_ref().ok()?.judgement.as_ref().ok()?.ppm())
}

/// Three significant digits, at any size.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "powers of ten of floats are within ±324")]
pub(super) fn three(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    format!("{value:.*}", digits.max(0) as usize)
}

/// A number with its digits in groups of three.
pub(super) fn grouped(number: u64) -> String {
    raxel_diagnostics::names::grouped(number).replace(',', "\u{202f}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [(0.0, "0"), (0.012_345, "0.0123"), (1.0, "1.00"), (99.96, "100.0"), (15_234.6, "15235")] {
            assert_eq!(three(value), text);
        }
        assert_eq!([1, 999, 1000, 8_294_400].map(grouped), ["1", "999", "1\u{202f}000", "8\u{202f}294\u{202f}400"]);
        assert_eq!((stem("worlds/valley.toml"), stem("a")), ("valley", "a"));
    }
}
