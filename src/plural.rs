//! One thing, several things.

use std::fmt::Display;

/// A count and what is counted: "1 ring", "2 rings".
pub(crate) fn counted(count: impl Display, thing: &str) -> String {
    let count = count.to_string();
    let ending = if count == "1" { "" } else { "s" };
    format!("{count} {thing}{ending}")
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_no_plural() {
        let said = [0, 1, 2].map(|count| counted(count, "ring"));
        assert_eq!(said, ["0 rings", "1 ring", "2 rings"]);
    }
}
