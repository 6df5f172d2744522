//! Numbers as text, short and the same everywhere.

/// A number with at most so many digits behind the point and no idle zeros.
pub(super) fn decimal(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    match text {
        "-0" => "0".to_owned(),
        text => text.to_owned(),
    }
}

/// Millimetres as they are drawn, to a tenth of a micrometre.
pub(super) fn mm(value: f64) -> String {
    decimal(value, 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn idle_zeros_are_left_out() {
        let texts = [0.0, -0.00001, 38.0, 26.900000000000002, 100.0].map(mm);
        assert_eq!(texts, ["0", "0", "38", "26.9", "100"]);
        assert_eq!(decimal(1200.0, 0), "1200");
    }
}
