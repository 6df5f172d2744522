//! YAML scalars that every reader takes for what they are.

/// Numbers as a flow sequence, each the shortest text that reads back as the same f64.
pub(super) fn flow_sequence(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(|value| number(*value)).collect();
    format!("[{}]", words.join(", "))
}

/// The shortest text that reads back as the same f64. YAML 1.1 (PyYAML, and so ROS's Python tools) takes a number for a string unless it has a point, and a sign before its
/// exponent.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:?}");
    let Some((mantissa, exponent)) = text.split_once('e') else {
        return text;
    };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}

/// A string, quoted unless it is a plain word that means nothing else in YAML.
pub(super) fn scalar(text: &str) -> String {
    const RESERVED: [&str; 10] = [
        "y", "n", "yes", "no", "on", "off", "true", "false", "null", "nan",
    ];
    let word = text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "_-/.".contains(c))
        && !RESERVED.contains(&text.to_ascii_lowercase().as_str());
    if word { text.to_owned() } else { quoted(text) }
}

/// A double-quoted scalar; what is not printable ASCII becomes an escape.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            ' '..='~' => out.push(c),
            _ => out += &format!("\\U{:08x}", u32::from(c)),
        }
    }
    out + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_and_a_signed_exponent() {
        let text = flow_sequence(&[1.0, -0.1, 1e-7, 1.5e-300, 1e22, 0.0, 20830.123456789013]);
        assert_eq!(
            text,
            "[1.0, -0.1, 1.0e-7, 1.5e-300, 1.0e+22, 0.0, 20830.123456789013]"
        );
    }

    #[test]
    fn plain_words_stay_plain_and_nothing_else_does() {
        assert_eq!(scalar("narrow_stereo/left"), "narrow_stereo/left");
        assert_eq!(scalar("Yes"), "\"Yes\"");
        assert_eq!(scalar("a\"b\nc"), "\"a\\\"b\\U0000000ac\"");
    }
}
